#include "host-tools/compiler/stable_stiffness.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "board/files/json_value.h"
#include "control/scene/scene_view.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

// From docs/stability.md; compiler_test compares.
constexpr std::array<StableStiffness, 2> kTables = {{
    {"premium-1.5",
     {{{4600, 11000, 23000}, {4600, 11000, 19000}, {3800, 13000, 23000}, {1000, 6600, 19000}}}},
    {"premium-1.5-frictionless",
     {{{3100, 9500, 16000}, {3100, 11000, 19000}, {2600, 11000, 19000}, {0, 2200, 19000}}}},
}};

// The place of a value among rising ones: between `below` and the next, by `part`; outside of them, at an end.
struct Place {
  std::size_t below;
  double part;
};

template <std::size_t kCount>
Place place_of(const std::array<double, kCount>& values, double value) {
  std::size_t below = 0;
  while (below + 2 < kCount && value > values[below + 1]) ++below;
  return {below, std::clamp((value - values[below]) / (values[below + 1] - values[below]), 0.0, 1.0)};
}

double between(double a, double b, double part) { return a + part * (b - a); }

// With two digits, as in the table.
double two_digits(double value) {
  if (value < 100.0) return std::floor(value);
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
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

std::vector<std::string_view> split(std::string_view names) {
  std::vector<std::string_view> all;
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(','), names.size());
    if (const std::string_view name = names.substr(0, end); std::ranges::find(all, name) == all.end())
      all.push_back(name);
    names.remove_prefix(std::min(end + 1, names.size()));
  }
  return all;
}

std::string text_of(double value) {
  std::string text = board::number(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

// Of a damping above those of the tables nothing is known, but that it takes stiffness away.
void warn_of_damping(const scene::Object& object, std::string_view arm, double rate_Hz,
                     std::vector<std::string>& warnings) {
  double most_N_s_m = 0.0;
  for (const Wall& wall : walls_of(object)) most_N_s_m = std::max(most_N_s_m, wall.damping_N_s_m);
  if (most_N_s_m <= kStableDampings_N_s_m.back() || !stable_stiffness_N_m(arm, rate_Hz, most_N_s_m)) return;
  warnings.push_back(object.name()->str() + ": a damping of " + text_of(most_N_s_m) +
                     " N s/m can oscillate; " + std::string(arm) + " is known to hold up to " +
                     text_of(kStableDampings_N_s_m.back()) + " N s/m (docs/stability.md)");
}

void warn(const scene::Object& object, std::string_view arm, double rate_Hz,
          std::vector<std::string>& warnings) {
  Wall worst{};
  double worst_most_N_m = 0.0;
  double excess = 1.0;
  for (const Wall& wall : walls_of(object)) {
    const std::optional<double> most_N_m = stable_stiffness_N_m(arm, rate_Hz, wall.damping_N_s_m);
    if (!most_N_m || wall.stiffness_N_m <= *most_N_m * excess) continue;
    worst = wall;
    worst_most_N_m = *most_N_m;
    excess = *most_N_m > 0.0 ? wall.stiffness_N_m / *most_N_m : 1.0e9;
  }
  if (worst.stiffness_N_m == 0.0) return warn_of_damping(object, arm, rate_Hz, warnings);
  warnings.push_back(object.name()->str() + ": " + text_of(worst.stiffness_N_m) + " N/m with a damping of " +
                     text_of(worst.damping_N_s_m) + " N s/m can oscillate; " + std::string(arm) + " at " +
                     text_of(std::round(rate_Hz)) + " Hz holds up to " + text_of(two_digits(worst_most_N_m)) +
                     " N/m (docs/stability.md)");
}

}  // namespace

std::span<const StableStiffness> stable_stiffness() { return kTables; }

std::optional<double> stable_stiffness_N_m(std::string_view arm, double rate_Hz, double damping_N_s_m) {
  const auto* const table = std::ranges::find(kTables, arm, &StableStiffness::arm);
  if (table == kTables.end() || !(rate_Hz > 0.0)) return std::nullopt;
  const Place damping = place_of(kStableDampings_N_s_m, damping_N_s_m);
  const Place rate = place_of(kStableRates_Hz, rate_Hz);
  const auto at = [&](std::size_t column) {
    return between(table->most_N_m[damping.below][column], table->most_N_m[damping.below + 1][column],
                   damping.part);
  };
  return std::min(rate_Hz / kStableRates_Hz.front(), 1.0) *
         between(at(rate.below), at(rate.below + 1), rate.part);
}

std::vector<std::string> stiffness_warnings(std::span<const std::byte> image, std::string_view arms,
                                            double rate_Hz) {
  std::vector<std::uint64_t> aligned((image.size() + 7) / 8);
  if (!image.empty()) std::memcpy(aligned.data(), image.data(), image.size());
  control::SceneView view;
  std::vector<std::string> warnings;
  if (control::SceneView::check(std::as_bytes(std::span(aligned)).first(image.size()), view) !=
      control::ImageStatus::kOk)
    return warnings;
  for (const scene::Object* object : *view.scene()->objects()) {
    if (object->shape_type() == scene::Shape::PotentialField) continue;
    for (const std::string_view arm : split(arms)) warn(*object, arm, rate_Hz, warnings);
  }
  return warnings;
}

}  // namespace thimble::host
