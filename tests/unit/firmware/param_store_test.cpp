// Parameters over power-off: whole or not at all, and never a value that is not allowed.
#include "firmware/store/param_store.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using firmware::crc32;
using firmware::Param;
using firmware::Params;
using firmware::ParamStatus;
using firmware::ParamStore;
using firmware::Storage;
using firmware::StoreStatus;

void set(Params& params, Param param, float value) {
  const firmware::ParamRow& row = firmware::kParamTable[static_cast<std::size_t>(param)];
  const std::uint32_t bits = row.type == firmware::ParamType::kFloat ? std::bit_cast<std::uint32_t>(value)
                                                                     : static_cast<std::uint32_t>(value);
  ASSERT_EQ(params.write(row.id, bits, true), ParamStatus::kOk) << row.name;
}

float loaded(Storage& storage, Param param) {
  Params params;
  ParamStore(storage).load(params);
  return params.get(param);
}

// Cuts the power after every byte that the storage erases or writes.
TEST(ParamStore, SurvivesPowerLossAtEveryByte) {
  int cuts = 0, kept_old = 0;
  for (const bool downwards : {false, true}) {
    for (std::size_t budget = 0;; ++budget, ++cuts) {
      TestStorage storage;
      storage.erase_downwards = downwards;
      Params params;
      ParamStore store(storage);
      for (const float value : {1.0F, 2.0F}) {  // both slots are in use
        set(params, Param::max_force, value);
        ASSERT_EQ(store.save(params), StoreStatus::kOk);
      }
      storage.power_left = budget;
      set(params, Param::max_force, 3.0F);
      const bool done = store.save(params) == StoreStatus::kOk;
      storage.power_left = std::numeric_limits<std::size_t>::max();
      ASSERT_EQ(loaded(storage, Param::max_force), done ? 3.0F : 2.0F) << "after byte " << budget;
      EXPECT_FALSE(storage.overwritten);
      if (done) break;
      ++kept_old;
    }
  }
  std::printf("%d cuts\n", cuts);
  EXPECT_EQ(kept_old, cuts);
  EXPECT_GT(cuts, 2 * static_cast<int>(2 * firmware::kParamCount * 8));
}

TEST(ParamStore, ForgetsWhatIsNotAllowedNotKnownOrNotForEver) {
  TestStorage storage;
  Params params;
  set(params, Param::max_force, 2.0F);
  set(params, Param::stop_time, 0.2F);
  set(params, Param::allow_moves, 1.0F);
  ASSERT_EQ(ParamStore(storage).save(params), StoreStatus::kOk);
  EXPECT_EQ(loaded(storage, Param::allow_moves), 0.0F);
  EXPECT_EQ(loaded(storage, Param::stop_time), 0.2F);

  // A set with a sound CRC, by a firmware that had other parameters and limits: max_force is beyond the limit, one id unknown.
  std::array<std::byte, 16> other{};
  const auto put = [&other](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) other[at + i] = static_cast<std::byte>(value >> (8 * i));
  };
  put(0, firmware::find_param("max_force")->id);
  put(4, std::bit_cast<std::uint32_t>(1.0e6F));
  put(8, 0xFFFF);
  const auto header = encode(firmware::SlotMagic::kParams, {7, sizeof(other), crc32(other)});
  ASSERT_TRUE(storage.erase(2, 256) && storage.write(2, firmware::kSlotHeaderBytes, other) &&
              storage.write(2, 0, header));
  EXPECT_EQ(loaded(storage, Param::max_force), Params().get(Param::max_force));
}

// Column `persistent` of params.def decides, for every row.
TEST(ParamStore, KeepsThePersistentParametersAndNoOther) {
  TestStorage storage;
  Params params;
  for (const firmware::ParamRow& row : firmware::kParamTable)
    set(params, static_cast<Param>(&row - firmware::kParamTable.data()),
        row.initial == row.max ? row.min : row.max);
  ASSERT_EQ(ParamStore(storage).save(params), StoreStatus::kOk);
  Params after;
  ParamStore(storage).load(after);
  const Params defaults;
  int kept = 0;
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    const auto param = static_cast<Param>(&row - firmware::kParamTable.data());
    const bool persistent = row.persistent == firmware::Persistence::kPersistent;
    EXPECT_EQ(after.get_unsigned(param), (persistent ? params : defaults).get_unsigned(param)) << row.name;
    kept += persistent ? 1 : 0;
  }
  std::printf("%d of %zu parameters are persistent\n", kept, firmware::kParamCount);
  EXPECT_FALSE(firmware::row_of(Param::allow_moves).persistent == firmware::Persistence::kPersistent)
      << "a permission to move is for one session";
}

// Through the controller: refused while the motors are on, there after a restart.
TEST(ParamStore, IsTheControllersOverARestart) {
  Bench bench;
  bench.start();
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("telemetry_decimation")->id, 7),
            ParamStatus::kOk);
  EXPECT_EQ(bench.controller->save_params(), StoreStatus::kBusy);
  ASSERT_EQ(bench.controller->request(Command::kDisarm), 0U);
  bench.ticks(4000);
  ASSERT_EQ(bench.mode(), Mode::kReady);
  EXPECT_EQ(bench.controller->save_params(), StoreStatus::kOk);
  const Controller again(bench.config, bench.storage);
  std::uint32_t bits = 0;
  ASSERT_EQ(again.read_param(firmware::find_param("telemetry_decimation")->id, bits), ParamStatus::kOk);
  EXPECT_EQ(bits, 7U);
}

}  // namespace
}  // namespace thimble::test
