// The two halves of a mesh's answers; see SolidOps.
//
// Why a slide needs no sweep of its own: a walk stays on the surface, each piece inside one triangle, and a triangle that no other
// crosses (the compiler proves it and flags the others as Pierced) can be slid along freely. So the tree is only walked in free
// flight and on pierced faces.
#pragma once

#include <span>

#include "control/solids/solid.h"

namespace thimble::control {

[[nodiscard]] bool sweep_mesh(const ShapeData& shape, const Vec3& from, const Vec3& to,
                              std::span<const Feature> leaving, Hit& hit);

[[nodiscard]] Slide slide_on_mesh(const ShapeData& shape, Feature& feature, const Vec3& from,
                                  const Vec3& target, SlideOptions options);

}  // namespace thimble::control
