#include "host-tools/lab/scan.h"

#include "firmware/link/services.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;

link::MoveOrder order_to(const ScanPlan& plan, const Eigen::Vector3d& target_m, double speed_m_s,
                         bool come_back) {
  link::MoveOrder order;
  order.arm = plan.arm;
  order.come_back = come_back;
  order.target_x_m = static_cast<float>(target_m.x());
  order.target_y_m = static_cast<float>(target_m.y());
  order.target_z_m = static_cast<float>(target_m.z());
  order.speed_m_s = static_cast<float>(speed_m_s);
  order.force_limit_N = static_cast<float>(plan.force_limit_N);
  return order;
}

std::string named(const ScanPlan& plan, std::size_t point) {
  return "point " + std::to_string(point) + " (column " + std::to_string(plan.column_of(point)) + ", row " +
         std::to_string(plan.row_of(point)) + ")";
}

[[noreturn]] void stopped(const ScanPlan& plan, std::size_t point, link::MoveEnd end) {
  const bool blocked = end == link::MoveEnd::kBlocked;
  const bool met = end == link::MoveEnd::kForceReached;
  throw Error(
      ExitCode::kRefused, met || blocked ? "in-the-way" : "stopped",
      (met || blocked ? "something is in the arm's way at " : "the arm was stopped at ") + named(plan, point),
      "clear the way (clearance_m, origin_m of the plan), arm again and go on with --resume");
}

}  // namespace

bool probe_points(const ScanPlan& plan, ScanLog& log, const std::function<Probe&()>& probe,
                  const std::function<bool(std::size_t)>& go_on) {
  for (std::size_t point = log.points().size(); point < plan.points(); ++point) {
    if (!go_on(point)) return false;
    const Eigen::Vector3d nominal_m = plan.place_m(plan.column_of(point), plan.row_of(point));
    const Probe::Result there = probe().move(
        order_to(plan, nominal_m - plan.clearance_m * plan.approach, plan.travel_speed_m_s, false));
    if (there.state.end != link::MoveEnd::kTargetReached) stopped(plan, point, there.state.end);
    const Probe::Result pressed =
        probe().move(order_to(plan, nominal_m + plan.depth_m * plan.approach, plan.speed_m_s, true));
    if (pressed.state.end != link::MoveEnd::kTargetReached &&
        pressed.state.end != link::MoveEnd::kForceReached)
      stopped(plan, point, pressed.state.end);

    ProbedPoint probed;
    probed.point = point;
    probed.force_limit = pressed.state.end == link::MoveEnd::kForceReached;
    probed.peak_force_N = static_cast<double>(pressed.state.peak_force_N);
    probed.turn_m = Eigen::Vector3f(pressed.state.turn_x_m, pressed.state.turn_y_m, pressed.state.turn_z_m)
                        .cast<double>();
    for (const link::MoveSample& sample : pressed.samples) {
      probed.samples.push_back(
          {sample.phase == link::MovePhase::kGoing,
           Eigen::Vector3f(sample.tip_x_m, sample.tip_y_m, sample.tip_z_m).cast<double>(),
           static_cast<double>(sample.force_N)});
    }
    log.append(probed);
  }
  return true;
}

std::vector<StiffnessFit> fit_points(const ScanPlan& plan, const ScanLog& log) {
  std::vector<StiffnessFit> fits;
  std::string missed;
  std::size_t misses = 0;
  for (const ProbedPoint& point : log.points()) {
    const std::optional<StiffnessFit> fit = fit_point(plan, point);
    if (!fit) {
      if (++misses <= 5) missed += (missed.empty() ? "" : ", ") + named(plan, point.point);
    } else {
      fits.push_back(*fit);
    }
  }
  if (misses != 0) {
    throw Error(ExitCode::kRefused, "no-contact",
                "the specimen was not felt at " + std::to_string(misses) + " points: " + missed +
                    (misses > 5 ? ", ..." : ""),
                "correct the plan's origin_m, or give it more depth_m");
  }
  return fits;
}

}  // namespace thimble::host
