#include "control/bodies/contact_search.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "control/bodies/pair_motion.h"

namespace thimble::control {
namespace {

bool collides(const PlacedObject& object) { return object.row->collision != nullptr; }

// Whether the box about an object is wholly outside of a half-space.
bool is_clear_of(const PlacedObject& object, const PlacedObject& half_space, float margin_m) {
  const Vec3& normal = half_space.normal;
  const Vec3 deepest(normal.x() > 0.0F ? object.lo_m.x() : object.hi_m.x(),
                     normal.y() > 0.0F ? object.lo_m.y() : object.hi_m.y(),
                     normal.z() > 0.0F ? object.lo_m.z() : object.hi_m.z());
  return normal.dot(deepest) - half_space.offset_m > margin_m;
}

}  // namespace

void ContactSearch::begin(const World& world, std::span<const SolverBody> bodies, float period_s) noexcept {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    moves_m_[i] = bodies[i].asleep ? 0.0F : period_s * bodies[i].velocity_m_s.norm();
  fixed_ = 0;
  for (std::size_t i = 0; i < world.count; ++i)
    if (world.objects[i].body == kNoBody && collides(world.objects[i])) fixed_ |= std::uint64_t{1} << i;
  a_ = 0;
  looked_ = false;
  at_ = At::kNext;
}

bool ContactSearch::go_on(const World& world, std::span<const SolverBody> bodies, float period_s,
                          ContactPatches& found, Effort& effort) noexcept {
  Work& work = effort.work;
  for (;;) {
    switch (at_) {
      case At::kNext:
        if (!begin_next(world, bodies, period_s, work)) return a_ == bodies.size();
        at_ = At::kIn;
        break;
      case At::kIn:
        work.at(bodies[a_].object);
        if (collision_.step(world.objects[bodies[a_].object], world.objects[object_b_], margin_m_, work,
                            manifold_))
          at_ = At::kEnd;
        break;
      case At::kEnd:
        end_pair(world, bodies, period_s, found, effort);
        at_ = At::kNext;
        break;
    }
    if (work.left() == 0) return false;
  }
}

void ContactSearch::find_near(const World& world, std::span<const SolverBody> bodies) noexcept {
  const PlacedObject& object = world.objects[bodies[a_].object];
  const float margin_m = kContactMargin_m + moves_m_[a_];
  near_fixed_ = 0;
  for (std::uint64_t left = fixed_; left != 0; left &= left - 1) {
    const PlacedObject& other = world.objects[static_cast<std::size_t>(std::countr_zero(left))];
    const bool apart =
        other.half_space ? is_clear_of(object, other, margin_m) : !boxes_overlap(object, other, margin_m);
    if (!apart) near_fixed_ |= left & (~left + 1);
  }
  near_bodies_ = 0;
  for (std::size_t i = a_ + 1; i < bodies.size(); ++i) {
    const PlacedObject& other = world.objects[bodies[i].object];
    if (!bodies[i].asleep && boxes_overlap(object, other, margin_m + moves_m_[i]) && collides(other))
      near_bodies_ |= static_cast<std::uint16_t>(1U << i);
  }
}

// The next pair whose boxes overlap. False: there is none, or the work is spent.
bool ContactSearch::begin_next(const World& world, std::span<const SolverBody> bodies, float period_s,
                               Work& work) noexcept {
  constexpr std::size_t kLooksPerUnit = 5;
  for (; a_ < bodies.size(); ++a_, looked_ = false) {
    if (bodies[a_].asleep || !collides(world.objects[bodies[a_].object])) continue;
    if (!looked_) {
      looked_ = true;
      find_near(world, bodies);
      work.charge(1 + static_cast<std::uint32_t>((world.count + bodies.size() - a_) / kLooksPerUnit));
    }
    while (near_fixed_ != 0 || near_bodies_ != 0) {
      if (near_fixed_ != 0) {
        b_ = kNoBody;
        object_b_ = static_cast<std::uint8_t>(std::countr_zero(near_fixed_));
        near_fixed_ &= near_fixed_ - 1;
      } else {
        b_ = static_cast<std::uint8_t>(std::countr_zero(near_bodies_));
        object_b_ = bodies[b_].object;
        near_bodies_ &= static_cast<std::uint16_t>(near_bodies_ - 1U);
      }
      if (begin_pair(world, bodies, period_s)) return true;
    }
    if (work.left() == 0) {
      ++a_;
      looked_ = false;
      return false;
    }
  }
  return false;
}

bool ContactSearch::begin_pair(const World& world, std::span<const SolverBody> bodies,
                               float period_s) noexcept {
  const PlacedObject& first = world.objects[bodies[a_].object];
  const PlacedObject& second = world.objects[object_b_];
  margin_m_ = kContactMargin_m + moves_m_[a_];
  if (b_ != kNoBody) {
    margin_m_ = kContactMargin_m + period_s * (bodies[a_].velocity_m_s - bodies[b_].velocity_m_s).norm();
    if (!boxes_overlap(first, second, margin_m_)) return false;
  }
  manifold_.count = 0;
  manifold_.left_out = 0;
  collision_.begin(first, second);
  return true;
}

void ContactSearch::end_pair(const World& world, std::span<const SolverBody> bodies, float period_s,
                             ContactPatches& found, Effort& effort) noexcept {
  effort.counters.contact_bound += manifold_.left_out;
  // Without the points that will not close in this tick.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < manifold_.count; ++i) {
    const ContactPoint& point = manifold_.points[i];
    Vec3 velocity = velocity_at(bodies[a_], point.point_m);
    if (b_ != kNoBody) velocity -= velocity_at(bodies[b_], point.point_m);
    if (velocity.dot(point.normal) * period_s + std::max(-point.depth_m, 0.0F) > kContactMargin_m) continue;
    if (kept != i) manifold_.points[kept] = point;
    ++kept;
  }
  manifold_.count = kept;
  if (kept == 0) return;
  const Material& material_a = world.objects[bodies[a_].object].material;
  const Material& material_b = world.objects[object_b_].material;
  PatchPair pair;
  pair.object_a = bodies[a_].object;
  pair.object_b = object_b_;
  pair.a = static_cast<std::uint8_t>(a_);
  pair.b = b_;
  pair.static_friction = std::sqrt(material_a.static_friction * material_b.static_friction);
  pair.dynamic_friction = std::sqrt(material_a.dynamic_friction * material_b.dynamic_friction);
  found.add(pair, manifold_, effort);
}

}  // namespace thimble::control
