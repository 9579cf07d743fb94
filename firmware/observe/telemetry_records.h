// Telemetry for the link: one record every telemetry_decimation ticks, through a ring to the background. What happened in the ticks
// between two records is combined: every limiter that acted, the longest tick.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "control/scene/limits.h"
#include "firmware/exchange/ring.h"
#include "firmware/observe/telemetry.h"

namespace thimble::firmware {

class TelemetryRecords {
 public:
  static constexpr std::uint32_t kRecords = 8;  // that wait for the background

  // --- tick
  // Counts the tick. True: a record is due with it.
  [[nodiscard]] bool due(std::uint32_t decimation) noexcept {
    if (++since_record_ < decimation) return false;
    since_record_ = 0;
    return true;
  }
  // A record that finds the ring full is counted in telemetry.records_dropped.
  void add(Telemetry& telemetry, bool is_due) noexcept {
    for (std::size_t i = 0; i < telemetry.arm_count; ++i) limiters_[i] |= telemetry.arm[i].limiters;
    tick_us_ = std::max(tick_us_, telemetry.tick_us);
    if (!is_due) return;
    Telemetry* record = ring_.blank();
    if (record == nullptr) {
      ++telemetry.records_dropped;
      return;
    }
    *record = telemetry;
    record->tick_us = tick_us_;
    for (std::size_t i = 0; i < telemetry.arm_count; ++i) record->arm[i].limiters = limiters_[i];
    ring_.push();
    limiters_ = {};
    tick_us_ = 0;
  }

  // --- background
  [[nodiscard]] bool next(Telemetry& record) noexcept { return ring_.pop(record); }

 private:
  Ring<Telemetry, kRecords> ring_;
  std::uint32_t since_record_ = 0;
  std::array<std::uint8_t, control::kMaxArms> limiters_{};
  float tick_us_ = 0;
};

}  // namespace thimble::firmware
