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

namespace {

constexpr std::size_t kPage = 4096;
std::size_t pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

}  // namespace

FileStorage::FileStorage(const std::filesystem::path& file, std::size_t scene_slot_bytes)
    : fd_(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  const auto fail = [&](const std::string& what) {
    if (fd_ >= 0) close(fd_);
    throw std::runtime_error("store " + file.string() + ": " + what);
  };
  for (unsigned i = 0; i < kSlots; ++i) begin_[i + 1] = begin_[i] + pages(slot_bytes(i, scene_slot_bytes));
  if (fd_ < 0) fail(std::strerror(errno));
  static_cast<void>(fchmod(fd_, 0600));  // of an older version: a key may be in it
  if (flock(fd_, LOCK_EX | LOCK_NB) != 0) fail("it is in use by another simulator");
  struct stat status {};
  if (fstat(fd_, &status) != 0) fail(std::strerror(errno));
  const auto wanted = static_cast<off_t>(begin_[kSlots]);
  // The files of older versions end before a pair of slots that did not exist then.
  bool known = status.st_size == 0;
  for (unsigned i = kSceneSlots; i <= kSlots; i += 2)
    known = known || status.st_size == static_cast<off_t>(begin_[i]);
  if (!known) fail("it is not a store of this simulator");
  if (ftruncate(fd_, wanted) != 0) fail(std::strerror(errno));
  void* map = mmap(nullptr, begin_[kSlots], PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
  if (map == MAP_FAILED) fail(std::strerror(errno));
  map_ = static_cast<std::byte*>(map);
}

FileStorage::~FileStorage() {
  munmap(map_, begin_[kSlots]);
  close(fd_);
}

std::span<const std::byte> FileStorage::slot(unsigned index) const noexcept {
  return {map_ + begin_[index], begin_[index + 1] - begin_[index]};
}

bool FileStorage::erase(unsigned index, std::size_t bytes) noexcept {
  if (index >= kSlots || bytes > slot(index).size()) return false;
  std::fill_n(map_ + begin_[index], bytes, std::byte{0xFF});  // like a flash
  return true;
}

bool FileStorage::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (index >= kSlots || offset > slot(index).size() || bytes.size() > slot(index).size() - offset)
    return false;
  std::ranges::copy(bytes, map_ + begin_[index] + offset);
  return true;
}

}  // namespace thimble::board
