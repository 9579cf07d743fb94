#include "board/sim/sim_arm.h"

#include <algorithm>

namespace thimble::board {
namespace {

template <typename Vector>
SimArm::PerAxis padded(const Vector& values) {
  SimArm::PerAxis all = SimArm::PerAxis::Zero();
  all.head(values.size()) = values;
  return all;
}

// As many of them as the plant has.
Vector3d of(const Plant&, const SimArm::PerAxis& values) { return values.head<3>(); }
JointVector of(const AnyPlant& plant, const SimArm::PerAxis& values) { return values.head(plant.axes()); }

}  // namespace

Vector3d SimArm::tip_m() const {
  const auto* general = std::get_if<AnyPlant>(&plant_);
  return general != nullptr ? general->force_point_m() : std::get<Plant>(plant_).tip_m();
}

Vector3d SimArm::tip_velocity_m_s() const {
  const auto* general = std::get_if<AnyPlant>(&plant_);
  if (general == nullptr) return std::get<Plant>(plant_).tip_velocity_m_s();
  return general->force_jacobian() * general->joint_speeds_rad_s();
}

Vector3d SimArm::hand_force_N() const {
  return std::visit([](const auto& plant) { return Vector3d(plant.hand_force_N()); }, plant_);
}

double SimArm::time_s() const {
  return std::visit([](const auto& plant) { return plant.time_s(); }, plant_);
}

SimArm::PerAxis SimArm::rotors_rad() const {
  return std::visit([](const auto& plant) { return padded(plant.rotors_rad()); }, plant_);
}

std::array<std::uint32_t, kinematics::kMaxJoints> SimArm::encoder_counts() const {
  std::array<std::uint32_t, kinematics::kMaxJoints> all{};
  std::visit([&all](const auto& plant) { std::ranges::copy(plant.encoder_counts(), all.begin()); }, plant_);
  return all;
}

const Motor& SimArm::motor(std::size_t axis) const {
  return std::visit([axis](const auto& plant) -> const Motor& { return plant.motors().at(axis); }, plant_);
}

void SimArm::set_drives(double supply, const PerAxis& torque) {
  std::visit([&](auto& plant) { plant.set_drives(supply, of(plant, torque)); }, plant_);
}

void SimArm::command_current(const PerAxis& current_A, bool enable) {
  std::visit([&](auto& plant) { plant.command_current(of(plant, current_A), enable); }, plant_);
}

void SimArm::set_hand(const Hand& hand) {
  std::visit([&](auto& plant) { plant.set_hand(hand); }, plant_);
}

void SimArm::set_hand_target(const Vector3d& position_m, const Vector3d& velocity_m_s) {
  std::visit([&](auto& plant) { plant.set_hand_target(position_m, velocity_m_s); }, plant_);
}

void SimArm::set_specimen(std::shared_ptr<const Specimen> specimen) {
  std::visit([&](auto& plant) { plant.set_specimen(std::move(specimen)); }, plant_);
}

void SimArm::push(const Vector3d& force_N) {
  std::visit([&](auto& plant) { plant.push(force_N); }, plant_);
}

void SimArm::step(double seconds, bool stays) {
  std::visit(
      [&](auto& plant) {
        const auto joints_rad = plant.joints_rad();
        plant.step(seconds);
        if (stays) plant.place(joints_rad);
      },
      plant_);
}

}  // namespace thimble::board
