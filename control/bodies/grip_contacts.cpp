#include "control/bodies/grip_contacts.h"

#include <algorithm>
#include <cmath>

#include "control/bodies/contact_solver.h"

namespace thimble::control {

void GripContacts::begin(std::span<const SolverBody> bodies, std::span<const Grip> grips,
                         float period_s) noexcept {
  count_ = 0;
  for (const Grip& grip : grips) {
    const float moment_N_m_s = kGripRadius_m * period_s * grip.normal_N;
    Row& row = rows_[count_++];
    row = {};
    row.a = grip.body;
    row.object = bodies[grip.body].object;
    row.finger = grip.finger;
    row.static_most_N_m_s = grip.static_friction * moment_N_m_s;
    row.dynamic_most_N_m_s = grip.dynamic_friction * moment_N_m_s;
    row.normal = grip.normal;
  }
}

void GripContacts::prepare(std::span<const SolverBody> bodies) noexcept {
  for (Row& row : rows()) {
    row.angular = bodies[row.a].inverse_inertia * row.normal;
    const float response = row.normal.dot(row.angular);
    if (kGripRadius_m * kGripRadius_m * response <= kNoResponse) continue;
    row.inertia_kg_m2 = 1.0F / response;
    float alike = kSameDirection;
    for (std::size_t i = 0; i < stored_count_; ++i) {
      const Stored& stored = stored_[i];
      if (stored.object != row.object || stored.finger != row.finger) continue;
      const float cosine = stored.normal.dot(row.normal);
      if (cosine <= alike) continue;
      alike = cosine;
      row.sliding = stored.sliding;
      row.moment_N_m_s = stored.moment_N_m_s;
      row.twist_rad = stored.twist_rad;
    }
  }
}

void GripContacts::warm_start(std::span<SolverBody> bodies) noexcept {
  for (const Row& row : rows()) bodies[row.a].spin_rad_s += row.moment_N_m_s * row.angular;
}

float GripContacts::solve(std::span<SolverBody> bodies, float bias_per_s, float least_m_s) noexcept {
  float most_m_s = 0.0F;
  for (Row& row : rows()) {
    SolverBody& body = bodies[row.a];
    const float limit = row.most_N_m_s();
    const float spin_rad_s = row.normal.dot(body.spin_rad_s) + bias_per_s * row.twist_rad;
    const float moment = std::clamp(row.moment_N_m_s - row.inertia_kg_m2 * spin_rad_s, -limit, limit);
    const float change = moment - row.moment_N_m_s;
    if (change == 0.0F || row.inertia_kg_m2 <= 0.0F) continue;
    const float change_m_s = kGripRadius_m * std::abs(change) / row.inertia_kg_m2;
    if (change_m_s < least_m_s) continue;
    row.moment_N_m_s = moment;
    body.spin_rad_s += change * row.angular;
    most_m_s = std::max(most_m_s, change_m_s);
  }
  return most_m_s;
}

void GripContacts::add_twist(std::span<const SolverBody> bodies, float period_s) noexcept {
  for (Row& row : rows())
    if (!row.sliding) row.twist_rad += period_s * row.normal.dot(bodies[row.a].spin_rad_s);
}

void GripContacts::decide_sliding() noexcept {
  for (Row& row : rows()) {
    const float limit = row.most_N_m_s();
    if (limit <= 0.0F) {
      row.twist_rad = 0.0F;
      row.sliding = false;
    } else if (std::abs(row.moment_N_m_s) < kAtLimit * limit) {
      row.sliding = false;
    } else if (kGripRadius_m * std::abs(row.twist_rad) > kSlipped_m) {
      row.sliding = true;
      row.twist_rad = 0.0F;
    }
  }
}

void GripContacts::store() noexcept {
  std::copy_n(rows_.begin(), count_, stored_.begin());
  stored_count_ = count_;
}

float GripContacts::work_twice_J(std::span<const SolverBody> bodies) const noexcept {
  float work_J = 0.0F;
  for (std::size_t i = 0; i < count_; ++i)
    work_J += rows_[i].moment_N_m_s * rows_[i].normal.dot(bodies[rows_[i].a].spin_rad_s);
  return work_J;
}

}  // namespace thimble::control
