#include "host-tools/compiler/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace thimble::host {
namespace {

constexpr std::size_t kMaxEarTests =
    50'000'000;  // points looked at; bounds the time for one polygon to about a second

}  // namespace

void append_polygon(std::vector<std::uint32_t> polygon, TriangleSoup& soup) {
  const std::vector<Eigen::Vector3d>& at = soup.vertices_m;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Newell: twice the area
  for (std::size_t i = 0; polygon.size() > 3 && i < polygon.size(); ++i) {
    normal += (at[polygon[i]] - at[polygon[0]]).cross(at[polygon[(i + 1) % polygon.size()]] - at[polygon[0]]);
  }
  const auto turn = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return (at[b] - at[a]).cross(at[c] - at[b]).dot(normal);
  };
  std::size_t tests = 0;
  while (polygon.size() > 3) {
    const std::size_t size = polygon.size();
    std::size_t ear = 1;
    double shortest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < size && tests < kMaxEarTests; ++i) {
      const std::uint32_t a = polygon[(i + size - 1) % size];
      const std::uint32_t b = polygon[i];
      const std::uint32_t c = polygon[(i + 1) % size];
      ++tests;
      if (!(turn(a, b, c) > 0)) {
        continue;
      }
      tests += size;
      const bool empty = std::none_of(polygon.begin(), polygon.end(), [&](std::uint32_t p) {
        return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
      });
      if (!empty) {
        continue;
      }
      if (size > 4) {
        ear = i;
        break;
      }
      // A quad is cut along its shorter diagonal: better faces, and two quads round a vertex of two do not
      // coincide.
      const double diagonal = (at[c] - at[a]).squaredNorm();
      if (diagonal < (1.0 - 1.0e-9) * shortest) {
        shortest = diagonal;
        ear = i;
      }
    }
    soup.triangles.push_back({polygon[(ear + size - 1) % size], polygon[ear], polygon[(ear + 1) % size]});
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  if (polygon.size() == 3) {
    soup.triangles.push_back({polygon[0], polygon[1], polygon[2]});
  }
}

}  // namespace thimble::host
