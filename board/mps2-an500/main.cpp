// The program of this board: the tick in the SysTick interrupt; SLCAN on UART 0 and all long work in the
// background.
#include <atomic>
#include <cstdint>

#include "board/common/liveness.h"
#include "board/common/stop_path.h"
#include "board/common/work_units.h"
#include "board/cortex/fabric.h"
#include "board/cortex/runtime.h"
#include "board/cortex/tick.h"
#include "board/mps2-an500/board.h"
#include "board/mps2-an500/clock.h"
#include "board/mps2-an500/drives.h"
#include "board/mps2-an500/eeprom_storage.h"
#include "board/mps2-an500/registers.h"
#include "board/mps2-an500/restart.h"
#include "board/mps2-an500/uart.h"
#include "firmware/controller.h"
#include "firmware/link/slcan_port.h"

namespace thimble::board {
namespace {

namespace link = firmware::link;

enum Context : std::size_t { kTick, kLink, kBackground, kContexts };

firmware::Controller* controller = nullptr;
Drives* fabric = nullptr;
constinit Liveness<kContexts> liveness({kTickLimit_us, kBackgroundLimit_us, kBackgroundLimit_us});
float last_tick_us = 0;

// The independent stop path of this board is the watchdog: its time-out is that of the stop, its interrupt
// cannot be masked, and only the tick feeds it.
std::uint32_t timeouts_to_restart = 0;
std::atomic<std::uint32_t> timeouts{0};  // in a row

void start_watchdog(std::uint32_t timeout_us) noexcept {
  timeouts_to_restart = kWatchdog_ms * 1000 / timeout_us;
  word(kWatchdogLock) = kWatchdogKey;
  volatile WatchdogRegisters& watchdog = at<WatchdogRegisters>(kWatchdogUnit);
  watchdog.load = kClock_Hz / 1'000'000 * timeout_us;
  watchdog.control = 3;
}
void restart_timeout() noexcept { at<WatchdogRegisters>(kWatchdogUnit).clear = 1; }

void feed_watchdog() noexcept {
  restart_timeout();
  timeouts.store(0, std::memory_order_relaxed);
}

void send(link::SlcanPort& port, link::Micros now) noexcept {
  link::CanFrame frame;
  link::SlcanLine line;
  while (uart::room() >= line.size() && controller->next_frame(frame, now)) {
    if (port.open()) static_cast<void>(uart::put({line.data(), link::encode_slcan(frame, line)}));
  }
}

void receive(link::SlcanPort& port, link::Micros now) noexcept {
  for (char byte = 0; uart::take(byte);) {
    const link::SlcanPort::Event event = port.push(byte);
    if (event == link::SlcanPort::Event::kClosed) uart::forget();
    static_cast<void>(uart::put(port.reply()));
    if (event == link::SlcanPort::Event::kFrame) {
      controller->on_frame(port.frame(), now);
      send(port, now);
    }
  }
}

[[noreturn]] void run() noexcept {
  link::SlcanPort port;
  for (;;) {
    // No WFI: with instruction counting QEMU loses the SysTick interrupt, and saving power is not needed.
    const link::Micros now = clock::now_us();
    receive(port, now);
    send(port, now);
    liveness.beat(kLink);
    controller->tell_link_losses(uart::dropped());
    controller->poll(now);
    if (controller->take_reset()) {
      while (!uart::sent() && clock::now_us() - now < kBackgroundLimit_us) {
      }
      restart(Restart::kHost);
    }
    liveness.beat(kBackground);
  }
}

}  // namespace

void crash(std::uint32_t /*address*/) noexcept {
  if (fabric != nullptr) fabric->off();
  restart(Restart::kCrash);
}

extern "C" void on_sys_tick() {
  const TickTime time = clock::begin_tick();
  run_tick(*fabric, *controller, time, last_tick_us);
  last_tick_us = clock::since_begin_us();
  liveness.beat(kTick);
  // In the tick, because the background may check an image for longer than the watchdog waits.
  if (liveness.alive(time.time_us)) feed_watchdog();
}

// Interrupt of each time-out. The last one is not cleared, so the next time-out resets the board.
extern "C" void on_watchdog() {
  fabric->cut();
  const std::uint32_t count = timeouts.load(std::memory_order_relaxed) + 1;
  timeouts.store(count, std::memory_order_relaxed);
  if (count < timeouts_to_restart) return restart_timeout();
  remember(Restart::kWatchdog);
  for (;;) {
  }
}

extern "C" void run_board() {
  static const Fabric logic(kFabric, kArms);
  static Drives drives(logic);
  fabric = &drives;
  uart::start();
  static EepromStorage storage;
  firmware::Config config;
  config.period_s = 1.0F / static_cast<float>(kRate_Hz);
  config.arm_count = kArms;
  config.work_units = work_units(config.period_s, kArms);
  for (firmware::ArmConfig& arm : config.arm) arm.model = kArmModel;
  config.node_id = kNode;
  config.block_bytes = kBlockBytes;
  config.board = "mps2-an500";
  config.reset_reason = take_restart_reason();
  const StopPath stop = saved_stop_path(storage, kRate_Hz);
  config.lacks = !logic.present() ? "no_fabric" : !storage.present() ? "no_eeprom" : stop.lacks;
  static firmware::Controller the_controller(config, storage);
  controller = &the_controller;
  logic.start_watchdog(stop.timeout_us);
  clock::start(kRate_Hz);
  start_watchdog(stop.timeout_us);
  run();
}

}  // namespace thimble::board
