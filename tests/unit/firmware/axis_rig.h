// An armed bench for the tests of orders for the axes: above the plane, the ramp done, moves allowed.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstddef>

#include "firmware/link/messages.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {

inline void write_param(Bench& bench, const char* name, std::uint32_t bits) {
  const firmware::ParamRow* row = firmware::find_param(name);
  ASSERT_NE(row, nullptr) << name;
  ASSERT_EQ(bench.controller->write_param(row->id, bits), firmware::ParamStatus::kOk) << name;
}
inline void write_param(Bench& bench, const char* name, float value) {
  write_param(bench, name, std::bit_cast<std::uint32_t>(value));
}

inline void arm_for_axes(Bench& bench) {
  write_param(bench, "allow_moves", 1U);
  bench.load(1000.0F, -0.01F);
  bench.home();
  bench.arm();
  bench.ticks(900);
}

// A torque of one axis for a while.
inline firmware::link::AxisOrder axis_torque(std::uint8_t axis, float torque_N_m, float driven_s = 0.1F) {
  firmware::link::AxisOrder order;
  order.axis = axis;
  order.driven_s = driven_s;
  order.offset_N_m = torque_N_m;
  order.most_torque_N_m.fill(10.0F);
  return order;
}

// All axes stay where they are.
inline firmware::link::AxisOrder axis_hold(const Bench& bench, float stiffness_N_m_rad,
                                           std::uint8_t arm = 0) {
  firmware::link::AxisOrder order = axis_torque(0, 0);
  order.arm = arm;
  order.hold = true;
  for (std::size_t j = 0; j < 3; ++j) {
    order.to_rad[j] = bench.shown().arm[arm].joint_rad[static_cast<int>(j)];
    order.stiffness_N_m_rad[j] = stiffness_N_m_rad;
  }
  return order;
}

// What the motor of an axis gives.
inline float given_N_m(const Bench& bench, std::size_t axis, std::size_t arm = 0) {
  return bench.outputs.arm[arm].current_A[axis] * bench.data[arm].axis[axis].torque_per_ampere();
}

inline firmware::link::AxisPhase axis_phase(const Bench& bench) {
  return bench.controller->axis_state().phase;
}
inline firmware::link::AxisEnd axis_end(const Bench& bench) { return bench.controller->axis_state().end; }

}  // namespace thimble::test
