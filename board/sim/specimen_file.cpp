#include "board/sim/specimen_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace thimble::board {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 11> kKeys = {
    "thimble_specimen", "description", "origin_m",     "u", "v", "cell_m", "columns", "rows",
    "stiffness_N_m",    "height_m",    "damping_N_s_m"};
constexpr double kLeastLength = 1e-9;

Eigen::Vector3d vector_of(const json& value) {
  const auto numbers = value.get<std::array<double, 3>>();
  return {numbers[0], numbers[1], numbers[2]};
}

Eigen::Vector3d direction_of(const json& value) {
  const Eigen::Vector3d given = vector_of(value);
  if (!(given.norm() > kLeastLength)) throw std::invalid_argument("u or v has no length");
  return given.normalized();
}

SpecimenMap read(const json& root) {
  if (!root.is_object() || root.value("thimble_specimen", 0) != 1)
    throw std::invalid_argument("it has no \"thimble_specimen\": 1");
  for (const auto& [key, unused] : root.items()) {
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end())
      throw std::invalid_argument("\"" + key + "\" is not a key of a specimen");
  }
  SpecimenMap map;
  map.origin_m = vector_of(root.at("origin_m"));
  map.u = direction_of(root.at("u"));
  map.v = direction_of(root.at("v"));
  map.cell_m = root.at("cell_m").get<double>();
  map.columns = root.at("columns").get<std::size_t>();
  map.rows = root.at("rows").get<std::size_t>();
  map.stiffness_N_m = root.at("stiffness_N_m").get<std::vector<double>>();
  if (root.contains("height_m")) map.height_m = root.at("height_m").get<std::vector<double>>();
  map.damping_N_s_m = root.value("damping_N_s_m", 0.0);
  return map;
}

}  // namespace

Specimen read_specimen(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw SpecimenError(file.string() + ": " + std::strerror(errno));
  try {
    return Specimen(read(json::parse(in)));
  } catch (const std::exception& error) {  // from the JSON library or from the checks above
    throw SpecimenError(file.string() + ": " + error.what());
  }
}

}  // namespace thimble::board
