// Homing where the host says (routine 0210): the arm is there, or nobody knows where it is.
#include <gtest/gtest.h>

#include <bit>
#include <memory>

#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using link::Nrc;

const Bytes kHomeIt = {0x31, 0x01, 0x02, 0x03}, kHomed = {0x71, 0x01, 0x02, 0x10};

Bytes request_of(const link::HomePlace& place) {
  Bytes request = {0x31, 0x01, 0x02, 0x10};
  request.resize(4 + link::wire_size<link::HomePlace>());
  EXPECT_NE(link::encode(place, std::span(request).subspan(4)), 0U);
  return request;
}

// The registers as they are now, and counts that the test knows.
link::HomePlace place_now(const Bench& bench, std::uint8_t arm = 0) {
  link::HomePlace place;
  place.arm = arm;
  for (std::size_t j = 0; j < 3; ++j) {
    place.raw[j] = bench.inputs.arm[arm].counts[j];
    place.counts[j] = 40 * static_cast<std::int32_t>(j + 1) - 70;
  }
  return place;
}

// The joints are where the host said, and what the registers have counted since.
void expect_at(const Bench& bench, const link::HomePlace& place) {
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<int>(j);
    const auto since = static_cast<std::int32_t>(bench.inputs.arm[place.arm].counts[j] - place.raw[j]);
    const double angle_rad =
        bench.arms[place.arm].home()[axis] +
        (place.counts[j] + since) * static_cast<double>(bench.data[place.arm].axis[j].rad_per_count());
    EXPECT_NEAR(static_cast<double>(bench.shown().arm[place.arm].joint_rad[axis]), angle_rad, 1e-6) << j;
  }
}

void turn(Bench& bench, const Eigen::Vector3d& way_rad) {
  for (int i = 0; i < 50; ++i) {
    bench.joints[0] += way_rad / 50;
    bench.tick();
  }
}

firmware::Config config_of(std::uint8_t arms, bool has_index) {
  firmware::Config config;
  config.arm_count = arms;
  config.arm[1].base.home_m = {0.3F, 0, 0};
  for (auto& arm : config.arm) arm.has_index = has_index;
  return config;
}

// With and without an index, before the first homing and after one.
TEST(HomePlace, TheArmIsWhereTheHostSays) {
  for (const bool has_index : {false, true}) {
    Bench bench(config_of(1, has_index));
    bench.load(1000.0F, -0.01F);
    bench.ticks(10);
    Tester tester(bench, false, 1);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    for (const double moved_rad : {0.0, 0.01}) {
      const link::HomePlace place = place_now(bench);
      turn(bench, Eigen::Vector3d::Constant(moved_rad));  // after the host has read the registers
      ASSERT_EQ(tester.ask(request_of(place)), kHomed) << tester.text(link::kDidRefusal);
      EXPECT_EQ(bench.mode(), Mode::kReady);
      expect_at(bench, place);
      turn(bench, {0.02, -0.01, 0.015});
      expect_at(bench, place);
      EXPECT_EQ(bench.controller->fault(), Fault::kNone);
      const link::AuditRecord entry = [&] {
        const Bytes page = tester.ask({0x31, 0x03, 0x02, 0x0A, 0, 0, 0, 0});
        link::AuditRecord newest;
        EXPECT_TRUE(link::decode(std::span(page).last(link::wire_size<link::AuditRecord>()), newest));
        return newest;
      }();
      EXPECT_EQ(entry.event, AuditEvent::kHoming);
      EXPECT_EQ(entry.host, tester.address());
    }
    tester.run(1200);
    ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x01})) << "it arms there: " << tester.text(link::kDidRefusal);
  }
}

TEST(HomePlace, APlaceThatCannotBeIsRefused) {
  for (const bool homed_before : {false, true}) {
    Bench bench;
    bench.load(1000.0F, -0.01F);
    bench.ticks(10);
    Tester tester(bench);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    if (homed_before) {
      ASSERT_TRUE(tester.ok(kHomeIt));
      tester.run(4);
      ASSERT_EQ(bench.mode(), Mode::kReady);
    }
    link::HomePlace far = place_now(bench);
    far.raw[2] += 1'000'000;
    EXPECT_EQ(tester.refused(request_of(far)), Nrc::kConditionsNotCorrect);
    EXPECT_NE(tester.text(link::kDidRefusal).find("not_homed"), std::string::npos);
    EXPECT_NE(bench.controller->unmet() & firmware::kNotHomed, 0);
    EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x01}), Nrc::kConditionsNotCorrect);
    EXPECT_EQ(bench.controller->fault(), Fault::kNone);
    // What comes after it is a plain home.
    ASSERT_TRUE(tester.ok(kHomeIt));
    tester.run(4);
    EXPECT_EQ(bench.mode(), Mode::kReady);
    EXPECT_NEAR((bench.shown().arm[0].joint_rad.head<3>().cast<double>() - bench.joints[0]).norm(), 0, 0.01);
  }
}

// Registers that nobody has read in this tick tell nothing.
TEST(HomePlace, AStaleSampleIsRefused) {
  Bench bench;
  bench.load(1000.0F, -0.01F);
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  const link::HomePlace place = place_now(bench);
  bench.halted = true;
  tester.post(request_of(place));
  tester.run(20);
  bench.halted = false;
  bench.sampling = false;
  bench.tick();
  bench.sampling = true;
  EXPECT_EQ(tester.posted_answer(), (Bytes{0x7F, 0x31, 0x22}));
  EXPECT_NE(bench.controller->unmet() & firmware::kNotHomed, 0) << "neither there nor where it was";
}

TEST(HomePlace, TheOtherArmKeepsItsHome) {
  Bench bench(config_of(2, false));
  bench.load(1000.0F, -0.01F);
  bench.ticks(10);
  Tester tester(bench, true);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  link::HomePlace wrong;
  wrong.arm = 2;
  EXPECT_EQ(tester.refused(request_of(wrong)), Nrc::kRequestOutOfRange);
  const link::HomePlace first = place_now(bench, 0);
  EXPECT_EQ(tester.refused(request_of(first)), Nrc::kConditionsNotCorrect);
  EXPECT_NE(tester.text(link::kDidRefusal).find("not_homed"), std::string::npos) << "the other one is not";
  EXPECT_EQ(bench.mode(), Mode::kDisarmed);
  const link::HomePlace second = place_now(bench, 1);
  EXPECT_EQ(tester.ask(request_of(second)), kHomed);
  EXPECT_EQ(bench.mode(), Mode::kReady);
  expect_at(bench, first);
  expect_at(bench, second);
  link::HomePlace again = place_now(bench, 0);
  again.counts = {11, 12, 13};
  EXPECT_EQ(tester.ask(request_of(again)), kHomed);
  expect_at(bench, again);
  expect_at(bench, second);
}

// A place is that of its own command: another one that came instead leaves none behind.
TEST(HomePlace, NoPlaceIsLeftBehind) {
  const auto disarm = [](Bench& b) { ASSERT_EQ(b.controller->request(Command::kDisarm), 0); };
  const auto clear = [](Bench& b) { b.controller->replay(Command::kClear); };
  const auto late = [](Bench& b) { b.inputs.tick += 100; };
  for (void (*come_between)(Bench&) : {+disarm, +clear, +late}) {
    Bench bench;
    bench.load(1000.0F, -0.01F);
    bench.ticks(10);
    Tester tester(bench);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    link::HomePlace place = place_now(bench);
    place.counts.fill(150);
    bench.halted = true;
    tester.post(request_of(place));
    tester.run(20);
    come_between(bench);
    bench.halted = false;
    bench.tick();
    EXPECT_EQ(tester.posted_answer(), (Bytes{0x7F, 0x31, 0x22}));
    EXPECT_EQ(bench.mode(), Mode::kDisarmed);
    ASSERT_EQ(bench.controller->request(Command::kHome), 0);
    bench.ticks(3);
    ASSERT_EQ(bench.mode(), Mode::kReady);
    EXPECT_NEAR((bench.shown().arm[0].joint_rad.head<3>().cast<double>() - bench.arms[0].home()).norm(), 0,
                0.01)
        << "a plain home";
  }
}

TEST(HomePlace, EndsARecordingAndTheNextOneIsExact) {
  Bench bench;
  bench.load();
  bench.home();
  bench.ticks(10);
  Tester tester(bench, true);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x08}));
  tester.run(20);
  link::HomePlace place = place_now(bench);
  ASSERT_EQ(tester.ask(request_of(place)), kHomed);
  EXPECT_EQ(bench.controller->recording_state().phase, link::RecordingPhase::kEnded);
  EXPECT_EQ(bench.controller->recording_state().end, link::RecordingEnd::kPlaced);
  bench.move({0.01, 0.02, 0.003}, 400);
  bench.ticks(400);
  ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x08}));
  const Bytes answer = tester.ask({0x31, 0x03, 0x02, 0x08});
  firmware::RecordingStart recording;
  std::span<const std::uint8_t> rest = std::span(answer).subspan(4);
  ASSERT_TRUE(link::decode(rest, recording.start));
  ASSERT_TRUE(link::decode(rest.subspan(link::wire_size<link::RecordingStart>()), recording.arms[0]));
  // The ticks since the start, and those that follow: all that the fresh controller is fed.
  Bench fresh;
  fresh.load();
  fresh.controller->resume(recording);
  for (auto tick = recording.start.tick + 1; tick <= bench.inputs.tick; ++tick) {
    Inputs inputs = bench.inputs;  // the bench has not moved since
    inputs.tick = tick;
    for (auto& arm : inputs.arm) arm.sample_tick = tick;
    fresh.controller->keep_alive();
    static_cast<void>(fresh.controller->tick(inputs));
  }
  bench.alive = true;
  float most_N = 0;
  for (int i = 0; i < 1500; ++i) {
    if (i == 5) {
      ASSERT_EQ(bench.controller->request(Command::kArm), 0);
      fresh.controller->replay(Command::kArm);
    }
    bench.place({0.01 - 5e-6 * i, 0.02 - 1e-5 * i, 0.003 - 4e-6 * i});
    bench.tick();
    fresh.controller->keep_alive();
    static_cast<void>(fresh.controller->tick(bench.inputs));
    for (int k = 0; k < 3; ++k)
      ASSERT_EQ(std::bit_cast<std::uint32_t>(fresh.shown().arm[0].force_N[k]),
                std::bit_cast<std::uint32_t>(bench.shown().arm[0].force_N[k]))
          << "tick " << i;
    most_N = std::max(most_N, bench.force_N());
  }
  EXPECT_GT(most_N, 1.0F) << "nothing was felt";
}

}  // namespace
}  // namespace thimble::test
