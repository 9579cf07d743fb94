#include "host-tools/compiler/convex_hull.h"

#include <array>
#include <cstdio>
#include <memory>

// Its macros must not reach other headers.
#include <libqhull_r/qhull_ra.h>

namespace thimble::host {

Hull hull_of(std::vector<Eigen::Vector3d> points) {
  Hull hull;
  constexpr std::size_t kLeast = 4;
  if (points.size() < kLeast) return hull;
  const std::unique_ptr<FILE, int (*)(FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
  if (!nowhere) return hull;
  qhT state;
  qhT* const qh = &state;
  qh_zero(qh, nowhere.get());
  std::array<char, 16> options{"qhull Pp Qt"};
  if (qh_new_qhull(qh, 3, static_cast<int>(points.size()), points.front().data(), 0, options.data(),
                   nowhere.get(), nowhere.get()) == 0) {
    qh_getarea(qh, qh->facet_list);
    hull.volume_m3 = qh->totvol;
    for (const vertexT* v = qh->vertex_list; v != nullptr && v->next != nullptr; v = v->next)
      hull.corners.emplace_back(v->point[0], v->point[1], v->point[2]);
    for (const facetT* f = qh->facet_list; f != nullptr && f->next != nullptr; f = f->next)
      hull.faces.push_back({Eigen::Vector3d(f->normal[0], f->normal[1], f->normal[2]), -f->offset});
  }
  qh_freeqhull(qh, 1);
  int kept = 0;
  int bytes = 0;
  qh_memfreeshort(qh, &kept, &bytes);
  return hull;
}

}  // namespace thimble::host
