// The arms that a board's store holds, for whom reads its configuration before there is a controller.
#pragma once

#include <filesystem>

#include "board/linux/board_config.h"

namespace thimble::board {

// The arms with which a controller with this store starts (firmware/store/arm_store.h). None of a folder that cannot be used: the board and
// --check report that.
[[nodiscard]] StoredArms stored_arms(const std::filesystem::path& store);

}  // namespace thimble::board
