// The slots in a file, so a simulated board keeps scenes and parameters between runs. Used by thimble-sim
// --store.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "firmware/store/storage.h"

namespace thimble::board {

class FileStorage final : public firmware::Storage {
 public:
  // Maps the file and creates it if it does not exist. The file is sparse: only written parts occupy space.
  // Throws std::runtime_error if it cannot be opened, is in use by another simulator, or has other slot
  // sizes.
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
