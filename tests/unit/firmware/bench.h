// A controller on the bench: storage in memory that can lose power, an arm that is where the test puts it,
// and the board's part of the loop. Used by every test of firmware/.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/controller.h"
#include "kinematics/built_in_arms.h"
#include "kinematics/two_link_arm.h"

namespace thimble::test {

using firmware::Command;
using firmware::Conditions;
using firmware::Controller;
using firmware::Fault;
using firmware::Inputs;
using firmware::Mode;
using firmware::Outputs;
using firmware::Telemetry;

// Behaves like NOR flash: a byte is writable once after an erase.
class TestStorage final : public firmware::Storage {
 public:
  explicit TestStorage(std::size_t slot_bytes = 4096) {
    for (unsigned i = 0; i < kSlots; ++i) slots_[i].assign(Storage::slot_bytes(i, slot_bytes) / 8, kErased);
  }

  std::span<const std::byte> slot(unsigned index) const noexcept override {
    return std::as_bytes(std::span(slots_[index]));
  }
  bool erase(unsigned index, std::size_t bytes) noexcept override {
    ++erases[index];
    for (std::size_t i = 0; i < bytes; ++i) {
      if (!power()) return lies;
      at(index, erase_downwards ? bytes - 1 - i : i) = std::byte{0xFF};
    }
    return true;
  }
  bool write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept override {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (!power()) return lies;
      overwritten = overwritten || at(index, offset + i) != std::byte{0xFF};
      at(index, offset + i) = bytes[i];
    }
    return true;
  }
  std::byte& at(unsigned index, std::size_t offset) noexcept {
    return std::as_writable_bytes(std::span(slots_[index]))[offset];
  }

  std::size_t power_left =
      std::numeric_limits<std::size_t>::max();  // bytes that can still be erased or written
  bool lies = false;                            // says that it has done what it had no power for
  bool erase_downwards = false;
  std::array<std::size_t, kSlots> erases{};
  bool overwritten = false;  // a byte was written twice without an erase

 private:
  static constexpr std::uint64_t kErased = ~std::uint64_t{0};
  bool power() noexcept { return power_left != 0 && power_left-- != 0; }

  std::array<std::vector<std::uint64_t>, kSlots> slots_;
};

// A scene with one horizontal plane, or as many in one place: solid below z = height_m.
std::vector<std::byte> plane_image(float stiffness_N_m, float height_m = 0.0F, float damping_N_s_m = 0.0F,
                                   const std::string& name = "plane", std::size_t planes = 1,
                                   float friction = 0.0F);

class Bench {
 public:
  explicit Bench(const firmware::Config& bench_config = {}, std::size_t slot_bytes = 4096)
      : config(bench_config),
        storage(slot_bytes),
        controller(std::make_unique<Controller>(bench_config, storage)) {
    inputs.dead_man = true;
    for (std::size_t i = 0; i < firmware::kMaxArms; ++i) {
      data[i] = kinematics::built_in_arm(config.arm[i].model);
      for (const kinematics::ArmData& known : config.arms_known)
        if (kinematics::name_of(known) == config.arm[i].model) data[i] = known;
      arms.emplace_back(data[i], config.arm[i].base);
      joints.push_back(arms.back().home());
    }
  }

  // One period. The hand trembles by two counts, as hands do, unless the test froze it.
  const Outputs& tick() {
    if (halted) {  // the background alone goes on
      const auto period_us = static_cast<std::uint64_t>(static_cast<double>(config.period_s) * 1e6);
      inputs.time_us += period_us;
      halted_us += period_us;
      controller->poll(inputs.time_us);
      return outputs;
    }
    ++inputs.tick;
    inputs.time_us = halted_us + static_cast<std::uint64_t>(static_cast<double>(inputs.tick) *
                                                            static_cast<double>(config.period_s) * 1e6);
    for (std::size_t i = 0; i < arms.size(); ++i) {
      if (sampling) inputs.arm[i].sample_tick = inputs.tick;
      for (std::size_t j = 0; j < 3; ++j) {
        const int axis = static_cast<int>(j);
        const double count =
            (joints[i][axis] - arms[i].home()[axis]) / static_cast<double>(data[i].axis[j].rad_per_count());
        constexpr std::array<std::int64_t, 4> kTremble = {0, 1, 2, 1};
        const std::int64_t tremble = frozen ? 0 : kTremble[inputs.tick / 100 % 4];
        inputs.arm[i].counts[j] =
            static_cast<std::uint32_t>(std::llround(count) + tremble + count_at_home) & counter_bits;
      }
    }
    if (alive) controller->keep_alive();
    outputs = controller->tick(inputs);
    controller->poll(inputs.time_us);
    return outputs;
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }
  // Puts a fingertip somewhere in the world, at once or by even steps.
  void place(const Eigen::Vector3d& tip_m, std::size_t arm = 0) {
    if (!arms[arm].inverse(tip_m, joints[arm])) throw std::logic_error("the test's tip is out of reach");
  }
  void move(const Eigen::Vector3d& to_m, int steps, std::size_t arm = 0) {
    const Eigen::Vector3d from_m = arms[arm].at(joints[arm]).tip_m;
    for (int i = 1; i <= steps; ++i) {
      place(from_m + (to_m - from_m) * (static_cast<double>(i) / steps), arm);
      tick();
    }
  }
  const Telemetry& shown() const { return controller->telemetry(); }
  Mode mode() const { return controller->mode(); }
  // A test puts the tip from place to place, at speeds that are a fault otherwise.
  void let_jump() {
    const firmware::ParamRow* row = firmware::find_param("max_tip_speed");
    if (controller->write_param(row->id, std::bit_cast<std::uint32_t>(row->max)) !=
        firmware::ParamStatus::kOk)
      throw std::logic_error("the parameter was refused");
  }
  float force_N(std::size_t arm = 0) const { return shown().arm[arm].force_N.norm(); }

  // Starts anew, as after a reset of the board. Its clock and the world go on.
  void restart(const char* reason, std::uint32_t utc_s = 0) {
    config.reset_reason = reason;
    config.utc_s = utc_s;
    controller.reset();
    controller = std::make_unique<Controller>(config, storage);
  }

  // Scene, home, arm. The tip is at home, on the plane's surface.
  void load(float stiffness_N_m = 1000.0F, float height_m = 0.0F, float damping_N_s_m = 0.0F) {
    const auto status = controller->load_scene(plane_image(stiffness_N_m, height_m, damping_N_s_m));
    if (status != firmware::StoreStatus::kOk) throw std::logic_error("the scene was refused");
  }
  void home() {
    tick();
    if (controller->request(Command::kHome) != 0) throw std::logic_error("homing was refused");
    ticks(2);
  }
  void arm() {
    if (controller->request(Command::kArm) != 0) throw std::logic_error("arming was refused");
    tick();
    if (mode() != Mode::kArmed) throw std::logic_error("not armed");
  }
  void start() {
    load();
    home();
    arm();
  }

  firmware::Config config;
  TestStorage storage;
  std::unique_ptr<Controller> controller;
  std::array<kinematics::ArmData, firmware::kMaxArms> data;
  std::vector<kinematics::TwoLinkArm<double>> arms;
  std::vector<Eigen::Vector3d> joints;
  Inputs inputs;
  Outputs outputs;
  std::int64_t count_at_home = 123456789;
  std::uint32_t counter_bits = 0xFFFFFFFF;  // 0xFFFF: a register of 16 bits
  std::vector<firmware::link::CanFrame>
      for_testers;              // answers that the testers (tester.h) have not taken yet
  bool halted = false;          // no tick comes
  std::uint64_t halted_us = 0;  // how long, altogether
  bool sampling = true;
  bool frozen = false;
  bool alive = true;
};

inline bool any_current(const Outputs& outputs) {
  for (const auto& arm : outputs.arm)
    for (const float current_A : arm.current_A)
      if (current_A != 0.0F) return true;
  return false;
}
inline bool any_enabled(const Outputs& outputs) { return outputs.arm[0].enable || outputs.arm[1].enable; }

}  // namespace thimble::test
