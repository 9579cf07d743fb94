#include "control/bodies/contact_solver.h"

#include <algorithm>
#include <cmath>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

constexpr int kSolverIterations = 10;
constexpr int kCorrectionIterations = 4;
// A contact that closes more slowly than this does not bounce. Gravity alone gives 10 mm/s in one tick at 1
// kHz.
constexpr float kBounce_m_s = 0.02F;
// Allowed penetration at rest: resting bodies stay in contact, and a hand does not feel it.
constexpr float kRest_m = 2.0e-5F;
constexpr float kCorrectionShare = 0.2F;  // of the excess penetration, corrected in one tick
constexpr float kMaxCorrection_m = 2.0e-4F;
// Contact points are collected at this gap and below; the gap grows by the distance that the bodies approach
// in one tick.
constexpr float kMargin_m = 1.0e-4F;
// A contact point of the previous tick within this distance is the same one.
constexpr float kSamePlace_m = 2.0e-3F;

bool collides(const PlacedObject& object) { return object.row->collision != nullptr; }

bool boxes_overlap(const PlacedObject& a, const PlacedObject& b, float margin) {
  return ((a.lo_m.array() - margin) <= b.hi_m.array()).all() &&
         ((b.lo_m.array() - margin) <= a.hi_m.array()).all();
}

}  // namespace

void ContactSolver::reset() noexcept {
  count_ = 0;
  stored_count_ = 0;
}

ContactSolver::Row ContactSolver::row(std::span<const SolverBody> bodies, const Contact& contact,
                                      const Vec3& direction) noexcept {
  Row r;
  r.direction = direction;
  const SolverBody& a = bodies[contact.a];
  r.arm_a = (contact.point_m - a.centre_m).cross(direction);
  r.linear_a = a.inverse_mass * direction;
  r.angular_a = a.inverse_inertia * r.arm_a;
  float answer = direction.dot(r.linear_a) + r.arm_a.dot(r.angular_a);
  r.arm_b = r.linear_b = r.angular_b = Vec3::Zero();
  if (contact.b != kNoBody) {
    const SolverBody& b = bodies[contact.b];
    r.arm_b = (contact.point_m - b.centre_m).cross(direction);
    r.linear_b = b.inverse_mass * direction;
    r.angular_b = b.inverse_inertia * r.arm_b;
    answer += direction.dot(r.linear_b) + r.arm_b.dot(r.angular_b);
  }
  // A thousandth of the response of the heaviest body. Below that, neither body can move in this direction.
  constexpr float kNothing = 1.0e-3F / kMaxMass_kg;
  r.mass = answer > kNothing ? 1.0F / answer : 0.0F;
  return r;
}

float ContactSolver::speed(std::span<const SolverBody> bodies, const Contact& contact,
                           const Row& r) noexcept {
  const SolverBody& a = bodies[contact.a];
  const float of_a = r.direction.dot(a.velocity_m_s) + r.arm_a.dot(a.spin_rad_s);
  if (contact.b == kNoBody) return of_a;
  const SolverBody& b = bodies[contact.b];
  return of_a - r.direction.dot(b.velocity_m_s) - r.arm_b.dot(b.spin_rad_s);
}

void ContactSolver::apply_impulse(std::span<SolverBody> bodies, const Contact& contact, const Row& r,
                                  float impulse) noexcept {
  SolverBody& a = bodies[contact.a];
  a.velocity_m_s += impulse * r.linear_a;
  a.spin_rad_s += impulse * r.angular_a;
  if (contact.b == kNoBody) return;
  SolverBody& b = bodies[contact.b];
  b.velocity_m_s -= impulse * r.linear_b;
  b.spin_rad_s -= impulse * r.angular_b;
}

// Both tangential directions together, so that the limit is a cone and not a pyramid.
void ContactSolver::solve_friction(std::span<SolverBody> bodies, Contact& contact) noexcept {
  const float friction = contact.sliding ? contact.dynamic_friction : contact.static_friction;
  const float most = friction * contact.normal.impulse;
  std::array<float, 2> wanted{};
  for (std::size_t i = 0; i < 2; ++i) {
    const Row& r = contact.tangent[i];
    wanted[i] = r.impulse - r.mass * speed(bodies, contact, r);
  }
  const float length = planar_length(wanted[0], wanted[1]);
  const float scale = length > most ? most / length : 1.0F;
  for (std::size_t i = 0; i < 2; ++i) {
    Row& r = contact.tangent[i];
    const float impulse = scale * wanted[i];
    apply_impulse(bodies, contact, r, impulse - r.impulse);
    r.impulse = impulse;
  }
}

// Warm start: reuse the impulses of the previous tick's contact within kSamePlace_m.
void ContactSolver::warm_start(std::span<SolverBody> bodies, Contact& contact) const noexcept {
  const StoredImpulse* best = nullptr;
  float nearest = kSamePlace_m * kSamePlace_m;
  for (std::size_t i = 0; i < stored_count_; ++i) {
    const StoredImpulse& stored = stored_[i];
    if (stored.object_a != contact.object_a || stored.object_b != contact.object_b) continue;
    const float distance = (stored.point_m - contact.point_m).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      best = &stored;
    }
  }
  if (best == nullptr) return;
  contact.sliding = best->sliding;
  if (contact.normal.mass > 0.0F) contact.normal.impulse = best->normal_N_s;
  apply_impulse(bodies, contact, contact.normal, contact.normal.impulse);
  for (Row& r : contact.tangent) {
    r.impulse = r.mass > 0.0F ? r.direction.dot(best->tangent_N_s) : 0.0F;
    apply_impulse(bodies, contact, r, r.impulse);
  }
}

void ContactSolver::prepare(const World& world, std::span<SolverBody> bodies, const Contact& found,
                            const Vec3& normal, std::size_t in_manifold, float period_s) noexcept {
  Contact contact = found;
  contact.normal = row(bodies, contact, normal);
  const Material& of_a = world.objects[contact.object_a].material;
  const Material& of_b = world.objects[contact.object_b].material;
  contact.static_friction = std::sqrt(of_a.static_friction * of_b.static_friction);
  contact.dynamic_friction = std::sqrt(of_a.dynamic_friction * of_b.dynamic_friction);
  const float approach = speed(bodies, contact, contact.normal);
  if (contact.normal.mass > 0.0F) {
    const float gap = std::max(-contact.depth_m, 0.0F);
    if (approach * period_s + gap > kMargin_m) return;  // it will not close in this tick
    contact.target_m_s = -gap / period_s;
    float restitution = bodies[contact.a].restitution;
    if (contact.b != kNoBody) restitution = std::max(restitution, bodies[contact.b].restitution);
    if (approach < -kBounce_m_s && approach < contact.target_m_s && restitution > 0.0F) {
      contact.target_m_s = -restitution * approach;
      contact.bounces = true;
    }
  } else {
    // Both bodies are fixed along the normal. Split the constraint force evenly over the manifold; it only
    // sets the friction limit.
    float held = -bodies[contact.a].constrained_N_s.dot(normal);
    if (contact.b != kNoBody) held = std::min(held, bodies[contact.b].constrained_N_s.dot(normal));
    contact.normal.impulse = std::max(held, 0.0F) / static_cast<float>(in_manifold);
    if (contact.depth_m < -kRest_m) contact.normal.impulse = 0.0F;
  }
  const Vec3 across = normal.unitOrthogonal();
  contact.tangent[0] = row(bodies, contact, across);
  contact.tangent[1] = row(bodies, contact, normal.cross(across));
  contacts_[count_++] = contact;
}

void ContactSolver::collect_pair(const World& world, std::span<SolverBody> bodies, std::size_t a,
                                 std::size_t object_b, std::uint8_t b, float period_s,
                                 RenderCounters& counters) noexcept {
  const std::uint8_t object_a = bodies[a].object;
  const PlacedObject& first = world.objects[object_a];
  const PlacedObject& second = world.objects[object_b];
  const Vec3 relative =
      b == kNoBody ? bodies[a].velocity_m_s : Vec3(bodies[a].velocity_m_s - bodies[b].velocity_m_s);
  const float margin = kMargin_m + period_s * relative.norm();
  if (!boxes_overlap(first, second, margin)) return;
  Manifold manifold;
  collide(first, second, margin, manifold);
  for (std::size_t i = 0; i < manifold.count; ++i) {
    if (count_ == contacts_.size()) {
      ++counters.contact_bound;
      return;
    }
    const ContactPoint& point = manifold.points[i];
    Contact contact;
    contact.object_a = object_a;
    contact.object_b = static_cast<std::uint8_t>(object_b);
    contact.a = static_cast<std::uint8_t>(a);
    contact.b = b;
    contact.point_m = point.point_m;
    contact.depth_m = point.depth_m;
    prepare(world, bodies, contact, point.normal, manifold.count, period_s);
  }
}

void ContactSolver::collect_contacts(const World& world, std::span<SolverBody> bodies, float period_s,
                                     RenderCounters& counters) noexcept {
  count_ = 0;
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    if (!collides(world.objects[bodies[a].object])) continue;
    for (std::size_t object = 0; object < world.count; ++object) {
      if (world.objects[object].body == kNoBody && collides(world.objects[object]))
        collect_pair(world, bodies, a, object, kNoBody, period_s, counters);
    }
    for (std::size_t b = a + 1; b < bodies.size(); ++b) {
      if (collides(world.objects[bodies[b].object]))
        collect_pair(world, bodies, a, bodies[b].object, static_cast<std::uint8_t>(b), period_s, counters);
    }
  }
}

// Penetration beyond kRest_m is removed by position corrections.
void ContactSolver::correct_positions(std::span<SolverBody> bodies) noexcept {
  for (int iteration = 0; iteration < kCorrectionIterations; ++iteration) {
    for (std::size_t i = 0; i < count_; ++i) {
      const Contact& c = contacts_[i];
      if (c.depth_m <= kRest_m || c.normal.mass <= 0.0F) continue;
      SolverBody& a = bodies[c.a];
      const Row& r = c.normal;
      float moved = r.direction.dot(a.correction_m) + r.arm_a.dot(a.correction_rad);
      if (c.b != kNoBody) {
        const SolverBody& b = bodies[c.b];
        moved -= r.direction.dot(b.correction_m) + r.arm_b.dot(b.correction_rad);
      }
      const float wanted = std::min(kCorrectionShare * (c.depth_m - kRest_m), kMaxCorrection_m) - moved;
      if (wanted <= 0.0F) continue;
      const float amount = r.mass * wanted;
      a.correction_m += amount * r.linear_a;
      a.correction_rad += amount * r.angular_a;
      if (c.b != kNoBody) {
        SolverBody& b = bodies[c.b];
        b.correction_m -= amount * r.linear_b;
        b.correction_rad -= amount * r.angular_b;
      }
    }
  }
}

void ContactSolver::store_impulses() noexcept {
  stored_count_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Contact& c = contacts_[i];
    StoredImpulse& stored = stored_[stored_count_++];
    stored = {c.object_a, c.object_b, c.sliding, c.point_m, c.normal.impulse, Vec3::Zero()};
    if (c.bounces)
      stored.normal_N_s = 0.0F;  // an impact ends in its tick
    else
      stored.tangent_N_s =
          c.tangent[0].impulse * c.tangent[0].direction + c.tangent[1].impulse * c.tangent[1].direction;
  }
}

void ContactSolver::solve(const World& world, std::span<SolverBody> bodies, float period_s,
                          RenderCounters& counters) noexcept {
  collect_contacts(world, bodies, period_s, counters);
  for (std::size_t i = 0; i < count_; ++i) warm_start(bodies, contacts_[i]);
  for (int iteration = 0; iteration < kSolverIterations; ++iteration) {
    for (std::size_t i = 0; i < count_; ++i) {
      Contact& c = contacts_[i];
      solve_friction(bodies, c);
      if (c.normal.mass <= 0.0F) continue;
      const float wanted = c.normal.impulse + c.normal.mass * (c.target_m_s - speed(bodies, c, c.normal));
      const float impulse = std::max(wanted, 0.0F);
      apply_impulse(bodies, c, c.normal, impulse - c.normal.impulse);
      c.normal.impulse = impulse;
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    // A contact slides from the tick in which static friction reaches its limit, until dynamic friction stops
    // it.
    Contact& c = contacts_[i];
    const float most = (c.sliding ? c.dynamic_friction : c.static_friction) * c.normal.impulse;
    constexpr float kAll = 1.0F - 1.0e-4F;
    c.sliding =
        c.normal.impulse > 0.0F && planar_length(c.tangent[0].impulse, c.tangent[1].impulse) >= kAll * most;
  }
  correct_positions(bodies);
  store_impulses();
}

}  // namespace thimble::control
