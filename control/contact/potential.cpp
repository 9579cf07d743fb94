#include "control/contact/potential.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thimble::control {
namespace {

// Planes of different stiffness have a common potential only when they are perpendicular to each other.
bool has_potential(const Constraints& held) noexcept {
  constexpr float kSquare = 1.0e-4F;
  for (std::size_t i = 1; i < held.count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (held.list[i].material.stiffness_N_m != held.list[j].material.stiffness_N_m &&
          std::abs(held.list[i].normal.dot(held.list[j].normal)) > kSquare) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

bool ContactPotential::goes_on(const Constraints& held, float step_m) noexcept {
  const Depths now = depths(held);
  bool same = has_potential(held);
  if (before_.count != 0 && (now.stiffness_N_m == 0.0F || now.stiffness_N_m != before_.stiffness_N_m)) {
    // An object that the tip is pressed into further than it moved was taken over from another one.
    for (std::size_t i = 0; i < now.count; ++i)
      same = same && now.depth_m[i] <= depth_before(now.object[i]) + step_m + kSurfaceTolerance_m;
  }
  before_ = now;
  return same;
}

float spring_energy_J(const Constraints& held) noexcept {
  float energy_J = 0.0F;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Constraint& a = held.list[i];
    const float push_N = a.material.stiffness_N_m * a.lambda_m;
    energy_J += 0.5F * push_N * a.lambda_m;
    for (std::size_t j = 0; j < i; ++j) {
      const Constraint& b = held.list[j];
      const float both_m = a.lambda_m + b.lambda_m;
      if (both_m > 0.0F)
        energy_J += a.normal.dot(b.normal) * a.lambda_m * b.lambda_m *
                    (push_N + b.material.stiffness_N_m * b.lambda_m) / both_m;
    }
  }
  return std::max(energy_J, 0.0F);
}

ContactPotential::Depths ContactPotential::depths(const Constraints& held) noexcept {
  Depths out;
  std::array<Vec3, kMaxContacts> pull;
  for (std::size_t i = 0; i < held.count; ++i) {
    const Constraint& c = held.list[i];
    std::size_t at = 0;
    while (at < out.count && out.object[at] != c.object) ++at;
    if (at == out.count) {
      out.object[out.count] = c.object;
      pull[out.count++] = Vec3::Zero();
    }
    pull[at] += c.lambda_m * c.normal;
    if (i == 0) out.stiffness_N_m = c.material.stiffness_N_m;
    if (c.material.stiffness_N_m != out.stiffness_N_m) out.stiffness_N_m = 0.0F;
  }
  for (std::size_t i = 0; i < out.count; ++i) out.depth_m[i] = pull[i].norm();
  return out;
}

float ContactPotential::depth_before(std::uint8_t object) const noexcept {
  // The fast path for one plain surface does not come here: of an object that was alone, the depth may be old.
  if (before_.count == 1 && before_.object[0] == object) return std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < before_.count; ++i)
    if (before_.object[i] == object) return before_.depth_m[i];
  return 0.0F;
}

}  // namespace thimble::control
