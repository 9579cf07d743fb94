// arm_plant: the arm behind the simulated hardware (arm_hardware/), in real time: reads the converter's voltages, the enable
// line and the one-shot of the heartbeat, moves motors, arm and a hand, writes the encoders. In the virtual machine only.
//
//   arm_plant --enable FILE --one-shot FILE --hand PATH.csv [--volts-per-ampere V]
//
// The arm lies at its home pose until it is enabled for the first time; from then on the hand has it and follows its path.
// Ends with SIGTERM and prints what happened as one line of JSON.
#include <fcntl.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>

#include "board/linux/open_file.h"
#include "board/sim/hand_path.h"
#include "board/sim/hand_path_file.h"
#include "board/sim/plant.h"
#include "tests/hardware/vm/arm_hardware.h"

namespace thimble::board {
namespace {

using test::ConverterOutputs;
using test::now_ns;

constexpr std::uint64_t kPeriod_ns = 1'000'000;
constexpr int kPriority = 90;          // above the board's: encoders do not wait
constexpr double kMostStep_s = 0.005;  // behind by more, the arm waits: the machine was busy

constexpr double kVoltsPerStep = 10.0 / 32768.0;
constexpr std::uint16_t kRange10V = 4;

volatile std::sig_atomic_t stopping = 0;

void check(bool done, const char* what) {
  if (!done) throw std::system_error(errno, std::generic_category(), what);
}

bool reads_1(const Descriptor& file, const char* what) {
  char level = '0';
  check(pread(file.get(), &level, 1, 0) == 1, what);
  return level == '1';
}

class ArmPlant {
 public:
  ArmPlant(const std::string& enable_file, const std::string& one_shot_file, const std::string& hand_file,
           double volts_per_ampere)
      : hardware_(open_file("/dev/arm_hardware", O_RDWR)),
        enable_(open_file(enable_file, O_RDONLY)),
        one_shot_(open_file(one_shot_file, O_RDONLY)),
        path_(read_hand_path(hand_file)),
        volts_per_ampere_(volts_per_ampere),
        plant_(PlantParameters::from(*find_plant_variant("premium-1.5")), Hand{}) {}

  void step(double seconds) {
    ConverterOutputs outputs{};
    check(read(hardware_.get(), &outputs, sizeof(outputs)) == sizeof(outputs), "/dev/arm_hardware");
    const bool enable = reads_1(enable_, "the enable line") && reads_1(one_shot_, "the one-shot");
    Vector3d current_A = Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const bool awake = outputs.range[i] == kRange10V && (outputs.power >> i & 1U) != 0;
      if (awake) current_A[static_cast<int>(i)] = outputs.word[i] * kVoltsPerStep / volts_per_ampere_;
    }
    bad_frames_ = outputs.bad_frames;
    most_A_ = std::max(most_A_, current_A.cwiseAbs().maxCoeff());
    if (enable && !since_s_) since_s_ = plant_.time_s();
    if (since_s_) {
      const HandPath::Sample hand = path_.at(path_.start_s() + plant_.time_s() - *since_s_);
      plant_.set_hand_target(hand.position_m, hand.velocity_m_s);
      plant_.command_current(current_A, enable);
      plant_.step(seconds);
      lowest_m_ = std::min(lowest_m_, plant_.tip_m().z());
      most_N_ = std::max(most_N_, plant_.hand_force_N().norm());
    }
    const std::array<std::uint32_t, 3> counts = plant_.encoder_counts();
    check(write(hardware_.get(), counts.data(), sizeof(counts)) == sizeof(counts), "/dev/arm_hardware");
    ++steps_;
  }

  void report() const {
    std::printf(
        "{\"steps\": %llu, \"simulated_s\": %.3f, \"lowest_mm\": %.3f, \"most_N\": %.3f, \"most_A\": %.3f, "
        "\"bad_frames\": %u}\n",
        static_cast<unsigned long long>(steps_), plant_.time_s(), lowest_m_ * 1e3, most_N_, most_A_,
        static_cast<unsigned>(bad_frames_));
  }

 private:
  Descriptor hardware_;
  Descriptor enable_, one_shot_;
  HandPath path_;
  double volts_per_ampere_;
  Plant plant_;
  std::optional<double> since_s_;  // of the plant's time, when it was enabled first
  std::uint64_t steps_ = 0;
  double lowest_m_ = 0, most_N_ = 0, most_A_ = 0;
  std::uint16_t bad_frames_ = 0;
};

int main_of(int argc, char** argv) {
  std::string enable, one_shot, hand;
  double volts_per_ampere = 2;
  CLI::App app{"The arm behind the simulated hardware", "arm_plant"};
  app.add_option("--enable", enable, "file with the enable line's level")->required();
  app.add_option("--one-shot", one_shot, "file with the one-shot's level")->required();
  app.add_option("--hand", hand, "the hand's path, CSV")->required();
  app.add_option("--volts-per-ampere", volts_per_ampere, "of the amplifiers")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGTERM, [](int) { stopping = 1; });
  try {
    sched_param parameters{};
    parameters.sched_priority = kPriority;
    check(sched_setscheduler(0, SCHED_FIFO, &parameters) == 0, "real-time priority");
    ArmPlant arm(enable, one_shot, hand, volts_per_ampere);
    std::uint64_t last_ns = now_ns(), due_ns = last_ns;
    while (stopping == 0) {
      due_ns = std::max(due_ns + kPeriod_ns, now_ns());
      const timespec due{static_cast<time_t>(due_ns / 1'000'000'000U),
                         static_cast<long>(due_ns % 1'000'000'000U)};
      (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
      const std::uint64_t time_ns = now_ns();
      arm.step(std::min(kMostStep_s, static_cast<double>(time_ns - last_ns) * 1e-9));
      last_ns = time_ns;
    }
    arm.report();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "arm_plant: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace
}  // namespace thimble::board

int main(int argc, char** argv) { return thimble::board::main_of(argc, argv); }
