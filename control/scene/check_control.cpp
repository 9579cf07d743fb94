#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/bodies/control_element.h"
#include "control/scene/check.h"

namespace thimble::control {
namespace {

ImageVerdict check_curve(const scene::Control& control, float most, float& steepest) {
  steepest = 0.0F;
  if (control.curve() == nullptr) return ImageStatus::kOk;
  const auto& curve = *control.curve();
  RETURN_IF_BAD(at_most(kMaxCurvePoints, curve.size(), "points of a curve", ImageStatus::kTooManySamples));
  for (std::uint32_t i = 0; i < curve.size(); ++i) {
    const scene::CurvePoint& point = *curve.Get(i);
    RETURN_IF_BAD(require(
        in_range(point.at(), -most, most) && in_range(point.effort(), -kMaxControlEffort, kMaxControlEffort),
        ImageStatus::kBadNumber));
    if (i == 0) continue;
    const float run = point.at() - curve.Get(i - 1)->at();
    RETURN_IF_BAD(require(run > 0.0F, ImageStatus::kBadNumber));
    steepest = std::max(steepest, std::abs(point.effort() - curve.Get(i - 1)->effort()) / run);
  }
  return ImageStatus::kOk;
}

}  // namespace

ImageVerdict check_control(const scene::Object& object) noexcept {
  const scene::Body& body = *object.body();
  if (body.control() == nullptr) return ImageStatus::kOk;
  const scene::Control& c = *body.control();
  const bool turns = body.motion() == scene::Motion::Turn;
  RETURN_IF_BAD(require(turns || body.motion() == scene::Motion::Slide, ImageStatus::kBadNumber));
  const float most = turns ? kMaxTurn_rad : kMaxCoordinate_m;
  const auto is_place = [&](float q) { return in_range(q, -most, most); };
  RETURN_IF_BAD(require(
      in_range(c.stiffness(), 0.0F, kMaxStiffness_N_m) && is_place(c.rest()) &&
          in_range(c.damping(), 0.0F, kMaxDamping_N_s_m) && in_range(c.friction(), 0.0F, kMaxControlEffort) &&
          in_range(c.low(), -most, 0.0F) && in_range(c.high(), 0.0F, most) && c.low() < c.high(),
      ImageStatus::kBadNumber));
  RETURN_IF_BAD(require(in_range(c.detent_effort(), 0.0F, kMaxControlEffort) && is_place(c.detent_phase()) &&
                            (c.detent_pitch() == 0.0F || in_range(c.detent_pitch(), kMinDetentPitch, most)),
                        ImageStatus::kBadNumber));
  RETURN_IF_BAD(
      require(!c.has_switch() || (is_place(c.on_at()) && is_place(c.off_at()) && c.on_at() != c.off_at()),
              ImageStatus::kBadNumber));
  float steepest = 0.0F;
  RETURN_IF_BAD(check_curve(c, most, steepest));
  const float detents = c.detent_pitch() > 0.0F
                            ? 2.0F * std::numbers::pi_v<float> * c.detent_effort() / c.detent_pitch()
                            : 0.0F;
  const float most_stiffness =
      kMaxControlRate_rad_s * kMaxControlRate_rad_s * control_element_inertia(object);
  return require(in_range(c.stiffness() + detents + steepest, 0.0F, most_stiffness), ImageStatus::kBadNumber);
}

}  // namespace thimble::control
