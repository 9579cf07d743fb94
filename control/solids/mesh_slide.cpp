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

// The faces that a slide looks at: those that the finger keeps, if it does.
class Faces {
 public:
  Faces(const ShapeData& shape, TriangleCache* kept) : shape_(shape), kept_(kept) {}
  // It stays valid until the next one is asked for.
  // Out of line: it is asked for in eight places, and the boards have little code memory.
  [[gnu::noinline]] const KeptFace& operator[](std::uint32_t triangle) {
    if (kept_ != nullptr) return kept_->face(shape_, triangle);
    keep_face(shape_, triangle, own_);
    return own_;
  }
  [[nodiscard]] const MeshView& mesh() const { return shape_.mesh; }

 private:
  const ShapeData& shape_;
  TriangleCache* const kept_;
  KeptFace own_;
};

// Whether the target is on the free side of the surface, for the feature with the point nearest to the
// target. False where the work is spent.
bool target_is_free(Faces& faces, const Feature& f, const Vec3& target, Work& work) {
  const MeshView& mesh = faces.mesh();
  if (f.kind == kFace) return in_front(faces[f.index], f.side, target);
  if (f.kind == kEdge) {
    const Step beyond = across(mesh, f.index, f.side, f.corner);
    const bool here = in_front(faces[f.index], f.side, target);
    const bool there = in_front(faces[beyond.triangle], beyond.side, target);
    return concave(mesh, f.index, f.side, beyond) ? here && there : here || there;
  }
  // Baerentzen and Aanaes 2005: at a vertex the angle-weighted pseudonormal tells the side.
  const float height = pseudonormal(mesh, f.index, f.corner).dot(target - vertex(mesh, f.index, f.corner));
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

Vec3 along(const KeptFace& face, std::uint32_t edge) { return face.corner[next(edge)] - face.corner[edge]; }

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
bool walk_face(const KeptFace& face, std::int8_t side, std::uint32_t entered, const Vec3& target,
               Foot& foot) {
  if (entered != kNoEdge && height_over(face, entered, target) <= 0.0F) return false;
  float t = 1.0F;
  std::uint32_t exit = kNoEdge;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    if (edge == entered) continue;
    const float there = height_over(face, edge, target);
    if (there >= 0.0F) continue;
    const float here = std::max(height_over(face, edge, foot.at), 0.0F);
    const float leaves = here / (here - there);
    if (leaves < t) {
      t = leaves;
      exit = edge;
    }
  }
  const Vec3 goal = project(face, target);
  if (exit == kNoEdge) {
    foot = {{face.triangle, kFace, 0, side}, goal};
    return true;
  }
  // On the edge: its point nearest to the crossing.
  const Vec3 crossing = foot.at + t * (goal - foot.at);
  const Vec3 edge = along(face, exit);
  const float length2 = edge.squaredNorm();
  const float part = edge.dot(crossing - face.corner[exit]);
  // A crossing within this distance of a corner counts as the corner; otherwise a walk could circle the
  // corner in steps of no length.
  constexpr float kSnap_m = 1.0e-8F;
  const float snap2 = kSnap_m * kSnap_m * length2;
  const float rest = length2 - part;
  if (part <= 0.0F || part * part <= snap2) {
    foot = {on_vertex(face.triangle, exit, side), face.corner[exit]};
  } else if (rest <= 0.0F || rest * rest <= snap2) {
    foot = {on_vertex(face.triangle, next(exit), side), face.corner[next(exit)]};
  } else {
    foot = {on_edge(face.triangle, exit, side), face.corner[exit] + (part / length2) * edge};
  }
  return true;
}

// Along an edge towards the target, to the point nearest to it or to the end.
Foot walk_edge(const KeptFace& face, const Feature& f, const Vec3& target) {
  const Vec3 edge = along(face, f.corner);
  const float length2 = edge.squaredNorm();
  const float part = edge.dot(target - face.corner[f.corner]);
  if (part <= 0.0F) return {on_vertex(f.index, f.corner, f.side), face.corner[f.corner]};
  if (part >= length2) return {on_vertex(f.index, next(f.corner), f.side), face.corner[next(f.corner)]};
  return {f, face.corner[f.corner] + (part / length2) * edge};
}

// How a slide continues: over a face, along an edge, or not at all.
enum class Lead : std::uint8_t { kNowhere, kOverFace, kAlongEdge };

// The distance of the target's projection from an edge, into the face; at most 0 when it is not inside.
float draw_inwards(const KeptFace& face, std::uint32_t edge, const Vec3& target) {
  return height_over(face, edge, target) / std::sqrt(face.normal2 * along(face, edge).squaredNorm());
}

Lead lead_from_edge(Faces& faces, Feature& f, const Vec3& target) {
  const Step beyond = across(faces.mesh(), f.index, f.side, f.corner);
  const float here = draw_inwards(faces[f.index], f.corner, target);
  const float there =
      beyond.triangle == f.index ? here : draw_inwards(faces[beyond.triangle], beyond.edge, target);
  if (here <= 0.0F && there <= 0.0F) return Lead::kAlongEdge;  // the target is beyond the edge for both faces
  f = here >= there ? Feature{f.index, kFace, 0, f.side} : Feature{beyond.triangle, kFace, 0, beyond.side};
  return Lead::kOverFace;
}

// kNowhere also where the work is spent.
Lead lead_from_vertex(Faces& faces, Feature& f, const Vec3& target, Work& work) {
  const MeshView& mesh = faces.mesh();
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
    const KeptFace& face = faces[at.triangle];
    const bool inside = height_over(face, at.corner, target) >= 0.0F &&
                        height_over(face, previous(at.corner), target) >= 0.0F;
    if (inside) {
      const float draw2 = (project(face, target) - v).squaredNorm();
      if (draw2 > steepest2) {
        steepest2 = draw2;
        lead = Lead::kOverFace;
        f = {at.triangle, kFace, 0, at.side};
      }
    } else {
      const Vec3 edge = along(face, at.corner);
      const float draw = edge.dot(pull);
      if (draw > 0.0F && draw * draw > steepest2 * edge.squaredNorm()) {
        steepest2 = draw * draw / edge.squaredNorm();
        lead = Lead::kAlongEdge;
        f = on_edge(at.triangle, at.corner, at.side);
      }
      const Vec3 back = face.corner[previous(at.corner)] - v;
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

// Whether a slide over faces of the size of this one would take more than the work that is left.
bool is_far(const KeptFace& face, const SlideQuery& query) {
  // A way as long as the edge of a face goes over up to three faces.
  constexpr float kUnitsAnEdge = 3.0F * static_cast<float>(kFaceWork);
  constexpr std::uint32_t kFlights = 64;  // what the way through the air takes
  constexpr std::uint32_t kMuch = 4 * kFaceWork * kMaxSlideFaces;
  if (query.work.at_hand() < kFlights || query.work.at_hand() > kMuch || face.is_point) return false;
  const Vec3 way = query.target - query.from;
  const float height = face.normal.dot(way);
  const float along2 = way.squaredNorm() - height * height / face.normal2;
  const float edges = static_cast<float>(query.work.at_hand()) / kUnitsAnEdge;
  return along2 > edges * edges * std::sqrt(face.normal2);
}

// The path of a god object: straight over each face towards the projection of the target, on over the edges
// that it crosses, and along an edge when the target is beyond it for both faces (Zilles and Salisbury 1995,
// with the real faces instead of infinite planes).
[[gnu::noinline]] Slide slide_over_faces(Faces& faces, const ShapeData& shape, Feature& feature,
                                         const SlideQuery& query) {
  const MeshView& mesh = shape.mesh;
  if (query.not_far && is_far(faces[feature.index], query)) return {query.from, SlideEnd::kFar};
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
      if (!query.hold && in_front(faces[beyond.triangle], beyond.side, query.target) &&
          !concave(mesh, foot.feature.index, foot.feature.side, beyond)) {
        end = SlideEnd::kFree;
        break;
      }
      next_feature = {beyond.triangle, kFace, 0, beyond.side};
    } else if (foot.feature.kind == kEdge) {
      lead = lead_from_edge(faces, next_feature, query.target);
    } else if (foot.feature.kind == kVertex) {
      lead = lead_from_vertex(faces, next_feature, query.target, query.work);
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
      if (!walk_face(faces[next_feature.index], next_feature.side, beyond.edge, query.target, foot)) {
        over_edge = false;  // the next face leads back to the edge: continue along the edge
        foot = walk_edge(faces[foot.feature.index], foot.feature, query.target);
        lead = Lead::kAlongEdge;
      }
    } else {
      foot = walk_edge(faces[next_feature.index], next_feature, query.target);
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
  if (end == SlideEnd::kHeld && !query.hold && target_is_free(faces, feature, query.target, query.work))
    end = SlideEnd::kFree;
  return {foot.at, end, swept};
}

}  // namespace

Slide slide_on_mesh(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  Faces faces(shape, query.triangles);
  if (feature.kind == kFace) {
    const KeptFace& face = faces[feature.index];
    if (is_over(face, query.target) && (face.slides || !query.sweeps) && query.work.spend(kFaceWork)) {
      const bool free = !query.hold && in_front(face, feature.side, query.target);
      return {project(face, query.target), free ? SlideEnd::kFree : SlideEnd::kHeld, face.slides};
    }
  }
  return slide_over_faces(faces, shape, feature, query);
}

}  // namespace thimble::control
