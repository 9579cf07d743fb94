#include "control/bodies/contact_solver.h"

#include <algorithm>
#include <cmath>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

constexpr int kSolverRounds = 10;
constexpr int kShiftRounds = 4;
// An approach slower than this ends without a bounce; gravity alone gives 10 mm/s in a tick at 1 kHz.
constexpr float kBounce_m_s = 0.02F;
// How deep bodies rest in each other: enough to stay in touch, less than a hand feels.
constexpr float kRest_m = 2.0e-5F;
constexpr float kShiftShare = 0.2F;  // of the depth beyond it that a tick takes away
constexpr float kMaxShift_m = 2.0e-4F;
constexpr float kMargin_m =
    1.0e-4F;  // contacts are known this long before they close, and longer by the speed
constexpr float kSamePlace_m = 2.0e-3F;  // a contact of the last tick nearer than this is the same

bool collides(const PlacedObject& object) { return object.row->collision != nullptr; }

bool boxes_meet(const PlacedObject& a, const PlacedObject& b, float margin) {
  return ((a.lo_m.array() - margin) <= b.hi_m.array()).all() &&
         ((b.lo_m.array() - margin) <= a.hi_m.array()).all();
}

}  // namespace

void ContactSolver::reset() noexcept {
  count_ = 0;
  kept_count_ = 0;
}

ContactSolver::Row ContactSolver::row(std::span<const Mover> movers, const Contact& contact,
                                      const Vec3& way) noexcept {
  Row r;
  r.way = way;
  const Mover& a = movers[contact.a];
  r.arm_a = (contact.point_m - a.centre_m).cross(way);
  r.linear_a = a.inverse_mass * way;
  r.angular_a = a.inverse_inertia * r.arm_a;
  float answer = way.dot(r.linear_a) + r.arm_a.dot(r.angular_a);
  r.arm_b = r.linear_b = r.angular_b = Vec3::Zero();
  if (contact.b != kNoBody) {
    const Mover& b = movers[contact.b];
    r.arm_b = (contact.point_m - b.centre_m).cross(way);
    r.linear_b = b.inverse_mass * way;
    r.angular_b = b.inverse_inertia * r.arm_b;
    answer += way.dot(r.linear_b) + r.arm_b.dot(r.angular_b);
  }
  // A thousandth of what the heaviest body answers: less is a direction in which nothing moves.
  constexpr float kNothing = 1.0e-3F / kMaxMass_kg;
  r.mass = answer > kNothing ? 1.0F / answer : 0.0F;
  return r;
}

float ContactSolver::speed(std::span<const Mover> movers, const Contact& contact, const Row& r) noexcept {
  const Mover& a = movers[contact.a];
  const float of_a = r.way.dot(a.velocity_m_s) + r.arm_a.dot(a.spin_rad_s);
  if (contact.b == kNoBody) return of_a;
  const Mover& b = movers[contact.b];
  return of_a - r.way.dot(b.velocity_m_s) - r.arm_b.dot(b.spin_rad_s);
}

void ContactSolver::push(std::span<Mover> movers, const Contact& contact, const Row& r,
                         float impulse) noexcept {
  Mover& a = movers[contact.a];
  a.velocity_m_s += impulse * r.linear_a;
  a.spin_rad_s += impulse * r.angular_a;
  if (contact.b == kNoBody) return;
  Mover& b = movers[contact.b];
  b.velocity_m_s -= impulse * r.linear_b;
  b.spin_rad_s -= impulse * r.angular_b;
}

// Both directions of friction together: the cone, not a pyramid.
void ContactSolver::rub(std::span<Mover> movers, Contact& contact) noexcept {
  const float friction = contact.sliding ? contact.dynamic_friction : contact.static_friction;
  const float most = friction * contact.normal.impulse;
  std::array<float, 2> wanted{};
  for (std::size_t i = 0; i < 2; ++i) {
    const Row& r = contact.tangent[i];
    wanted[i] = r.impulse - r.mass * speed(movers, contact, r);
  }
  const float length = planar_length(wanted[0], wanted[1]);
  const float scale = length > most ? most / length : 1.0F;
  for (std::size_t i = 0; i < 2; ++i) {
    Row& r = contact.tangent[i];
    const float impulse = scale * wanted[i];
    push(movers, contact, r, impulse - r.impulse);
    r.impulse = impulse;
  }
}

// The contact of the last tick at the same place, if any, lends its impulses.
void ContactSolver::warm(std::span<Mover> movers, Contact& contact) const noexcept {
  const Kept* best = nullptr;
  float nearest = kSamePlace_m * kSamePlace_m;
  for (std::size_t i = 0; i < kept_count_; ++i) {
    const Kept& kept = kept_[i];
    if (kept.object_a != contact.object_a || kept.object_b != contact.object_b) continue;
    const float distance = (kept.point_m - contact.point_m).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      best = &kept;
    }
  }
  if (best == nullptr) return;
  contact.sliding = best->sliding;
  if (contact.normal.mass > 0.0F) contact.normal.impulse = best->normal_N_s;
  push(movers, contact, contact.normal, contact.normal.impulse);
  for (Row& r : contact.tangent) {
    r.impulse = r.mass > 0.0F ? r.way.dot(best->tangent_N_s) : 0.0F;
    push(movers, contact, r, r.impulse);
  }
}

void ContactSolver::add(const World& world, std::span<Mover> movers, const Contact& seen, const Vec3& normal,
                        std::size_t in_manifold, float period_s) noexcept {
  Contact contact = seen;
  contact.normal = row(movers, contact, normal);
  const Material& of_a = world.objects[contact.object_a].material;
  const Material& of_b = world.objects[contact.object_b].material;
  contact.static_friction = std::sqrt(of_a.static_friction * of_b.static_friction);
  contact.dynamic_friction = std::sqrt(of_a.dynamic_friction * of_b.dynamic_friction);
  const float approach = speed(movers, contact, contact.normal);
  if (contact.normal.mass > 0.0F) {
    const float gap = std::max(-contact.depth_m, 0.0F);
    if (approach * period_s + gap > kMargin_m) return;  // it will not close, whatever the others do to it
    contact.target_m_s = -gap / period_s;
    float restitution = movers[contact.a].restitution;
    if (contact.b != kNoBody) restitution = std::max(restitution, movers[contact.b].restitution);
    if (approach < -kBounce_m_s && approach < contact.target_m_s && restitution > 0.0F) {
      contact.target_m_s = -restitution * approach;
      contact.bounces = true;
    }
  } else {
    // Neither can give way: what its own forces press it on with is shared by the points, and rubs.
    float held = -movers[contact.a].held_N_s.dot(normal);
    if (contact.b != kNoBody) held = std::min(held, movers[contact.b].held_N_s.dot(normal));
    contact.normal.impulse = std::max(held, 0.0F) / static_cast<float>(in_manifold);
    if (contact.depth_m < -kRest_m) contact.normal.impulse = 0.0F;
  }
  const Vec3 across = normal.unitOrthogonal();
  contact.tangent[0] = row(movers, contact, across);
  contact.tangent[1] = row(movers, contact, normal.cross(across));
  contacts_[count_++] = contact;
}

void ContactSolver::meet(const World& world, std::span<Mover> movers, std::size_t a, std::size_t object_b,
                         std::uint8_t b, float period_s, RenderCounters& counters) noexcept {
  const std::uint8_t object_a = movers[a].object;
  const PlacedObject& first = world.objects[object_a];
  const PlacedObject& second = world.objects[object_b];
  const Vec3 relative =
      b == kNoBody ? movers[a].velocity_m_s : Vec3(movers[a].velocity_m_s - movers[b].velocity_m_s);
  const float margin = kMargin_m + period_s * relative.norm();
  if (!boxes_meet(first, second, margin)) return;
  Manifold manifold;
  collide(first, second, margin, manifold);
  for (std::size_t i = 0; i < manifold.count; ++i) {
    if (count_ == contacts_.size()) {
      ++counters.contact_bound;
      return;
    }
    const Meeting& meeting = manifold.points[i];
    Contact contact;
    contact.object_a = object_a;
    contact.object_b = static_cast<std::uint8_t>(object_b);
    contact.a = static_cast<std::uint8_t>(a);
    contact.b = b;
    contact.point_m = meeting.point_m;
    contact.depth_m = meeting.depth_m;
    add(world, movers, contact, meeting.normal, manifold.count, period_s);
  }
}

void ContactSolver::find(const World& world, std::span<Mover> movers, float period_s,
                         RenderCounters& counters) noexcept {
  count_ = 0;
  for (std::size_t a = 0; a < movers.size(); ++a) {
    if (!collides(world.objects[movers[a].object])) continue;
    for (std::size_t object = 0; object < world.count; ++object) {
      if (world.objects[object].body == kNoBody && collides(world.objects[object]))
        meet(world, movers, a, object, kNoBody, period_s, counters);
    }
    for (std::size_t b = a + 1; b < movers.size(); ++b) {
      if (collides(world.objects[movers[b].object]))
        meet(world, movers, a, movers[b].object, static_cast<std::uint8_t>(b), period_s, counters);
    }
  }
}

// The rest of the depth, as places.
void ContactSolver::move_apart(std::span<Mover> movers) noexcept {
  for (int round = 0; round < kShiftRounds; ++round) {
    for (std::size_t i = 0; i < count_; ++i) {
      const Contact& c = contacts_[i];
      if (c.depth_m <= kRest_m || c.normal.mass <= 0.0F) continue;
      Mover& a = movers[c.a];
      const Row& r = c.normal;
      float moved = r.way.dot(a.shift_m) + r.arm_a.dot(a.shift_rad);
      if (c.b != kNoBody) {
        const Mover& b = movers[c.b];
        moved -= r.way.dot(b.shift_m) + r.arm_b.dot(b.shift_rad);
      }
      const float wanted = std::min(kShiftShare * (c.depth_m - kRest_m), kMaxShift_m) - moved;
      if (wanted <= 0.0F) continue;
      const float amount = r.mass * wanted;
      a.shift_m += amount * r.linear_a;
      a.shift_rad += amount * r.angular_a;
      if (c.b != kNoBody) {
        Mover& b = movers[c.b];
        b.shift_m -= amount * r.linear_b;
        b.shift_rad -= amount * r.angular_b;
      }
    }
  }
}

void ContactSolver::keep() noexcept {
  kept_count_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Contact& c = contacts_[i];
    Kept& kept = kept_[kept_count_++];
    kept = {c.object_a, c.object_b, c.sliding, c.point_m, c.normal.impulse, Vec3::Zero()};
    if (c.bounces)
      kept.normal_N_s = 0.0F;  // an impact is over in its tick
    else
      kept.tangent_N_s = c.tangent[0].impulse * c.tangent[0].way + c.tangent[1].impulse * c.tangent[1].way;
  }
}

void ContactSolver::solve(const World& world, std::span<Mover> movers, float period_s,
                          RenderCounters& counters) noexcept {
  find(world, movers, period_s, counters);
  for (std::size_t i = 0; i < count_; ++i) warm(movers, contacts_[i]);
  for (int round = 0; round < kSolverRounds; ++round) {
    for (std::size_t i = 0; i < count_; ++i) {
      Contact& c = contacts_[i];
      rub(movers, c);
      if (c.normal.mass <= 0.0F) continue;
      const float wanted = c.normal.impulse + c.normal.mass * (c.target_m_s - speed(movers, c, c.normal));
      const float impulse = std::max(wanted, 0.0F);
      push(movers, c, c.normal, impulse - c.normal.impulse);
      c.normal.impulse = impulse;
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    // It slides from where static friction has given way, until dynamic friction has brought it to rest.
    Contact& c = contacts_[i];
    const float most = (c.sliding ? c.dynamic_friction : c.static_friction) * c.normal.impulse;
    constexpr float kAll = 1.0F - 1.0e-4F;
    c.sliding =
        c.normal.impulse > 0.0F && planar_length(c.tangent[0].impulse, c.tangent[1].impulse) >= kAll * most;
  }
  move_apart(movers);
  keep();
}

}  // namespace thimble::control
