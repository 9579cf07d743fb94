#include "host-tools/compiler/scene_field.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "control/scene/limits.h"
#include "host-tools/compiler/compile_help.h"
#include "host-tools/compiler/scene_pose.h"
#include "host-tools/compiler/to_scene.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Subvolume = VectorFieldShape::Subvolume;

struct Bounds {
  Vector3d lo_m;
  Vector3d hi_m;
};

// A box that holds the points where all half spaces hold, within the coordinates that a scene may have; none when there are none.
std::optional<Bounds> bounds_of(std::vector<HalfSpace> sides) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    sides.push_back({Vector3d::Unit(axis), kMaxCoordinate});
    sides.push_back({-Vector3d::Unit(axis), kMaxCoordinate});
  }
  constexpr double kRounding_m = 1.0e-9;
  std::optional<Bounds> bounds;
  const auto add_corner = [&](const HalfSpace& a, const HalfSpace& b, const HalfSpace& c) {
    Eigen::Matrix3d normals;
    normals << a.normal.transpose(), b.normal.transpose(), c.normal.transpose();
    if (std::abs(normals.determinant()) < 1.0e-9) return;
    const Vector3d corner = normals.inverse() * Vector3d(a.offset_m, b.offset_m, c.offset_m);
    for (const HalfSpace& side : sides) {
      if (side.normal.dot(corner) > side.offset_m + kRounding_m) return;
    }
    if (!bounds) bounds = Bounds{corner, corner};
    bounds->lo_m = bounds->lo_m.cwiseMin(corner);
    bounds->hi_m = bounds->hi_m.cwiseMax(corner);
  };
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (std::size_t k = 0; k < j; ++k) add_corner(sides[i], sides[j], sides[k]);
    }
  }
  // A single corner, edge or face has no volume.
  if (bounds && (bounds->hi_m - bounds->lo_m).minCoeff() < kRounding_m) bounds.reset();
  return bounds;
}

std::optional<Bounds> bounds_of(const Subvolume& subvolume) {
  std::vector<HalfSpace> sides = subvolume.sides;
  if (subvolume.radius_m > 0.0) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      sides.push_back({Vector3d::Unit(axis), subvolume.centre_m[axis] + subvolume.radius_m});
      sides.push_back({-Vector3d::Unit(axis), -subvolume.centre_m[axis] + subvolume.radius_m});
    }
  } else {
    sides.push_back(subvolume.plane);
  }
  return bounds_of(sides);
}

HalfSpace read_half_space(const Value& value) {
  const ScenePart part(value, "plane");
  return {part.direction("normal"), part.number("offset_m")};
}

constexpr const char* kTooMany = "too-many-samples";
constexpr const char* kLeaveOut = "leave some out";

std::vector<HalfSpace> read_half_spaces(const Value& list) {
  std::vector<HalfSpace> planes;
  for (std::size_t i = 0; i < list.raw().size(); ++i) planes.push_back(read_half_space(list.at(i)));
  return planes;
}

Subvolume read_subvolume(const Value& value) {
  const ScenePart part(value, "subvolume");
  Subvolume subvolume;
  if (part.has("sides"))
    subvolume.sides = read_half_spaces(part.list("sides", kTooMany, "planes", kLeaveOut));
  if (part.has("plane") == part.has("ball")) {
    value.wrong("a subvolume with exactly one of \"plane\" and \"ball\", the surface that pushes");
  }
  if (part.has("plane")) {
    subvolume.plane = read_half_space(part.at("plane"));
  } else {
    const ScenePart ball(part.at("ball"), "ball");
    subvolume.centre_m = ball.vector("centre_m");
    subvolume.radius_m = ball.number("radius_m");
  }
  if (!bounds_of(subvolume)) {
    value.fail("empty-subvolume", "holds no point: its sides and its surface exclude each other",
               "turn a normal round; a half space holds the points with normal . p <= offset_m");
  }
  return subvolume;
}

Solid read_solid(const Value& shape, const std::string& word) {
  const ScenePart part(shape, word);
  Solid solid;
  if (word == "sphere") {
    solid.radius_m = part.number("radius_m");
  } else if (word == "box") {
    solid.kind = Solid::Kind::kBox;
    solid.half_size_m = 0.5 * part.vector("size_m");
  } else {
    solid.kind = word == "cylinder" ? Solid::Kind::kCylinder : Solid::Kind::kCapsule;
    solid.radius_m = part.number("radius_m");
    solid.half_height_m = 0.5 * part.number("height_m");
  }
  return solid;
}

Solid read_solid(const Value& value) {
  const std::string word = ScenePart(value, "solid").only_key();
  return read_solid(value.at(word), word);
}

Solid read_placed_solid(const Value& value) {
  Solid solid = read_solid(value.at("shape"));
  if (value.has("pose")) read_pose(value.at("pose"), solid.position_m, solid.rotation);
  return solid;
}

// A number with one key for each law, because its unit differs.
struct ByLaw {
  std::string_view spring;
  std::string_view energy;
};
constexpr ByLaw kSource{"source_per_m", "source_N_m"};
constexpr ByLaw kHeld{"depth_m", "potential_J"};

std::string_view key_of(const Value& value, const ByLaw& keys, scene::PotentialLaw law) {
  const bool spring = law == scene::PotentialLaw::Spring;
  const std::string_view other = spring ? keys.energy : keys.spring;
  if (value.has(other)) {
    value.at(other).fail(
        "wrong-law", std::string("belongs to the law \"") + (spring ? "energy" : "spring") + "\"",
        "use \"" + std::string(spring ? keys.spring : keys.energy) + "\", or change the law");
  }
  return spring ? keys.spring : keys.energy;
}

scene::HalfSpace half_space(const HalfSpace& half) {
  return {to_scene(half.normal), static_cast<float>(half.offset_m)};
}

}  // namespace

std::vector<Subvolume> divide(const std::vector<HalfSpace>& planes) {
  std::vector<Subvolume> subvolumes;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    Subvolume subvolume;
    subvolume.plane = planes[i];
    subvolume.sides.push_back(planes[i]);
    bool nearest = true;
    for (std::size_t j = 0; j < planes.size(); ++j) {
      if (j == i) continue;
      // Nearer to plane i than to plane j: o_i - n_i . p <= o_j - n_j . p.
      const Vector3d across = planes[j].normal - planes[i].normal;
      const double offset = planes[j].offset_m - planes[i].offset_m;
      constexpr double kParallel = 1.0e-9;
      if (across.norm() > kParallel) {
        subvolume.sides.push_back({across.normalized(), offset / across.norm()});
      } else {
        nearest = nearest && (offset > 0.0 || (offset == 0.0 && i < j));
      }
    }
    if (nearest && bounds_of(subvolume)) subvolumes.push_back(subvolume);
  }
  return subvolumes;
}

VectorFieldShape read_vector_field(const Value& value) {
  const ScenePart part(value, "vector_field");
  const std::string word = part.only_key();
  VectorFieldShape field;
  if (word == "sphere") {
    Subvolume ball;
    ball.radius_m = read_solid(part.at(word), word).radius_m;
    field.subvolumes.push_back(ball);
  } else if (word == "box") {
    const Solid solid = read_solid(part.at(word), word);
    std::vector<HalfSpace> faces;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      faces.push_back({Vector3d::Unit(axis), solid.half_size_m[axis]});
      faces.push_back({-Vector3d::Unit(axis), solid.half_size_m[axis]});
    }
    field.subvolumes = divide(faces);
  } else if (word == "planes") {
    const Value planes = part.list(word, kTooMany, "planes", kLeaveOut);
    field.subvolumes = divide(read_half_spaces(planes));
    if (field.subvolumes.empty()) {
      planes.fail("empty-subvolume", "hold no point together",
                  "turn a normal round; a plane holds the points with normal . p <= offset_m");
    }
  } else {
    const Value subvolumes = part.list(word, kTooMany, "subvolumes", kLeaveOut);
    for (std::size_t i = 0; i < subvolumes.raw().size(); ++i)
      field.subvolumes.push_back(read_subvolume(subvolumes.at(i)));
  }
  return field;
}

PotentialFieldShape read_potential_field(const Value& value) {
  const ScenePart part(value, "potential_field");
  PotentialFieldShape field;
  field.law = static_cast<scene::PotentialLaw>(part.word("law"));
  PotentialProblem& problem = field.problem;
  problem.place = value.place();
  problem.shape = read_solid(part.at("shape"));
  problem.step_m = part.number("step_m");
  problem.source = part.number(key_of(value, kSource, field.law));
  if (part.has("inclusions")) {
    const Value inclusions = part.list("inclusions", kTooMany, "inclusions", kLeaveOut);
    for (std::size_t i = 0; i < inclusions.raw().size(); ++i) {
      const Value each = inclusions.at(i);
      const ScenePart inclusion(each, "inclusion");
      problem.inclusions.push_back(
          {read_placed_solid(each), inclusion.number(key_of(each, kHeld, field.law)), each.place()});
    }
  }
  if (part.has("regions")) {
    const Value regions = part.list("regions", kTooMany, "regions", kLeaveOut);
    for (std::size_t i = 0; i < regions.raw().size(); ++i) {
      const Value each = regions.at(i);
      const ScenePart region(each, "region");
      problem.regions.push_back({read_placed_solid(each), region.number(key_of(each, kSource, field.law))});
    }
  }
  return field;
}

std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(flatbuffers::FlatBufferBuilder& builder,
                                                               const VectorFieldShape& field) {
  std::vector<flatbuffers::Offset<scene::Subvolume>> subvolumes;
  Bounds all{Vector3d::Constant(kMaxCoordinate), Vector3d::Constant(-kMaxCoordinate)};
  for (const Subvolume& subvolume : field.subvolumes) {
    std::vector<scene::HalfSpace> sides;
    for (const HalfSpace& side : subvolume.sides) sides.push_back(half_space(side));
    const scene::HalfSpace plane = half_space(subvolume.plane);
    const scene::Vec3 centre = to_scene(subvolume.centre_m);
    subvolumes.push_back(scene::CreateSubvolume(builder, builder.CreateVectorOfStructs(sides), &plane,
                                                &centre, static_cast<float>(subvolume.radius_m)));
    if (const std::optional<Bounds> bounds = bounds_of(subvolume)) {
      all.lo_m = all.lo_m.cwiseMin(bounds->lo_m);
      all.hi_m = all.hi_m.cwiseMax(bounds->hi_m);
    }
  }
  const scene::Vec3 lo = to_scene(all.lo_m);
  const scene::Vec3 hi = to_scene(all.hi_m);
  return {scene::Shape::VectorField,
          scene::CreateVectorField(builder, builder.CreateVector(subvolumes), &lo, &hi).Union()};
}

namespace {

// What the image holds of a solved potential.
std::vector<float> coefficients_of(const PotentialFieldShape& field,
                                   const std::function<void(double)>& progress) {
  std::vector<float> coefficients;
  for (const double each : solve_potential(field.problem, progress).coefficients) {
    constexpr auto kMost = static_cast<double>(control::kMaxPotential);
    if (!(std::abs(each) <= kMost)) {
      throw Error(ExitCode::kBadInput, "potential-too-high",
                  field.problem.place + " reaches " + number(each) +
                      (field.law == scene::PotentialLaw::Spring ? " m" : " J") + ", at most " +
                      number(kMost) + " is allowed",
                  "lower its sources");
    }
    coefficients.push_back(static_cast<float>(each));
  }
  return coefficients;
}

}  // namespace

std::vector<float> solved_coefficients(const PotentialFieldShape& field,
                                       const std::function<void(double)>& progress) {
  const std::size_t size = potential_grid(field.problem).size();
  const std::optional<SolvedCache>& cache = compile_help().cache;
  if (!cache) return coefficients_of(field, progress);
  const std::string key = potential_key(field.problem);
  const std::optional<std::string> kept = cache->find(key);
  std::vector<float> coefficients(size);
  if (kept && kept->size() == size * sizeof(float)) {
    std::memcpy(coefficients.data(), kept->data(), kept->size());
    return coefficients;
  }
  coefficients = coefficients_of(field, progress);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(coefficients));
  cache->keep(key, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return coefficients;
}

std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(flatbuffers::FlatBufferBuilder& builder,
                                                               const PotentialFieldShape& field,
                                                               const std::vector<float>& coefficients) {
  const Grid grid = potential_grid(field.problem);
  std::vector<std::uint16_t> count;
  for (const std::size_t each : grid.count) count.push_back(static_cast<std::uint16_t>(each));
  const scene::Vec3 origin = to_scene(grid.origin_m);
  const auto counts = builder.CreateVector(count);
  return {scene::Shape::PotentialField,
          scene::CreatePotentialField(builder, counts, &origin, static_cast<float>(grid.step_m), field.law,
                                      builder.CreateVector(coefficients))
              .Union()};
}

}  // namespace thimble::host
