// builder: a simulated arm on emulated drives, and a person who does what `thimble commission` asks for (builder_rig.h). In the virtual machine only.
//
//   builder INTERFACE --arm FILE.arm.json --drive KIND:ID... --prompts FIFO --answers FIFO --e-stop FILE --dead-man FILE [--fault NAME@AXIS]
//
// Prints "ready", then what it reads, and before each step the largest force and speed of the tip so far. Ends with SIGTERM.
#include <sched.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "board/linux/drives/open_can_bus.h"
#include "board/sim/drives/drive_options.h"
#include "host-tools/commission/planted.h"
#include "host-tools/files/input_file.h"
#include "tests/hardware/vm/builder_rig.h"

namespace thimble::test {
namespace {

constexpr int kPriority = 90;  // above the board's: a drive does not wait

volatile std::sig_atomic_t stopping = 0;

struct Choice {
  std::string interface, arm;
  std::vector<std::string> drives, faults;
  Places places;
  std::uint64_t seed = 1;
};

void live(const Choice& choice) {
  const host::ArmFile arm = host::read_arm_file(host::read_input(choice.arm), choice.arm);
  std::vector<host::SimFault> faults;
  faults.reserve(choice.faults.size());
  for (const std::string& text : choice.faults) faults.push_back(host::planted_fault(text, arm));
  board::drives::OpenedBus opened = board::drives::open_can_bus(choice.interface, {}, false);
  if (!opened.socket.is_open()) throw std::runtime_error(opened.trouble);
  board::emulated::EmulatedBus bus(std::move(opened.socket));
  std::vector<board::emulated::EmulatedDrive*> drives;
  drives.reserve(choice.drives.size());
  for (const std::string& text : choice.drives)
    drives.push_back(&bus.add(board::emulated::parse_drive(text).drive));
  host::SimBenchOptions options;
  options.seed = choice.seed;
  BuilderRig rig(arm, std::move(faults), options, bus, std::move(drives), choice.places);
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) throw std::runtime_error("no real-time priority");
  std::cout << "ready" << std::endl;
  while (stopping == 0) rig.go_on();
  std::cout << "at the end: " << rig.figures() << std::endl;
}

int main_of(int argc, char** argv) {
  Choice choice;
  CLI::App app{"A simulated arm on emulated drives, and its builder", "builder"};
  app.add_option("interface", choice.interface, "CAN interface of the drives")->required();
  app.add_option("--arm", choice.arm, "arm file")->required();
  app.add_option("--drive", choice.drives, "KIND:ID, once an axis, as of thimble-sim-drive")->required();
  app.add_option("--fault", choice.faults, "NAME@AXIS, as of `thimble commission --simulate`");
  app.add_option("--seed", choice.seed, "of the arm's true figures")->capture_default_str();
  app.add_option("--prompts", choice.places.prompts, "FIFO with what the tool prints on stderr")->required();
  app.add_option("--answers", choice.places.answers, "FIFO that the tool reads")->required();
  app.add_option("--e-stop", choice.places.e_stop, "file with the pull of its line")->required();
  app.add_option("--dead-man", choice.places.dead_man, "file with the pull of its line")->required();
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGTERM, [](int) { stopping = 1; });
  try {
    live(choice);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "builder: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) { return thimble::test::main_of(argc, argv); }
