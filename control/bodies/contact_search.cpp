#include "control/bodies/contact_search.h"

#include <algorithm>
#include <cmath>

namespace thimble::control {
namespace {

bool collides(const PlacedObject& object) { return object.row->collision != nullptr; }

}  // namespace

void ContactSearch::begin() noexcept {
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
  constexpr std::size_t kSkippedPerUnit = 16;
  for (; a_ < bodies.size(); ++a_, partner_ = 0) {
    if (bodies[a_].asleep || !collides(world.objects[bodies[a_].object])) continue;
    if (partner_ == 0) work.charge(1 + static_cast<std::uint32_t>(world.count / kSkippedPerUnit));
    for (; partner_ < world.count + bodies.size(); ++partner_) {
      b_ = kNoBody;
      if (partner_ < world.count) {
        object_b_ = static_cast<std::uint8_t>(partner_);
        if (world.objects[partner_].body != kNoBody) continue;
      } else {
        b_ = static_cast<std::uint8_t>(partner_ - world.count);
        if (b_ <= a_ || bodies[b_].asleep) continue;
        object_b_ = bodies[b_].object;
      }
      if (!collides(world.objects[object_b_])) continue;
      if (begin_pair(world, bodies, period_s)) {
        return true;
      }
      work.charge(1);
      if (work.left() == 0) {
        ++partner_;
        return false;
      }
    }
  }
  return false;
}

bool ContactSearch::begin_pair(const World& world, std::span<const SolverBody> bodies,
                               float period_s) noexcept {
  const PlacedObject& first = world.objects[bodies[a_].object];
  const PlacedObject& second = world.objects[object_b_];
  const Vec3& velocity = bodies[a_].velocity_m_s;
  const Vec3 relative = b_ == kNoBody ? velocity : Vec3(velocity - bodies[b_].velocity_m_s);
  margin_m_ = kContactMargin_m + period_s * relative.norm();
  if (!boxes_overlap(first, second, margin_m_)) return false;
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
