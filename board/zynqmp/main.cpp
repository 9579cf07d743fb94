// Thimble on the Cortex-R5F of a Zynq UltraScale+: a cyclic executive. The loop runs the tick when it is due,
// otherwise the background. Long background work calls run_due_tick() in between (Config::pause).
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "board/common/liveness.h"
#include "board/common/stop_path.h"
#include "board/common/work_units.h"
#include "board/cortex/fabric.h"
#include "board/cortex/runtime.h"
#include "board/cortex/tick.h"
#include "board/zynqmp/board.h"
#include "board/zynqmp/can.h"
#include "board/zynqmp/clock.h"
#include "board/zynqmp/nor.h"
#include "board/zynqmp/nor_storage.h"
#include "board/zynqmp/registers.h"
#include "board/zynqmp/restart.h"
#include "board/zynqmp/uart.h"
#include "board/zynqmp/watchdog.h"
#include "firmware/controller.h"
#include "firmware/link/slcan_port.h"

namespace thimble::board {
namespace {

namespace link = firmware::link;

constexpr std::optional<CanTiming> kCanTiming = can_timing(kCanClock_Hz, kCanBitrate);
static_assert(kCanTiming, "the controller cannot divide its clock to this bitrate");

// 64 frames of 8 bytes at 1 Mbit/s take 9 ms.
constexpr link::Micros kGoodbye_us = 20'000;

enum Context : std::size_t { kTick, kLink, kBackground, kContexts };

const Fabric* fabric = nullptr;
firmware::Controller* controller = nullptr;
Can* can = nullptr;
float last_tick_us = 0;
bool uart_asked = false;  // the last frame came from the UART, so frames are sent there
constinit Liveness<kContexts> liveness({kTickLimit_us, kBackgroundLimit_us, kBackgroundLimit_us});

void run_due_tick() noexcept {
  if (!clock::tick_due()) return;
  const TickTime time = clock::begin_tick();
  run_tick(*fabric, *controller, time, last_tick_us);
  last_tick_us = clock::since_begin_us();
  liveness.beat(kTick);
  if (liveness.alive(time.time_us))
    feed_watchdog();  // in the tick, because the background may wait for the flash
}

// Sends as many frames as the link accepts now.
void send(const link::SlcanPort& port, link::Micros now) noexcept {
  link::CanFrame frame;
  link::SlcanLine line;
  if (uart_asked && port.open()) {
    while (uart::room() >= line.size() && controller->next_frame(frame, now)) {
      static_cast<void>(uart::put({line.data(), link::encode_slcan(frame, line)}));
      run_due_tick();
    }
  } else {
    while (can->can_send(now) && controller->next_frame(frame, now)) {
      can->send(frame, now);
      run_due_tick();
    }
  }
  uart::feed();
}

// True: a frame was received.
bool receive(link::SlcanPort& port, link::Micros now) noexcept {
  bool any = false;
  for (link::CanFrame frame; can->receive(frame); any = true) {
    uart_asked = false;
    controller->on_frame(frame, now);
    run_due_tick();
    send(port, now);
  }
  for (char byte = 0; uart::take(byte); any = true) {
    const link::SlcanPort::Event event = port.push(byte);
    if (event == link::SlcanPort::Event::kClosed) uart::forget();
    static_cast<void>(uart::put(port.reply()));
    if (event == link::SlcanPort::Event::kFrame) {
      uart_asked = true;
      controller->on_frame(port.frame(), now);
      run_due_tick();
      send(port, now);
    }
  }
  return any;
}

[[noreturn]] void run() noexcept {
  link::SlcanPort port;
  for (;;) {
    run_due_tick();
    const link::Micros now = clock::now_us();
    const bool any = receive(port, now);
    can->supervise(now);
    controller->tell_link_losses(can->counters().overflows + uart::overruns());
    send(port, now);
    liveness.beat(kLink);
    controller->poll(now);
    if (controller->take_reset()) {
      while (clock::now_us() - now < kGoodbye_us) {  // let the answer be sent
        uart::feed();
        run_due_tick();
      }
      fabric->off();
      restart(Restart::kHost);
    }
    liveness.beat(kBackground);
    if (!any) clock::rest();
  }
}

void print(std::string_view text) noexcept { static_cast<void>(uart::put(text)); }

void print_hex(std::uint32_t value) noexcept {
  std::array<char, 8> digits;
  for (std::size_t i = 0; i < digits.size(); ++i)
    digits[i] = "0123456789abcdef"[value >> (28 - 4 * i) & 0xFU];
  print({digits.data(), digits.size()});
}

}  // namespace

void crash(std::uint32_t address) noexcept {
  if (fabric != nullptr) fabric->off();
  restart(Restart::kCrash, address);
}

extern "C" void run_board() {
  stop_watchdog();  // it keeps running over a restart of the program, and reading the scenes takes longer than its limit
  fabric = nullptr;  // a crash from here on must not access what is not set up
  static const Fabric logic(reinterpret_cast<std::uintptr_t>(board_fabric), kArms);
  fabric = &logic;
  clock::start(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(board_core_Hz)));
  uart::start(kUartClock_Hz, kUartBaud);
  const StartReason reason = take_start_reason();
  print("Thimble " THIMBLE_VERSION " zynqmp, started: ");
  print(*reason.name == '\0' ? "not known why" : reason.name);
  if (reason.address != 0) {
    print(" near 0x");
    print_hex(reason.address);
  }
  print("\r\n");
  uart::feed();
  static Nor nor(run_due_tick);
  // In DDR what no tick uses.
  [[gnu::section(".slots")]] static NorStorage storage(nor);
  firmware::Config config;
  config.period_s = 1.0F / static_cast<float>(kRate_Hz);
  config.arm_count = kArms;
  config.work_units = work_units(config.period_s, kArms);
  for (firmware::ArmConfig& arm : config.arm) arm.model = kArmModel;
  config.node_id = kNode;
  config.classic_can = true;
  config.bus_bits_per_s = kCanBitrate;
  config.board = "zynqmp";
  config.reset_reason = reason.name;
  const StopPath stop = saved_stop_path(storage, kRate_Hz);
  config.lacks = !logic.present() ? "no_fabric" : !nor.present() ? "no_flash" : stop.lacks;
  config.pause = run_due_tick;
  static firmware::Controller the_controller(config, storage);
  controller = &the_controller;
  [[gnu::section(".slots")]] static Can the_can(at<CanRegisters>(kCan0), *kCanTiming, kCanBitrate, kNode);
  can = &the_can;
  logic.start_watchdog(stop.timeout_us);
  clock::start_ticks(kRate_Hz);
  start_watchdog(kLsbusClock_Hz, kWatchdog_ms);
  run();
}

}  // namespace thimble::board
