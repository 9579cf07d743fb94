#include "host-tools/compiler/scene_field.h"

#include <cmath>
#include <optional>
#include <string>

#include "control/scene/limits.h"
#include "host-tools/compiler/scene_pose.h"
#include "host-tools/compiler/to_scene.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Subvolume = VectorFieldShape::Subvolume;

constexpr std::size_t kMaxInclusions = 64;
constexpr double kMaxSource = 1.0e6;
constexpr double kMaxDepth = 1.0;      // m
constexpr double kMaxEnergy = 1000.0;  // J

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
  // A corner, an edge or a face alone holds nothing.
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

void check_list(const Value& value, const char* what, std::size_t least, std::size_t most) {
  if (!value.raw().is_array() || value.raw().size() < least) {
    value.wrong("an array of at least " + std::to_string(least) + " " + what);
  }
  if (value.raw().size() > most) {
    value.fail("too-many-samples",
               "has " + std::to_string(value.raw().size()) + " " + what + ", at most " +
                   std::to_string(most) + " are allowed",
               "leave some out");
  }
}

HalfSpace read_half_space(const Value& value) {
  constexpr std::array<std::string_view, 2> kKeys{"normal", "offset_m"};
  value.object("a plane", kKeys);
  constexpr Range kAnyNumber{-1.0e9, 1.0e9};
  HalfSpace half{value.at("normal").as_vector(kAnyNumber), value.number_or("offset_m", kCoordinate, 0.0)};
  if (half.normal.norm() < 1.0e-6) {
    value.at("normal").wrong("a direction, of any length but zero");
  }
  half.normal.normalize();
  return half;
}

std::vector<HalfSpace> read_half_spaces(const Value& value, std::size_t least) {
  check_list(value, "planes", least, control::kMaxSubvolumeSides);
  std::vector<HalfSpace> planes;
  for (std::size_t i = 0; i < value.raw().size(); ++i) planes.push_back(read_half_space(value.at(i)));
  return planes;
}

Subvolume read_subvolume(const Value& value) {
  value.object("a subvolume", kSubvolumeKeys);
  Subvolume subvolume;
  if (value.has("sides")) subvolume.sides = read_half_spaces(value.at("sides"), 0);
  if (value.has("plane") == value.has("ball")) {
    value.wrong("a subvolume with exactly one of \"plane\" and \"ball\", the surface that pushes");
  }
  if (value.has("plane")) {
    subvolume.plane = read_half_space(value.at("plane"));
  } else {
    const Value ball = value.at("ball");
    ball.object("a ball", kBallKeys);
    if (ball.has("centre_m")) subvolume.centre_m = ball.at("centre_m").as_vector(kCoordinate);
    subvolume.radius_m = ball.at("radius_m").as_number(kLength);
  }
  if (!bounds_of(subvolume)) {
    value.fail("empty-subvolume", "holds no point: its sides and its surface exclude each other",
               "turn a normal round; a half space holds the points with normal . p <= offset_m");
  }
  return subvolume;
}

// The only key of `value`, which says what kind it is.
std::string only_key(const Value& value, const char* what, Keys keys) {
  value.object(what, keys);
  if (value.raw().size() != 1) {
    value.wrong("an object with exactly one of " + listed(keys));
  }
  return value.raw().begin().key();
}

Solid read_solid(const Value& value) {
  constexpr std::array<std::string_view, 1> kSphere{"radius_m"};
  constexpr std::array<std::string_view, 1> kBox{"size_m"};
  constexpr std::array<std::string_view, 2> kRound{"radius_m", "height_m"};
  const std::string word = only_key(value, "a shape of closed form", kSolidKeys);
  const Value shape = value.at(word);
  Solid solid;
  if (word == "sphere") {
    shape.object("a sphere", kSphere);
    solid.radius_m = shape.at("radius_m").as_number(kLength);
  } else if (word == "box") {
    shape.object("a box", kBox);
    solid.kind = Solid::Kind::kBox;
    solid.half_size_m = 0.5 * shape.at("size_m").as_vector(kLength);
  } else {
    solid.kind = word == "cylinder" ? Solid::Kind::kCylinder : Solid::Kind::kCapsule;
    shape.object(word == "cylinder" ? "a cylinder" : "a capsule", kRound);
    solid.radius_m = shape.at("radius_m").as_number(kLength);
    solid.half_height_m = 0.5 * shape.at("height_m").as_number(kLength);
  }
  return solid;
}

Solid read_placed_solid(const Value& value) {
  Solid solid = read_solid(value.at("shape"));
  if (value.has("pose")) read_pose(value.at("pose"), solid.position_m, solid.rotation);
  return solid;
}

// A number whose key carries the unit that the law asks for.
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

Range source_range(scene::PotentialLaw law) {
  return {0.0, kMaxSource, false, law == scene::PotentialLaw::Spring ? "1/m" : "N/m"};
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
  const std::string word = only_key(value, "a vector field", kVectorFieldKeys);
  const Value part = value.at(word);
  VectorFieldShape field;
  if (word == "box" || word == "sphere") {
    const Solid solid = read_solid(value);
    if (word == "sphere") {
      Subvolume ball;
      ball.radius_m = solid.radius_m;
      field.subvolumes.push_back(ball);
    } else {
      std::vector<HalfSpace> faces;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        faces.push_back({Vector3d::Unit(axis), solid.half_size_m[axis]});
        faces.push_back({-Vector3d::Unit(axis), solid.half_size_m[axis]});
      }
      field.subvolumes = divide(faces);
    }
  } else if (word == "planes") {
    field.subvolumes = divide(read_half_spaces(part, 1));
    if (field.subvolumes.empty()) {
      part.fail("empty-subvolume", "hold no point together",
                "turn a normal round; a plane holds the points with normal . p <= offset_m");
    }
  } else {
    check_list(part, "subvolumes", 1, control::kMaxSubvolumes);
    for (std::size_t i = 0; i < part.raw().size(); ++i)
      field.subvolumes.push_back(read_subvolume(part.at(i)));
  }
  return field;
}

PotentialFieldShape read_potential_field(const Value& value) {
  value.object("a potential field", kPotentialFieldKeys);
  PotentialFieldShape field;
  constexpr std::array<std::string_view, 2> kLaws{"spring", "energy"};
  if (value.has("law")) field.law = static_cast<scene::PotentialLaw>(value.at("law").as_word(kLaws));
  PotentialProblem& problem = field.problem;
  problem.place = value.place();
  problem.shape = read_solid(value.at("shape"));
  problem.step_m =
      value.at("step_m").as_number({static_cast<double>(control::kMinFieldStep_m), 1.0, false, "m"});
  problem.source = value.number_or(key_of(value, kSource, field.law), source_range(field.law), 0.0);
  if (value.has("inclusions")) {
    const Value inclusions = value.at("inclusions");
    check_list(inclusions, "inclusions", 0, kMaxInclusions);
    const Range range = field.law == scene::PotentialLaw::Spring ? Range{0.0, kMaxDepth, true, "m"}
                                                                 : Range{0.0, kMaxEnergy, true, "J"};
    for (std::size_t i = 0; i < inclusions.raw().size(); ++i) {
      const Value inclusion = inclusions.at(i);
      inclusion.object("an inclusion", kInclusionKeys);
      problem.inclusions.push_back({read_placed_solid(inclusion),
                                    inclusion.at(key_of(inclusion, kHeld, field.law)).as_number(range),
                                    inclusion.place()});
    }
  }
  if (value.has("regions")) {
    const Value regions = value.at("regions");
    check_list(regions, "regions", 0, kMaxInclusions);
    for (std::size_t i = 0; i < regions.raw().size(); ++i) {
      const Value region = regions.at(i);
      region.object("a region", kRegionKeys);
      problem.regions.push_back(
          {read_placed_solid(region),
           region.at(key_of(region, kSource, field.law)).as_number(source_range(field.law))});
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

std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(flatbuffers::FlatBufferBuilder& builder,
                                                               const PotentialFieldShape& field) {
  const Potential potential = solve_potential(field.problem);
  const Grid& grid = potential.grid;
  std::vector<std::uint16_t> count;
  for (const std::size_t each : grid.count) count.push_back(static_cast<std::uint16_t>(each));
  std::vector<float> coefficients;
  for (const double each : potential.coefficients) {
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
  const scene::Vec3 origin = to_scene(grid.origin_m);
  const auto counts = builder.CreateVector(count);
  return {scene::Shape::PotentialField,
          scene::CreatePotentialField(builder, counts, &origin, static_cast<float>(grid.step_m), field.law,
                                      builder.CreateVector(coefficients))
              .Union()};
}

}  // namespace thimble::host
