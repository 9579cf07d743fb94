// Slides over a mesh: straight from face to face over shared edges.
//
// Every piece reduces the distance to the target. So a slide that is cut short has made progress and has
// passed through nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/near_triangles.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxSlideFaces = 128;  // faces and edges walked over in one slide
// A face far smaller than the surface tolerance is treated as one point.
constexpr float kPoint_m4 = 1.0e-30F;

// Whether the target is on the free side of the surface, for the feature with the point nearest to the
// target. False where the work is spent.
bool target_is_free(const MeshView& mesh, const Feature& f, const Vec3& target, Work& work) {
  if (f.kind == kFace) return in_front(mesh, f.index, f.side, target);
  if (f.kind == kEdge) {
    const Step beyond = across(mesh, f.index, f.side, f.corner);
    const bool here = in_front(mesh, f.index, f.side, target);
    const bool there = in_front(mesh, beyond.triangle, beyond.side, target);
    return concave(mesh, f.index, f.side, beyond) ? here && there : here || there;
  }
  // Baerentzen and Aanaes 2005: at a vertex the angle-weighted pseudonormal tells the side.
  const scene::Vertex& v = mesh.vertices[vertex_index(mesh, f.index, f.corner)];
  const float height = to_vec(v.pseudonormal()).dot(target - to_vec(v.position_m()));
  if (!two_sided(mesh, f.index)) return height > 0.0F;
  // At the rim of a sheet the faces around the vertex count with both sides: free when in front of any of
  // them.
  Corner at{f.index, f.corner, f.side};
  for (int n = 0; n < kMaxFan; ++n) {
    if (!work.spend(kFanWork)) return false;
    at = next_in_fan(mesh, at);
    if (at.side != f.side) return true;
    if (at.triangle == f.index) break;
  }
  return f.side > 0 ? height > 0.0F : height < 0.0F;
}

// A triangle in its plane. The height of a point over an edge, positive inwards, is (n x edge) . (p - v) in
// units of |n| |edge| m. Products of dot products would cancel on thin triangles.
struct Plane {
  std::array<Vec3, 3> corner;
  Vec3 normal;

  Plane(const MeshView& mesh, std::uint32_t triangle)
      : corner{vertex(mesh, triangle, 0), vertex(mesh, triangle, 1), vertex(mesh, triangle, 2)},
        normal((corner[1] - corner[0]).cross(corner[2] - corner[0])) {}
  [[nodiscard]] Vec3 along(std::uint32_t edge) const { return corner[next(edge)] - corner[edge]; }
  [[nodiscard]] Vec3 inwards(std::uint32_t edge) const { return normal.cross(along(edge)); }
  [[nodiscard]] float height(std::uint32_t edge, const Vec3& p) const {
    return inwards(edge).dot(p - corner[edge]);
  }
  [[nodiscard]] Vec3 project(const Vec3& p) const {
    const float normal2 = normal.squaredNorm();
    return normal2 > kPoint_m4 ? Vec3(p - (normal.dot(p - corner[0]) / normal2) * normal) : corner[0];
  }
};

// The state of a slide: its feature and its point.
struct Foot {
  Feature feature;
  Vec3 at;
};

Feature on_edge(std::uint32_t triangle, std::uint32_t edge, std::int8_t side) {
  return {triangle, kEdge, static_cast<std::uint8_t>(edge), side};
}
Feature on_vertex(std::uint32_t triangle, std::uint32_t corner, std::int8_t side) {
  return {triangle, kVertex, static_cast<std::uint8_t>(corner), side};
}

constexpr std::uint32_t kNoEdge = 3;

// Straight over one face towards the projection of the target, up to it or to the edge where the path leaves
// the face. entered: the edge where the path enters the face, if any; false when the path does not lead
// inwards from there.
bool walk_face(const MeshView& mesh, std::uint32_t triangle, std::int8_t side, std::uint32_t entered,
               const Vec3& target, Foot& foot) {
  const Plane plane(mesh, triangle);
  if (entered != kNoEdge && plane.height(entered, target) <= 0.0F) return false;
  float t = 1.0F;
  std::uint32_t exit = kNoEdge;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    if (edge == entered) continue;
    const Vec3 inwards = plane.inwards(edge);
    const float there = inwards.dot(target - plane.corner[edge]);
    if (there >= 0.0F) continue;
    const float here = std::max(inwards.dot(foot.at - plane.corner[edge]), 0.0F);
    const float leaves = here / (here - there);
    if (leaves < t) {
      t = leaves;
      exit = edge;
    }
  }
  const Vec3 goal = plane.project(target);
  if (exit == kNoEdge) {
    foot = {{triangle, kFace, 0, side}, goal};
    return true;
  }
  // On the edge: its point nearest to the crossing.
  const Vec3 crossing = foot.at + t * (goal - foot.at);
  const Vec3 along = plane.along(exit);
  const float length2 = along.squaredNorm();
  const float part = along.dot(crossing - plane.corner[exit]);
  // A crossing within this distance of a corner counts as the corner; otherwise a walk could circle the
  // corner in steps of no length.
  constexpr float kSnap_m = 1.0e-8F;
  const float snap2 = kSnap_m * kSnap_m * length2;
  const float rest = length2 - part;
  if (part <= 0.0F || part * part <= snap2) {
    foot = {on_vertex(triangle, exit, side), plane.corner[exit]};
  } else if (rest <= 0.0F || rest * rest <= snap2) {
    foot = {on_vertex(triangle, next(exit), side), plane.corner[next(exit)]};
  } else {
    foot = {on_edge(triangle, exit, side), plane.corner[exit] + (part / length2) * along};
  }
  return true;
}

// Along an edge towards the target, to the point nearest to it or to the end.
Foot walk_edge(const MeshView& mesh, const Feature& f, const Vec3& target) {
  const Plane plane(mesh, f.index);
  const Vec3 along = plane.along(f.corner);
  const float length2 = along.squaredNorm();
  const float part = along.dot(target - plane.corner[f.corner]);
  if (part <= 0.0F) return {on_vertex(f.index, f.corner, f.side), plane.corner[f.corner]};
  if (part >= length2) return {on_vertex(f.index, next(f.corner), f.side), plane.corner[next(f.corner)]};
  return {f, plane.corner[f.corner] + (part / length2) * along};
}

// How a slide continues: over a face, along an edge, or not at all.
enum class Lead : std::uint8_t { kNowhere, kOverFace, kAlongEdge };

// The distance of the target's projection from an edge, into the face; at most 0 when it is not inside.
float draw_inwards(const MeshView& mesh, std::uint32_t triangle, std::uint32_t edge, const Vec3& target) {
  const Plane plane(mesh, triangle);
  return plane.height(edge, target) / std::sqrt(plane.normal.squaredNorm() * plane.along(edge).squaredNorm());
}

Lead lead_from_edge(const MeshView& mesh, Feature& f, const Vec3& target) {
  const Step beyond = across(mesh, f.index, f.side, f.corner);
  const float here = draw_inwards(mesh, f.index, f.corner, target);
  const float there =
      beyond.triangle == f.index ? here : draw_inwards(mesh, beyond.triangle, beyond.edge, target);
  if (here <= 0.0F && there <= 0.0F) return Lead::kAlongEdge;  // the target is beyond the edge for both faces
  f = here >= there ? Feature{f.index, kFace, 0, f.side} : Feature{beyond.triangle, kFace, 0, beyond.side};
  return Lead::kOverFace;
}

// kNowhere also where the work is spent.
Lead lead_from_vertex(const MeshView& mesh, Feature& f, const Vec3& target, Work& work) {
  const Corner start{f.index, f.corner, f.side};
  const Vec3 v = vertex(mesh, f.index, f.corner);
  const Vec3 pull = target - v;
  // The steepest descent over all faces and edges; a descent below rounding does not count.
  constexpr float kRounding = 1.2e-7F;
  const float least = kRounding * (std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z()) + pull.norm());
  float steepest2 = least * least;
  Lead lead = Lead::kNowhere;
  Corner at = start;
  for (int n = 0; n < kMaxFan; ++n) {
    if (!work.spend(kFanWork)) return Lead::kNowhere;
    const Plane plane(mesh, at.triangle);
    const bool inside =
        plane.height(at.corner, target) >= 0.0F && plane.height(previous(at.corner), target) >= 0.0F;
    if (inside) {
      const float draw2 = (plane.project(target) - v).squaredNorm();
      if (draw2 > steepest2) {
        steepest2 = draw2;
        lead = Lead::kOverFace;
        f = {at.triangle, kFace, 0, at.side};
      }
    } else {
      const Vec3 along = plane.along(at.corner);
      const float draw = along.dot(pull);
      if (draw > 0.0F && draw * draw > steepest2 * along.squaredNorm()) {
        steepest2 = draw * draw / along.squaredNorm();
        lead = Lead::kAlongEdge;
        f = on_edge(at.triangle, at.corner, at.side);
      }
      const Vec3 back = plane.corner[previous(at.corner)] - v;
      const float draw_back = back.dot(pull);
      if (draw_back > 0.0F && draw_back * draw_back > steepest2 * back.squaredNorm()) {
        steepest2 = draw_back * draw_back / back.squaredNorm();
        lead = Lead::kAlongEdge;
        f = on_edge(at.triangle, previous(at.corner), at.side);
      }
    }
    at = next_in_fan(mesh, at);
    if (at.triangle == start.triangle && at.side == start.side) break;
  }
  return lead;
}

bool edge_pierced(const MeshView& mesh, const Feature& f) {
  return pierced(mesh, f.index) || pierced(mesh, across(mesh, f.index, f.side, f.corner).triangle);
}

// Whether a piece on which the mesh may cross itself is known to cross nothing. Parts that touch count as several solids: no.
bool is_free(const ShapeData& shape, const Foot& from, const Foot& to, const SlideQuery& query) {
  if (!query.sweeps || shape.mesh.seams) return false;
  std::array<Feature, 3> leaving{from.feature, to.feature};
  std::size_t count = 2;
  if (query.beside != nullptr) {
    leaving[count] = *query.beside;
    leaving[count++].kind = kSideOnly;
  }
  Hit hit;
  return sweep_mesh(shape, {query.work, from.at, to.at, {leaving.data(), count}, query.triangles}, hit) &&
         hit.t > 1.0F;
}

}  // namespace

[[gnu::noinline]] void keep(const ShapeData& shape, std::uint32_t triangle, KeptFace& face) {
  const Plane plane(shape.mesh, triangle);
  const float normal2 = plane.normal.squaredNorm();
  if (normal2 <= kPoint_m4) return;
  face = {&shape,       triangle, plane.corner, {plane.inwards(0), plane.inwards(1), plane.inwards(2)},
          plane.normal, normal2};
}

// Whether the slide stays on the kept face.
bool stays(const ShapeData& shape, const KeptFace& face, const Feature& feature, const SlideQuery& query) {
  return face.triangle == feature.index && feature.kind == kFace && face.shape == &shape &&
         face.inwards[0].dot(query.target - face.corner[0]) >= 0.0F &&
         face.inwards[1].dot(query.target - face.corner[1]) >= 0.0F &&
         face.inwards[2].dot(query.target - face.corner[2]) >= 0.0F && query.work.spend(kFaceWork);
}

// A slide that stays on it: the same bits as without it.
Slide slide_on_kept(const KeptFace& face, const Feature& feature, const SlideQuery& query) {
  const float height = face.normal.dot(query.target - face.corner[0]);
  const bool free = !query.hold && (height >= 0.0F) == (feature.side > 0);
  return {query.target - (height / face.normal2) * face.normal, free ? SlideEnd::kFree : SlideEnd::kHeld};
}

// Whether a slide over faces of the size of this one would take more than the work that is left.
bool is_far(const MeshView& mesh, const Feature& feature, const SlideQuery& query) {
  // A way as long as the edge of a face goes over up to three faces.
  constexpr float kUnitsAnEdge = 3.0F * static_cast<float>(kFaceWork);
  constexpr std::uint32_t kFlights = 64;  // what the way through the air takes
  constexpr std::uint32_t kMuch = 4 * kFaceWork * kMaxSlideFaces;
  if (query.work.at_hand() < kFlights || query.work.at_hand() > kMuch) return false;
  const Vec3 way = query.target - query.from;
  const Vec3 normal = area_normal(mesh, feature.index);
  const float normal2 = normal.squaredNorm();
  if (normal2 <= kPoint_m4) return false;
  const float height = normal.dot(way);
  const float along2 = way.squaredNorm() - height * height / normal2;
  const float edges = static_cast<float>(query.work.at_hand()) / kUnitsAnEdge;
  return along2 > edges * edges * std::sqrt(normal2);
}

// The path of a god object: straight over each face towards the projection of the target, on over the edges
// that it crosses, and along an edge when the target is beyond it for both faces (Zilles and Salisbury 1995,
// with the real faces instead of infinite planes).
Slide slide_on_mesh(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  if (query.triangles != nullptr && stays(shape, query.triangles->face(), feature, query))
    return slide_on_kept(query.triangles->face(), feature, query);
  if (query.triangles == nullptr && feature.kind == kFace && !query.sweeps) {
    KeptFace face;
    keep(shape, feature.index, face);
    if (stays(shape, face, feature, query)) {
      Slide slide = slide_on_kept(face, feature, query);
      slide.swept = !pierced(shape.mesh, feature.index);
      return slide;
    }
  }
  const MeshView& mesh = shape.mesh;
  if (query.not_far && is_far(mesh, feature, query)) return {query.from, SlideEnd::kFar};
  Foot foot{feature, query.from};
  bool moved = false;
  bool over_edge = false;  // the path has just crossed foot.feature, an edge
  SlideEnd end = SlideEnd::kBound;
  bool swept = true;
  Foot before = foot;
  for (int pieces = 0; pieces < kMaxSlideFaces && query.work.spend(kFaceWork); ++pieces) {
    // The next piece: over a face, or along an edge.
    Feature next_feature = foot.feature;
    Lead lead = Lead::kOverFace;
    Step beyond{0, kNoEdge, 1};
    if (over_edge) {
      beyond = across(mesh, foot.feature.index, foot.feature.side, foot.feature.corner);
      // At a convex edge with the target in front of the next face, the path leaves the surface.
      if (!query.hold && in_front(mesh, beyond.triangle, beyond.side, query.target) &&
          !concave(mesh, foot.feature.index, foot.feature.side, beyond)) {
        end = SlideEnd::kFree;
        break;
      }
      next_feature = {beyond.triangle, kFace, 0, beyond.side};
    } else if (foot.feature.kind == kEdge) {
      lead = lead_from_edge(mesh, next_feature, query.target);
    } else if (foot.feature.kind == kVertex) {
      lead = lead_from_vertex(mesh, next_feature, query.target, query.work);
      if (query.work.is_spent()) break;
    }
    if (lead == Lead::kNowhere) {
      foot.at = vertex(mesh, foot.feature.index,
                       foot.feature.corner);  // not `from`, whose rounding would accumulate
      end = SlideEnd::kHeld;
      break;
    }
    swept =
        !pierced(mesh, next_feature.index) && !(lead == Lead::kAlongEdge && edge_pierced(mesh, next_feature));
    before = foot;
    if (lead == Lead::kOverFace) {
      if (!walk_face(mesh, next_feature.index, next_feature.side, beyond.edge, query.target, foot)) {
        over_edge = false;  // the next face leads back to the edge: continue along the edge
        foot = walk_edge(mesh, foot.feature, query.target);
        lead = Lead::kAlongEdge;
      }
    } else {
      foot = walk_edge(mesh, next_feature, query.target);
    }
    if (!swept) swept = is_free(shape, before, foot, query);
    if (!swept && moved) {  // then this piece is a slide of its own
      feature = before.feature;
      return {before.at, SlideEnd::kMoved};
    }
    moved = true;
    over_edge = lead == Lead::kOverFace && foot.feature.kind == kEdge;
    if (foot.feature.kind == kFace || (lead == Lead::kAlongEdge && foot.feature.kind == kEdge)) {
      end = SlideEnd::kHeld;
      break;
    }
    if (query.one_piece || !swept) {
      end = SlideEnd::kMoved;
      break;
    }
  }
  feature = foot.feature;
  if (end == SlideEnd::kHeld && !query.hold && target_is_free(mesh, feature, query.target, query.work))
    end = SlideEnd::kFree;
  if (query.triangles != nullptr && end == SlideEnd::kHeld && feature.kind == kFace &&
      !pierced(mesh, feature.index))
    keep(shape, feature.index, query.triangles->face());
  return {foot.at, end, swept};
}

}  // namespace thimble::control
