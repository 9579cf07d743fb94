// The services: a table of requests and answers with every negative response, sessions, downloads, pending
// work.
#include "firmware/link/service_server.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/unit/link/fake_backend.h"

namespace thimble::firmware::link {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A server and the host's end of the line, without a channel between that could lose anything.
class Bench {
 public:
  FakeBackend backend;
  ServiceServer server{backend, 1};
  IsoTpChannel host{request_id(1), response_id(1), {.fd = true}};
  Micros now = 1'000'000;

  // The next answer; nothing when there is none.
  Bytes ask(const Bytes& request) {
    EXPECT_TRUE(host.send(request, now));
    return answer();
  }
  Bytes answer() {
    CanFrame frame;
    for (int i = 0; i < 2000; ++i) {
      now += 10;
      while (host.next_frame(frame, now)) EXPECT_TRUE(server.on_frame(frame, now));
      while (server.next_frame(frame, now)) EXPECT_TRUE(host.on_frame(frame, now));
      if (!host.received().empty()) {
        Bytes answer(host.received().begin(), host.received().end());
        host.release();
        return answer;
      }
    }
    return {};
  }
  Bytes session(Session which) { return ask({0x10, static_cast<std::uint8_t>(which)}); }
};

Bytes refusal(std::uint8_t service, Nrc code) { return {0x7F, service, static_cast<std::uint8_t>(code)}; }

struct Row {
  const char* what;
  Session session;
  Bytes request;
  Bytes answer;
};

constexpr Session kDefault = Session::kDefault, kExtended = Session::kExtended,
                  kProgramming = Session::kProgramming;

const std::vector<Row>& table() {
  static const std::vector<Row> rows = {
      {"default session", kDefault, {0x10, 0x01}, {0x50, 0x01, 0x00, 0x32, 0x01, 0xF4}},
      {"extended session", kDefault, {0x10, 0x03}, {0x50, 0x03, 0x00, 0x32, 0x01, 0xF4}},
      {"programming session", kDefault, {0x10, 0x02}, {0x50, 0x02, 0x00, 0x32, 0x01, 0xF4}},
      {"no such session", kDefault, {0x10, 0x04}, refusal(0x10, Nrc::kSubFunctionNotSupported)},
      {"session too short", kDefault, {0x10}, refusal(0x10, Nrc::kIncorrectLength)},
      {"session too long", kDefault, {0x10, 0x01, 0x00}, refusal(0x10, Nrc::kIncorrectLength)},

      {"reset", kExtended, {0x11, 0x01}, {0x51, 0x01}},
      {"soft reset", kProgramming, {0x11, 0x03}, {0x51, 0x03}},
      {"no such reset", kExtended, {0x11, 0x02}, refusal(0x11, Nrc::kSubFunctionNotSupported)},
      {"reset too long", kExtended, {0x11, 0x01, 0x00}, refusal(0x11, Nrc::kIncorrectLength)},
      {"reset in the default session", kDefault, {0x11, 0x01}, refusal(0x11, Nrc::kNotInThisSession)},

      {"clear all faults", kExtended, {0x14, 0xFF, 0xFF, 0xFF}, {0x54}},
      {"clear one fault", kExtended, {0x14, 0x00, 0x00, 0x01}, refusal(0x14, Nrc::kRequestOutOfRange)},
      {"clear too short", kExtended, {0x14, 0xFF}, refusal(0x14, Nrc::kIncorrectLength)},
      {"clear in the default session",
       kDefault,
       {0x14, 0xFF, 0xFF, 0xFF},
       refusal(0x14, Nrc::kNotInThisSession)},

      {"how many faults", kDefault, {0x19, 0x01, 0xFF}, {0x59, 0x01, 0x09, 0x01, 0x00, 0x02}},
      {"how many are active", kDefault, {0x19, 0x01, 0x01}, {0x59, 0x01, 0x09, 0x01, 0x00, 0x01}},
      {"which faults", kDefault, {0x19, 0x02, 0xFF}, {0x59, 0x02, 0x09, 0, 0, 5, 0x09, 0, 0, 7, 0x08}},
      {"which are active", kDefault, {0x19, 0x02, 0x01}, {0x59, 0x02, 0x09, 0, 0, 5, 0x09}},
      {"no such fault report", kDefault, {0x19, 0x0F, 0xFF}, refusal(0x19, Nrc::kSubFunctionNotSupported)},
      {"fault report too short", kDefault, {0x19, 0x02}, refusal(0x19, Nrc::kIncorrectLength)},
      {"fault report empty", kDefault, {0x19}, refusal(0x19, Nrc::kIncorrectLength)},
      {"freeze frames of no fault",
       kDefault,
       {0x19, 0x04, 0, 0, 9, 0xFF},
       refusal(0x19, Nrc::kRequestOutOfRange)},
      {"freeze frames of a far number",
       kDefault,
       {0x19, 0x04, 1, 0, 5, 0xFF},
       refusal(0x19, Nrc::kRequestOutOfRange)},
      {"freeze frames too short", kDefault, {0x19, 0x04, 0, 0, 5}, refusal(0x19, Nrc::kIncorrectLength)},

      {"read", kDefault, {0x22, 0x01, 0x00}, {0x62, 0x01, 0x00, 1, 2, 3, 4}},
      {"read two",
       kDefault,
       {0x22, 0x01, 0x00, 0xF1, 0x86},
       {0x62, 0x01, 0x00, 1, 2, 3, 4, 0xF1, 0x86, 0x01}},
      {"read the session", kExtended, {0x22, 0xF1, 0x86}, {0x62, 0xF1, 0x86, 0x03}},
      {"read nothing", kDefault, {0x22}, refusal(0x22, Nrc::kIncorrectLength)},
      {"read half an identifier", kDefault, {0x22, 0x01}, refusal(0x22, Nrc::kIncorrectLength)},
      {"read nine",
       kDefault,
       {0x22, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0},
       refusal(0x22, Nrc::kIncorrectLength)},
      {"read what is not there", kDefault, {0x22, 0x7F, 0xFF}, refusal(0x22, Nrc::kRequestOutOfRange)},
      {"read what is too long", kDefault, {0x22, 0x02, 0x00}, refusal(0x22, Nrc::kResponseTooLong)},

      {"write", kExtended, {0x2E, 0x01, 0x00, 9, 8, 7, 6}, {0x6E, 0x01, 0x00}},
      {"write too few bytes", kExtended, {0x2E, 0x01, 0x00, 9}, refusal(0x2E, Nrc::kIncorrectLength)},
      {"write nothing", kExtended, {0x2E, 0x01, 0x00}, refusal(0x2E, Nrc::kIncorrectLength)},
      {"write what is not there",
       kExtended,
       {0x2E, 0x7F, 0xFF, 1, 2, 3, 4},
       refusal(0x2E, Nrc::kRequestOutOfRange)},
      {"write in the default session",
       kDefault,
       {0x2E, 0x01, 0x00, 9, 8, 7, 6},
       refusal(0x2E, Nrc::kNotInThisSession)},

      {"arm", kExtended, {0x31, 0x01, 0x02, 0x01}, {0x71, 0x01, 0x02, 0x01}},
      {"disarm", kExtended, {0x31, 0x01, 0x02, 0x02}, {0x71, 0x01, 0x02, 0x02}},
      {"disarm in the default session", kDefault, {0x31, 0x01, 0x02, 0x02}, {0x71, 0x01, 0x02, 0x02}},
      {"home", kExtended, {0x31, 0x01, 0x02, 0x03}, {0x71, 0x01, 0x02, 0x03}},
      {"activate", kProgramming, {0x31, 0x01, 0x02, 0x04}, {0x71, 0x01, 0x02, 0x04}},
      {"arm in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x01},
       refusal(0x31, Nrc::kNotInThisSession)},
      {"stop a routine", kExtended, {0x31, 0x02, 0x02, 0x01}, refusal(0x31, Nrc::kSubFunctionNotSupported)},
      {"no such routine", kExtended, {0x31, 0x01, 0x7F, 0x01}, refusal(0x31, Nrc::kRequestOutOfRange)},
      {"routine too short", kExtended, {0x31, 0x01, 0x02}, refusal(0x31, Nrc::kIncorrectLength)},
      {"end a move", kExtended, {0x31, 0x02, 0x02, 0x06}, {0x71, 0x02, 0x02, 0x06}},
      {"a move in the default session",
       kDefault,
       {0x31, 0x02, 0x02, 0x06},
       refusal(0x31, Nrc::kNotInThisSession)},
      {"a move without an order", kExtended, {0x31, 0x01, 0x02, 0x06}, refusal(0x31, Nrc::kIncorrectLength)},
      {"end a move with arguments",
       kExtended,
       {0x31, 0x02, 0x02, 0x06, 0},
       refusal(0x31, Nrc::kIncorrectLength)},
      {"no such part of a move",
       kExtended,
       {0x31, 0x04, 0x02, 0x06},
       refusal(0x31, Nrc::kSubFunctionNotSupported)},
      {"start a trace", kExtended, {0x31, 0x01, 0x02, 0x08}, {0x71, 0x01, 0x02, 0x08}},
      {"end a trace", kExtended, {0x31, 0x02, 0x02, 0x08}, {0x71, 0x02, 0x02, 0x08}},
      {"what a trace began with",
       kExtended,
       {0x31, 0x03, 0x02, 0x08},
       {0x71, 0x03, 0x02, 0x08, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}},
      {"a trace in the default session",
       kDefault,
       {0x31, 0x01, 0x02, 0x08},
       refusal(0x31, Nrc::kNotInThisSession)},
      {"a trace with arguments",
       kExtended,
       {0x31, 0x01, 0x02, 0x08, 0},
       refusal(0x31, Nrc::kIncorrectLength)},
      {"no such part of a trace",
       kExtended,
       {0x31, 0x04, 0x02, 0x08},
       refusal(0x31, Nrc::kSubFunctionNotSupported)},
      {"arm with arguments", kExtended, {0x31, 0x01, 0x02, 0x01, 0x00}, refusal(0x31, Nrc::kIncorrectLength)},

      {"prepare",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0, 1, 2, 3, 4},
       {0x71, 0x01, 0x02, 0x05, 0, 0, 0, 0}},
      {"prepare in the extended session",
       kExtended,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0, 1, 2, 3, 4},
       refusal(0x31, Nrc::kNotInThisSession)},
      {"prepare too much",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0x7F, 0, 0, 0, 1, 2, 3, 4},
       refusal(0x31, Nrc::kDownloadNotAccepted)},
      {"prepare without a CRC",
       kProgramming,
       {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0},
       refusal(0x31, Nrc::kIncorrectLength)},
      {"download that was not prepared",
       kProgramming,
       {0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       refusal(0x34, Nrc::kRequestSequenceError)},
      {"download compressed",
       kProgramming,
       {0x34, 0x10, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       refusal(0x34, Nrc::kRequestOutOfRange)},
      {"download too short",
       kProgramming,
       {0x34, 0x00, 0x44, 0, 0, 0, 0},
       refusal(0x34, Nrc::kIncorrectLength)},
      {"download in the extended session",
       kExtended,
       {0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 1, 0},
       refusal(0x34, Nrc::kNotInThisSession)},
      {"block without a download",
       kProgramming,
       {0x36, 0x01, 0xAA},
       refusal(0x36, Nrc::kRequestSequenceError)},
      {"block of nothing", kProgramming, {0x36, 0x01}, refusal(0x36, Nrc::kIncorrectLength)},
      {"block in the extended session", kExtended, {0x36, 0x01, 0xAA}, refusal(0x36, Nrc::kNotInThisSession)},
      {"end without a download", kProgramming, {0x37}, refusal(0x37, Nrc::kRequestSequenceError)},
      {"end with data", kProgramming, {0x37, 0x00}, refusal(0x37, Nrc::kIncorrectLength)},
      {"end in the extended session", kExtended, {0x37}, refusal(0x37, Nrc::kNotInThisSession)},

      {"tester present", kDefault, {0x3E, 0x00}, {0x7E, 0x00}},
      {"tester present, no answer wanted", kDefault, {0x3E, 0x80}, {}},
      {"tester present with a sub-function",
       kDefault,
       {0x3E, 0x01},
       refusal(0x3E, Nrc::kSubFunctionNotSupported)},
      {"tester present too short", kDefault, {0x3E}, refusal(0x3E, Nrc::kIncorrectLength)},

      {"no such service", kDefault, {0x27, 0x01}, refusal(0x27, Nrc::kServiceNotSupported)},
      {"an answer as a request", kDefault, {0x50, 0x01}, refusal(0x50, Nrc::kServiceNotSupported)},
  };
  return rows;
}

TEST(Services, Table) {
  for (const Row& row : table()) {
    Bench bench;
    bench.backend.faults_list = {{5, kFaultActive | kFaultConfirmed}, {7, kFaultConfirmed}};
    if (row.session != kDefault) bench.session(row.session);
    EXPECT_EQ(bench.ask(row.request), row.answer) << row.what;
  }
}

// Every code that the backend or the server can give appears on the wire, for every service that asks the
// backend.
TEST(Services, EveryRefusalOfTheBackendTravels) {
  const std::map<std::string, Bytes> asks = {{"write", {0x2E, 0x01, 0x00, 1, 2, 3, 4}},
                                             {"arm", {0x31, 0x01, 0x02, 0x01}},
                                             {"disarm", {0x31, 0x01, 0x02, 0x02}},
                                             {"home", {0x31, 0x01, 0x02, 0x03}},
                                             {"activate", {0x31, 0x01, 0x02, 0x04}},
                                             {"prepare", {0x31, 0x01, 0x02, 0x05, 0, 0, 1, 0, 1, 2, 3, 4}},
                                             {"clear", {0x14, 0xFF, 0xFF, 0xFF}}};
  for (const Nrc code : {Nrc::kGeneralReject, Nrc::kIncorrectLength, Nrc::kBusyRepeatRequest,
                         Nrc::kConditionsNotCorrect, Nrc::kRequestSequenceError, Nrc::kRequestOutOfRange,
                         Nrc::kDownloadNotAccepted, Nrc::kProgrammingFailure}) {
    for (const auto& [call, request] : asks) {
      Bench bench;
      bench.session(kProgramming);
      bench.backend.next = code;
      const int alive = bench.backend.alive;
      EXPECT_EQ(bench.ask(request), refusal(request[0], code)) << call;
      EXPECT_EQ(bench.backend.calls, std::vector<std::string>{call});
      EXPECT_EQ(bench.backend.alive, alive) << "a refused request feeds nothing";
    }
  }
}

TEST(Services, TheTablesCoverEveryNegativeResponse) {
  std::set<std::uint8_t> seen = {0x10, 0x21, 0x22, 0x72};  // EveryRefusalOfTheBackendTravels
  seen.insert({0x71, 0x73, 0x78});                         // Download, Pending
  for (const Row& row : table()) {
    if (row.answer.size() == 3 && row.answer[0] == 0x7F) seen.insert(row.answer[2]);
  }
  for (unsigned code = 1; code < 256; ++code) {
    const bool named = std::string(name(static_cast<Nrc>(code))) != "unknown";
    EXPECT_EQ(named, seen.contains(static_cast<std::uint8_t>(code))) << code;
  }
}

TEST(Services, SuppressedAnswersStillRefuse) {
  Bench bench;
  EXPECT_EQ(bench.ask({0x10, 0x83}), Bytes{});
  EXPECT_EQ(bench.server.session(), Session::kExtended);
  EXPECT_EQ(bench.ask({0x10, 0x84}), refusal(0x10, Nrc::kSubFunctionNotSupported));
}

TEST(Services, AnswersComeInTheFormatOfTheRequest) {
  for (const bool fd : {false, true}) {
    Bench bench;
    bench.host.config().fd = fd;
    ASSERT_TRUE(bench.host.send(Bytes{0x22, 0x01, 0x00}, 0));
    CanFrame frame;
    ASSERT_TRUE(bench.host.next_frame(frame, 0));
    bench.server.on_frame(frame, 0);
    ASSERT_TRUE(bench.server.next_frame(frame, 0));
    EXPECT_EQ(frame.fd, fd);
  }
}

TEST(Services, FreezeFramesOfAFault) {
  Bench bench;
  bench.backend.faults_list = {{5, kFaultActive}};
  bench.backend.frames = 64;
  const Bytes all = bench.ask({0x19, 0x04, 0, 0, 5, 0xFF});
  constexpr std::size_t kRecord = 4 + wire_size<FreezeFrame>();
  ASSERT_EQ(all.size(), 6 + 64 * kRecord);
  FreezeFrame frame;
  ASSERT_TRUE(decode(std::span(all).subspan(6 + 63 * kRecord + 4), frame));
  EXPECT_EQ(frame.tick, 63U);
  EXPECT_EQ(all[6 + 63 * kRecord], 64);
  const Bytes one = bench.ask({0x19, 0x04, 0, 0, 5, 3});
  ASSERT_EQ(one.size(), 6 + kRecord);
  EXPECT_EQ(one[6], 3);
}

TEST(Services, ASessionEndsWithoutRequests) {
  Bench bench;
  bench.session(kExtended);
  bench.now += ServiceServer::kSessionTimeout_us - 50'000;
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.server.session(), Session::kExtended);
  bench.ask({0x3E, 0x80});
  bench.now += ServiceServer::kSessionTimeout_us - 50'000;
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.server.session(), Session::kExtended);
  bench.now += 50'001;
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.server.session(), Session::kDefault);
}

TEST(Services, ArmingDoesNotFeedTheWatchdog) {
  Bench bench;
  bench.session(kExtended);
  EXPECT_EQ(bench.backend.alive, 1);
  bench.ask({0x31, 0x01, 0x02, 0x01});
  EXPECT_EQ(bench.backend.alive, 1);
  bench.ask({0x27});
  EXPECT_EQ(bench.backend.alive, 1) << "nor does what is refused";
  bench.ask({0x3E, 0x80});
  EXPECT_EQ(bench.backend.alive, 2) << "what wants no answer does";
}

TEST(Services, ResetComesAfterItsAnswer) {
  Bench bench;
  bench.session(kExtended);
  EXPECT_EQ(bench.ask({0x11, 0x01}), (Bytes{0x51, 0x01}));
  EXPECT_TRUE(bench.backend.calls.empty());
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.backend.calls, std::vector<std::string>{"reset"});
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.backend.calls.size(), 1U);
}

TEST(Services, PendingWorkIsToldAndAnswered) {
  Bench bench;
  bench.session(kExtended);
  bench.backend.pending = 5;
  EXPECT_EQ(bench.ask({0x31, 0x01, 0x02, 0x03}), refusal(0x31, Nrc::kResponsePending));
  EXPECT_EQ(bench.ask({0x3E, 0x00}), Bytes{}) << "one at a time";
  for (int i = 0; i < 3; ++i) bench.server.poll(bench.now);
  EXPECT_EQ(bench.answer(), Bytes{}) << "told again only after a second";
  bench.server.poll(bench.now);
  bench.server.poll(bench.now);
  EXPECT_EQ(bench.answer(), (Bytes{0x71, 0x01, 0x02, 0x03}));
  EXPECT_EQ(bench.backend.calls, std::vector<std::string>{"home"});
}

TEST(Services, PendingWorkIsGivenUp) {
  Bench bench;
  bench.session(kExtended);
  bench.backend.pending = 1 << 30;
  EXPECT_EQ(bench.ask({0x31, 0x01, 0x02, 0x03}), refusal(0x31, Nrc::kResponsePending));
  int told = 1;
  Bytes last;
  for (int second = 0; second < 40 && (last.empty() || last[2] == 0x78); ++second) {
    bench.now += 1'000'001;
    bench.server.poll(bench.now);
    last = bench.answer();
    if (!last.empty() && last[2] == 0x78) ++told;
  }
  EXPECT_EQ(last, refusal(0x31, Nrc::kGeneralReject));
  EXPECT_GE(told, 29);
  EXPECT_EQ(bench.ask({0x3E, 0x00}), (Bytes{0x7E, 0x00})) << "and the next is served";
}

Bytes prepare(std::uint32_t length, std::uint8_t crc) {
  return {0x31,
          0x01,
          0x02,
          0x05,
          0,
          0,
          static_cast<std::uint8_t>(length >> 8U),
          static_cast<std::uint8_t>(length),
          0,
          0,
          0,
          crc};
}
Bytes download(std::uint8_t offset, std::uint8_t length) {
  return {0x34, 0x00, 0x44, 0, 0, 0, offset, 0, 0, 0, length};
}

TEST(Services, Download) {
  Bench bench;
  bench.session(kProgramming);
  EXPECT_EQ(bench.ask(prepare(5, 1)), (Bytes{0x71, 0x01, 0x02, 0x05, 0, 0, 0, 0}));
  EXPECT_EQ(bench.ask(download(0, 4)), refusal(0x34, Nrc::kRequestOutOfRange)) << "not what was prepared";
  EXPECT_EQ(bench.ask(download(0, 5)), (Bytes{0x74, 0x20, 0x0F, 0xFF}));
  EXPECT_TRUE(bench.server.downloading());
  EXPECT_EQ(bench.ask({0x36, 0x02, 1}), refusal(0x36, Nrc::kWrongBlockCounter));
  EXPECT_EQ(bench.ask({0x36, 0x01, 1, 2, 3}), (Bytes{0x76, 0x01}));
  EXPECT_EQ(bench.ask({0x36, 0x01, 1, 2, 3}), (Bytes{0x76, 0x01})) << "repeated because the answer was lost";
  EXPECT_EQ(bench.backend.stored, (Bytes{1, 2, 3})) << "but stored once";
  EXPECT_EQ(bench.ask({0x37}), refusal(0x37, Nrc::kRequestSequenceError)) << "bytes are missing";
  EXPECT_EQ(bench.ask({0x36, 0x02, 4, 5, 6}), refusal(0x36, Nrc::kTransferSuspended))
      << "more than announced";
  EXPECT_EQ(bench.ask({0x36, 0x02, 4, 5}), (Bytes{0x76, 0x02}));
  EXPECT_EQ(bench.ask({0x37}), Bytes{0x77});
  EXPECT_EQ(bench.ask({0x37}), Bytes{0x77}) << "repeated because the answer was lost";
  EXPECT_EQ(bench.backend.stored, (Bytes{1, 2, 3, 4, 5}));
  EXPECT_EQ(std::ranges::count(bench.backend.calls, "finish"), 1);
  EXPECT_FALSE(bench.server.downloading());
}

TEST(Services, DownloadGoesOnWhereItStopped) {
  Bench bench;
  bench.session(kProgramming);
  bench.ask(prepare(5, 1));
  bench.ask(download(0, 5));
  bench.ask({0x36, 0x01, 1, 2, 3});
  bench.now += 2 * ServiceServer::kSessionTimeout_us;  // the host dies
  bench.server.poll(bench.now);
  EXPECT_FALSE(bench.server.downloading());
  EXPECT_EQ(bench.ask({0x36, 0x02, 4, 5}), refusal(0x36, Nrc::kNotInThisSession));
  bench.session(kProgramming);
  EXPECT_EQ(bench.ask(prepare(5, 1)), (Bytes{0x71, 0x01, 0x02, 0x05, 0, 0, 0, 3}));
  EXPECT_EQ(bench.ask(download(3, 2)), (Bytes{0x74, 0x20, 0x0F, 0xFF}));
  EXPECT_EQ(bench.ask({0x36, 0x01, 4, 5}), (Bytes{0x76, 0x01}));
  EXPECT_EQ(bench.ask({0x37}), Bytes{0x77});
  EXPECT_EQ(bench.backend.stored, (Bytes{1, 2, 3, 4, 5}));
  EXPECT_EQ(bench.ask(prepare(5, 2)), (Bytes{0x71, 0x01, 0x02, 0x05, 0, 0, 0, 0}))
      << "another image begins anew";
}

TEST(Services, ABadImageEndsTheDownload) {
  Bench bench;
  bench.session(kProgramming);
  bench.ask(prepare(1, 1));
  bench.ask(download(0, 1));
  bench.ask({0x36, 0x01, 1});
  bench.backend.next = Nrc::kProgrammingFailure;
  EXPECT_EQ(bench.ask({0x37}), refusal(0x37, Nrc::kProgrammingFailure));
  EXPECT_EQ(bench.ask({0x37}), refusal(0x37, Nrc::kRequestSequenceError));
  bench.backend.next = Nrc::kOk;
  EXPECT_EQ(bench.ask({0x36, 0x02, 1}), refusal(0x36, Nrc::kRequestSequenceError));
}

TEST(Services, TheBlockCounterWraps) {
  Bench bench;
  bench.session(kProgramming);
  bench.ask(prepare(600, 1));
  bench.ask({0x34, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 0x02, 0x58});
  for (unsigned block = 1; block <= 600; ++block) {
    const auto counter = static_cast<std::uint8_t>(block);
    ASSERT_EQ(bench.ask({0x36, counter, counter}), (Bytes{0x76, counter}));
  }
  EXPECT_EQ(bench.ask({0x37}), Bytes{0x77});
}

TEST(Services, ANewRequestEndsAnAnswerThatNobodyFetches) {
  Bench bench;
  bench.backend.param.assign(1000, 7);
  ASSERT_TRUE(bench.host.send(Bytes{0x22, 0x01, 0x00}, bench.now));
  CanFrame frame;
  ASSERT_TRUE(bench.host.next_frame(frame, bench.now));
  bench.server.on_frame(frame, bench.now);
  ASSERT_TRUE(bench.server.next_frame(frame, bench.now))
      << "the first frame of a long answer, and the host is gone";
  EXPECT_EQ(bench.ask({0x3E, 0x00}), (Bytes{0x7E, 0x00}));
}

TEST(Services, FramesForOthersAreNotTaken) {
  Bench bench;
  CanFrame frame;
  frame.id = request_id(2);
  frame.extended = true;
  frame.size = 8;
  EXPECT_FALSE(bench.server.on_frame(frame, 0));
  frame.id = 0x181;
  frame.extended = false;
  EXPECT_FALSE(bench.server.on_frame(frame, 0));
}

}  // namespace
}  // namespace thimble::firmware::link
