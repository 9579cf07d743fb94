#include "board/sim/specimen_file.h"

#include <stdexcept>
#include <string>

#include "board/files/json_value.h"
#include "board/files/text_file.h"

namespace thimble::board {
namespace {

constexpr Range kAny{-1e9, 1e9};
constexpr Range kFromZero{0, 1e9};
constexpr int kMostSide = 1 << 16;
constexpr std::size_t kMostLayers = 16;

SpecimenMap read(const JsonValue& root) {
  root.object("a specimen", {"thimble_specimen", "description", "origin_m", "u", "v", "cell_m", "columns",
                             "rows", "stiffness_N_m", "height_m", "damping_N_s_m", "static_friction",
                             "dynamic_friction", "layers"});
  (void)root.at("thimble_specimen").integer(1, 1);
  SpecimenMap map;
  map.origin_m = root.at("origin_m").vector(kAny);
  map.u = root.at("u").direction();
  map.v = root.at("v").direction();
  map.cell_m = root.at("cell_m").number(kAny);
  map.columns = static_cast<std::size_t>(root.at("columns").integer(1, kMostSide));
  map.rows = static_cast<std::size_t>(root.at("rows").integer(1, kMostSide));
  map.stiffness_N_m = root.at("stiffness_N_m").numbers(kAny, map.columns * map.rows);
  if (root.has("height_m")) map.height_m = root.at("height_m").numbers(kAny, map.columns * map.rows);
  map.damping_N_s_m = root.number_or("damping_N_s_m", kFromZero, 0);
  map.static_friction = root.number_or("static_friction", kFromZero, 0);
  map.dynamic_friction = root.number_or("dynamic_friction", kFromZero, map.static_friction);
  if (root.has("layers")) {
    const JsonValue layers = root.at("layers");
    for (std::size_t i = 0; i < layers.size(0, kMostLayers); ++i) {
      const JsonValue layer = layers.at(i);
      layer.object("a layer", {"depth_m", "stiffness_ratio"});
      map.layers.push_back({layer.at("depth_m").number(kAny), layer.at("stiffness_ratio").number(kFromZero)});
    }
  }
  return map;
}

}  // namespace

Specimen read_specimen(const std::filesystem::path& file) {
  try {
    const JsonDocument document(read_text(file), file.string(), "the specimen");
    return Specimen(read(JsonValue(document)));
  } catch (const FileError& error) {
    throw SpecimenError(error.what());
  } catch (const JsonError& error) {
    throw SpecimenError(error.what());
  } catch (const std::invalid_argument& error) {  // of Specimen: the map as a whole
    throw SpecimenError(file.string() + ": " + error.what());
  }
}

}  // namespace thimble::board
