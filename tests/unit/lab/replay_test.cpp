// Replays: of every scene of the repository, after a controller has felt something else, each force comes out again to the bit; and what
// is not so is found.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>

#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/services.h"
#include "host-tools/client/device.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "host-tools/lab/recorder.h"
#include "host-tools/lab/replay_recording.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using board::SimBoard;
using firmware::Command;

// The simulated board, its frames, and the services asked as a host asks them.
class RecordedBoard {
 public:
  explicit RecordedBoard(const board::SimBoardOptions& options)
      : board(options), recorder_(1, options.arm_count) {}

  void tick() {
    board.controller().keep_alive();
    board.tick();
    time_us_ += 250;
    board.controller().poll(time_us_);
    link::CanFrame frame;
    while (board.controller().next_frame(frame, time_us_)) {
      if (frame.extended) {
        static_cast<void>(channel_.on_frame(frame, time_us_));
      } else {
        recorder_.take(frame, static_cast<std::uint32_t>(time_us_));
      }
    }
  }
  void seconds(double s) {
    for (int i = 0; i < static_cast<int>(s * 4000); ++i) tick();
  }
  bool until(firmware::Mode mode) {
    for (int i = 0; i < 40'000 && board.controller().mode() != mode; ++i) tick();
    return board.controller().mode() == mode;
  }
  std::vector<std::uint8_t> ask(const std::vector<std::uint8_t>& request) {
    EXPECT_TRUE(channel_.send(request, time_us_));
    for (int i = 0; i < 4000; ++i) {
      link::CanFrame frame;
      while (channel_.next_frame(frame, time_us_)) board.controller().on_frame(frame, time_us_);
      tick();
      const std::span<const std::uint8_t> received = channel_.received();
      if (received.empty()) continue;
      std::vector<std::uint8_t> answer(received.begin(), received.end());
      channel_.release();
      if (answer.size() == 3 && answer[2] == 0x78) continue;
      return answer;
    }
    ADD_FAILURE() << "no answer";
    return {0};
  }

  // Starts a recording: what its recording begins with.
  host::Recording start(std::span<const std::byte> scene) {
    host::Recording recording;
    EXPECT_EQ(ask({0x10, 0x03})[0], 0x50);
    EXPECT_EQ(ask({0x31, 0x01, 0x02, 0x08})[0], 0x71);
    const std::vector<std::uint8_t> answer = ask({0x31, 0x03, 0x02, 0x08});
    host::RecordingHeader& header = recording.header;
    std::span<const std::uint8_t> rest = std::span(answer).subspan(4);
    EXPECT_TRUE(link::decode(rest, header.start));
    rest = rest.subspan(link::wire_size<link::RecordingStart>());
    header.arms.resize(header.start.arms);
    for (link::RecordingArm& arm : header.arms) {
      EXPECT_TRUE(link::decode(rest, arm));
      rest = rest.subspan(link::wire_size<link::RecordingArm>());
    }
    header.models.assign(header.arms.size(), "premium-1.5");
    header.scene.assign(scene.begin(), scene.end());
    header.scene_crc = host::crc32(scene);
    EXPECT_EQ(header.start.scene_crc, header.scene_crc);
    for (const firmware::ParamRow& row : firmware::kParamTable) {
      std::uint32_t bits = 0;
      EXPECT_EQ(board.controller().read_param(row.id, bits), firmware::ParamStatus::kOk);
      header.parameters.emplace_back(row.id, bits);
    }
    recorder_.begin(header.start);
    return recording;
  }

  // What has come since the start, through the file's bytes.
  host::Recording finish(const host::Recording& begun) {
    std::ostringstream out;
    host::write_header(out, begun.header);
    recorder_.write(out);
    const std::string bytes = out.str();
    return host::parse_recording(std::as_bytes(std::span(bytes)), "file");
  }

  SimBoard board;

 private:
  host::Recorder recorder_;
  link::IsoTpChannel channel_{link::request_id(1), link::response_id(1), link::IsoTpConfig{}};
  link::Micros time_us_ = 1'000'000;
};

std::vector<std::byte> image_of(const fs::path& scene) { return host::compile_scene(scene).image; }

// Arms, lets the hand feel, disarms in the middle of it and arms again.
host::Recording felt(const fs::path& folder, const std::vector<std::byte>& before, double seconds) {
  const std::vector<board::PathPoint> points = board::read_hand_path(folder / "stroke.csv");
  board::SimBoardOptions options;
  options.arm_count =
      std::ranges::any_of(points, [](const board::PathPoint& point) { return point.arm == 1; }) ? 2 : 1;
  RecordedBoard recorded(options);
  firmware::Controller& controller = recorded.board.controller();
  for (int arm = 0; arm < options.arm_count; ++arm) {
    std::vector<board::PathPoint> own;
    std::ranges::copy_if(points, std::back_inserter(own),
                         [arm](const board::PathPoint& point) { return point.arm == arm; });
    recorded.board.follow(static_cast<std::size_t>(arm), board::HandPath(std::move(own)), true);
  }
  // Something else is felt first: heat, counts, a scene's memory.
  EXPECT_EQ(controller.load_scene(before), firmware::StoreStatus::kOk);
  recorded.seconds(0.01);
  EXPECT_EQ(controller.request(Command::kHome), 0U);
  EXPECT_TRUE(recorded.until(firmware::Mode::kReady));
  EXPECT_EQ(controller.request(Command::kArm), 0U);
  EXPECT_TRUE(recorded.until(firmware::Mode::kArmed));
  recorded.seconds(1.0);
  const std::vector<std::byte> image = image_of(folder / (folder.filename().string() + ".scene.json"));
  EXPECT_EQ(controller.load_scene(image), firmware::StoreStatus::kOk);
  recorded.seconds(1.0);
  EXPECT_EQ(controller.request(Command::kDisarm), 0U);
  EXPECT_TRUE(recorded.until(firmware::Mode::kDamping));
  EXPECT_TRUE(recorded.until(firmware::Mode::kReady));

  const host::Recording begun = recorded.start(image);
  recorded.seconds(0.1);
  EXPECT_EQ(controller.request(Command::kArm), 0U);
  recorded.seconds(seconds);
  recorded.board.set_dead_man(false);
  recorded.seconds(0.3);
  recorded.board.set_dead_man(true);
  recorded.seconds(0.1);
  EXPECT_EQ(controller.request(Command::kArm), 0U);
  recorded.seconds(seconds);
  EXPECT_EQ(controller.recording_state().phase, link::RecordingPhase::kRunning)
      << link::name(static_cast<link::RecordingEnd>(controller.recording_state().end));
  EXPECT_EQ(controller.recording_state().dropped, 0U);
  return recorded.finish(begun);
}

TEST(Replay, EveryScenesForcesComeOutAgain) {
  const fs::path scenes = fs::path(THIMBLE_SOURCE_DIR) / "scenes";
  const std::vector<std::byte> asteroid = image_of(scenes / "asteroid/asteroid.scene.json");
  const double seconds = kUnderSanitizers ? 2.0 : 3.0;
  // Under the sanitizers e2e.scenes renders every scene; here one in four, for the code that replays.
  constexpr std::size_t kStep = kUnderSanitizers ? 4 : 1;
  std::size_t scenes_felt = 0;
  std::size_t scenes_moved = 0;
  std::uint64_t ticks = 0;
  std::uint64_t contacts = 0;
  std::set<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(scenes)) {
    if (fs::exists(entry.path() / "stroke.csv") &&
        fs::exists(entry.path() / (entry.path().filename().string() + ".scene.json")))
      folders.insert(entry.path());
  }
  for (std::size_t i = 0; const fs::path& folder : folders) {
    if (i++ % kStep != 0) continue;
    SCOPED_TRACE(folder.filename().string());
    const host::Recording recording = felt(folder, asteroid, seconds);
    std::vector<control::BodyState> first;
    bool moved = false;
    const host::ReplayVerdict verdict = host::replay_recording(recording, [&](const board::LogRow& row) {
      const std::span<const control::BodyState> now = row.scene.bodies;
      if (first.empty()) first.assign(now.begin(), now.end());
      for (std::size_t body = 0; body < first.size(); ++body)
        moved = moved || (now[body].position_m - first[body].position_m).norm() > 1e-3F;
    });
    if (moved) ++scenes_moved;
    EXPECT_TRUE(verdict.exact());
    EXPECT_EQ(verdict.ticks, recording.tick_count());
    EXPECT_GE(verdict.checks, verdict.ticks / 16);
    EXPECT_LT(verdict.first_tick + verdict.ticks - 1 - verdict.exact_to, 16U);
    if (verdict.contact_ticks != 0) ++scenes_felt;
    ticks += verdict.ticks;
    contacts += verdict.contact_ticks;
  }
  figure("ticks replayed, all the same to the bit", static_cast<double>(ticks), "reported");
  figure("of those in contact", static_cast<double>(contacts), "reported");
  figure("scenes that were felt", static_cast<double>(scenes_felt), "reported");
  figure("scenes whose objects moved, in the rows of the replay", static_cast<double>(scenes_moved),
         "reported");
  EXPECT_GE(scenes_felt, kUnderSanitizers ? 1U : 5U);
  EXPECT_GE(scenes_moved, kUnderSanitizers ? 0U : 3U);
}

// A recording with events, and with the trial switched by a host while the arm is armed: it goes on, and comes out again. The host reads the
// parameters when the trial has been switched already.
TEST(Replay, TrialsComeOutAgain) {
  const std::string scene = R"({"thimble_scene": 1, "name": "fields", "objects": [
    {"name": "up", "shape": {"force_field": {"constant_N": [0, 0, 1.5], "trial": 1}}},
    {"name": "curl", "shape": {"force_field": {"curl_N_s_m": [0, 0, 12], "trial": 2}}},
    {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.01}}, "material": {"stiffness_N_m": 600}}]})";
  const fs::path file = fs::path(testing::TempDir()) / "trials.scene.json";
  std::ofstream(file) << scene;
  const std::vector<std::byte> image = image_of(file);
  RecordedBoard recorded(board::SimBoardOptions{});
  firmware::Controller& controller = recorded.board.controller();
  recorded.board.follow(0, board::HandPath({{0, {0, 0, 0}}, {0.5, {0.02, 0.01, -0.013}}, {1, {0, 0, 0}}}),
                        true);
  EXPECT_EQ(controller.load_scene(image), firmware::StoreStatus::kOk);
  recorded.seconds(0.01);
  EXPECT_EQ(controller.request(Command::kHome), 0U);
  EXPECT_TRUE(recorded.until(firmware::Mode::kReady));
  ASSERT_EQ(recorded.ask({0x10, 0x03})[0], 0x50);
  const auto write = [&](std::uint16_t id, std::uint16_t value) {
    EXPECT_EQ(
        recorded.ask({0x2E, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id),
                      static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8), 0, 0})[0],
        0x6E);
    link::Marked marked;
    const std::vector<std::uint8_t> read = recorded.ask({0x22, 0xF1, 0xBD});
    EXPECT_TRUE(link::decode(std::span(read).subspan(3), marked));
    EXPECT_EQ(marked.value, value);
    return marked.tick;
  };
  write(0x0190, 2);
  host::Recording begun = recorded.start(image);
  std::vector<std::pair<std::uint64_t, std::uint16_t>> told;
  const auto mark = [&](std::uint16_t id, std::uint16_t value) {
    told.emplace_back(write(id, value), value);
  };
  mark(0x0190, 1);
  for (auto& [id, bits] : begun.header.parameters)
    if (id == 0x0190) bits = 1;
  EXPECT_EQ(controller.request(Command::kArm), 0U);
  for (std::uint16_t i = 0; i < 60; ++i) {
    recorded.seconds(0.02);
    mark(0x0190, i % 3);
    mark(0x0191, static_cast<std::uint16_t>(40'000 + i));
  }
  EXPECT_EQ(controller.recording_state().phase, link::RecordingPhase::kRunning);
  EXPECT_EQ(controller.recording_state().marks, told.size());
  const host::Recording recording = recorded.finish(begun);
  ASSERT_EQ(recording.marks.size(), told.size());
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(recording.marks[i].tick, told[i].first);
    EXPECT_EQ(recording.marks[i].value, told[i].second);
  }
  EXPECT_EQ(recording.first_trial(), 2U);
  const host::ReplayVerdict verdict = host::replay_recording(recording);
  EXPECT_TRUE(verdict.exact());
  EXPECT_GT(verdict.ticks, 4000U);
  EXPECT_GT(verdict.peak_force_N, 1.0);
  EXPECT_GT(verdict.contact_ticks, 100U);

  host::Recording later = recording;  // by one tick
  for (host::RecordedMark& one : later.marks) ++one.tick;
  EXPECT_TRUE(host::replay_recording(later).differs_at);
  host::Recording none = recording;  // as a thimble that knew none of this would read it
  none.marks.clear();
  EXPECT_TRUE(host::replay_recording(none).differs_at);
}

TEST(Replay, ADifferenceIsFound) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes/asteroid";
  const host::Recording good = felt(folder, image_of(folder / "asteroid.scene.json"), 2.0);
  std::size_t tick = 0, rows = 0;  // the last one that is in contact
  ASSERT_TRUE(host::replay_recording(good, [&](const board::LogRow& row) {
                if (row.contacts != 0 && row.force_N.norm() > 0.5) tick = rows;
                ++rows;
              }).exact());
  tick -= 50;

  host::Recording count = good;  // one count
  count.ticks[0].counts[3 * tick + 2] ^= 1U;
  const host::ReplayVerdict verdict = host::replay_recording(count);
  ASSERT_TRUE(verdict.differs_at);
  const std::uint64_t changed = good.ticks[0].first + tick;
  EXPECT_GE(*verdict.differs_at, changed);
  EXPECT_LT(*verdict.differs_at, changed + 40);
  EXPECT_LT(verdict.exact_to, changed + 16);

  host::Recording scene = good;
  scene.header.parameters[0].second = 0x3F800000;  // max_force 1 N
  EXPECT_TRUE(host::replay_recording(scene).differs_at);

  host::Recording heat = good;
  heat.header.arms[0].winding_K[1] = 200;  // hotter than winding_limit
  EXPECT_TRUE(host::replay_recording(heat).differs_at);
}

TEST(Replay, StopsWhereSomethingIsMissing) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes/asteroid";
  const host::Recording good = felt(folder, image_of(folder / "asteroid.scene.json"), 0.5);
  const std::size_t each = 3;
  host::Recording gap = good;
  std::vector<std::uint16_t>& counts = gap.ticks[0].counts;
  gap.ticks.push_back({gap.ticks[0].first + 1001, {counts.begin() + 1001 * each, counts.end()}});
  gap.ticks[0].counts.resize(1000 * each);
  host::ReplayVerdict verdict = host::replay_recording(gap);
  EXPECT_FALSE(verdict.exact());
  EXPECT_FALSE(verdict.differs_at);
  EXPECT_EQ(verdict.gap_at, good.ticks[0].first + 1000);
  EXPECT_EQ(verdict.ticks, 1000U);
  EXPECT_EQ(verdict.not_replayed, good.tick_count() - 1001);

  host::Recording lost = good;  // a check
  const host::RecordedCheck check = lost.checks[40];
  lost.checks.erase(lost.checks.begin() + 40);
  verdict = host::replay_recording(lost);
  EXPECT_FALSE(verdict.differs_at);
  EXPECT_EQ(verdict.gap_at, good.checks[39].tick + 1);
  EXPECT_EQ(verdict.exact_to, good.checks[39].tick);
  EXPECT_LT(verdict.exact_to, check.tick);
}

TEST(Replay, WhatIsNotKnownHereIsRefused) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes/asteroid";
  const host::Recording good = felt(folder, image_of(folder / "asteroid.scene.json"), 0.1);
  const auto refused = [](const host::Recording& recording) {
    try {
      static_cast<void>(host::replay_recording(recording));
    } catch (const host::Error& error) {
      return error.name == "cannot-replay" && error.code == host::ExitCode::kBadInput;
    }
    return false;
  };
  host::Recording bad = good;
  bad.header.models[0] = "premium-9";
  EXPECT_TRUE(refused(bad));
  bad = good;
  bad.header.parameters.emplace_back(0x7777, 1);
  EXPECT_TRUE(refused(bad));
  bad = good;
  bad.header.start.period_s = 1;
  EXPECT_TRUE(refused(bad));
  bad = good;
  bad.header.scene.resize(bad.header.scene.size() / 2);
  EXPECT_TRUE(refused(bad));
}

}  // namespace
}  // namespace thimble::test
