#include "control/bodies/contact_search.h"

#include <algorithm>
#include <cmath>

namespace thimble::control {
namespace {

bool collides(const PlacedObject& object) { return object.row->collision != nullptr; }

// Whether the box about an object is wholly outside of a half-space. False: the other one is none.
bool is_clear_of(const PlacedObject& object, const PlacedObject& other, float margin_m) {
  if (!other.half_space) return false;
  const Vec3& normal = other.normal;
  const Vec3 deepest(normal.x() > 0.0F ? object.lo_m.x() : object.hi_m.x(),
                     normal.y() > 0.0F ? object.lo_m.y() : object.hi_m.y(),
                     normal.z() > 0.0F ? object.lo_m.z() : object.hi_m.z());
  return normal.dot(deepest) - other.offset_m > margin_m;
}

}  // namespace

void ContactSearch::begin(std::span<const SolverBody> bodies, float period_s) noexcept {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    moves_m_[i] = bodies[i].asleep ? 0.0F : period_s * bodies[i].velocity_m_s.norm();
  a_ = partner_ = 0;
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
        ++partner_;
        at_ = At::kNext;
        break;
    }
    if (work.left() == 0) return false;
  }
}

// The next pair whose boxes overlap. False: there is none, or the work is spent.
bool ContactSearch::begin_next(const World& world, std::span<const SolverBody> bodies, float period_s,
                               Work& work) noexcept {
  constexpr std::size_t kSkippedPerUnit = 5;
  const std::size_t partners = world.count + bodies.size();
  for (; a_ < bodies.size(); ++a_, partner_ = 0) {
    if (bodies[a_].asleep || !collides(world.objects[bodies[a_].object])) continue;
    if (partner_ == 0) {
      if (work.left() == 0) return false;
      work.charge(1 + static_cast<std::uint32_t>(partners / kSkippedPerUnit));
    }
    for (; partner_ < partners; ++partner_) {
      b_ = kNoBody;
      if (partner_ < world.count) {
        object_b_ = static_cast<std::uint8_t>(partner_);
        if (world.objects[partner_].body != kNoBody) continue;
      } else {
        partner_ = std::max(partner_, world.count + a_ + 1);  // each pair of bodies once
        if (partner_ == partners) break;
        b_ = static_cast<std::uint8_t>(partner_ - world.count);
        if (bodies[b_].asleep) continue;
        object_b_ = bodies[b_].object;
      }
      if (collides(world.objects[object_b_]) && begin_pair(world, bodies, period_s)) return true;
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
    if (!boxes_overlap(first, second, margin_m_ + moves_m_[b_])) return false;
    margin_m_ = kContactMargin_m + period_s * (bodies[a_].velocity_m_s - bodies[b_].velocity_m_s).norm();
  }
  if (!boxes_overlap(first, second, margin_m_) || is_clear_of(first, second, margin_m_)) return false;
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
    if (velocity.dot(point.normal) * period_s + std::max(-point.depth_m, 0.0F) <= kContactMargin_m)
      manifold_.points[kept++] = point;
  }
  manifold_.count = kept;
  if (kept == 0) return;
  const Material& material_a = world.objects[bodies[a_].object].material;
  const Material& material_b = world.objects[object_b_].material;
  Patch pair;
  pair.normal = pair.across[0] = pair.across[1] = pair.centre_m = pair.slip_m = pair.impulse_N_s =
      Vec3::Zero();
  pair.mass.setZero();
  pair.object_a = bodies[a_].object;
  pair.object_b = object_b_;
  pair.a = static_cast<std::uint8_t>(a_);
  pair.b = b_;
  pair.static_friction = std::sqrt(material_a.static_friction * material_b.static_friction);
  pair.dynamic_friction = std::sqrt(material_a.dynamic_friction * material_b.dynamic_friction);
  found.add(pair, manifold_, effort);
}

}  // namespace thimble::control
