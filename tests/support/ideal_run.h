// The renderer in open loop: a fingertip follows given positions exactly, without an arm.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "control/renderer.h"
#include "tests/support/scene.h"

namespace thimble::test {

inline constexpr double kRate_Hz = 4000.0;

struct Felt {
  Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();  // rounded to float, as given to the renderer
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d god_object_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d ball_m = Eigen::Vector3d::Zero();  // control::Renderer::ball_centre_m()
  int contacts = 0;
  bool inside = false;  // of something that is not felt until the tip has left it
};

// Whether THIMBLE_WORK bounds the work of a tick, in the units of control/work.h. What a test says about falls holds then, too.
[[nodiscard]] bool work_is_bounded();

class IdealRun {
 public:
  explicit IdealRun(const SceneImage& image, double rate_Hz = kRate_Hz);  // the image must outlive the run
  explicit IdealRun(SceneImage&& image, double rate_Hz = kRate_Hz);

  // One tick with the tip at p. Its velocity is the step from the last tick.
  const Felt& step(const Eigen::Vector3d& p);
  // Ticks along the straight line from the present tip to p, at most `step_m` each.
  const Felt& move(const Eigen::Vector3d& p, double step_m);
  // Puts the tip at p without contact, as after a pause; restarts the sums.
  void restart(const Eigen::Vector3d& p);

  [[nodiscard]] const Felt& felt() const { return felt_; }
  [[nodiscard]] control::Renderer& renderer() { return renderer_; }

  // Sums since the start or the last restart().
  [[nodiscard]] double work_on_hand_J() const {
    return work_J_;
  }  // each force is held for the whole tick, as on a device
  [[nodiscard]] double work_mean_force_J() const {
    return work_mean_J_;
  }  // with the mean of the forces at both ends of each step
  [[nodiscard]] double longest_step_m() const { return longest_step_m_; }
  [[nodiscard]] double deepest_m() const { return deepest_m_; }  // |god object - tip|
  [[nodiscard]] double force_variation_N() const {
    return force_variation_N_;
  }  // total variation of the force: sum of |dF|

 private:
  control::Renderer renderer_;
  double period_s_;
  std::optional<SceneImage> own_;
  bool started_ = false;
  Felt felt_;
  double work_J_ = 0;
  double work_mean_J_ = 0;
  double longest_step_m_ = 0;
  double deepest_m_ = 0;
  double force_variation_N_ = 0;
};

}  // namespace thimble::test
