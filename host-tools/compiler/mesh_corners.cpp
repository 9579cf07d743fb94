#include "host-tools/compiler/mesh_corners.h"

#include "host-tools/compiler/portable_math.h"

namespace thimble::host {

using Eigen::Vector3d;

std::vector<Vector3d> mean_normals(const Surface& surface, const std::vector<Vector3d>& face_normals,
                                   DisjointSets& sets) {
  std::vector<Vector3d> sum(face_normals.size() * 3, Vector3d::Zero());
  for (std::uint32_t corner = 0; corner < sum.size(); ++corner) {
    const TriangleIndices& t = surface.triangles[corner / 3];
    const Vector3d at = surface.point(t[corner % 3]);
    const Vector3d a = surface.point(t[next_edge(corner % 3)]) - at;
    const Vector3d b = surface.point(t[next_edge(next_edge(corner % 3))]) - at;
    sum[sets.find(corner)] += face_normals[corner / 3] * portable::atan2(a.cross(b).norm(), a.dot(b));
  }
  for (std::uint32_t corner = 0; corner < sum.size(); ++corner) {
    if (sets.find(corner) == corner) {
      const double length = sum[corner].norm();
      // Faces whose normals cancel (a folded sheet) have no mean; the normal of one face is used.
      sum[corner] = length > 1.0e-6 ? (sum[corner] / length).eval() : face_normals[corner / 3];
    }
  }
  return sum;
}

}  // namespace thimble::host
