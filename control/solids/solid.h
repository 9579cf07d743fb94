// The operations of a solid. Each kind of solid is one file in this folder with a SolidOps; its row is in
// control/scene/shape_table.h.
//
// All coordinates are in the object's own frame, in metres. A solid has a free side. The god object is a
// point that never enters a solid; it either flies (sweep) or slides over a surface (slide). Nothing here
// allocates or fails.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "control/scene/image_verdict.h"
#include "control/scene/pauses.h"
#include "control/scene/shape_table.h"
#include "control/solids/mesh_view.h"
#include "kinematics/vector.h"

namespace thimble::control {

// How far a point may lie inside a solid and still count as on its surface. Larger than the rounding of a
// point on the surface of an object within a metre (6e-8 m), smaller than anything a hand or an encoder
// resolves (2e-5 m).
inline constexpr float kSurfaceTolerance_m = 2.0e-7F;

// Feature.kind of a feature that only tells a sweep its side; it stops the flight like any other feature.
inline constexpr std::uint8_t kSideOnly = 3;

// The part of a shape's surface that a point is on. Each shape gives its own meaning to the index; side is -1
// on the back of a two-sided sheet.
struct Feature {
  std::uint32_t index = 0;
  std::uint8_t kind = 0;    // mesh: 0 face, 1 edge, 2 vertex
  std::uint8_t corner = 0;  // mesh: which edge or vertex of triangle `index`
  std::int8_t side = 1;
};

// The first place where a flight enters a solid.
struct Hit {
  float t = 2.0F;  // fraction of the segment; above 1: none
  Feature feature;
};

enum class SlideEnd : std::uint8_t {
  kHeld,   // `to` is the nearest point that the slide can reach, and the target is behind the surface
  kFree,   // the straight line from `to` to the target does not enter this solid at `to`
  kMoved,  // one piece of the path: slide again
  kBound,  // kMaxSlideFaces was reached: `to` is on the surface, nearer to the target than before
};

// One piece of a slide, straight from `from` to `to` or in two straight parts over `via`, on the surface or
// on its free side.
struct Slide {
  Slide(const Vec3& there, SlideEnd how, bool is_swept = true) : to(there), end(how), swept(is_swept) {}
  Slide(const Vec3& round_by, const Vec3& there, SlideEnd how)
      : to(there), end(how), bent(true), via(round_by) {}

  Vec3 to;
  SlideEnd end;
  bool swept = true;  // the piece is known not to cross this same shape elsewhere
  bool bent = false;
  Vec3 via;  // only when bent
};

struct SlideOptions {
  bool hold = false;       // stay on the surface, whichever side the target is on
  bool one_piece = false;  // stop after each straight piece, so that it can be swept against other objects
};

struct ShapeData {
  Vec3 vector = Vec3::Zero();  // plane: unit normal; box: half size
  float radius_m = 0.0F;       // plane: offset
  float half_height_m = 0.0F;
  MeshView mesh;
};

struct SurfacePoint;  // control/surfaces/chart.h
struct Chart;

struct SolidOps {
  // In the background, once: whether the numbers in the image are allowed. Adds to the scene's triangles.
  ImageVerdict (*check)(const scene::Object& object, std::size_t& triangles_in_scene, Pauses& pauses);
  // Reads the shape from a checked image.
  void (*view)(const scene::Object& object, ShapeData& shape);
  // Finds the first entry into the solid along from -> to before hit.t, and writes it to `hit`. `leaving` are
  // the features of this shape that `from` is on: they do not stop the flight. False when a bound was hit and
  // the answer is not known.
  bool (*sweep)(const ShapeData& shape, const Vec3& from, const Vec3& to, std::span<const Feature> leaving,
                Hit& hit);
  // Slides `from`, which is on `feature`, over the surface towards the point nearest to `target`; `feature`
  // follows.
  Slide (*slide)(const ShapeData& shape, Feature& feature, const Vec3& from, const Vec3& target,
                 SlideOptions options);
  // The unit normals of the constraints at a point on `feature`, to the free side; returns how many, 1 to 3.
  int (*normals)(const ShapeData& shape, const Feature& feature, const Vec3& point, std::span<Vec3, 3> out);
  // Half extents of a box about the object's origin that holds the solid.
  Vec3 (*reach)(const ShapeData& shape);
  // The interpolated normal of force shading at a point on `feature`; false where the shape is as it looks.
  // Null: never shaded.
  bool (*shaded_normal)(const ShapeData& shape, const Feature& feature, const Vec3& point,
                        Vec3& normal) = nullptr;
  // The chart of a curved part of the surface; false where it is flat. Null: flat everywhere.
  bool (*chart)(const ShapeData& shape, const SurfacePoint& place, Chart& out) = nullptr;
  // For a curved surface: the gradient with respect to the tip of what has this gradient along the surface at
  // the place. Null: the same.
  Vec3 (*gradient_at_tip)(const ShapeData& shape, const SurfacePoint& place, const Vec3& along) = nullptr;
  bool smooth = false;  // the surface has no edge
  bool walks = false;   // a slide costs more the farther it goes
};

}  // namespace thimble::control
