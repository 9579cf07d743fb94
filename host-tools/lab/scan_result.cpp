#include "host-tools/lab/scan_result.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "control/scene/limits.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr double kPerDegree = 180 / std::numbers::pi;
// The search for the common layers: steps of ratio and depth, as parts of them.
constexpr double kFirstStep = 0.08, kLastStep = 0.005;
constexpr int kAround = 1;

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * kPerDegree;
}

// A press along the plan's approach.
Aim approach_aim(const ScanPlan& plan, std::size_t point) {
  return {plan.place_m(plan.column_of(point), plan.row_of(point)), -plan.approach};
}

Eigen::Vector3d contact_of(const Aim& aim, const StiffnessFit& fit) {
  return aim.surface_m - fit.contact_m * aim.normal;
}

// The press that counts for a point: its line, its samples along the line, and its fit.
struct PointFit {
  Aim aim;
  std::vector<ProbeSample> samples;
  StiffnessFit fit;
};
struct PointFits {
  std::vector<PointFit> points;
  std::optional<Layers> layers;
};

std::vector<Eigen::Vector3d> contacts_of(const PointFits& fits) {
  std::vector<Eigen::Vector3d> contacts;
  for (const PointFit& point : fits.points) contacts.push_back(contact_of(point.aim, point.fit));
  return contacts;
}

std::vector<ProbeSample> along(const Aim& aim, const ProbedMove& press) {
  std::vector<ProbeSample> samples;
  for (const PointSample& sample : press.samples)
    samples.push_back({sample.out, -(sample.tip_m - aim.surface_m).dot(aim.normal), sample.force_N});
  return samples;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// A layer is under the whole specimen: all presses together tell its depth and its ratio better than one does. Layered: what most points
// say. Nothing: the points are not layered, and each has one slope.
std::optional<Layers> pool_layers(const ScanPlan& plan, std::vector<PointFit>& points) {
  std::vector<double> ratios, boundaries_m;
  for (const PointFit& point : points) {
    if (!point.fit.layer) continue;
    ratios.push_back(point.fit.layer->below_N_m / point.fit.stiffness_N_m);
    boundaries_m.push_back(point.fit.layer->boundary_m);
  }
  if (2 * ratios.size() <= points.size()) {
    for (PointFit& point : points) {
      if (point.fit.layer) point.fit = fit_one_slope(point.samples, plan.speed_m_s).value_or(point.fit);
    }
    return std::nullopt;
  }
  Layers best{median(ratios), median(boundaries_m)};
  double least = -1;
  for (double step = kFirstStep; step > kLastStep; step /= 2) {
    const Layers middle = best;
    for (int i = -kAround; i <= kAround; ++i) {
      for (int j = -kAround; j <= kAround; ++j) {
        const Layers tried{middle.ratio * (1 + i * step), middle.boundary_m * (1 + j * step)};
        double sum2 = 0;
        for (const PointFit& point : points) {
          StiffnessFit fit = point.fit;
          refit_layers(point.samples, tried, 0, fit);
          sum2 += fit.residual_N * fit.residual_N;
        }
        if (least < 0 || sum2 < least) {
          least = sum2;
          best = tried;
        }
      }
    }
  }
  for (PointFit& point : points) refit_layers(point.samples, best, plan.speed_m_s, point.fit);
  return best;
}

PointFits point_fits(const ScanPlan& plan, const ScanLog& log, bool along_normal) {
  PointFits fits;
  std::string missed;
  std::size_t misses = 0;
  for (std::size_t point = 0; point < plan.points(); ++point) {
    PointFit each{approach_aim(plan, point), {}, {}};
    if (const ProbedStep* step = log.find(point)) each.samples = along(each.aim, step->moves[0]);
    if (const std::optional<StiffnessFit> fit = fit_stiffness(each.samples, plan.speed_m_s)) {
      each.fit = *fit;
      fits.points.push_back(std::move(each));
    } else if (++misses <= 5) {
      missed += (missed.empty() ? "" : ", ") + plan.named(point);
    }
  }
  if (misses != 0) {
    throw Error(ExitCode::kRefused, "no-contact",
                "the specimen was not felt at " + std::to_string(misses) + " points: " + missed +
                    (misses > 5 ? ", ..." : ""),
                "correct the plan's origin_m, or give it more depth_m");
  }
  fits.layers = pool_layers(plan, fits.points);
  if (!along_normal) return fits;
  const ScannedShape shape(plan, contacts_of(fits));
  for (std::size_t point = 0; point < plan.points(); ++point) {
    const ProbedStep* step = log.find(plan.points() + point);
    const std::optional<Aim> aim = step == nullptr ? std::nullopt : aim_at(plan, shape, point);
    if (!aim) continue;
    PointFit each{*aim, along(*aim, step->moves[0]), {}};
    const std::optional<StiffnessFit> fit = fit_stiffness(each.samples, plan.speed_m_s);
    if (!fit) continue;
    each.fit = *fit;
    fits.points[point] = std::move(each);
  }
  fits.layers = pool_layers(plan, fits.points);
  return fits;
}

// Least squares of the height along u x v: h = c0 u + c1 v about the centre.
void fit_plane(const ScanPlan& plan, ScanResult& result) {
  const auto points = static_cast<double>(result.points.size());
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  for (const ScannedPoint& point : result.points) centre_m += point.contact_m / points;
  const Eigen::Vector3d up = plan.normal();
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const ScannedPoint& point : result.points) {
    const Eigen::Vector3d from_m = point.contact_m - centre_m;
    const Eigen::Vector2d at(from_m.dot(plan.u), from_m.dot(plan.v));
    A += at * at.transpose();
    b += at * from_m.dot(up);
  }
  const Eigen::Vector2d slope = A.inverse() * b;
  result.normal = (up - slope.x() * plan.u - slope.y() * plan.v).normalized();
  result.offset_m = result.normal.dot(centre_m);
  for (const ScannedPoint& point : result.points) {
    const double off_m = result.normal.dot(point.contact_m) - result.offset_m;
    result.off_plane_rms_m += off_m * off_m / points;
    result.off_plane_most_m = std::max(result.off_plane_most_m, std::abs(off_m));
  }
  result.off_plane_rms_m = std::sqrt(result.off_plane_rms_m);
  result.flat = result.off_plane_most_m <= kFlat_m;
}

}  // namespace

std::vector<Eigen::Vector3d> approach_contacts(const ScanPlan& plan, const ScanLog& log) {
  return contacts_of(point_fits(plan, log, false));
}

std::vector<Eigen::Vector3d> best_contacts(const ScanPlan& plan, const ScanLog& log) {
  return contacts_of(point_fits(plan, log, true));
}

std::optional<Aim> aim_at(const ScanPlan& plan, const ScannedShape& shape, std::size_t point) {
  const Eigen::Vector2d at(static_cast<double>(plan.column_of(point)),
                           static_cast<double>(plan.row_of(point)));
  const Aim aim{shape.place_m(at), shape.normal(at)};
  const double lean_deg = angle_deg(aim.normal, -plan.approach);
  if (lean_deg < kAligned_deg) return std::nullopt;
  if (lean_deg > kSteepest_deg) {
    throw Error(ExitCode::kRefused, "too-steep",
                "the surface leans " + std::to_string(std::lround(lean_deg)) +
                    " degrees from the approach at " + plan.named(point),
                "turn u, v and approach of the plan towards the surface, or scan a smaller patch");
  }
  return aim;
}

Aim aim_at_site(const ScannedShape& shape, const Eigen::Vector2d& site) {
  return {shape.place_m(site), shape.normal(site)};
}

std::optional<StiffnessFit> fit_press(const Aim& aim, const ProbedMove& press, double speed_m_s,
                                      const std::optional<Layers>& layers) {
  const std::vector<ProbeSample> samples = along(aim, press);
  std::optional<StiffnessFit> fit = fit_one_slope(samples, speed_m_s);
  if (fit && layers) refit_layers(samples, *layers, speed_m_s, *fit);
  return fit;
}

double ScanResult::height_m(const ScanPlan& plan, std::size_t point) const {
  return -(points[point].contact_m - plan.place_m(plan.column_of(point), plan.row_of(point)))
              .dot(plan.approach);
}

std::vector<double> ScanResult::stiffness_map(const ScanPlan& plan) const {
  std::vector<double> map(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    map[plan.row_of(i) * plan.columns + plan.column_of(i)] = points[i].stiffness_N_m;
  return map;
}

namespace {

void add_points(const ScanPlan& plan, const PointFits& fits, ScanResult& result,
                std::vector<StiffnessFit>& damped) {
  const auto count = static_cast<double>(fits.points.size());
  for (std::size_t i = 0; i < fits.points.size(); ++i) {
    const PointFit& from = fits.points[i];
    const Eigen::Vector3d normal =
        result.shape.normal({static_cast<double>(plan.column_of(i)), static_cast<double>(plan.row_of(i))});
    ScannedPoint point{from.fit, contact_of(from.aim, from.fit), 0, angle_deg(normal, from.aim.normal)};
    // Without friction the force is along the normal, so what is felt along the press is K (n . a)^2.
    const double cosine = normal.dot(from.aim.normal);
    point.fit.stiffness_N_m /= cosine * cosine;
    if (point.fit.layer) point.fit.layer->below_N_m /= cosine * cosine;
    if (point.lean_deg < kAligned_deg) damped.push_back(from.fit);
    result.residual_N = std::max(result.residual_N, point.fit.residual_N);
    result.hysteresis_N = std::max(result.hysteresis_N, std::abs(point.fit.hysteresis_N));
    result.depth_m += point.fit.depth_m / count;
    result.upper_N_m += point.fit.stiffness_N_m / count;
    if (point.fit.layer) result.lower_N_m += point.fit.layer->below_N_m / count;
    result.points.push_back(point);
  }
  result.least_stiffness_N_m = static_cast<double>(control::kMaxStiffness_N_m);
  for (ScannedPoint& point : result.points) {
    const StiffnessFit::Single single = point.fit.single(result.depth_m);
    point.stiffness_N_m = single.stiffness_N_m;
    result.off_N = std::max(result.off_N, single.off_N);
    result.mean_stiffness_N_m += single.stiffness_N_m / count;
    result.least_stiffness_N_m = std::min(result.least_stiffness_N_m, single.stiffness_N_m);
    result.most_stiffness_N_m = std::max(result.most_stiffness_N_m, single.stiffness_N_m);
  }
}

void add_sites(const ScanPlan& plan, const ScanLog& log, ScanResult& result,
               std::vector<StiffnessFit>& damped) {
  std::vector<StrokeForce> breakaway, sliding;
  const std::vector<Eigen::Vector2d> sites = plan.sites();
  for (std::size_t site = 0; site < sites.size(); ++site) {
    const ProbedStep* step = log.find(2 * plan.points() + site);
    if (step == nullptr) continue;
    const Aim aim = aim_at_site(result.shape, sites[site]);
    const auto fit = fit_press(aim, step->moves[0], plan.speed_m_s, result.layers);
    const auto fast = fit_press(aim, step->moves[1], plan.travel_speed_m_s, result.layers);
    if (fast) damped.push_back(*fast);
    if (!fit) continue;
    ++result.checks;
    result.check_rms_m += fit->contact_m * fit->contact_m;
    result.check_most_m = std::max(result.check_most_m, std::abs(fit->contact_m));
    const SiteForces forces = site_forces(*step, site, *fit, result.shape, contact_of(aim, *fit));
    breakaway.insert(breakaway.end(), forces.breakaway.begin(), forces.breakaway.end());
    sliding.insert(sliding.end(), forces.sliding.begin(), forces.sliding.end());
  }
  if (result.checks != 0)
    result.check_rms_m = std::sqrt(result.check_rms_m / static_cast<double>(result.checks));
  const std::optional<CoefficientFit> held = fit_coefficient(breakaway), slides = fit_coefficient(sliding);
  if (held && slides) result.friction = FrictionResult{*held, *slides};
}

}  // namespace

ScanResult result_of(const ScanPlan& plan, const ScanLog& log) {
  const PointFits fits = point_fits(plan, log, true);
  ScanResult result{.shape = ScannedShape(plan, contacts_of(fits)), .points = {}, .normal = {}};
  result.layers = fits.layers;
  std::vector<StiffnessFit> aligned, fast;  // presses in which friction of the surface does not act
  add_points(plan, fits, result, aligned);
  fit_plane(plan, result);
  add_sites(plan, log, result, fast);
  if (plan.measure_damping) result.damping = fit_damping(fast.empty() ? aligned : fast);
  return result;
}

}  // namespace thimble::host
