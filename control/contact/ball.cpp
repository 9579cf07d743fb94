#include "control/contact/ball.h"

#include <algorithm>
#include <array>
#include <limits>

#include "control/contact/separations.h"
#include "control/scene/limits.h"

namespace thimble::control {
namespace {

constexpr float kRadius_m = kPointRadius_m;
constexpr float kUnder_m = 4.0F * kRadius_m;  // the point under the ball is no farther from the centre
constexpr int kMaxSteps = 16;

// The ball's centre over a point that lies on its contacts' surfaces.
Vec3 centre_over(const World& world, const GodObject& god) {
  std::array<Vec3, kMaxContacts> normals;
  const std::size_t count = contact_normals(world, god, normals);
  std::array<HalfSpace, kMaxContacts> planes;
  for (std::size_t i = 0; i < count; ++i) planes[i] = {normals[i], kRadius_m};
  const NearestInside over = nearest_inside(std::span(planes).first(count), Vec3::Zero());
  return over.found ? Vec3(god.position_m + over.point_m) : Vec3(god.position_m + kRadius_m * normals[0]);
}

void become_ball(const World& world, GodObject& god) {
  if (god.is_ball) return;
  god.centre_m = god.count == 0 ? god.position_m : centre_over(world, god);
  contact_normals(world, god, god.normals);
  god.is_ball = true;
  god.has_beside = false;
}

bool holds_from_afar(const NearestInside& there, const Separations& near) {
  for (std::size_t i = 0; i < there.count; ++i)
    if (!near.touches(there.holding[i], kRadius_m)) return true;
  return false;
}

// The planes that hold the ball where it is.
struct Holding {
  std::array<HalfSpace, kMaxHolding> planes;
  std::size_t count = 0;

  explicit Holding(const GodObject& god) : count(god.count) {
    for (std::size_t i = 0; i < count; ++i) planes[i] = {god.normals[i], 0.0F};
  }
  // touched: of the planes that hold it, only those of solids that it touches.
  void hold(const NearestInside& there, const Separations& near, bool touched) {
    count = 0;
    for (std::size_t i = 0; i < there.count; ++i) {
      const std::size_t at = there.holding[i];
      if (!touched || near.touches(at, kRadius_m)) planes[count++] = {near.planes[at].normal, 0.0F};
    }
  }
  [[nodiscard]] BallQuery query(const Vec3& centre, const Vec3& target) const {
    BallQuery ball{centre, aim(centre, target), target, kRadius_m, 0.5F * (target - centre).norm(), {},
                   count};
    for (std::size_t i = 0; i < count; ++i) ball.held_by[i] = planes[i].normal;
    return ball;
  }
  // The place nearest to the target that they allow.
  [[nodiscard]] Vec3 aim(const Vec3& centre, const Vec3& target) const {
    const Vec3 way = target - centre;
    const NearestInside there = nearest_inside(std::span(planes).first(count), way);
    return there.found ? Vec3(centre + there.point_m) : centre;
  }
};

// Looks for the planes from where the ball is towards its target, several times in one move. Where they are too many,
// it goes a part of the way only, and tries twice that part the next time.
class Lookout {
 public:
  Lookout(const World& world, std::span<const std::uint8_t> nearby) : world_(world), nearby_(nearby) {}

  // False: it has looked too often in this move. Brings `target` nearer.
  bool look(const Holding& holding, const Vec3& centre, Vec3& target, Separations& out) {
    constexpr float kLess = 0.25F;
    const Vec3 whole = target - centre;
    for (; looks_ < kMaxLooks; part_ *= kLess) {
      ++looks_;
      if (part_ < 1.0F) target = centre + part_ * whole;
      if (out.look(world_, nearby_, holding.query(centre, target))) {
        part_ = std::min(2.0F * part_, 1.0F);
        return true;
      }
    }
    return false;
  }

 private:
  static constexpr int kMaxLooks = 16;

  const World& world_;
  std::span<const std::uint8_t> nearby_;
  float part_ = 1.0F;
  int looks_ = 0;
};

// The surfaces round the ball, for the displacement of a point from the centre: all that are near, or those only that
// it touches.
struct Surroundings {
  static constexpr std::size_t kMax = 16;
  std::array<HalfSpace, kMax> planes;
  std::array<std::size_t, kMax> index;
  std::size_t count = 0;
  Vec3 out = Vec3::Zero();  // away from what it touches

  Surroundings(const Separations& near, bool all_near) {
    for (std::size_t i = 0; i < near.count; ++i) {
      const float height_m = near.of[i].height_m;
      const bool touches = near.touches(i, kRadius_m);
      if (touches) out += near.of[i].normal;
      if (!touches && !(all_near && height_m <= kUnder_m)) continue;
      std::size_t at = count;
      if (count == kMax) {  // in place of the farthest
        at = static_cast<std::size_t>(
            std::min_element(planes.begin(), planes.end(),
                             [](const HalfSpace& a, const HalfSpace& b) { return a.offset_m < b.offset_m; }) -
            planes.begin());
        if (-height_m <= planes[at].offset_m) continue;
      } else {
        ++count;
      }
      planes[at] = {near.of[i].normal, -height_m};
      index[at] = i;
    }
  }
  // The point nearest to the target, if it is under the ball. It is exact where a surface that does not push keeps only
  // the ball away. Else, and with hold, the point under the centre.
  [[nodiscard]] NearestInside under(const Vec3& way, bool hold) const {
    const std::span<const HalfSpace> all(planes.data(), count);
    NearestInside point = nearest_inside(all, way);
    if (!hold && point.found && (point.count == 0 || point.point_m.squaredNorm() <= kUnder_m * kUnder_m))
      return point;
    const Vec3 down = -2.0F * kRadius_m * out.normalized();
    return nearest_inside(all, down);
  }
};

// Takes over the contacts and the point under the ball.
void set_contacts(const World& world, std::span<const std::uint8_t> nearby, GodObject& god, Separations& near,
                  const Vec3& target, bool hold) {
  const Vec3 way = target - god.centre_m;
  god.count = 0;
  god.position_m = god.centre_m;
  Surroundings round(near, false);
  if (round.count == 0) return;
  NearestInside under = round.under(way, hold);
  if (under.found && under.count == 0) {
    // The target is above the surfaces: only the ball's radius keeps it from coming there.
    if (!hold && way.squaredNorm() <= kUnder_m * kUnder_m) god.position_m = target;
    return;
  }
  // The point lies up to some radii from the centre, and must not come to lie in a solid that the ball does not touch.
  for (std::size_t i = 0; under.found && i < near.count; ++i) {
    if (near.of[i].height_m > kUnder_m ||
        near.of[i].normal.dot(under.point_m) >= -near.of[i].height_m - kBehind_m)
      continue;
    const Vec3 at = god.centre_m + under.point_m;
    if (!near.look(world, nearby, {god.centre_m, at, at, 0.0F, kUnder_m, {}, 0})) break;
    round = Surroundings(near, true);
    under = round.under(way, hold);
    break;
  }
  if (!under.found || under.count == 0) return;
  god.position_m = god.centre_m + under.point_m;
  for (std::size_t i = 0; i < under.count; ++i) {
    const std::size_t at = round.index[under.holding[i]];
    god.contacts[i] = {near.object[at], near.of[at].feature};
    god.normals[i] = near.of[at].normal;
  }
  god.count = under.count;
}

}  // namespace

void fly_ball(const World& world, std::span<const std::uint8_t> nearby, GodObject& god, const Vec3& target,
              RenderCounters& counters) noexcept {
  become_ball(world, god);
  Separations near;
  const Holding holding(god);
  Lookout lookout(world, nearby);
  for (int step = 0; step < kMaxSteps; ++step) {
    Vec3 aim = target;
    if (!lookout.look(holding, god.centre_m, aim, near)) {
      ++counters.sweep_bound;
      break;
    }
    const Vec3 way = aim - god.centre_m;
    float free = 1.0F;
    float behind_m = 0.0F;
    for (const HalfSpace& plane : near.all()) {
      behind_m = std::max(behind_m, plane.offset_m);
      const float falls = plane.normal.dot(way);
      if (falls < 0.0F) free = std::min(free, plane.offset_m / falls);
    }
    if (behind_m >
        kBehind_m) {  // it was a point until now, and nearer to a surface than the radius: out first
      const NearestInside out = near.nearest(Vec3::Zero());
      if (!out.found || out.point_m.squaredNorm() <= kSettled_m * kSettled_m) break;
      god.centre_m += out.point_m;
      continue;
    }
    god.centre_m += std::max(free, 0.0F) * way;
    if (free >= 1.0F && aim == target) {
      god.centre_m = target;
      god.position_m = target;
      return;
    }
    if (free * free * way.squaredNorm() <= kSettled_m * kSettled_m) break;
  }
  set_contacts(world, nearby, god, near, target, true);
  if (god.count == 0) god.position_m = god.centre_m;
}

void move_ball(const World& world, std::span<const std::uint8_t> nearby, GodObject& god, const Vec3& target,
               bool hold, RenderCounters& counters) noexcept {
  become_ball(world, god);
  const Vec3 goal = hold ? Vec3(target + god.centre_m - god.position_m) : target;
  const std::uint8_t held = god.count > 0 ? god.contacts[0].object : std::uint8_t{0};
  Separations near;
  Holding holding(god);
  Lookout lookout(world, nearby);
  bool settled = false;
  bool again =
      false;  // it rests against the plane of a solid that it does not touch: another plane may let it on
  for (int step = 0; step < kMaxSteps && !settled; ++step) {
    Vec3 aim = goal;
    if (!lookout.look(holding, god.centre_m, aim, near)) {
      ++counters.sweep_bound;
      break;
    }
    if (hold) {  // down on the surface that it is on
      std::size_t nearest = near.count;
      for (std::size_t i = 0; i < near.count; ++i) {
        if (near.object[i] == held &&
            (nearest == near.count || near.of[i].apart_m < near.of[nearest].apart_m))
          nearest = i;
      }
      if (nearest < near.count) {
        const HalfSpace& surface = near.planes[nearest];
        aim -= std::max(surface.height_m(aim - god.centre_m), 0.0F) * surface.normal;
      }
    }
    const Vec3 way = aim - god.centre_m;
    const NearestInside there = near.nearest(way);
    if (!there.found) {
      ++counters.slide_bound;
      break;
    }
    god.centre_m += there.point_m;
    const bool rests = there.point_m.squaredNorm() <= kSettled_m * kSettled_m;
    settled = rests && (again || !holds_from_afar(there, near));
    again = rests;
    holding.hold(there, near, rests);
    if (there.count == 0 && !hold && aim == goal) {
      god.centre_m = goal;
      god.position_m = goal;
      god.count = 0;
      return;
    }
  }
  if (!settled) {
    ++counters.slide_bound;
    const Vec3 way = goal - god.centre_m;
    const Vec3 under = god.centre_m + std::min(1.0F, kUnder_m / way.norm()) * way;
    if (!near.look(world, nearby, holding.query(god.centre_m, under)) &&
        !near.look(world, nearby, holding.query(god.centre_m, god.centre_m)))
      near.count = 0;
  }
  set_contacts(world, nearby, god, near, target, hold);
}

void leave_ball(const World& world, GodObject& god) noexcept {
  for (std::size_t i = 0; i < god.count; ++i) {
    const PlacedObject& object = world.objects[god.contacts[i].object];
    const Vec3 at = object.to_local(god.position_m);
    god.position_m =
        object.to_world(object.ops->slide(object.shape, god.contacts[i].feature, at, at, {.hold = true}).to);
  }
  god.is_ball = false;
}

}  // namespace thimble::control
