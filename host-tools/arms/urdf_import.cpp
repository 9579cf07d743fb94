#include "host-tools/arms/urdf_import.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "host-tools/error.h"
#include "kinematics/arm_data.h"
#include "kinematics/geometry.h"

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::size_t kMostRobotName = 1000;  // bytes
constexpr double kPerRad_deg = 180.0 / std::numbers::pi;

[[noreturn]] void refuse(const char* slug, const std::string& cause, const std::string& remedy) {
  throw Error(ExitCode::kBadInput, slug, cause, remedy);
}

// To a nanometre and a billionth of a degree, so that 0.1 + 0.2 is 0.3; adding 0 makes 0 of -0.
double tidy(double value) { return std::round(value * 1e9) / 1e9 + 0.0; }
Json numbers(const Vector3d& v) { return {tidy(v.x()), tidy(v.y()), tidy(v.z())}; }
std::string shortened(const std::string& name) {
  constexpr std::size_t kMost = 60;  // bytes
  return name.size() <= kMost ? name : name.substr(0, kMost) + "...";
}
Json guess(double value) { return {{"value", value}, {"by", "guess"}}; }

Isometry3d of(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Isometry3d place = Isometry3d::Identity();
  place.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  place.translation() << pose.position.x, pose.position.y, pose.position.z;
  return place;
}

// Roll, pitch and yaw about fixed axes.
Vector3d rpy_deg(const Eigen::Matrix3d& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool upright = std::hypot(R(0, 0), R(1, 0)) > 1e-9;  // otherwise roll and yaw are about one axis
  const double roll = upright ? std::atan2(R(2, 1), R(2, 2)) : std::atan2(-R(1, 2), R(1, 1));
  const double yaw = upright ? std::atan2(R(1, 0), R(0, 0)) : 0.0;
  return kPerRad_deg * Vector3d(roll, pitch, yaw);
}

// The parser takes stack for each level of nesting, without a bound. A URDF has about five.
bool is_nested_deeply(const std::string& xml) {
  constexpr int kMost = 1000;
  int depth = 0;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const std::string_view rest = std::string_view(xml).substr(at);
    if (rest.starts_with("<!--")) {
      at = std::min(xml.find("-->", at), xml.size() - 1);
    } else if (rest.starts_with("</")) {
      --depth;
    } else if (const std::size_t end = xml.find('>', at); !rest.starts_with("<?") &&
                                                          !rest.starts_with("<!") &&
                                                          (end == std::string::npos || xml[end - 1] != '/')) {
      if (++depth > kMost) return true;
    }
  }
  return false;
}

// The parser accepts joints that go round in a circle, and two that carry one link.
void check_tree(const urdf::ModelInterface& model) {
  for (const auto& [name, joint] : model.joints_)
    if (model.getLink(joint->child_link_name)->parent_joint != joint)
      refuse("not-a-tree",
             "link '" + joint->child_link_name + "' is carried by joint '" + name + "' and by another one",
             "an arm file has chains without loops only; write it by hand");
  std::vector<const urdf::Link*> reached{model.getRoot().get()};
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (const urdf::LinkSharedPtr& child : reached[i]->child_links) reached.push_back(child.get());
  if (reached.size() != model.links_.size())
    refuse("not-a-tree", "the URDF has joints that go round in a circle",
           "let each link be carried by another one, up to the root");
}

std::vector<urdf::JointConstSharedPtr> joints_to(const urdf::ModelInterface& model,
                                                 const std::string& wanted) {
  std::string tip = wanted;
  if (tip.empty()) {
    std::string leaves;
    int count = 0;
    for (const auto& [name, link] : model.links_) {
      if (!link->child_links.empty()) continue;
      ++count;
      tip = name;
      leaves += (leaves.empty() ? "" : ", ") + name;
    }
    if (count != 1)
      refuse("ambiguous-tip", "the URDF has several links without a child: " + leaves,
             "say which one carries the tip with --tip");
  }
  const urdf::LinkConstSharedPtr end = model.getLink(tip);
  if (!end) refuse("unknown-link", "the URDF has no link '" + tip + "'", "give --tip the name of a link");
  std::vector<urdf::JointConstSharedPtr> joints;
  for (urdf::LinkConstSharedPtr link = end; link->parent_joint; link = link->getParent())
    joints.push_back(link->parent_joint);
  std::ranges::reverse(joints);
  return joints;
}

Json axis_of(const urdf::Joint& joint, int port) {
  const bool prismatic = joint.type == urdf::Joint::PRISMATIC;
  const bool endless = joint.type == urdf::Joint::CONTINUOUS || !joint.limits;
  const double turn = prismatic ? 1.0 : kPerRad_deg;
  const double lower = endless ? -360.0 : turn * joint.limits->lower;
  const double upper = endless ? 360.0 : turn * joint.limits->upper;
  const std::string unit = prismatic ? "_m" : "_deg";
  Json axis{{"name", joint.name}};
  axis["lower" + unit] = tidy(lower);
  axis["upper" + unit] = tidy(upper);
  axis["home" + unit] = tidy(lower <= 0 && upper >= 0 ? 0.0 : 0.5 * (lower + upper));
  axis["encoder"] = {{"port", port},
                     {"kind", "quadrature"},
                     {"counts_per_turn", guess(4096)},
                     {"turns_per_turn", guess(10)}};
  axis["drive"] = {{"port", port}, {"kind", "analog_current"}, {"turns_per_turn", guess(10)}};
  axis["motor"] = "unknown";
  if (joint.dynamics)
    axis["friction"] = {{"coulomb_N_m", joint.dynamics->friction},
                        {"viscous_N_m_s_rad", joint.dynamics->damping}};
  return axis;
}

Json some_motor() {
  Json motor;
  for (const auto& [key, value] :
       std::initializer_list<std::pair<const char*, double>>{{"torque_constant_N_m_A", 0.02},
                                                             {"resistance_ohm", 2},
                                                             {"inductance_H", 3e-4},
                                                             {"rotor_inertia_kg_m2", 1e-6},
                                                             {"peak_current_A", 3},
                                                             {"continuous_torque_N_m", 0.02},
                                                             {"winding_to_housing_K_W", 4},
                                                             {"housing_to_ambient_K_W", 15},
                                                             {"winding_time_constant_s", 12},
                                                             {"housing_time_constant_s", 600},
                                                             {"max_winding_C", 100}})
    motor[key] = guess(value);
  return motor;
}

struct Chain {
  Json joints = Json::array(), axes = Json::array();
  std::vector<double> mass_kg;        // of the link behind each joint
  std::vector<Vector3d> moment_kg_m;  // its mass times its centre
  Isometry3d behind =
      Isometry3d::Identity();  // from the frame of the last movable joint to that of the next link

  // next: the joint behind the link on the way to the tip, if there is one.
  void add(const urdf::Joint& joint, const urdf::Link& link, const urdf::Joint* next) {
    if (joint.mimic)
      refuse("mimic-joint", "joint '" + joint.name + "' mimics '" + joint.mimic->joint_name + "'",
             "an arm file has couplings; write it by hand");
    behind = behind * of(joint.parent_to_joint_origin_transform);
    if (joint.type != urdf::Joint::FIXED) add_movable(joint);
    if (!joints.empty()) add_mass(link, next);
  }

  // One for each movable link, with all that is fixed to it.
  [[nodiscard]] Json bodies() const {
    Json all = Json::array();
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (tidy(mass_kg[i]) != 0)
        all.push_back({{"link", joints[i]["name"]},
                       {"mass_kg", tidy(mass_kg[i])},
                       {"centre_m", numbers(moment_kg_m[i] / mass_kg[i])}});
    return all;
  }

 private:
  // Of a link and of what is fixed to it beside the way to the tip: a camera, the housing of a motor.
  void add_mass(const urdf::Link& first, const urdf::Joint* next) {
    std::vector<std::pair<const urdf::Link*, Isometry3d>> links{{&first, behind}};
    while (!links.empty()) {
      const auto [link, place] = links.back();
      links.pop_back();
      if (link->inertial) {
        if (!(link->inertial->mass >= 0))
          refuse("bad-mass",
                 fmt::format("link '{}' has a mass of {} kg", shortened(link->name), link->inertial->mass),
                 "give it a mass of 0 or more");
        mass_kg.back() += link->inertial->mass;
        moment_kg_m.back() += link->inertial->mass * (place * of(link->inertial->origin).translation());
      }
      for (std::size_t i = 0; i < link->child_joints.size(); ++i) {
        const urdf::Joint& joint = *link->child_joints[i];
        if (joint.type == urdf::Joint::FIXED && &joint != next)
          links.emplace_back(link->child_links[i].get(), place * of(joint.parent_to_joint_origin_transform));
      }
    }
  }

  void add_movable(const urdf::Joint& joint) {
    const bool prismatic = joint.type == urdf::Joint::PRISMATIC;
    if (!prismatic && joint.type != urdf::Joint::REVOLUTE && joint.type != urdf::Joint::CONTINUOUS)
      refuse("joint-type",
             "joint '" + joint.name + "' is neither revolute nor continuous, prismatic or fixed",
             "an arm has joints of one axis");
    if (joint.name.empty() || joint.name.size() > kinematics::kMaxArmName)
      refuse("bad-name",
             fmt::format("joint '{}' has a name of {} bytes, an arm has names of 1 to {}",
                         shortened(joint.name), joint.name.size(), kinematics::kMaxArmName),
             "rename the joint in the URDF");
    Json entry{{"name", joint.name}};
    if (prismatic) entry["type"] = "prismatic";
    entry["origin_m"] = numbers(behind.translation());
    entry["rotation_deg"] = numbers(rpy_deg(behind.linear()));
    entry["axis"] = numbers({joint.axis.x, joint.axis.y, joint.axis.z});
    axes.push_back(axis_of(joint, static_cast<int>(joints.size())));
    joints.push_back(entry);
    mass_kg.push_back(0);
    moment_kg_m.emplace_back(Vector3d::Zero());
    behind.setIdentity();
  }
};

// Collects what the parser has against a URDF, which it says nowhere else.
class ParserErrors : public console_bridge::OutputHandler {
 public:
  ParserErrors() {
    console_bridge::noOutputHandler();
    console_bridge::useOutputHandler(this);
  }
  ~ParserErrors() override { console_bridge::noOutputHandler(); }
  ParserErrors(const ParserErrors&) = delete;
  ParserErrors& operator=(const ParserErrors&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (errors_.size() < kMost) errors_.push_back(text.substr(0, kMostBytes));
  }
  // The first one is the cause, the next one often says where.
  [[nodiscard]] std::string first() const {
    if (errors_.empty()) return "it has no robot";
    return errors_.size() == 1 ? errors_[0] : errors_[0] + "; " + errors_[1];
  }
  // Why the mass of a link was left out: the parser goes on without it. Empty: none was.
  [[nodiscard]] std::string about_a_mass() const {
    for (std::size_t i = 0; i < errors_.size(); ++i)
      if (errors_[i].starts_with("Could not parse inertial element"))
        return (i == 0 ? "" : errors_[i - 1] + "; ") + errors_[i];
    return {};
  }

 private:
  static constexpr std::size_t kMost = 1000, kMostBytes = 200;
  std::vector<std::string> errors_;
};

// A model whose links hold each other would never be freed where joints go in a circle.
urdf::ModelInterfaceSharedPtr model_of(const std::string& urdf) {
  const urdf::ModelInterfaceSharedPtr parsed = urdf::parseURDF(urdf);
  if (!parsed) return nullptr;
  return {parsed.get(), [parsed](urdf::ModelInterface* model) {
            for (const auto& [name, link] : model->links_) {
              link->child_links.clear();
              link->child_joints.clear();
            }
          }};
}

}  // namespace

std::string import_urdf(const std::string& urdf, const std::string& name, const std::string& tip) {
  const ParserErrors errors;
  const char* const remedy = "correct the file, or expand it first if it is a xacro file";
  if (is_nested_deeply(urdf))
    refuse("not-a-urdf", "the file is not a URDF: elements are nested too deeply", remedy);
  const urdf::ModelInterfaceSharedPtr model = model_of(urdf);
  if (!model) refuse("not-a-urdf", "the file is not a URDF: " + errors.first(), remedy);
  if (const std::string mass = errors.about_a_mass(); !mass.empty())
    refuse("bad-mass", "the mass of a link cannot be read: " + mass,
           "correct mass, origin and inertia of the link, or remove its <inertial>: it then has no mass");
  check_tree(*model);
  Chain chain;
  const std::vector<urdf::JointConstSharedPtr> way = joints_to(*model, tip);
  for (std::size_t i = 0; i < way.size(); ++i)
    chain.add(*way[i], *model->getLink(way[i]->child_link_name),
              i + 1 < way.size() ? way[i + 1].get() : nullptr);
  if (chain.joints.empty() || chain.joints.size() > kinematics::kMaxJoints)
    refuse("wrong-joints",
           fmt::format("{} joints move between the root and the tip, an arm has 1 to {}", chain.joints.size(),
                       kinematics::kMaxJoints),
           "choose another tip with --tip");
  Json arm{{"thimble_arm", 1},
           {"name", name},
           {"source",
            (model->getName().size() > kMostRobotName ? "A URDF" : "The URDF of '" + model->getName() + "'") +
                ". Encoders, drives, motors and limits of the arm are guesses."}};
  arm["kinematics"]["serial"] = {{"joints", chain.joints}, {"tip_m", numbers(chain.behind.translation())}};
  arm["motors"]["unknown"] = some_motor();
  arm["axes"] = chain.axes;
  if (const Json bodies = chain.bodies(); !bodies.empty()) arm["bodies"] = bodies;
  arm["limits"] = {{"max_force_N", guess(1)},
                   {"max_joint_speed_rad_s", guess(20)},
                   {"tip_stiffness_N_m", guess(2000)},
                   {"supply_V", guess(24)}};
  try {
    return arm.dump(2) + "\n";
  } catch (const Json::type_error&) {
    refuse("not-utf-8", "a name in the URDF is not in UTF-8", "save the file in UTF-8");
  }
}

}  // namespace thimble::host
