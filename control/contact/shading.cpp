#include "control/contact/shading.h"

#include <algorithm>

#include "control/solids/near_triangles.h"

namespace thimble::control {
namespace {

// The error of the god object against the smooth surface falls in each round by the ratio of depth to radius of curvature.
constexpr int kRounds = 3;

// The interpolated normal at the god object, when exactly one solid holds it, if by several facets, and that one is
// shaded.
bool shaded_normal(const World& world, const Nearby& nearby, const GodObject& god, Vec3& normal) {
  if (god.count == 0) return false;
  const std::uint8_t index = god.contacts[0].object;
  const PlacedObject& object = world.objects[index];
  if (!object.shaded || !on_one_object(god, index)) return false;
  const Feature& feature = god.contacts[0].feature;
  const Vec3 at = object.to_local(god.position_m + to_place(world, god, 0));
  KeptFace own;
  KeptFace* face = &own;
  if (TriangleCache* const kept = nearby.point_triangles())
    face = &kept->face(object.shape, feature.index);
  else
    keep_face(object.shape, feature.index, own);
  if (!shaded_normal_on(*face, object.shape.mesh, feature.side, at, normal)) return false;
  normal = object.turn(normal);
  return true;
}

// The rounds of shade(), as far as they stay on the face where they begin, and nothing else is near. Returns how many. `normal`: at the
// place that they come to.
int shade_on_face(const World& world, const Nearby& nearby, GodObject& god, const Vec3& tip, Vec3& normal,
                  Work& work) {
  TriangleCache* const kept = nearby.point_triangles();
  const Feature& feature = god.contacts[0].feature;
  if (kept == nullptr || nearby.several() || world.any_seams || god.count != 1 || feature.kind != 0) return 0;
  const PlacedObject& object = world.objects[god.contacts[0].object];
  KeptFace& face = kept->face(object.shape, feature.index);
  const auto find_normal = [&] {
    const bool found =
        shaded_normal_on(face, object.shape.mesh, feature.side, object.to_local(god.position_m), normal);
    normal = object.turn(normal);
    return found;
  };
  int rounds = 0;
  bool found = find_normal();
  for (; found && rounds < kRounds; found = find_normal()) {
    const Vec3 on_plane = object.to_local(tip - normal * (tip - god.position_m).dot(normal));
    if (!face.slides || !is_over(face, on_plane) || !work.spend(kMoveWork + kFaceWork)) break;
    god.position_m = object.to_world(project(face, on_plane));
    ++rounds;
  }
  return found ? rounds : 0;
}

}  // namespace

bool shade(const World& world, const Nearby& nearby, GodObject& rest, const Vec3& tip, Constraints& held,
           Effort& effort) noexcept {
  if (!world.objects[rest.contacts[0].object].shaded) return false;
  Vec3 normal;
  const Vec3 facets_m = rest.position_m;
  const int on_face = shade_on_face(world, nearby, rest, tip, normal, effort.work);
  if (on_face < kRounds) {
    GodObject smooth = rest;
    for (int round = on_face; round <= kRounds; ++round) {
      if (!shaded_normal(world, nearby, smooth, normal)) {
        rest.position_m = facets_m;
        return false;
      }
      if (round < kRounds)
        move(world, nearby, smooth, tip - normal * (tip - smooth.position_m).dot(normal), true, effort);
    }
    rest = smooth;
  }
  const std::uint8_t object = rest.contacts[0].object;
  held.count = 1;
  held.list[0] = {object,
                  normal,
                  std::max((rest.position_m - tip).dot(normal), 0.0F),
                  world.objects[object].material,
                  0,
                  to_place(world, rest, 0)};
  return true;
}

Vec3 ShadedForce::follow(const PlacedObject& frame, const Vec3& tip_m, const Vec3& spring_N,
                         float stiffest_N_m, float mean_N_m, bool shaded) noexcept {
  const bool moves = frame.body != kNoBody;
  const Vec3 at = moves ? frame.to_local(tip_m) : tip_m;
  const bool goes_on = open_ && body_ == frame.body;
  bound_ = goes_on && (shaded || binds());
  const float stiffest_both_N_m = goes_on ? std::max(stiffest_N_m, stiffest_N_m_) : stiffest_N_m;
  const float motion_m = (at - tip_m_).norm();
  before_N_ = force_N_;
  most_N_ = kFastest * stiffest_both_N_m * motion_m;
  if (!bound_) {
    has_effect_ = false;
    effect_N_ = Vec3::Zero();
  }
  open_ = true;
  shaded_ = shaded;
  took_part_ = shaded || (goes_on && took_part_);
  body_ = frame.body;
  tip_m_ = at;
  const Vec3 force_N = change_to(moves ? frame.turn_back(spring_N) : spring_N, most_N_);
  stiffest_N_m_ = behind_ ? stiffest_both_N_m : stiffest_N_m;
  if (bound_) {
    const float push_N = mean_N_m_ * motion_m;
    const float part = push_N / std::max(force_N_.norm(), push_N + 1.0e-9F);
    mean_N_m_ = std::clamp(mean_N_m, (1.0F - part) * mean_N_m_, (1.0F + part) * mean_N_m_);
  } else {
    mean_N_m_ = mean_N_m;
  }
  return moves ? frame.turn(force_N) : force_N;
}

Vec3 ShadedForce::slip(const PlacedObject& frame, const Vec3& by_N, float breaks_N) noexcept {
  const bool moves = frame.body != kNoBody;
  const Vec3 local_by_N = moves ? frame.turn_back(by_N) : by_N;
  if (!bound_) {
    force_N_ += local_by_N;
    return by_N;
  }
  const Vec3 stuck_N = force_N_;
  const float stuck = stuck_N.norm();
  Vec3 slipped_N = stuck_N + local_by_N;
  const float slipped = slipped_N.norm();
  const bool adds = slipped > stuck;
  if (adds) slipped_N *= stuck / slipped;
  const Vec3 change_N = change_to(slipped_N, most_N_ + breaks_N) - stuck_N;
  behind_ = behind_ || adds;
  return moves ? frame.turn(change_N) : change_N;
}

Vec3 ShadedForce::effect(const PlacedObject& frame, const Vec3& by_N) noexcept {
  const bool moves = frame.body != kNoBody;
  const Vec3 wanted_N = moves ? frame.turn_back(by_N) : by_N;
  const Vec3 change_N = wanted_N - effect_N_;
  const float most_N = kEffects / kFastest * most_N_;
  const bool late = bound_ && change_N.squaredNorm() > most_N * most_N;
  if (late)
    effect_N_ += most_N / change_N.norm() * change_N;
  else
    effect_N_ = wanted_N;
  behind_ = behind_ || late;
  has_effect_ = effect_N_ != Vec3::Zero();
  return late ? Vec3((moves ? frame.turn(effect_N_) : effect_N_) - by_N) : Vec3(Vec3::Zero());
}

Vec3 ShadedForce::change_to(const Vec3& force_N, float most_N) noexcept {
  const Vec3 change = force_N - before_N_;
  behind_ = bound_ && change.squaredNorm() > most_N * most_N;
  force_N_ = behind_ ? Vec3(before_N_ + most_N / change.norm() * change) : force_N;
  return force_N_;
}

}  // namespace thimble::control
