// The time-out of the stop path by the saved parameters, for a board that sets it at start.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/core/stop_timeout.h"
#include "firmware/params.h"
#include "firmware/store/param_store.h"
#include "firmware/store/storage.h"

namespace thimble::board {

// The parameter lost_ticks as the controller will begin with it.
[[nodiscard]] inline std::uint32_t saved_lost_ticks(firmware::Storage& storage) noexcept {
  firmware::Params params;
  firmware::ParamStore(storage).load(params);
  return params.get_unsigned(firmware::Param::lost_ticks);
}

struct StopPath {
  std::uint32_t timeout_us;
  const char* lacks;  // part of Config::lacks; empty: nothing
};
[[nodiscard]] inline StopPath saved_stop_path(firmware::Storage& storage, std::uint32_t rate_Hz) noexcept {
  const auto wanted_us = firmware::stop_timeout_us(1'000'000'000 / rate_Hz, saved_lost_ticks(storage));
  if (wanted_us) return {*wanted_us, ""};
  return {firmware::kShortestStop_us, firmware::kLacksShortStop};
}

}  // namespace thimble::board
