// Whether the configuration names a device: for the udev rule, which gives the board's group no other one.
#pragma once

#include <filesystem>

#include "board/linux/board_config.h"

namespace thimble::board {

// device: "/dev/spidev0.0", "/dev/gpiochip0" (by the names of its lines), "/dev/counter0", ...
[[nodiscard]] bool names_device(const BoardConfig& config, const std::filesystem::path& device);

}  // namespace thimble::board
