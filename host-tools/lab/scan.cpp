#include "host-tools/lab/scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "firmware/link/services.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

namespace link = firmware::link;
using link::MoveEnd;

constexpr double kNear_m = 3e-3;  // a move begins so far before a surface whose shape is known
constexpr double kFree = 0.5;     // part of that which a way between two points keeps
constexpr int kWayPlaces = 16;
// Normal forces of the strokes over the force limit. The sum of normal force and friction stays below the limit for coefficients up to 1.7.
constexpr std::array<double, kSiteLoads> kLoads = {0.28, 0.5};

// Executes the moves of the steps.
class Prober {
 public:
  Prober(const ScanPlan& plan, Probe& probe) : plan_(plan), probe_(probe) {}

  // The approach to a point whose surface is not known yet.
  ProbedStep press_along_approach(std::size_t point) {
    const Eigen::Vector3d nominal_m = plan_.place_m(plan_.column_of(point), plan_.row_of(point));
    travel(nominal_m - plan_.clearance_m * plan_.approach, plan_.named(point));
    return {point, {press(nominal_m + plan_.depth_m * plan_.approach, plan_.speed_m_s, plan_.named(point))}};
  }

  ProbedStep press_along_normal(std::size_t point, const ScannedShape& shape, const Aim& aim) {
    travel_over(shape, aim.surface_m + near_m() * aim.normal, plan_.named(point));
    return {plan_.points() + point,
            {press(aim.surface_m - plan_.depth_m * aim.normal, plan_.speed_m_s, plan_.named(point))}};
  }

  ProbedStep probe_site(std::size_t site, const ScannedShape& shape) {
    const Aim aim = aim_at_site(shape, plan_.sites()[site]);
    const std::string where = "friction site " + std::to_string(site);
    ProbedStep step{2 * plan_.points() + site, {}};
    for (const double speed_m_s : {plan_.speed_m_s, plan_.travel_speed_m_s}) {
      // Twice as far, so that the arm is at its speed.
      travel_over(shape, aim.surface_m + 2 * near_m() * aim.normal, where);
      step.moves.push_back(press(aim.surface_m - plan_.depth_m * aim.normal, speed_m_s, where));
    }
    const std::optional<StiffnessFit> fit = fit_press(aim, step.moves[0], plan_.speed_m_s);
    if (!fit) {
      throw Error(ExitCode::kRefused, "no-contact", "the specimen was not felt at " + where,
                  "scan with a smaller cell_m, or give \"friction\": false in the plan");
    }
    // Along u at the first site, along v at the next.
    const Eigen::Vector3d& side = site % 2 == 0 ? plan_.u : plan_.v;
    const Eigen::Vector3d along = (side - side.dot(aim.normal) * aim.normal).normalized();
    const Eigen::Vector3d half_m = plan_.stroke_m / 2 * along;
    const Eigen::Vector3d before_m = aim.surface_m + near_m() * aim.normal - half_m;
    travel_over(shape, before_m, where);
    step.moves.push_back(measure(order_to(before_m + 2 * half_m, plan_.slow_stroke_m_s, false), where));
    step.moves.push_back(measure(order_to(before_m, plan_.fast_stroke_m_s, true), where));
    travel(before_m, where);
    for (const double part : kLoads) {
      const double force_N = part * plan_.force_limit_N;
      // The arm holds its set point by a spring.
      const double set_m =
          fit->contact_m + depth_of(*fit, force_N) + force_N / static_cast<double>(link::kMoveStiffness_N_m);
      loaded_strokes(aim.surface_m - set_m * aim.normal - half_m, 2 * half_m, where, step);
      travel(before_m, where);
    }
    return step;
  }

 private:
  [[nodiscard]] double near_m() const { return std::min(plan_.clearance_m, kNear_m); }

  // The depth in which the springs exert this force.
  static double depth_of(const StiffnessFit& fit, double force_N) {
    double low_m = 0, high_m = fit.depth_m;
    for (int i = 0; i < 40; ++i) {
      const double middle_m = (low_m + high_m) / 2;
      (fit.force_N(middle_m) < force_N ? low_m : high_m) = middle_m;
    }
    return low_m;
  }

  // Down to begin_m, and along way_m and back.
  void loaded_strokes(const Eigen::Vector3d& begin_m, const Eigen::Vector3d& way_m, const std::string& where,
                      ProbedStep& step) {
    const Probe::Result down = probe_.move(order_to(begin_m, plan_.speed_m_s, false));
    if (down.state.end != MoveEnd::kTargetReached && down.state.end != MoveEnd::kForceReached)
      stopped(where, down.state.end);
    bool loaded = down.state.end == MoveEnd::kTargetReached;  // otherwise the arm went back
    for (const Stroke kind : {Stroke::kSlowOut, Stroke::kSlowBack, Stroke::kFast}) {
      ProbedMove move;
      move.force_limit = true;
      if (loaded) {
        const bool fast = kind == Stroke::kFast;
        move = measure(order_to(kind == Stroke::kSlowBack ? begin_m : Eigen::Vector3d(begin_m + way_m),
                                fast ? plan_.fast_stroke_m_s : plan_.slow_stroke_m_s, fast),
                       where);
        // A slow stroke that meets the limit goes back to where it began; the others still have their way.
        loaded = !move.force_limit;
      }
      step.moves.push_back(std::move(move));
    }
  }

  ProbedMove press(const Eigen::Vector3d& target_m, double speed_m_s, const std::string& where) {
    return measure(order_to(target_m, speed_m_s, true), where);
  }

  ProbedMove measure(const link::MoveOrder& order, const std::string& where) {
    const Probe::Result result = probe_.move(order);
    if (result.state.end != MoveEnd::kTargetReached && result.state.end != MoveEnd::kForceReached)
      stopped(where, result.state.end);
    ProbedMove move;
    move.force_limit = result.state.end == MoveEnd::kForceReached;
    move.peak_force_N = static_cast<double>(result.state.peak_force_N);
    move.turn_m =
        Eigen::Vector3f(result.state.turn_x_m, result.state.turn_y_m, result.state.turn_z_m).cast<double>();
    for (const link::MoveSample& sample : result.samples) {
      move.samples.push_back({sample.phase == link::MovePhase::kGoing,
                              Eigen::Vector3f(sample.tip_x_m, sample.tip_y_m, sample.tip_z_m).cast<double>(),
                              static_cast<double>(sample.force_N)});
    }
    return move;
  }

  void travel(const Eigen::Vector3d& target_m, const std::string& where) {
    const Probe::Result there = probe_.move(order_to(target_m, plan_.travel_speed_m_s, false));
    if (there.state.end != MoveEnd::kTargetReached) stopped(where, there.state.end);
    at_m_ = target_m;
  }

  // Straight, or over the specimen where the straight way comes near it.
  void travel_over(const ScannedShape& shape, const Eigen::Vector3d& target_m, const std::string& where) {
    if (!at_m_) {  // the scan goes on: from wherever the arm is
      travel(target_m + plan_.clearance_m * plan_.normal(), where);
    } else {
      double least_m = near_m(), highest_m = -1e9;
      const Eigen::Vector3d up = plan_.normal();
      for (int i = 0; i <= kWayPlaces; ++i) {
        const Eigen::Vector3d on_way_m = *at_m_ + (target_m - *at_m_) * i / kWayPlaces;
        least_m = std::min(least_m, -shape.depth_m(on_way_m));
        highest_m = std::max(highest_m, (on_way_m - plan_.origin_m).dot(up) - shape.above_m(on_way_m));
      }
      if (least_m < kFree * near_m()) {
        const double top_m = highest_m + near_m();
        const auto raised = [&](const Eigen::Vector3d& from_m) {
          return Eigen::Vector3d(from_m + std::max(top_m - (from_m - plan_.origin_m).dot(up), 0.0) * up);
        };
        travel(raised(*at_m_), where);
        travel(raised(target_m), where);
      }
    }
    travel(target_m, where);
  }

  [[nodiscard]] link::MoveOrder order_to(const Eigen::Vector3d& target_m, double speed_m_s,
                                         bool come_back) const {
    link::MoveOrder order;
    order.arm = plan_.arm;
    order.come_back = come_back;
    order.target_x_m = static_cast<float>(target_m.x());
    order.target_y_m = static_cast<float>(target_m.y());
    order.target_z_m = static_cast<float>(target_m.z());
    order.speed_m_s = static_cast<float>(speed_m_s);
    order.force_limit_N = static_cast<float>(plan_.force_limit_N);
    return order;
  }

  [[noreturn]] static void stopped(const std::string& where, MoveEnd end) {
    const bool met = end == MoveEnd::kForceReached || end == MoveEnd::kBlocked;
    throw Error(ExitCode::kRefused, met ? "in-the-way" : "stopped",
                (met ? "something is in the arm's way at " : "the arm was stopped at ") + where,
                "clear the way (clearance_m, origin_m of the plan), arm again and go on with --resume");
  }

  const ScanPlan& plan_;
  Probe& probe_;
  std::optional<Eigen::Vector3d> at_m_;  // where it was sent last
};

// The steps of one kind; false: go_on() ended the scan.
struct Scan {
  const ScanPlan& plan;
  ScanLog& log;
  const std::function<Probe&()>& probe;
  const std::function<bool(std::size_t)>& go_on;
  std::optional<Prober> prober = std::nullopt;

  Prober& moves() {
    if (!prober) prober.emplace(plan, probe());
    return *prober;
  }

  bool points() {
    for (std::size_t point = 0; point < plan.points(); ++point) {
      if (log.find(point) != nullptr) continue;
      if (!go_on(point)) return false;
      log.append(moves().press_along_approach(point));
    }
    return true;
  }

  bool leaning_points() {
    const std::size_t done = log.steps().back().step;
    const ScannedShape shape(plan, approach_contacts(plan, log));
    for (std::size_t point = 0; point < plan.points(); ++point) {
      const std::size_t step = plan.points() + point;
      const std::optional<Aim> aim = step > done ? aim_at(plan, shape, point) : std::nullopt;
      if (!aim) continue;
      if (!go_on(step)) return false;
      log.append(moves().press_along_normal(point, shape, *aim));
    }
    return true;
  }

  bool sites() {
    if (plan.sites().empty()) return true;
    const ScannedShape shape(plan, best_contacts(plan, log));
    for (std::size_t step = 2 * plan.points(); step < plan.steps(); ++step) {
      if (log.find(step) != nullptr) continue;
      if (!go_on(step)) return false;
      log.append(moves().probe_site(step - 2 * plan.points(), shape));
    }
    return true;
  }
};

}  // namespace

bool probe_steps(const ScanPlan& plan, ScanLog& log, const std::function<Probe&()>& probe,
                 const std::function<bool(std::size_t)>& go_on) {
  Scan scan{plan, log, probe, go_on};
  return scan.points() && scan.leaning_points() && scan.sites();
}

}  // namespace thimble::host
