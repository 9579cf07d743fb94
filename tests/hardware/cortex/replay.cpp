#include "tests/hardware/cortex/replay.h"

#include <bit>

#include "board/common/work_units.h"
#include "firmware/params.h"

extern "C" {
[[gnu::noinline]] void tick_begin() { asm volatile(""); }
[[gnu::noinline]] void tick_end() { asm volatile(""); }
[[gnu::weak]] void before_tick() {}
[[gnu::weak]] void after_tick() {}
}

namespace thimble::test {

firmware::Config config_of(const Recording& recording) noexcept {
  firmware::Config config;
  config.period_s = recording.header.period_s;
  config.work_units = board::work_units(config.period_s, recording.header.arms);
  config.arm_count = static_cast<std::uint8_t>(recording.header.arms);
  for (std::size_t arm = 0; arm < recording.header.arms; ++arm) {
    config.arm[arm].model = recording.header.model.data();
    const auto& home_m = recording.header.home_m[arm];
    config.arm[arm].base.home_m = {home_m[0], home_m[1], home_m[2]};
  }
  return config;
}

ReplayEnd replay(const Recording& recording, firmware::Controller& controller, ForceSink sink) noexcept {
  const RecordingHeader& header = recording.header;
  if (controller.load_scene(recording.image) != firmware::StoreStatus::kOk) return ReplayEnd::kRefused;
  // A run that looks for the worst tick is faster than any hand.
  const firmware::ParamRow& speed =
      firmware::kParamTable[static_cast<std::size_t>(firmware::Param::max_tip_speed)];
  if (controller.write_param(speed.id, std::bit_cast<std::uint32_t>(speed.max)) != firmware::ParamStatus::kOk)
    return ReplayEnd::kRefused;
  firmware::Inputs inputs;
  inputs.dead_man = true;
  for (std::uint32_t tick = 0; tick < header.ticks; ++tick) {
    controller.keep_alive();
    if (tick == header.home_before && controller.request(firmware::Command::kHome) != 0)
      return ReplayEnd::kNotHomed;
    if (tick == header.arm_before && controller.request(firmware::Command::kArm) != 0)
      return ReplayEnd::kNotArmed;
    inputs.tick = tick;
    for (std::size_t arm = 0; arm < header.arms; ++arm) {
      for (std::size_t joint = 0; joint < 3; ++joint)
        inputs.arm[arm].counts[joint] = recording.count(tick, arm, joint);
      inputs.arm[arm].sample_tick = tick;
    }
    before_tick();
    tick_begin();
    static_cast<void>(controller.tick(inputs));
    tick_end();
    after_tick();
    const firmware::Telemetry& telemetry = controller.telemetry();
    std::array<float, 3 * control::kMaxArms> force_N{};
    for (std::size_t arm = 0; arm < header.arms; ++arm) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        force_N[3 * arm + axis] = telemetry.arm[arm].force_N[static_cast<Eigen::Index>(axis)];
    }
    sink(std::span(force_N).first(3 * header.arms));
    if (controller.fault() != firmware::Fault::kNone) return ReplayEnd::kFaulted;
  }
  return ReplayEnd::kDone;
}

}  // namespace thimble::test
