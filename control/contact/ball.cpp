#include "control/contact/ball.h"

#include <algorithm>
#include <array>
#include <limits>

#include "control/contact/separations.h"
#include "control/contact/tip_ball.h"
#include "control/scene/limits.h"

namespace thimble::control {
namespace {

constexpr float kUnder_m =
    4.0F * kPointRadius_m;  // the point under the ball of a point is no farther from the centre
constexpr int kMaxSteps = 16;
constexpr float kUpright = 0.5F;  // cosine of the angle between two planes of one surface

bool is_tip(const World& world) { return world.tip_radius_m > 0.0F; }
float radius_m(const World& world) { return is_tip(world) ? world.tip_radius_m : kPointRadius_m; }

// From a point that lies on the planes of its contacts to the ball's centre over it.
Vec3 over_contacts(const GodObject& god) {
  std::array<HalfSpace, kMaxContacts> planes;
  for (std::size_t i = 0; i < god.count; ++i) planes[i] = {god.normals[i], kPointRadius_m};
  Work work(kHoldWork);
  const NearestInside over = nearest_inside(std::span(planes).first(god.count), Vec3::Zero(), work);
  return over.found ? over.point_m : Vec3(kPointRadius_m * god.normals[0]);
}

// Sweeps pieces of a path past meshes of several parts. A triangle gives no plane to a centre that is behind it, and where parts cross, a
// point could become a ball behind a triangle, or a squeezed ball be moved behind one.
class Sweeps {
 public:
  Sweeps(const World& world, const Nearby& nearby, Work& work) : world_(world), nearby_(nearby), work_(work) {
    for (const std::uint8_t index : nearby.objects())
      needed_ = needed_ || world.objects[index].shape.mesh.seams;
    needed_ = needed_ && !is_tip(world);
  }
  // `on`: what `from` lies on, which does not stop it. `behind_m`: how far behind a surface it may end.
  [[nodiscard]] [[gnu::noinline]] bool free(const Vec3& from, const Vec3& to,
                                            std::span<const Contact> on = {}, float behind_m = 0.0F) const {
    if (!needed_ || from == to) return true;
    const float length_m = (to - from).norm();
    for (const std::uint8_t index : nearby_.objects()) {
      const PlacedObject& object = world_.objects[index];
      if (!object.shape.mesh.seams) continue;
      std::array<Feature, kMaxContacts> features;
      std::size_t count = 0;
      for (const Contact& contact : on)
        if (contact.object == index) features[count++] = contact.feature;
      Hit hit;
      if (!object.ops->sweep(object.shape,
                             {work_, object.to_local(from), object.to_local(to), {features.data(), count}},
                             hit) ||
          (hit.t <= 1.0F && (1.0F - hit.t) * length_m >= behind_m))
        return false;
    }
    return true;
  }
  // From the centre to the point, which lies on surfaces or is at the target. A ball between them was cut short, or planes of faces that it
  // does not touch hold it: it would not push, and a point finds a way.
  [[nodiscard]] bool comes_down(const GodObject& god, const Vec3& target) const {
    if (needed_ && god.count == 0 && god.position_m != target) return false;
    return free(god.centre_m, god.position_m, {}, god.count > 0 ? 2.0F * kSurfaceTolerance_m : 0.0F);
  }

 private:
  const World& world_;
  const Nearby& nearby_;
  Work& work_;
  bool needed_ = false;
};

// False where the centre would not be free.
bool become_ball(const World& world, const Sweeps& sweeps, GodObject& god) {
  if (is_tip(world)) god.centre_m = god.position_m;
  if (god.is_ball) return true;
  contact_normals(world, god, god.normals);
  god.centre_m = is_tip(world) ? god.position_m : Vec3(god.position_m + over_contacts(god));
  god.is_ball = true;
  god.has_beside = false;
  return sweeps.free(god.position_m, god.centre_m, std::span(god.contacts).first(god.count));
}

// False where the planes of crossing faces have squeezed the ball of a point away from where it should go: a point finds a way. A point that
// becomes a ball, and a ball in a corner, may be up to two radii farther.
bool comes_nearer(const World& world, const Vec3& from, const Vec3& to, const Vec3& goal) {
  return is_tip(world) || (to - goal).norm() <= (from - goal).norm() + 2.0F * kPointRadius_m;
}

bool holds_from_afar(const NearestInside& there, const Separations& near, float radius_m) {
  for (std::size_t i = 0; i < there.count; ++i)
    if (!near.touches(there.holding[i], radius_m)) return true;
  return false;
}

// The planes that hold the ball where it is.
struct Holding {
  std::array<HalfSpace, kMaxHolding> planes;
  Separations::Held held;
  std::size_t count = 0;
  float radius_m;
  bool is_tip;
  float farther =
      1.0F;  // it looks this much farther for parts of meshes, after a move that ended where it had looked

  Holding(const World& world, const GodObject& god)
      : count(god.count), radius_m(control::radius_m(world)), is_tip(control::is_tip(world)) {
    for (std::size_t i = 0; i < count; ++i) {
      planes[i] = {god.normals[i], 0.0F};
      add(god.contacts[i].object, god.contacts[i].feature);
    }
  }
  void add(std::uint8_t object, const Feature& feature) {
    held.object[held.count] = object;
    held.feature[held.count++] = feature.index;
  }
  // touched: of the planes that hold it, only those of solids that it touches.
  void hold(const NearestInside& there, const Separations& near, bool touched) {
    count = held.count = 0;
    for (std::size_t i = 0; i < there.count; ++i) {
      const std::size_t at = there.holding[i];
      if (touched && !near.touches(at, radius_m)) continue;
      planes[count++] = {near.planes[at].normal, 0.0F};
      add(near.object[at], near.of[at].feature);
    }
  }
  [[nodiscard]] BallQuery query(const Vec3& centre, const Vec3& target, Work& work) const {
    const float way_m = (target - centre).norm();
    BallQuery ball{work,  centre, aim(centre, target, work), target, radius_m, 0.5F * way_m, {},
                   count, is_tip};
    // With room for as much more as the way to the aim, which is straight.
    constexpr float kLeast_m = 2.0e-5F;
    ball.reach_m = std::min(way_m, farther * (2.0F * (ball.aim_m - centre).norm() + kLeast_m));
    for (std::size_t i = 0; i < count; ++i) ball.held_by[i] = planes[i].normal;
    return ball;
  }
  // The place nearest to the target that they allow.
  [[nodiscard]] Vec3 aim(const Vec3& centre, const Vec3& target, Work& work) const {
    const Vec3 way = target - centre;
    const NearestInside there = nearest_inside(std::span(planes).first(count), way, work);
    return there.found ? Vec3(centre + there.point_m) : centre;
  }
};

// Looks for the planes from where the ball is towards its target, several times in one move. Where they are too many,
// it goes a part of the way only, and tries twice that part the next time.
class Lookout {
 public:
  Lookout(const World& world, const Nearby& nearby, Work& work)
      : world_(world), nearby_(nearby), work_(work) {}

  // False: it has looked too often in this move, or the work is spent. Brings `target` nearer.
  bool look(const Holding& holding, const Vec3& centre, Vec3& target, Separations& out) {
    constexpr float kLess = 0.25F;
    const Vec3 whole = target - centre;
    for (; looks_ < kMaxLooks && !work_.is_spent(); part_ *= kLess) {
      ++looks_;
      if (part_ < 1.0F) target = centre + part_ * whole;
      if (out.look(world_, nearby_, holding.query(centre, target, work_), holding.held)) {
        part_ = std::min(2.0F * part_, 1.0F);
        return true;
      }
    }
    return false;
  }

 private:
  static constexpr int kMaxLooks = 16;

  const World& world_;
  const Nearby& nearby_;
  Work& work_;
  float part_ = 1.0F;
  int looks_ = 0;
};

// After a move that is cut short: what is near the place where it ends. The last look was from elsewhere, or is incomplete.
// False: only what the ball touches is known, not what is near the point under it.
bool look_under(const World& world, const Nearby& nearby, const Holding& holding, const Vec3& centre,
                const Vec3& target, Separations& near, Work& work) {
  const Vec3 way = target - centre;
  const Vec3 under = centre + std::min(1.0F, kUnder_m / way.norm()) * way;
  if (near.look(world, nearby, holding.query(centre, under, work), holding.held)) return true;
  if (!near.look(world, nearby, holding.query(centre, centre, work), holding.held)) near.count = 0;
  return false;
}

// The surfaces round the ball, for the displacement of a point from the centre: all that are near, or those only that
// it touches.
struct Surroundings {
  static constexpr std::size_t kMax = 16;
  std::array<HalfSpace, kMax> planes;
  std::array<std::size_t, kMax> index;
  std::size_t count = 0;
  Vec3 out = Vec3::Zero();  // away from the nearest that it touches

  Surroundings(const Separations& near, bool all_near) {
    float lowest_m = kUnder_m;
    for (std::size_t i = 0; i < near.count; ++i) lowest_m = std::min(lowest_m, near.of[i].height_m);
    for (std::size_t i = 0; i < near.count; ++i) {
      const float height_m = near.of[i].height_m;
      const bool touches = near.touches(i, kPointRadius_m);
      if (touches && height_m <= lowest_m + kBehind_m) out += near.of[i].normal;
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
    Work work(kHoldWork);
    NearestInside point = nearest_inside(all, way, work);
    if (!hold && point.found && (point.count == 0 || point.point_m.squaredNorm() <= kUnder_m * kUnder_m))
      return point;
    work = Work(kHoldWork);
    NearestInside below = nearest_inside(all, -2.0F * kPointRadius_m * out.normalized(), work);
    if (below.count > 0 || !point.found || point.count == 0) return below;
    // In a groove so acute that its bottom is farther away: as near to it as what is near is known.
    point.point_m *= std::min(1.0F, kUnder_m / point.point_m.norm());
    return point;
  }
};

// Takes over the contacts and the point under the ball. known: `near` has all that is near this point.
void set_contacts(const World& world, const Nearby& nearby, GodObject& god, Separations& near,
                  const Vec3& target, bool hold, bool known, Work& work) {
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
    known = near.look(world, nearby, {work, god.centre_m, at, at, 0.0F, kUnder_m, {}, 0}, {});
    if (!known &&
        !near.look(world, nearby,
                   {work, god.centre_m, god.centre_m, god.centre_m, kPointRadius_m, 0.0F, {}, 0}, {}))
      return;
    round = Surroundings(near, known);
    under = round.under(way, hold);
    break;
  }
  if (!under.found || under.count == 0) return;
  // In the ball nothing else is.
  const float most = known ? 1.0F : std::min(1.0F, kPointRadius_m / under.point_m.norm());
  god.position_m = god.centre_m + most * under.point_m;
  for (std::size_t i = 0; i < under.count; ++i) {
    const std::size_t at = round.index[under.holding[i]];
    god.contacts[i] = {near.object[at], near.of[at].feature};
    god.normals[i] = near.of[at].normal;
  }
  god.count = under.count;
}

// As fly_ball() and move_ball(), but the god object is anywhere on the path where they return false.
bool fly_proven(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
                Effort& effort) {
  const Sweeps sweeps(world, nearby, effort.work);
  const Vec3 start = god.is_ball ? god.centre_m : god.position_m;
  if (!become_ball(world, sweeps, god)) return false;
  if (is_clear(world, nearby, effort.work, god.centre_m, target)) {
    god.centre_m = god.position_m = target;
    return true;
  }
  Separations near;
  const Holding holding(world, god);
  Lookout lookout(world, nearby, effort.work);
  bool rests = false;
  for (int step = 0; step < kMaxSteps && !rests; ++step) {
    Vec3 aim = target;
    if (!lookout.look(holding, god.centre_m, aim, near)) {
      ++effort.counters.sweep_bound;
      break;
    }
    const Vec3 way = aim - god.centre_m;
    float free = near.free_m < way.norm() ? near.free_m / way.norm() : 1.0F;
    float behind_m = 0.0F;
    for (const HalfSpace& plane : near.all()) {
      behind_m = std::max(behind_m, plane.offset_m);
      const float falls = plane.normal.dot(way);
      if (falls < 0.0F) free = std::min(free, std::max(plane.offset_m / falls, 0.0F));
    }
    if (behind_m >
        kBehind_m) {  // it was a point until now, and nearer to a surface than the radius: out first
      const NearestInside out = near.nearest(Vec3::Zero(), effort.work);
      rests = !out.found || out.point_m.squaredNorm() <= kSettled_m * kSettled_m;
      const Vec3 from = god.centre_m;
      if (!rests) god.centre_m += out.point_m;
      if (!sweeps.free(from, god.centre_m)) return false;
      continue;
    }
    const Vec3 from = god.centre_m;
    const bool arrives = free >= 1.0F && aim == target;
    god.centre_m = arrives ? target : Vec3(from + free * way);
    if (!sweeps.free(from, god.centre_m)) return false;
    if (arrives) {
      god.position_m = target;
      return true;
    }
    rests = free * free * way.squaredNorm() <= kSettled_m * kSettled_m;
  }
  const bool known = rests || look_under(world, nearby, holding, god.centre_m, target, near, effort.work);
  if (is_tip(world)) {
    set_tip_contacts(god, near, target, true, holding.radius_m);
    return true;
  }
  set_contacts(world, nearby, god, near, target, true, known, effort.work);
  if (god.count == 0) god.position_m = god.centre_m;
  return sweeps.comes_down(god, target) && comes_nearer(world, start, god.centre_m, target);
}

bool move_proven(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
                 Effort& effort) {
  const Sweeps sweeps(world, nearby, effort.work);
  const Vec3 start = god.is_ball ? god.centre_m : god.position_m;
  if (!become_ball(world, sweeps, god)) return false;
  if (roll(world, nearby, effort.work, god, target, hold)) return true;
  const Vec3 goal = hold && !is_tip(world) ? Vec3(target + over_contacts(god)) : target;
  const std::uint8_t held = god.count > 0 ? god.contacts[0].object : std::uint8_t{0};
  // A mesh of several parts has faces below its surface that look aside: they are not what it is on.
  const bool upright = god.count > 0 && world.objects[held].shape.mesh.seams;
  const Vec3 up = god.count > 0 ? god.normals[0] : Vec3(Vec3::Zero());
  Separations near;
  Holding holding(world, god);
  Lookout lookout(world, nearby, effort.work);
  bool settled = false;
  bool again =
      false;  // it rests against the plane of a solid that it does not touch: another plane may let it on
  for (int step = 0; step < kMaxSteps && !settled; ++step) {
    Vec3 aim = goal;
    if (!lookout.look(holding, god.centre_m, aim, near)) {
      ++effort.counters.sweep_bound;
      break;
    }
    std::size_t nearest = near.count;
    if (hold) {  // down on the surface that it is on
      for (std::size_t i = 0; i < near.count; ++i) {
        if (near.object[i] == held && (!upright || near.of[i].normal.dot(up) >= kUpright) &&
            (nearest == near.count || near.of[i].apart_m < near.of[nearest].apart_m))
          nearest = i;
      }
      if (nearest < near.count) {
        const HalfSpace& surface = near.planes[nearest];
        aim -= std::max(surface.height_m(aim - god.centre_m), 0.0F) * surface.normal;
      }
    }
    const Vec3 way = aim - god.centre_m;
    const NearestInside there = near.nearest(way, effort.work);
    if (!there.found) {
      ++effort.counters.slide_bound;
      break;
    }
    const float step_m = there.point_m.norm();
    const bool whole = step_m <= near.free_m;
    const Vec3 from = god.centre_m;
    god.centre_m += whole ? there.point_m : Vec3((near.free_m / step_m) * there.point_m);
    if (!sweeps.free(from, god.centre_m)) return false;
    const bool rests = step_m <= kSettled_m;
    settled = rests && (again || !holds_from_afar(there, near, holding.radius_m));
    again = rests;
    if (!whole) holding.farther *= 4.0F;
    if (!rests && whole && holding.is_tip && (hold || aim == goal) &&
        stop_on(world, god, nearest < near.count ? with_plane(there, nearest) : there, near))
      return true;
    holding.hold(there, near, rests);
    if (there.count == 0 && !hold && aim == goal && whole) {
      god.centre_m = goal;
      god.position_m = goal;
      god.count = 0;
      return true;
    }
  }
  if (!settled) ++effort.counters.slide_bound;
  const bool known = settled || look_under(world, nearby, holding, god.centre_m, goal, near, effort.work);
  if (is_tip(world)) {
    set_tip_contacts(god, near, target, hold, holding.radius_m);
  } else {
    set_contacts(world, nearby, god, near, target, hold, known, effort.work);
  }
  // Cut short above a surface, where it would not push.
  const bool is_free = !settled && god.count == 0 ? fly_proven(world, nearby, god, target, effort)
                                                  : sweeps.comes_down(god, target);
  return is_free && comes_nearer(world, start, god.centre_m, goal);
}

}  // namespace

bool fly_ball(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
              Effort& effort) noexcept {
  const GodObject start = god;
  if (fly_proven(world, nearby, god, target, effort)) return true;
  god = start;
  return false;
}

bool move_ball(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
               Effort& effort) noexcept {
  const GodObject start = god;
  if (move_proven(world, nearby, god, target, hold, effort)) return true;
  god = start;
  return false;
}

void leave_ball(const World& world, GodObject& god) noexcept {
  for (std::size_t i = 0; i < god.count; ++i) {
    const PlacedObject& object = world.objects[god.contacts[i].object];
    const Vec3 at = object.to_local(god.position_m);
    Work work(kInPlaceWork);
    god.position_m =
        object.to_world(object.ops->slide(object.shape, god.contacts[i].feature, {work, at, at, true}).to);
  }
  god.is_ball = false;
}

}  // namespace thimble::control
