// The controller over its link, as a tester speaks to it: ISO-TP and services in, real-time frames out.
#include "firmware/link/services.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "firmware/link/crc32.h"
#include "firmware/link/messages.h"
#include "firmware/services/refusal.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

constexpr std::uint16_t kArm = 0x0201, kDisarm = 0x0202, kHome = 0x0203, kActivate = 0x0204;

TEST(Services, LateTicksAreCountedByTheirLateness) {
  Bench bench;
  Tester tester(bench);
  const std::array<float, 5> late_us = {0.0F, 0.99F, 1.0F, 4999.0F, 5000.0F};
  for (const float late : late_us) {
    bench.inputs.late_us = late;
    bench.tick();
  }
  bench.inputs.late_us = 3.0F;
  link::Lateness told;
  ASSERT_TRUE(link::decode(tester.read(link::Lateness::kId), told));
  EXPECT_EQ(told.below_1us, 2U);
  EXPECT_EQ(told.below_2us, 1U);
  EXPECT_EQ(told.below_5ms, 1U);
  EXPECT_EQ(told.longer, 1U);
  EXPECT_FLOAT_EQ(told.worst_s, 0.005F);
}

TEST(Services, WholeSession) {
  Bench bench({.board = "bench", .reset_reason = "host"});
  Tester tester(bench);
  bench.tick();

  EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x01}), link::Nrc::kNotInThisSession);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));

  // Arming names every condition that stands against it.
  EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x01}), link::Nrc::kConditionsNotCorrect);
  EXPECT_EQ(tester.text(link::kDidRefusal), "not_homed,no_scene");
  EXPECT_EQ(tester.text(link::kDidArmName), "premium-1.5");
  EXPECT_FALSE(tester.text(link::kDidFirmwareVersion).empty());

  EXPECT_EQ(tester.text(link::kDidBoardName), "bench");
  EXPECT_EQ(tester.text(link::kDidResetReason), "host");

  // Parameters.
  const firmware::ParamRow& force = *firmware::find_param("max_force");
  const Bytes id{static_cast<std::uint8_t>(force.id >> 8), static_cast<std::uint8_t>(force.id)};
  const auto value = std::bit_cast<std::array<std::uint8_t, 4>>(3.5F);
  EXPECT_TRUE(tester.ok(join(join({0x2E}, id), Bytes(value.begin(), value.end()))));
  EXPECT_EQ(tester.read(force.id), Bytes(value.begin(), value.end()));
  const auto bad = std::bit_cast<std::array<std::uint8_t, 4>>(-1.0F);
  EXPECT_EQ(tester.refused(join(join({0x2E}, id), Bytes(bad.begin(), bad.end()))),
            link::Nrc::kRequestOutOfRange);
  EXPECT_EQ(tester.refused(join(join({0x2E}, id), {1, 2})), link::Nrc::kIncorrectLength);
  EXPECT_EQ(tester.read(force.id), Bytes(value.begin(), value.end()));

  // Download, activate, home, arm.
  const std::vector<std::byte> image = plane_image(1000.0F, 0.0F, 0.0F, "table");
  ASSERT_TRUE(tester.ok({0x10, 0x02}));
  const Bytes exit = download(tester, image, firmware::crc32(image));
  ASSERT_FALSE(exit.empty());
  EXPECT_EQ(exit[0], 0x77);
  EXPECT_TRUE(tester.routine(kActivate));
  EXPECT_EQ(tester.text(link::kDidSceneName), "table");
  EXPECT_TRUE(tester.routine(kHome));
  EXPECT_TRUE(tester.routine(kArm));
  EXPECT_EQ(bench.mode(), Mode::kArmed);
  std::printf("answers kept waiting (0x78): %d\n", tester.pending);

  // Pressing: the frames say so.
  bench.move({0, 0, -0.002}, 400);
  tester.run(1);  // what the move left to be sent
  tester.seen.clear();
  tester.run(4000);
  int poses = 0, forces = 0, states = 0, beats = 0;
  float deepest_m = 0, strongest_N = 0;
  for (const link::CanFrame& frame : tester.seen) {
    link::Pose pose;
    link::Force felt;
    link::Status status;
    link::Heartbeat beat;
    if (link::from_frame(frame, 1, pose)) {
      ++poses;
      deepest_m = std::min(deepest_m, pose.z_m);
    } else if (link::from_frame(frame, 1, felt)) {
      ++forces;
      strongest_N = std::max(strongest_N, felt.z_N);
      EXPECT_EQ(felt.contacts, 1);
    } else if (link::from_frame(frame, 1, status)) {
      ++states;
      EXPECT_EQ(status.mode, Mode::kArmed);
    } else if (link::from_frame(frame, 1, beat)) {
      ++beats;
      EXPECT_EQ(beat.state, link::NodeState::kArmed);
    }
  }
  std::printf("in 1 s: %d poses, %d forces, %d states, %d heartbeats; depth %.5f m, force %.3f N\n", poses,
              forces, states, beats, static_cast<double>(deepest_m), static_cast<double>(strongest_N));
  EXPECT_EQ(poses, 100);  // 4000 ticks, one record in 40
  EXPECT_EQ(forces, 100);
  EXPECT_NEAR(states, 10, 1);
  EXPECT_NEAR(beats, 2, 1);
  EXPECT_NEAR(deepest_m, -0.002F, 5e-5F);
  EXPECT_NEAR(strongest_N, 2.0F, 0.1F);

  link::DeviceState state;
  ASSERT_TRUE(link::decode(tester.read(link::DeviceState::kId), state));
  std::printf("rate %.1f Hz, contact ticks %u, peak %.3f N, scene %u bytes\n",
              static_cast<double>(state.tick_rate_Hz), state.contact_ticks,
              static_cast<double>(state.peak_force_N), state.scene_bytes);
  EXPECT_NEAR(state.tick_rate_Hz, 4000.0F, 10.0F);
  EXPECT_GT(state.contact_ticks, 4000U);
  EXPECT_EQ(state.scene_bytes, image.size());
  EXPECT_EQ(state.scene_crc, firmware::crc32(image));

  EXPECT_TRUE(tester.routine(kDisarm));
  tester.run(1100);
  EXPECT_EQ(bench.mode(), Mode::kReady);
}

TEST(Services, FaultMemory) {
  Bench bench;
  bench.load();
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  ASSERT_TRUE(tester.routine(kArm));
  tester.run(200);
  tester.seen.clear();
  bench.inputs.e_stop = true;
  tester.run(2);
  link::Emergency emergency;
  const auto found = std::find_if(tester.seen.begin(), tester.seen.end(),
                                  [&](const auto& frame) { return link::from_frame(frame, 1, emergency); });
  ASSERT_NE(found, tester.seen.end());
  EXPECT_EQ(emergency.code, firmware::find_fault(Fault::e_stop)->emergency_code);
  EXPECT_EQ(emergency.fault, static_cast<int>(Fault::e_stop));
  tester.run(1200);
  ASSERT_EQ(bench.mode(), Mode::kFaulted);

  const Bytes memory = tester.ask({0x19, 0x02, 0xFF});
  ASSERT_GE(memory.size(), 3U);
  EXPECT_EQ(memory[0], 0x59);
  // The freeze-frames: the newest is the tick that tripped.
  const Bytes frames = tester.ask({0x19, 0x04, 0x00, 0x00, static_cast<std::uint8_t>(Fault::e_stop), 0xFF});
  constexpr std::size_t kHead = 6, kFrame = 4 + link::wire_size<link::FreezeFrame>();
  ASSERT_EQ(frames.size(), kHead + firmware::kFreezeTicks * kFrame);
  link::FreezeFrame newest;
  ASSERT_TRUE(link::decode(std::span(frames).last(kFrame - 4), newest));
  EXPECT_EQ(newest.tick, emergency.tick);
  EXPECT_EQ(newest.mode, Mode::kDamping);
  std::printf("%zu freeze-frames, the newest of tick %u\n", (frames.size() - kHead) / kFrame, newest.tick);
  EXPECT_EQ(tester.refused({0x14, 0xFF, 0xFF, 0xFF}), link::Nrc::kConditionsNotCorrect);
  EXPECT_EQ(tester.text(link::kDidRefusal), "e_stop_pressed");
  bench.inputs.e_stop = false;
  tester.run(2);
  EXPECT_EQ(bench.mode(), Mode::kFaulted) << "it must not clear itself";
  EXPECT_TRUE(tester.ok({0x14, 0xFF, 0xFF, 0xFF}));
  EXPECT_EQ(bench.mode(), Mode::kReady);
  EXPECT_EQ(bench.controller->fault(), Fault::kNone);
}

// A bad image by the link: refused with its reason, the running scene untouched.
TEST(Services, RefusedImage) {
  Bench bench({}, std::size_t{1} << 15U);
  bench.load();
  bench.home();
  Tester tester(bench, true);
  ASSERT_TRUE(tester.ok({0x10, 0x02}));
  ASSERT_TRUE(tester.routine(kArm));
  const std::uint32_t before = bench.shown().scene_sequence;
  std::vector<std::byte> image = plane_image(1000.0F);
  image.resize(image.size() - 8);
  Bytes exit = download(tester, image, firmware::crc32(image));
  ASSERT_EQ(exit.size(), 3U);
  EXPECT_EQ(exit[2], static_cast<int>(link::Nrc::kProgrammingFailure));
  EXPECT_EQ(tester.text(link::kDidRefusal), "not_a_scene");
  exit = download(tester, image, firmware::crc32(image) + 1);
  ASSERT_EQ(exit.size(), 3U);
  EXPECT_EQ(tester.text(link::kDidRefusal), "wrong_crc");
  image = plane_image(1000.0F, 0.0F, 0.0F, "many", control::kMaxObjects + 1);
  exit = download(tester, image, firmware::crc32(image));
  ASSERT_EQ(exit.size(), 3U);
  EXPECT_EQ(tester.text(link::kDidRefusal), "too_many_objects: 65 objects, at most 64");
  EXPECT_FALSE(tester.routine(kActivate));
  EXPECT_EQ(tester.text(link::kDidRefusal), "no_download");
  EXPECT_EQ(bench.shown().scene_sequence, before);
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

// A guarded move as a tester orders it: refused until allowed, then state, results and stop.
TEST(Services, GuardedMove) {
  Bench bench;
  bench.load(1000.0F, -0.01F);
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  link::MoveOrder order;
  order.target_z_m = 0.002F;
  order.speed_m_s = 0.02F;
  order.force_limit_N = 1.0F;
  Bytes start{0x31, 0x01, 0x02, 0x06};
  start.resize(4 + link::wire_size<link::MoveOrder>());
  const auto encode = [&] { ASSERT_NE(link::encode(order, std::span(start).subspan(4)), 0U); };
  encode();
  EXPECT_EQ(tester.refused(start), link::Nrc::kConditionsNotCorrect);
  EXPECT_EQ(tester.text(link::kDidRefusal), "not_armed,moves_not_allowed");
  const firmware::ParamRow& allow = *firmware::find_param("allow_moves");
  ASSERT_TRUE(tester.ok(
      {0x2E, static_cast<std::uint8_t>(allow.id >> 8), static_cast<std::uint8_t>(allow.id), 1, 0, 0, 0}));
  ASSERT_TRUE(tester.routine(kArm));
  tester.run(900);
  order.speed_m_s = 1.0F;
  encode();
  EXPECT_EQ(tester.refused(start), link::Nrc::kRequestOutOfRange);
  order.speed_m_s = 0.02F;
  encode();
  EXPECT_EQ(tester.refused(Bytes(start.begin(), start.end() - 1)), link::Nrc::kIncorrectLength);
  ASSERT_TRUE(tester.ok(start));
  EXPECT_EQ(tester.refused({0x31, 0x03, 0x02, 0x06}), link::Nrc::kRequestSequenceError) << "it goes";
  link::MoveState state;
  tester.seen.clear();
  for (int i = 0; i < 100; ++i) {  // the hand of this bench follows: 2 mm at 0.02 m/s and the ends
    bench.place(bench.shown().arm[0].god_object_m.cast<double>());
    ASSERT_TRUE(link::decode(tester.read(link::MoveState::kId), state));
    if (state.phase == link::MovePhase::kHolding) break;
    tester.run(10);
  }
  EXPECT_EQ(state.phase, link::MovePhase::kHolding);
  EXPECT_EQ(state.end, link::MoveEnd::kTargetReached);
  link::Status status;
  tester.run(800);
  const auto shown = std::find_if(tester.seen.rbegin(), tester.seen.rend(),
                                  [&](const auto& frame) { return link::from_frame(frame, 1, status); });
  ASSERT_NE(shown, tester.seen.rend());
  EXPECT_TRUE(status.flags.moves_itself) << "a viewer knows that it moves by itself";
  const Bytes results = tester.ask({0x31, 0x03, 0x02, 0x06});
  std::printf("%d samples in %zu bytes\n", state.samples, results.size());
  EXPECT_EQ(results.size(), 4 + state.samples * link::wire_size<link::MoveSample>());
  EXPECT_GT(state.samples, 20);
  EXPECT_TRUE(tester.ok({0x31, 0x02, 0x02, 0x06}));
  EXPECT_FALSE(bench.shown().moves_itself);
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

TEST(Services, OrdersOfForceAreCounted) {
  Bench bench;
  const firmware::ParamRow& host_forces = *firmware::find_param("host_forces");
  ASSERT_EQ(bench.controller->write_param(host_forces.id, 1), firmware::ParamStatus::kOk);
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  ASSERT_TRUE(tester.routine(kArm));
  const auto send = [&](std::uint8_t arm, std::uint8_t sequence, std::uint8_t bytes = 8) {
    link::ForceOrder order;
    order.z_N = 1;
    order.arm = arm;
    order.sequence = sequence;
    link::CanFrame frame = link::to_frame(order, 1);
    frame.size = bytes;
    bench.controller->on_frame(frame, bench.inputs.time_us);
    tester.run(1);
  };
  for (const int sequence : {1, 2, 2, 4, 3, 5}) send(0, static_cast<std::uint8_t>(sequence));
  send(1, 6);
  send(0, 7, 4);
  tester.run(100);
  send(0, 1);
  tester.run(100);
  link::HostOrders orders;
  ASSERT_TRUE(link::decode(tester.read(link::HostOrders::kId), orders));
  EXPECT_EQ(orders.taken, 5U);
  EXPECT_EQ(orders.old, 2U);
  EXPECT_EQ(orders.wrong, 2U);
  EXPECT_EQ(orders.expired, 2U);
}

// The parameters whose column `recorded` says so end a recording, and no other.
TEST(Services, ARecordingEndsBeforeARecordedParameterIsWritten) {
  int ended = 0;
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    Bench bench;
    bench.load();
    bench.home();
    Tester tester(bench);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x08}));
    const Bytes start = tester.ask({0x31, 0x03, 0x02, 0x08});
    EXPECT_EQ(start.size(),
              4 + link::wire_size<link::RecordingStart>() + link::wire_size<link::RecordingArm>());
    const Bytes value = tester.read(row.id);
    ASSERT_TRUE(tester.ok(
        join({0x2E, static_cast<std::uint8_t>(row.id >> 8), static_cast<std::uint8_t>(row.id)}, value)));
    link::RecordingState state;
    ASSERT_TRUE(link::decode(tester.read(link::RecordingState::kId), state));
    const bool recorded = row.recorded == firmware::Recording::kRecorded;
    EXPECT_EQ(static_cast<int>(state.phase),
              static_cast<int>(recorded ? link::RecordingPhase::kEnded : link::RecordingPhase::kRunning))
        << row.name;
    ended += recorded ? 1 : 0;
  }
  EXPECT_EQ(ended, static_cast<int>(firmware::kParamCount) - 5)
      << "all but those of telemetry, event and trial";
}

// Every reason for "busy, repeat", each with its text, and each passing.
TEST(Services, BusyReasons) {
  std::set<std::string> seen;
  Bench bench;
  Tester first(bench, true, 1), second(bench, true, 2);
  ASSERT_NE(first.address(), second.address());
  const std::vector<std::byte> image = plane_image(1000.0F);
  const Bytes prepare = join({0x31, 0x01, 0x02, 0x05},
                             big_endian({static_cast<std::uint32_t>(image.size()), link::crc32(image)}));
  ASSERT_TRUE(first.ok({0x10, 0x02}));
  ASSERT_TRUE(second.ok({0x10, 0x02}));

  // A download belongs to the host that prepared it, until another one that commands prepares one.
  const auto lease_ends = [&] {
    first.run(
        static_cast<int>(firmware::Lease::kTime_us * 1e-6 / static_cast<double>(bench.config.period_s)) + 1);
  };
  ASSERT_TRUE(first.ok(prepare));
  EXPECT_EQ(second.refused(prepare), link::Nrc::kBusyRepeatRequest);
  EXPECT_EQ(second.text(link::kDidRefusal), "other_host_commands");
  seen.insert("other_host_commands");
  EXPECT_EQ(first.text(link::kDidRefusal), "") << "a refusal is its host's own";
  ASSERT_TRUE(first.ok({0x10, 0x02})) << "the same host resumes";
  EXPECT_EQ(download(first, image, link::crc32(image)), Bytes{0x77});
  lease_ends();
  EXPECT_EQ(second.refused({0x36, 0x01, 0xAA}), link::Nrc::kRequestSequenceError);
  EXPECT_EQ(second.refused({0x31, 0x01, 0x02, 0x04}), link::Nrc::kBusyRepeatRequest);
  EXPECT_EQ(second.text(link::kDidRefusal), "other_host_uploads");
  seen.insert("other_host_uploads");
  lease_ends();
  ASSERT_TRUE(first.routine(kActivate));
  lease_ends();
  EXPECT_TRUE(second.ok(prepare));
  EXPECT_EQ(first.refused(prepare), link::Nrc::kBusyRepeatRequest);
  ASSERT_TRUE(second.ok({0x10, 0x01})) << "or its host's session ends";
  EXPECT_TRUE(first.ok(prepare));
  lease_ends();
  ASSERT_TRUE(second.ok({0x10, 0x02}));
  EXPECT_TRUE(second.ok(prepare)) << "who prepares later has it";
  lease_ends();
  EXPECT_EQ(first.refused({0x36, 0x01, 0xAA}), link::Nrc::kRequestSequenceError);
  ASSERT_TRUE(first.ok({0x10, 0x01}));

  // No tick comes: what was posted stays.
  ASSERT_EQ(bench.controller->load_scene(image), firmware::StoreStatus::kOk);
  bench.halted = true;
  for (const Bytes& request : {prepare, Bytes{0x31, 0x01, 0x02, 0x04}, Bytes{0x31, 0x01, 0x02, 0x08}}) {
    EXPECT_EQ(second.refused(Bytes{0x10, 0x02}), link::Nrc::kOk);
    EXPECT_EQ(second.refused(request), link::Nrc::kBusyRepeatRequest);
    EXPECT_EQ(second.text(link::kDidRefusal), "scene_switching");
  }
  seen.insert("scene_switching");
  bench.halted = false;
  bench.tick();
  EXPECT_TRUE(second.ok(prepare));

  ASSERT_EQ(bench.controller->request(Command::kHome), 0U);
  bench.halted = true;
  EXPECT_EQ(second.refused({0x2E, 0x01, 0x00, 0, 0, 0x80, 0x40}), link::Nrc::kBusyRepeatRequest);
  EXPECT_EQ(second.text(link::kDidRefusal), "command_pending");
  seen.insert("command_pending");
  bench.halted = false;
  bench.tick();
  EXPECT_TRUE(second.ok({0x2E, 0x01, 0x00, 0, 0, 0x80, 0x40}));

  ASSERT_TRUE(second.ok({0x11, 0x01}));
  second.run(1);
  EXPECT_EQ(second.refused({0x31, 0x01, 0x02, 0x01}), link::Nrc::kBusyRepeatRequest);
  EXPECT_EQ(second.text(link::kDidRefusal), "restarting");
  seen.insert("restarting");

  for (const firmware::BusyRow& row : firmware::kBusyTable) EXPECT_TRUE(seen.contains(row.name)) << row.name;
  EXPECT_EQ(seen.size(), firmware::kBusyTable.size());
}

// Jobs of several hosts run one after the other; nobody is refused for another's, and who needs none is answered meanwhile.
TEST(Services, JobsOfSeveralHostsWaitForEachOther) {
  Bench bench;
  bench.load();
  Tester first(bench, false, 1), second(bench, false, 2), third(bench, false, 3);
  ASSERT_TRUE(first.ok({0x10, 0x03}));
  ASSERT_TRUE(second.ok({0x10, 0x03}));
  bench.halted = true;
  first.post({0x31, 0x01, 0x02, 0x03});
  second.post({0x31, 0x02, 0x02, 0x06});
  EXPECT_EQ(third.read(link::kDidSession), Bytes{0x01}) << "while two jobs wait for the tick";
  EXPECT_EQ(bench.mode(), Mode::kDisarmed);
  bench.halted = false;
  EXPECT_EQ(first.posted_answer(), (Bytes{0x71, 0x01, 0x02, 0x03}));
  EXPECT_NE(bench.mode(), Mode::kDisarmed);
  EXPECT_EQ(second.posted_answer(), (Bytes{0x71, 0x02, 0x02, 0x06}));
  EXPECT_EQ(first.pending, 1);
  EXPECT_EQ(second.pending, 1);
}

// Only valid commands feed the watchdog, and arming is none of them.
TEST(Services, ArmingDoesNotKeepTheLinkAlive) {
  Bench bench;
  const firmware::ParamRow& supervision = *firmware::find_param("host_supervision");
  ASSERT_EQ(bench.controller->write_param(supervision.id, 1), firmware::ParamStatus::kOk);
  bench.load();
  bench.home();
  Tester tester(bench);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  ASSERT_TRUE(tester.routine(kArm));
  tester.run(3000);
  ASSERT_TRUE(tester.ok({0x3E, 0x00}));
  tester.run(3000);
  EXPECT_EQ(bench.mode(), Mode::kArmed) << "tester-present kept it alive";
  (void)tester.routine(kArm);
  tester.run(2000);
  EXPECT_EQ(bench.controller->fault(), Fault::host_lost);
}

}  // namespace
}  // namespace thimble::test
