// The arms that a board's store holds, for whom reads its configuration before there is a controller.
#pragma once

#include <filesystem>

#include "board/linux/board_config.h"

namespace thimble::board {

// The arms with which a controller with this store starts (firmware/store/arm_store.h). Only reads, also while a board works with the folder. None
// of a folder that cannot be read: the board and --check report that.
[[nodiscard]] StoredArms stored_arms(const std::filesystem::path& store);

}  // namespace thimble::board
