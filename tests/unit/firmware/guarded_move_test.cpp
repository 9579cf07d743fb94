// The guarded move's rules: what it is refused for, its ranges, and the buffer of what it measures.
#include "firmware/sources/guarded_move.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using firmware::MoveOrder;

const MoveOrder kShort{0, true, Vec3(0.0F, 0.0F, 0.005F), 0.02F, 1.0F};

void allow(Bench& bench, std::uint32_t yes = 1) {
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("allow_moves")->id, yes),
            firmware::ParamStatus::kOk);
}

// Armed above the plane, the ramp done, moves allowed.
void start(Bench& bench) {
  allow(bench);
  bench.load(1000.0F, -0.01F);
  bench.home();
  bench.arm();
  bench.ticks(900);
}

TEST(GuardedMoveRules, RunsWhenNothingStandsAgainstIt) {
  Bench bench;
  start(bench);
  ASSERT_EQ(bench.controller->request_move(kShort), 0);
  bench.tick();
  EXPECT_TRUE(bench.shown().moves_itself);
  EXPECT_EQ(bench.controller->move_results(), nullptr) << "nothing to read while it goes";
  bench.ticks(100);
  EXPECT_GT(bench.shown().arm[0].force_N.z(), 0.1F) << "the arm pulls its tip along";
  EXPECT_EQ(bench.controller->request_move(kShort), firmware::kMoveUnderWay);
}

TEST(GuardedMoveRules, EveryConditionIsNamed) {
  struct Case {
    firmware::Condition condition;
    void (*spoil)(Bench&);
  };
  const Case kCases[] = {
      {firmware::kMovesNotAllowed,
       [](Bench& b) {
         ASSERT_EQ(b.controller->request(Command::kDisarm), 0);
         b.ticks(1100);
         allow(b, 0);
         b.arm();
         b.ticks(900);
       }},
      {firmware::kNotArmed,
       [](Bench& b) {
         ASSERT_EQ(b.controller->request(Command::kDisarm), 0);
         b.ticks(1100);
       }},
      {firmware::kInContact,
       [](Bench& b) {
         b.move({0, 0, -0.012}, 400);
       }},
      {firmware::kLinkDown,
       [](Bench& b) {
         b.alive = false;
         b.ticks(2100);  // 0.525 s: arming would still do, a move of its own does not
         EXPECT_EQ(b.mode(), Mode::kArmed);
       }},
      {firmware::kRampRuns,
       [](Bench& b) {
         ASSERT_EQ(b.controller->request(Command::kDisarm), 0);
         b.ticks(1100);
         b.arm();
       }},
      {firmware::kFaultLatched, [](Bench& b) { (void)b.controller->request(Command::kStop); }},
  };
  for (const Case& c : kCases) {
    Bench bench;
    start(bench);
    c.spoil(bench);
    bench.ticks(5);
    const Conditions refused = bench.controller->request_move(kShort);
    std::printf("condition %d: refused with %d\n", c.condition, refused);
    EXPECT_NE(refused & c.condition, 0) << c.condition;
    bench.ticks(2);
    EXPECT_FALSE(bench.shown().moves_itself) << c.condition;
  }
  Bench bench;
  start(bench);
  MoveOrder far = kShort;
  far.target_m = {0, 0, 1.0F};
  EXPECT_EQ(bench.controller->request_move(far), firmware::kOutsideWorkspace);
  EXPECT_NE(bench.controller->request(Command::kMove), 0) << "a move has an order";
}

// The tick looks again.
TEST(GuardedMoveRules, AreCheckedAgainInTheTick) {
  Bench bench;
  start(bench);
  ASSERT_EQ(bench.controller->request_move(kShort), 0);
  bench.inputs.e_stop = true;
  bench.tick();
  EXPECT_FALSE(bench.shown().moves_itself);
}

TEST(GuardedMoveRules, RangesAreKept) {
  Bench bench;
  start(bench);
  EXPECT_TRUE(bench.controller->move_in_range(kShort));
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto refused = [&](auto&& change) {
    MoveOrder order = kShort;
    change(order);
    return !bench.controller->move_in_range(order);
  };
  EXPECT_TRUE(refused([](MoveOrder& o) { o.arm = 1; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.target_m.x() = kNan; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.speed_m_s = kNan; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.speed_m_s = 0; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.speed_m_s = link::kMaxMoveSpeed_m_s * 1.01F; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.force_limit_N = kNan; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.force_limit_N = 0.1F; }));
  EXPECT_TRUE(refused([](MoveOrder& o) { o.force_limit_N = link::kMaxMoveForce_N * 1.01F; }));
  // The clamp must lie above the limit, or the limit could never be met.
  const auto bits = std::bit_cast<std::uint32_t>(1.4F);
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("max_force")->id, bits),
            firmware::ParamStatus::kOk);
  EXPECT_FALSE(bench.controller->move_in_range(kShort));
}

TEST(GuardedMoveRules, AlwaysLimitedWhateverTheTipDoes) {
  Bench bench;
  bench.let_jump();
  start(bench);
  ASSERT_EQ(bench.controller->request_move(kShort), 0);
  bench.tick();
  float most_N = 0;
  for (int i = 0; i < 400 && bench.mode() == Mode::kArmed; ++i) {  // thrown about at 0.2 m/s
    bench.move({0.01 * std::sin(0.005 * i), 0, 0.002}, 1);
    if (bench.mode() == Mode::kArmed) most_N = std::max(most_N, bench.force_N());
  }
  std::printf("most force %.3f N with a limit of 1 N\n", static_cast<double>(most_N));
  EXPECT_LE(most_N, 1.5F + 1e-4F);
  EXPECT_NE(bench.mode(), Mode::kArmed) << "the one in the way stops it";
  EXPECT_EQ(bench.controller->move_state().end, link::MoveEnd::kBlocked);
  EXPECT_EQ(bench.controller->fault(), Fault::kNone);
}

TEST(SampleBuffer, KeepsMeansOfAllThatCame) {
  firmware::SampleBuffer buffer;
  constexpr int kCount = 10000;
  for (int i = 0; i < kCount; ++i)
    buffer.add({Vec3(static_cast<float>(i), 1.0F, 0.0F), 2.0F * static_cast<float>(i)});
  const auto samples = buffer.samples();
  ASSERT_GE(samples.size(), firmware::SampleBuffer::kMaxSamples / 2);
  ASSERT_LE(samples.size(), firmware::SampleBuffer::kMaxSamples);
  const float step = samples[1].tip_m.x() - samples[0].tip_m.x();
  std::printf("%zu samples of %.0f ticks\n", samples.size(), static_cast<double>(step));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_NEAR(samples[i].tip_m.x(), (static_cast<float>(i) + 0.5F) * step - 0.5F, 0.05F);
    EXPECT_NEAR(samples[i].force_N, 2.0F * samples[i].tip_m.x(), 0.1F);
    EXPECT_EQ(samples[i].tip_m.y(), 1.0F);
  }
  EXPECT_GT(samples.back().tip_m.x(), static_cast<float>(kCount) - 1.5F * step)
      << "nothing of the end is lost";
}

}  // namespace
}  // namespace thimble::test
