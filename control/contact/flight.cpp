#include "control/contact/flight.h"

#include <algorithm>

#include "control/contact/planes.h"

namespace thimble::control {
namespace {

constexpr int kMaxRefreshPieces = 8;  // slides that bring a contact's feature along with a corner step

struct Flight {
  Hit hit;
  std::uint8_t object = 0;
  bool known = true;  // false: a tree walk was cut short
};

// Sweeps from -> to against all objects nearby. `leaving`: the contacts that `from` is on. skip: an object
// that is known not to be hit.
void sweep_nearby(const World& world, const Nearby& nearby, const GodObject& god,
                  std::span<const Contact> leaving, const Vec3& from, const Vec3& to, int skip,
                  Flight& flight, Work& work) {
  for (const std::uint8_t index : nearby.objects()) {
    if (index == skip) continue;
    work.at(index);
    if (!work.spend(kSolidWork)) {
      flight.known = false;
      return;
    }
    const PlacedObject& object = world.objects[index];
    std::array<Feature, Left::kMax + 1> features;
    std::size_t count = 0;
    for (const Contact& contact : leaving) {
      if (contact.object == index) features[count++] = contact.feature;
    }
    if (const Feature* const beside = beside_on(god, index)) {
      features[count] = *beside;
      features[count++].kind = kSideOnly;
    }
    Hit hit{.t = flight.hit.t, .feature = {}};
    if (!object.ops->sweep(object.shape,
                           {work,
                            object.to_local(from),
                            object.to_local(to),
                            {features.data(), count},
                            nearby.point_triangles()},
                           hit)) {
      flight.known = false;
    }
    if (hit.t < flight.hit.t) {
      flight.hit = hit;
      flight.object = index;
    }
  }
}

// Updates a contact's feature for a point that should still be on its surface; false when it is not.
bool refresh(const World& world, Contact& contact, const Vec3& from, const Vec3& point, Work& work,
             Resting& resting) {
  const PlacedObject& object = world.objects[contact.object];
  const Vec3 target = object.to_local(point);
  Vec3 at = object.to_local(from);
  for (int piece = 0; piece < kMaxRefreshPieces; ++piece) {
    const ShortSlide& slide = resting.slide(object, contact.feature, at, target, work);
    contact.feature = slide.feature_there;
    at = slide.to_m;
    if (slide.end != SlideEnd::kMoved) break;
  }
  return (at - target).squaredNorm() <= kOnePlace_m * kOnePlace_m;
}

void add_contact(GodObject& god, const Contact& contact) {
  for (std::size_t i = 0; i < god.count; ++i) {
    if (god.contacts[i].object == contact.object && god.contacts[i].feature.index == contact.feature.index) {
      god.contacts[i] = contact;  // another hit on the same face
      return;
    }
  }
  if (god.count == kMaxContacts) {  // three planes hold a point already: drop the oldest
    std::rotate(god.contacts.begin(), god.contacts.begin() + 1, god.contacts.end());
    --god.count;
  }
  god.contacts[god.count++] = contact;
}

}  // namespace

void update_contacts(const World& world, const Nearby& nearby, GodObject& god, const Vec3& from,
                     const Vec3& point, Work& work) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < god.count; ++i) {
    Contact contact = god.contacts[i];
    if (refresh(world, contact, from, point, work, nearby.resting())) god.contacts[kept++] = contact;
  }
  god.count = kept;
}

Outcome fly_and_land(const World& world, const Nearby& nearby, std::span<const Contact> leaving,
                     GodObject& god, const Vec3& to, int skip, bool& landed, Work& work) noexcept {
  Flight flight;
  sweep_nearby(world, nearby, god, leaving, god.position_m, to, skip, flight, work);
  landed = false;
  if (!flight.known) return Outcome::kUnknown;
  if (flight.hit.t > 1.0F) {
    god.position_m = to;
    if (god.count == 0) god.has_beside = false;
    return Outcome::kContinue;
  }
  const Vec3 from = god.position_m;
  god.position_m = from + flight.hit.t * (to - from);
  update_contacts(world, nearby, god, from, god.position_m, work);
  add_contact(god, {flight.object, flight.hit.feature});
  landed = true;
  return Outcome::kContinue;
}

}  // namespace thimble::control
