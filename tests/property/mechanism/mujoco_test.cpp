// MuJoCo holds the links of a five-bar and of a delta together by constraints of its own, which are soft: the tip must be where our closed
// form or Newton's method has it.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::kinematics {
namespace {

std::string text(const char* format, auto... values) {
  std::array<char, 2000> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return buffer.data();
}

std::string model_of(const std::string& bodies, const std::string& constraints, int actuators) {
  std::string all = R"(<mujoco><compiler angle="radian" autolimits="true"/>
<option gravity="0 0 0" timestep="0.0002" integrator="implicit"/><size njmax="200"/>
<default><geom contype="0" conaffinity="0" type="sphere" size="0.004" mass="0.01"/><joint damping="0.0005"/>
<equality solref="0.001 1" solimp="0.9999 0.9999 0.001"/></default>
<worldbody>)" + bodies +
                    "</worldbody><equality>" + constraints + "</equality><actuator>";
  for (int j = 0; j < actuators; ++j) all += text(R"(<position name="q%d" joint="q%d" kp="20"/>)", j, j);
  return all + "</actuator></mujoco>";
}

// A model that is closed as it is written; its joints are the changes from there.
class MuJoCo {
 public:
  explicit MuJoCo(const std::string& xml) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "mechanism.xml";
    std::ofstream(file) << xml;
    std::array<char, 1000> error{};
    model_ = mj_loadXML(file.c_str(), nullptr, error.data(), static_cast<int>(error.size()));
    if (model_ == nullptr) throw std::runtime_error(std::string(error.data()) + "\n" + xml);
    data_ = mj_makeData(model_);
  }
  ~MuJoCo() {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MuJoCo(const MuJoCo&) = delete;
  MuJoCo& operator=(const MuJoCo&) = delete;

  // Turns the actuated joints by that much and lets the rest follow; where they are then, and the position of site "tip".
  Vector3d turn(const Eigen::VectorXd& by, Eigen::VectorXd& reached) {
    constexpr int kSteps = 5000;
    for (int i = 0; i < 2 * kSteps; ++i) {
      for (int j = 0; j < static_cast<int>(by.size()); ++j)
        data_->ctrl[j] = std::min(1.0, static_cast<double>(i) / kSteps) * by[j];
      mj_step(model_, data_);
    }
    reached.resize(by.size());
    for (int j = 0; j < static_cast<int>(by.size()); ++j) {
      const int joint = mj_name2id(model_, mjOBJ_JOINT, text("q%d", j).c_str());
      reached[j] = data_->qpos[model_->jnt_qposadr[joint]];
    }
    const int tip = mj_name2id(model_, mjOBJ_SITE, "tip");
    return {data_->site_xpos[3 * tip], data_->site_xpos[3 * tip + 1], data_->site_xpos[3 * tip + 2]};
  }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

TEST(MuJoCo, FindsTheSameTipOfAFiveBar) {
  Random random(4);
  double worst_m = 0, moved_m = 0;
  for (int cases = 0; cases < 6;) {
    Case one;
    if (!some_five_bar_case(random, one)) continue;
    const auto& bars = std::get<FiveBarGeometry>(one.geometry.platform);
    Plate<double, 2> plate;
    const Vector2d q = one.axes, by(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2));
    if (!five_bar<double>(bars, q, plate) || plate.jacobian.norm() > 0.3) continue;
    const Vector3d begin_m = plate.position_m;
    if (!five_bar<double>(bars, q + by, plate) || plate.jacobian.norm() > 0.3) continue;
    ++cases;
    std::string bodies;
    for (int leg = 0; leg < 2; ++leg) {
      const auto at = static_cast<std::size_t>(leg);
      const double base = leg == 0 ? 0.0 : static_cast<double>(bars.base_distance_m);
      const double inner = static_cast<double>(bars.inner_m.at(at));
      const Vector2d out =
          begin_m.head<2>() - Vector2d(base + inner * std::cos(q[leg]), inner * std::sin(q[leg]));
      bodies += text(R"(<body pos="%.12g 0 0" euler="0 0 %.12g"><joint name="q%d" axis="0 0 1"/><geom/>
<body name="outer%d" pos="%.12g 0 0" euler="0 0 %.12g"><joint axis="0 0 1"/><geom/>%s</body></body>)",
                     base, q[leg], leg, leg, inner, std::atan2(out.y(), out.x()) - q[leg],
                     leg == 0 ? text(R"(<site name="tip" pos="%.12g 0 0"/>)", out.norm()).c_str() : "");
    }
    MuJoCo peer(model_of(bodies,
                         text(R"(<connect body1="outer0" body2="outer1" anchor="%.12g 0 0"/>)",
                              static_cast<double>(bars.outer_m[0])),
                         2));
    Eigen::VectorXd reached;
    const Vector3d tip_m = peer.turn(by, reached);
    ASSERT_TRUE(five_bar<double>(bars, q + Vector2d(reached), plate));
    worst_m = std::max(worst_m, (plate.position_m - tip_m).norm());
    moved_m = std::max(moved_m, (tip_m - begin_m).norm());
  }
  test::figure("five-bar: way of the tip, m", moved_m, "> 0.005");
  test::figure("five-bar: tip against MuJoCo, m", worst_m, "1e-5");
  EXPECT_GT(moved_m, 0.005);
  EXPECT_LT(worst_m, 1e-5);
}

// A leg: a thigh, a hinge across it, a link of length e, the shins as one rod that turns square to that hinge, a link of length d that stays
// parallel to the first one, and a hinge at the plate. The plate slides without turning.
std::string leg_of(const DeltaGeometry& geometry, int leg, double q, const Vector3d& plate_m) {
  const auto of = [](float value) { return static_cast<double>(value); };
  const double angle = of(geometry.leg_angle_rad.at(static_cast<std::size_t>(leg)));
  const Vector3d p = Eigen::AngleAxisd(-angle, Vector3d::UnitZ()) * plate_m;
  const double u =
      p.x() - of(geometry.base_u_m) + of(geometry.plate_u_m) - of(geometry.thigh_m) * std::cos(q);
  const double v = p.y() - of(geometry.base_v_m) + of(geometry.plate_v_m);
  const double w = p.z() - of(geometry.thigh_m) * std::sin(q);
  const double lift = std::atan2(w, u);                    // of the plane of the shins, about -y
  const double sway = std::asin(v / of(geometry.shin_m));  // of the shins in it
  // The axis of the thigh is where the plate's end of the leg would be with u = v = w = 0 and no thigh.
  return text(
      R"(<body euler="0 0 %.12g"><body pos="%.12g %.12g 0" euler="0 %.12g 0"><joint name="q%d" axis="0 -1 0"/><geom/>
<body pos="%.12g 0 0" euler="0 %.12g 0"><joint axis="0 -1 0"/><geom/>
<body pos="%.12g 0 0" euler="0 0 %.12g"><joint name="sway%d" axis="0 0 1"/><geom/>
<body name="end%d" pos="%.12g 0 0" euler="0 0 %.12g"><joint name="back%d" axis="0 0 1"/><geom/>
</body></body></body></body></body>)",
      angle, of(geometry.base_u_m) - of(geometry.plate_u_m), of(geometry.base_v_m) - of(geometry.plate_v_m),
      -q, leg, of(geometry.thigh_m), q - lift, of(geometry.knee_end_m), sway, leg, leg, of(geometry.shin_m),
      -sway, leg);
}

TEST(MuJoCo, FindsTheSamePlateOfADelta) {
  Random random(5);
  double worst_m = 0, moved_m = 0;
  for (int cases = 0; cases < 6; ++cases) {
    Vector3d begin_m, end_m;
    const Case one = some_delta_case(random, begin_m);
    const auto& geometry = std::get<DeltaGeometry>(one.geometry.platform);
    const Delta<double> delta(geometry);
    Vector3d target;
    do {
      end_m = some_place(random);
    } while (!delta.inverse(end_m, target));
    std::string bodies = text(
        R"(<body name="plate" pos="%.12g %.12g %.12g"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
<joint type="slide" axis="0 0 1"/><geom/><site name="tip"/></body>)",
        begin_m.x(), begin_m.y(), begin_m.z());
    std::string constraints;
    for (int leg = 0; leg < 3; ++leg) {
      bodies += leg_of(geometry, leg, one.axes[leg], begin_m);
      constraints += text(R"(<connect body1="end%d" body2="plate" anchor="%.12g 0 0"/>
<joint joint1="back%d" joint2="sway%d" polycoef="0 -1 0 0 0"/>)",
                          leg, static_cast<double>(geometry.shin_end_m), leg, leg);
    }
    MuJoCo peer(model_of(bodies, constraints, 3));
    Eigen::VectorXd reached;
    const Vector3d tip_m = peer.turn(target - Vector3d(one.axes), reached);
    Plate<double, 3> plate;
    plate.position_m = tip_m + 1e-3 * random.direction();
    ASSERT_TRUE(delta.at(Vector3d(one.axes) + Vector3d(reached), plate));
    worst_m = std::max(worst_m, (plate.position_m - tip_m).norm());
    moved_m = std::max(moved_m, (tip_m - begin_m).norm());
  }
  test::figure("delta: way of the plate, m", moved_m, "> 0.02");
  test::figure("delta: plate against MuJoCo, m", worst_m, "1e-5");
  EXPECT_GT(moved_m, 0.02);
  EXPECT_LT(worst_m, 1e-5);
}

}  // namespace
}  // namespace thimble::kinematics
