// The scenes `sliders` and `buttons` along their strokes: every control element is operated and works.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "board/sim/hand_path_file.h"
#include "board/sim/simulation.h"
#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"
#include "tests/support/units.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

struct Moment {
  double time_s;
  Vector3d tip_m;
  Vector3d force_N;
};

struct Travel {
  std::vector<double> q;  // one a tick
  int ons = 0;
  int offs = 0;
  [[nodiscard]] double least() const { return *std::min_element(q.begin(), q.end()); }
  [[nodiscard]] double most() const { return *std::max_element(q.begin(), q.end()); }
  [[nodiscard]] double last() const { return q.back(); }
};

// A scene played by its own hand: through the firmware and the simulated arm, or by the tip that is on the
// path exactly.
class Played {
 public:
  Played(const std::string& name, bool ideal, double rate_Hz = 4000.0) {
    const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes" / name;
    const std::vector<std::byte> bytes = host::compile_scene(folder / (name + ".scene.json")).image;
    const std::vector<board::PathPoint> path = board::read_hand_path(folder / "stroke.csv");
    const board::SimulationResult result =
        board::simulate(bytes, path, {.ideal = ideal, .rate_Hz = rate_Hz}, [&](const board::LogRow& row) {
          moments.push_back({row.time_s, row.tip_m, row.force_N});
        });
    EXPECT_EQ(result.status, board::SimulationStatus::kOk) << result.detail;
    EXPECT_EQ(result.bounds.sweep_bound + result.bounds.slide_bound, 0U);
    // The same tip once more through a renderer that can be asked where its bodies are.
    const SceneImage image(bytes);
    control::Renderer renderer;
    renderer.bind(image.view());
    std::array<control::Tip, 1> tips;
    std::array<control::Touch, 1> touches;
    std::vector<bool> was(renderer.bodies().size());
    for (std::size_t i = 0; i < was.size(); ++i) was[i] = renderer.bodies()[i].on;
    for (std::size_t k = 0; k < moments.size(); ++k) {
      const Vector3d step = k > 0 ? Vector3d(moments[k].tip_m - moments[k - 1].tip_m) : Vector3d::Zero();
      tips[0].position_m = moments[k].tip_m.cast<float>();
      tips[0].velocity_m_s = (step * rate_Hz).cast<float>();
      renderer.tick(tips, static_cast<float>(1.0 / rate_Hz), touches);
      for (std::size_t i = 0; i < was.size(); ++i) {
        const control::BodyState& body = renderer.bodies()[i];
        const auto* object = image.view().scene()->objects()->Get(body.object);
        Travel& travel = travels[object->name()->str()];
        travel.q.push_back(static_cast<double>(body.q));
        travel.ons += body.on && !was[i] ? 1 : 0;
        travel.offs += !body.on && was[i] ? 1 : 0;
        was[i] = body.on;
      }
    }
  }

  [[nodiscard]] double peak_N() const {
    double peak = 0;
    for (const Moment& m : moments) peak = std::max(peak, m.force_N.norm());
    return peak;
  }
  [[nodiscard]] const Travel& of(const std::string& name) const { return travels.at(name); }

  std::vector<Moment> moments;
  std::map<std::string, Travel> travels;
};

std::string mode(bool ideal) { return ideal ? "exact tip: " : "simulated arm: "; }

// Ideally and through the arm; under the sanitizers the arm is left to the last test of this file.
std::vector<bool> played_ways() { return kUnderSanitizers ? std::vector{true} : std::vector{true, false}; }

TEST(ScenesOfControls, SlidersArePushedAsideAndComeBack) {
  for (const bool ideal : played_ways()) {
    const Played played("sliders", ideal);
    ASSERT_EQ(played.travels.size(), 4U);
    for (const auto& [name, travel] : played.travels) {
      figure(mode(ideal) + name + " pushed aside by, mm", 1e3 * travel.most(), "> 7");
      EXPECT_GT(travel.most(), .007) << name;
      EXPECT_NEAR(travel.last(), 0, 1e-3) << name;
    }
    // Let go, the light ones swing through the centre, and the one in honey never does.
    figure(mode(ideal) + "soft slider swings beyond its centre by, mm",
           -1e3 * played.of("soft slider").least(), "> 3");
    EXPECT_LT(played.of("soft slider").least(), -.003);
    EXPECT_LT(played.of("medium slider").least(), -.003);
    EXPECT_LT(played.of("stiff slider").least(), -.003);
    EXPECT_GT(played.of("slider in honey").least(), -1e-3);
    figure(mode(ideal) + "peak force, N", played.peak_N(), "< 8");
    EXPECT_LT(played.peak_N(), 8);
  }
}

TEST(ScenesOfControls, SlidersPushBackInProportionToTheirSpring) {
  // While the hand holds still, the force along x is the slider's spring: the stiffness from force and way.
  const Played played("sliders", true);
  const std::map<std::string, double> stiffness_N_m{
      {"soft slider", 40}, {"medium slider", 100}, {"stiff slider", 250}, {"slider in honey", 100}};
  for (const auto& [name, expected] : stiffness_N_m) {
    const std::vector<double>& q = played.of(name).q;
    // The last tick of the hold: the hand goes off over the top right after the longest rest at the far end.
    const auto far = static_cast<std::size_t>(std::max_element(q.begin(), q.end()) - q.begin());
    std::size_t held = far;
    while (held + 1 < q.size() && (played.moments[held + 1].tip_m - played.moments[held].tip_m).norm() < 1e-9)
      ++held;
    const double felt = -played.moments[held].force_N.x() / q[held];
    figure(name + ": stiffness felt, N/m", felt, std::to_string(expected) + " +- 3 %");
    EXPECT_NEAR(felt, expected, .03 * expected) << name;
  }
}

TEST(ScenesOfControls, EveryControlOfThePanelIsOperated) {
  for (const bool ideal : played_ways()) {
    const Played played("buttons", ideal);
    ASSERT_EQ(played.travels.size(), 8U);
    for (const char* name : {"click button", "hard button", "soft button", "toggle"}) {
      EXPECT_EQ(played.of(name).ons, 1) << mode(ideal) << name;
      EXPECT_EQ(played.of(name).offs, 1) << mode(ideal) << name;
    }
    for (const char* name : {"click button", "hard button", "soft button"})
      EXPECT_NEAR(played.of(name).last(), 0, 1e-5) << mode(ideal) << name;
    EXPECT_NEAR(played.of("toggle").most(), 40 * kDegree, .01) << mode(ideal);
    EXPECT_NEAR(played.of("toggle").last(), 0, 1e-4) << mode(ideal);
    const auto notches = [&](const std::string& name, double pitch, double turns, double tolerance) {
      const double at = played.of(name).last() / pitch;
      figure(mode(ideal) + name + " left at notch", at, "at least " + std::to_string(turns) + ", whole");
      EXPECT_GT(at, turns - .1) << mode(ideal) << name;
      EXPECT_NEAR(at, std::round(at), tolerance) << mode(ideal) << name;
    };
    // Friction keeps a knob a little off the middle of a notch.
    notches("rotary switch", 30 * kDegree, 2, .03);
    notches("knob", 15 * kDegree, 4, .03);
    notches("dial", 20 * kDegree, 3, .05);
    notches("fader", .005, 4, .06);
    EXPECT_EQ(played.of("rotary switch").ons, 1) << mode(ideal);
    figure(mode(ideal) + "peak force, N", played.peak_N(), "< 8");
    EXPECT_LT(played.peak_N(), 8);
  }
}

TEST(ScenesOfControls, ThePanelWorksAtOtherRatesToo) {
  for (const double rate_Hz : kUnderSanitizers ? std::vector{1000.0} : std::vector{1000.0, 10000.0}) {
    const Played played("buttons", true, rate_Hz);
    for (const char* name : {"click button", "hard button", "soft button", "toggle"}) {
      EXPECT_EQ(played.of(name).ons, 1) << rate_Hz << " Hz: " << name;
      EXPECT_EQ(played.of(name).offs, 1) << rate_Hz << " Hz: " << name;
    }
    const double notch = played.of("knob").last() / (15 * kDegree);
    figure("knob left at notch, ticks at " + std::to_string(rate_Hz) + " Hz", notch, "whole");
    EXPECT_NEAR(notch, std::round(notch), .03);
    EXPECT_LT(played.peak_N(), 8);
  }
}

TEST(ScenesOfControls, TheClickIsFeltThroughTheArm) {
  const Played played("buttons", false);
  // The first press: pushing down on the click button, at the far left.
  double peak_N = 0, after_N = 1e9, peak_at_s = 0, bottom_at_s = 0;
  for (const Moment& m : played.moments) {
    if (m.tip_m.x() > -.08) continue;
    const double force_N = m.force_N.z();
    const bool snapped = peak_N - force_N > .3 && peak_N > 1;
    if (after_N > 1e8 && !snapped && force_N > peak_N) {
      peak_N = force_N;
      peak_at_s = m.time_s;
    } else if ((snapped || after_N < 1e8) && m.time_s < peak_at_s + .05 && force_N < after_N) {
      after_N = force_N;
      bottom_at_s = m.time_s;
    }
  }
  figure("simulated arm: force at which the button snaps, N", peak_N, "2.0 +- 10 %");
  figure("simulated arm: force lost in the snap, N", peak_N - after_N, "> 0.5");
  figure("simulated arm: the snap takes, ms", 1e3 * (bottom_at_s - peak_at_s), "< 50");
  EXPECT_NEAR(peak_N, 2.0, .2);
  EXPECT_GT(peak_N - after_N, .5);
}

}  // namespace
}  // namespace thimble::test
