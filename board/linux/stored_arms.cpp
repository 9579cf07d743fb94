#include "board/linux/stored_arms.h"

#include <system_error>

#include "board/linux/slot_files.h"
#include "firmware/arm/arm_image.h"
#include "firmware/store/arm_store.h"

namespace thimble::board {

StoredArms stored_arms(const std::filesystem::path& store) {
  StoredArms arms;
  try {
    SlotFiles files(store, kSceneSlotBytes);
    const firmware::ArmStore images(files);
    for (std::size_t i = 0; i < arms.size(); ++i) {
      kinematics::ArmData arm;
      if (firmware::read_arm_image(images.image(i), arm) == firmware::ArmStatus::kOk) arms[i] = arm;
    }
  } catch (const std::system_error&) {
  }
  return arms;
}

}  // namespace thimble::board
