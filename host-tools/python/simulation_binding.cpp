#include "host-tools/python/simulation_binding.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "board/sim/stepped_simulation.h"
#include "host-tools/error.h"
#include "host-tools/lab/simulation_run.h"
#include "host-tools/python/arm_binding.h"
#include "host-tools/python/binding.h"

namespace py = pybind11;

namespace thimble::host {
namespace {

struct SimulationRow {
  double time_s;
  std::int32_t arm;
  std::int32_t contacts;
  std::array<double, 3> tip_m;
  std::array<double, 3> proxy_m;
  std::array<double, 3> force_N;
};

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

py::dtype dtype_of(const SceneColumns& scene) {
  py::list fields;
  const py::dtype fixed = py::dtype::of<SimulationRow>();
  for (const py::handle name : fixed.attr("names"))
    fields.append(py::make_tuple(name, fixed.attr("fields")[name][py::int_(0)]));
  for (const SceneField& field : scene.fields()) {
    if (field.columns.size() == 1)
      fields.append(py::make_tuple(field.name, "f8"));
    else
      fields.append(py::make_tuple(field.name, "f8", py::make_tuple(field.columns.size())));
  }
  return py::dtype::from_args(fields);
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<board::PathPoint> path_of(const Numbers& path) {
  const auto columns = path.ndim() == 2 ? path.shape(1) : 0;
  if (columns != 4 && columns != 5)
    throw py::value_error("a path has rows of time_s, x_m, y_m, z_m and, for two arms, arm");
  std::vector<board::PathPoint> points;
  const auto rows = path.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    board::PathPoint point;
    point.time_s = rows(i, 0);
    point.position_m = {rows(i, 1), rows(i, 2), rows(i, 3)};
    if (columns == 5) point.arm = static_cast<int>(rows(i, 4));
    points.push_back(point);
  }
  return points;
}

board::SimulationOptions options_of(double rate_Hz, const GivenArm& arm, bool ideal, std::uint64_t seed,
                                    std::uint8_t trial) {
  board::SimulationOptions options;
  options.rate_Hz = rate_Hz;
  choose_arm(arm, options);
  options.ideal = ideal;
  options.seed = seed;
  options.trial = trial;
  return options;
}

py::array simulate(const py::bytes& image, const std::variant<std::filesystem::path, Numbers>& path,
                   double rate_Hz, const GivenArm& arm, bool ideal, std::uint64_t seed, std::uint8_t trial) {
  ImageFile scene{bytes_of(image), {}, {}};
  const auto* const given = std::get_if<Numbers>(&path);
  const SimulationRun run = given != nullptr
                                ? SimulationRun(std::move(scene), path_of(*given))
                                : SimulationRun(std::move(scene), std::get<std::filesystem::path>(path));
  const board::SimulationOptions options = options_of(rate_Hz, arm, ideal, seed, trial);
  const SceneColumns columns(run.image());
  SimulationRows rows(columns);
  {
    const py::gil_scoped_release others;
    throw_if_failed(run.go(options, [&rows](const board::LogRow& row) {
      rows.add(row);
      if (rows.count() % kHeedRows == 0) heed_python();
    }));
  }
  return rows.to_numpy();
}

// A run whose hands get their next points from the caller.
class Simulation {
 public:
  // starts: a point for each arm.
  Simulation(const py::bytes& image, const Numbers& starts, double rate_Hz, const GivenArm& arm, bool ideal,
             std::uint64_t seed, std::uint8_t trial)
      : arms_(arms_of(starts)),
        scene_(bytes_of(image)),
        columns_(scene_),
        rows_(columns_),
        run_(open(scene_, options_of(rate_Hz, arm, ideal, seed, trial), starts)) {
    for (std::size_t arm_index = 0; arm_index < arms_; ++arm_index)
      refuse_out_of_reach(arm_index, point_of(starts, 0, arm_index));
    const py::gil_scoped_release others;
    throw_if_failed(run_->begin());
  }

  // targets: n x 3 for each arm; each is reached in so many ticks, on a straight line. Their rows.
  py::array advance(const Numbers& targets, std::uint32_t ticks_each) {
    if (ticks_each == 0) throw py::value_error("a step has one tick or more");
    if (targets.ndim() != 3 || targets.shape(2) != 3 || static_cast<std::size_t>(targets.shape(1)) != arms_)
      throw py::value_error("a target has x_m, y_m, z_m for each arm");
    throw_if_failed(run_->result());  // it has tripped before
    for (py::ssize_t i = 0; i < targets.shape(0); ++i)
      for (std::size_t arm = 0; arm < arms_; ++arm) refuse_out_of_reach(arm, point_of(targets, i, arm));
    rows_.clear();
    {
      const py::gil_scoped_release others;
      for (py::ssize_t i = 0; i < targets.shape(0); ++i) {
        const double end_s = run_->time_of(run_->result().ticks + ticks_each);
        for (std::size_t arm = 0; arm < arms_; ++arm)
          run_->extend(arm, {end_s, point_of(targets, i, arm), static_cast<int>(arm)});
        for (std::uint32_t tick = 0; tick < ticks_each; ++tick) run_one_tick();
      }
    }
    return rows_.to_numpy();
  }

  // The columns are those of the first scene, so the objects that move have to be the same.
  void load(const py::bytes& image) {
    std::vector<std::byte> next = bytes_of(image);
    const SceneColumns columns(next);
    const auto same = [](const SceneField& a, const SceneField& b) { return a.name == b.name; };
    if (!std::ranges::equal(columns.fields(), columns_.fields(), same))
      throw py::value_error("the scene has other moving objects or tissues: begin another Sim");
    const board::SimulationResult loaded = run_->load(next);
    throw_if_failed(loaded);
    scene_ = std::move(next);
    columns_ = SceneColumns(scene_);
  }

  std::uint64_t set_trial(std::uint8_t trial) { return run_->mark(firmware::link::MarkKind::kTrial, trial); }
  std::uint64_t event(std::uint16_t code) { return run_->mark(firmware::link::MarkKind::kEvent, code); }

  [[nodiscard]] std::uint64_t ticks() const { return run_->result().ticks; }

 private:
  static std::size_t arms_of(const Numbers& starts) {
    if (starts.ndim() != 3 || starts.shape(0) != 1 || starts.shape(2) != 3 || starts.shape(1) < 1 ||
        starts.shape(1) > 2)
      throw py::value_error("a start has x_m, y_m, z_m for one arm or two");
    return static_cast<std::size_t>(starts.shape(1));
  }
  static Eigen::Vector3d point_of(const Numbers& points, py::ssize_t i, std::size_t arm) {
    const double* at = points.data() + (i * points.shape(1) + static_cast<py::ssize_t>(arm)) * 3;
    return {at[0], at[1], at[2]};
  }
  static std::unique_ptr<board::SteppedSimulation> open(std::span<const std::byte> image,
                                                        const board::SimulationOptions& options,
                                                        const Numbers& starts) {
    throw_if_failed(board::checked(options));
    std::vector<board::HandPath> paths;
    for (std::size_t arm = 0; arm < arms_of(starts); ++arm) {
      const Eigen::Vector3d at = point_of(starts, 0, arm);
      if (!at.allFinite()) throw py::value_error("a number of the start is not finite");
      paths.emplace_back(std::vector<board::PathPoint>{{0.0, at, static_cast<int>(arm)}});
    }
    return std::make_unique<board::SteppedSimulation>(image, options, std::move(paths));
  }
  void refuse_out_of_reach(std::size_t arm, const Eigen::Vector3d& at) const {
    if (!at.allFinite()) throw py::value_error("a number of the target is not finite");
    if (run_->reaches(arm, at)) return;
    throw Error(ExitCode::kBadInput, "out-of-reach",
                "(" + std::to_string(at.x()) + ", " + std::to_string(at.y()) + ", " + std::to_string(at.z()) +
                    ") m is outside the workspace of arm " + std::to_string(arm),
                "keep the hand inside the arm's workspace, or use ideal=True");
  }
  void run_one_tick() {
    run_->tick([this](const board::LogRow& row) { rows_.add(row); });
    if (rows_.count() % kHeedRows == 0) heed_python();
    throw_if_failed(run_->result());
  }

  std::size_t arms_;
  std::vector<std::byte> scene_;
  SceneColumns columns_;
  SimulationRows rows_;
  std::unique_ptr<board::SteppedSimulation> run_;
};

}  // namespace

SimulationRows::SimulationRows(const SceneColumns& scene) : scene_(scene), dtype_(dtype_of(scene)) {}

void SimulationRows::add(const board::LogRow& row) {
  const SimulationRow fixed{
      row.time_s, row.arm, row.contacts, to_array(row.tip_m), to_array(row.proxy_m), to_array(row.force_N)};
  const auto append = [this](std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  };
  append(std::as_bytes(std::span(&fixed, 1)));
  append(std::as_bytes(scene_.values(row)));
  ++count_;
}

void bind_simulation(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(SimulationRow, time_s, arm, contacts, tip_m, proxy_m, force_N);
  m.def("simulate", &simulate);
  py::class_<Simulation>(m, "Simulation")
      .def(py::init<const py::bytes&, const Numbers&, double, const GivenArm&, bool, std::uint64_t,
                    std::uint8_t>())
      .def("advance", &Simulation::advance)
      .def("load", &Simulation::load)
      .def("set_trial", &Simulation::set_trial)
      .def("event", &Simulation::event)
      .def_property_readonly("ticks", &Simulation::ticks);
}

}  // namespace thimble::host
