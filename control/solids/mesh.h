// The two large operations of a mesh (SolidOps in control/solids/solid.h).
//
// A slide needs no sweep of its own: it stays on the surface, each piece inside one triangle, and no other
// triangle crosses it. The compiler finds triangles that others cross and flags them as Pierced. So the tree
// is walked only in free flight and on pierced faces.
#pragma once

#include <span>

#include "control/solids/solid.h"

namespace thimble::control {

[[nodiscard]] bool sweep_mesh(const ShapeData& shape, const Vec3& from, const Vec3& to,
                              std::span<const Feature> leaving, Hit& hit);

[[nodiscard]] Slide slide_on_mesh(const ShapeData& shape, Feature& feature, const Vec3& from,
                                  const Vec3& target, SlideOptions options);

// A plane for each triangle that the ball could meet on its way, at most kMaxSeparationNodes nodes of the tree.
[[nodiscard]] std::size_t separate_mesh(const ShapeData& shape, const BallQuery& ball,
                                        std::span<Separation> out);

}  // namespace thimble::control
