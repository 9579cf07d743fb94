// thimble-sim-drive: emulated motor drives on a CAN interface (a vcan, or a real bus), one process a bus, in real time.
//
// Prints "ready" when it listens. Ends with SIGTERM or SIGINT. Exit codes: 0 ended by signal, 1 failed, 2 usage.
#include <poll.h>
#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "board/linux/drives/open_can_bus.h"
#include "board/sim/arm_image_file.h"
#include "board/sim/drives/drive_options.h"
#include "board/sim/drives/driven_arm.h"
#include "board/sim/drives/emulated_bus.h"
#include "board/sim/hand_path_file.h"

namespace thimble::board::emulated {
namespace {

volatile std::sig_atomic_t ending = 0;

struct Options {
  std::string interface;
  int socket = -1;
  std::vector<std::string> drives, faults;
  std::string arm, hand;                // the simulated arm behind the first drives; empty: none
  double step_us = kPlantStep_s * 1e6;  // of the arm, at most
  int priority = 0;                     // of SCHED_FIFO; 0: the usual scheduling
};

std::string arm_names() {
  std::string names;
  for (const PlantVariant& one : plant_variants()) names.append(names.empty() ? "" : ", ").append(one.name);
  return names;
}

SimArm sim_arm(const std::string& name, double step_s) {
  if (const std::optional<kinematics::ArmData> data = arm_of_image(name)) {
    AnyPlantParameters parameters = AnyPlantParameters::from(*data);
    parameters.max_step_s = step_s;
    return {*data, AnyPlant(parameters, Hand{})};
  }
  const PlantVariant* variant = find_plant_variant(name);
  if (variant == nullptr)
    throw std::runtime_error("no simulated arm is named '" + name + "'; there are: " + arm_names() +
                             ", and images (`thimble model compile`): *.tarm");
  PlantParameters parameters = PlantParameters::from(*variant);
  parameters.max_step_s = step_s;
  return {parameters.model, Plant(parameters, Hand{})};
}

std::optional<DrivenArm> make_arm(const Options& options, const std::vector<EmulatedDrive*>& drives) {
  if (options.arm.empty()) return std::nullopt;
  const SimArm arm = sim_arm(options.arm, options.step_us * 1e-6);
  const std::size_t motors = DrivenArm::motors_of(arm.data());
  if (drives.size() != motors)
    throw std::runtime_error("the motors of the arm are " + std::to_string(motors) + ", the drives " +
                             std::to_string(drives.size()) + ": give each motor its --drive");
  return DrivenArm(arm, HandPath(read_hand_path(options.hand)), drives);
}

std::uint64_t steady_us() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

void emulate(const Options& options, std::vector<NamedDrive> drives, std::vector<TimedFault> faults) {
  Descriptor socket(options.socket);
  if (options.socket < 0) {
    const bool fd = std::ranges::any_of(drives, &NamedDrive::fd);
    drives::OpenedBus opened = drives::open_can_bus(options.interface, {}, fd);
    if (!opened.socket.is_open()) throw std::runtime_error(opened.trouble);
    socket = std::move(opened.socket);
  }
  EmulatedBus bus(std::move(socket));
  std::vector<EmulatedDrive*> added;
  added.reserve(drives.size());
  for (NamedDrive& one : drives) added.push_back(&bus.add(std::move(one.drive)));
  std::optional<DrivenArm> arm = make_arm(options, added);
  sched_param parameters{};
  parameters.sched_priority = options.priority;
  if (options.priority > 0 && sched_setscheduler(0, SCHED_FIFO, &parameters) != 0)
    throw std::runtime_error("no priority " + std::to_string(options.priority) +
                             " of SCHED_FIFO: run as root");
  std::cout << "ready" << std::endl;
  const std::uint64_t start_us = steady_us();
  while (ending == 0) {
    const std::uint64_t now_us = steady_us();
    bus.run(now_us);
    if (arm) {
      arm->advance(now_us, bus.heard());
      if (const auto report = arm->take_report()) std::cout << *report << std::endl;
    }
    const double time_s = static_cast<double>(now_us - start_us) * 1e-6;
    std::erase_if(faults, [&](const TimedFault& fault) {
      if (fault.time_s > time_s) return false;
      fault.happens(*added[fault.drive]);
      return true;
    });
    // Until a frame comes or is due, and no longer than what a drive's timers may be late.
    constexpr std::uint64_t kMostWait_us = 100;
    const std::uint64_t due_us = std::max(bus.next_due_us(), now_us) - now_us;
    pollfd waited{bus.descriptor(), POLLIN, 0};
    const timespec shortly{0, static_cast<long>(std::min(due_us, kMostWait_us)) * 1000};
    if (ppoll(&waited, 1, &shortly, nullptr) > 0 && (waited.revents & (POLLHUP | POLLNVAL)) != 0)
      throw std::runtime_error("the other end of the socket is closed");
  }
}

int main_of(int argc, char** argv) {
  Options options;
  CLI::App app{"Emulated motor drives on a CAN interface", "thimble-sim-drive"};
  CLI::Option* interface =
      app.add_option("interface", options.interface, "CAN interface, such as vcan0 (mtu 72 for FD)");
  app.add_option("--socket", options.socket,
                 "instead: this descriptor, an end of a socketpair that carries struct canfd_frame")
      ->excludes(interface);
  app.add_option(
         "--drive", options.drives,
         "KIND:ID[:REPLY_ID[:TORQUE_N_M]], once a drive; kinds: moteus, odrive05, odrive06, mini-cheetah, "
         "cubemars, damiao, damiao-fd; TORQUE_N_M: range of the torque's codes in MIT mode")
      ->required();
  app.add_option("--inject", options.faults,
                 "TIME_S:DRIVE:FAULT[=VALUE], DRIVE counts from 0; faults: " + fault_names());
  CLI::Option* hand =
      app.add_option("--hand", options.hand, "path of the hand that holds the arm's tip, CSV");
  app.add_option("--arm", options.arm,
                 "the simulated arm behind the drives, one for each of its motors: one of " + arm_names() +
                     ", or an arm image (`thimble model compile`): *.tarm; each time when they go off it "
                     "prints what the tip did")
      ->needs(hand);
  app.add_option("--step", options.step_us,
                 "of the arm's simulation in us, at most; longer on a slow machine")
      ->check(CLI::Range(1.0, 100.0))
      ->capture_default_str();
  app.add_option("--priority", options.priority, "of SCHED_FIFO, 1 to 99")->check(CLI::Range(1, 99));
  std::vector<NamedDrive> drives;
  std::vector<TimedFault> faults;
  try {
    app.parse(argc, argv);
    if (options.interface.empty() && options.socket < 0) throw CLI::RequiredError("interface");
    if (std::isnan(options.step_us)) throw CLI::ValidationError("--step", "is not a number");
    for (const std::string& text : options.drives) drives.push_back(parse_drive(text));
    for (const std::string& text : options.faults) {
      faults.push_back(parse_fault(text));
      if (faults.back().drive >= drives.size())
        throw std::invalid_argument("'" + text + "' is of a drive that is not there");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::invalid_argument& error) {
    std::cerr << "thimble-sim-drive: " << error.what() << '\n';
    return 2;
  }
  const auto end = [](int) { ending = 1; };
  std::signal(SIGTERM, end);
  std::signal(SIGINT, end);
  try {
    emulate(options, std::move(drives), std::move(faults));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "thimble-sim-drive: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace
}  // namespace thimble::board::emulated

int main(int argc, char** argv) { return thimble::board::emulated::main_of(argc, argv); }
