// thimble-board: the controller of a haptic arm on an embedded Linux board. docs/board-linux.md.
//
// Threads: the servo (SCHED_FIFO, servo_loop.h), the background of the controller (link and scenes), and the
// main thread, which feeds the watchdogs while both others make progress. Ends with SIGTERM or SIGINT, motors
// off. Exit codes: 0 ended by signal, or --check found nothing missing; 1 failed; 2 usage; 3 --check: a
// device is missing, --uses: the configuration does not name it; 5 --check: a privilege is missing; 10 bad configuration.
#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "board/files/text_file.h"
#include "board/linux/board_config.h"
#include "board/linux/check_board.h"
#include "board/linux/clock.h"
#include "board/linux/devices.h"
#include "board/linux/guardian.h"
#include "board/linux/measure_work.h"
#include "board/linux/named_devices.h"
#include "board/linux/realtime.h"
#include "board/linux/run_mark.h"
#include "board/linux/service_manager.h"
#include "board/linux/servo_loop.h"
#include "board/linux/slot_files.h"
#include "board/linux/stored_arms.h"
#include "board/linux/wall_clock.h"
#include "board/linux/watchdog.h"
#include "board/posix/link_ports.h"
#include "firmware/store/arm_store.h"

namespace thimble::board {
namespace {

constexpr int kFailed = 1, kUsage = 2, kNotFound = 3, kBadConfig = 10;
constexpr std::uint64_t kStart_us = 30'000'000;  // no start takes longer
constexpr const char* kByHost = "host";          // a reset reason
constexpr const char* kRestarted = "--restarted";
constexpr std::uint64_t kWait_us =
    1000;  // longest wait of the background for the link, and so the longest delay of telemetry
constexpr std::uint64_t kLook_ns = 20'000'000;  // interval of the checks of servo and background
constexpr std::uint64_t kFeed_us = 200'000;     // interval of feeding the watchdogs
// Longest time without progress for which the watchdogs are still fed. The background checks and saves a
// scene in one cycle: 64 MB on a slow card.
constexpr std::uint32_t kTickLimit_us = 100'000, kRoundLimit_us = 10'000'000;

std::uint64_t now_us() { return monotonic_ns() / 1000; }

// The names without duplicates, separated by commas.
std::string names(const std::vector<Missing>& missing) {
  std::string all;
  for (const Missing& one : missing)
    if (all.find(one.name) == std::string::npos) all += (all.empty() ? "" : ",") + one.name;
  return all;
}

firmware::Config controller_config(const BoardConfig& board, const LinkPorts& ports, const Devices& devices,
                                   const std::string& lacks, const char* reset_reason) {
  firmware::Config config;
  config.period_s = static_cast<float>(1.0 / board.rate_Hz);
  config.arm_count = static_cast<std::uint8_t>(board.arms.size());
  config.work_units = board.work_units;
  config.node_id = board.node;
  config.bus_bits_per_s = ports.classic_bits_per_s();
  config.serial_number = board.serial_number.c_str();
  config.board = "linux";
  config.board_data = &devices.measured();
  config.reset_reason = reset_reason;
  config.utc_s = wall_clock_s();
  config.lacks = lacks.c_str();
  for (std::size_t i = 0; i < board.arms.size(); ++i) {
    config.arm[i].model = board.arms[i].model.c_str();
    config.arm[i].base = board.arms[i].base;
    config.arm[i].has_index = board.arms[i].index.has_value();
  }
  return config;
}

// Runs the background of the controller in a thread, from construction to stop().
class Background {
 public:
  Background(firmware::Controller& controller, LinkPorts& ports, BoardLiveness& liveness)
      : controller_(controller), ports_(ports), liveness_(liveness), thread_([this] { run(); }) {}
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;
  ~Background() { stop(); }
  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] bool ended() const {
    return ended_;
  }  // by itself, because of restart() or an exception, see rethrow()
  [[nodiscard]] bool restart() const { return restart_; }  // requested by a host
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void run() {
    pthread_setname_np(pthread_self(), "thimble-link");
    try {
      while (!stopping_ && !restart_) round();
    } catch (...) {
      failure_ = std::current_exception();
    }
    ended_ = true;
  }
  void round() {
    while (const std::optional<firmware::link::CanFrame> frame = ports_.receive()) {
      controller_.on_frame(*frame, now_us());
      send();
    }
    controller_.tell_link_losses(static_cast<std::uint32_t>(ports_.dropped()));
    controller_.poll(now_us());
    send();
    liveness_.beat(kBackground);
    ports_.flush();
    if (const std::optional<std::string> news = ports_.news())
      std::cerr << "thimble-board: " << *news << std::endl;
    ports_.wait(kWait_us);
    liveness_.beat(kLink);
    restart_ = controller_.take_reset().has_value();
  }
  void send() {
    for (firmware::link::CanFrame out; controller_.next_frame(out, now_us());) ports_.send(out);
  }

  firmware::Controller& controller_;
  LinkPorts& ports_;
  BoardLiveness& liveness_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> restart_{false};
  std::atomic<bool> ended_{false};
  std::exception_ptr failure_;
  std::thread thread_;  // last member: it uses the others
};

// The signals that end the board; blocked in every thread and received by the main thread.
sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}

void report(const ServoLoop::Report& servo) {
  std::cerr << "thimble-board: " << servo.ticks << " ticks, " << servo.lost << " lost, the latest "
            << servo.worst_late_us << " us late, " << servo.page_faults << " page faults in the servo\n";
}

// The watchdog's driver says until the next boot that it restarted the machine; that is the reason of the first start only.
const char* reason_of(RunMark::Before before, const std::optional<Watchdog>& watchdog) {
  switch (before) {
    case RunMark::Before::kCrashed:
      return "crash";
    case RunMark::Before::kEnded:
      return "";
    case RunMark::Before::kNoRun:
      break;
  }
  return watchdog && watchdog->restarted_machine() ? "watchdog" : "";
}

using ArmImages = std::array<std::uint32_t, firmware::kMaxArms>;  // the CRC-32 of each arm's, 0: none

ArmImages arm_images(SlotFiles& store) {
  const firmware::ArmStore arms(store);
  ArmImages images{};
  for (std::size_t i = 0; i < images.size(); ++i) images[i] = arms.image_crc(i);
  return images;
}

void tell_ready(const LinkPorts& ports, const std::vector<Missing>& missing, ServiceManager& manager,
                bool restarted) {
  for (const std::string& uri : ports.uris()) std::cout << uri << '\n';
  std::cout << "ready" << std::endl;
  if (restarted && manager.watchdog_us() != 0)  // as before tell_new_start()
    manager.tell("WATCHDOG_USEC=" + std::to_string(manager.watchdog_us()));
  manager.tell("READY=1\nSTATUS=" +
               (missing.empty() ? "running" : "cannot arm: " + describe(missing.front())));
}

// The start looks for drives, and the manager's watchdog goes on meanwhile.
void tell_new_start(ServiceManager& manager) {
  manager.tell("WATCHDOG_USEC=" + std::to_string(kStart_us) +
               "\nWATCHDOG=1\nSTATUS=starting with the arm that was uploaded");
}

// Order: make the devices safe, start the guardian, lock memory, and then create what is large or must not
// exist in the guardian. restarted: the program has started itself anew. Returns whether it must again: the store has another arm, and the
// devices were opened for the arm before.
bool run(const BoardConfig& config, bool restarted) {
  const ServoBeat::Shared beat = ServoBeat::make();
  Devices devices(config, *beat);
  Guardian guardian([&devices] { devices.switch_off(); }, *beat, config.priority + 1);
  static std::optional<firmware::Controller> controller;  // static, so it exists before memory is locked
  std::vector<Missing> missing = devices.missing();
  const KernelLatency latency;
  for (const std::string& line : latency.report()) std::cerr << "thimble-board: " << line << '\n';
  if (const std::optional<Missing> memory = lock_memory()) missing.push_back(*memory);
  const std::vector<Missing> realtime = try_realtime(config.priority, config.cpu);
  add(missing, realtime);
  if (realtime.empty()) add(missing, try_realtime(config.priority + 1, std::nullopt));  // the guardian's

  SlotFiles store(config.store, kSceneSlotBytes);
  LinkPorts ports;
  for (const LinkConfig& link : config.links) ports.add(open_port(link, config.node));
  std::optional<Watchdog> watchdog;
  try {
    if (config.watchdog) watchdog.emplace(*config.watchdog, config.watchdog_timeout_s);
    if (!config.watchdog) missing.push_back(no_watchdog(config, ENOENT));
  } catch (const std::system_error& error) {
    missing.push_back(no_watchdog(config, error.code().value()));
  }
  ServiceManager manager;
  BoardLiveness liveness({kTickLimit_us, kRoundLimit_us, kRoundLimit_us});
  ServoLoop servo({config.rate_Hz, config.priority, config.cpu}, devices, liveness);

  const sigset_t signals = ending_signals();
  const char* runtime_folder = std::getenv("RUNTIME_DIRECTORY");  // of systemd
  const RunMark mark(runtime_folder == nullptr ? "" : runtime_folder);
  const char* reset_reason = restarted ? kByHost : reason_of(mark.before(), watchdog);
  const ArmImages arms = arm_images(store);
  const std::vector<Missing> always = missing;
  std::string lacks;
  for (bool again = true; again;) {
    missing = always;
    if (const std::optional<Missing> late = too_late(config, store)) missing.push_back(*late);
    lacks = names(missing);
    for (const Missing& one : missing) std::cerr << "thimble-board: " << describe(one) << '\n';
    controller.emplace(controller_config(config, ports, devices, lacks, reset_reason), store);
    if (servo.start(*controller).size() != realtime.size())
      throw std::runtime_error("the servo thread did not get what it could have had: start again");
    Background background(*controller, ports, liveness);
    tell_ready(ports, missing, manager, restarted);

    const std::uint64_t feed_us =
        manager.watchdog_us() == 0 ? kFeed_us : std::min(kFeed_us, manager.watchdog_us() / 2);
    std::uint64_t fed_us = 0;
    constexpr timespec kLook{0, kLook_ns};
    again = false;
    while (sigtimedwait(&signals, nullptr, &kLook) < 0) {
      if (guardian.gone())
        throw std::runtime_error(
            "the guardian process was ended or stopped: nothing would switch the drives off");
      if (background.ended()) {
        background.rethrow();
        again = background.restart();
        break;
      }
      if (const std::string news = devices.news(); !news.empty())
        std::cerr << "thimble-board: " << news << std::endl;
      if (!liveness.alive(now_us())) continue;  // the watchdogs are not fed
      if (now_us() - fed_us < feed_us) continue;
      fed_us = now_us();
      if (watchdog) (void)watchdog->feed();
      manager.tell("WATCHDOG=1");
    }
    report(servo.stop());
    reset_reason = kByHost;
    if (again && arm_images(store) != arms) {
      tell_new_start(manager);
      if (watchdog) (void)watchdog->disarm();
      return true;
    }
  }
  manager.tell("STOPPING=1");
  if (watchdog) (void)watchdog->disarm();
  return false;
}

// This program once more, from its beginning: the same arguments, and kRestarted. Returns when that failed.
void start_anew(int argc, char** argv) {
  std::vector<char*> arguments(argv, argv + argc);
  std::string flag = kRestarted;
  if (arguments.back() != flag) arguments.push_back(flag.data());
  arguments.push_back(nullptr);
  execv("/proc/self/exe", arguments.data());
}

// Renders the scenes as the servo would, and proposes /work_units. Nothing is opened, and no motor moves.
int measure(const BoardConfig& config, const std::vector<std::string>& files) {
  for (const Missing& one : try_realtime(config.priority, config.cpu))
    std::cerr << "thimble-board: measured without it: " << describe(one) << '\n';
  std::cout << std::fixed << std::setprecision(1);
  double unit_ns = 0;
  for (const std::string& file : files) {
    const std::string image = read_text(file);
    const auto found = measure_work(std::as_bytes(std::span(image)), config.rate_Hz, config.work_units,
                                    config.arms.size(), monotonic_ns);
    if (!found) {
      std::cerr << "thimble-board: " << file
                << " is no scene image with an object; make one with `thimble compile`\n";
      return kFailed;
    }
    std::cout << file << ": the longest tick takes " << found->worst_tick_ns * 1e-3 << " us, a unit "
              << found->unit_ns << " ns, at most " << found->most_units << " units a tick\n";
    if (found->most_units >= kTellingUnits) unit_ns = std::max(unit_ns, found->unit_ns);
  }
  if (unit_ns == 0) {
    std::cerr << "thimble-board: no tick of these scenes has " << kTellingUnits
              << " units, too few to measure one; add a scene that takes more, such as ring\n";
    return kFailed;
  }
  std::cout << "the configuration has " << config.work_units << " units, which take "
            << config.work_units * unit_ns * 1e-3 << " us of a period of " << 1e6 / config.rate_Hz << " us\n"
            << "\"work_units\": " << proposed_work_units(unit_ns, config.rate_Hz, config.arms.size())
            << " would be a quarter of the period\n";
  return 0;
}

int main_of(int argc, char** argv) {
  std::string file = "/etc/thimble/board.json";
  bool only_check = false;
  std::string device;
  std::vector<std::string> scenes;
  bool restarted = false;
  CLI::App app{"The controller of a Thimble haptic arm on an embedded Linux board", "thimble-board"};
  app.set_version_flag("--version", "thimble-board " THIMBLE_VERSION);
  app.add_option("--config", file, "configuration of this board, see docs/board-linux.md")
      ->capture_default_str();
  app.add_flag("--check", only_check,
               "say which devices and privileges are missing, what a tick takes, and end");
  app.add_option("--uses", device,
                 "end with 0 if the configuration names this device, with 3 if not (udev rule)");
  app.add_option("--measure", scenes,
                 "say what rendering these scene images takes here, propose work_units, and end; with "
                 "--check: count it in")
      ->type_name("IMAGE...");
  app.add_flag(kRestarted, restarted)->group("");  // of start_anew() alone
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  if (restarted) pthread_setname_np(pthread_self(), "thimble-board");  // it would be "exe"
  const sigset_t signals = ending_signals();
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  try {
    const BoardConfig config = read_board_config(file, stored_arms);
    if (!device.empty()) return names_device(config, device) ? 0 : kNotFound;
    if (only_check) return check_board(config, scenes);
    if (!scenes.empty()) return measure(config, scenes);
    if (!run(config, restarted)) return 0;
    start_anew(argc, argv);
    throw std::system_error(errno, std::generic_category(), "the program cannot start itself anew");
  } catch (const ConfigError& error) {
    std::cerr << "thimble-board: " << error.what() << "\n  remedy: " << error.remedy << '\n';
    return kBadConfig;
  } catch (const std::exception& error) {
    std::cerr << "thimble-board: " << error.what() << '\n';
    return kFailed;
  }
}

}  // namespace
}  // namespace thimble::board

int main(int argc, char** argv) { return thimble::board::main_of(argc, argv); }
