// Scenes with bodies, written as in a scene file, and fingertips that follow given positions exactly.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/scene.h"

namespace thimble::test {

using Eigen::Vector3d;

// `objects` and what else the scene has, as JSON without the outer braces.
inline SceneImage scene_of(const std::string& members) {
  return SceneImage(host::compile_scene_text(R"({"thimble_scene": 1, "name": "test", )" + members + "}",
                                             "test.scene.json", ".")
                        .image);
}

inline constexpr const char* kGravity = R"("gravity_m_s2": [0, 0, -9.81], )";

// As a scene file has it.
inline std::string list(const Vector3d& v) {
  std::string text("[");
  for (int i = 0; i < 3; ++i) text.append(i == 0 ? "" : ", ").append(std::to_string(v[i]));
  return text.append("]");
}

class BodyRun {
 public:
  explicit BodyRun(const std::string& members, std::vector<Vector3d> tips = {}, double rate_Hz = 4000.0)
      : image_(scene_of(members)), period_s_(1.0 / rate_Hz), tips_(std::move(tips)) {
    renderer_.bind(image_.view());
  }

  // One tick with every tip where it is said to be; a tip's velocity is its step.
  void tick(const std::vector<Vector3d>& tips) {
    std::array<control::Tip, control::kMaxArms> in;
    for (std::size_t i = 0; i < tips.size(); ++i) {
      in[i].position_m = tips[i].cast<float>();
      in[i].velocity_m_s = ((tips[i] - tips_[i]) / period_s_).cast<float>();
    }
    tips_ = tips;
    before_.assign(renderer_.bodies().begin(), renderer_.bodies().end());
    renderer_.tick(std::span(in).first(tips.size()), static_cast<float>(period_s_), touches_);
    time_s_ += period_s_;
  }
  void tick() { tick(tips_); }
  void run(double seconds) {
    for (const double end = time_s_ + seconds - .5 * period_s_; time_s_ < end;) tick();
  }

  [[nodiscard]] const std::vector<Vector3d>& tips() const { return tips_; }
  [[nodiscard]] Vector3d force_N(std::size_t finger) const {
    return touches_.at(finger).force_N.cast<double>();
  }
  [[nodiscard]] Vector3d god_m(std::size_t finger) const {
    return touches_.at(finger).god_object_m.cast<double>();
  }
  [[nodiscard]] int contacts(std::size_t finger) const { return touches_.at(finger).contacts; }

  [[nodiscard]] const control::BodyState& body(std::size_t i) const { return renderer_.bodies()[i]; }
  // As it was when the fingers of the last tick touched it.
  [[nodiscard]] const control::BodyState& before(std::size_t i) const { return before_.at(i); }
  [[nodiscard]] Vector3d position_m(std::size_t i) const { return body(i).position_m.cast<double>(); }
  [[nodiscard]] Vector3d velocity_m_s(std::size_t i) const { return body(i).velocity_m_s.cast<double>(); }
  [[nodiscard]] Eigen::Quaterniond rotation(std::size_t i) const { return body(i).rotation.cast<double>(); }
  [[nodiscard]] double period_s() const { return period_s_; }
  [[nodiscard]] double time_s() const { return time_s_; }
  [[nodiscard]] const control::Renderer& renderer() const { return renderer_; }
  void bound_work(std::uint32_t units) { renderer_.bound_work(units); }

 private:
  SceneImage image_;
  control::Renderer renderer_;
  double period_s_;
  double time_s_ = 0;
  std::vector<Vector3d> tips_;
  std::array<control::Touch, control::kMaxArms> touches_;
  std::vector<control::BodyState> before_;
};

}  // namespace thimble::test
