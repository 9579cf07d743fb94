// What an embedded Linux board keeps over power-off: the slots in memory, where the tick reads them and no page fault waits,
// and each in a file of its own, read once at start. Background context.
//
// A slot reaches its file as a whole when its header comes, which the stores write last: into a new file, fsync, rename,
// fsync of the folder. Power may fail at any byte; a file is what it was or what it is to be.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "board/posix/descriptor.h"
#include "firmware/store/storage.h"

namespace thimble::board {

class SlotFiles final : public firmware::Storage {
 public:
  // folder: must exist and be writable; one board at a time. Throws std::system_error with the path, also when another
  // program holds the folder.
  SlotFiles(std::filesystem::path folder, std::size_t scene_slot_bytes);
  SlotFiles(const SlotFiles&) = delete;
  SlotFiles& operator=(const SlotFiles&) = delete;
  ~SlotFiles();

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  // False, too, where the file could not be written; the slot then has no header, and error() says why.
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

  [[nodiscard]] int error() const noexcept { return error_; }  // errno of the last failure

 private:
  struct Slot {
    const char* file = "";
    std::byte* memory = nullptr;  // a page that is never written takes no memory
    std::size_t bytes = 0;
    std::size_t used = 0;  // from its start that are written
  };
  [[nodiscard]] bool fits(unsigned index, std::size_t offset, std::size_t bytes) const noexcept;
  void load(Slot& slot) const;
  [[nodiscard]] bool save(const Slot& slot) noexcept;
  void unmap() noexcept;

  std::filesystem::path path_;
  Descriptor folder_;
  std::array<Slot, kSlots> slots_;
  int error_ = 0;
};

}  // namespace thimble::board
