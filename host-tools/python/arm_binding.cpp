#include "host-tools/python/arm_binding.h"

#include "board/sim/plant.h"

namespace py = pybind11;

namespace thimble::host {

py::list PyArm::axes() const {
  py::list all;
  for (std::size_t j = 0; j < pose_.axes(); ++j) {
    const kinematics::AxisData& axis = choice_.data.axis.at(j);
    py::dict one;
    one["name"] = axis.name.data();
    one["prismatic"] = axis.prismatic;
    one["driven"] = choice_.data.geometry.driven.at(j);
    one["lower"] = axis.lower;
    one["upper"] = axis.upper;
    one["home"] = choice_.data.geometry.home[static_cast<Eigen::Index>(j)];
    one["per_count"] = axis.rad_per_count();
    all.append(one);
  }
  return all;
}

py::dict PyArm::limits() const {
  py::dict limits;
  limits["max_force_N"] = choice_.data.max_force_N;
  limits["max_joint_speed_rad_s"] = choice_.data.max_joint_speed_rad_s;
  limits["tip_stiffness_N_m"] = choice_.data.tip_stiffness_N_m;
  limits["supply_V"] = choice_.data.supply_V;
  py::list walls;
  for (const HeldWall& wall : choice_.walls.walls)
    walls.append(py::make_tuple(wall.rate_Hz, wall.damping_N_s_m, wall.stiffness_N_m));
  limits["largest_walls"] = walls;
  return limits;
}

py::array_t<double> PyArm::tip_m(const std::vector<double>& axes) {
  move_to(axes);
  return py::array_t<double>(3, pose_.tip_m().data());
}

py::array_t<double> PyArm::jacobian(const std::vector<double>& axes) {
  move_to(axes);
  const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> by_rows(pose_.jacobian().topRows<3>());
  return py::array_t<double>({by_rows.rows(), by_rows.cols()}, by_rows.data());
}

py::array_t<double> PyArm::rotation(const std::vector<double>& axes) {
  move_to(axes);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> by_rows(pose_.rotation());
  return py::array_t<double>({3, 3}, by_rows.data());
}

py::list PyArm::links(const std::vector<double>& axes) {
  move_to(axes);
  py::list all;
  for (const ArmPose::Line& line : pose_.links())
    all.append(py::array_t<double>({line.size(), std::size_t{3}}, line.front().data()));
  return all;
}

void PyArm::move_to(const std::vector<double>& axes) {
  if (axes.size() != pose_.axes())
    throw py::value_error("the arm has " + std::to_string(pose_.axes()) + " axes");
  if (!pose_.move_to(axes)) throw py::value_error("the links do not meet there, or the arm is singular");
}

void choose_arm(const GivenArm& arm, board::SimulationOptions& options) {
  const auto* const known = std::get_if<const PyArm*>(&arm);
  if (known == nullptr) {
    options.arm = std::get<std::string>(arm);
    options.arm_data = other_arm(options.arm);
    return;
  }
  if (*known == nullptr) throw py::value_error("None is no arm");
  options.arm = (*known)->given();
  // A simulated arm that is built in has its own plant.
  if (board::find_plant_variant(options.arm) == nullptr) options.arm_data = (*known)->choice().data;
}

void bind_arm(py::module_& m) {
  py::class_<PyArm>(m, "Arm")
      .def(py::init<const std::string&>())
      .def_property_readonly("name", [](const PyArm& arm) { return arm.choice().name; })
      .def_property_readonly("commissioned", [](const PyArm& arm) { return arm.choice().data.commissioned; })
      .def_property_readonly("axes", &PyArm::axes)
      .def_property_readonly("limits", &PyArm::limits)
      .def("tip_m", &PyArm::tip_m)
      .def("jacobian", &PyArm::jacobian)
      .def("rotation", &PyArm::rotation)
      .def("links", &PyArm::links);
}

}  // namespace thimble::host
