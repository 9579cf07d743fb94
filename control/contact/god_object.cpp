#include "control/contact/god_object.h"

#include <algorithm>
#include <limits>

#include "control/contact/ball.h"
#include "control/contact/flight.h"
#include "control/contact/planes.h"

namespace thimble::control {
namespace {

constexpr int kMaxMoves = 32;  // flights, slides and corner steps of one move

// Whether a move goes on from both in the same way.
[[gnu::noinline]] bool same(const GodObject& a, const GodObject& b) {
  return a.position_m == b.position_m && a.count == b.count && a.has_beside == b.has_beside &&
         (!a.has_beside || a.beside == b.beside) && same_contacts(a, b.contacts);
}

void remove_inactive(GodObject& god, const Planes& planes, const NearestInside& projection) {
  std::array<bool, kMaxContacts> active{};
  for (std::size_t i = 0; i < projection.count; ++i) active[planes.contact[projection.holding[i]]] = true;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < god.count; ++i) {
    if (active[i]) {
      god.contacts[kept++] = god.contacts[i];
    } else {
      god.beside = god.contacts[i];
      god.has_beside = true;
    }
  }
  god.count = kept;
}

// Flies along a piece of a slide; where another object is in the way, stops there with one more contact.
[[gnu::always_inline]] inline Outcome fly_along(const World& world, const Nearby& nearby, const Slide& slide,
                                                const Feature& feature, GodObject& god, bool& landed,
                                                Work& work) {
  Contact& contact = god.contacts[0];
  const PlacedObject& object = world.objects[contact.object];
  // The feature that the slide starts from and the one that it slides along do not stop the sweep.
  const std::array<Contact, 2> leaving{contact, Contact{contact.object, feature}};
  const int skip = slide.swept ? contact.object : kSkipNone;
  if (!slide.swept) contact.feature = {feature.index, 0, 0, feature.side};
  if (slide.bent) {
    const Outcome outcome =
        fly_and_land(world, nearby, leaving, god, object.to_world(slide.via), skip, landed, work);
    if (outcome == Outcome::kUnknown || landed) return outcome;
  }
  return fly_and_land(world, nearby, leaving, god, object.to_world(slide.to), skip, landed, work);
}

// A bent piece leaves the surface by up to 0.4 radii on its way. Where it meets another object out there, that place can be farther from
// the target than the start. Then the arc is halved: the detour falls with the square of its angle, what it gains with the angle.
constexpr int kMaxHalvings = 8;

bool moves_away(const Vec3& target, const Vec3& to, const Vec3& from) {
  return (to - target).squaredNorm() > (from - target).squaredNorm();
}

// `ended`: the slide goes no further. In a function of its own: the copy of the god object would take 2 % of a tick on a mesh, which has
// no arcs.
[[gnu::noinline]] Outcome slide_on_arc(const World& world, const Nearby& nearby, Slide slide, Feature feature,
                                       GodObject& god, const Vec3& target, Effort& effort, bool& ended) {
  const GodObject start = god;
  const Contact& contact = start.contacts[0];
  const PlacedObject& object = world.objects[contact.object];
  for (int halving = 0; halving <= kMaxHalvings; ++halving) {
    const Outcome outcome = fly_along(world, nearby, slide, feature, god, ended, effort.work);
    if (halving == 0 && !ended && outcome != Outcome::kUnknown) return outcome;
    if (!moves_away(target, god.position_m, start.position_m)) {
      if (!ended && outcome != Outcome::kUnknown) god.contacts[0].feature = feature;
      ended = true;
      return outcome;
    }
    god = start;
    if (outcome == Outcome::kUnknown) return outcome;
    feature = contact.feature;
    const Vec3 from = object.to_local(start.position_m);
    // The middle of the chord is inside, as the solid is convex: the slide ends above it.
    slide = object.ops->slide(object.shape, feature,
                              {effort.work, from, Vec3(0.5F * (from + slide.to)), true, true});
  }
  ended = true;
  ++effort.counters.slide_bound;
  return Outcome::kSettled;
}

// A way over more faces of a mesh than there is work for: through the air instead, along the plane of the contact, then down to the target. Both
// parts are swept against all objects, so this passes nothing either. False, and nothing has moved, where it would not come nearer.
[[gnu::noinline]] bool fly_over(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
                                Work& work) {
  const GodObject start = god;
  const Contact& contact = start.contacts[0];
  const PlacedObject& object = world.objects[contact.object];
  std::array<Vec3, 3> normals;
  object.ops->normals(object.shape, {contact.feature.index, 0, 0, contact.feature.side},
                      object.to_local(god.position_m), normals);
  const Vec3 normal = object.turn(normals[0]);
  const Vec3 way = target - god.position_m;
  const float height_m = normal.dot(way);
  const Vec3 along = way - height_m * normal;
  const float along_m = along.norm();
  if (height_m > 0.0F || along_m <= 0.0F) return false;
  // Round a body the way down is the better the more it comes from the side. A way close to the surface would meet many leaves of the tree.
  constexpr float kRise = 0.25F;
  const float way_m = std::max(along_m, -height_m);
  const Vec3 over = god.position_m + (way_m / along_m) * along + kRise * way_m * normal;
  // What is left is for a walk, should it fail.
  const std::uint32_t share = work.at_hand() / 2;
  Work some(share);
  bool landed = false;
  Outcome outcome = Outcome::kContinue;
  for (int leg = 0; leg < 2 && outcome != Outcome::kUnknown && !landed; ++leg) {
    if (leg == 1) god.count = 0;
    outcome = fly_and_land(world, nearby, std::span(&contact, leg == 0 ? 1U : 0U), god,
                           leg == 0 ? over : target, kSkipNone, landed, some);
  }
  const bool nearer =
      outcome != Outcome::kUnknown && (god.position_m - target).squaredNorm() < way.squaredNorm();
  if (!nearer) god = start;
  return work.spend(share - some.left()) && nearer;
}

// One contact: slide over its surface.
Outcome slide_on_one(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
                     bool alone, Left& left, Effort& effort) {
  Contact& contact = god.contacts[0];
  const PlacedObject& object = world.objects[contact.object];
  Feature feature = contact.feature;
  const Contact start{contact.object, {.index = feature.index, .side = feature.side}};
  effort.work.at(contact.object);
  const Vec3 from = object.to_local(god.position_m);
  SlideQuery query{effort.work, from,    object.to_local(target),  hold, !alone,
                   false,       nullptr, nearby.point_triangles(), true};
  Slide slide = object.ops->slide(object.shape, feature, query);
  if (slide.end == SlideEnd::kFar) {
    if (fly_over(world, nearby, god, target, effort.work)) {
      left.count = 0;
      return Outcome::kContinue;
    }
    query.not_far = false;
    slide = object.ops->slide(object.shape, feature, query);
  }
  if (alone && slide.swept) {
    god.position_m = object.to_world(slide.to);
  } else {
    bool ended = false;
    const Outcome outcome = slide.bent
                                ? slide_on_arc(world, nearby, slide, feature, god, target, effort, ended)
                                : fly_along(world, nearby, slide, feature, god, ended, effort.work);
    if (outcome == Outcome::kUnknown || ended) return outcome;
  }
  god.contacts[0].feature = feature;
  switch (slide.end) {
    case SlideEnd::kHeld:
      return Outcome::kSettled;
    case SlideEnd::kMoved:
      return Outcome::kContinue;
    case SlideEnd::kBound:
      ++effort.counters.slide_bound;
      return Outcome::kSettled;
    case SlideEnd::kFree:
    case SlideEnd::kFar:
      break;
  }
  if (left.count > 0 && (slide.to - from).squaredNorm() <= kOnePlace_m * kOnePlace_m) {
    left.add(start);
  } else {
    left.count = 0;
  }
  left.add(god.contacts[0]);
  god.count = 0;
  return Outcome::kContinue;
}

// Two or three contacts: all their planes together.
Outcome slide_in_corner(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
                        Left& left, Work& work) {
  const Planes& planes = nearby.resting().planes_at(world, god);
  const NearestInside& projection = nearby.resting().project(target - god.position_m);
  if (projection.count == 0 && projection.point_m != Vec3::Zero()) {  // no plane holds it back
    // The sweep ignores these faces only: other faces at their edges can still stop it.
    left.count = 0;
    for (std::size_t i = 0; i < god.count; ++i) {
      const Feature& f = god.contacts[i].feature;
      left.add({god.contacts[i].object, {.index = f.index, .side = f.side}});
    }
    god.count = 0;
    return Outcome::kContinue;
  }
  if (projection.count != 0) remove_inactive(god, planes, projection);
  if (projection.point_m.squaredNorm() <= kSettled_m * kSettled_m) return Outcome::kSettled;
  if (god.count == 1 && projection.count == 1) return Outcome::kContinue;
  // Along the line where two planes meet.
  const Vec3 from = god.position_m;
  const std::array<Contact, kMaxContacts> leaving = god.contacts;
  const std::size_t leaving_count = god.count;
  bool landed = false;
  const Outcome outcome = fly_and_land(world, nearby, {leaving.data(), leaving_count}, god,
                                       from + projection.point_m, kSkipNone, landed, work);
  if (outcome == Outcome::kUnknown) return outcome;
  if (!landed) update_contacts(world, nearby, god, from, god.position_m, work);
  return Outcome::kContinue;
}

// Whether one of them is on a part of a mesh that touches another part of the mesh: both are as several solids.
[[gnu::noinline]] bool on_seam(const World& world, std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) {
    const MeshView& mesh = world.objects[contact.object].shape.mesh;
    if (mesh.seams &&
        (mesh.flags[contact.feature.index] & static_cast<std::uint8_t>(scene::TriangleFlag::Seam)) != 0)
      return true;
  }
  return false;
}

// Makes the ball a point on the first surface below its centre, which is free. Its place under the ball lies on the planes of faces, and can
// be beside one of them, or behind another face.
void come_down(const World& world, const Nearby& nearby, GodObject& god, Effort& effort) {
  if (god.count > 0) {
    GodObject point = god;
    point.position_m = god.centre_m;
    point.is_ball = false;
    point.count = 0;
    bool landed = false;
    if (fly_and_land(world, nearby, {}, point, god.centre_m + 2.0F * (god.position_m - god.centre_m),
                     kSkipNone, landed, effort.work) == Outcome::kUnknown)
      ++effort.counters.sweep_bound;
    if (landed) {
      god = point;
      return;
    }
  }
  leave_ball(world, god);
}

void fly_point(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, Effort& effort) {
  if (god.is_ball) come_down(world, nearby, god, effort);
  bool landed = false;
  if (fly_and_land(world, nearby, {}, god, target, kSkipNone, landed, effort.work) == Outcome::kUnknown)
    ++effort.counters.sweep_bound;
}

// Moves it as a point. to_seam: only to where parts of a mesh touch; returns false there, as it could come between them.
[[gnu::noinline]] bool move_point(const World& world, const Nearby& nearby, GodObject& god,
                                  const Vec3& target, bool hold, bool to_seam, Effort& effort) {
  Left left;
  float nearest2 = std::numeric_limits<float>::infinity();
  int idle_steps = 0;  // corner steps that brought it no nearer
  GodObject corner;    // at the last of them
  const auto stops = [&] {
    return to_seam && on_seam(world, god.count > 0 ? std::span(god.contacts).first(god.count) : left.all());
  };
  for (int moves = 0; moves < kMaxMoves && effort.work.spend(kMoveWork); ++moves) {
    if (stops()) return false;
    if (god.is_ball) come_down(world, nearby, god, effort);
    Outcome outcome = Outcome::kContinue;
    if (god.count == 0) {
      bool landed = false;
      outcome = fly_and_land(world, nearby, left.all(), god, target, kSkipNone, landed, effort.work);
      if (outcome == Outcome::kContinue && !landed) return true;
    } else if (god.count == 1) {
      const bool alone = nearby.objects().size() == 1 && nearby.objects()[0] == god.contacts[0].object;
      outcome = slide_on_one(world, nearby, god, target, hold, alone, left, effort);
    } else {
      // Between nearly parallel faces it can move back and forth by rounding: it ends after two steps without
      // progress, or where it comes back to the same corner and would go round for ever.
      const float distance2 = (god.position_m - target).squaredNorm();
      constexpr float kNearer = 1.0F - 1.0e-6F;
      idle_steps = distance2 < kNearer * nearest2 ? 0 : idle_steps + 1;
      nearest2 = std::min(nearest2, distance2);
      if (idle_steps > 2 || (idle_steps > 0 && left.count == 0 && same(god, corner))) return true;
      if (left.count == 0) corner = god;
      outcome = slide_in_corner(world, nearby, god, target, left, effort.work);
    }
    if (outcome == Outcome::kSettled) return !stops();
    if (outcome == Outcome::kUnknown) {
      ++effort.counters.sweep_bound;
      return true;
    }
  }
  ++effort.counters.slide_bound;
  if (god.count > 0) return !stops();
  // Cut short above a surface, where it would not push.
  bool landed = false;
  if (fly_and_land(world, nearby, left.all(), god, target, kSkipNone, landed, effort.work) ==
      Outcome::kUnknown)
    ++effort.counters.sweep_bound;
  return !stops();
}

// What it can meet: it comes nearer to the target all the way, or may leave it by as much as Reach allows. Where one solid is left, it stays
// a point: a ball takes several times as long.
Nearby on_way(const World& world, const Nearby& nearby, const GodObject& god, const Vec3& target, bool hold) {
  const float moves = hold ? Reach::kMoves : 1.0F;
  const float way =
      std::max((target - god.position_m).norm(), god.is_ball ? (target - god.centre_m).norm() : 0.0F);
  return nearby.within(world, target, moves * way + world.margin_m);
}

void fly_near(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, Effort& effort) {
  if (nearby.several() || world.tip_radius_m > 0.0F) {
    if (fly_ball(world, nearby, god, target, effort)) return;
  } else if (world.any_seams) {
    GodObject ball = god;
    fly_point(world, nearby, god, target, effort);
    if (on_seam(world, std::span(god.contacts).first(god.count)) &&
        fly_ball(world, nearby, ball, target, effort))
      god = ball;  // a point could have come between two parts of a mesh
    return;
  }
  fly_point(world, nearby, god, target, effort);
}

void move_near(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
               Effort& effort) {
  if (nearby.several() || world.tip_radius_m > 0.0F) {
    if (move_ball(world, nearby, god, target, hold, effort)) return;
  } else if (world.any_seams) {
    GodObject ball = god;
    if (move_point(world, nearby, god, target, hold, true, effort)) return;
    if (move_ball(world, nearby, ball, target, hold, effort)) {
      god = ball;
      return;
    }
  }
  move_point(world, nearby, god, target, hold, false, effort);
}

}  // namespace

void fly(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
         Effort& effort) noexcept {
  if (nearby.several())
    return fly_near(world, on_way(world, nearby, god, target, false), god, target, effort);
  fly_near(world, nearby, god, target, effort);
}

void move(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
          Effort& effort) noexcept {
  if (nearby.several())
    return move_near(world, on_way(world, nearby, god, target, hold), god, target, hold, effort);
  move_near(world, nearby, god, target, hold, effort);
}

}  // namespace thimble::control
