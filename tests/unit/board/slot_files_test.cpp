// The slots in files: the contract of Storage, and power failures at every byte of a save.
#include "board/linux/slot_files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <system_error>

#include "board/linux/stored_arms.h"
#include "firmware/store/audit_log.h"
#include "firmware/store/journal.h"
#include "firmware/store/key_store.h"
#include "firmware/store/param_store.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/slot_header.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/paddle_image.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using board::SlotFiles;
using firmware::crc32;
using firmware::SceneStore;
using firmware::StoreStatus;

constexpr std::size_t kSlotBytes = 8192;

class SlotFilesTest : public ::testing::Test {
 protected:
  static StoreStatus upload(SceneStore& store, const std::vector<std::byte>& image) {
    control::SceneView view;
    StoreStatus status = store.begin(image.size(), crc32(image));
    for (std::size_t at = 0; status == StoreStatus::kOk && at < image.size(); at += 64)
      status = store.write(at, std::span(image).subspan(at, std::min<std::size_t>(64, image.size() - at)));
    if (status == StoreStatus::kOk) status = store.verify();
    if (status == StoreStatus::kOk) status = store.commit(view);
    return status;
  }
  // The CRC of the scene that a start from these files gives; 0: none.
  std::uint32_t start() const {
    SlotFiles files(folder_.path(), kSlotBytes);
    SceneStore store(files);
    control::SceneView view;
    return store.open(view) == StoreStatus::kOk ? store.image_crc() : 0;
  }
  void put(const std::vector<std::byte>& image) const {
    SlotFiles files(folder_.path(), kSlotBytes);
    SceneStore store(files);
    control::SceneView view;
    (void)store.open(view);
    ASSERT_EQ(upload(store, image), StoreStatus::kOk);
  }

  TemporaryFolder folder_;
};

TEST_F(SlotFilesTest, KeepsTheNewestOverRestarts) {
  EXPECT_EQ(start(), 0U);
  for (const float stiffness : {100.0F, 200.0F, 300.0F, 400.0F}) {
    put(plane_image(stiffness));
    EXPECT_EQ(start(), crc32(plane_image(stiffness)));
  }
  EXPECT_TRUE(fs::exists(folder_.path() / "scene0"));
  EXPECT_TRUE(fs::exists(folder_.path() / "scene1"));
}

TEST_F(SlotFilesTest, TheArmOfTheNextStartIsKnownToTheConfiguration) {
  EXPECT_FALSE(board::stored_arms(folder_.path())[0].has_value());
  EXPECT_FALSE(board::stored_arms(folder_.path() / "nowhere")[0].has_value());
  for (const char* name : {"first", "second"}) {
    {
      SlotFiles files(folder_.path(), board::kSceneSlotBytes);
      firmware::ArmStore arms(files);
      ASSERT_EQ(test::upload(arms, 1, paddle_image(name)), StoreStatus::kOk);
    }
    const board::StoredArms arms = board::stored_arms(folder_.path());
    EXPECT_FALSE(arms[0].has_value());
    ASSERT_TRUE(arms[1].has_value());
    EXPECT_EQ(kinematics::name_of(*arms[1]), name);
    EXPECT_EQ(axes_of(arms[1]->geometry), 1);
  }
  // Also while a board works with them, and has locked them: for --check and --uses.
  const SlotFiles in_use(folder_.path(), kSlotBytes);
  EXPECT_TRUE(board::stored_arms(folder_.path())[1].has_value());
}

TEST_F(SlotFilesTest, SlotsStayWhereTheyAre) {
  SlotFiles files(folder_.path(), kSlotBytes);
  SceneStore store(files);
  const std::byte* const first = files.slot(0).data();
  EXPECT_EQ(files.slot(0).size(), files.slot(1).size());
  EXPECT_GE(files.slot(0).size(), kSlotBytes);
  ASSERT_EQ(upload(store, plane_image(100.0F)), StoreStatus::kOk);
  ASSERT_EQ(upload(store, plane_image(200.0F)), StoreStatus::kOk);
  EXPECT_EQ(files.slot(0).data(), first);
  EXPECT_FALSE(files.erase(0, kSlotBytes + 4096));
  EXPECT_FALSE(files.erase(SlotFiles::kSlots, 1));
  EXPECT_FALSE(files.write(0, kSlotBytes, std::array<std::byte, 1>{}));
}

// Record by record; a record that the process has written is there after its end, and the file has its full size from the start.
TEST_F(SlotFilesTest, KeepsTheJournal) {
  for (std::uint32_t number = 1; number < 200; ++number) {
    SlotFiles files(folder_.path(), kSlotBytes);
    firmware::Journal journal(files);
    const auto found = journal.open();
    ASSERT_EQ(found.has_value(), number != 1);
    if (found) {
      EXPECT_EQ(found->utc_s, number - 1);
    }
    firmware::JournalRecord record;
    record.utc_s = number;
    ASSERT_TRUE(journal.append(record));
    EXPECT_EQ(fs::file_size(folder_.path() / "journal0"), SlotFiles::kJournalSlotBytes);
    EXPECT_EQ(fs::file_size(folder_.path() / "journal1"), SlotFiles::kJournalSlotBytes);
  }
}

// What was replaced, or removed, is not on the disk any more, and nobody else reads what is.
TEST_F(SlotFilesTest, KeepsOneKeyOnly) {
  using firmware::link::KeyState;
  for (std::uint8_t number = 1; number < 6; ++number) {
    SlotFiles files(folder_.path(), kSlotBytes);
    firmware::KeyStore store(files);
    store.open();
    EXPECT_EQ(store.state(), number == 1 ? KeyState::kNone : KeyState::kSet);
    firmware::link::Key key;
    key.fill(number);
    ASSERT_EQ(store.set(key), firmware::StoreStatus::kOk);
    std::size_t found = 0;
    for (const fs::directory_entry& file : fs::directory_iterator(folder_.path())) {
      std::ifstream in(file.path(), std::ios::binary);
      const std::string all(std::istreambuf_iterator<char>(in), {});
      for (char old = 1; old < number; ++old) EXPECT_EQ(all.find(std::string(32, old)), std::string::npos);
      if (all.find(std::string(32, static_cast<char>(number))) == std::string::npos) continue;
      ++found;
      EXPECT_EQ(fs::status(file).permissions() & ~(fs::perms::owner_read | fs::perms::owner_write),
                fs::perms::none);
    }
    EXPECT_EQ(found, 1U);
  }
}

// Also in a folder of an older version, which has no files for it.
TEST_F(SlotFilesTest, KeepsTheAuditRecord) {
  put(plane_image(100.0F));
  for (const char* file : {"audit0", "audit1"}) fs::remove(folder_.path() / file);
  for (std::uint32_t number = 1; number < 200; ++number) {
    SlotFiles files(folder_.path(), kSlotBytes);
    firmware::AuditLog log(files);
    log.open(static_cast<std::uint16_t>(number));
    firmware::link::AuditRecord event;
    event.event = firmware::link::AuditEvent::kFault;
    event.value = number;
    log.add(std::move(event), {0, 1000});
    std::array<std::uint8_t, firmware::link::kMaxPduBytes> bytes;
    firmware::link::ByteWriter out(bytes);
    log.read(0, out);
    firmware::link::AuditRecord oldest;
    ASSERT_TRUE(firmware::link::decode(std::span<const std::uint8_t>(bytes).first(out.size()), oldest));
    EXPECT_EQ(oldest.value, oldest.number);
    ASSERT_LE(number - oldest.number, 128U);
    ASSERT_GE(number - oldest.number, number <= 128 ? 0U : 56U);
    EXPECT_EQ(fs::file_size(folder_.path() / "audit0"), SlotFiles::kAuditSlotBytes);
    EXPECT_EQ(fs::file_size(folder_.path() / "audit1"), SlotFiles::kAuditSlotBytes);
  }
  SlotFiles files(folder_.path(), kSlotBytes);
  SceneStore store(files);
  control::SceneView view;
  EXPECT_EQ(store.open(view), StoreStatus::kOk);
}

TEST_F(SlotFilesTest, KeepsParameters) {
  for (const float most_N : {3.0F, 4.0F, 5.0F}) {
    SlotFiles files(folder_.path(), kSlotBytes);
    firmware::ParamStore store(files);
    firmware::Params params;
    store.load(params);
    if (most_N > 3.0F) {
      EXPECT_EQ(params.get(firmware::Param::max_force), most_N - 1.0F);
    }
    ASSERT_EQ(params.write(firmware::kParamTable[static_cast<std::size_t>(firmware::Param::max_force)].id,
                           std::bit_cast<std::uint32_t>(most_N), true),
              firmware::ParamStatus::kOk);
    EXPECT_EQ(store.save(params), StoreStatus::kOk);
  }
}

// The kernel cuts a save short after every single byte (a full disk, power: the same to the file that was
// there).
TEST_F(SlotFilesTest, ASaveThatFailsAtAnyByteLeavesTheOldScene) {
  const std::vector<std::byte> old_scene = plane_image(100.0F), new_scene = plane_image(200.0F);
  put(old_scene);
  const std::size_t bytes = firmware::kSlotHeaderBytes + new_scene.size();
  int refused = 0;
  for (std::size_t limit = 0; limit <= bytes; ++limit) {
    const pid_t board = fork();  // the limit is the process's
    if (board == 0) {
      signal(SIGXFSZ, SIG_IGN);
      SlotFiles files(folder_.path(), kSlotBytes);
      SceneStore store(files);
      control::SceneView view;
      if (store.open(view) != StoreStatus::kOk) _exit(2);
      const rlimit most{limit, limit};
      if (setrlimit(RLIMIT_FSIZE, &most) != 0) _exit(3);
      const StoreStatus status = upload(store, new_scene);
      // The store goes on with the scene it had, and its slot has no header.
      if (status == StoreStatus::kStorage &&
          (files.error() != EFBIG || store.image_crc() != crc32(old_scene)))
        _exit(4);
      _exit(status == StoreStatus::kOk ? 0 : status == StoreStatus::kStorage ? 1 : 5);
    }
    int status = 0;
    ASSERT_EQ(waitpid(board, &status, 0), board);
    ASSERT_TRUE(WIFEXITED(status));
    ASSERT_LE(WEXITSTATUS(status), 1) << limit;
    const bool saved = WEXITSTATUS(status) == 0;
    EXPECT_EQ(saved, limit == bytes) << limit;
    ASSERT_EQ(start(), crc32(saved ? new_scene : old_scene)) << "cut after byte " << limit;
    refused += saved ? 0 : 1;
  }
  EXPECT_EQ(refused, static_cast<int>(bytes));
}

// Power fails before the rename: what stands in the new file, to any length, is never looked at, and is gone.
TEST_F(SlotFilesTest, WhatAPowerFailureLeftIsCleared) {
  const std::vector<std::byte> old_scene = plane_image(100.0F);
  put(old_scene);
  const fs::path left = folder_.path() / "new";
  for (const std::size_t bytes :
       {std::size_t{0}, std::size_t{1}, firmware::kSlotHeaderBytes, old_scene.size()}) {
    std::ofstream(left) << std::string(bytes, 'x');
    EXPECT_EQ(start(), crc32(old_scene));
    EXPECT_FALSE(fs::exists(left));
  }
}

// A file system that flipped a byte in spite of fsync, or lost the file's tail: the other slot's scene is
// there.
TEST_F(SlotFilesTest, ADamagedFileIsNotTaken) {
  put(plane_image(100.0F));
  put(plane_image(200.0F));
  const fs::path newest = folder_.path() / "scene1";
  std::ifstream in(newest, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  for (std::size_t at = 0; at < whole.size(); ++at) {
    // Between the header's 24 bytes and the image, at 64, nothing is looked at.
    if (at >= 24 && at < firmware::kSlotHeaderBytes) continue;
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    std::ofstream(newest, std::ios::binary) << damaged;
    ASSERT_EQ(start(), crc32(plane_image(100.0F))) << at;
  }
  std::ofstream(newest, std::ios::binary) << whole.substr(0, whole.size() / 2);
  EXPECT_EQ(start(), crc32(plane_image(100.0F)));
  std::ofstream(newest, std::ios::binary) << whole;
  EXPECT_EQ(start(), crc32(plane_image(200.0F)));
}

TEST_F(SlotFilesTest, OneBoardAtATime) {
  const SlotFiles files(folder_.path(), kSlotBytes);
  EXPECT_THROW(SlotFiles(folder_.path(), kSlotBytes), std::system_error);
}

// `thimble-board --check` may be run by another user, whose files the board could not open.
TEST_F(SlotFilesTest, ALookChangesNothing) {
  std::ofstream(folder_.path() / "new") << "left by a power failure";
  std::ofstream(folder_.path() / "audit1") << "short";
  const auto files = [this] {
    std::map<std::string, std::uintmax_t> sizes;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      sizes[entry.path().filename()] = entry.file_size();
    return sizes;
  };
  const auto before = files();
  SlotFiles looked(folder_.path(), kSlotBytes, SlotFiles::Access::kLook);
  EXPECT_EQ(std::to_integer<char>(looked.slot(7)[0]), 's');
  const std::byte byte{1};
  for (unsigned slot = 0; slot < SlotFiles::kSlots; ++slot)
    EXPECT_FALSE(looked.erase(slot, 1) || looked.write(slot, 0, {&byte, 1})) << slot;
  EXPECT_EQ(files(), before);
}

TEST_F(SlotFilesTest, AFileOfAnotherUserIsNamedWithItsOwner) {
  constexpr uid_t kNobody = 65534;
  const fs::path file = folder_.path() / "journal0";
  std::ofstream(file) << "of another user";
  fs::permissions(file, fs::perms::none);
  fs::permissions(folder_.path(), fs::perms::all);
  for (const auto access : {SlotFiles::Access::kWrite, SlotFiles::Access::kLook}) {
    std::string told = "nothing";
    int error = 0;
    const bool root = geteuid() == 0;  // who may open any file
    ASSERT_EQ(seteuid(root ? kNobody : geteuid()), 0);
    try {
      const SlotFiles files(folder_.path(), kSlotBytes, access);
    } catch (const std::system_error& failed) {
      told = failed.what();
      error = failed.code().value();
    }
    ASSERT_EQ(seteuid(root ? 0 : geteuid()), 0);
    EXPECT_TRUE(told.starts_with(file.string() + ", which belongs to the user ")) << told;
    EXPECT_TRUE(told.ends_with(": Permission denied")) << told;
    EXPECT_NE(
        board::remedy_for_store(folder_.path(), error).find("chown -R thimble: " + folder_.path().string()),
        std::string::npos);
  }
}

TEST_F(SlotFilesTest, AMissingFolderIsNamed) {
  try {
    const SlotFiles files(folder_.path() / "nowhere", kSlotBytes);
    FAIL() << "there is no such folder";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("nowhere"), std::string::npos);
    EXPECT_EQ(error.code().value(), ENOENT);
  }
}

}  // namespace
}  // namespace thimble::test
