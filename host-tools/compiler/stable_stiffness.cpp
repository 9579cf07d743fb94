#include "host-tools/compiler/stable_stiffness.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "board/files/json_value.h"
#include "host-tools/compiler/checked_scene.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

// From docs/stability.md; compiler_test compares.
constexpr std::array<StableStiffness, 2> kTables = {{
    {"premium-1.5",
     {{{4600, 11000, 23000}, {4600, 11000, 23000}, {3800, 13000, 28000}, {1000, 6600, 34000}}}},
    {"premium-1.5-frictionless",
     {{{3100, 9500, 19000}, {3100, 11000, 23000}, {2600, 11000, 23000}, {0, 2600, 28000}}}},
}};

double between(double a, double b, double part) { return a + part * (b - a); }

struct Point {
  double at, value;
};
// points: with rising `at`, at least one. Linear between them, outside of them as at the end.
double interpolated(std::span<const Point> points, double at) {
  if (at <= points.front().at) return points.front().value;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point &a = points[i - 1], &b = points[i];
    if (at <= b.at) return between(a.value, b.value, (at - a.at) / (b.at - a.at));
  }
  return points.back().value;
}

// With two digits, as in the table.
double two_digits(double value) {
  if (value < 100.0) return std::floor(value);
  double unit = 10.0;
  while (value >= 100.0 * unit) unit *= 10.0;
  return std::floor(value / unit) * unit;
}

struct Wall {
  double stiffness_N_m;
  double damping_N_s_m;
};

// The one of an object that is farthest above its limit.
std::vector<Wall> walls_of(const scene::Object& object) {
  const scene::Material& material = *object.material();
  const auto damping = static_cast<double>(material.damping_n_s_per_m());
  std::vector<Wall> walls = {{static_cast<double>(material.stiffness_n_per_m()), damping}};
  if (const scene::Needle* needle = object.shape_as_Needle())  // a layer that has not torn yet has no damping
    for (const scene::Layer* layer : *needle->layers())
      walls.push_back({static_cast<double>(layer->stiffness_n_per_m()), 0.0});
  const scene::Surface* surface = object.surface();
  if (surface == nullptr || surface->stiffness_map() == nullptr) return walls;
  const scene::StiffnessMap& map = *surface->stiffness_map();
  walls.clear();
  for (flatbuffers::uoffset_t i = 0; i < map.stiffness_n_per_m()->size(); ++i) {
    const auto* dampings = map.damping_n_s_per_m();
    walls.push_back({static_cast<double>(map.stiffness_n_per_m()->Get(i)),
                     dampings == nullptr ? damping : static_cast<double>(dampings->Get(i))});
  }
  return walls;
}

std::string text_of(double value) {
  std::string text = board::number(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

// Of a damping above those that are known nothing is known, but that it takes stiffness away.
std::string warning_of_damping(const scene::Object& object, const ArmWalls& arm, double rate_Hz) {
  double most_N_s_m = 0.0, known_N_s_m = 0.0;
  for (const Wall& wall : walls_of(object)) most_N_s_m = std::max(most_N_s_m, wall.damping_N_s_m);
  for (const HeldWall& wall : arm.walls) known_N_s_m = std::max(known_N_s_m, wall.damping_N_s_m);
  if (arm.walls.empty() || most_N_s_m <= known_N_s_m || !(rate_Hz > 0.0)) return {};
  return object.name()->str() + ": a damping of " + text_of(most_N_s_m) + " N s/m can oscillate; " + arm.arm +
         " is known to hold up to " + text_of(known_N_s_m) + " N s/m (" + arm.source + ")";
}

// Empty: the arm holds it, or nothing is known.
std::string warning_of(const scene::Object& object, const ArmWalls& arm, double rate_Hz) {
  Wall worst{};
  double worst_most_N_m = 0.0;
  double excess = 1.0;
  for (const Wall& wall : walls_of(object)) {
    const std::optional<double> most_N_m = stable_stiffness_N_m(arm.walls, rate_Hz, wall.damping_N_s_m);
    if (!most_N_m || wall.stiffness_N_m <= *most_N_m * excess) continue;
    worst = wall;
    worst_most_N_m = *most_N_m;
    excess = *most_N_m > 0.0 ? wall.stiffness_N_m / *most_N_m : 1.0e9;
  }
  if (worst.stiffness_N_m == 0.0) return warning_of_damping(object, arm, rate_Hz);
  return object.name()->str() + ": " + text_of(worst.stiffness_N_m) + " N/m with a damping of " +
         text_of(worst.damping_N_s_m) + " N s/m can oscillate; " + arm.arm + " at " +
         text_of(std::round(rate_Hz)) + " Hz holds up to " + text_of(two_digits(worst_most_N_m)) + " N/m (" +
         arm.source + ")";
}

}  // namespace

std::span<const StableStiffness> stable_stiffness() { return kTables; }

ArmWalls known_walls(std::string_view arm) {
  ArmWalls known{.arm = std::string(arm), .walls = {}};
  const auto table = std::ranges::find(kTables, arm, &StableStiffness::arm);
  if (table == kTables.end()) return known;
  known.walls.reserve(kStableDampings_N_s_m.size() * kStableRates_Hz.size());
  for (std::size_t row = 0; row < kStableDampings_N_s_m.size(); ++row)
    for (std::size_t column = 0; column < kStableRates_Hz.size(); ++column)
      known.walls.push_back(
          {kStableRates_Hz[column], kStableDampings_N_s_m[row], table->most_N_m[row][column]});
  return known;
}

std::optional<double> stable_stiffness_N_m(std::span<const HeldWall> walls, double rate_Hz,
                                           double damping_N_s_m) {
  if (walls.empty() || !(rate_Hz > 0.0)) return std::nullopt;
  std::map<double, std::vector<Point>> dampings;  // by the rate
  for (const HeldWall& wall : walls)
    dampings[wall.rate_Hz].push_back({wall.damping_N_s_m, wall.stiffness_N_m});
  std::vector<Point> rates;
  rates.reserve(dampings.size());
  for (auto& [rate, points] : dampings) {
    std::ranges::sort(points, {}, &Point::at);
    rates.push_back({rate, interpolated(points, damping_N_s_m)});
  }
  return std::min(rate_Hz / rates.front().at, 1.0) * interpolated(rates, rate_Hz);
}

std::optional<double> stable_stiffness_N_m(std::string_view arm, double rate_Hz, double damping_N_s_m) {
  return stable_stiffness_N_m(known_walls(arm).walls, rate_Hz, damping_N_s_m);
}

std::vector<std::string> names_of_arms(std::string_view arms) {
  std::vector<std::string> all;
  while (!arms.empty()) {
    const std::size_t end = std::min(arms.find(','), arms.size());
    all.emplace_back(arms.substr(0, end));
    arms.remove_prefix(std::min(end + 1, arms.size()));
  }
  return all;
}

std::vector<std::string> stiffness_warnings(std::span<const std::byte> image, std::span<const ArmWalls> arms,
                                            double rate_Hz) {
  const CheckedScene checked(image);
  std::vector<std::string> warnings;
  if (checked.scene() == nullptr) return warnings;
  for (const scene::Object* object : *checked.scene()->objects()) {
    if (object->shape_type() == scene::Shape::PotentialField) continue;
    for (const ArmWalls& arm : arms) {
      const std::string warning = warning_of(*object, arm, rate_Hz);
      if (!warning.empty() && std::ranges::find(warnings, warning) == warnings.end())
        warnings.push_back(warning);
    }
  }
  return warnings;
}

std::vector<std::string> stiffness_warnings(std::span<const std::byte> image, std::string_view arms,
                                            double rate_Hz) {
  std::vector<ArmWalls> known;
  for (const std::string& arm : names_of_arms(arms)) known.push_back(known_walls(arm));
  return stiffness_warnings(image, known, rate_Hz);
}

}  // namespace thimble::host
