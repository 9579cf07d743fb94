// thimble-sim: the simulated board in real time behind the link, for people without an arm and for tests.
//
// Prints one address a line (tcp:HOST:PORT, slcan:PTY, canfd:INTERFACE ...), then "ready". Ends with SIGTERM, SIGINT or SIGHUP and
// leaves nothing behind. Exit codes: 0 ended by signal, 1 failed, 2 usage.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/posix/can_port.h"
#include "board/posix/link_ports.h"
#include "board/posix/pty_port.h"
#include "board/posix/tcp_port.h"
#include "board/posix/tty_port.h"
#include "board/sim/announcement.h"
#include "board/sim/file_storage.h"
#include "board/sim/hand_path_file.h"
#include "board/sim/sim_board.h"
#include "board/sim/specimen_file.h"

namespace thimble::board {
namespace {

volatile std::sig_atomic_t stopping = 0;

struct Options {
  std::string arm = "premium-1.5";
  double rate_Hz = 4000;
  std::uint64_t seed = 1;
  std::optional<std::uint16_t> tcp_port;
  bool pty = true;
  std::string link;
  std::string can;
  std::string tty;
  std::string hand;
  bool loop = false;
  std::string specimen;
  std::string store;
  std::string name;
};

// Behind by more than this, the arm waits instead of catching up: the machine was busy, and a burst would be worse. The link waits as
// long: where the arm cannot keep up (under sanitizers it runs at 0.7 of real time), 0.1 s took 2 s to answer a question.
constexpr double kMostBehind_s = 0.02;
constexpr std::uint64_t kWait_us = 500;

std::uint64_t now_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

std::unique_ptr<SimBoard> start_board(const Options& options, firmware::Storage& storage,
                                      const char* reset_reason) {
  SimBoardOptions board_options;
  board_options.variant = options.arm;
  board_options.rate_Hz = options.rate_Hz;
  board_options.seed = options.seed;
  board_options.storage = &storage;
  board_options.reset_reason = reset_reason;
  board_options.time_ticks = true;
  if (!options.specimen.empty()) {
    board_options.specimen = std::make_shared<const Specimen>(read_specimen(options.specimen));
    board_options.hand = kNoHand;  // nobody holds an arm that scans
  }
  std::vector<PathPoint> points;
  if (!options.hand.empty()) points = read_hand_path(options.hand);
  const bool two = std::ranges::any_of(points, [](const PathPoint& point) { return point.arm == 1; });
  board_options.arm_count = two ? 2 : 1;
  auto board = std::make_unique<SimBoard>(board_options);
  for (int arm = 0; arm < board_options.arm_count; ++arm) {
    std::vector<PathPoint> own;
    std::ranges::copy_if(points, std::back_inserter(own), [arm](const PathPoint& p) { return p.arm == arm; });
    if (!own.empty()) board->follow(static_cast<std::size_t>(arm), HandPath(std::move(own)), options.loop);
  }
  return board;
}

void run(const Options& options) {
  LinkPorts ports;
  // The best first: TCP carries more than a pty, whose buffer is 4 kB.
  if (options.tcp_port) ports.add(std::make_unique<TcpPort>(*options.tcp_port));
  if (options.pty) ports.add(std::make_unique<PtyPort>(options.link));
  if (!options.can.empty()) ports.add(std::make_unique<CanPort>(options.can, firmware::Config{}.node_id));
  if (!options.tty.empty()) ports.add(std::make_unique<TtyPort>(options.tty));
  if (ports.empty()) throw std::runtime_error("without a pty, --tcp, --can and --tty nobody can reach it");

  constexpr std::size_t kSlotBytes = control::kMaxImageBytes + firmware::SceneStore::kHeaderBytes;
  std::unique_ptr<FileStorage> file;
  std::unique_ptr<MemoryStorage> memory;
  if (options.store.empty()) {
    memory = std::make_unique<MemoryStorage>(kSlotBytes);
  } else {
    file = std::make_unique<FileStorage>(options.store, kSlotBytes);
  }
  firmware::Storage& storage = file ? static_cast<firmware::Storage&>(*file) : *memory;
  std::unique_ptr<SimBoard> board = start_board(options, storage, "power_on");

  const Announced announced({options.name, options.arm, ports.uris()});
  for (const std::string& uri : ports.uris()) std::cout << uri << '\n';
  std::cout << "ready" << std::endl;

  std::uint64_t last_us = now_us();
  double skipped_s = 0;
  while (stopping == 0) {
    const std::uint64_t time_us = now_us();
    double due_s = static_cast<double>(time_us - last_us) * 1e-6;
    last_us = time_us;
    if (due_s > kMostBehind_s) {
      skipped_s += due_s - kMostBehind_s;
      due_s = kMostBehind_s;
    }
    board->step(due_s);

    firmware::Controller& controller = board->controller();
    while (const std::optional<firmware::link::CanFrame> frame = ports.receive()) {
      controller.on_frame(*frame, now_us());
      for (firmware::link::CanFrame out; controller.next_frame(out, now_us());) ports.send(out);
    }
    controller.tell_link_losses(static_cast<std::uint32_t>(ports.dropped()));
    controller.poll(now_us());
    for (firmware::link::CanFrame out; controller.next_frame(out, now_us());) ports.send(out);
    ports.flush();
    if (const std::optional<std::string> news = ports.news())
      std::cerr << "thimble-sim: " << *news << std::endl;
    if (controller.take_reset()) board = start_board(options, storage, "host");
    ports.wait(kWait_us);
  }
  std::cerr << "thimble-sim: " << board->time_s() << " s simulated, " << skipped_s << " s skipped, "
            << ports.dropped() << " frames dropped\n";
}

int main_of(int argc, char** argv) {
  Options options;
  CLI::App app{"A simulated Thimble device in real time", "thimble-sim"};
  std::string arms;
  for (const PlantVariant& variant : plant_variants())
    arms += (arms.empty() ? "" : ", ") + std::string(variant.name);
  app.add_option("--arm", options.arm, "one of: " + arms)->capture_default_str();
  app.add_option("--rate", options.rate_Hz, "ticks a second")
      ->check(CLI::Range(100.0, 20000.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the simulated arm")->capture_default_str();
  app.add_option("--tcp", options.tcp_port, "offer the link on this port of 127.0.0.1 too; 0: any free one");
  app.add_flag("!--no-pty", options.pty, "no pty, only the others");
  app.add_option("--link", options.link, "a symbolic link to the pty");
  app.add_option("--can", options.can, "offer the link on this SocketCAN interface too, classic and FD");
  app.add_option("--tty", options.tty,
                 "offer it as SLCAN on this serial port too: /dev/ttyGS0 of a USB gadget");
  CLI::Option* hand =
      app.add_option("--hand", options.hand, "the hand's path once armed: CSV time_s,x_m,y_m,z_m[,arm]");
  app.add_flag("--loop", options.loop, "the hand begins again at the path's end");
  app.add_option("--specimen", options.specimen,
                 "no hand, but a thing to touch, for `thimble scan`: JSON, see docs/scan.md")
      ->excludes(hand);
  app.add_option("--store", options.store, "keep the scenes in this file");
  app.add_option("--name", options.name, "its name in `thimble list`; default: sim-PID")
      ->check([](const std::string& name) {
        return name.find_first_of("/:") == std::string::npos ? "" : "no / and no :";
      });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (options.name.empty()) options.name = "sim-" + std::to_string(getpid());
  const auto stop = [](int) { stopping = 1; };
  std::signal(SIGTERM, stop);
  std::signal(SIGINT, stop);
  if (std::signal(SIGHUP, stop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
  std::signal(SIGPIPE, SIG_IGN);
  try {
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "thimble-sim: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace
}  // namespace thimble::board

int main(int argc, char** argv) { return thimble::board::main_of(argc, argv); }
