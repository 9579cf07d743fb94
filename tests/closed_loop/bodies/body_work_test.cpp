// What bodies do in a tick has a bound, and takes more ticks where it does not suffice (control/bodies/bodies.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/closed_loop/bodies/compositions.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Bytes = std::vector<unsigned char>;

template <typename Value>
void append(Bytes& bytes, const Value& value) {
  const auto* at = reinterpret_cast<const unsigned char*>(value.data());
  bytes.insert(bytes.end(), at, at + sizeof(value));
}

Bytes state(const control::BodyState& body) {
  Bytes bytes;
  append(bytes, body.position_m);
  append(bytes, body.rotation.coeffs());
  append(bytes, body.velocity_m_s);
  append(bytes, body.spin_rad_s);
  return bytes;
}

Bytes states(const BodyRun& run) {
  Bytes bytes;
  for (const control::BodyState& body : run.renderer().bodies()) {
    const Bytes of_body = state(body);
    bytes.insert(bytes.end(), of_body.begin(), of_body.end());
  }
  return bytes;
}

class BodyWork : public ::testing::Test {
 protected:
  Compositions compositions_;
};

// Pads of tissue that the bodies fall into, before the other objects.
std::string with_tissue(const std::string& members, Random& random) {
  std::string pads;
  for (int i = 0; i < 3; ++i) {
    pads +=
        R"({"name": "pad )" + std::to_string(i) +
        R"(", "shape": {"tissue": {"size_m": [0.2, 0.2], "contact_radius_m": 0.01, "relaxed_stiffness_N_m": 60,
              "recovery_s": 0.3}}, "material": {"stiffness_N_m": 120, "static_friction": 0.3, "dynamic_friction": 0.3},
              "pose": {"position_m": )" +
        list(random.in_box({.02, .02, .005}) + Vector3d(0, 0, .035)) + R"(, "rotation_deg": )" +
        list(random.in_box({10, 10, 90})) + "}}, ";
  }
  const std::string before = R"("objects": [)";
  const std::size_t at = members.find(before) + before.size();
  return members.substr(0, at) + pads + members.substr(at);
}

std::uint32_t beyond(const BodyRun& run, std::uint32_t units) {
  const std::uint32_t done = run.renderer().tick_work();
  return done > units ? done - units : 0U;
}

// Without fingers nothing but the bodies' own clock tells how much work a tick may do.
TEST_F(BodyWork, WithAnyWorkTheBodiesGoTheSameWayOnlySlower) {
  Random random(31);
  std::uint32_t over = 0;
  double slowest = 0;
  for (int i = 0; i < (kUnderSanitizers ? 2 : 4); ++i) {
    const bool crossing = i % 2 == 0;
    Composition composition = compositions_.compose(random, 3 + random.below(14), crossing);
    if (i % 3 != 0) composition.members = with_tissue(composition.members, random);
    const int steps = kUnderSanitizers ? 10 : crossing ? 20 : 300;
    BodyRun free(composition.members);
    std::vector<Bytes> way;
    for (int step = 0; step < steps; ++step) {
      free.tick();
      way.push_back(states(free));
    }
    for (const std::uint32_t units : {1U, 40U, 300U, 2000U}) {
      BodyRun run(composition.members);
      run.bound_work(units);
      int ticks = 0;
      for (int step = 0; step < steps; ++step) {
        do {
          ASSERT_LT(++ticks, 3000000);
          run.tick();
          over = std::max(over, beyond(run, units));
        } while (run.renderer().bodies_wait());
        ASSERT_EQ(states(run), way.at(static_cast<std::size_t>(step)))
            << "composition " << i << ", " << units << " units, step " << step;
      }
      slowest = std::max(slowest, 1.0 * ticks / steps);
    }
  }
  figure("work beyond what a tick may do, units", over, "<= " + std::to_string(control::kMostBodyStepWork));
  figure("ticks that a step takes, at most", slowest, "");
  EXPECT_LE(over, control::kMostBodyStepWork);
}

// What a tick does when it may do anything: where that is allowed, nothing changes.
TEST_F(BodyWork, AsMuchAsIsNeededChangesNothing) {
  Random random(32);
  for (int i = 0; i < (kUnderSanitizers ? 1 : 4); ++i) {
    const Composition composition = compositions_.compose(random, 3 + random.below(14), i % 2 == 0);
    const std::vector<Vector3d> start = {composition.tip_m(0, 0), composition.tip_m(1, 0)};
    BodyRun free(composition.members, start);
    std::vector<Bytes> way;
    std::uint32_t most = 0;
    const int ticks = kUnderSanitizers ? 20 : 500;
    const auto tips = [&](int tick) -> std::vector<Vector3d> {
      return {composition.tip_m(0, tick / 4000.0), composition.tip_m(1, tick / 4000.0)};
    };
    for (int tick = 0; tick < ticks; ++tick) {
      free.tick(tips(tick));
      way.push_back(states(free));
      for (std::size_t finger = 0; finger < 2; ++finger) append(way.back(), free.force_N(finger));
      most = std::max(most, free.renderer().tick_work());
    }
    figure("composition " + std::to_string(i) + ": most work in a tick, units", most, "");
    BodyRun run(composition.members, start);
    run.bound_work(8 * most);  // a finger may do less than a quarter of it
    for (int tick = 0; tick < ticks; ++tick) {
      run.tick(tips(tick));
      Bytes now = states(run);
      for (std::size_t finger = 0; finger < 2; ++finger) append(now, run.force_N(finger));
      ASSERT_EQ(now, way.at(static_cast<std::size_t>(tick))) << "composition " << i << ", tick " << tick;
      ASSERT_FALSE(run.renderer().bodies_wait());
    }
  }
}

// Two fingers go through the midst of the bodies.
TEST_F(BodyWork, NoGodObjectFallsWithLittleWork) {
  Random random(33);
  std::uint32_t over = 0;
  double deepest_m = 0;
  double deepest_ground_m = 0;
  double fastest_m_s = 0;
  double waited = 0;
  for (int i = 0; i < (kUnderSanitizers ? 2 : 6); ++i) {
    const Composition composition = compositions_.compose(random, 3 + random.below(10), i % 3 == 0);
    for (const std::uint32_t units : {60U, 400U, 3000U}) {
      BodyRun run(composition.members, {composition.tip_m(0, 0), composition.tip_m(1, 0)});
      run.bound_work(units);
      const int ticks = kUnderSanitizers ? 100 : 2000;
      for (int tick = 0; tick < ticks; ++tick) {
        run.tick({composition.tip_m(0, tick / 4000.0), composition.tip_m(1, tick / 4000.0)});
        over = std::max(over, beyond(run, units));
        waited += run.renderer().bodies_wait() ? 1 : 0;
        for (std::size_t finger = 0; finger < 2; ++finger) {
          const std::uint64_t inside = run.renderer().inside(finger);
          for (std::size_t body = 0; body < composition.outside_m.size(); ++body) {
            if ((inside >> run.body(body).object & 1U) != 0) continue;
            // Where the bodies were when the god object was placed.
            const control::BodyState& at = run.before(body);
            const Vector3d local =
                at.rotation.cast<double>().conjugate() * (run.god_m(finger) - at.position_m.cast<double>());
            const double depth_m = -composition.outside_m[body](local);
            ASSERT_LT(depth_m, 3e-5) << "composition " << i << ", " << units << " units, tick " << tick
                                     << ", finger " << finger << ", body " << body;
            deepest_m = std::max(deepest_m, depth_m);
          }
        }
        for (std::size_t body = 0; body < composition.outside_m.size(); ++body) {
          ASSERT_TRUE(run.position_m(body).allFinite());
          if (composition.level) deepest_ground_m = std::max(deepest_ground_m, -run.position_m(body).z());
          fastest_m_s = std::max(fastest_m_s, run.velocity_m_s(body).norm());
        }
      }
    }
  }
  figure("work beyond what a tick may do, units", over, "<= " + std::to_string(control::kMostBodyStepWork));
  figure("deepest god object in a body, um", 1e6 * deepest_m, "< 30");
  figure("lowest middle of a body below a level ground, mm", 1e3 * deepest_ground_m, "< 0");
  EXPECT_LE(deepest_ground_m, 0);
  figure("fastest body, m/s", fastest_m_s, "");
  figure("ticks in which bodies waited", waited, "");
  EXPECT_LE(over, control::kMostBodyStepWork);
}

// What the bodies have more of than the hands have given: of their motion without their spin, and of their height.
double gained_J(const Composition& composition, std::uint32_t units) {
  const std::vector<Vector3d> start = {composition.tip_m(0, 0), composition.tip_m(1, 0)};
  BodyRun run(composition.members, start);
  run.bound_work(units);
  const auto energy_J = [&] {
    double sum_J = 0;
    for (std::size_t body = 0; body < composition.mass_kg.size(); ++body)
      sum_J += composition.mass_kg[body] *
               (.5 * run.velocity_m_s(body).squaredNorm() + 9.81 * run.position_m(body).z());
    return sum_J;
  };
  const double start_J = energy_J();
  double given_J = 0;
  double gained_J = 0;
  std::array<Vector3d, 2> force_N = {run.force_N(0), run.force_N(1)};
  for (int tick = 0; tick < (kUnderSanitizers ? 100 : 2000); ++tick) {
    const std::vector<Vector3d> tips = {composition.tip_m(0, tick / 4000.0),
                                        composition.tip_m(1, tick / 4000.0)};
    for (std::size_t finger = 0; finger < 2; ++finger)
      given_J -= .5 * force_N.at(finger).dot(tips[finger] - run.tips()[finger]);
    const std::vector<Vector3d> before = run.tips();
    run.tick(tips);
    for (std::size_t finger = 0; finger < 2; ++finger) {
      force_N.at(finger) = run.force_N(finger);
      given_J -= .5 * force_N.at(finger).dot(tips[finger] - before[finger]);
    }
    gained_J = std::max(gained_J, energy_J() - start_J - given_J);
  }
  return gained_J;
}

TEST_F(BodyWork, HandsGiveTheBodiesWhatTheyGain) {
  Random random(34);
  double most_J = 0;
  for (int i = 0; i < (kUnderSanitizers ? 1 : 4); ++i) {
    const Composition composition = compositions_.compose(random, 3 + random.below(6), false);
    for (const std::uint32_t units : {control::Work::kNoBound, 60U, 400U, 3000U})
      most_J = std::max(most_J, gained_J(composition, units));
  }
  figure("bodies have more than hands gave, mJ", 1e3 * most_J, "< 0.01");
  EXPECT_LT(most_J, 1e-5);
}

}  // namespace
}  // namespace thimble::test
