// Records a run of the simulated arm for replay on the boards, and what it felt.
//
//   record_run SCENE PATH.csv TICKS RATE OUT.rec OUT.forces     under the hand of a path, over and over; RATE ticks a second
//   record_run SCENE wander:SEED TICKS RATE OUT.rec OUT.forces  a fingertip that darts about in the scene, with no arm's inertia:
//                                                               for the worst that a tick can cost
//
// Plays it again at once, on this machine, and fails when a byte of a force differs. Writes OUT.cost: a row for each tick with the
// instructions that board/sim/tick_cost.h estimates for each board that has a core of its own, and the terms, "-" before the arm is armed.
// Exit codes: 0, 1 failed, 2 usage.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "board/sim/tick_cost.h"
#include "host-tools/compiler/compile.h"
#include "kinematics/built_in_arms.h"
#include "tests/hardware/cortex/replay.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

constexpr const char* kModel = "premium-1.5";

struct Run {
  double rate_Hz = 0;
  RecordingHeader header{};
  std::vector<std::byte> image;
  std::vector<std::uint32_t> counts;
};

void describe_arms(Run& run, std::size_t arms) {
  run.header.magic = kRecordingMagic;
  run.header.arms = static_cast<std::uint32_t>(arms);
  run.header.period_s = static_cast<float>(1.0 / run.rate_Hz);
  run.header.image_bytes = static_cast<std::uint32_t>(run.image.size());
  std::string_view(kModel).copy(run.header.model.data(), run.header.model.size() - 1);
}

void tick(Run& run, board::SimBoard& board) {
  board.controller().keep_alive();
  board.tick();
  for (std::size_t arm = 0; arm < run.header.arms; ++arm) {
    const auto& counts = board.controller().telemetry().arm[arm].counts;
    run.counts.insert(run.counts.end(), counts.begin(), counts.begin() + 3);
  }
  ++run.header.ticks;
  if (board.controller().fault() != firmware::Fault::kNone)
    throw std::runtime_error(std::string("fault in tick ") + std::to_string(run.header.ticks) + ": " +
                             firmware::find_fault(board.controller().fault())->name);
}

void request(board::SimBoard& board, firmware::Command command) {
  if (board.controller().request(command) != 0) throw std::runtime_error("a command was refused");
}

void through_the_arm(Run& run, const std::string& path_file, std::uint32_t ticks) {
  const std::vector<board::PathPoint> points = board::read_hand_path(path_file);
  std::array<std::vector<board::PathPoint>, 2> own;
  for (const board::PathPoint& point : points) own[static_cast<std::size_t>(point.arm)].push_back(point);
  const std::size_t arms = own[1].empty() ? 1 : 2;
  describe_arms(run, arms);
  board::SimBoard board(
      {.variant = kModel, .rate_Hz = run.rate_Hz, .arm_count = static_cast<std::uint8_t>(arms)});
  for (std::size_t arm = 0; arm < arms; ++arm) {
    board.follow(arm, board::HandPath(own[arm]), true);
    for (std::size_t axis = 0; axis < 3; ++axis)
      run.header.home_m[arm][axis] =
          board.plant(arm).parameters().base.home_m[static_cast<Eigen::Index>(axis)];
  }
  if (board.controller().load_scene(run.image) != firmware::StoreStatus::kOk)
    throw std::runtime_error("the scene was refused");
  tick(run, board);
  run.header.home_before = run.header.ticks;
  request(board, firmware::Command::kHome);
  const auto waits = [&] {
    for (std::size_t arm = 0; arm < arms; ++arm)
      if (!board.hand_waits(arm)) return false;
    return true;
  };
  while (!waits() && run.header.ticks < ticks) tick(run, board);
  run.header.arm_before = run.header.ticks;
  request(board, firmware::Command::kArm);
  while (run.header.ticks < ticks) tick(run, board);
}

// Faster than any hand for some ticks, slow for others, within 60 mm of home; encoder counts to the nearest.
void wander(Run& run, std::uint64_t seed, std::uint32_t ticks) {
  constexpr double kReach_m = 0.06, kFast_m_s = 2.0, kSlow_m_s = 0.08;
  constexpr std::uint32_t kRest = 8;  // ticks in the home pose: homing, arming
  describe_arms(run, 1);
  run.header.home_before = 1;
  run.header.arm_before = 4;
  const kinematics::ArmData model = kinematics::built_in_arm(kModel);
  const kinematics::TwoLinkArm<double> arm(model, {});
  Random random(seed);
  Eigen::Vector3d tip = Eigen::Vector3d::Zero(), goal = tip;
  for (; run.header.ticks < ticks; ++run.header.ticks) {
    if (run.header.ticks > kRest) {
      if ((goal - tip).norm() < kFast_m_s / run.rate_Hz || random.below(200) == 0)
        goal = kReach_m * random.direction();
      tip += (random.below(3) == 0 ? kSlow_m_s : kFast_m_s) / run.rate_Hz * (goal - tip).normalized();
    }
    Eigen::Vector3d joints;
    if (!arm.inverse(tip, joints)) throw std::logic_error("out of reach");
    for (int joint = 0; joint < 3; ++joint) {
      const double count = (joints[joint] - arm.home()[joint]) /
                           static_cast<double>(model.axis[static_cast<std::size_t>(joint)].rad_per_count());
      run.counts.push_back(static_cast<std::uint32_t>(std::llround(count)));
    }
  }
}

std::vector<std::byte> bytes_of(const Run& run) {
  std::vector<std::byte> bytes(sizeof(run.header) + padded(run.image.size()) + run.counts.size() * 4);
  std::memcpy(bytes.data(), &run.header, sizeof(run.header));
  std::memcpy(bytes.data() + sizeof(run.header), run.image.data(), run.image.size());
  std::memcpy(bytes.data() + sizeof(run.header) + padded(run.image.size()), run.counts.data(),
              run.counts.size() * 4);
  return bytes;
}

std::vector<float> forces_N;
const firmware::Controller* replayed = nullptr;
float replayed_period_s = 0;
std::ofstream cost_rows;

void write_cost() {
  const firmware::Telemetry& telemetry = replayed->telemetry();
  if (telemetry.mode != firmware::Mode::kArmed) {
    cost_rows << "-\n";
    return;
  }
  std::size_t touching = 0, contacts = 0;
  for (std::size_t arm = 0; arm < telemetry.arm_count; ++arm) {
    touching += telemetry.arm[arm].contacts != 0 ? 1U : 0U;
    contacts += telemetry.arm[arm].contacts;
  }
  const board::TickTerms terms = board::terms_of(replayed->renderer().load(), replayed_period_s,
                                                 telemetry.arm_count, touching, contacts);
  for (const board::BoardCost& board : board::board_costs())
    if (!board.core.empty()) cost_rows << std::lround(board.of(terms)) << ' ';
  for (const double term : terms.of) cost_rows << ' ' << term;
  cost_rows << '\n';
}

void write_file(const std::string& name, const void* data, std::size_t bytes) {
  std::ofstream file(name, std::ios::binary);
  file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  if (!file.flush()) throw std::runtime_error("cannot write " + name);
}

void record(const std::string& scene, const std::string& path, std::uint32_t ticks, double rate_Hz,
            const std::string& out, const std::string& forces_out) {
  Run run;
  run.rate_Hz = rate_Hz;
  run.image = host::compile_scene(scene).image;
  constexpr std::string_view kWander = "wander:";
  if (path.starts_with(kWander)) {
    wander(run, std::stoull(path.substr(kWander.size())), ticks);
  } else {
    through_the_arm(run, path, ticks);
  }
  const std::vector<std::byte> bytes = bytes_of(run);
  Recording recording;
  if (!open_recording(bytes, recording)) throw std::logic_error("not what was written");
  board::MemoryStorage storage(run.image.size() + firmware::SceneStore::kHeaderBytes);
  const auto controller = std::make_unique<firmware::Controller>(config_of(recording), storage);
  replayed = controller.get();
  replayed_period_s = run.header.period_s;
  cost_rows.open(out + ".cost");
  const ReplayEnd end = replay(recording, *controller, [](std::span<const float> force) {
    forces_N.insert(forces_N.end(), force.begin(), force.end());
    write_cost();
  });
  if (end != ReplayEnd::kDone)
    throw std::runtime_error("the replay ended early, " + std::to_string(static_cast<int>(end)));
  write_file(out, bytes.data(), bytes.size());
  write_file(forces_out, forces_N.data(), forces_N.size() * sizeof(float));
  const auto felt = static_cast<double>(controller->telemetry().contact_ticks);
  std::printf("%u ticks, %.0f %% in contact\n", run.header.ticks, 100.0 * felt / run.header.ticks);
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "usage: record_run SCENE PATH.csv|wander:SEED TICKS RATE OUT.rec OUT.forces\n");
    return 2;
  }
  try {
    thimble::test::record(argv[1], argv[2], static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10)),
                          std::strtod(argv[4], nullptr), argv[5], argv[6]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "record_run: %s\n", error.what());
    return 1;
  }
}
