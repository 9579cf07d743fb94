// The same wall twice: calculated here, a thousand times a second and more, and as a scene on the board.
//
//   host_wall [DEVICE [SECONDS]]      thimble-sim --tcp 0 --hand press.csv --loop has a hand that presses it
//
// For each it prints the stiffness that is felt, fitted to forces and tips as the link tells them, and how often and how
// evenly the force was renewed. docs/host-rendering.md is about the difference.
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "host-tools/client/thimble.h"
#include "host-tools/compiler/compile.h"

namespace {

using Vector = std::array<double, 3>;

constexpr double kFloor_m = -0.01;  // below the tip's home position
constexpr double kStiffness_N_m = 300;

Vector wall_N(const Vector& tip_m) {
  const double depth_m = kFloor_m - tip_m[2];
  return {0, 0, depth_m > 0 ? kStiffness_N_m * depth_m : 0};
}

// The same as a scene.
std::string wall_scene() {
  return R"({"thimble_scene": 1, "name": "wall", "objects": [{"name": "wall",
    "shape": {"plane": {"normal": [0, 0, 1], "offset_m": )" +
         std::to_string(kFloor_m) + R"(}}, "material": {"stiffness_N_m": )" + std::to_string(kStiffness_N_m) +
         R"(, "damping_N_s_m": 0, "static_friction": 0, "dynamic_friction": 0}}]})";
}

// What is felt while `each` is called with every reading.
void feel(const char* where, thimble::Device& device, double seconds,
          const std::function<void(const thimble::TipReading&)>& each) {
  constexpr std::uint64_t kPatience_us = 500'000;
  double depth2 = 0, depth_force = 0;
  unsigned touching = 0, readings = 0;
  std::uint64_t longest_us = 0;
  const std::uint64_t begin_us = thimble::now_us();
  std::uint64_t last_us = begin_us;
  while (thimble::now_us() < begin_us + static_cast<std::uint64_t>(seconds * 1e6)) {
    const std::optional<thimble::TipReading> tip = device.next_tip(thimble::now_us() + kPatience_us);
    if (!tip) continue;
    each(*tip);
    ++readings;
    longest_us = std::max(longest_us, tip->heard_us - last_us);
    last_us = tip->heard_us;
    const double depth_m = kFloor_m - tip->position_m[2];
    constexpr double kClear_m = 0.5e-3;  // of the edge, where one of the two may be a reading late
    if (depth_m < kClear_m) continue;
    depth2 += depth_m * depth_m;
    depth_force += depth_m * tip->force_N[2];
    ++touching;
  }
  const double took_s = static_cast<double>(thimble::now_us() - begin_us) * 1e-6;
  std::printf("%s: %.0f readings/s, the longest wait %.1f ms, %u of %u in the wall, felt %.0f N/m of %.0f\n",
              where, readings / took_s, static_cast<double>(longest_us) * 1e-3, touching, readings,
              touching != 0 ? depth_force / depth2 : 0.0, kStiffness_N_m);
  std::fflush(stdout);
}

void run(const std::string& address, double seconds) {
  thimble::Device device = thimble::connect(address);
  device.home();

  // The board's own clock tells how many orders it took in how many of its ticks.
  device.take_over();
  const auto before = device.orders();
  const auto first = device.state();
  feel("wall on the host", device, seconds,
       [&device](const thimble::TipReading& tip) { device.order_force(wall_N(tip.position_m)); });
  const auto after = device.orders();
  const auto last = device.state();
  const double board_s = (last.tick - first.tick) / static_cast<double>(last.tick_rate_Hz);
  std::printf("the board: %u orders taken in %u ticks, %.0f a second, %u old, %u times none in time\n",
              after.taken - before.taken, last.tick - first.tick, (after.taken - before.taken) / board_s,
              after.old - before.old, after.expired - before.expired);
  device.hand_back();

  device.upload(thimble::host::compile_scene_text(wall_scene(), "wall", ".").image, {}, {});
  device.arm();
  feel("wall on the board", device, seconds, [](const thimble::TipReading&) {});
  device.disarm();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc > 1 ? argv[1] : "", argc > 2 ? std::stod(argv[2]) : 5.0);
    return 0;
  } catch (const thimble::Error& error) {
    std::fprintf(stderr, "host_wall: %s: %s\n  remedy: %s\n", error.name.c_str(), error.cause.c_str(),
                 error.remedy.c_str());
    return static_cast<int>(error.code);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_wall: %s\n", error.what());
    return 2;
  }
}
