// The rotary delta (Novint Falcon, omega.3): three legs about z, each a thigh that an actuator turns and a parallelogram of two shins, so the plate
// does not turn. In the frame of leg i, which is turned by its angle about z:
//
//   (u, v) = R(-angle_i) (x, y) - (r, s),  w = z;      knee: (a cos q, 0, a sin q) from the axis of the thigh
//   g_i = (rho - (d + e))^2 + (v + f)^2 - b^2 = 0,   rho = |(u + c - a cos q, w - a sin q)|
//
// The shins' joints are at a distance d and e from the ends of the plate and the thigh, so the plate's place for one knee is a torus, and the
// formula for spheres is wrong off the axis. Source: Stamper 1997, as libnifalcon has it, rewritten. The forward map has no closed form: Newton
// on g from the last place.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "kinematics/geometry.h"
#include "kinematics/platform.h"
#include "kinematics/trig.h"

namespace thimble::kinematics {

// Newton's steps: enough from home to anywhere in a ball of 40 mm round it (Delta.TheForwardMapFindsThePlaceOfTheInverse), so from the place of
// the tick before.
inline constexpr int kDeltaSteps = 6;

template <typename S>
class Delta {
 public:
  using Vector3 = Eigen::Matrix<S, 3, 1>;
  using Matrix3 = Eigen::Matrix<S, 3, 3>;

  explicit Delta(const DeltaGeometry& geometry) noexcept : g_(&geometry) {
    for (int i = 0; i < 3; ++i)
      leg_[static_cast<std::size_t>(i)] = sin_cos(S(geometry.leg_angle_rad[static_cast<std::size_t>(i)]));
  }

  // plate.position_m is where the search begins, and the result. False: no place found from there, or no direction of force is safe
  // (the legs are almost in one plane); then the plate's values are not to be used.
  [[nodiscard]] bool at(const Vector3& q, Plate<S, 3>& plate) const noexcept {
    const std::array<SinCos<S>, 3> knee{sin_cos(q[0]), sin_cos(q[1]), sin_cos(q[2])};
    Matrix3 A, inverse;  // rows: d g_i / d position
    Vector3 g, by_q;
    for (int step = 0; step <= kDeltaSteps; ++step) {
      constraints(knee, plate.position_m, g, A, by_q);
      if (!invert(A, inverse)) return false;
      const Vector3 correction = inverse * g;
      plate.position_m -= correction;
      if (!(correction.squaredNorm() < kConverged_m2)) continue;  // A and by_q are those of the place
      plate.jacobian = -(inverse * by_q.asDiagonal());
      return true;
    }
    return false;
  }

  // Actuator angles for a place of the plate. False (q unchanged): out of reach. For tests and set-up.
  [[nodiscard]] bool inverse(const Vector3& position_m, Vector3& q) const noexcept {
    const S a = S(g_->thigh_m), b = S(g_->shin_m);
    Vector3 found;
    for (int i = 0; i < 3; ++i) {
      const Vector3 p = in_leg(i, position_m);
      const S across = p.y() + S(g_->plate_v_m);
      if (!(std::abs(across) < b)) return false;
      const S l = ends() + std::sqrt(b * b - across * across);
      const S x = p.x() + S(g_->plate_u_m), h = std::sqrt(x * x + p.z() * p.z());
      const S cosine = (h * h + a * a - l * l) / (2 * a * h);
      if (!(std::abs(cosine) < 1)) return false;
      found[i] = std::atan2(p.z(), x) + (g_->minus ? S(-1) : S(1)) * std::acos(cosine);
    }
    q = found;
    return true;
  }

 private:
  // The square of a step after which the next one would be below rounding: 0.1 um in float, 0.1 nm in double.
  static constexpr S kConverged_m2 = sizeof(S) == sizeof(float) ? S(1e-14) : S(1e-20);

  [[nodiscard]] S ends() const noexcept { return S(g_->shin_end_m) + S(g_->knee_end_m); }
  [[nodiscard]] Vector3 in_leg(int i, const Vector3& p) const noexcept {
    const SinCos<S>& turn = leg_[static_cast<std::size_t>(i)];
    return {turn.cos * p.x() + turn.sin * p.y() - S(g_->base_u_m),
            turn.cos * p.y() - turn.sin * p.x() - S(g_->base_v_m), p.z()};
  }

  void constraints(const std::array<SinCos<S>, 3>& knee, const Vector3& position_m, Vector3& g, Matrix3& A,
                   Vector3& by_q) const noexcept {
    const S a = S(g_->thigh_m), b = S(g_->shin_m);
    for (int i = 0; i < 3; ++i) {
      const SinCos<S>& q = knee[static_cast<std::size_t>(i)];
      const SinCos<S>& turn = leg_[static_cast<std::size_t>(i)];
      const Vector3 p = in_leg(i, position_m);
      const S u = p.x() + S(g_->plate_u_m) - a * q.cos, w = p.z() - a * q.sin, v = p.y() + S(g_->plate_v_m);
      const S rho = std::sqrt(u * u + w * w), out = rho - ends();
      const S scale = 2 * out / rho;
      const S du = scale * u, dw = scale * w, dv = 2 * v;
      g[i] = out * out + v * v - b * b;
      A.row(i) << turn.cos * du - turn.sin * dv, turn.sin * du + turn.cos * dv, dw;
      by_q[i] = a * (du * q.sin - dw * q.cos);
    }
  }

  // False: A is not finite, or nearly singular: three unit vectors would span less than a thousandth.
  [[nodiscard]] static bool invert(const Matrix3& A, Matrix3& inverse) noexcept {
    const Vector3 x = A.row(0), y = A.row(1), z = A.row(2);
    inverse.col(0) = y.cross(z);
    inverse.col(1) = z.cross(x);
    inverse.col(2) = x.cross(y);
    const S volume = x.dot(inverse.col(0));
    if (!(volume * volume > S(1e-6) * x.squaredNorm() * y.squaredNorm() * z.squaredNorm())) return false;
    inverse /= volume;
    return true;
  }

  const DeltaGeometry* g_;
  std::array<SinCos<S>, 3> leg_;
};

}  // namespace thimble::kinematics
