#include "host-tools/arms/arm_writer.h"

#include "thimble_arm_schema/arm_generated.h"

namespace thimble::host {
namespace {

using flatbuffers::Offset;

float of(const Quantity& quantity) { return static_cast<float>(quantity.value); }
float of(const std::optional<Quantity>& quantity) { return quantity ? of(*quantity) : 0.0F; }

arm::Vec3 vec3(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

arm::Mat3 mat3(const Eigen::Matrix3f& m) {
  const std::array<float, 9> row{m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1),
                                 m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
  return arm::Mat3(row);
}

struct Platform {
  arm::Platform type = arm::Platform::NONE;
  Offset<void> value;
};
Platform write_platform(const ArmFile& file, flatbuffers::FlatBufferBuilder& builder) {
  const auto& platform = file.geometry.platform;
  if (const auto* two = std::get_if<kinematics::TwoLinkGeometry>(&platform)) {
    std::vector<float> inertia;
    if (file.two_link_inertia) {
      const TwoLinkInertia& i = *file.two_link_inertia;
      for (const double number : {i.m11, i.m11_cos_2q2, i.m11_cos_2q3, i.m22, i.m33, i.m23, i.g2, i.g3})
        inertia.push_back(static_cast<float>(number));
    }
    const auto numbers = inertia.empty() ? 0 : builder.CreateVector(inertia);
    return {
        arm::Platform::TwoLink,
        arm::CreateTwoLink(builder, two->base_height_m, two->upper_link_m, two->forearm_m, numbers).Union()};
  }
  if (const auto* bars = std::get_if<kinematics::FiveBarGeometry>(&platform)) {
    const arm::FiveBar value(bars->base_distance_m, bars->inner_m, bars->outer_m, bars->up);
    return {arm::Platform::FiveBar, builder.CreateStruct(value).Union()};
  }
  if (const auto* d = std::get_if<kinematics::DeltaGeometry>(&platform)) {
    const arm::Delta value(d->thigh_m, d->shin_m, d->plate_u_m, d->plate_v_m, d->shin_end_m, d->knee_end_m,
                           d->base_u_m, d->base_v_m, d->leg_angle_rad, d->minus, d->home_axis_m);
    return {arm::Platform::Delta, builder.CreateStruct(value).Union()};
  }
  return {};
}

template <typename Kind>
Kind kind_of(const std::string& word, std::initializer_list<std::pair<const char*, Kind>> kinds) {
  for (const auto& [name, kind] : kinds)
    if (word == name) return kind;
  throw std::logic_error("no kind of an image for " + word);
}

Offset<arm::Axis> write_axis(const ArmAxis& axis, flatbuffers::FlatBufferBuilder& builder) {
  using enum arm::DriveKind;
  const ArmEncoder& e = axis.encoder;
  const arm::Encoder encoder(
      static_cast<std::uint8_t>(e.port),
      kind_of<arm::EncoderKind>(e.kind, {{"quadrature", arm::EncoderKind::Quadrature},
                                         {"potentiometer", arm::EncoderKind::Potentiometer},
                                         {"drive", arm::EncoderKind::Drive}}),
      static_cast<std::uint8_t>(e.counter_bits), static_cast<std::int8_t>(e.sign), of(e.counts_per_turn),
      of(e.turns_per_turn), static_cast<float>(e.max_rate_Hz));
  std::optional<arm::Drive> drive;
  std::optional<arm::Motor> motor;
  if (axis.drive) {
    const ArmDrive& d = *axis.drive;
    drive.emplace(static_cast<std::uint8_t>(d.port),
                  kind_of<arm::DriveKind>(d.kind, {{"analog_current", AnalogCurrent},
                                                   {"moteus", Moteus},
                                                   {"odrive", Odrive},
                                                   {"mit", Mit},
                                                   {"damiao", Damiao}}),
                  static_cast<std::int8_t>(d.sign), of(d.turns_per_turn), of(d.delay_s));
    const ArmMotor& m = *axis.motor;
    motor.emplace(of(m.torque_constant_N_m_A), of(m.resistance_ohm), of(m.inductance_H),
                  of(m.rotor_inertia_kg_m2), of(m.peak_current_A), of(m.continuous_torque_N_m),
                  of(m.winding_to_housing_K_W), of(m.housing_to_ambient_K_W), of(m.winding_time_constant_s),
                  of(m.housing_time_constant_s), of(m.max_winding_C));
  }
  const ArmFriction& f = axis.friction;
  return arm::CreateAxis(builder, builder.CreateString(axis.name), of(axis.lower), of(axis.upper),
                         of(axis.home), &encoder, drive ? &*drive : nullptr, motor ? &*motor : nullptr,
                         of(f.coulomb_N_m), of(f.viscous_N_m_s_rad), std::max(1.0F, of(f.stiction_ratio)),
                         of(axis.stiffness_N_m_rad), of(axis.first_resonance_Hz));
}

std::vector<arm::Joint> joints_of(const kinematics::ChainGeometry& chain) {
  std::vector<arm::Joint> joints;
  for (int k = 0; k < chain.count; ++k) {
    const kinematics::ChainJoint& joint = chain.joint.at(static_cast<std::size_t>(k));
    joints.emplace_back(joint.kind == kinematics::JointKind::kPrismatic, vec3(joint.origin_m),
                        mat3(joint.rotation), vec3(joint.axis));
  }
  return joints;
}

std::vector<arm::Body> bodies_of(const kinematics::Geometry& geometry) {
  std::vector<arm::Body> bodies;
  for (int i = 0; i < geometry.body_count; ++i) {
    const kinematics::Body& body = geometry.body.at(static_cast<std::size_t>(i));
    bodies.emplace_back(static_cast<arm::BodyLink>(body.link), static_cast<std::uint8_t>(body.joint),
                        body.mass_kg, vec3(body.centre_m));
  }
  return bodies;
}

}  // namespace

std::vector<std::byte> arm_image(const ArmFile& file) {
  flatbuffers::FlatBufferBuilder builder;
  const kinematics::Geometry& geometry = file.geometry;
  const auto axes = static_cast<Eigen::Index>(file.axes.size());
  const auto name = builder.CreateString(file.name);
  const Platform platform = write_platform(file, builder);
  const auto chain = builder.CreateVectorOfStructs(joints_of(geometry.chain));
  std::vector<float> matrix, offset;
  for (Eigen::Index i = 0; i < axes; ++i) {
    offset.push_back(geometry.joint_offset[i]);
    for (Eigen::Index j = 0; j < axes; ++j) matrix.push_back(geometry.joints_per_axis(i, j));
  }
  const auto joints_per_axis = builder.CreateVector(matrix);
  const auto joint_offset = builder.CreateVector(offset);
  std::vector<Offset<arm::Axis>> written_axes;
  for (const ArmAxis& axis : file.axes) written_axes.push_back(write_axis(axis, builder));
  const auto axes_vector = builder.CreateVector(written_axes);
  std::vector<Offset<arm::LimitSum>> sums;
  for (const ArmLimitSum& sum : file.limit_sums) {
    const std::vector<float> weights(sum.weights.begin(), sum.weights.end());
    sums.push_back(
        arm::CreateLimitSum(builder, builder.CreateVector(weights), of(sum.lower_rad), of(sum.upper_rad)));
  }
  const auto sums_vector = builder.CreateVector(sums);
  const auto bodies = builder.CreateVectorOfStructs(bodies_of(geometry));
  const arm::Mat3 rotation = mat3(geometry.rotation);
  const arm::Vec3 tip = vec3(geometry.chain.tip_m);
  arm::FinishArmBuffer(builder, arm::CreateArm(builder, name, &rotation, platform.type, platform.value, chain,
                                               &tip, static_cast<std::uint8_t>(geometry.chain.force_joint),
                                               joints_per_axis, joint_offset, axes_vector, sums_vector,
                                               bodies, static_cast<float>(file.max_force_N),
                                               static_cast<float>(file.max_joint_speed_rad_s),
                                               static_cast<float>(file.tip_stiffness_N_m),
                                               static_cast<float>(file.supply_V), file.is_commissioned));
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace thimble::host
