#include "host-tools/arms/arm_file.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "board/files/json_document.h"
#include "board/files/rotation.h"
#include "host-tools/arms/arm_keys.h"
#include "host-tools/arms/commissioned.h"

namespace thimble::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

class Part : public FilePart {
 public:
  Part(const Value& value, std::string_view kind) : FilePart(value, kind_of(arm_kinds(), kind)) {}
  [[nodiscard]] Part part(std::string_view key, std::string_view kind) const { return {at(key), kind}; }
  [[nodiscard]] float length_m(std::string_view key) const { return static_cast<float>(quantity(key).value); }
};

Quantity in_rad(Quantity degrees) {
  degrees.value *= kDegree;
  degrees.spread *= kDegree;
  return degrees;
}

Eigen::Matrix3f rotation(const Part& part) {
  return board::rotation_of(part.vector("rotation_deg")).cast<float>();
}

// Words for the links of a five-bar and a delta, beside the names of the joints of a wrist.
constexpr std::array<std::string_view, 6> kPlatformLinks{"inner1", "inner2", "outer1",
                                                         "outer2", "plate",  "thighs"};

// Names stand in messages and tables, and in answers of the device.
std::string read_name(const Part& part) {
  std::string name = part.text("name");
  if (name.front() == ' ' || name.back() == ' ' ||
      std::ranges::any_of(name, [](unsigned char c) { return c < ' ' || c == 0x7F; }))
    part.at("name").wrong("a name without line breaks or tabs, and without spaces at its ends");
  return name;
}

void read_chain(const Part& part, ArmFile& arm) {
  kinematics::ChainGeometry& chain = arm.geometry.chain;
  const Value joints = part.at("joints");
  const std::size_t most = kinematics::kMaxJoints - arm.joints.size();
  chain.count = static_cast<int>(joints.size(1, most));
  const std::size_t before = arm.joints.size();
  for (std::size_t k = 0; k < static_cast<std::size_t>(chain.count); ++k) {
    const Part joint(joints.at(k), "joint");
    const std::string name = read_name(joint);
    if (std::ranges::find(arm.joints, name) != arm.joints.end())
      joint.at("name").fail("repeated-name", "is \"" + name + "\", as a joint before",
                            "give each joint a name of its own");
    if (before > 0 && std::ranges::find(kPlatformLinks, name) != kPlatformLinks.end())
      joint.at("name").fail("repeated-name", "is \"" + name + "\", as a link of the platform",
                            "give the joint another name");
    arm.joints.push_back(name);
    chain.joint.at(k) = {
        joint.word("type") == 1 ? kinematics::JointKind::kPrismatic : kinematics::JointKind::kRevolute,
        joint.vector("origin_m").cast<float>(), rotation(joint), joint.direction("axis").cast<float>()};
  }
  chain.tip_m = part.vector("tip_m").cast<float>();
  chain.force_joint = chain.count;
  if (!part.has("force_at")) return;
  const std::vector<std::string_view> names(arm.joints.begin() + static_cast<std::ptrdiff_t>(before),
                                            arm.joints.end());
  chain.force_joint = static_cast<int>(part.at("force_at").word(names));
}

void read_two_link(const Part& part, ArmFile& arm) {
  arm.geometry.platform = kinematics::TwoLinkGeometry{
      part.length_m("base_height_m"), part.length_m("upper_link_m"), part.length_m("forearm_m")};
  arm.joints = {"yaw", "upper", "fore"};
  if (!part.has("inertia")) return;
  const Part inertia = part.part("inertia", "two_link_inertia");
  const auto of = [&](std::string_view key) { return inertia.quantity(key).value; };
  arm.two_link_inertia = {of("m11"), of("m11_cos_2q2"), of("m11_cos_2q3"), of("m22"),
                          of("m33"), of("m23"),         of("g2"),          of("g3")};
}

void read_five_bar(const Part& part, ArmFile& arm) {
  const std::vector<double> inner = part.numbers("inner_m"), outer = part.numbers("outer_m");
  const auto two = [](const std::vector<double>& lengths) {
    return std::array{static_cast<float>(lengths.at(0)), static_cast<float>(lengths.at(1))};
  };
  arm.geometry.platform = kinematics::FiveBarGeometry{part.length_m("base_distance_m"), two(inner),
                                                      two(outer), part.word("assembly") == 0};
  arm.joints = {"first", "second"};
}

void read_delta(const Part& part, ArmFile& arm) {
  kinematics::DeltaGeometry delta{
      .thigh_m = part.length_m("thigh_m"),
      .shin_m = part.length_m("shin_m"),
      .plate_u_m = part.length_m("plate_u_m"),
      .plate_v_m = part.length_m("plate_v_m"),
      .shin_end_m = part.length_m("shin_end_m"),
      .knee_end_m = part.length_m("knee_end_m"),
      .base_u_m = part.length_m("base_u_m"),
      .base_v_m = part.length_m("base_v_m"),
      .leg_angle_rad = {},
      .minus = part.word("branch") == 0,
      .home_axis_m = part.length_m("home_axis_m"),
  };
  const std::vector<double> angles = part.numbers("leg_angles_deg");
  for (std::size_t i = 0; i < 3; ++i) delta.leg_angle_rad.at(i) = static_cast<float>(kDegree * angles.at(i));
  arm.geometry.platform = delta;
  arm.joints = {"first", "second", "third"};
}

void read_kinematics(const Part& root, ArmFile& arm) {
  const Part part = root.part("kinematics", "kinematics");
  arm.family = part.only_key();
  const Part family = part.part(arm.family, arm.family == "serial" ? "chain" : arm.family);
  if (arm.family == "serial") {
    read_chain(family, arm);
  } else if (arm.family == "two_link") {
    read_two_link(family, arm);
  } else if (arm.family == "five_bar") {
    read_five_bar(family, arm);
  } else {
    read_delta(family, arm);
  }
  if (!root.has("wrist")) return;
  if (arm.family != "five_bar" && arm.family != "delta")
    root.at("wrist").fail("senseless-key", "is only for a five_bar or a delta",
                          "write the whole arm as one serial chain");
  read_chain(root.part("wrist", "chain"), arm);
}

double read_sign(const Part& part) {
  const double sign = part.number("sign");
  if (std::abs(sign) != 1.0) part.at("sign").wrong("1 or -1");
  return sign;
}

int read_whole(const Part& part, std::string_view key) {
  const double number = part.number(key);
  if (number != std::trunc(number)) part.at(key).wrong("a whole number");
  return static_cast<int>(number);
}

ArmEncoder read_encoder(const Part& part) {
  constexpr std::array kKinds{"quadrature", "potentiometer", "drive"};
  ArmEncoder encoder{.port = read_whole(part, "port"),
                     .kind = kKinds.at(part.word("kind")),
                     .counts_per_turn = part.quantity("counts_per_turn"),
                     .counter_bits = read_whole(part, "counter_bits"),
                     .sign = read_sign(part),
                     .turns_per_turn = part.quantity("turns_per_turn"),
                     .max_rate_Hz = 0};
  if (part.has("max_rate_Hz")) encoder.max_rate_Hz = part.quantity("max_rate_Hz").value;
  return encoder;
}

ArmDrive read_drive(const Part& part) {
  constexpr std::array kKinds{"analog_current", "moteus", "odrive", "mit", "damiao"};
  return {.port = read_whole(part, "port"),
          .kind = kKinds.at(part.word("kind")),
          .sign = read_sign(part),
          .turns_per_turn = part.quantity("turns_per_turn"),
          .delay_s = part.quantity("delay_s")};
}

ArmMotor read_motor(const Part& part) {
  return {part.quantity("torque_constant_N_m_A"),
          part.quantity("resistance_ohm"),
          part.quantity("inductance_H"),
          part.quantity("rotor_inertia_kg_m2"),
          part.quantity("peak_current_A"),
          part.quantity("continuous_torque_N_m"),
          part.quantity("winding_to_housing_K_W"),
          part.quantity("housing_to_ambient_K_W"),
          part.quantity("winding_time_constant_s"),
          part.quantity("housing_time_constant_s"),
          part.quantity("max_winding_C")};
}

using Motors = std::map<std::string, ArmMotor, std::less<>>;

// All of them, so that one that no axis has is checked, too.
Motors read_motors(const Part& root) {
  Motors motors;
  if (!root.has("motors")) return motors;
  const Value given = root.at("motors");
  if (!given.raw().is_object()) given.wrong("an object of motors by name");
  for (auto motor = given.raw().begin(); motor != given.raw().end(); ++motor)
    motors.emplace(motor.key(), read_motor(Part(given.at(std::string_view(motor.key())), "motor")));
  return motors;
}

ArmMotor motor_of(const Motors& motors, const Part& axis) {
  const Value given = axis.at("motor");
  if (!given.raw().is_string()) return read_motor(Part(given, "motor"));
  if (motors.empty()) given.wrong("a motor, because the file has no \"motors\" with names");
  std::vector<std::string_view> names;
  for (const auto& motor : motors) names.push_back(motor.first);
  return motors.find(names.at(given.word(names)))->second;
}

// Keys with _m for a prismatic joint, with _deg for a revolute one.
void read_range(const Part& part, ArmAxis& axis) {
  const std::string unit = axis.is_prismatic ? "_m" : "_deg", other = axis.is_prismatic ? "_deg" : "_m";
  for (const std::string_view key : {"lower", "upper", "home"}) {
    const std::string wrong = std::string(key).append(other);
    if (part.has(wrong))
      part.at(wrong).fail("senseless-key",
                          axis.is_prismatic ? "is for a revolute joint" : "is for a prismatic joint",
                          std::string("write ").append(key).append(unit));
  }
  const auto read = [&](std::string_view key) {
    const Quantity given = part.quantity(std::string(key).append(unit));
    return axis.is_prismatic ? given : in_rad(given);
  };
  axis.lower = read("lower");
  axis.upper = read("upper");
  axis.home = read("home");
}

ArmAxis read_axis(const Motors& motors, const Part& part, bool is_prismatic) {
  ArmAxis axis;
  axis.name = read_name(part);
  axis.is_prismatic = is_prismatic;
  read_range(part, axis);
  axis.encoder = read_encoder(part.part("encoder", "encoder"));
  if (part.has("drive")) {
    axis.drive = read_drive(part.part("drive", "drive"));
    axis.motor = motor_of(motors, part);
  } else if (part.has("motor")) {
    part.at("motor").fail("senseless-key", "has a meaning with a drive only",
                          "add the drive, or leave it out");
  }
  if (axis.encoder.kind == "drive" && !axis.drive)
    part.at("encoder").at("kind").fail("senseless-key", "is \"drive\", and the axis has none",
                                       "add the drive, or say what the encoder is");
  if (part.has("friction")) {
    const Part friction = part.part("friction", "friction");
    axis.friction = {friction.quantity("coulomb_N_m"), friction.quantity("viscous_N_m_s_rad"),
                     friction.quantity("stiction_ratio")};
  }
  if (part.has("stiffness_N_m_rad")) axis.stiffness_N_m_rad = part.quantity("stiffness_N_m_rad");
  if (part.has("first_resonance_Hz")) axis.first_resonance_Hz = part.quantity("first_resonance_Hz");
  return axis;
}

bool is_prismatic(const ArmFile& arm, std::size_t joint) {
  const auto platform = static_cast<std::size_t>(kinematics::platform_joints(arm.geometry));
  return joint >= platform &&
         arm.geometry.chain.joint.at(joint - platform).kind == kinematics::JointKind::kPrismatic;
}

void read_coupling(const Part& root, ArmFile& arm) {
  if (!root.has("coupling")) return;
  const Part part = root.part("coupling", "coupling");
  const auto n = static_cast<Eigen::Index>(arm.joints.size());
  const Value rows = part.at("joints_per_axis");
  if (rows.size(1, arm.joints.size()) != arm.joints.size()) rows.wrong("a row for each joint");
  const Range& range = part.range("joints_per_axis");
  for (Eigen::Index i = 0; i < n; ++i) {
    const Value row = rows.at(static_cast<std::size_t>(i));
    const std::vector<double> values = row.numbers(range, arm.joints.size());
    if (values.size() != arm.joints.size()) row.wrong("a number for each axis");
    for (std::size_t j = 0; j < values.size(); ++j) {
      if (values[j] != 0 && is_prismatic(arm, static_cast<std::size_t>(i)) != is_prismatic(arm, j))
        row.at(j).fail("mixed-units",
                       "couples a revolute joint with the axis of a prismatic one, or the reverse",
                       "give the axes in the order of the joints that they move");
      arm.geometry.joints_per_axis(i, static_cast<Eigen::Index>(j)) = static_cast<float>(values[j]);
    }
  }
  const Eigen::MatrixXd matrix = arm.geometry.joints_per_axis.topLeftCorner(n, n).cast<double>();
  if (std::abs(matrix.determinant()) < 1e-6)
    rows.fail("singular-coupling", "has no inverse", "each axis must move a joint that the others do not");
  if (!part.has("offset_deg")) return;
  const std::vector<double> offset = part.numbers("offset_deg");
  if (offset.size() != arm.joints.size()) part.at("offset_deg").wrong("a number for each joint");
  for (std::size_t i = 0; i < offset.size(); ++i) {
    arm.geometry.joint_offset[static_cast<Eigen::Index>(i)] =
        static_cast<float>(is_prismatic(arm, i) ? offset[i] : kDegree * offset[i]);
  }
}

void read_axes(const Part& root, ArmFile& arm) {
  const Value axes = root.at("axes");
  if (axes.size(1, kinematics::kMaxJoints) != arm.joints.size())
    axes.fail("wrong-axes",
              "has " + std::to_string(axes.raw().size()) + " axes, and the kinematics has " +
                  std::to_string(arm.joints.size()) + " joints",
              "give one axis for each joint, those that are only sensed too");
  const Motors motors = read_motors(root);
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const Part part(axes.at(i), "axis");
    ArmAxis axis = read_axis(motors, part, is_prismatic(arm, i));
    if (std::ranges::find(arm.axes, axis.name, &ArmAxis::name) != arm.axes.end())
      part.at("name").fail("repeated-name", "is \"" + axis.name + "\", as an axis before",
                           "give each axis a name of its own");
    arm.axes.push_back(std::move(axis));
    arm.geometry.home[static_cast<Eigen::Index>(i)] = static_cast<float>(arm.axes.back().home.value);
    arm.geometry.driven.at(i) = arm.axes.back().drive.has_value();
  }
}

void read_limit_sums(const Part& root, ArmFile& arm) {
  for (std::size_t i = 0; root.has("limit_sums") && i < root.at("limit_sums").size(1, 4); ++i) {
    const Part part(root.at("limit_sums").at(i), "limit_sum");
    arm.limit_sums.push_back(
        {part.numbers("weights"), in_rad(part.quantity("lower_deg")), in_rad(part.quantity("upper_deg"))});
    if (arm.limit_sums.back().weights.size() != arm.axes.size())
      part.at("weights").wrong("a number for each axis");
    for (std::size_t j = 0; j < arm.axes.size(); ++j)
      if (arm.axes[j].is_prismatic && arm.limit_sums.back().weights[j] != 0)
        part.at("weights").at(j).fail("mixed-units", "is of a prismatic axis, and the sum is in degrees",
                                      "write 0");
  }
}

// The words for the links of a family, and what they are. Those of a chain are behind its joints.
std::vector<std::pair<std::string_view, kinematics::Body>> links_of(const ArmFile& arm) {
  using kinematics::BodyLink;
  std::vector<std::pair<std::string_view, kinematics::Body>> links;
  links.reserve(arm.joints.size() + 4);
  const int platform = kinematics::platform_joints(arm.geometry);
  for (int k = 0; k < arm.geometry.chain.count; ++k)
    links.push_back({arm.joints[static_cast<std::size_t>(platform + k)], {BodyLink::kChain, k}});
  if (arm.family == "five_bar")
    links.insert(links.end(), {{"inner1", {BodyLink::kInner, 0}},
                               {"inner2", {BodyLink::kInner, 1}},
                               {"outer1", {BodyLink::kOuter, 0}},
                               {"outer2", {BodyLink::kOuter, 1}}});
  if (arm.family == "delta")
    links.insert(links.end(), {{"plate", {BodyLink::kPlate}}, {"thighs", {BodyLink::kThighs}}});
  return links;
}

void read_bodies(const Part& root, ArmFile& arm) {
  if (!root.has("bodies")) return;
  const Value bodies = root.at("bodies");
  const auto links = links_of(arm);
  if (links.empty())
    bodies.fail("senseless-key", "is not for a two_link, whose weight is in its inertia",
                "give g2 and g3 of its inertia");
  std::vector<std::string_view> words;
  words.reserve(links.size());
  for (const auto& link : links) words.push_back(link.first);
  const std::size_t count = bodies.size(1, kinematics::kMaxBodies);
  for (std::size_t i = 0; i < count; ++i) {
    const Part part(bodies.at(i), "body");
    kinematics::Body& body = arm.geometry.body.at(i);
    body = links.at(part.at("link").word(words)).second;
    body.mass_kg = static_cast<float>(part.quantity("mass_kg").value);
    body.centre_m = part.vector("centre_m").cast<float>();
    arm.body_inertia_kg_m2.at(i) = part.vector("inertia_kg_m2");
  }
  arm.geometry.body_count = static_cast<int>(count);
}

void read_limits(const Part& root, ArmFile& arm) {
  const Part limits = root.part("limits", "limits");
  arm.max_force_N = limits.quantity("max_force_N").value;
  arm.max_joint_speed_rad_s = limits.quantity("max_joint_speed_rad_s").value;
  arm.tip_stiffness_N_m = limits.quantity("tip_stiffness_N_m").value;
  arm.supply_V = limits.quantity("supply_V").value;
  if (!limits.has("largest_walls")) return;
  constexpr std::size_t kMostWalls = 32;
  const Value walls = limits.at("largest_walls");
  const std::size_t count = walls.size(1, kMostWalls);
  arm.largest_walls.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Part wall(walls.at(i), "largest_wall");
    arm.largest_walls.push_back(
        {wall.number("rate_Hz"), wall.number("damping_N_s_m"), wall.quantity("stiffness_N_m")});
  }
}

void read_commissioned(const Part& root, ArmFile& arm) {
  if (!root.has(kCommissionedKey)) return;
  const Part part = root.part(kCommissionedKey, "commissioned");
  arm.commissioned_on = part.text("on");
  arm.is_commissioned = part.text("crc32") == commissioned_crc(root.value().raw());
}

ArmFile read(const Value& value) {
  const Part root(value, "arm");
  if (root.at("thimble_arm").raw() != 1)
    root.at("thimble_arm")
        .fail("wrong-version", "is " + root.at("thimble_arm").raw().dump() + ", this program reads version 1",
              "use the version of thimble that the file was written for");
  ArmFile arm;
  if (root.has("$schema")) static_cast<void>(root.text("$schema"));
  arm.name = read_name(root);
  if (root.has("description")) arm.description = root.text("description");
  arm.source = root.text("source");
  arm.geometry.rotation = rotation(root);
  read_kinematics(root, arm);
  read_coupling(root, arm);
  read_axes(root, arm);
  read_limit_sums(root, arm);
  read_bodies(root, arm);
  read_limits(root, arm);
  read_commissioned(root, arm);
  return arm;
}

}  // namespace

double ArmAxis::per_count() const {
  const double turn = is_prismatic ? 1.0 : 2.0 * std::numbers::pi;
  return encoder.sign * turn / (encoder.counts_per_turn.value * encoder.turns_per_turn.value);
}

double ArmAxis::per_ampere() const {
  if (!drive) return 0;
  const double rad_per_turn = is_prismatic ? 2.0 * std::numbers::pi : 1.0;
  return drive->sign * rad_per_turn * drive->turns_per_turn.value * motor->torque_constant_N_m_A.value;
}

double ArmAxis::peak_torque() const {
  return drive ? std::abs(per_ampere()) * motor->peak_current_A.value : 0;
}

ArmFile read_arm_file(const std::string& text, const std::string& name) {
  try {
    const board::JsonDocument document(text, name, "the arm");
    return read(Value(document));
  } catch (const board::JsonError& error) {
    throw to_error(error);
  }
}

}  // namespace thimble::host
