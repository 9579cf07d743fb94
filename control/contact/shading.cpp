#include "control/contact/shading.h"

#include <algorithm>

namespace thimble::control {
namespace {

// The error of the god object against the smooth surface falls in each round by the ratio of depth to radius of curvature.
constexpr int kRounds = 3;

// The interpolated normal at the god object, when exactly one solid holds it, if by several facets, and that one is
// shaded.
bool shaded_normal(const World& world, const GodObject& god, Vec3& normal) {
  if (god.count == 0) return false;
  const PlacedObject& object = world.objects[god.contacts[0].object];
  for (std::size_t i = 1; i < god.count; ++i)
    if (god.contacts[i].object != god.contacts[0].object) return false;
  if (!object.shaded) return false;
  const Vec3 at = object.to_local(god.position_m + to_place(world, god, 0));
  if (!object.ops->shaded_normal(object.shape, god.contacts[0].feature, at, normal)) return false;
  normal = object.turn(normal);
  return true;
}

}  // namespace

bool shade(const World& world, const Nearby& nearby, GodObject& rest, const Vec3& tip, Constraints& held,
           Effort& effort) noexcept {
  if (!world.objects[rest.contacts[0].object].shaded) return false;
  Vec3 normal;
  GodObject smooth = rest;
  for (int round = 0; round < kRounds; ++round) {
    if (!shaded_normal(world, smooth, normal)) return false;
    const Vec3 on_plane = tip - normal * (tip - smooth.position_m).dot(normal);
    move(world, nearby, smooth, on_plane, true, effort);
  }
  if (!shaded_normal(world, smooth, normal)) return false;
  rest = smooth;
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
