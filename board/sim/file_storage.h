// The slots in a file, so that a simulated board keeps scene and parameters from one run to the next. Used by
// thimble-sim --store.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "firmware/store/storage.h"

namespace thimble::board {

class FileStorage final : public firmware::Storage {
 public:
  // Maps the file, which is made when it is missing; it is sparse, so only what was written takes space.
  // Throws std::runtime_error when it cannot be opened, is held by another simulator, or belongs to other
  // slots.
  FileStorage(const std::filesystem::path& file, std::size_t scene_slot_bytes);
  FileStorage(const FileStorage&) = delete;
  FileStorage& operator=(const FileStorage&) = delete;
  ~FileStorage();

  [[nodiscard]] std::span<const std::byte> slot(unsigned index) const noexcept override;
  [[nodiscard]] bool erase(unsigned index, std::size_t bytes) noexcept override;
  [[nodiscard]] bool write(unsigned index, std::size_t offset,
                           std::span<const std::byte> bytes) noexcept override;

 private:
  // Slot i of the file: from begin_[i] to begin_[i + 1].
  std::array<std::size_t, kSlots + 1> begin_{};
  int fd_;
  std::byte* map_ = nullptr;
};

}  // namespace thimble::board
