// The servo thread with devices in memory: ticks keep their number and time, a delay loses ticks that are
// counted, and the devices are safe when the thread ends.
#include "board/linux/servo_loop.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "board/linux/realtime.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using board::BoardLiveness;
using board::ServoLoop;
using namespace std::chrono_literals;

class MemoryDevices final : public board::TickDevices {
 public:
  void read(Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept override {
    if (in.tick < next_tick || period_ns != 1'000'000) wrong = true;
    lost += in.tick - next_tick;
    next_tick = in.tick + 1;
    if (now_ns < last_ns || in.time_us != now_ns / 1000) wrong = true;
    last_ns = now_ns;
    in.arm[0].counts = {1000, 2000, 3000};
    in.arm[0].sample_tick = in.tick;
    in.dead_man = true;
    if (in.tick >= delay_at && !delayed) {
      delayed = true;
      std::this_thread::sleep_for(10ms);
    }
  }
  void write(const Outputs& out) noexcept override {
    mode = out.mode;
    ++writes;
    written_tick = next_tick - 1;
  }
  void make_safe() noexcept override { ++made_safe; }

  // Returns when the servo has written the outputs of this tick or a later one, however late the machine lets
  // it run.
  void wait_for_tick(std::uint64_t tick) const {
    while (written_tick < tick) std::this_thread::sleep_for(1ms);
  }

  std::uint64_t delay_at =
      ~std::uint64_t{0};  // the first tick from here on takes 10 ms; set before the start
  std::atomic<std::uint64_t> written_tick{0};
  std::atomic<Mode> mode{Mode::kDisarmed};
  std::atomic<int> made_safe{0};
  // The servo's own.
  std::uint64_t next_tick = 0, lost = 0, last_ns = 0, writes = 0;
  bool wrong = false, delayed = false;
};

firmware::Config config() {
  firmware::Config config;
  config.period_s = 1e-3F;
  return config;
}

TEST(ServoLoop, TicksLosesAndCounts) {
  TestStorage storage;
  Controller controller(config(), storage);
  MemoryDevices devices;
  devices.delay_at = 100;
  BoardLiveness liveness({1'000'000, 1'000'000, 1'000'000});
  ServoLoop servo({1000.0, 1, std::nullopt}, devices, liveness);
  const auto begin = std::chrono::steady_clock::now();
  (void)servo.start(controller);
  devices.wait_for_tick(200);
  ASSERT_EQ(controller.request(Command::kHome), 0);
  while (devices.mode != Mode::kReady) std::this_thread::sleep_for(1ms);
  devices.wait_for_tick(390);
  EXPECT_EQ(devices.mode, Mode::kReady);
  EXPECT_EQ(devices.made_safe, 0);
  const ServoLoop::Report report = servo.stop();
  const auto periods = static_cast<std::uint64_t>(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  EXPECT_FALSE(devices.wrong);
  EXPECT_EQ(report.ticks, devices.writes);
  EXPECT_EQ(report.lost, devices.lost);
  EXPECT_GE(report.lost, 9U);  // of the delay
  EXPECT_GE(report.worst_late_us, 9000.0F);
  EXPECT_GE(report.ticks + report.lost, 390U);
  EXPECT_LE(report.ticks + report.lost, periods + 1);
  EXPECT_EQ(devices.made_safe, 1);
  std::printf("%llu ticks, %llu lost, %ld page faults\n", static_cast<unsigned long long>(report.ticks),
              static_cast<unsigned long long>(report.lost), report.page_faults);
}

// The restart that a host asks for: the same devices, a new controller.
TEST(ServoLoop, StartsAgain) {
  TestStorage storage;
  MemoryDevices devices;
  BoardLiveness liveness({1'000'000, 1'000'000, 1'000'000});
  ServoLoop servo({1000.0, 1, std::nullopt}, devices, liveness);
  for (int start = 1; start <= 3; ++start) {
    Controller controller(config(), storage);
    devices.next_tick = devices.written_tick = 0;
    (void)servo.start(controller);
    devices.wait_for_tick(10);
    EXPECT_GT(servo.stop().ticks, 0U);
    EXPECT_EQ(devices.made_safe, start);
  }
  EXPECT_FALSE(devices.wrong);
}

// What the thread may not have is said, and it runs all the same.
TEST(ServoLoop, SaysWhatItCouldNotHave) {
  TestStorage storage;
  Controller controller(config(), storage);
  MemoryDevices devices;
  BoardLiveness liveness({1'000'000, 1'000'000, 1'000'000});
  ServoLoop servo({1000.0, 100, 1023}, devices, liveness);  // neither exists
  const auto missing = servo.start(controller);
  ASSERT_EQ(missing.size(), 2U);
  EXPECT_NE(missing[0].what.find("real-time priority 100"), std::string::npos);
  EXPECT_NE(missing[1].what.find("processor 1023"), std::string::npos);
  devices.wait_for_tick(10);
  EXPECT_GT(servo.stop().ticks, 0U);
}

}  // namespace
}  // namespace thimble::test
