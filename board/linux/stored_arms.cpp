#include "board/linux/stored_arms.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <span>
#include <vector>

#include "board/linux/slot_files.h"
#include "board/posix/descriptor.h"
#include "firmware/arm/arm_image.h"
#include "firmware/store/arm_store.h"

namespace thimble::board {
namespace {

// The slots of the arms alone, and only to be read: SlotFiles is for the one board that the folder belongs to.
class ArmFiles final : public firmware::Storage {
 public:
  explicit ArmFiles(const std::filesystem::path& store) {
    for (unsigned i = kFirstArmSlot; i < kSlots; ++i) {
      std::vector<std::byte>& bytes = slots_[i - kFirstArmSlot];
      bytes.resize(kArmSlotBytes);
      const Descriptor file(::open((store / SlotFiles::kFiles[i]).c_str(), O_RDONLY | O_CLOEXEC));
      std::size_t used = 0;
      while (file.is_open() && used < bytes.size()) {
        const ssize_t got = ::read(file.get(), bytes.data() + used, bytes.size() - used);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        used += static_cast<std::size_t>(got);
      }
    }
  }
  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override {
    if (index < kFirstArmSlot || index >= kSlots) return {};
    return slots_[index - kFirstArmSlot];
  }
  [[nodiscard]] bool erase(unsigned, std::size_t) noexcept override { return false; }
  [[nodiscard]] bool write(unsigned, std::size_t, std::span<const std::byte>) noexcept override {
    return false;
  }

 private:
  std::array<std::vector<std::byte>, kSlots - kFirstArmSlot> slots_;
};

}  // namespace

StoredArms stored_arms(const std::filesystem::path& store) {
  StoredArms arms;
  ArmFiles files(store);
  const firmware::ArmStore images(files);
  for (std::size_t i = 0; i < arms.size(); ++i) {
    kinematics::ArmData arm;
    if (firmware::read_arm_image(images.image(i), arm) == firmware::ArmStatus::kOk) arms[i] = arm;
  }
  return arms;
}

}  // namespace thimble::board
