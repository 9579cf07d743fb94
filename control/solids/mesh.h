// The large operations of a mesh (SolidOps in control/solids/solid.h).
//
// A slide needs no sweep of its own: it stays on the surface, each piece inside one triangle, and no other
// triangle crosses it. The compiler finds triangles that others cross and flags them as Pierced. So the tree
// is walked only in free flight and on pierced faces.
#pragma once

#include <span>

#include "control/solids/solid.h"

namespace thimble::control {

[[nodiscard]] bool sweep_mesh(const ShapeData& shape, const SweepQuery& query, Hit& hit);

[[nodiscard]] Slide slide_on_mesh(const ShapeData& shape, Feature& feature, const SlideQuery& query);

// A plane for each triangle that the ball could meet on its way, at most kMaxSeparationNodes nodes of the tree. Of a tip,
// those that find no room, the farthest ones, shorten free_m; and none is needed for what lies behind the plane of a face
// that the tip touches.
[[nodiscard]] std::size_t separate_mesh(const ShapeData& shape, const BallQuery& ball,
                                        std::span<Separation> out, float& free_m);

[[nodiscard]] bool touches_mesh(const ShapeData& shape, const Feature& feature, const Vec3& centre,
                                float radius_m, const Vec3& normal);

[[nodiscard]] bool roll_on_mesh(const ShapeData& shape, BallRoll& ball);

// The first try of it: over faces on which the ball touches nothing else (MeshView::rims).
[[nodiscard]] bool roll_within_rims(const MeshView& mesh, BallRoll& ball);

// Textures on a mesh (SolidOps::chart, SolidOps::blend).
[[nodiscard]] Chart chart_on_mesh(const ShapeData& shape, const SurfacePoint& place);
[[nodiscard]] bool blend_on_mesh(const ShapeData& shape, const SurfacePoint& place, Blend& blend);

// By the faces that a ray crosses; at most six rays. A face of a sheet encloses nothing. Beyond the box of a mesh that
// encloses free space, every point is outside.
[[nodiscard]] Containment mesh_contains(const ShapeData& shape, const Vec3& point, Work& work);

}  // namespace thimble::control
