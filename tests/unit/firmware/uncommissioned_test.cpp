// An arm image whose file has not passed a commissioning: it is not armed with more than 1 N, unless a parameter allows it.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

#include "firmware/core/force_limits.h"
#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/paddle_image.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using firmware::kNotCommissioned;
using firmware::Param;
using link::Nrc;

enum class Arm { kBuiltIn, kProved, kUnproved };

std::uint32_t bits_of(float value) { return std::bit_cast<std::uint32_t>(value); }

// Homed, with a scene.
struct Rig {
  explicit Rig(Arm first, Arm second = Arm::kBuiltIn, float most_N = 3) {
    bench.config.arm_count = 2;
    bench.config.arm[1].base.home_m = {0.3F, 0, 0};
    firmware::ArmStore store(bench.storage);
    for (const auto& [index, arm] : {std::pair{0U, first}, std::pair{1U, second}}) {
      if (arm == Arm::kBuiltIn) continue;
      EXPECT_EQ(upload(store, index, paddle_image("paddle", true, arm == Arm::kProved, most_N)),
                firmware::StoreStatus::kOk);
    }
    bench.restart("power_on");
    bench.load();
    bench.home();
  }
  void set(Param param, std::uint32_t bits) {
    EXPECT_EQ(bench.controller->write_param(row_of(param).id, bits), firmware::ParamStatus::kOk);
    bench.tick();
  }
  firmware::Conditions refused_by() { return bench.controller->request(Command::kArm); }

  Bench bench;
};

TEST(Uncommissioned, OnlySuchAnArmIsRefused) {
  using enum Arm;
  EXPECT_EQ(Rig(kBuiltIn).refused_by(), 0U);
  EXPECT_EQ(Rig(kProved, kProved).refused_by(), 0U);
  EXPECT_EQ(Rig(kUnproved).refused_by(), kNotCommissioned);
  EXPECT_EQ(Rig(kProved, kUnproved).refused_by(), kNotCommissioned);
  EXPECT_EQ(Rig(kBuiltIn, kUnproved).refused_by(), kNotCommissioned);
  EXPECT_EQ(Rig(kUnproved, kBuiltIn, 1).refused_by(), 0U) << "it cannot give more than 1 N";
}

TEST(Uncommissioned, OneNewtonArmsIt) {
  Rig rig(Arm::kUnproved);
  rig.set(Param::max_force, bits_of(1.001F));
  EXPECT_EQ(rig.refused_by(), kNotCommissioned);
  rig.set(Param::max_force, bits_of(1));
  rig.bench.arm();
  EXPECT_EQ(rig.bench.mode(), Mode::kArmed);
}

// Neither by a host that sees no arming refused, nor by one that changes its mind.
TEST(Uncommissioned, ArmedItStaysBelow) {
  Rig rig(Arm::kUnproved);
  rig.set(Param::max_force, bits_of(1));
  rig.bench.arm();
  rig.bench.alive = true;
  Tester host(rig.bench);
  const auto write = [&](Param param, std::uint32_t bits) {
    const std::uint16_t id = row_of(param).id;
    Bytes request = {0x2E, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id)};
    for (int i = 0; i < 4; ++i) request.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
    return host.refused(request);
  };
  EXPECT_TRUE(host.ok({0x10, 0x03}));
  for (const float more_N : {1.001F, 8.0F, 20.0F}) {
    EXPECT_EQ(write(Param::max_force, bits_of(more_N)), Nrc::kConditionsNotCorrect) << more_N;
    EXPECT_EQ(host.text(link::kDidRefusal), "arm_not_commissioned");
  }
  EXPECT_EQ(write(Param::allow_uncommissioned, 1), Nrc::kConditionsNotCorrect) << "while it is armed";
  EXPECT_EQ(write(Param::max_force, bits_of(.5F)), Nrc::kOk);
  EXPECT_EQ(write(Param::max_force, bits_of(1)), Nrc::kOk);
  EXPECT_EQ(rig.bench.mode(), Mode::kArmed);
}

TEST(Uncommissioned, TheBraveAllowItAndItIsRecorded) {
  Rig rig(Arm::kUnproved);
  Tester host(rig.bench);
  constexpr std::uint16_t id = row_of(Param::allow_uncommissioned).id;
  const Bytes allow = {0x2E, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id), 1, 0, 0, 0};
  EXPECT_TRUE(host.ok({0x10, 0x03}));
  EXPECT_TRUE(host.ok(allow));
  const std::vector<link::AuditRecord> audit = audit_page(host, 0);
  EXPECT_TRUE(std::ranges::any_of(audit, [](const link::AuditRecord& entry) {
    return entry.event == link::AuditEvent::kParameter && entry.detail == id && entry.value == 1;
  }));
  rig.bench.alive = true;
  rig.bench.arm();
  EXPECT_EQ(rig.bench.mode(), Mode::kArmed);
}

}  // namespace
}  // namespace thimble::test
