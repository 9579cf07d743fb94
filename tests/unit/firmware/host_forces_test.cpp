// Forces that the host orders (parameter host_forces): what is felt of them, when they expire, and what still limits them.
#include "firmware/sources/host_forces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <thread>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;

void set_value(Bench& bench, const char* name, float value) {
  const firmware::ParamRow* row = firmware::find_param(name);
  const std::uint32_t bits = row->type == firmware::ParamType::kFloat ? std::bit_cast<std::uint32_t>(value)
                                                                      : static_cast<std::uint32_t>(value);
  ASSERT_EQ(bench.controller->write_param(row->id, bits), firmware::ParamStatus::kOk) << name;
}

link::ForceOrder order_of(float x_N, float y_N, float z_N, std::uint8_t arm, std::uint8_t sequence) {
  link::ForceOrder order;
  order.x_N = x_N;
  order.y_N = y_N;
  order.z_N = z_N;
  order.arm = arm;
  order.sequence = sequence;
  return order;
}

// As it arrives: in whole mN.
Vec3 travelled(const Vec3& force_N) {
  link::ForceOrder order = order_of(force_N.x(), force_N.y(), force_N.z(), 0, 0);
  (void)link::from_frame(link::to_frame(order, 1), 1, order);
  return {order.x_N, order.y_N, order.z_N};
}

// A host on the bench's wire.
struct Host {
  explicit Host(Bench& b) : bench(b) {}
  void send(const link::ForceOrder& order, std::uint8_t node = 1) {
    bench.controller->on_frame(link::to_frame(order, node), bench.inputs.time_us);
  }
  void order(const Vec3& force_N, std::uint8_t arm = 0) {
    send(order_of(force_N.x(), force_N.y(), force_N.z(), arm, ++sequence[arm]));
  }
  // An order before each tick.
  void stream(const Vec3& force_N, int ticks, std::uint8_t arm = 0) {
    for (int i = 0; i < ticks; ++i) {
      order(force_N, arm);
      bench.tick();
    }
  }
  Bench& bench;
  std::array<std::uint8_t, firmware::kMaxArms> sequence{};
};

// Homed and armed without a scene, nothing ordered, the ramp done.
void take_over(Bench& bench) {
  set_value(bench, "host_forces", 1);
  bench.home();
  bench.arm();
  bench.ticks(static_cast<int>(0.25F / bench.config.period_s));
  ASSERT_EQ(bench.shown().ramp, 1.0F);
}

std::optional<link::Status> status(Bench& bench) {
  link::CanFrame frame;
  for (int i = 0; i < 1000; ++i) {
    bench.tick();
    link::Status found;
    while (bench.controller->next_frame(frame, bench.inputs.time_us))
      if (link::from_frame(frame, 1, found)) return found;
  }
  return std::nullopt;
}

TEST(HostForces, ArmingNeedsNoScene) {
  Bench bench;
  bench.home();
  EXPECT_EQ(bench.controller->unmet(), firmware::kNoScene);
  set_value(bench, "host_forces", 1);
  EXPECT_EQ(bench.controller->unmet(), 0) << "at once, without a tick in between";
  bench.arm();
  const std::uint16_t id = firmware::find_param("host_forces")->id;
  EXPECT_EQ(bench.controller->write_param(id, 0), firmware::ParamStatus::kNotWhileArmed);
  const std::optional<link::Status> told = status(bench);
  ASSERT_TRUE(told);
  EXPECT_TRUE(told->flags.host_renders);
  EXPECT_TRUE(told->flags.supervised);
  EXPECT_FALSE(told->flags.scene) << "none is loaded";
}

// A wrench is a force, for arms that exert no torque; one with a torque is none of theirs.
TEST(HostForces, AWrenchWithoutATorqueIsAForce) {
  Bench bench;
  bench.start();
  ASSERT_EQ(bench.controller->request(Command::kDisarm), 0);
  bench.ticks(1500);
  set_value(bench, "host_forces", 1);
  bench.arm();
  bench.ticks(1000);  // the force is ramped
  link::WrenchOrder wrench;
  wrench.force_N = {0, 0, 1};
  wrench.sequence = 1;
  const link::CanFrame frame = link::to_frame(wrench, 1);
  EXPECT_TRUE(frame.fd);
  bench.controller->on_frame(frame, bench.inputs.time_us);
  bench.ticks(8);
  EXPECT_GT(bench.shown().arm[0].force_N.z(), 0.5F);
  bench.ticks(200);
  EXPECT_LT(std::abs(bench.shown().arm[0].force_N.z()), 0.1F);
  wrench.torque_N_m = {0.1F, 0, 0};
  wrench.sequence = 2;
  bench.controller->on_frame(link::to_frame(wrench, 1), bench.inputs.time_us);
  bench.ticks(8);
  EXPECT_LT(std::abs(bench.shown().arm[0].force_N.z()), 0.1F);
}

TEST(HostForces, TheForceIsTheNewestOrderInTheNextTick) {
  Bench bench;
  take_over(bench);
  Host host(bench);
  std::mt19937 random(1);
  std::uniform_int_distribution<int> mN(-900, 900);
  for (int i = 0; i < 1000; ++i) {
    const auto any = [&] { return static_cast<float>(mN(random)) * 1e-3F; };
    host.order({any(), any(), any()});  // no tick sees this one
    const Vec3 force_N = travelled({any(), any(), any()});
    host.order(force_N);
    bench.tick();
    ASSERT_EQ(bench.shown().arm[0].force_N, force_N) << i;
    ASSERT_EQ(bench.shown().arm[0].rendered_N, force_N);
    ASSERT_EQ(bench.shown().arm[0].contacts, 0);
    ASSERT_EQ(bench.shown().arm[0].limiters, 0);
  }
}

// For how many ticks an order is felt, the tip in motion meanwhile.
int ticks_felt(Bench& bench) {
  Host host(bench);
  const Vec3 force_N = travelled({0.25F, 0.5F, -0.75F});
  host.order(force_N);
  int felt = 0;
  Eigen::Vector3d tip = bench.arms[0].at(bench.joints[0]).tip_m;
  for (; felt < 2000; ++felt) {
    tip.x() += 0.05 * static_cast<double>(bench.config.period_s);
    bench.place(tip);
    bench.tick();
    if (bench.shown().arm[0].force_N != force_N) break;
  }
  const auto& arm = bench.shown().arm[0];
  EXPECT_LT((arm.force_N + 2.0F * arm.tip_velocity_m_s).norm(), 1e-6F) << "then the tip is damped";
  EXPECT_GT(arm.tip_velocity_m_s.norm(), 0.02F);
  return felt;
}

TEST(HostForces, ExpireInTheExactTick) {
  for (const auto& [rate_Hz, life] :
       {std::pair{1000.0F, 20}, {3000.0F, 60}, {4000.0F, 80}, {10000.0F, 200}, {333.0F, 6}}) {
    firmware::Config config;
    config.period_s = 1.0F / rate_Hz;
    Bench bench(config);
    set_value(bench, "force_slew", 100000.0F);
    take_over(bench);
    const int felt = ticks_felt(bench);
    std::printf("%.0f Hz: felt for %d ticks, %.4f s\n", static_cast<double>(rate_Hz), felt,
                static_cast<double>(static_cast<float>(felt) / rate_Hz));
    EXPECT_EQ(felt, life);
  }
}

TEST(HostForces, LostTicksAge) {
  Bench bench;
  take_over(bench);
  Host host(bench);
  host.stream({0, 0, 1}, 1);
  for (int i = 0; i < 19; ++i) {  // three periods lost before each: 4 count for each
    bench.inputs.tick += 3;
    bench.tick();
    ASSERT_EQ(bench.force_N(), 1.0F) << i;
  }
  bench.inputs.tick += 3;
  bench.tick();
  EXPECT_LT(bench.force_N(), 0.1F);
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

TEST(HostForces, AnExpiredForceEndsNoFasterThanTheSlewLimitAndComesBackSo) {
  Bench bench;
  set_value(bench, "force_slew", 1000.0F);  // 0.25 N a tick
  take_over(bench);
  Host host(bench);
  host.stream({0, 0, 2}, 100);
  ASSERT_EQ(bench.force_N(), 2.0F);
  Vec3 last_N = bench.shown().arm[0].force_N;
  float worst_N = 0;
  int ticks = 0;
  const auto step = [&] {
    bench.tick();
    worst_N = std::max(worst_N, (bench.shown().arm[0].force_N - last_N).norm());
    last_N = bench.shown().arm[0].force_N;
  };
  for (; bench.force_N() > 0.2F; ++ticks) step();
  std::printf("gone after %d ticks, steps of at most %.4f N\n", ticks, static_cast<double>(worst_N));
  EXPECT_NEAR(ticks, 79 + 8, 1);
  for (int i = 0; i < 40; ++i) {
    host.order({0, 0, 2});
    step();
  }
  EXPECT_EQ(bench.force_N(), 2.0F);
  EXPECT_LE(worst_N, 0.25F + 1e-5F);
}

TEST(HostForces, TheNumberDecidesWhatIsOld) {
  Bench bench;
  take_over(bench);
  Host host(bench);
  const auto felt_after = [&](std::uint8_t sequence, float z_N) {
    host.send(order_of(0, 0, z_N, 0, sequence));
    bench.tick();
    return std::round(1e3F * bench.shown().arm[0].force_N.z()) / 1e3F;
  };
  EXPECT_EQ(felt_after(250, 1.0F), 1.0F);
  EXPECT_EQ(felt_after(250, 0.5F), 1.0F) << "repeated";
  EXPECT_EQ(felt_after(249, 0.5F), 1.0F) << "overtaken";
  EXPECT_EQ(felt_after(251, 0.75F), 0.75F);
  EXPECT_EQ(felt_after(3, 0.5F), 0.5F) << "it wraps, some lost in between";
  EXPECT_EQ(felt_after(252, 0.25F), 0.5F);
  EXPECT_EQ(felt_after(131, 0.25F), 0.5F) << "half way round is behind";
  EXPECT_EQ(felt_after(130, 0.25F), 0.25F);
  bench.ticks(40);
  EXPECT_EQ(felt_after(130, 0.5F), 0.25F) << "an old one keeps no force alive ...";
  bench.ticks(39);
  EXPECT_LT(bench.force_N(), 0.1F);
  EXPECT_EQ(felt_after(7, 1.0F), 1.0F)
      << "a program that begins to count anew is heard after the life of an order";
}

TEST(HostForces, WhatIsNoOrderForThisControllerIsPassedOver) {
  Bench bench;
  take_over(bench);
  Host host(bench);
  const auto quiet = [&] {
    bench.tick();
    return bench.force_N() < 0.1F;
  };
  host.send(order_of(0, 0, 1, 1, 1));
  EXPECT_TRUE(quiet()) << "there is no second arm";
  host.send(order_of(0, 0, 1, 255, 1));
  EXPECT_TRUE(quiet());
  host.send(order_of(0, 0, 1, 0, 1), 2);
  EXPECT_TRUE(quiet()) << "another node's";
  link::CanFrame frame = link::to_frame(order_of(0, 0, 1, 0, 2), 1);
  frame.size = 7;
  bench.controller->on_frame(frame, bench.inputs.time_us);
  EXPECT_TRUE(quiet()) << "too short";
  frame.size = 8;
  frame.remote = true;
  bench.controller->on_frame(frame, bench.inputs.time_us);
  EXPECT_TRUE(quiet()) << "without data";
  frame.remote = false;
  frame.extended = true;
  bench.controller->on_frame(frame, bench.inputs.time_us);
  EXPECT_TRUE(quiet()) << "another format";
  frame.extended = false;
  bench.controller->on_frame(frame, bench.inputs.time_us);
  EXPECT_FALSE(quiet()) << "and now it is one";
}

TEST(HostForces, WithoutTheParameterOrNotArmedNobodyListens) {
  Bench bench;
  bench.load();
  bench.home();
  Host host(bench);
  bench.arm();
  bench.ticks(1000);
  host.stream({0, 0, 1}, 10);
  EXPECT_LT(bench.force_N(), 0.1F) << "the scene is rendered";

  Bench other;
  set_value(other, "host_forces", 1);
  other.home();
  Host early(other);
  early.stream({0, 0, 1}, 10);
  other.arm();
  other.ticks(20);
  EXPECT_EQ(other.shown().arm[0].rendered_N.z(), 0.0F) << "ordered before it was armed";
  early.stream({0, 0, 1}, 1);
  EXPECT_EQ(other.shown().arm[0].rendered_N.z(), 1.0F);
}

TEST(HostForces, NothingOfTheSceneIsFeltAndASwapTakesNoForce) {
  Bench bench;
  bench.load(2000.0F, 0.004F);
  take_over(bench);
  bench.move({0, 0, 0.01}, 200);
  Host host(bench);
  host.stream({1, 0, 0}, 10);
  for (int i = 0; i < 200; ++i) {  // into the plane
    bench.place({0, 0, 0.01 - 0.00005 * i});
    host.stream({1, 0, 0}, 1);
    ASSERT_EQ(bench.shown().arm[0].force_N, Vec3(1, 0, 0));
    ASSERT_EQ(bench.shown().arm[0].contacts, 0);
    ASSERT_EQ(bench.shown().arm[0].god_object_m, bench.shown().arm[0].tip_m);
  }
  const std::uint32_t before = bench.shown().scene_sequence;
  bench.load(1000.0F, 0.002F);
  for (int i = 0; i < 400; ++i) {
    host.stream({1, 0, 0}, 1);
    ASSERT_EQ(bench.shown().arm[0].force_N, Vec3(1, 0, 0));
  }
  EXPECT_NE(bench.shown().scene_sequence, before);
}

TEST(HostForces, RampUpOver200ms) {
  Bench bench;
  set_value(bench, "host_forces", 1);
  bench.home();
  bench.arm();
  Host host(bench);
  float worst = 0;
  for (int i = 0; i < 1000; ++i) {
    host.stream({0, 0, 2}, 1);
    const float expected_N = 2.0F * std::min(static_cast<float>(i + 2) / 800.0F, 1.0F);
    worst = std::max(worst, std::abs(bench.force_N() - expected_N));
  }
  std::printf("farthest from the ramp: %.4f N\n", static_cast<double>(worst));
  EXPECT_LT(worst, 0.01F);
}

TEST(HostForces, EveryWayToStopStops) {
  struct Case {
    const char* what;
    void (*stop)(Bench&);
    Fault fault;
  };
  const Case kCases[] = {
      {"e-stop", [](Bench& b) { b.inputs.e_stop = true; }, Fault::e_stop},
      {"dead-man", [](Bench& b) { b.inputs.dead_man = false; }, Fault::kNone},
      {"disarm", [](Bench& b) { (void)b.controller->request(Command::kDisarm); }, Fault::kNone},
      {"host's stop", [](Bench& b) { (void)b.controller->request(Command::kStop); }, Fault::host_stop},
      {"drive", [](Bench& b) { b.inputs.arm[0].drive_fault = true; }, Fault::drive_fault},
  };
  for (const Case& c : kCases) {
    Bench bench;
    take_over(bench);
    Host host(bench);
    host.stream({0, 0, 2}, 20);
    ASSERT_EQ(bench.force_N(), 2.0F);
    c.stop(bench);
    host.stream({0, 0, 2}, 1);
    EXPECT_LT(bench.force_N(), 0.1F) << c.what << ": in the same tick";
    host.stream({0, 0, 2}, 1100);  // a host that goes on is not heard
    EXPECT_EQ(bench.controller->fault(), c.fault) << c.what;
    EXPECT_NE(bench.mode(), Mode::kArmed);
    EXPECT_FALSE(any_current(bench.outputs)) << c.what;
  }
}

TEST(HostForces, AHostThatIsGoneIsAFaultAfterTheLinkTimeout) {
  Bench bench;
  set_value(bench, "link_timeout", 0.5F);
  take_over(bench);
  bench.alive = false;  // the orders alone are the sign of life
  Host host(bench);
  host.stream({0, 0, 1}, 8000);
  ASSERT_EQ(bench.mode(), Mode::kArmed) << "2 s";
  int damped_after = 0, lost_after = 0;
  for (int i = 1; i <= 4000 && lost_after == 0; ++i) {
    bench.tick();
    if (damped_after == 0 && bench.force_N() < 0.2F) damped_after = i;
    if (bench.controller->fault() == Fault::host_lost) lost_after = i;
  }
  std::printf("damped in tick %d (20 ms are 80), fault host_lost in tick %d (0.5 s are 2000)\n", damped_after,
              lost_after);
  EXPECT_EQ(damped_after, 80);
  EXPECT_EQ(lost_after, 2001);
  EXPECT_EQ(bench.mode(), Mode::kDamping);
}

// Over the link alone: the order that comes after a pose is in the very next Force frame.
TEST(HostForces, ShowInTheNextForceFrame) {
  Bench bench;
  set_value(bench, "telemetry_decimation", 1);
  take_over(bench);
  Host host(bench);
  link::CanFrame frame;
  while (bench.controller->next_frame(frame, bench.inputs.time_us)) {
  }
  int forces = 0;
  float ordered_N = 0;
  for (int i = 0; i < 1000; ++i) {
    const float last_N = ordered_N;
    bench.tick();
    while (bench.controller->next_frame(frame, bench.inputs.time_us)) {
      link::Pose pose;
      link::Force force;
      if (link::from_frame(frame, 1, force)) {
        ++forces;
        if (i > 0) {
          ASSERT_NEAR(force.z_N, last_N, 5e-4F) << i;
        }
      }
      if (link::from_frame(frame, 1, pose)) ordered_N = 0.001F * static_cast<float>(i % 500);
    }
    host.order({0, 0, ordered_N});
  }
  EXPECT_EQ(forces, 1000) << "one a tick";
}

TEST(HostForces, TwoArmsHaveAnOrderEach) {
  firmware::Config config;
  config.arm_count = 2;
  config.arm[1].base.home_m = {0.3F, 0, 0};
  Bench bench(config);
  take_over(bench);
  Host host(bench);
  for (int i = 0; i < 79; ++i) {
    if (i == 0) host.order({0, 0, 1}, 0);
    host.order({0, 1, 0}, 1);
    bench.tick();
    ASSERT_EQ(bench.shown().arm[0].force_N, Vec3(0, 0, 1));
    ASSERT_EQ(bench.shown().arm[1].force_N, Vec3(0, 1, 0));
  }
  host.stream({0, 1, 0}, 2, 1);
  EXPECT_LT(bench.force_N(0), 0.1F) << "only the arm without orders is damped";
  EXPECT_EQ(bench.force_N(1), 1.0F);
}

TEST(HostForces, AGuardedMoveIsRefused) {
  Bench bench;
  set_value(bench, "allow_moves", 1);
  take_over(bench);
  EXPECT_EQ(bench.controller->request_move({0, true, Vec3(0, 0, 0.005F), 0.02F, 1.0F}),
            firmware::kHostRenders);
}

TEST(HostForces, ClampAndMotorsLimitThem) {
  Bench bench;
  take_over(bench);
  Host host(bench);
  host.stream({0, 0, 30}, 100);
  EXPECT_NEAR(bench.force_N(), 8.0F, 2.0F) << "by the clamp, and by the peak current where that is less";
  EXPECT_NE(bench.shown().arm[0].limiters & firmware::kLimitClamp, 0);
  EXPECT_NE(bench.shown().arm[0].limiters & firmware::kLimitCurrent, 0);
  set_value(bench, "max_force", 3.0F);
  host.stream({0, -30, 0}, 600);  // by 50 N/s
  EXPECT_NEAR((bench.shown().arm[0].force_N - Vec3(0, -3, 0)).norm(), 0.0F, 1e-5F) << "direction kept";
}

TEST(HostForces, HeatDeratesThem) {
  Bench bench;
  set_value(bench, "winding_limit", 60.0F);
  take_over(bench);
  Host host(bench);
  host.stream({0, 0, 5}, 2000);
  const Vec3 first_N = bench.shown().arm[0].force_N;
  float hottest_C = 0;
  bool derated = false;
  for (int i = 0; i < 30 * 4000; ++i) {
    host.stream({0, 0, 5}, 1);
    ASSERT_EQ(bench.mode(), Mode::kArmed);
    hottest_C = std::max(hottest_C, std::ranges::max(bench.shown().arm[0].winding_C));
    derated = derated || (bench.shown().arm[0].limiters & firmware::kLimitThermal) != 0;
  }
  std::printf("30 s of 5 N: hottest %.1f C of 60, force fell from %.2f to %.2f N\n",
              static_cast<double>(hottest_C), static_cast<double>(first_N.norm()),
              static_cast<double>(bench.force_N()));
  EXPECT_TRUE(derated);
  EXPECT_LT(hottest_C, 60.0F);
  EXPECT_LT(bench.force_N(), 0.8F * first_N.norm());
}

// Whatever a host orders, in whatever order and rate it comes, with the tip anywhere.
TEST(HostForcesProperty, NeverBeyondClampSlewRampOrTheLifeOfAnOrder) {
  float worst_clamp = 0, worst_slew = 0, worst_ramp = 0, worst_current = 0;
  std::uint64_t ticks = 0, limited[4] = {}, expired = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    Bench bench;
    const float max_N = 0.5F + 12.0F * unit(random);
    const float slew_N_s = 200.0F + 40000.0F * unit(random);
    const float chance = unit(random) * unit(random);  // of an order before a tick
    bench.let_jump();
    set_value(bench, "max_force", max_N);
    set_value(bench, "force_slew", slew_N_s);
    set_value(bench, "host_forces", 1);
    bench.home();
    bench.arm();
    Host host(bench);
    const float bound_N = std::min(max_N, bench.data[0].max_force_N);
    const float peak_A = bench.data[0].axis[0].motor.peak_current_A;
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();
    Vec3 last_N = Vec3::Zero();
    bool last_scaled = false;
    float largest_N = 0;
    int since_order = 1000;
    for (int i = 0; i < 4000; ++i, ++ticks) {
      tip += (unit(random) < 0.02F ? 0.0014 : 0.0002) *
             Eigen::Vector3f(unit(random) - 0.5F, unit(random) - 0.5F, unit(random) - 0.5F).cast<double>();
      tip = tip.cwiseMax(Eigen::Vector3d::Constant(-0.03)).cwiseMin(Eigen::Vector3d::Constant(0.03));
      bench.place(tip);
      ++since_order;
      if (i % 500 > 400 ? unit(random) < 0.02F : unit(random) < chance) {
        const float size_N = unit(random) < 0.1F ? 60.0F : 4.0F * unit(random);
        link::ForceOrder order;
        order.x_N = size_N * (unit(random) - 0.5F);
        order.y_N = size_N * (unit(random) - 0.5F);
        order.z_N = size_N * (unit(random) - 0.5F);
        order.arm = static_cast<std::uint8_t>(random() % 3 / 2);
        order.sequence = host.sequence[0];
        const unsigned kind = random() % 8;
        if (kind != 0) order.sequence = ++host.sequence[0];  // else repeated
        if (kind == 1) order.sequence = static_cast<std::uint8_t>(host.sequence[0] - random() % 20);
        host.send(order);
        if (order.arm == 0) since_order = 0;
      }
      bench.tick();
      ASSERT_EQ(bench.mode(), Mode::kArmed)
          << seed << " fault " << static_cast<int>(bench.controller->fault());
      const auto& arm = bench.shown().arm[0];
      // Silent for longer than the life of an order: it is damping, whatever came before.
      if (since_order > 80) {
        ++expired;
        ASSERT_EQ(arm.rendered_N, Vec3(-2.0F * arm.tip_velocity_m_s)) << seed << ' ' << i;
      }
      largest_N = std::max(largest_N, arm.rendered_N.norm());
      worst_clamp = std::max(worst_clamp, arm.force_N.norm() / bound_N);
      const bool scaled = (arm.limiters & (firmware::kLimitCurrent | firmware::kLimitThermal)) != 0;
      if (!scaled && !last_scaled)
        worst_slew = std::max(worst_slew, (arm.force_N - last_N).norm() / (slew_N_s * bench.config.period_s));
      if (i < 790)
        worst_ramp = std::max(worst_ramp, arm.force_N.norm() / (bench.shown().ramp * largest_N + 1e-6F));
      for (const float current_A : bench.outputs.arm[0].current_A)
        worst_current = std::max(worst_current, std::abs(current_A) / peak_A);
      last_N = arm.force_N;
      last_scaled = scaled;
      for (unsigned bit = 0; bit < 4; ++bit) limited[bit] += arm.limiters >> bit & 1U;
    }
  }
  std::printf(
      "%llu ticks, %llu without an order: force/clamp %.7f, step/slew %.7f, force/ramp %.7f, current/peak "
      "%.7f\n",
      static_cast<unsigned long long>(ticks), static_cast<unsigned long long>(expired),
      static_cast<double>(worst_clamp), static_cast<double>(worst_slew), static_cast<double>(worst_ramp),
      static_cast<double>(worst_current));
  EXPECT_LE(worst_clamp, 1 + 1e-6F);
  EXPECT_LE(worst_slew, 1 + 1e-4F);
  EXPECT_LE(worst_ramp, 1 + 1e-5F);
  EXPECT_LE(worst_current, 1.0F);
  EXPECT_GT(expired, 5000U);
  EXPECT_GT(limited[0], 100U);
  EXPECT_GT(limited[1], 100U);
  EXPECT_GT(limited[2], 10U);
}

// The handover with both contexts at once: what the tick takes is one order, and never one from before the last.
TEST(HostForces, AreHandedOverWhole) {
  constexpr int kWanted = 2000,
                kMostOrders = 100'000'000;  // the scheduler may let one of the two run alone for long
  constexpr int kDigit = 30000;             // mN
  firmware::HostForces forces(1.0F / 4000);
  std::atomic<int> taken{0};
  std::atomic<int> ordered{0};
  std::atomic<bool> done{false};
  std::thread background([&] {
    for (int i = 0; i < kMostOrders && taken < kWanted; ++i) {
      const float low_N = static_cast<float>(i % kDigit) * 1e-3F;
      const int high_mN = i / kDigit;
      const float high_N = static_cast<float>(high_mN) * 1e-3F;
      if (!forces.order(order_of(low_N, high_N, -low_N, 0, static_cast<std::uint8_t>(i)), 0)) std::abort();
      ordered = i + 1;
      if (i % 256 == 0) std::this_thread::yield();
    }
    done = true;
  });
  int torn = 0, back = 0;
  int last = -1;
  for (std::uint64_t tick = 0; !done; ++tick) {
    const Vec3* force_N = forces.take(0, tick);
    if (force_N != nullptr) {
      torn += force_N->z() == -force_N->x() ? 0 : 1;
      const int number = static_cast<int>(std::lround(1e3F * force_N->x())) +
                         kDigit * static_cast<int>(std::lround(1e3F * force_N->y()));
      back += number < last || number > ordered ? 1 : 0;
      if (number > last) ++taken;
      last = number;
    }
    if (tick % 64 == 0) std::this_thread::yield();
  }
  background.join();
  std::printf("%d orders, %d taken, %d torn, %d backwards\n", ordered.load(), taken.load(), torn, back);
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(back, 0);
  EXPECT_GE(taken.load(), kWanted);
}

}  // namespace
}  // namespace thimble::test
