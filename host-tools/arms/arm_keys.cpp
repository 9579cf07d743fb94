#include "host-tools/arms/arm_keys.h"

#include "host-tools/keys/key_values.h"
#include "host-tools/keys/schema.h"
#include "kinematics/geometry.h"

namespace thimble::host {
namespace keys {
namespace {

constexpr std::size_t kAxes = kinematics::kMaxJoints;

FileKind& add(KeyTable& kinds, std::string_view name, const char* what, std::string_view for_people = {}) {
  kinds.push_back({name, what, for_people});
  return kinds.back();
}

KeyValue name() { return text(31); }
Range degrees() { return from(-720, 720, "degrees"); }
Range place() { return from(-2, 2, "m"); }
KeyValue length() { return quantity(above(0, 2, "m")); }
KeyValue offset() { return quantity(place()); }
KeyValue ratio() { return quantity(above(0, 1e4)); }
KeyValue positive(const char* unit) { return quantity(above(0, 1e6, unit)); }
KeyValue not_negative(const char* unit) { return quantity(from(0, 1e6, unit)); }
KeyValue turn() { return vector(from(-360, 360, "degrees")).by_default(0, 0, 0); }
KeyValue sign() { return number(from(-1, 1)).by_default(1); }
KeyValue port() { return number(from(0, 15)); }

void add_arm(KeyTable& kinds) {
  add(kinds, "arm", "an arm", "The numbers of a haptic arm. See docs/arm-format.md.")
      .optional("$schema", text(4096), "Path of this schema, for editors.")
      .required("thimble_arm", version(), "Version of the format.")
      .required("name", name(), "As configurations and recordings have it.")
      .optional("description", text(4096), "For people.")
      .required("source", text(4096), "Where the figures are from. A guess says so in its \"by\".")
      .optional("rotation_deg", turn(), "Of the base frame in the world: roll, pitch, yaw, about fixed axes.")
      .required("kinematics", part("kinematics"))
      .optional("wrist", part("chain"), "Behind a five_bar or a delta.")
      .optional("coupling", part("coupling"), "Without it each axis is a joint.")
      .optional("motors", named_parts("motor"), "By name, for axes to refer to.")
      .required("axes", list("axis", 1, kAxes),
                "Encoders, and the motors of those that are driven: as many as joints, in their order.")
      .optional("limit_sums", list("limit_sum", 1, 4), "Limits of weighted sums of the axes.")
      .optional("bodies", list("body", 1, kinematics::kMaxBodies), "What gravity compensation carries.")
      .required("limits", part("limits"))
      .optional("commissioned", part("commissioned"),
                "Written by `thimble commission`. Without it, or with another figure changed since, a board "
                "gives at most 1 N.");

  add(kinds, "commissioned", "a commissioning")
      .required("on", text(31), "The day on which every step had passed.")
      .required("crc32", text(8), "Of the figures that were proved.");

  add(kinds, "kinematics", "the kinematics", "Exactly one family.")
      .alternative("serial", part("chain"))
      .alternative("two_link", part("two_link"))
      .alternative("five_bar", part("five_bar"))
      .alternative("delta", part("delta"));

  add(kinds, "coupling", "the coupling", "joints = matrix x axes + offset")
      .required("joints_per_axis", rows(from(-10, 10)), "A row a joint.")
      .optional("offset_deg", numbers(degrees(), 1, kAxes), "Of each joint; m for a prismatic one.");

  add(kinds, "limit_sum", "a limit of a sum")
      .required("weights", numbers(from(-10, 10), 1, kAxes), "Of each axis.")
      .required("lower_deg", quantity(degrees()))
      .required("upper_deg", quantity(degrees()));

  add(kinds, "limits", "the limits of the arm")
      .required("max_force_N", positive("N"), "At the tip, in any direction.")
      .required("max_joint_speed_rad_s", positive("rad/s"), "Above it an encoder's reading is rejected.")
      .required("tip_stiffness_N_m", positive("N/m"), "With locked motors.")
      .required("supply_V", positive("V"), "Of the motor amplifiers.")
      .optional("largest_walls", list("largest_wall", 1, 32),
                "What the arm holds still, as `thimble commission` measured it, with its margin.");

  add(kinds, "largest_wall", "a largest wall")
      .required("rate_Hz", number(above(0, 1e6, "Hz")), "Ticks a second.")
      .required("damping_N_s_m", number(from(0, 1e3, "N s/m")), "B of the wall.")
      .required("stiffness_N_m", quantity(from(0, 1e5, "N/m")), "0: it holds no wall with this damping.");
}

void add_families(KeyTable& kinds) {
  add(kinds, "chain", "a chain", "Joints from the base outwards, as in URDF.")
      .required("joints", list("joint", 1, kAxes))
      .optional("tip_m", vector(place()).by_default(0, 0, 0), "In the frame of the last link.")
      .optional("force_at", name(), "The joint at whose origin the force acts; without it at the tip.");
  add(kinds, "joint", "a joint")
      .required("name", name())
      .optional("type", one_of({"revolute", "prismatic"}).by_default("revolute"))
      .optional("origin_m", vector(place()).by_default(0, 0, 0), "In the frame of the link before.")
      .optional("rotation_deg", turn(), "Of the joint's frame there: roll, pitch, yaw, about fixed axes.")
      .optional("axis", direction().by_default(0, 0, 1), "In the joint's frame.");

  add(kinds, "two_link", "a two-link arm",
      "Yaw, upper link and forearm, both links driven from the base: joints 2 and 3 are absolute angles.")
      .optional("base_height_m", offset().by_default(0))
      .required("upper_link_m", length())
      .required("forearm_m", length())
      .optional("inertia", part("two_link_inertia"));
  FileKind& inertia = add(kinds, "two_link_inertia", "the inertia of a two-link arm",
                          "Coefficients of M(q) and G(q), see kinematics/arm_data.h; without rotors.");
  const Range kg_m2 = from(-1, 1, "kg m2"), N_m = from(-100, 100, "N m");
  for (const std::string_view key : {"m11", "m11_cos_2q2", "m11_cos_2q3", "m22", "m33", "m23"})
    inertia.required(key, quantity(kg_m2));
  inertia.required("g2", quantity(N_m)).required("g3", quantity(N_m));

  add(kinds, "five_bar", "a planar five-bar",
      "Base joints at (0, 0) and (base_distance_m, 0), in the plane z = 0.")
      .required("base_distance_m", offset())
      .required("inner_m", numbers(above(0, 2, "m"), 2, 2), "From the base joints.")
      .required("outer_m", numbers(above(0, 2, "m"), 2, 2), "To the tip.")
      .required("assembly", one_of({"up", "down"}),
                "The side of the tip: up is the left of the way from the first elbow to the second one.");
  add(kinds, "delta", "a rotary delta", "Lengths as in kinematics/delta.h.")
      .required("thigh_m", length(), "a")
      .required("shin_m", length(), "b")
      .required("plate_u_m", offset(), "c")
      .required("plate_v_m", offset(), "f")
      .required("shin_end_m", offset(), "d")
      .required("knee_end_m", offset(), "e")
      .required("base_u_m", offset(), "r")
      .required("base_v_m", offset(), "s")
      .required("leg_angles_deg", numbers(degrees(), 3, 3))
      .required("branch", one_of({"minus", "plus"}))
      .required("home_axis_m", offset(), "Height of the plate with all axes at home, roughly.");
}

void add_axis(KeyTable& kinds) {
  add(kinds, "axis", "an axis", "_m instead of _deg where the joint is prismatic.")
      .required("name", name())
      .optional("lower_deg", quantity(degrees()))
      .optional("upper_deg", quantity(degrees()))
      .optional("lower_m", quantity(place()))
      .optional("upper_m", quantity(place()))
      .optional("home_deg", quantity(degrees()).by_default(0))
      .optional("home_m", quantity(place()).by_default(0))
      .required("encoder", part("encoder"))
      .optional("drive", part("drive"), "Without one the axis is only sensed.")
      .optional("motor", part_or_name("motor"), "With a drive.")
      .optional("friction", part("friction"))
      .optional("stiffness_N_m_rad", positive("N m/rad"), "Between motor and joint, at the axis.")
      .optional("first_resonance_Hz", positive("Hz"));
  add(kinds, "encoder", "an encoder")
      .required("port", port())
      .required("kind", one_of({"quadrature", "potentiometer", "drive"}),
                "drive: the motor drive reports it.")
      .required("counts_per_turn", positive("counts"), "Of the encoder, all edges.")
      .optional("counter_bits", number(from(8, 32)).by_default(32))
      .optional("sign", sign(), "Of the counts for a positive motion of the axis: 1 or -1.")
      .required("turns_per_turn", ratio(), "Turns of the encoder for a turn of the axis, or for a metre.")
      .optional("max_rate_Hz", positive("Hz"), "Edges a second that the input counts.");
  add(kinds, "drive", "a drive")
      .required("port", port())
      .required("kind", one_of({"analog_current", "moteus", "odrive", "mit", "damiao"}))
      .optional("sign", sign(), "Of the torque for a positive current: 1 or -1.")
      .required("turns_per_turn", ratio(), "Turns of the motor for a turn of the axis, or for a metre.")
      .optional("delay_s", quantity(from(0, 0.1, "s")).by_default(0), "From the command to the torque.");
  add(kinds, "motor", "a motor")
      .required("torque_constant_N_m_A", positive("N m/A"), "And back-EMF constant, V s/rad.")
      .required("resistance_ohm", positive("ohm"), "At 25 C.")
      .required("inductance_H", positive("H"))
      .required("rotor_inertia_kg_m2", positive("kg m2"))
      .required("peak_current_A", positive("A"))
      .required("continuous_torque_N_m", positive("N m"), "At the shaft.")
      .required("winding_to_housing_K_W", positive("K/W"))
      .required("housing_to_ambient_K_W", positive("K/W"))
      .required("winding_time_constant_s", positive("s"))
      .required("housing_time_constant_s", positive("s"))
      .required("max_winding_C", positive("C"));
  add(kinds, "friction", "friction", "At the axis.")
      .required("coulomb_N_m", not_negative("N m"))
      .required("viscous_N_m_s_rad", not_negative("N m s/rad"))
      .optional("stiction_ratio", quantity(from(1, 10)).by_default(1), "Static over Coulomb friction.");
  add(kinds, "body", "a body", "Its weight is carried.")
      .required("link", name(),
                "Behind this joint; of a five_bar inner1, inner2, outer1, outer2, of a delta plate, thighs.")
      .required("mass_kg", positive("kg"))
      .optional("centre_m", vector(place()).by_default(0, 0, 0),
                "In the link's frame; x is along the link of a five_bar and of a delta.")
      .optional("inertia_kg_m2", vector(from(0, 10, "kg m2")).by_default(0, 0, 0),
                "About the centre of mass, along the axes of the link.");
}

KeyTable table() {
  KeyTable kinds;
  add_arm(kinds);
  add_families(kinds);
  add_axis(kinds);
  return kinds;
}

}  // namespace
}  // namespace keys

const KeyTable& arm_kinds() {
  static const KeyTable kKinds = keys::table();
  return kKinds;
}

std::string arm_schema() {
  return schema_text("Thimble arm, version 1",
                     "Generated from host-tools/arms/arm_keys.cpp; arms_test compares.", "arm", arm_kinds());
}

}  // namespace thimble::host
