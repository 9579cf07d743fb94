// The whole controller: bytes are frames, requests of several hosts, ticks, inputs of the board and torn storage. In every tick the
// currents are finite and not above their peak, and zero with the drives off unless the motors are on; a stop ends that in the next tick
// and, braked, for good; what the controller sends can stand on a bus, ends, and is no answer of more than 4095 bytes.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "firmware/controller.h"
#include "firmware/link/host_address.h"
#include "firmware/link/iso_tp.h"
#include "tests/fuzz/targets/target.h"
#include "tests/unit/firmware/bench.h"

namespace {

using namespace thimble;
namespace link = firmware::link;

constexpr std::size_t kSlotBytes = std::size_t{16} << 10U;

// A host with the ISO-TP of the real one.
struct FuzzHost {
  std::uint64_t key = 0;  // 0: a tester, that claims no address
  std::uint8_t address = link::kTesterAddress;
  link::IsoTpChannel channel{link::request_id(1), link::response_id(1)};
};

class Run {
 public:
  explicit Run(std::uint8_t kind) : bench_(config(kind), kSlotBytes) {
    hosts_[1].key = 0x1111;
    hosts_[2].key = 0x2222;
    const bool armed = (kind & 8U) != 0;
    if (armed || (kind & 4U) != 0) bench_.load(1000.0F, -0.002F, 1.0F);  // in reach, and not touched
    if (armed) {
      for (firmware::ArmInputs& arm : bench_.inputs.arm) arm.index = true;
      bench_.home();
      bench_.arm();
    }
    bench_.alive = false;
  }

  void step(fuzz::Taker& take) {
    const std::uint8_t what = take.byte();
    FuzzHost& host = hosts_[what >> 4U & 3U];
    switch (what & 15U) {
      case 0:
      case 1:
        return ticks(1U + take.byte() % 64U);
      case 2:
      case 3:
      case 4: {  // a request
        const std::size_t length = what % 16U == 4 ? take.word() % link::kMaxPduBytes : take.byte() % 32U;
        static_cast<void>(host.channel.send(take.bytes(length), now()));
        return exchange();
      }
      case 5:
        return raw_frame(take, host);
      case 6:
        return claim(host, (take.byte() & 1U) != 0 ? link::ClaimAction::kRelease : link::ClaimAction::kClaim,
                     take.byte());
      case 7:
        return stop(take.byte());
      case 8:
        return levels(take.byte());
      case 9: {  // the hand, or a counter that goes wrong
        const std::uint8_t joint = take.byte();
        bench_.joints[joint & 1U][joint >> 1U & 1U] += 1e-5 * static_cast<std::int16_t>(take.word());
        return;
      }
      case 10:  // without a tick for so long
        bench_.halted = true;
        for (unsigned i = 0, n = take.byte(); i < n; ++i) bench_.tick();
        bench_.halted = false;
        return exchange();
      case 11:  // periods that are lost
        bench_.inputs.tick += take.byte();
        return ticks(1);
      case 12:
        bench_.storage.power_left = take.word();
        return;
      case 13:
        return restart();
      case 14:  // the link takes nothing of the controller's
        full_ = !full_;
        return;
      default:
        host.channel.config().fd = !host.channel.config().fd;
    }
  }

  // A stop is the end of every input.
  void end() {
    full_ = false;
    stop(0);
    constexpr float kLongest_s = 2.0F + 0.1F;  // stop_time and the time to come to it
    const auto most = static_cast<int>(kLongest_s / bench_.config.period_s);
    int n = 0;
    while (n++ < most && test::any_enabled(bench_.outputs)) tick();
    fuzz::demand(!test::any_enabled(bench_.outputs) && !test::any_current(bench_.outputs),
                 "a stop ends with the motors off");
  }

 private:
  static firmware::Config config(std::uint8_t kind) {
    firmware::Config config;
    config.period_s = 1e-3F;
    config.arm_count = (kind & 1U) != 0 ? 2 : 1;
    for (firmware::ArmConfig& arm : config.arm) arm.has_index = (kind & 2U) != 0;
    return config;
  }

  [[nodiscard]] link::Micros now() const { return bench_.inputs.time_us; }

  void ticks(unsigned count) {
    for (unsigned i = 0; i < count; ++i) tick();
  }

  void tick() {
    bench_.tick();
    check_outputs();
    if (stopped_) fuzz::demand(bench_.mode() != test::Mode::kArmed, "a stop takes effect in the next tick");
    stopped_ = false;
    exchange();
    if (bench_.controller->take_reset()) restart();
  }

  void check_outputs() const {
    const bool on = firmware::motors_on(bench_.outputs.mode);
    for (std::size_t arm = 0; arm < bench_.outputs.arm.size(); ++arm) {
      const firmware::ArmOutputs& out = bench_.outputs.arm[arm];
      fuzz::demand(on || !out.enable, "the drives are off unless the motors are on");
      for (std::size_t axis = 0; axis < out.current_A.size(); ++axis) {
        const float current_A = out.current_A[axis];
        fuzz::demand(std::isfinite(current_A), "a current is finite");
        fuzz::demand(std::abs(current_A) <= bench_.data[arm].axis[axis].motor.peak_current_A * 1.0001F,
                     "a current is not above its peak");
        fuzz::demand(out.enable || current_A == 0.0F, "a drive that is off gets no current");
      }
    }
  }

  // What the controller sends, to the hosts, and their answers.
  void exchange() {
    constexpr int kMostFrames = 20000;
    int sent = 0;
    for (bool any = true; any && sent < kMostFrames;) {
      any = false;
      link::CanFrame frame;
      while (!full_ && sent < kMostFrames && bench_.controller->next_frame(frame, now())) {
        ++sent;
        any = true;
        check_sent(frame);
        link::HostGrant grant;
        const bool granted = link::from_frame(frame, bench_.config.node_id, grant);
        for (FuzzHost& host : hosts_) {
          if (granted && grant.key == host.key && grant.address != 0) set_address(host, grant.address);
          static_cast<void>(host.channel.on_frame(frame, now()));
          if (!host.channel.received().empty()) host.channel.release();
        }
      }
      for (FuzzHost& host : hosts_) {
        host.channel.poll(now());
        while (sent < kMostFrames && host.channel.next_frame(frame, now())) {
          ++sent;
          any = true;
          bench_.controller->on_frame(frame, now());
        }
      }
    }
    fuzz::demand(sent < kMostFrames, "the controller has said at some time what it has to say");
  }

  static void check_sent(const link::CanFrame& frame) {
    fuzz::demand(link::is_valid(frame), "a frame of the controller can stand on a bus");
    // The first frame of an answer whose length does not fit into 12 bits.
    const bool answer = frame.extended && (frame.id & 0x1FFF00FFU) == link::response_id(1, 0);
    fuzz::demand(!answer || frame.data[0] != 0x10 || frame.data[1] != 0, "an answer has at most 4095 bytes");
  }

  static void set_address(FuzzHost& host, std::uint8_t address) {
    if (host.address == address) return;
    host.address = address;
    host.channel.set_ids(link::request_id(1, address), link::response_id(1, address));
  }

  void raw_frame(fuzz::Taker& take, const FuzzHost& host) {
    const std::uint8_t kind = take.byte();
    link::CanFrame frame;
    frame.extended = (kind & 1U) != 0;
    frame.id = frame.extended ? (kind & 2U) != 0
                                    ? link::request_id(1, host.address)
                                    : (take.word() | std::uint32_t{take.word()} << 16U) & 0x1FFFFFFFU
                              : take.word() & 0x7FFU;
    frame.fd = (kind & 4U) != 0;
    frame.remote = !frame.fd && (kind & 8U) != 0;
    const std::size_t length = take.byte() % (frame.fd ? 65U : 9U);
    const auto data = take.bytes(length);
    std::ranges::copy(data, frame.data.begin());
    frame.size = frame.fd ? link::fd_size(length) : static_cast<std::uint8_t>(length);
    bench_.controller->on_frame(frame, now());
    exchange();
  }

  void claim(const FuzzHost& host, link::ClaimAction action, std::uint8_t salt) {
    bench_.controller->on_frame(link::to_frame(link::HostClaim{host.key, action}, 1, salt), now());
    exchange();
  }

  void stop(std::uint8_t kind) {
    link::CanFrame frame;
    frame.id = link::EmergencyStop::kId;
    frame.remote = (kind & 1U) != 0;
    frame.size = (kind & 2U) != 0 ? 8 : 0;
    bench_.controller->on_frame(frame, now());
    stopped_ = true;
    tick();
  }

  void levels(std::uint8_t bits) {
    bench_.inputs.e_stop = (bits & 1U) != 0;
    bench_.inputs.dead_man = (bits & 2U) == 0;
    bench_.sampling = (bits & 4U) == 0;
    bench_.frozen = (bits & 8U) != 0;
    bench_.inputs.arm[bits >> 7U].index = (bits & 16U) != 0;
    bench_.inputs.arm[bits >> 7U].drive_fault = (bits & 32U) != 0;
    bench_.counter_bits = (bits & 64U) != 0 ? 0xFFFFU : 0xFFFFFFFFU;
  }

  // Power off and on: what the storage holds is what is left.
  void restart() {
    bench_.storage.power_left = std::numeric_limits<std::size_t>::max();
    bench_.controller = std::make_unique<test::Controller>(bench_.config, bench_.storage);
    bench_.outputs = {};
  }

  test::Bench bench_;
  std::array<FuzzHost, 4>
      hosts_;  // the first and the last without an address: two testers that are one to the controller
  bool full_ = false;
  bool stopped_ = false;  // since the last tick
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Taker take({data, size});
  Run run(take.byte());
  constexpr int kMostSteps = 200;
  for (int step = 0; step < kMostSteps && !take.empty(); ++step) run.step(take);
  run.end();
  return 0;
}
