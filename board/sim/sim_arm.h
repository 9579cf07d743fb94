// One arm of a simulated board: the closed form of a two-link arm (plant.h), or the general rigid-body model (any_plant.h). Both have one shape
// here, with as many axes as the arm has. Units: SI, world frame; an array has 0 beyond the axes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <variant>

#include "board/sim/any_plant.h"
#include "board/sim/plant.h"

namespace thimble::board {

class SimArm {
 public:
  using PerAxis = kinematics::PerAxis<double>;

  // data: what the controller knows of the arm.
  SimArm(const kinematics::ArmData& data, const Plant& plant) : data_(data), plant_(plant) {}
  SimArm(const kinematics::ArmData& data, const AnyPlant& plant) : data_(data), plant_(plant) {}

  [[nodiscard]] const kinematics::ArmData& data() const noexcept { return data_; }
  [[nodiscard]] std::size_t axes() const noexcept {
    return static_cast<std::size_t>(kinematics::axes_of(data_.geometry));
  }
  [[nodiscard]] Plant& two_link() { return std::get<Plant>(plant_); }       // throws for another arm
  [[nodiscard]] AnyPlant& general() { return std::get<AnyPlant>(plant_); }  // throws for a two-link arm

  [[nodiscard]] Vector3d tip_m() const;  // where the hand is: the force point
  [[nodiscard]] Vector3d tip_velocity_m_s() const;
  [[nodiscard]] Vector3d hand_force_N() const;
  [[nodiscard]] double time_s() const;
  [[nodiscard]] PerAxis rotors_rad() const;
  [[nodiscard]] std::array<std::uint32_t, kinematics::kMaxJoints> encoder_counts() const;
  [[nodiscard]] const Motor& motor(std::size_t axis) const;

  // As those of Plant.
  void set_drives(double supply, const PerAxis& torque);
  void command_current(const PerAxis& current_A, bool enable);
  void set_hand(const Hand& hand);
  void set_hand_target(const Vector3d& position_m, const Vector3d& velocity_m_s);
  void set_specimen(std::shared_ptr<const Specimen> specimen);
  void push(const Vector3d& force_N);
  // stays: it is where it was when they have passed, as an arm that nothing moves.
  void step(double seconds, bool stays);

 private:
  kinematics::ArmData data_;
  std::variant<Plant, AnyPlant> plant_;
};

}  // namespace thimble::board
