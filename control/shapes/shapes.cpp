#include "control/shapes/shape.h"

namespace thimble::control {

const ShapeOps& shape_ops(scene::Shape kind) noexcept {
  switch (kind) {
    case scene::Shape::NONE:         // SceneView::check lets none through
    case scene::Shape::VectorField:  // volumes: control/fields
    case scene::Shape::PotentialField:
    case scene::Shape::Needle:
    case scene::Shape::Tissue:
    case scene::Shape::Plane:
      return kPlaneOps;
    case scene::Shape::Sphere:
      return kSphereOps;
    case scene::Shape::Box:
      return kBoxOps;
    case scene::Shape::Cylinder:
      return kCylinderOps;
    case scene::Shape::Capsule:
      return kCapsuleOps;
    case scene::Shape::Mesh:
      return kMeshOps;
  }
  return kPlaneOps;
}

}  // namespace thimble::control
