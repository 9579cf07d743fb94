// The fields of a scene file (paper, sections 4 and 5.1): vector fields made of subvolumes, and potential fields: read, checked,
// compiled for the controller.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "host-tools/compiler/potential_solver.h"
#include "host-tools/compiler/scene_value.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// Points with normal . p <= offset_m.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0;
};

struct VectorFieldShape {
  struct Subvolume {
    std::vector<HalfSpace> sides;
    HalfSpace plane;  // pushes, unless there is a ball
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    double radius_m = 0;  // of the ball that pushes; 0: the plane does
  };
  std::vector<Subvolume> subvolumes;
};

struct PotentialFieldShape {
  PotentialProblem problem;
  scene::PotentialLaw law = scene::PotentialLaw::Spring;
};

// Throw Error (kBadInput) with the place.
[[nodiscard]] VectorFieldShape read_vector_field(const Value& value);
[[nodiscard]] PotentialFieldShape read_potential_field(const Value& value);

// The subvolumes of the convex body in which all planes hold: each plane has the points that are nearest to it. A plane with
// none is left out.
[[nodiscard]] std::vector<VectorFieldShape::Subvolume> divide(const std::vector<HalfSpace>& planes);

[[nodiscard]] std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(
    flatbuffers::FlatBufferBuilder& builder, const VectorFieldShape& field);
// With its solved_coefficients().
[[nodiscard]] std::pair<scene::Shape, flatbuffers::Offset<void>> write_shape(
    flatbuffers::FlatBufferBuilder& builder, const PotentialFieldShape& field,
    const std::vector<float>& coefficients);

// What the image holds of the solved potential, of potential_grid(). Solves it, or takes the solution from the cache of compile_help.h. Throws
// what solve_potential throws, with its `progress`, and Error potential-too-high.
[[nodiscard]] std::vector<float> solved_coefficients(const PotentialFieldShape& field,
                                                     const std::function<void(double)>& progress);

}  // namespace thimble::host
