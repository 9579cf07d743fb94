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

}  // namespace thimble::board
