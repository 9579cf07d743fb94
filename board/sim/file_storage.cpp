#include "board/sim/file_storage.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace thimble::board {

FileStorage::FileStorage(const std::filesystem::path& file, std::size_t slot_bytes)
    : slot_bytes_((slot_bytes + 4095) / 4096 * 4096),
      fd_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  const auto fail = [&](const std::string& what) {
    if (fd_ >= 0) close(fd_);
    throw std::runtime_error("store " + file.string() + ": " + what);
  };
  if (fd_ < 0) fail(std::strerror(errno));
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) fail("another simulator uses it");
  struct stat status {};
  if (fstat(fd_, &status) != 0) fail(std::strerror(errno));
  const auto wanted = static_cast<off_t>(size());
  if (status.st_size != 0 && status.st_size != wanted) fail("it is not a store of this simulator");
  if (ftruncate(fd_, wanted) != 0) fail(std::strerror(errno));
  void* map = mmap(nullptr, size(), PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
  if (map == MAP_FAILED) fail(std::strerror(errno));
  map_ = static_cast<std::byte*>(map);
}

FileStorage::~FileStorage() {
  munmap(map_, size());
  close(fd_);
}

std::span<const std::byte> FileStorage::slot(unsigned index) const noexcept {
  return {map_ + index * slot_bytes_, slot_bytes_};
}

bool FileStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (index >= kSlots || bytes > slot_bytes_) return false;
  std::fill_n(map_ + index * slot_bytes_, bytes, std::byte{0xFF});  // as a flash does
  return true;
}

bool FileStorage::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (index >= kSlots || offset > slot_bytes_ || bytes.size() > slot_bytes_ - offset) return false;
  std::ranges::copy(bytes, map_ + index * slot_bytes_ + offset);
  return true;
}

}  // namespace thimble::board
