// One host commands, the others look (firmware/services/lease.h): random orders of hosts against a model, what is a command, and whose
// requests are a sign of life.
#include "firmware/services/lease.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include "firmware/params.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using link::Nrc;

const Bytes kOpen = {0x10, 0x03}, kArmIt = {0x31, 0x01, 0x02, 0x01}, kDisarmIt = {0x31, 0x01, 0x02, 0x02},
            kHomeIt = {0x31, 0x01, 0x02, 0x03}, kSaveAll = {0x31, 0x01, 0x02, 0x07},
            kClearAll = {0x14, 0xFF, 0xFF, 0xFF};

Bytes write_request(firmware::Param param, float value) {
  const std::uint16_t id = firmware::row_of(param).id;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  Bytes request = {0x2E, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id)};
  for (unsigned i = 0; i < 4; ++i) request.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  return request;
}

int ticks_of(double seconds) {
  return static_cast<int>(seconds / static_cast<double>(firmware::Config{}.period_s));
}

// A homed controller with a scene, and hosts in the extended session.
struct Hosts {
  Bench bench;
  std::array<std::unique_ptr<Tester>, 3> host;

  Hosts() {
    bench.load();
    for (std::size_t i = 0; i < host.size(); ++i) {
      host[i] = std::make_unique<Tester>(bench, false, 11 + i);
      EXPECT_TRUE(host[i]->ok(kOpen));
    }
    EXPECT_TRUE(host[0]->ok(kHomeIt));
    host[0]->run(4);
    EXPECT_EQ(bench.mode(), Mode::kReady);
    host[0]->run(ticks_of(1.6));
  }
  std::uint8_t commander(Tester& asks) {
    link::DeviceState state;
    EXPECT_TRUE(link::decode(asks.read(link::DeviceState::kId), state));
    return state.commander;
  }
};

// What the documents say, without the controller's code: who holds the lease, and since when.
struct LeaseModel {
  std::optional<std::size_t> holder;
  std::uint64_t commanded_us = 0;
  bool ordered_arm = false;

  [[nodiscard]] std::optional<std::size_t> at(std::uint64_t now_us, bool active) const {
    return (ordered_arm && active) || now_us - commanded_us < 1'500'000 ? holder : std::nullopt;
  }
};

TEST(Lease, RandomOrdersOfThreeHosts) {
  Hosts hosts;
  Bench& bench = hosts.bench;
  LeaseModel model;
  std::mt19937 random(1);
  std::array<int, 3> refused{};  // not yet, while active, allowed
  for (int i = 0; i < 1500; ++i) {
    for (const auto& host : hosts.host) EXPECT_EQ(host->read(link::kDidSession), Bytes{0x03});
    const std::size_t who = random() % hosts.host.size();
    Tester& host = *hosts.host[who];
    const bool armed = bench.mode() == Mode::kArmed;
    const bool active = armed || bench.mode() == Mode::kHoming;
    const std::uint64_t now_us = bench.inputs.time_us;
    const std::optional<std::size_t> holder = model.at(now_us, active);
    EXPECT_EQ(hosts.commander(host), holder ? hosts.host[*holder]->address() : 0);
    switch (random() % 8) {
      case 0:
        host.run(ticks_of(std::uniform_real_distribution<>(0, 2)(random)));
        break;
      case 1:
        EXPECT_TRUE(host.ok(kDisarmIt)) << "a stop is anybody's";
        host.run(static_cast<int>(random() % 2000));
        break;
      case 2:
        if (random() % 2 == 0) {
          EXPECT_TRUE(host.ok({0x10, 0x01}));
          EXPECT_TRUE(host.ok(kOpen));
        } else {
          EXPECT_TRUE(host.ok({0x31, 0x02, 0x02, 0x0C}));
        }
        if (model.holder == who) model.holder.reset();
        break;
      default: {
        const Bytes request =
            random() % 3 == 0 ? kArmIt : write_request(firmware::Param::force_slew, 9000.0F);
        const Nrc answer = host.refused(request);
        if (holder && *holder != who) {
          EXPECT_EQ(answer, armed ? Nrc::kConditionsNotCorrect : Nrc::kBusyRepeatRequest);
          EXPECT_EQ(host.text(link::kDidRefusal), armed ? "other_hosts_arm" : "other_host_commands");
          ++refused[armed ? 1 : 0];
        } else {
          EXPECT_NE(answer, Nrc::kBusyRepeatRequest);
          EXPECT_FALSE(answer == Nrc::kConditionsNotCorrect &&
                       host.text(link::kDidRefusal) == "other_hosts_arm");
          model = {who, now_us, request == kArmIt || (model.ordered_arm && model.holder == who)};
          ++refused[2];
        }
      }
    }
    if (HasFailure()) return;
  }
  std::printf(
      "[figure] of 1500 turns %d commands were refused while another host commanded, %d while its arm was "
      "active, %d were taken\n",
      refused[0], refused[1], refused[2]);
  for (const int count : refused) EXPECT_GT(count, 100);
}

TEST(Lease, WhatIsACommandAndWhatIsNot) {
  Hosts hosts;
  Tester& commands = *hosts.host[0];
  Tester& looks = *hosts.host[1];
  ASSERT_TRUE(looks.ok({0x10, 0x02}));
  const Bytes move = join({0x31, 0x01, 0x02, 0x06}, Bytes(link::wire_size<link::MoveOrder>()));
  const Bytes axes = join({0x31, 0x01, 0x02, 0x0F}, Bytes(link::wire_size<link::AxisOrder>()));
  const Bytes place = join({0x31, 0x01, 0x02, 0x10}, Bytes(link::wire_size<link::HomePlace>()));
  const Bytes prepare = {0x31, 0x01, 0x02, 0x05, 0, 0, 0, 64, 0, 0, 0, 0};
  const Bytes download = {0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 0, 64};
  for (const Bytes& request :
       {Bytes{0x31, 0x01, 0x02, 0x0C}, kArmIt, kHomeIt, kSaveAll, kClearAll, move, axes, place, prepare,
        download, Bytes{0x36, 0x01, 0xAA}, Bytes{0x37}, Bytes{0x11, 0x01}, Bytes{0x31, 0x01, 0x02, 0x04},
        Bytes{0x31, 0x01, 0x02, 0x08}, Bytes{0x31, 0x01, 0x02, 0x11},
        write_request(firmware::Param::max_force, 8.5F),
        write_request(firmware::Param::max_tip_speed, 0.5F)}) {
    ASSERT_TRUE(commands.ok(kSaveAll));
    EXPECT_EQ(looks.refused(request), Nrc::kBusyRepeatRequest) << int{request[0]} << " " << int{request[1]};
    EXPECT_EQ(looks.text(link::kDidRefusal), "other_host_commands");
    EXPECT_EQ(hosts.commander(looks), commands.address());
  }
  EXPECT_EQ(hosts.bench.mode(), Mode::kReady);
  for (const Bytes& request :
       {kDisarmIt, Bytes{0x31, 0x02, 0x02, 0x06}, Bytes{0x31, 0x02, 0x02, 0x0F},
        Bytes{0x31, 0x02, 0x02, 0x08}, Bytes{0x19, 0x02, 0xFF}, Bytes{0x3E, 0x00},
        write_request(firmware::Param::max_force, 4.0F), Bytes{0x2E, 0x01, 0x70, 10, 0, 0, 0}}) {
    ASSERT_TRUE(commands.ok(kSaveAll));
    EXPECT_TRUE(looks.ok(request)) << int{request[0]} << " " << int{request[1]};
    EXPECT_EQ(hosts.commander(looks), commands.address());
  }
}

// A host that was killed while its arm is armed: the lease ends with its place.
TEST(Lease, OfAnArmedArmEndsWithThePlaceOfItsHost) {
  Hosts hosts;
  ASSERT_TRUE(hosts.host[0]->ok(kSaveAll));  // a sign of life, without which it would not arm
  ASSERT_TRUE(hosts.host[0]->ok(kArmIt));
  Tester& other = *hosts.host[1];
  const Bytes raise = write_request(firmware::Param::max_force, 9.0F);
  int silent = 0;
  for (; hosts.commander(other) != 0 && silent < 100; ++silent) {
    ASSERT_EQ(other.refused(raise), Nrc::kConditionsNotCorrect);
    other.run(ticks_of(0.1));
  }
  std::printf("[figure] %.1f s after its host fell silent an armed arm takes another host's commands\n",
              0.1 * silent);
  EXPECT_GT(silent, 45);
  EXPECT_LT(silent, 55);
  EXPECT_EQ(hosts.bench.mode(), Mode::kArmed);
  EXPECT_TRUE(other.ok(raise));
}

// With supervision, what another host asks does not keep the arm of a silent one alive.
TEST(Lease, OnlyTheCommandingHostsRequestsAreASignOfLife) {
  for (const std::size_t alive : {0U, 1U}) {
    Hosts hosts;
    ASSERT_TRUE(hosts.host[0]->ok({0x2E, 0x01, 0x21, 1, 0, 0, 0}));
    ASSERT_TRUE(hosts.host[0]->ok(kArmIt));
    for (int i = 0; i < 30; ++i) {
      EXPECT_TRUE(hosts.host[alive]->ok({0x3E, 0x00}));
      hosts.host[alive]->run(ticks_of(0.1));
    }
    EXPECT_EQ(hosts.bench.controller->fault(), alive == 0 ? Fault::kNone : Fault::host_lost);
  }
}

// Also where it may be silent for longer than its place lasts. Who arms the armed arm then keeps it.
TEST(Lease, WhoLooksDoesNotKeepTheArmOfAHostThatVanished) {
  for (const bool takes_over : {false, true}) {
    Hosts hosts;
    Tester& owner = *hosts.host[0];
    Tester& other = *hosts.host[1];
    ASSERT_TRUE(owner.ok(write_request(firmware::Param::link_timeout, 8.0F)));
    ASSERT_TRUE(owner.ok({0x2E, 0x01, 0x21, 1, 0, 0, 0}));
    ASSERT_TRUE(owner.ok(kArmIt));
    int silent = 0;
    for (; hosts.bench.controller->fault() == Fault::kNone && silent < 120; ++silent) {
      EXPECT_TRUE(other.ok({0x3E, 0x00}));
      other.run(ticks_of(0.1));
      if (takes_over && silent == 60) {
        ASSERT_TRUE(other.ok(kArmIt));
      }
    }
    EXPECT_EQ(hosts.bench.controller->fault(), takes_over ? Fault::kNone : Fault::host_lost);
    EXPECT_NEAR(silent, takes_over ? 120 : 80, 5);
  }
}

}  // namespace
}  // namespace thimble::test
