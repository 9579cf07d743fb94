// The router with a handler of the test's: how a request becomes an answer, whatever the service. Several hosts:
// router_hosts_test.cpp. What the services do: service_table_test.cpp, services_test.cpp.
#include "firmware/services/router.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace thimble::test {
namespace {

namespace link = firmware::link;
using firmware::Call;
using firmware::Router;
using link::CanFrame;
using link::Nrc;
using RouterBytes = std::vector<std::uint8_t>;

class TestHandler final : public firmware::RequestHandler {
 public:
  std::function<Nrc(Call&)> answer = [](Call&) { return Nrc::kOk; };
  int alive = 0, given_up = 0, sessions_ended = 0;
  std::vector<link::Reset> restarts;

  Nrc handle(Call& call) noexcept override { return answer(call); }
  bool urgent(std::span<const std::uint8_t>) const noexcept override { return false; }
  void give_up(firmware::Host&) noexcept override { ++given_up; }
  void session_ended(firmware::Host&) noexcept override { ++sessions_ended; }
  void host_alive(const firmware::Host&, link::Micros) noexcept override { ++alive; }
  void restart(link::Reset kind) noexcept override { restarts.push_back(kind); }
};

// A router and a tester's end of the line, without a channel between that could lose anything.
class Line {
 public:
  TestHandler handler;
  Router router{handler, 1};
  link::IsoTpChannel tester{link::request_id(1), link::response_id(1), {.fd = true}};
  link::Micros now = 1'000'000;

  RouterBytes ask(const RouterBytes& request) {
    EXPECT_TRUE(tester.send(request, now));
    return answer();
  }
  // The next answer; nothing when there is none.
  RouterBytes answer() {
    CanFrame frame;
    for (int i = 0; i < 2000; ++i) {
      now += 10;
      while (tester.next_frame(frame, now)) EXPECT_TRUE(router.on_frame(frame, now));
      while (router.next_frame(frame, now)) EXPECT_TRUE(tester.on_frame(frame, now));
      if (!tester.received().empty()) {
        RouterBytes answer(tester.received().begin(), tester.received().end());
        tester.release();
        return answer;
      }
    }
    return {};
  }
};

RouterBytes refusal(std::uint8_t service, Nrc code) {
  return {0x7F, service, static_cast<std::uint8_t>(code)};
}

// Answers kResponsePending so many times, then kOk.
std::function<Nrc(Call&)> pending_for(int times) {
  return [times](Call&) mutable { return times-- > 0 ? Nrc::kResponsePending : Nrc::kOk; };
}

TEST(Router, EveryRefusalOfAHandlerTravels) {
  for (const Nrc code :
       {Nrc::kGeneralReject, Nrc::kServiceNotSupported, Nrc::kSubFunctionNotSupported, Nrc::kIncorrectLength,
        Nrc::kResponseTooLong, Nrc::kBusyRepeatRequest, Nrc::kConditionsNotCorrect,
        Nrc::kRequestSequenceError, Nrc::kRequestOutOfRange, Nrc::kDownloadNotAccepted,
        Nrc::kTransferSuspended, Nrc::kProgrammingFailure, Nrc::kWrongBlockCounter, Nrc::kNotInThisSession}) {
    for (const int id : {0x10, 0x22, 0x2E, 0x31, 0x36}) {
      const auto service = static_cast<std::uint8_t>(id);
      Line line;
      int calls = 0;
      line.handler.answer = [&](Call&) {
        ++calls;
        return code;
      };
      EXPECT_EQ(line.ask({service, 0x01, 0x02}), refusal(service, code));
      EXPECT_EQ(calls, 1);
      EXPECT_EQ(line.handler.alive, 0) << "a refused request is no sign of life";
    }
  }
}

TEST(Router, AnAnswerThatDoesNotFitIsRefused) {
  Line line;
  line.handler.answer = [](Call& call) {
    for (int i = 0; i < 5000; ++i) call.answer.put(0);
    return Nrc::kOk;
  };
  EXPECT_EQ(line.ask({0x22, 0x02, 0x00}), refusal(0x22, Nrc::kResponseTooLong));
}

TEST(Router, OnlyASubFunctionCanSuppressThePositiveAnswer) {
  Line line;
  line.handler.answer = [](Call& call) { return call.sub_function() == 3 ? Nrc::kOk : Nrc::kGeneralReject; };
  EXPECT_EQ(line.ask({0x10, 0x83}), RouterBytes{});
  EXPECT_EQ(line.handler.alive, 1) << "it is a sign of life all the same";
  EXPECT_EQ(line.ask({0x10, 0x84}), refusal(0x10, Nrc::kGeneralReject));
  line.handler.answer = [](Call&) { return Nrc::kOk; };
  EXPECT_EQ(line.ask({0x22, 0x83}), RouterBytes{0x62}) << "a service without one";
}

TEST(Router, AnswersComeInTheFormatOfTheRequest) {
  for (const bool fd : {false, true}) {
    Line line;
    line.tester.config().fd = fd;
    ASSERT_TRUE(line.tester.send(RouterBytes{0x22, 0x01, 0x00}, 0));
    CanFrame frame;
    ASSERT_TRUE(line.tester.next_frame(frame, 0));
    line.router.on_frame(frame, 0);
    ASSERT_TRUE(line.router.next_frame(frame, 0));
    EXPECT_EQ(frame.fd, fd);
  }
}

TEST(Router, ASessionEndsWithoutRequests) {
  Line line;
  line.handler.answer = [](Call& call) {
    if (call.request[0] == 0x10) call.host.session = link::Session::kExtended;
    return Nrc::kOk;
  };
  const auto session = [&] {
    const firmware::Host* host = line.router.host(link::kTesterAddress);
    return host == nullptr ? link::Session::kDefault : host->session;
  };
  line.ask({0x10, 0x03});
  line.now += Router::kSessionTimeout_us - 50'000;
  line.router.poll(line.now);
  EXPECT_EQ(session(), link::Session::kExtended);
  line.ask({0x3E, 0x80});
  line.now += Router::kSessionTimeout_us - 50'000;
  line.router.poll(line.now);
  EXPECT_EQ(session(), link::Session::kExtended);
  EXPECT_EQ(line.handler.sessions_ended, 0);
  line.now += 50'001;
  line.router.poll(line.now);
  EXPECT_EQ(session(), link::Session::kDefault);
  EXPECT_EQ(line.handler.sessions_ended, 1);
}

TEST(Router, AHandlerCanSayThatItIsNoSignOfLife) {
  Line line;
  line.ask({0x22, 0x01, 0x00});
  EXPECT_EQ(line.handler.alive, 1);
  line.handler.answer = [](Call& call) {
    call.sign_of_life = false;
    return Nrc::kOk;
  };
  EXPECT_EQ(line.ask({0x31, 0x01}), RouterBytes{0x71});
  EXPECT_EQ(line.handler.alive, 1);
}

TEST(Router, ARestartComesAfterItsAnswer) {
  Line line;
  line.handler.answer = [](Call& call) {
    call.host.restart = link::Reset::kHard;
    return Nrc::kOk;
  };
  EXPECT_EQ(line.ask({0x11, 0x01}), RouterBytes{0x51});
  EXPECT_TRUE(line.handler.restarts.empty());
  line.router.poll(line.now);
  EXPECT_EQ(line.handler.restarts, std::vector<link::Reset>{link::Reset::kHard});
  line.router.poll(line.now);
  EXPECT_EQ(line.handler.restarts.size(), 1U);
}

TEST(Router, PendingWorkIsToldAndAnswered) {
  Line line;
  line.handler.answer = pending_for(5);
  EXPECT_EQ(line.ask({0x31, 0x01, 0x02, 0x03}), refusal(0x31, Nrc::kResponsePending));
  EXPECT_EQ(line.ask({0x3E, 0x00}), RouterBytes{}) << "one at a time";
  for (int i = 0; i < 3; ++i) line.router.poll(line.now);
  EXPECT_EQ(line.answer(), RouterBytes{}) << "told again only after a second";
  line.router.poll(line.now);
  line.router.poll(line.now);
  EXPECT_EQ(line.answer(), RouterBytes{0x71});
  EXPECT_EQ(line.handler.alive, 1);
}

TEST(Router, AnAnswerThatWasAnnouncedComesThoughItIsSuppressed) {
  Line line;
  line.handler.answer = [times = 2](Call& call) mutable {
    static_cast<void>(call.sub_function());
    return times-- > 0 ? Nrc::kResponsePending : Nrc::kOk;
  };
  EXPECT_EQ(line.ask({0x31, 0x81}), refusal(0x31, Nrc::kResponsePending));
  line.router.poll(line.now);
  line.router.poll(line.now);
  EXPECT_EQ(line.answer(), RouterBytes{0x71});
}

TEST(Router, PendingWorkIsGivenUp) {
  Line line;
  line.handler.answer = pending_for(1 << 30);
  EXPECT_EQ(line.ask({0x31, 0x01, 0x02, 0x03}), refusal(0x31, Nrc::kResponsePending));
  int told = 1;
  RouterBytes last;
  for (int second = 0; second < 40 && (last.empty() || last[2] == 0x78); ++second) {
    line.now += 1'000'001;
    line.router.poll(line.now);
    last = line.answer();
    if (!last.empty() && last[2] == 0x78) ++told;
  }
  EXPECT_EQ(last, refusal(0x31, Nrc::kGeneralReject));
  EXPECT_EQ(line.handler.given_up, 1);
  EXPECT_GE(told, 29);
  line.handler.answer = [](Call&) { return Nrc::kOk; };
  EXPECT_EQ(line.ask({0x3E, 0x00}), RouterBytes{0x7E}) << "and the next is served";
}

TEST(Router, ANewRequestEndsAnAnswerThatNobodyFetches) {
  Line line;
  line.handler.answer = [](Call& call) {
    if (call.request[0] == 0x22) call.answer.put(RouterBytes(1000, 7));
    return Nrc::kOk;
  };
  ASSERT_TRUE(line.tester.send(RouterBytes{0x22, 0x01, 0x00}, line.now));
  CanFrame frame;
  ASSERT_TRUE(line.tester.next_frame(frame, line.now));
  line.router.on_frame(frame, line.now);
  ASSERT_TRUE(line.router.next_frame(frame, line.now))
      << "the first frame of a long answer, and the host is gone";
  EXPECT_EQ(line.ask({0x3E, 0x00}), RouterBytes{0x7E});
}

TEST(Router, FramesForOthersAreNotTaken) {
  Line line;
  CanFrame frame;
  frame.id = link::request_id(2);
  frame.extended = true;
  frame.size = 8;
  EXPECT_FALSE(line.router.on_frame(frame, 0));
  frame.id = 0x181;
  frame.extended = false;
  EXPECT_FALSE(line.router.on_frame(frame, 0));
}

}  // namespace
}  // namespace thimble::test
