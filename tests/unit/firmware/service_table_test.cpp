// The services of a controller, request by request: each with its answer, and every negative response.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "firmware/link/crc32.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using link::Nrc;
using link::Session;

Bytes negative(std::uint8_t service, Nrc code) { return {0x7F, service, static_cast<std::uint8_t>(code)}; }

// The state of the controller that a row asks.
enum class Setup {
  kFresh,
  kHomed,    // with a scene
  kFaulted,  // e_stop (1) has been seen, host_stop (14) is latched
};

struct ServiceCase {
  const char* what;
  Session session;
  Bytes request;
  Bytes answer;
  Setup setup = Setup::kFresh;
};

constexpr Session kDefault = Session::kDefault, kExtended = Session::kExtended,
                  kProgramming = Session::kProgramming;

const std::vector<ServiceCase>& service_cases() {
  static const std::vector<ServiceCase> table = {
      {"default session", kDefault, {0x10, 0x01}, {0x50, 0x01, 0x00, 0x32, 0x01, 0xF4}},
      {"extended session", kDefault, {0x10, 0x03}, {0x50, 0x03, 0x00, 0x32, 0x01, 0xF4}},
      {"programming session", kDefault, {0x10, 0x02}, {0x50, 0x02, 0x00, 0x32, 0x01, 0xF4}},
      {"no such session", kDefault, {0x10, 0x04}, negative(0x10, Nrc::kSubFunctionNotSupported)},
      {"session too short", kDefault, {0x10}, negative(0x10, Nrc::kIncorrectLength)},
      {"session too long", kDefault, {0x10, 0x01, 0x00}, negative(0x10, Nrc::kIncorrectLength)},

      {"audit record from a number to come",
       kDefault,
       {0x31, 0x03, 0x02, 0x0A, 0, 0, 0x10, 0},
       {0x71, 0x03, 0x02, 0x0A}},
      {"audit record from nowhere",
       kDefault,
       {0x31, 0x03, 0x02, 0x0A},
       negative(0x31, Nrc::kIncorrectLength)},
      {"audit record is not started",
       kExtended,
       {0x31, 0x01, 0x02, 0x0A},
       negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"name of the host", kExtended, {0x2E, 0xF1, 0xAF, 'a'}, {0x6E, 0xF1, 0xAF}},
      {"name that is empty", kExtended, {0x2E, 0xF1, 0xAF}, negative(0x2E, Nrc::kIncorrectLength)},
      {"name with a line feed", kExtended, {0x2E, 0xF1, 0xAF, '\n'}, negative(0x2E, Nrc::kRequestOutOfRange)},
      {"name of a host that has none", kDefault, {0x22, 0xF1, 0xAF}, {0x62, 0xF1, 0xAF}},

      {"reset", kExtended, {0x11, 0x01}, {0x51, 0x01}},
      {"soft reset", kProgramming, {0x11, 0x03}, {0x51, 0x03}},
      {"no such reset", kExtended, {0x11, 0x02}, negative(0x11, Nrc::kSubFunctionNotSupported)},
      {"reset too long", kExtended, {0x11, 0x01, 0x00}, negative(0x11, Nrc::kIncorrectLength)},
      {"reset in the default session", kDefault, {0x11, 0x01}, negative(0x11, Nrc::kNotInThisSession)},

      {"clear all faults", kExtended, {0x14, 0xFF, 0xFF, 0xFF}, {0x54}, Setup::kFaulted},
      {"clear one fault", kExtended, {0x14, 0x00, 0x00, 0x01}, negative(0x14, Nrc::kRequestOutOfRange)},
      {"clear too short", kExtended, {0x14, 0xFF}, negative(0x14, Nrc::kIncorrectLength)},
      {"clear in the default session",
       kDefault,
       {0x14, 0xFF, 0xFF, 0xFF},
       negative(0x14, Nrc::kNotInThisSession)},

      {"how many faults",
       kDefault,
       {0x19, 0x01, 0xFF},
       {0x59, 0x01, 0x09, 0x01, 0x00, 0x02},
       Setup::kFaulted},
      {"how many are active",
       kDefault,
       {0x19, 0x01, 0x01},
       {0x59, 0x01, 0x09, 0x01, 0x00, 0x01},
       Setup::kFaulted},
      {"which faults",
       kDefault,
       {0x19, 0x02, 0xFF},
       {0x59, 0x02, 0x09, 0, 0, 1, 0x08, 0, 0, 14, 0x09},
       Setup::kFaulted},
      {"which are active", kDefault, {0x19, 0x02, 0x01}, {0x59, 0x02, 0x09, 0, 0, 14, 0x09}, Setup::kFaulted},
      {"no such fault report", kDefault, {0x19, 0x0F, 0xFF}, negative(0x19, Nrc::kSubFunctionNotSupported)},
      {"fault report too short", kDefault, {0x19, 0x02}, negative(0x19, Nrc::kIncorrectLength)},
      {"fault report empty", kDefault, {0x19}, negative(0x19, Nrc::kIncorrectLength)},
      {"freeze frames of no fault",
       kDefault,
       {0x19, 0x04, 0, 0, 9, 0xFF},
       negative(0x19, Nrc::kRequestOutOfRange),
       Setup::kFaulted},
      {"freeze frames of a far number",
       kDefault,
       {0x19, 0x04, 1, 0, 14, 0xFF},
       negative(0x19, Nrc::kRequestOutOfRange),
       Setup::kFaulted},
      {"freeze frames of a fault that is not the latched one",
       kDefault,
       {0x19, 0x04, 0, 0, 1, 0xFF},
       {0x59, 0x04, 0, 0, 1, 0x08},
       Setup::kFaulted},
      {"freeze frames too short", kDefault, {0x19, 0x04, 0, 0, 14}, negative(0x19, Nrc::kIncorrectLength)},

      {"read", kDefault, {0x22, 0x01, 0x00}, {0x62, 0x01, 0x00, 0, 0, 0, 0x41}},  // 8.0
      {"read two",
       kDefault,
       {0x22, 0x01, 0x00, 0xF1, 0x86},
       {0x62, 0x01, 0x00, 0, 0, 0, 0x41, 0xF1, 0x86, 0x01}},
      {"read a known one between unknown ones",
       kDefault,
       {0x22, 0x7F, 0xFF, 0xF1, 0x86, 0x7F, 0xFE},
       {0x62, 0xF1, 0x86, 0x01}},
      {"read the session", kExtended, {0x22, 0xF1, 0x86}, {0x62, 0xF1, 0x86, 0x03}},
      {"read nothing", kDefault, {0x22}, negative(0x22, Nrc::kIncorrectLength)},
      {"read half an identifier", kDefault, {0x22, 0x01}, negative(0x22, Nrc::kIncorrectLength)},
      {"read nine",
       kDefault,
       {0x22, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0},
       negative(0x22, Nrc::kIncorrectLength)},
      {"read what is not there", kDefault, {0x22, 0x7F, 0xFF}, negative(0x22, Nrc::kRequestOutOfRange)},
      {"read two that are not there",
       kDefault,
       {0x22, 0x7F, 0xFF, 0x7F, 0xFE},
       negative(0x22, Nrc::kRequestOutOfRange)},

      {"write", kExtended, {0x2E, 0x01, 0x00, 0, 0, 0x80, 0x40}, {0x6E, 0x01, 0x00}},  // 4.0
      {"write too few bytes", kExtended, {0x2E, 0x01, 0x00, 9}, negative(0x2E, Nrc::kIncorrectLength)},
      {"write nothing", kExtended, {0x2E, 0x01, 0x00}, negative(0x2E, Nrc::kIncorrectLength)},
      {"write what is not there",
       kExtended,
       {0x2E, 0x7F, 0xFF, 1, 2, 3, 4},
       negative(0x2E, Nrc::kRequestOutOfRange)},
      {"write a value that is not allowed",
       kExtended,
       {0x2E, 0x01, 0x00, 0, 0, 0x80, 0xC0},
       negative(0x2E, Nrc::kRequestOutOfRange)},  // -4.0
      {"write in the default session",
       kDefault,
       {0x2E, 0x01, 0x00, 0, 0, 0x80, 0x40},
       negative(0x2E, Nrc::kNotInThisSession)},

      {"arm", kExtended, {0x31, 0x01, 0x02, 0x01}, {0x71, 0x01, 0x02, 0x01}, Setup::kHomed},
      {"arm what is not homed",
       kExtended,
       {0x31, 0x01, 0x02, 0x01},
       negative(0x31, Nrc::kConditionsNotCorrect)},
      {"disarm", kExtended, {0x31, 0x01, 0x02, 0x02}, {0x71, 0x01, 0x02, 0x02}},
      {"disarm in the default session", kDefault, {0x31, 0x01, 0x02, 0x02}, {0x71, 0x01, 0x02, 0x02}},
      {"home", kExtended, {0x31, 0x01, 0x02, 0x03}, {0x71, 0x01, 0x02, 0x03}},
      {"activate nothing",
       kProgramming,
       {0x31, 0x01, 0x02, 0x04},
       negative(0x31, Nrc::kConditionsNotCorrect)},
      {"save parameters", kExtended, {0x31, 0x01, 0x02, 0x07}, {0x71, 0x01, 0x02, 0x07}},
      {"arm in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x01},
       negative(0x31, Nrc::kNotInThisSession)},
      {"stop a routine", kExtended, {0x31, 0x02, 0x02, 0x01}, negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"no such routine", kExtended, {0x31, 0x01, 0x7F, 0x01}, negative(0x31, Nrc::kRequestOutOfRange)},
      {"no such routine in the default session",
       kDefault,
       {0x31, 0x01, 0x7F, 0x01},
       negative(0x31, Nrc::kNotInThisSession)},
      {"routine too short", kExtended, {0x31, 0x01, 0x02}, negative(0x31, Nrc::kIncorrectLength)},
      {"end a move", kExtended, {0x31, 0x02, 0x02, 0x06}, {0x71, 0x02, 0x02, 0x06}},
      {"a move in the default session",
       kDefault,
       {0x31, 0x02, 0x02, 0x06},
       negative(0x31, Nrc::kNotInThisSession)},
      {"a move without an order", kExtended, {0x31, 0x01, 0x02, 0x06}, negative(0x31, Nrc::kIncorrectLength)},
      {"end a move with arguments",
       kExtended,
       {0x31, 0x02, 0x02, 0x06, 0},
       negative(0x31, Nrc::kIncorrectLength)},
      {"no such part of a move",
       kExtended,
       {0x31, 0x04, 0x02, 0x06},
       negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"end an order for the axes", kExtended, {0x31, 0x02, 0x02, 0x0F}, {0x71, 0x02, 0x02, 0x0F}},
      {"state of the axes",
       kExtended,
       {0x31, 0x03, 0x02, 0x0F},
       {0x71, 0x03, 0x02, 0x0F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}},
      {"an order for the axes in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x0F},
       negative(0x31, Nrc::kNotInThisSession)},
      {"axes without an order", kExtended, {0x31, 0x01, 0x02, 0x0F}, negative(0x31, Nrc::kIncorrectLength)},
      {"end an order for the axes with arguments",
       kExtended,
       {0x31, 0x02, 0x02, 0x0F, 0},
       negative(0x31, Nrc::kIncorrectLength)},
      {"home without a place", kExtended, {0x31, 0x01, 0x02, 0x10}, negative(0x31, Nrc::kIncorrectLength)},
      {"home at a place in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x10},
       negative(0x31, Nrc::kNotInThisSession)},
      {"a place has no end",
       kExtended,
       {0x31, 0x02, 0x02, 0x10},
       negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"record counts", kExtended, {0x31, 0x01, 0x02, 0x11}, {0x71, 0x01, 0x02, 0x11}, Setup::kHomed},
      {"record counts with arguments",
       kExtended,
       {0x31, 0x01, 0x02, 0x11, 0},
       negative(0x31, Nrc::kIncorrectLength)},
      {"record counts in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x11},
       negative(0x31, Nrc::kNotInThisSession)},
      {"a recording of counts ends as others do",
       kExtended,
       {0x31, 0x02, 0x02, 0x11},
       negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"start a recording", kExtended, {0x31, 0x01, 0x02, 0x08}, {0x71, 0x01, 0x02, 0x08}, Setup::kHomed},
      {"end a recording", kExtended, {0x31, 0x02, 0x02, 0x08}, {0x71, 0x02, 0x02, 0x08}},
      {"what a recording began with, before the first",
       kExtended,
       {0x31, 0x03, 0x02, 0x08},
       negative(0x31, Nrc::kRequestSequenceError)},
      {"a recording in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x08},
       negative(0x31, Nrc::kNotInThisSession)},
      {"a recording with arguments",
       kExtended,
       {0x31, 0x01, 0x02, 0x08, 0},
       negative(0x31, Nrc::kIncorrectLength)},
      {"no such part of a recording",
       kExtended,
       {0x31, 0x04, 0x02, 0x08},
       negative(0x31, Nrc::kSubFunctionNotSupported)},
      {"arm with arguments",
       kExtended,
       {0x31, 0x01, 0x02, 0x01, 0x00},
       negative(0x31, Nrc::kIncorrectLength)},

      {"prepare",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0, 1, 2, 3, 4},
       {0x71, 0x01, 0x02, 0x05, 0, 0, 0, 0}},
      {"prepare in the extended session",
       kExtended,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0, 1, 2, 3, 4},
       negative(0x31, Nrc::kNotInThisSession)},
      {"prepare too much",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0x7F, 0, 0, 0, 1, 2, 3, 4},
       negative(0x31, Nrc::kDownloadNotAccepted)},
      {"prepare without a CRC",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0},
       negative(0x31, Nrc::kIncorrectLength)},
      {"download that was not prepared",
       kProgramming,
       {0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       negative(0x34, Nrc::kRequestSequenceError)},
      {"download compressed",
       kProgramming,
       {0x34, 0x10, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       negative(0x34, Nrc::kRequestOutOfRange)},
      {"download too short",
       kProgramming,
       {0x34, 0x00, 0x44, 0, 0, 0, 0},
       negative(0x34, Nrc::kIncorrectLength)},
      {"download in the extended session",
       kExtended,
       {0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       negative(0x34, Nrc::kNotInThisSession)},
      {"block without a download",
       kProgramming,
       {0x36, 0x01, 0xAA},
       negative(0x36, Nrc::kRequestSequenceError)},
      {"block of nothing", kProgramming, {0x36, 0x01}, negative(0x36, Nrc::kIncorrectLength)},
      {"block in the extended session",
       kExtended,
       {0x36, 0x01, 0xAA},
       negative(0x36, Nrc::kNotInThisSession)},
      {"end without a download", kProgramming, {0x37}, negative(0x37, Nrc::kRequestSequenceError)},
      {"end with data", kProgramming, {0x37, 0x00}, negative(0x37, Nrc::kIncorrectLength)},
      {"end in the extended session", kExtended, {0x37}, negative(0x37, Nrc::kNotInThisSession)},

      {"tester present", kDefault, {0x3E, 0x00}, {0x7E, 0x00}},
      {"tester present with a sub-function",
       kDefault,
       {0x3E, 0x01},
       negative(0x3E, Nrc::kSubFunctionNotSupported)},
      {"tester present too short", kDefault, {0x3E}, negative(0x3E, Nrc::kIncorrectLength)},

      {"no such service", kDefault, {0x27, 0x01}, negative(0x27, Nrc::kServiceNotSupported)},
      {"an answer as a request", kDefault, {0x50, 0x01}, negative(0x50, Nrc::kServiceNotSupported)},
  };
  return table;
}

void set_up(Bench& bench, Setup setup) {
  bench.tick();
  if (setup == Setup::kFresh) return;
  bench.load();
  bench.home();
  if (setup == Setup::kHomed) return;
  bench.ticks(100);  // more than the freeze frames
  ASSERT_EQ(bench.controller->request(Command::kStop), 0U);
  bench.tick();
  bench.inputs.e_stop = true;
  bench.tick();
  bench.inputs.e_stop = false;
  bench.ticks(4000);
  ASSERT_EQ(bench.mode(), Mode::kFaulted);
}

TEST(ServiceTable, EveryRow) {
  for (const ServiceCase& row : service_cases()) {
    Bench bench;
    set_up(bench, row.setup);
    Tester tester(bench);
    if (row.session != kDefault) {
      ASSERT_TRUE(tester.ok({0x10, static_cast<std::uint8_t>(row.session)}));
    }
    EXPECT_EQ(tester.ask(row.request), row.answer) << row.what;
  }
}

TEST(ServiceTable, CoversEveryNegativeResponse) {
  // 10, 14, 21: router_test (a request given up, an answer too long), and BusyReasons of services_test. 72: RefusedImage
  // there. 34, 37, 58: access_test. 71, 73: Download. 78: every row with a job.
  std::set<std::uint8_t> seen = {0x10, 0x14, 0x21, 0x34, 0x37, 0x58, 0x71, 0x72, 0x73, 0x78};
  for (const ServiceCase& row : service_cases())
    if (row.answer.size() == 3 && row.answer[0] == 0x7F) seen.insert(row.answer[2]);
  for (unsigned code = 1; code < 256; ++code) {
    const bool named = std::string(name(static_cast<Nrc>(code))) != "unknown";
    EXPECT_EQ(named, seen.contains(static_cast<std::uint8_t>(code))) << code;
  }
}

TEST(ServiceTable, SuppressedAnswersStillRefuse) {
  Bench bench;
  Tester tester(bench);
  tester.say({0x10, 0x83});
  EXPECT_EQ(tester.seen_answers(), 0);
  EXPECT_EQ(tester.read(link::kDidSession), Bytes{0x03});
  EXPECT_EQ(tester.ask({0x10, 0x84}), negative(0x10, Nrc::kSubFunctionNotSupported));
  tester.say({0x3E, 0x80});
  EXPECT_EQ(tester.seen_answers(), 0);
}

// Not the reason of an earlier refusal.
TEST(ServiceTable, AParameterThatIsLockedWhileArmedSaysWhy) {
  for (const char* parameter : {"host_forces", "stop_damping"}) {
    Bench bench;
    bench.tick();
    bench.load();
    Tester tester(bench, true);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    const auto reason = [&] {
      const Bytes text = tester.read(link::kDidRefusal);
      return std::string(text.begin(), text.end());
    };
    EXPECT_EQ(tester.ask({0x31, 0x01, 0x02, 0x01}), negative(0x31, Nrc::kConditionsNotCorrect));
    ASSERT_EQ(reason(), "not_homed");
    bench.home();
    ASSERT_TRUE(tester.ok({0x31, 0x01, 0x02, 0x01}));
    const std::uint16_t id = firmware::find_param(parameter)->id;
    EXPECT_EQ(
        tester.ask({0x2E, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id), 0, 0, 0, 0}),
        negative(0x2E, Nrc::kConditionsNotCorrect));
    EXPECT_EQ(reason(), "wrong_mode") << parameter;
  }
}

TEST(ServiceTable, OneFreezeFrameOfAFault) {
  Bench bench;
  set_up(bench, Setup::kFaulted);
  Tester tester(bench, true);
  constexpr std::size_t kRecord = 4 + link::wire_size<link::FreezeFrame>();
  const Bytes all = tester.ask({0x19, 0x04, 0, 0, 14, 0xFF});
  ASSERT_EQ(all.size(), 6 + 64 * kRecord);
  EXPECT_EQ(all[6 + 63 * kRecord], 64);
  const Bytes one = tester.ask({0x19, 0x04, 0, 0, 14, 3});
  ASSERT_EQ(one.size(), 6 + kRecord);
  EXPECT_EQ(Bytes(one.begin() + 6, one.end()),
            Bytes(all.begin() + 6 + 2 * kRecord, all.begin() + 6 + 3 * kRecord));
}

// The download, step by step, with a scene of the bench.
class DownloadSteps {
 public:
  explicit DownloadSteps(Bench& bench)
      : tester(bench, true), image(plane_image(1000.0F, 0.0F, 0.0F, "planes", 4)) {
    EXPECT_TRUE(tester.ok({0x10, 0x02}));
  }

  Bytes prepare() { return prepare(firmware::link::crc32(image)); }
  Bytes prepare(std::uint32_t crc) {
    return tester.ask(join({0x31, 0x01, 0x02, 0x05}, big_endian({length(), crc})));
  }
  Bytes begin(std::uint32_t at, std::uint32_t bytes) {
    return tester.ask(join({0x34, 0x00, 0x44}, big_endian({at, bytes})));
  }
  Bytes block(std::uint8_t number, std::size_t from, std::size_t to) {
    Bytes request = {0x36, number};
    for (std::size_t i = from; i < to; ++i)
      request.push_back(i < image.size() ? std::to_integer<std::uint8_t>(image[i]) : std::uint8_t{0});
    return tester.ask(request);
  }
  [[nodiscard]] std::uint32_t length() const { return static_cast<std::uint32_t>(image.size()); }
  static Bytes prepared(std::uint32_t has) { return join({0x71, 0x01, 0x02, 0x05}, big_endian({has})); }

  Tester tester;
  std::vector<std::byte> image;
};

TEST(ServiceTable, Download) {
  Bench bench;
  DownloadSteps steps(bench);
  const std::uint32_t length = steps.length();
  EXPECT_EQ(steps.prepare(), DownloadSteps::prepared(0));
  EXPECT_EQ(steps.begin(0, length - 1), negative(0x34, Nrc::kRequestOutOfRange)) << "not what was prepared";
  EXPECT_FALSE(bench.controller->store().verified());
  EXPECT_EQ(steps.begin(0, length), (Bytes{0x74, 0x20, 0x0F, 0xFF}));
  EXPECT_TRUE(bench.controller->store().downloading());
  EXPECT_EQ(steps.block(2, 0, 3), negative(0x36, Nrc::kWrongBlockCounter));
  EXPECT_EQ(steps.block(1, 0, 3), (Bytes{0x76, 0x01}));
  EXPECT_EQ(steps.block(1, 0, 3), (Bytes{0x76, 0x01})) << "repeated because the answer was lost";
  EXPECT_EQ(bench.controller->store().offset(), 3U) << "but stored once";
  EXPECT_EQ(steps.tester.ask({0x37}), negative(0x37, Nrc::kRequestSequenceError)) << "bytes are missing";
  EXPECT_EQ(steps.block(2, 3, length + 1), negative(0x36, Nrc::kTransferSuspended)) << "more than announced";
  EXPECT_EQ(steps.block(2, 3, length), (Bytes{0x76, 0x02}));
  EXPECT_EQ(steps.tester.ask({0x37}), Bytes{0x77});
  EXPECT_EQ(steps.tester.ask({0x37}), Bytes{0x77}) << "repeated because the answer was lost";
  EXPECT_TRUE(bench.controller->store().verified());
  EXPECT_EQ(steps.tester.ask({0x31, 0x01, 0x02, 0x04}), (Bytes{0x71, 0x01, 0x02, 0x04}));
  EXPECT_EQ(steps.tester.refused({0x31, 0x01, 0x02, 0x04}), Nrc::kConditionsNotCorrect) << "it runs already";
  EXPECT_EQ(bench.controller->store().image_crc(), firmware::link::crc32(steps.image));
}

TEST(ServiceTable, DownloadGoesOnWhereItStopped) {
  Bench bench;
  DownloadSteps steps(bench);
  const std::uint32_t length = steps.length();
  steps.prepare();
  steps.begin(0, length);
  steps.block(1, 0, 3);
  steps.tester.run(2 * 5 * 4000);  // the host is silent for twice the session's timeout
  EXPECT_EQ(steps.block(2, 3, 5), negative(0x36, Nrc::kNotInThisSession));
  ASSERT_TRUE(steps.tester.ok({0x10, 0x02}));
  EXPECT_EQ(steps.block(2, 3, 5), negative(0x36, Nrc::kRequestSequenceError));
  EXPECT_EQ(steps.prepare(), DownloadSteps::prepared(3));
  EXPECT_EQ(steps.begin(3, length - 3), (Bytes{0x74, 0x20, 0x0F, 0xFF}));
  EXPECT_EQ(steps.block(1, 3, length), (Bytes{0x76, 0x01}));
  EXPECT_EQ(steps.tester.ask({0x37}), Bytes{0x77});
  EXPECT_EQ(steps.prepare(1), DownloadSteps::prepared(0)) << "another image begins anew";
}

TEST(ServiceTable, ABadImageEndsTheDownload) {
  Bench bench;
  DownloadSteps steps(bench);
  const std::uint32_t length = steps.length();
  steps.prepare(1);
  steps.begin(0, length);
  steps.block(1, 0, length);
  EXPECT_EQ(steps.tester.ask({0x37}), negative(0x37, Nrc::kProgrammingFailure));
  EXPECT_EQ(steps.tester.ask({0x37}), negative(0x37, Nrc::kRequestSequenceError));
  EXPECT_EQ(steps.block(2, 0, 1), negative(0x36, Nrc::kRequestSequenceError));
}

TEST(ServiceTable, ANewSessionEndsTheDownload) {
  Bench bench;
  DownloadSteps steps(bench);
  steps.prepare();
  steps.begin(0, steps.length());
  ASSERT_TRUE(steps.tester.ok({0x10, 0x02}));
  EXPECT_EQ(steps.block(1, 0, 1), negative(0x36, Nrc::kRequestSequenceError));
}

TEST(ServiceTable, TheBlockCounterWraps) {
  Bench bench;
  DownloadSteps steps(bench);
  ASSERT_GT(steps.length(), 256U) << "in blocks of one byte the counter must wrap";
  steps.prepare();
  steps.begin(0, steps.length());
  for (std::size_t at = 0; at < steps.image.size(); ++at) {
    const auto counter = static_cast<std::uint8_t>(at + 1);
    ASSERT_EQ(steps.block(counter, at, at + 1), (Bytes{0x76, counter}));
  }
  EXPECT_EQ(steps.tester.ask({0x37}), Bytes{0x77});
}

}  // namespace
}  // namespace thimble::test
