#include "host-tools/compiler/scene_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "control/scene/limits.h"
#include "control/scene/shape_table.h"
#include "host-tools/compiler/portable_math.h"

namespace thimble::host {
namespace {

constexpr double kMinSpacing = 1.0e-5;  // control::kMinSpacing_m, in the digits that people read
static_assert(static_cast<float>(kMinSpacing) == control::kMinSpacing_m);

// Rows of numbers, written as in a file: the last one is at the least v.
HeightGrid read_rows(const Value& value, const Range& range, std::size_t most) {
  constexpr const char* kRows = "rows of numbers, [[...], [...]], at least 2 x 2 and all rows of one length";
  const nlohmann::json& rows = value.raw();
  if (!rows.is_array() || rows.size() < 2 || !rows.front().is_array() || rows.front().size() < 2)
    value.wrong(kRows);
  HeightGrid grid;
  grid.rows = rows.size();
  grid.columns = rows.front().size();
  if (grid.rows > most / grid.columns) {
    value.fail("too-many-samples",
               "has " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows) +
                   " numbers, at most " + std::to_string(most) + " are allowed",
               "make the grid coarser");
  }
  for (std::size_t row = grid.rows; row-- > 0;) {
    const Value numbers = value.at(row);
    if (!numbers.raw().is_array() || numbers.raw().size() != grid.columns) {
      numbers.wrong("a row of " + std::to_string(grid.columns) + " numbers, like the first");
    }
    for (std::size_t column = 0; column < grid.columns; ++column) {
      grid.values.push_back(numbers.at(column).number(range));
    }
  }
  return grid;
}

GridSource read_source(const Value& value, const Range& range, std::size_t most) {
  GridSource source;
  source.range = range;
  source.place = value.place();
  if (value.raw().is_string()) {
    source.file = value.text(4096);
  } else {
    source.inline_grid = read_rows(value, range, most);
  }
  return source;
}

SceneClick read_click(const Value& value) {
  const ScenePart part(value, "click");
  return {part.number("amplitude_N"), part.number("frequency_Hz"), part.number("decay_per_s")};
}

SceneTexture read_texture(const Value& value) {
  const ScenePart part(value, "texture");
  SceneTexture texture{};
  constexpr std::array<scene::TextureKind, 3> kKinds{scene::TextureKind::Lateral, scene::TextureKind::Normal,
                                                     scene::TextureKind::Height};
  texture.kind = kKinds.at(part.word("kind"));
  texture.tile_m = part.pair("tile_m");
  texture.height_m = part.number("height_m");
  constexpr std::array<TextureMapping, 3> kMappings{TextureMapping::kAuto, TextureMapping::kCoordinates,
                                                    TextureMapping::kBlended};
  texture.mapping = kMappings.at(part.word("mapping"));
  texture.place = value.place();
  constexpr std::array<std::string_view, 3> kSources{"pattern", "heights", "file"};
  if (std::ranges::count_if(kSources, [&](std::string_view key) { return part.has(key); }) != 1)
    value.wrong("a texture with exactly one of " + listed(kSources));
  if (part.has("pattern")) {
    constexpr std::array<TexturePattern, 3> kPatterns{TexturePattern::kCosCos, TexturePattern::kRidges,
                                                      TexturePattern::kNoise};
    texture.pattern = kPatterns.at(part.word("pattern"));
  } else if (part.has("heights")) {
    texture.heights.inline_grid =
        read_rows(part.at("heights"), part.range("heights"), control::kMaxTextureSamples);
    texture.heights.place = part.at("heights").place();
  } else {
    texture.heights = {{}, part.text("file"), part.range("heights"), part.at("file").place()};
  }
  return texture;
}

SceneStiffnessMap read_map(const Value& value) {
  const ScenePart part(value, "stiffness_map");
  const auto source = [&](std::string_view key) {
    return read_source(part.at(key), part.range(key), control::kMaxMapSamples);
  };
  SceneStiffnessMap map{};
  map.stiffness_N_m = source("stiffness_N_m");
  if (part.has("damping_N_s_m")) map.damping_N_s_m = source("damping_N_s_m");
  map.cell_m = part.number("cell_m");
  map.origin_m = part.vector("origin_m");
  map.u = part.direction("u");
  map.v = part.direction("v");
  constexpr double kParallel = 1.0e-3;
  if (map.u.cross(map.v).norm() < kParallel) value.wrong("a map whose u and v point in different directions");
  map.conservative = part.flag("conservative");
  map.place = value.place();
  return map;
}

HeightGrid load(const GridSource& source, const std::filesystem::path& folder, std::size_t most) {
  if (source.file.empty()) return source.inline_grid;
  const std::string name = source.place + ": " + source.file;
  HeightGrid grid = read_height_grid(folder / source.file, most, name);
  for (const double number : grid.values) {
    if (!source.range.holds(number)) {
      throw Error(ExitCode::kBadInput, "bad-value",
                  name + ": has the value " + host::number(number) + ", allowed is " + describe(source.range),
                  "correct the file");
    }
  }
  return grid;
}

HeightGrid draw(TexturePattern pattern) {
  constexpr std::size_t kSide = 32;
  HeightGrid grid{kSide, kSide, {}};
  std::uint32_t noise = 1;
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t column = 0; column < kSide; ++column) {
      const double x = 2.0 * std::numbers::pi * static_cast<double>(column) / kSide;
      const double y = 2.0 * std::numbers::pi * static_cast<double>(row) / kSide;
      noise = 1664525U * noise + 1013904223U;  // Knuth's linear congruences (Numerical Recipes)
      if (pattern == TexturePattern::kCosCos) grid.values.push_back(portable::cos(x) * portable::cos(y));
      if (pattern == TexturePattern::kRidges) grid.values.push_back(portable::cos(x));
      if (pattern == TexturePattern::kNoise) grid.values.push_back(static_cast<double>(noise >> 16U));
    }
  }
  return grid;
}

// The control points of the periodic spline that passes through the samples: in each direction (c[i-1] + 4 c[i] + c[i+1]) / 6 is
// the sample. Gauss and Seidel's iteration halves the error at least in each round.
void interpolate(std::vector<double>& values, std::size_t first, std::size_t stride, std::size_t count) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) samples[i] = values[first + i * stride];
  constexpr int kRounds = 40;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < count; ++i) {
      const double before = values[first + (i + count - 1) % count * stride];
      const double after = values[first + (i + 1) % count * stride];
      values[first + i * stride] = (6.0 * samples[i] - before - after) / 4.0;
    }
  }
}

// What four control points in a row count for between the second and the third, at quarters of the way.
constexpr std::size_t kLooks = 4;
std::array<double, 4> weights(std::size_t look) {
  const double t = static_cast<double>(look) / kLooks;
  const double s = 1.0 - t;
  return {s * s * s / 6.0, (4.0 - 3.0 * t * t * (1.0 + s)) / 6.0, (4.0 - 3.0 * s * s * (1.0 + t)) / 6.0,
          t * t * t / 6.0};
}

double height_between(const HeightGrid& points, std::size_t column, std::size_t row, std::size_t look_u,
                      std::size_t look_v) {
  const std::array<double, 4> u = weights(look_u);
  const std::array<double, 4> v = weights(look_v);
  double height = 0.0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      height += u.at(i) * v.at(j) *
                points.at((column + points.columns + i - 1) % points.columns,
                          (row + points.rows + j - 1) % points.rows);
    }
  }
  return height;
}

// Control points as the board has them, the highest point of the surface between them at 0 and the lowest at -height_m.
std::vector<float> control_points(HeightGrid grid, double height_m) {
  for (std::size_t row = 0; row < grid.rows; ++row)
    interpolate(grid.values, row * grid.columns, 1, grid.columns);
  for (std::size_t column = 0; column < grid.columns; ++column)
    interpolate(grid.values, column, grid.columns, grid.rows);
  double lowest = std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::lowest();
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      for (std::size_t look = 0; look < kLooks * kLooks; ++look) {
        const double height = height_between(grid, column, row, look % kLooks, look / kLooks);
        lowest = std::min(lowest, height);
        highest = std::max(highest, height);
      }
    }
  }
  std::vector<float> points;
  points.reserve(grid.values.size());
  for (const double point : grid.values)
    points.push_back(static_cast<float>(height_m * (point - highest) / (highest - lowest)));
  return points;
}

flatbuffers::Offset<scene::Texture> write_texture(flatbuffers::FlatBufferBuilder& builder,
                                                  const SceneTexture& texture, const Wearer& wearer,
                                                  const std::filesystem::path& folder,
                                                  std::vector<std::string>& warnings) {
  if (texture.mapping == TextureMapping::kCoordinates && wearer.kind != scene::Shape::Mesh) {
    throw Error(ExitCode::kBadInput, "no-coordinates",
                texture.place + " has the mapping \"uv\" and is worn by \"" + std::string(wearer.name) +
                    "\", a " + std::string(wearer.shape_word) + ", which has no texture coordinates",
                R"(leave "mapping" out)");
  }
  const HeightGrid grid = texture.pattern == TexturePattern::kNone
                              ? load(texture.heights, folder, control::kMaxTextureSamples)
                              : draw(texture.pattern);
  const auto [lowest, highest] = std::minmax_element(grid.values.begin(), grid.values.end());
  if (*lowest == *highest) {
    throw Error(ExitCode::kBadInput, "flat-texture",
                texture.heights.place + " has the same height everywhere", "give heights that differ");
  }
  std::array<double, 2> tile_m = texture.tile_m;
  if (wearer.unrolled_radius_m > 0.0) {
    const double round_m = 2.0 * std::numbers::pi * wearer.unrolled_radius_m;
    const double tiles = std::max(1.0, std::round(round_m / tile_m[0]));
    tile_m[0] = round_m / tiles;
    constexpr double kSeen = 1.0e-6;
    if (std::abs(tile_m[0] - texture.tile_m[0]) > kSeen * tile_m[0]) {
      warnings.push_back(std::string(wearer.name) + ": a tile of the texture is " + number(tile_m[0]) +
                         " m instead of " + number(texture.tile_m[0]) + " m along u, so that " +
                         number(tiles) + " go round without a seam");
    }
  }
  const std::array<std::size_t, 2> count{grid.columns, grid.rows};
  for (std::size_t i = 0; i < 2; ++i) {
    const double spacing = tile_m.at(i) / static_cast<double>(count.at(i));
    if (spacing < kMinSpacing) {
      throw Error(ExitCode::kBadInput, "too-fine",
                  texture.place + "/tile_m/" + std::to_string(i) + " puts the heights " + number(spacing) +
                      " m apart, allowed is at least " + number(kMinSpacing) + " m",
                  "make the tile larger or the grid coarser");
    }
  }
  const auto heights = builder.CreateVector(control_points(grid, texture.height_m));
  return scene::CreateTexture(builder, texture.kind, static_cast<std::uint16_t>(grid.columns),
                              static_cast<std::uint16_t>(grid.rows), static_cast<float>(tile_m[0]),
                              static_cast<float>(tile_m[1]), heights);
}

flatbuffers::Offset<flatbuffers::Vector<float>> write_numbers(flatbuffers::FlatBufferBuilder& builder,
                                                              const HeightGrid& grid) {
  return builder.CreateVector(std::vector<float>(grid.values.begin(), grid.values.end()));
}

flatbuffers::Offset<scene::StiffnessMap> write_map(flatbuffers::FlatBufferBuilder& builder,
                                                   const SceneStiffnessMap& map,
                                                   const std::filesystem::path& folder) {
  const auto vec = [](const Eigen::Vector3d& v) {
    return scene::Vec3(static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
  };
  const HeightGrid stiffness = load(map.stiffness_N_m, folder, control::kMaxMapSamples);
  const auto stiffness_offset = write_numbers(builder, stiffness);
  flatbuffers::Offset<flatbuffers::Vector<float>> damping_offset = 0;
  if (map.damping_N_s_m) {
    const HeightGrid damping = load(*map.damping_N_s_m, folder, control::kMaxMapSamples);
    if (damping.columns != stiffness.columns || damping.rows != stiffness.rows) {
      throw Error(ExitCode::kBadInput, "unlike-grids",
                  map.damping_N_s_m->place + " is a grid of " + std::to_string(damping.columns) + " x " +
                      std::to_string(damping.rows) + ", the stiffness has " +
                      std::to_string(stiffness.columns) + " x " + std::to_string(stiffness.rows),
                  "give as many numbers of each");
    }
    damping_offset = write_numbers(builder, damping);
  }
  const scene::Vec3 origin = vec(map.origin_m);
  const scene::Vec3 u = vec(map.u);
  const scene::Vec3 v = vec(map.v);
  return scene::CreateStiffnessMap(builder, static_cast<std::uint16_t>(stiffness.columns),
                                   static_cast<std::uint16_t>(stiffness.rows), static_cast<float>(map.cell_m),
                                   &origin, &u, &v, stiffness_offset, damping_offset, map.conservative);
}

}  // namespace

SceneSurface read_surface(const ScenePart& material) {
  SceneSurface surface;
  surface.place = material.value().place();
  if (material.has("click")) surface.click = read_click(material.at("click"));
  surface.brake_friction = material.number("brake_friction");
  if (material.has("texture")) surface.texture = read_texture(material.at("texture"));
  if (material.has("stiffness_map")) surface.stiffness_map = read_map(material.at("stiffness_map"));
  return surface;
}

flatbuffers::Offset<scene::Surface> write_surface(flatbuffers::FlatBufferBuilder& builder,
                                                  const SceneSurface& surface, const Wearer& wearer,
                                                  const std::filesystem::path& folder,
                                                  std::vector<std::string>& warnings) {
  if (!surface.any()) return 0;
  if (control::is_volume(wearer.kind)) {
    throw Error(ExitCode::kBadInput, "no-surface",
                surface.place + " has effects of a surface and is worn by \"" + std::string(wearer.name) +
                    "\", a " + std::string(wearer.shape_word) + ", which is a volume without one",
                "leave click, brake_friction, texture and stiffness_map out");
  }
  flatbuffers::Offset<scene::Texture> texture = 0;
  flatbuffers::Offset<scene::StiffnessMap> map = 0;
  if (surface.texture) texture = write_texture(builder, *surface.texture, wearer, folder, warnings);
  if (surface.stiffness_map) map = write_map(builder, *surface.stiffness_map, folder);
  scene::Click click;
  if (surface.click) {
    click = {static_cast<float>(surface.click->amplitude_N), static_cast<float>(surface.click->frequency_Hz),
             static_cast<float>(surface.click->decay_per_s)};
  }
  return scene::CreateSurface(builder, surface.click ? &click : nullptr,
                              static_cast<float>(surface.brake_friction), texture, map);
}

}  // namespace thimble::host
