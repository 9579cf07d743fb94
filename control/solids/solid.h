// The operations of a solid. Each kind of solid is one file in this folder with a SolidOps; its row is in
// control/scene/shape_table.h.
//
// All coordinates are in the object's own frame, in metres. A solid has a free side. The god object is a
// point that never enters a solid; it either flies (sweep) or slides over a surface (slide). Nothing here
// allocates or fails. What can take long spends work first, and is cut short when that is spent.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "control/scene/image_verdict.h"
#include "control/scene/limits.h"
#include "control/scene/pauses.h"
#include "control/scene/shape_table.h"
#include "control/solids/mesh_view.h"
#include "control/work.h"
#include "kinematics/vector.h"

namespace thimble::control {

// How far a point may lie inside a solid and still count as on its surface. Larger than the rounding of a
// point on the surface of an object within a metre (6e-8 m), smaller than anything a hand or an encoder
// resolves (2e-5 m).
inline constexpr float kSurfaceTolerance_m = 2.0e-7F;

// Feature.kind of a feature that only tells a sweep its side; it stops the flight like any other feature.
inline constexpr std::uint8_t kSideOnly = 3;

// The part of a shape's surface that a point is on. Each shape gives its own meaning to the index; side is -1
// on the back of a two-sided sheet.
struct Feature {
  std::uint32_t index = 0;
  std::uint8_t kind = 0;    // mesh: 0 face, 1 edge, 2 vertex
  std::uint8_t corner = 0;  // mesh: which edge or vertex of triangle `index`
  std::int8_t side = 1;

  bool operator==(const Feature&) const = default;
};

// The first place where a flight enters a solid.
struct Hit {
  float t = 2.0F;  // fraction of the segment; above 1: none
  Feature feature;
};

// A plane that a solid lies behind: its unit normal, to the free side, and how far in front of it a point is.
struct NearestPlace {
  Vec3 normal = Vec3::UnitZ();
  float outside_m = 0.0F;
};

// A plane behind which a part of a solid lies, seen from the centre of a ball in front of it.
struct Separation {
  Vec3 normal;
  float height_m;  // of the centre over the plane
  float apart_m;   // of the centre from that part of the solid: at least height_m
  Vec3 direct;     // the normal of the plane through its nearest place, apart_m below the centre
  bool ledge;      // the plane is that of a face that the centre is beside, by up to kFaceMargin_m
  Feature feature;
};

// A ball that is apart from a surface by no more than this touches it: above the rounding of places (1e-6 m at 10 m).
inline constexpr float kTouchGap_m = 2.0e-6F;

// A ball may be this far behind a plane that it chooses, by rounding and by the curvature of the surface that it moved
// along. It moves out again.
inline constexpr float kBehind_m = 1.0e-6F;

class TriangleCache;  // control/solids/near_triangles.h

// A ball, the place that it is drawn to, and the place nearest to that which the planes that it touches let it come
// to. Only what can come into its way matters.
struct BallQuery {
  Work& work;
  Vec3 centre_m;
  Vec3 aim_m;
  Vec3 target_m;
  float radius_m;
  float half_way_m;             // half of the distance from centre to target
  std::array<Vec3, 3> held_by;  // unit normals of the planes that it touches
  std::size_t held_count = 0;
  bool is_tip = false;                           // it is the tip itself: no level gap is closed for it
  std::array<std::uint32_t, 3> held_features{};  // of this solid: the parts behind planes that it touches
  std::size_t held_feature_count = 0;
  float reach_m = 0.0F;  // of a tip: of a mesh only what the centre can touch after moving by this matters
  TriangleCache* triangles = nullptr;  // of a tip, for one mesh

  // Whether the ball can come to this plane while it comes nearer to the target: its centre stays in the ball over the
  // line between them.
  [[nodiscard]] bool meets(const Vec3& normal, float height_m) const {
    return height_m + 0.5F * normal.dot(target_m - centre_m) - half_way_m < radius_m;
  }
};

// A ball that touches a part of a solid, and is to move to the place nearest to the target.
struct BallRoll {
  Work& work;
  Vec3 centre_m;
  Vec3 target_m;
  float radius_m;
  bool hold;  // stay on the surface also where the target is above it
  Feature feature;
  Vec3 normal;               // at the end
  TriangleCache* triangles;  // of the finger; null: none
};

// Chooses among planes in front of one part of a solid: the one that the ball comes to last on its way to the aim,
// which is where the way enters a convex solid, then the one that leaves the longest way to the target.
class PlaneChoice {
 public:
  PlaneChoice(const BallQuery& ball, Separation& chosen) : ball_(ball), chosen_(chosen) {}

  // The plane through the place nearest to the centre: the first one.
  void offer_direct(const Vec3& normal) {
    chosen_.direct = normal;
    chosen_.ledge = false;
    offer(normal, chosen_.apart_m);
  }
  // The plane of a face: alone, where the face is below the centre or beside it.
  void offer_face(const Vec3& normal, float height_m) {
    const float beside2 = (chosen_.apart_m - height_m) * (chosen_.apart_m + height_m);
    const float margin_m = ball_.is_tip ? kTouchGap_m : kFaceMargin_m;
    if (height_m >= ball_.radius_m - kBehind_m && beside2 <= margin_m * margin_m) {
      first_ = true;
      chosen_.ledge = beside2 > kTouchGap_m * kTouchGap_m;
    }
    offer(normal, height_m);
  }
  // A plane that the centre is in front of by less than the radius is no choice, unless it is the first one.
  void offer(const Vec3& normal, float height_m) {
    if (!first_ && height_m < ball_.radius_m - kBehind_m) return;
    const float at_target_m = height_m + normal.dot(ball_.target_m - ball_.centre_m);
    const float meets = meets_at(normal, height_m);
    if (!first_ && (meets < meets_ || (meets == meets_ && at_target_m <= at_target_m_))) return;
    first_ = false;
    meets_ = meets;
    at_target_m_ = at_target_m;
    chosen_.normal = normal;
    chosen_.height_m = height_m;
  }
  // Whether the chosen plane is in the way to the aim.
  [[nodiscard]] bool blocks() const { return meets_ < 1.0F; }
  // Whether the ball can meet the plane, or touches what is behind it.
  [[nodiscard]] bool matters() const {
    return ball_.meets(chosen_.normal, chosen_.height_m) || chosen_.apart_m <= ball_.radius_m + kTouchGap_m;
  }

 private:
  // The part of the way to the aim after which the ball comes to the plane: 0 at once, 1 not at all.
  [[nodiscard]] float meets_at(const Vec3& normal, float height_m) const {
    constexpr float kRounding_m = 2.0e-8F;
    const float falls_m = -normal.dot(ball_.aim_m - ball_.centre_m);
    const float room_m = std::max(height_m - ball_.radius_m, 0.0F);
    return falls_m <= room_m + kRounding_m ? 1.0F : room_m / falls_m;
  }

  const BallQuery& ball_;
  Separation& chosen_;
  bool first_ = true;
  float meets_ = 0.0F;
  float at_target_m_ = 0.0F;
};

enum class SlideEnd : std::uint8_t {
  kHeld,   // `to` is the nearest point that the slide can reach, and the target is behind the surface
  kFree,   // the straight line from `to` to the target does not enter this solid at `to`
  kMoved,  // one piece of the path: slide again
  kBound,  // kMaxSlideFaces was reached, or the work is spent: `to` is on the surface, nearer to the target than before
  kFar,  // SlideQuery::not_far, and the way would take more than the work: the slide has not begun
};

// One piece of a slide, straight from `from` to `to` or in two straight parts over `via`, on the surface or
// on its free side.
struct Slide {
  Slide(const Vec3& there, SlideEnd how, bool is_swept = true) : to(there), end(how), swept(is_swept) {}
  Slide(const Vec3& round_by, const Vec3& there, SlideEnd how)
      : to(there), end(how), bent(true), via(round_by) {}

  Vec3 to;
  SlideEnd end;
  bool swept = true;  // the piece is known not to cross this same shape elsewhere
  bool bent = false;
  Vec3 via;  // only when bent
};

// A flight, straight from `from` to `to`.
struct SweepQuery {
  Work& work;
  const Vec3& from;
  const Vec3& to;
  std::span<const Feature> leaving;    // of this shape, that `from` is on: they do not stop the flight
  TriangleCache* triangles = nullptr;  // of the finger
};

struct SlideQuery {
  Work& work;
  const Vec3& from;
  const Vec3& target;
  bool hold = false;       // stay on the surface, whichever side the target is on
  bool one_piece = false;  // stop after each straight piece, so that it can be swept against other objects
  // Whether each piece on which the shape may cross itself is swept, `beside` being another part of it that `from` is on (null: none).
  // Where the way is not free, the slide ends before that piece, or is not `swept`.
  bool sweeps = false;
  const Feature* beside = nullptr;
  TriangleCache* triangles = nullptr;  // of the finger
  bool not_far = false;                // on a mesh: no slide that would surely be cut short
};

// Whether a point is in a solid.
enum class Containment : std::uint8_t {
  kOutside,
  kInside,
  kUnknown,  // a bound was hit
};

struct ShapeData {
  Vec3 vector = Vec3::Zero();  // plane: unit normal; box: half size
  float radius_m = 0.0F;       // plane: offset
  float half_height_m = 0.0F;
  MeshView mesh;
};

struct SurfacePoint;  // control/surfaces/chart.h
struct Chart;
struct Blend;  // control/scene/blend.h

struct SolidOps {
  // In the background, once: whether the numbers in the image are allowed. Adds to the scene's triangles.
  ImageVerdict (*check)(const scene::Object& object, std::size_t& triangles_in_scene, Pauses& pauses);
  // Reads the shape from a checked image.
  void (*view)(const scene::Object& object, ShapeData& shape);
  // Finds the first entry into the solid along from -> to before hit.t, and writes it to `hit`. False when a bound was hit
  // and the answer is not known.
  bool (*sweep)(const ShapeData& shape, const SweepQuery& query, Hit& hit);
  // Slides `from`, which is on `feature`, over the surface towards the point nearest to `target`; `feature`
  // follows.
  Slide (*slide)(const ShapeData& shape, Feature& feature, const SlideQuery& query);
  // The planes through flat faces and straight walls that face the point, beside the plane at the place nearest to it
  // (CollisionOps::nearest); returns how many. Null: there are none.
  std::size_t (*faces)(const ShapeData& shape, const Vec3& point, std::span<NearestPlace, 3> out) = nullptr;
  // The feature whose surface has this normal. Null: there is one only.
  Feature (*feature)(const ShapeData& shape, const Vec3& normal) = nullptr;
  // Of a solid that is not convex: a plane for each part that the ball could meet on its way; returns how many, more
  // than there is room for when they do not fit. free_m: reduced to how far the centre may move because of parts that
  // were left out. Null: the solid is convex.
  std::size_t (*separate)(const ShapeData& shape, const BallQuery& ball, std::span<Separation> out,
                          float& free_m) = nullptr;
  // Whether a ball at this centre, and no nearer, touches that part with this normal. With separate only.
  bool (*touches)(const ShapeData& shape, const Feature& feature, const Vec3& centre, float radius_m,
                  const Vec3& normal) = nullptr;
  // The short way of a ball that touches one part of this solid, and may touch no other on its way to the target. False,
  // and nothing is changed, where that is not certain. With separate only.
  bool (*roll)(const ShapeData& shape, BallRoll& ball) = nullptr;
  // Whether a point is in a solid that is not convex. Null: its nearest place tells (CollisionOps::nearest).
  Containment (*contains)(const ShapeData& shape, const Vec3& point, Work& work) = nullptr;
  // The unit normals of the constraints at a point on `feature`, to the free side; returns how many, 1 to 3.
  int (*normals)(const ShapeData& shape, const Feature& feature, const Vec3& point, std::span<Vec3, 3> out);
  // Half extents of a box about the object's origin that holds the solid.
  Vec3 (*reach)(const ShapeData& shape);
  // The chart of a place, where the texture is not blended. Null: that of the plane square to the normal.
  Chart (*chart)(const ShapeData& shape, const SurfacePoint& place) = nullptr;
  // The weights of the axes in a texture that is blended; false where it is not. Null: nowhere.
  bool (*blend)(const ShapeData& shape, const SurfacePoint& place, Blend& out) = nullptr;
  // For a curved surface: the gradient with respect to the tip of what has this gradient along the surface at
  // the place. Null: the same.
  Vec3 (*gradient_at_tip)(const ShapeData& shape, const SurfacePoint& place, const Vec3& along) = nullptr;
  bool smooth = false;  // the surface has no edge
  bool walks = false;   // a slide costs more the farther it goes
};

}  // namespace thimble::control
