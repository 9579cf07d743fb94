// Arms with drives on CAN in simulated time: ArmDevices with a converter, an enable line and counters in memory, and emulated drives on buses
// that are socketpairs.
#pragma once

#include <fcntl.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "board/linux/arm_devices.h"
#include "board/sim/drives/driven_arm.h"
#include "board/sim/hand_path.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/no_heap_guard.h"
#include "tests/unit/drives/rig.h"

namespace thimble::test {

using board::ArmDevices;
using board::ArmParts;
using board::ArmWiring;
using board::DriveHost;
using board::DriveSet;
using board::DriveWiring;
using board::kArmJoints;
using board::ServoBeat;

struct MemoryEncoders final : board::EncoderReader {
  std::optional<board::EncoderSample> read(std::uint64_t now_ns) noexcept override {
    if (silent) return std::nullopt;
    return board::EncoderSample{counts, now_ns};
  }
  std::array<std::uint32_t, kArmJoints> counts{};
  bool silent = false;
};
struct MemoryDac final : board::CurrentOutput {
  bool write(const std::array<float, kArmJoints>& wanted_A) noexcept override {
    if (!broken) current_A = wanted_A;
    return !broken;
  }
  std::array<float, kArmJoints> current_A{};
  bool broken = false;
};
struct MemorySwitch final : board::SwitchOutput {
  bool set(bool wanted) noexcept override {
    active = wanted;
    return true;
  }
  bool active = false;
};

inline DriveWiring wiring_of(const DriveConfig& config, const std::string& interface = "can0",
                             float direction = 1) {
  DriveWiring wiring;
  wiring.interface = interface;
  wiring.config = config;
  wiring.config.items = {};
  for (const board::drives::ConfigItem& item : config.items)
    wiring.items.push_back({item.name, item.number, item.integer, item.value});
  wiring.direction = direction;
  return wiring;
}

// The first joints of one arm by counter and converter, the others by drives; `prepare` may spoil a drive before the search begins.
class DrivenRig {
 public:
  using Prepare = std::function<void(DrivenRig&)>;
  explicit DrivenRig(board::DriveWirings drives, const Prepare& prepare = {}, double rate_Hz = 1000)
      : period_us(static_cast<std::uint64_t>(1e6 / rate_Hz)) {
    wiring.model = "premium-1.5";
    wiring.arm = kinematics::built_in_arm(wiring.model);
    wiring.drives = std::move(drives);
    wiring.encoders.emplace();
    bool own = false;
    for (std::size_t j = 0; j < emulated.size(); ++j) {
      if (wiring.drives[j]) {
        const DriveWiring& drive = *wiring.drives[j];
        auto bus = buses.find(drive.interface);
        if (bus == buses.end()) {
          auto ends = socket_pair();
          bus = buses.emplace(drive.interface, Bus{std::move(ends.first), {}}).first;
          bus->second.emulated = std::make_unique<EmulatedBus>(std::move(ends.second));
        }
        DriveConfig config = drive.config;
        emulated[j] = &bus->second.emulated->add(emulated_of(config));
      } else {
        wiring.encoders->counter[j] = {"counter0", static_cast<unsigned>(j)};
        own = true;
      }
    }
    if (!own) wiring.encoders.reset();
    if (prepare) prepare(*this);
    DriveHost host;
    host.open = [this](const std::string& interface, bool, board::drives::BusRate&, bool&) {
      const auto bus = buses.find(interface);
      if (bus == buses.end() || bus->second.absent)
        return board::drives::OpenedBus{{}, "cannot use " + interface};
      return board::drives::OpenedBus{board::Descriptor(fcntl(bus->second.host.get(), F_DUPFD_CLOEXEC, 0)),
                                      {}};
    };
    host.now_us = [this] { return now_us; };
    host.sleep_until = [this](std::uint64_t time_us) { run_until(time_us); };
    auto set = std::make_unique<DriveSet>(std::span(&wiring, 1), rate_Hz, host);
    drives_ = set.get();
    std::vector<ArmParts> parts(1);
    parts[0].needs_encoders = parts[0].needs_dac = own;
    if (own) {
      parts[0].encoders = std::unique_ptr<MemoryEncoders>(encoders = new MemoryEncoders);
      parts[0].dac = std::unique_ptr<MemoryDac>(dac = new MemoryDac);
      parts[0].enable = std::unique_ptr<MemorySwitch>(enable = new MemorySwitch);
    }
    devices = std::make_unique<ArmDevices>(std::move(parts), std::move(set), *beat);
    in.dead_man = true;
  }

  void run_until(std::uint64_t time_us) {
    while (now_us < time_us) {
      now_us = std::min(now_us + 50, time_us);
      for (auto& [name, bus] : buses)
        if (!bus.stopped) bus.emulated->run(now_us);
      if (arm) arm->advance(now_us, 0);
    }
  }
  // From now on the simulated arm is behind the drives, held by a hand.
  void attach_arm(const board::HandPath& path) {
    const auto parameters = board::PlantParameters::from(*board::find_plant_variant("premium-1.5"));
    arm.emplace(board::SimArm(parameters.model, board::Plant(parameters, board::Hand{})), path,
                std::vector(emulated.begin(), emulated.end()));
  }
  // The servo's tick: what is read is in `in`, what is written in `out`, which `control` may set in between.
  void tick(unsigned ticks = 1) {
    for (unsigned i = 0; i < ticks; ++i) {
      const std::uint64_t begin_us = now_us;
      ++in.tick;
      in.time_us = now_us;
      {
        const NoHeapGuard guard;
        devices->read(in, now_us * 1000, period_us * 1000);
      }
      if (control) control(*this);
      run_until(begin_us + 100);  // what the controller takes
      {
        const NoHeapGuard guard;
        devices->write(out, true, now_us * 1000);
      }
      for (auto& [name, bus] : buses)
        if (!bus.stopped) bus.emulated->run(now_us);
      run_until(begin_us + period_us);
    }
  }
  // Enabled until every drive gives its torque.
  [[nodiscard]] bool start() {
    out.mode = firmware::Mode::kArmed;
    out.arm[0].enable = true;
    for (int i = 0; i < 1500 && drives_->gain() < 1; ++i) tick();
    return drives_->gain() == 1;
  }
  void fault_latched() {
    out.mode = firmware::Mode::kFaulted;
    out.arm[0].enable = false;
  }
  void fault_cleared() {
    out.mode = firmware::Mode::kReady;
    tick();
  }
  [[nodiscard]] bool any_power() const {
    return std::ranges::any_of(emulated,
                               [](const EmulatedDrive* one) { return one != nullptr && one->powered(); });
  }
  [[nodiscard]] DriveSet& set() { return *drives_; }
  [[nodiscard]] std::string missing() const {
    std::string all;
    for (const board::Missing& one : drives_->missing())
      all += one.name + ": " + one.what + "; " + one.remedy + "\n";
    return all;
  }

  struct Bus {
    board::Descriptor host;
    std::unique_ptr<EmulatedBus> emulated;
    bool absent = false;   // no such interface
    bool stopped = false;  // its drives do not act
  };
  std::map<std::string, Bus> buses;
  std::array<EmulatedDrive*, 3> emulated{};  // of the premium's joints
  std::uint64_t period_us;
  std::uint64_t now_us = 1'000'000;
  ArmWiring wiring;
  MemoryEncoders* encoders = nullptr;
  MemoryDac* dac = nullptr;
  MemorySwitch* enable = nullptr;
  ServoBeat::Shared beat = ServoBeat::make();
  firmware::Inputs in;
  firmware::Outputs out;
  std::function<void(DrivenRig&)> control;
  std::unique_ptr<ArmDevices> devices;
  std::optional<board::emulated::DrivenArm> arm;

 private:
  DriveSet* drives_ = nullptr;
};

}  // namespace thimble::test
