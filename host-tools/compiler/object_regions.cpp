#include "host-tools/compiler/object_regions.h"

#include <Eigen/Geometry>

#include "control/scene/limits.h"
#include "host-tools/compiler/checked_scene.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

Vector3d vector_of(const scene::Vec3& v) { return Eigen::Vector3f(v.x(), v.y(), v.z()).cast<double>(); }

void set_round(ObjectRegion& region, double radius_m, double bottom_m, double top_m) {
  region.lo_m = {-radius_m, -radius_m, bottom_m};
  region.hi_m = {radius_m, radius_m, top_m};
}

void set_mesh(ObjectRegion& region, const scene::Mesh& mesh) {
  region.lo_m = region.hi_m = vector_of(mesh.vertices()->Get(0)->position_m());
  for (const scene::Vertex* vertex : *mesh.vertices()) {
    region.lo_m = region.lo_m.cwiseMin(vector_of(vertex->position_m()));
    region.hi_m = region.hi_m.cwiseMax(vector_of(vertex->position_m()));
  }
}

void set_potential(ObjectRegion& region, const scene::PotentialField& field) {
  region.lo_m = vector_of(*field.origin_m());
  for (int axis = 0; axis < 3; ++axis)
    region.hi_m[axis] = region.lo_m[axis] + static_cast<double>(field.step_m()) *
                                                (field.count()->Get(static_cast<unsigned>(axis)) - 1);
}

// In the frame of the object.
void set_box(ObjectRegion& region, const scene::Object& object) {
  const auto metres = [](float value) { return static_cast<double>(value); };
  switch (object.shape_type()) {
    case scene::Shape::NONE:
      return;
    case scene::Shape::Plane: {
      const scene::Plane& plane = *object.shape_as_Plane();
      region.rotation *=
          Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), vector_of(plane.normal())).matrix();
      region.hi_m.z() = metres(plane.offset_m());
      return;
    }
    case scene::Shape::Sphere: {
      const double radius_m = metres(object.shape_as_Sphere()->radius_m());
      return set_round(region, radius_m, -radius_m, radius_m);
    }
    case scene::Shape::Box:
      region.hi_m = vector_of(object.shape_as_Box()->half_size_m());
      region.lo_m = -region.hi_m;
      return;
    case scene::Shape::Cylinder: {
      const scene::Cylinder& it = *object.shape_as_Cylinder();
      return set_round(region, metres(it.radius_m()), -metres(it.half_height_m()),
                       metres(it.half_height_m()));
    }
    case scene::Shape::Capsule: {
      const scene::Capsule& it = *object.shape_as_Capsule();
      const double end_m = metres(it.half_height_m()) + metres(it.radius_m());
      return set_round(region, metres(it.radius_m()), -end_m, end_m);
    }
    case scene::Shape::Cone: {
      const scene::Cone& it = *object.shape_as_Cone();
      return set_round(region, metres(it.radius_m()), -0.25 * metres(it.height_m()),
                       0.75 * metres(it.height_m()));
    }
    case scene::Shape::Mesh:
      return set_mesh(region, *object.shape_as_Mesh());
    case scene::Shape::VectorField:
      region.lo_m = vector_of(*object.shape_as_VectorField()->lo_m());
      region.hi_m = vector_of(*object.shape_as_VectorField()->hi_m());
      return;
    case scene::Shape::ForceField: {
      const Vector3d half_m = vector_of(object.shape_as_ForceField()->half_size_m());
      if (half_m.minCoeff() == metres(control::kMaxCoordinate_m)) return;  // everywhere
      region.hi_m = half_m;
      region.lo_m = -half_m;
      return;
    }
    case scene::Shape::PotentialField:
      return set_potential(region, *object.shape_as_PotentialField());
    case scene::Shape::Needle:  // felt from its skin on, along the object's -z
      region.lo_m.head<2>().setZero();
      region.hi_m.setZero();
      return;
    case scene::Shape::Tissue: {
      const scene::Tissue& it = *object.shape_as_Tissue();
      region.hi_m = {metres(it.half_x_m()), metres(it.half_y_m()), 0};
      region.lo_m.head<2>() = -region.hi_m.head<2>();
      return;
    }
  }
}

}  // namespace

std::vector<ObjectRegion> object_regions(std::span<const std::byte> image) {
  std::vector<ObjectRegion> regions;
  const CheckedScene checked(image);
  if (checked.scene() == nullptr) return regions;
  regions.reserve(checked.scene()->objects()->size());
  for (const scene::Object* object : *checked.scene()->objects()) {
    ObjectRegion& region = regions.emplace_back();
    region.name = object->name()->str();
    const scene::Quat& q = object->pose()->rotation();
    region.rotation = Eigen::Quaternionf(q.w(), q.x(), q.y(), q.z()).normalized().cast<double>().matrix();
    region.origin_m = vector_of(object->pose()->position_m());
    set_box(region, *object);
  }
  return regions;
}

}  // namespace thimble::host
