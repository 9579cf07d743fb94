// thimble._thimble.Arm: an arm by name, file or image.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <variant>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/arms/arm_pose.h"
#include "host-tools/lab/arm_choice.h"

namespace thimble::host {

class PyArm {
 public:
  explicit PyArm(const std::string& given) : given_(given), choice_(chosen_arm(given)), pose_(choice_.data) {}

  [[nodiscard]] const ArmChoice& choice() const { return choice_; }
  [[nodiscard]] const std::string& given() const { return given_; }
  [[nodiscard]] pybind11::list axes() const;
  [[nodiscard]] pybind11::dict limits() const;

  // axes: rad, m. ValueError: not as many as the arm has, or its links do not meet there.
  [[nodiscard]] pybind11::array_t<double> tip_m(const std::vector<double>& axes);
  [[nodiscard]] pybind11::array_t<double> jacobian(const std::vector<double>& axes);
  [[nodiscard]] pybind11::array_t<double> rotation(const std::vector<double>& axes);
  [[nodiscard]] pybind11::list links(const std::vector<double>& axes);

 private:
  void move_to(const std::vector<double>& axes);

  std::string given_;
  ArmChoice choice_;
  ArmPose pose_;
};

// The arm of a simulation: an Arm, or what names one. ValueError: None.
using GivenArm = std::variant<const PyArm*, std::string>;
void choose_arm(const GivenArm& arm, board::SimulationOptions& options);

void bind_arm(pybind11::module_& m);

}  // namespace thimble::host
