#include "board/linux/slot_files.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "board/linux/open_file.h"
#include "firmware/store/slot_header.h"

namespace thimble::board {
namespace {

constexpr const char* kNewFile = "new";

[[noreturn]] void fail_with(int error, const std::filesystem::path& path) {
  std::string what = path.string();
  if (struct stat file{}; error == EACCES && stat(path.c_str(), &file) == 0) {
    const passwd* owner = getpwuid(file.st_uid);
    what += ", which belongs to the user " +
            (owner == nullptr ? std::to_string(file.st_uid) : std::string(owner->pw_name));
  }
  throw std::system_error(error, std::generic_category(), what);
}

// Writes all bytes, also after interruptions.
bool write_all(int fd, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t put = ::write(fd, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return true;
}

}  // namespace

SlotFiles::SlotFiles(std::filesystem::path folder, std::size_t scene_slot_bytes, Access access)
    : path_(std::move(folder)),
      folder_(open_file(path_, O_RDONLY | O_DIRECTORY)),
      looks_(access == Access::kLook) {
  if (flock(folder_.get(), LOCK_EX | LOCK_NB) != 0) fail_with(errno, path_);
  if (faccessat(folder_.get(), ".", W_OK, 0) != 0) fail_with(errno, path_);
  if (!looks_) (void)unlinkat(folder_.get(), kNewFile, 0);  // left behind by a power failure
  try {
    for (unsigned i = 0; i < kSlots; ++i) {
      slots_[i].file = kFiles[i];
      slots_[i].bytes = slot_bytes(i, scene_slot_bytes);
      void* map = mmap(nullptr, slots_[i].bytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
      if (map == MAP_FAILED) fail_with(errno, path_ / slots_[i].file);
      slots_[i].memory = static_cast<std::byte*>(map);
      load(slots_[i]);
      if (holds_records(i)) open_in_place(slots_[i]);
    }
  } catch (...) {
    unmap();
    throw;
  }
}

SlotFiles::~SlotFiles() { unmap(); }

void SlotFiles::unmap() noexcept {
  for (const Slot& slot : slots_)
    if (slot.memory != nullptr) munmap(slot.memory, slot.bytes);
}

// A file with a wrong length is refused by the stores: the header contains length and CRC.
void SlotFiles::load(Slot& slot) const {
  const Descriptor file(openat(folder_.get(), slot.file, O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) {
    if (errno == ENOENT) return;
    fail_with(errno, path_ / slot.file);
  }
  while (slot.used < slot.bytes) {
    const ssize_t got = ::read(file.get(), slot.memory + slot.used, slot.bytes - slot.used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_with(errno, path_ / slot.file);
    if (got == 0) return;
    slot.used += static_cast<std::size_t>(got);
  }
}

// With all its bytes, so that no later write has to find room on the disk.
void SlotFiles::open_in_place(Slot& slot) const {
  slot.open = Descriptor(openat(folder_.get(), slot.file, O_RDWR | O_CLOEXEC | (looks_ ? 0 : O_CREAT), 0600));
  if (!slot.open.is_open() && !(looks_ && errno == ENOENT)) fail_with(errno, path_ / slot.file);
  if (looks_ || slot.used == slot.bytes) return;
  std::fill(slot.memory + slot.used, slot.memory + slot.bytes, std::byte{0xFF});
  slot.used = slot.bytes;
  if (!write_all(slot.open.get(), {slot.memory, slot.bytes}) || fsync(slot.open.get()) != 0 ||
      fsync(folder_.get()) != 0)
    fail_with(errno, path_ / slot.file);
}

bool SlotFiles::write_in_place(const Slot& slot, std::size_t offset, std::size_t bytes) noexcept {
  const int file = slot.open.get();
  const auto at = static_cast<off_t>(offset);
  if (lseek(file, at, SEEK_SET) == at && write_all(file, {slot.memory + offset, bytes}) &&
      sync_file_range(file, at, static_cast<off_t>(bytes), SYNC_FILE_RANGE_WRITE) == 0)
    return true;
  error_ = errno;
  return false;
}

bool SlotFiles::fits(unsigned index, std::size_t offset, std::size_t bytes) const noexcept {
  return index < kSlots && offset <= slots_[index].bytes && bytes <= slots_[index].bytes - offset;
}

std::span<const std::byte> SlotFiles::slot(unsigned index) const noexcept {
  return {slots_[index].memory, slots_[index].bytes};
}

// Changes only the memory: the file stays until the slot is complete again. A store never selects this file
// as the newest one, because the other slot is newer. But a key that was replaced must not come back, nor a damaged
// image of an arm.
bool SlotFiles::erase(unsigned index, std::size_t bytes) noexcept {
  if (looks_ || !fits(index, 0, bytes)) return false;
  Slot& slot = slots_[index];
  std::fill_n(slot.memory, std::max(bytes, slot.used), std::byte{0xFF});
  if (slot.open.is_open()) return write_in_place(slot, 0, bytes);
  slot.used = 0;
  if (index < kFirstKeySlot || unlinkat(folder_.get(), slot.file, 0) == 0 || errno == ENOENT) return true;
  error_ = errno;
  return false;
}

bool SlotFiles::write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept {
  if (looks_ || !fits(index, offset, bytes.size())) return false;
  Slot& slot = slots_[index];
  std::copy(bytes.begin(), bytes.end(), slot.memory + offset);
  if (slot.open.is_open()) return write_in_place(slot, offset, bytes.size());
  slot.used = std::max(slot.used, offset + bytes.size());
  if (offset >= firmware::kSlotHeaderBytes || save(slot)) return true;
  std::fill_n(slot.memory, firmware::kSlotHeaderBytes, std::byte{0xFF});
  return false;
}

bool SlotFiles::save(const Slot& slot) noexcept {
  const Descriptor file(openat(folder_.get(), kNewFile, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  if (file.is_open() && write_all(file.get(), {slot.memory, slot.used}) && fsync(file.get()) == 0 &&
      renameat(folder_.get(), kNewFile, folder_.get(), slot.file) == 0 && fsync(folder_.get()) == 0)
    return true;
  error_ = errno;
  (void)unlinkat(folder_.get(), kNewFile, 0);
  return false;
}

std::string remedy_for_store(const std::filesystem::path& folder, int error) {
  switch (error) {
    case EWOULDBLOCK:
      return "end the thimble-board that uses the folder (sudo systemctl stop thimble-board)";
    case EACCES:
    case EPERM:
      return "run it as the board's user (sudo -u thimble), who must own the folder and its files: sudo "
             "chown -R thimble: " +
             folder.string();
    case ENOENT:
    case ENOTDIR:
      return "make the folder, for the board's user to write";
    default:
      return "see the kernel's log (dmesg)";
  }
}

}  // namespace thimble::board
