// Non-volatile storage of an embedded Linux board: the slots are in memory, where the tick reads them without
// page faults, and each slot has a file, which is read once at start. Background context.
//
// A slot is written to its file as a whole when its header is written, which the stores do last: new file,
// fsync, rename, fsync of the folder. Power may fail at any byte: the file then has either the old or the new
// content. The slots of records (journal, audit) are written in place, record by record, and the kernel starts to write them to the disk at once; the
// background does not wait for the disk, because it would delay the link every few seconds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "board/posix/descriptor.h"
#include "control/scene/limits.h"
#include "firmware/store/slot_header.h"
#include "firmware/store/storage.h"

namespace thimble::board {

inline constexpr std::size_t kSceneSlotBytes = control::kMaxImageBytes + firmware::kSlotHeaderBytes;

class SlotFiles final : public firmware::Storage {
 public:
  static constexpr std::array<const char*, kSlots> kFiles = {
      "scene0", "scene1", "params0", "params1", "journal0", "journal1", "audit0",
      "audit1", "key0",   "key1",    "arm0a",   "arm0b",    "arm1a",    "arm1b"};

  // folder: must exist and be writable; one board at a time. Throws std::system_error with the path, also if
  // another program uses the folder. kLook: as far as it goes without a change of the folder; nothing can be written.
  enum class Access : std::uint8_t { kWrite, kLook };
  SlotFiles(std::filesystem::path folder, std::size_t scene_slot_bytes, Access access = Access::kWrite);
  SlotFiles(const SlotFiles&) = delete;
  SlotFiles& operator=(const SlotFiles&) = delete;
  ~SlotFiles();

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  // Also false if the file could not be written; the slot then has no header, and error() gives the cause.
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

  [[nodiscard]] int error() const noexcept { return error_; }  // errno of the last failure

 private:
  struct Slot {
    const char* file = "";
    Descriptor open;              // of a slot that is written in place
    std::byte* memory = nullptr;  // pages that are never written occupy no memory
    std::size_t bytes = 0;
    std::size_t used = 0;  // number of written bytes from the start
  };
  [[nodiscard]] bool fits(unsigned index, std::size_t offset, std::size_t bytes) const noexcept;
  void load(Slot& slot) const;
  void open_in_place(Slot& slot) const;
  [[nodiscard]] bool write_in_place(const Slot& slot, std::size_t offset, std::size_t bytes) noexcept;
  [[nodiscard]] bool save(const Slot& slot) noexcept;
  void unmap() noexcept;

  std::filesystem::path path_;
  Descriptor folder_;
  bool looks_ = false;
  std::array<Slot, kSlots> slots_;
  int error_ = 0;
};

// What to do after the error of SlotFiles(folder). error: its errno.
[[nodiscard]] std::string remedy_for_store(const std::filesystem::path& folder, int error);

}  // namespace thimble::board
