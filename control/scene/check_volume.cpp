#include "control/fields/volume.h"
#include "control/scene/check.h"

namespace thimble::control {
namespace {

bool is_half_space(const scene::HalfSpace& half) {
  return is_coordinate(half.normal()) && is_unit(half.normal()) &&
         in_range(half.offset_m(), -2.0F * kMaxCoordinate_m, 2.0F * kMaxCoordinate_m);
}

}  // namespace

ImageVerdict check_vector_field(const scene::VectorField& field) noexcept {
  RETURN_IF_BAD(
      at_most(kMaxSubvolumes, field.subvolumes()->size(), "subvolumes", ImageStatus::kTooManySamples));
  RETURN_IF_BAD(
      require(is_coordinate(*field.lo_m()) && is_coordinate(*field.hi_m()), ImageStatus::kBadNumber));
  for (const scene::Subvolume* subvolume : *field.subvolumes()) {
    RETURN_IF_BAD(at_most(kMaxSubvolumeSides, subvolume->sides()->size(), "sides of a subvolume",
                          ImageStatus::kTooManySamples));
    for (const scene::HalfSpace* side : *subvolume->sides()) {
      RETURN_IF_BAD(require(is_half_space(*side), ImageStatus::kBadNumber));
    }
    RETURN_IF_BAD(require(is_half_space(*subvolume->plane()) && is_coordinate(*subvolume->centre_m()) &&
                              in_range(subvolume->radius_m(), 0.0F, kMaxCoordinate_m),
                          ImageStatus::kBadNumber));
  }
  return ImageStatus::kOk;
}

ImageVerdict check_force_field(const scene::ForceField& field) noexcept {
  const auto within = [](const scene::Vec3& numbers, float least, float most) {
    return in_range(numbers.x(), least, most) && in_range(numbers.y(), least, most) &&
           in_range(numbers.z(), least, most);
  };
  const float mass_kg = field.mass_kg();
  return require(within(field.constant_n(), -kMaxFieldForce_N, kMaxFieldForce_N) &&
                     within(field.stiffness_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                     within(field.damping_n_s_per_m(), 0.0F, kMaxDamping_N_s_m) &&
                     within(field.curl_n_s_per_m(), -kMaxDamping_N_s_m, kMaxDamping_N_s_m) &&
                     within(field.half_size_m(), 0.0F, kMaxCoordinate_m) && field.trial() <= kMaxTrial &&
                     (mass_kg == 0.0F || (in_range(mass_kg, kMinMass_kg, kMaxMass_kg) &&
                                          within(field.curl_n_s_per_m(), 0.0F, 0.0F))) &&
                     in_range(field.mass_stiffness_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                     in_range(field.mass_damping_n_s_per_m(), 0.0F, kMaxDamping_N_s_m),
                 ImageStatus::kBadNumber);
}

ImageVerdict check_potential_field(const scene::PotentialField& field, Pauses& pauses) noexcept {
  constexpr std::uint16_t kLeastCount = 4;  // one cell of the spline
  if (field.count()->size() != 3) return ImageStatus::kBadIndex;
  std::size_t samples = 1;
  for (const std::uint16_t count : *field.count()) {
    if (count < kLeastCount) return ImageStatus::kBadIndex;
    samples *= count;
    RETURN_IF_BAD(at_most(kMaxFieldSamples, samples, "points of a field", ImageStatus::kTooManySamples));
  }
  RETURN_IF_BAD(require(field.coefficients()->size() == samples, ImageStatus::kBadIndex));
  RETURN_IF_BAD(require(is_coordinate(*field.origin_m()) &&
                            in_range(field.step_m(), kMinFieldStep_m, kMaxCoordinate_m) &&
                            field.law() <= scene::PotentialLaw::MAX,
                        ImageStatus::kBadNumber));
  for (const float coefficient : *field.coefficients()) {
    pauses.step();
    RETURN_IF_BAD(require(in_range(coefficient, -kMaxPotential, kMaxPotential), ImageStatus::kBadNumber));
  }
  return ImageStatus::kOk;
}

ImageVerdict check_volume(const scene::Object& object, const VolumeOps& volume, Pauses& pauses) noexcept {
  // Effects of a surface and motion belong to objects that have a surface; a proxy needs a stiffness.
  if (object.surface() != nullptr || object.body() != nullptr) return ImageStatus::kNoShape;
  RETURN_IF_BAD(require(object.material()->stiffness_n_per_m() > 0.0F, ImageStatus::kBadNumber));
  return volume.check(object, pauses);
}

}  // namespace thimble::control
