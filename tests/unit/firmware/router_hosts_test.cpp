// Several hosts on one router: claims of addresses, requests at the same time, and a random bus (losses, repetitions,
// exchanged and cut frames) with a model of each host as the judge.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "firmware/services/router.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using firmware::Call;
using firmware::Router;
using link::CanFrame;
using link::ClaimAction;
using link::HostClaim;
using link::HostGrant;
using link::Nrc;
using Payload = std::vector<std::uint8_t>;

class HostsHandler final : public firmware::RequestHandler {
 public:
  std::function<Nrc(Call&)> answer = [](Call& call) {
    call.answer.put(call.request.subspan(1));
    return Nrc::kOk;
  };
  std::vector<const firmware::Host*> ended;
  Nrc handle(Call& call) noexcept override { return answer(call); }
  bool urgent(std::span<const std::uint8_t>) const noexcept override { return false; }
  void give_up(firmware::Host&) noexcept override {}
  void session_ended(firmware::Host& host) noexcept override { ended.push_back(&host); }
  void host_alive(const firmware::Host&, link::Micros) noexcept override {}
  void restart(link::Reset) noexcept override {}
};

// Claims one after the other, without a bus.
class Claims {
 public:
  HostsHandler handler;
  Router router{handler, 1};
  link::Micros now = 1'000'000;

  void send(std::uint64_t key, ClaimAction action = ClaimAction::kClaim) {
    EXPECT_TRUE(router.on_frame(to_frame(HostClaim{key, action}, 1, static_cast<std::uint16_t>(key)), now));
  }
  // All grants that wait, by key.
  std::map<std::uint64_t, std::uint8_t> grants() {
    std::map<std::uint64_t, std::uint8_t> found;
    CanFrame frame;
    HostGrant grant;
    while (router.next_frame(frame, now))
      if (link::from_frame(frame, 1, grant)) found[grant.key] = grant.address;
    return found;
  }
  std::uint8_t claim(std::uint64_t key) {
    send(key);
    const auto found = grants();
    return found.contains(key) ? found.at(key) : std::uint8_t{0xFF};
  }
  // A request of one frame from an address; its answer as bytes, empty: none.
  Payload ask(std::uint8_t address, const Payload& request) {
    link::IsoTpChannel channel;
    channel.set_ids(link::request_id(1, address), link::response_id(1, address));
    EXPECT_TRUE(channel.send(request, now));
    CanFrame frame;
    for (int i = 0; i < 100; ++i) {
      while (channel.next_frame(frame, now)) EXPECT_TRUE(router.on_frame(frame, now));
      router.poll(now);
      while (router.next_frame(frame, now)) static_cast<void>(channel.on_frame(frame, now));
      if (!channel.received().empty()) return {channel.received().begin(), channel.received().end()};
      now += 100;
    }
    return {};
  }
  void silence(link::Micros time_us) {
    now += time_us;
    router.poll(now);
  }
};

TEST(RouterHosts, ClaimsInTheSameInstantGetDifferentAddresses) {
  Claims bus;
  for (const std::uint64_t key : {11U, 12U, 13U, 14U}) bus.send(key);
  const auto grants = bus.grants();
  std::set<std::uint8_t> addresses;
  for (const auto& [key, address] : grants) {
    EXPECT_GE(address, link::kFirstHostAddress);
    EXPECT_LE(address, link::kLastHostAddress);
    addresses.insert(address);
  }
  EXPECT_EQ(grants.size(), 4U);
  EXPECT_EQ(addresses.size(), 4U);
}

TEST(RouterHosts, AFifthIsToldThatThereIsNoPlace) {
  Claims bus;
  for (const std::uint64_t key : {1U, 2U, 3U, 4U}) EXPECT_NE(bus.claim(key), 0);
  EXPECT_EQ(bus.claim(5), 0);
  bus.send(2, ClaimAction::kRelease);
  EXPECT_NE(bus.claim(5), 0) << "a place was released";
  EXPECT_EQ(bus.claim(6), 0);
}

TEST(RouterHosts, AHostThatVanishesFreesItsPlace) {
  Claims bus;
  std::map<std::uint64_t, std::uint8_t> addresses;
  for (const std::uint64_t key : {1U, 2U, 3U, 4U}) addresses[key] = bus.claim(key);
  bus.silence(3'000'000);
  for (const std::uint64_t key : {1U, 2U, 4U}) EXPECT_EQ(bus.ask(addresses[key], {0x3E, 0x00}).size(), 2U);
  bus.silence(2'100'000);
  EXPECT_NE(bus.claim(5), 0) << "the place of 3";
  EXPECT_EQ(bus.ask(addresses[3], {0x3E, 0x00}), Payload{}) << "its address has nobody now";
  for (const std::uint64_t key : {1U, 2U, 4U})
    EXPECT_EQ(bus.ask(addresses[key], {0x3E, 0x00}).size(), 2U) << key;
  EXPECT_EQ(bus.claim(3), 0) << "and must wait like any other";
}

TEST(RouterHosts, AClaimMayBeRepeated) {
  Claims bus;
  const std::uint8_t address = bus.claim(7);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(bus.claim(7), address) << "its grant was lost";
  EXPECT_NE(bus.claim(8), address);
  bus.silence(4'000'000);
  EXPECT_EQ(bus.claim(7), address);
  bus.silence(4'000'000);
  EXPECT_EQ(bus.claim(7), address) << "a claim is a sign of life";
}

TEST(RouterHosts, AnAddressComesBackAsLateAsPossible) {
  Claims bus;
  const std::uint8_t first = bus.claim(100);
  bus.send(100, ClaimAction::kRelease);
  constexpr std::uint64_t others = link::kLastHostAddress - link::kFirstHostAddress;
  for (std::uint64_t key = 101; key <= 100 + others; ++key) {
    EXPECT_NE(bus.claim(key), first) << key;
    bus.send(key, ClaimAction::kRelease);
  }
  EXPECT_EQ(bus.claim(999), first);
}

TEST(RouterHosts, TheTesterThatClaimsNothingHasAPlaceLikeAnyOther) {
  Claims bus;
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x22, 1, 2}), (Payload{0x62, 1, 2}));
  for (const std::uint64_t key : {1U, 2U, 3U}) EXPECT_NE(bus.claim(key), 0);
  EXPECT_EQ(bus.claim(4), 0);
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x22, 3, 4}), (Payload{0x62, 3, 4}));
  bus.silence(5'100'000);
  EXPECT_NE(bus.claim(4), 0);
}

// So that anybody can disarm at any time.
TEST(RouterHosts, WithoutAPlaceATesterIsAnsweredOneFrameInTheDefaultSession) {
  Claims bus;
  for (const std::uint64_t key : {1U, 2U, 3U, 4U}) EXPECT_NE(bus.claim(key), 0);
  link::Session asked = link::Session::kExtended;
  bus.handler.answer = [&](Call& call) {
    asked = call.host.session;
    call.answer.put(call.request.subspan(1));
    return Nrc::kOk;
  };
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x31, 0x01, 0x02, 0x02}), (Payload{0x71, 0x01, 0x02, 0x02}));
  EXPECT_EQ(asked, link::Session::kDefault);
  const Payload busy22 = {0x7F, 0x22, 0x21};
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x22, 1, 2, 3, 4, 5, 6, 7, 8}), busy22) << "more than a frame";
  bus.handler.answer = [](Call& call) {
    call.answer.put(Payload(7, 1));
    return Nrc::kOk;
  };
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x22, 1, 2}), busy22) << "an answer of more than a frame";
  bus.handler.answer = [](Call&) { return Nrc::kResponsePending; };
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x22, 1, 2}), busy22) << "an answer that takes longer";
  bus.handler.answer = [](Call& call) {
    call.host.session = static_cast<link::Session>(call.request[1] & 0x7FU);
    return Nrc::kOk;
  };
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x10, 0x03}), (Payload{0x7F, 0x10, 0x21})) << "a session to keep";
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x10, 0x83}), (Payload{0x7F, 0x10, 0x21}));
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x10, 0x01})[0], 0x50);
  bus.handler.answer = [](Call& call) { return call.sub_function() == 0 ? Nrc::kOk : Nrc::kGeneralReject; };
  EXPECT_EQ(bus.ask(link::kTesterAddress, {0x3E, 0x80}), Payload{}) << "no answer is wanted";
}

TEST(RouterHosts, SessionsAreTheHostsOwn) {
  Claims bus;
  bus.handler.answer = [](Call& call) {
    if (call.request[0] == 0x10) call.host.session = static_cast<link::Session>(call.request[1]);
    call.answer.put(static_cast<std::uint8_t>(call.host.session));
    return Nrc::kOk;
  };
  const std::uint8_t a = bus.claim(1), b = bus.claim(2);
  EXPECT_EQ(bus.ask(a, {0x10, 3}), (Payload{0x50, 3}));
  EXPECT_EQ(bus.ask(b, {0x22, 0}), (Payload{0x62, 1}));
  bus.silence(3'000'000);
  EXPECT_EQ(bus.ask(b, {0x10, 2}), (Payload{0x50, 2}));
  bus.silence(3'000'000);
  EXPECT_EQ(bus.handler.ended.size(), 1U) << "of the first, 6 s after its last request";
  EXPECT_EQ(bus.ask(b, {0x22, 0}), (Payload{0x62, 2}));
  EXPECT_EQ(bus.ask(bus.claim(1), {0x22, 0}), (Payload{0x62, 1}));
}

TEST(RouterHosts, ARequestThatTakesLongKeepsNobodyElseWaiting) {
  Claims bus;
  bool ready = false;
  bus.handler.answer = [&](Call& call) {
    call.answer.put(call.request.subspan(1));
    return call.request[0] == 0x31 && !ready ? Nrc::kResponsePending : Nrc::kOk;
  };
  const std::uint8_t a = bus.claim(1), b = bus.claim(2);
  EXPECT_EQ(bus.ask(a, {0x31, 1}), (Payload{0x7F, 0x31, 0x78}));
  EXPECT_EQ(bus.ask(b, {0x22, 5}), (Payload{0x62, 5}));
  EXPECT_EQ(bus.ask(b, {0x31, 2}), (Payload{0x7F, 0x31, 0x78}));
  EXPECT_EQ(bus.ask(a, {0x22, 5}), Payload{}) << "a second request of the same host is dropped";
  ready = true;
  bus.router.poll(bus.now);
  std::map<std::uint32_t, Payload> answers;
  CanFrame frame;
  while (bus.router.next_frame(frame, bus.now))
    answers[frame.id] = Payload(frame.data.begin() + 1, frame.data.begin() + 1 + frame.data[0]);
  EXPECT_EQ(answers[link::response_id(1, a)], (Payload{0x71, 1}));
  EXPECT_EQ(answers[link::response_id(1, b)], (Payload{0x71, 2}));
}

TEST(RouterHosts, WhoLeavesWhileItsRequestIsPendingIsFreeAfterIt) {
  Claims bus;
  bool ready = false;
  bus.handler.answer = [&](Call&) { return ready ? Nrc::kOk : Nrc::kResponsePending; };
  const std::uint8_t a = bus.claim(1);
  static_cast<void>(bus.ask(a, {0x31, 1}));
  bus.send(1, ClaimAction::kRelease);
  for (const std::uint64_t key : {2U, 3U, 4U}) EXPECT_NE(bus.claim(key), 0);
  EXPECT_EQ(bus.claim(5), 0);
  ready = true;
  bus.router.poll(bus.now);
  bus.router.poll(bus.now);
  EXPECT_NE(bus.claim(5), 0);
}

// --- A random bus

struct Chances {
  double lose = 0, repeat = 0, exchange = 0, cut = 0;
};

// A host as an independent model: it claims, asks `wanted` requests of its own content one after the other, and leaves.
class ModelHost {
 public:
  ModelHost(unsigned number, unsigned requests, bool polite, std::uint32_t seed)
      : number_(number), wanted_(requests), polite_(polite), random_(seed) {
    new_key();
  }

  [[nodiscard]] bool finished() const { return done_ == wanted_ && left_; }
  [[nodiscard]] unsigned done() const { return done_; }
  [[nodiscard]] unsigned repeats() const { return repeats_; }
  [[nodiscard]] unsigned refusals() const { return refusals_; }
  // What it may rely on: the address, while it is sure that the controller has heard it lately.
  [[nodiscard]] std::optional<std::uint8_t> address(link::Micros now) const {
    if (address_ == 0 || now - confirmed_us_ > link::kHostTimeout_us) return std::nullopt;
    return address_;
  }

  // Its next frame, if any.
  std::optional<CanFrame> send(link::Micros now) {
    channel_.poll(now);
    if (const auto error = channel_.take_error(); error != link::IsoTpError::kNone) retry_us_ = now;
    if (done_ == wanted_) {
      if (left_) return std::nullopt;
      left_ = true;
      if (!polite_) return std::nullopt;
      return to_frame(HostClaim{key_, ClaimAction::kRelease}, 1, salt());
    }
    const bool stale = address_ == 0 || now - confirmed_us_ > 2'000'000;
    if (stale && now >= claim_us_) {
      claim_us_ = now + 50'000;
      claimed_at_us_ = now;
      return to_frame(HostClaim{key_, ClaimAction::kClaim}, 1, salt());
    }
    if (stale && address_ == 0) return std::nullopt;
    if (!asking_ || now >= retry_us_) ask(now);
    CanFrame frame;
    if (channel_.next_frame(frame, now)) return frame;
    return std::nullopt;
  }

  void receive(const CanFrame& frame, link::Micros now) {
    HostGrant grant;
    if (link::from_frame(frame, 1, grant)) {
      if (grant.key != key_) return;
      if (grant.address == 0) {
        ++refusals_;
        claim_us_ = now + 200'000;
        return;
      }
      confirmed_us_ = claimed_at_us_;
      if (grant.address != address_) {
        address_ = grant.address;
        channel_.set_ids(link::request_id(1, address_), link::response_id(1, address_));
        asking_ = false;
      }
      return;
    }
    if (address_ == 0 || !channel_.on_frame(frame, now)) return;
    const Payload got(channel_.received().begin(), channel_.received().end());
    if (got.empty()) return;
    channel_.release();
    if (!asking_) return;
    if (got.size() == 3 && got[0] == 0x7F) {
      retry_us_ = now + 500'000;  // pending
      return;
    }
    // The late answer to a request before may come; anything else than the expected bytes is a mix-up.
    Payload expected = request_;
    expected[0] |= link::kPositive;
    if (got == expected) {
      confirmed_us_ = asked_us_;
      asking_ = false;
      ++done_;
      return;
    }
    ASSERT_GE(got.size(), 4U);
    EXPECT_EQ(got[1], number_) << "an answer to another host's request";
    EXPECT_LT(static_cast<unsigned>(got[2]) << 8U | got[3], done_) << "an answer to no request of its own";
  }

 private:
  void new_key() { key_ = (static_cast<std::uint64_t>(random_()) << 8U | number_ | 1U) & link::kHostKeyMask; }
  std::uint16_t salt() { return static_cast<std::uint16_t>(random_()); }

  void ask(link::Micros now) {
    if (asking_) {
      ++repeats_;
    } else {
      // Up to 15 consecutive frames, so that ISO-TP's modulo cannot hide a loss.
      request_ = {0x22, static_cast<std::uint8_t>(number_), static_cast<std::uint8_t>(done_ >> 8U),
                  static_cast<std::uint8_t>(done_)};
      for (std::size_t i = random_() % 90; i > 0; --i)
        request_.push_back(static_cast<std::uint8_t>(random_()));
    }
    channel_.abort();
    EXPECT_TRUE(channel_.send(request_, now));
    asking_ = true;
    asked_us_ = now;
    retry_us_ = now + 400'000;
  }

  unsigned number_;
  unsigned wanted_;
  bool polite_;
  std::minstd_rand random_;
  std::uint64_t key_ = 0;
  std::uint8_t address_ = 0;
  link::IsoTpChannel channel_;
  Payload request_;
  bool asking_ = false, left_ = false;
  unsigned done_ = 0, repeats_ = 0, refusals_ = 0;
  link::Micros claim_us_ = 0, claimed_at_us_ = 0, confirmed_us_ = 0, asked_us_ = 0, retry_us_ = 0;
};

// The frames of all hosts and of the controller on one bus: who sends next is drawn, and all hear all.
class RandomBus {
 public:
  RandomBus(std::size_t count, unsigned requests, const Chances& chances, std::uint32_t seed, bool all_polite)
      : chances_(chances), random_(seed) {
    for (unsigned i = 0; i < count; ++i)
      hosts.push_back(std::make_unique<ModelHost>(i + 1, requests, all_polite || i % 3 != 1, seed * 131 + i));
    handler_.answer = [this](Call& call) { return handle(call); };
  }

  // Until all hosts have finished, or `limit_us`.
  bool run(link::Micros limit_us) {
    while (now_ < limit_us) {
      step();
      if (std::ranges::all_of(hosts, [](const auto& host) { return host->finished(); })) return true;
    }
    return false;
  }
  [[nodiscard]] double seconds() const { return static_cast<double>(now_) * 1e-6; }

  std::vector<std::unique_ptr<ModelHost>> hosts;

 private:
  bool draw(double chance) { return std::uniform_real_distribution<>(0, 1)(random_) < chance; }

  // The controller's end: the request says whose it is, and a Host must see one host's requests only.
  Nrc handle(Call& call) {
    const std::string who = "host " + std::to_string(call.request[1]);
    if (call.host.refusal[0] == '\0') call.host.refuse(who.c_str());
    EXPECT_EQ(std::string(call.host.refusal.data()), who) << "two hosts in one place";
    call.answer.put(call.request.subspan(1));
    if (!waits_.contains(&call.host) && draw(0.2)) waits_[&call.host] = static_cast<int>(random_() % 20);
    if (const auto found = waits_.find(&call.host); found != waits_.end()) {
      if (found->second-- > 0) return Nrc::kResponsePending;
      waits_.erase(found);
    }
    return Nrc::kOk;
  }

  void step() {
    now_ += random_() % 300;
    router_.poll(now_);
    const std::size_t turn = random_() % (hosts.size() + 1);
    CanFrame frame;
    if (turn < hosts.size()) {
      if (const auto sent = hosts[turn]->send(now_)) pass(*sent, to_router_);
    } else if (router_.next_frame(frame, now_)) {
      pass(frame, to_hosts_);
    }
    // What two hosts believe to have at once must differ.
    std::set<std::uint8_t> addresses;
    for (const auto& host : hosts) {
      const auto address = host->address(now_);
      if (!address || host->finished()) continue;
      EXPECT_TRUE(addresses.insert(*address).second) << "two hosts with address " << int{*address};
    }
    deliver();
  }

  void pass(const CanFrame& frame, std::deque<CanFrame>& queue) {
    if (draw(chances_.lose)) return;
    queue.push_back(frame);
    if (draw(chances_.cut)) queue.back().size = static_cast<std::uint8_t>(random_() % 8);
    if (draw(chances_.repeat)) queue.push_back(frame);
    if (queue.size() > 1 && draw(chances_.exchange)) std::swap(queue.back(), queue[queue.size() - 2]);
  }

  void deliver() {
    while (!to_router_.empty() && draw(0.7)) {
      static_cast<void>(router_.on_frame(to_router_.front(), now_));
      to_router_.pop_front();
    }
    while (!to_hosts_.empty() && draw(0.7)) {
      for (const auto& host : hosts) host->receive(to_hosts_.front(), now_);
      to_hosts_.pop_front();
    }
  }

  Chances chances_;
  std::minstd_rand random_;
  HostsHandler handler_;
  Router router_{handler_, 1};
  std::map<const firmware::Host*, int> waits_;
  std::deque<CanFrame> to_router_, to_hosts_;
  link::Micros now_ = 1'000'000;
};

TEST(RouterHosts, FourAtOnceOnASoundBusLoseNothing) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    RandomBus bus(4, 40, {}, seed, true);
    ASSERT_TRUE(bus.run(60'000'000)) << "seed " << seed;
    for (const auto& host : bus.hosts) {
      EXPECT_EQ(host->done(), 40U);
      EXPECT_EQ(host->repeats(), 0U) << "a request was dropped, seed " << seed;
      EXPECT_EQ(host->refusals(), 0U);
    }
  }
}

TEST(RouterHosts, SevenOnABadBusGetTheirOwnAnswersAndNoOther) {
  const std::array<Chances, 5> weathers = {{{.lose = 0.03},
                                            {.repeat = 0.03},
                                            {.exchange = 0.03},
                                            {.cut = 0.03},
                                            {.lose = 0.02, .repeat = 0.02, .exchange = 0.02, .cut = 0.02}}};
  unsigned repeats = 0, refusals = 0;
  double slowest_s = 0;
  for (const Chances& chances : weathers) {
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
      RandomBus bus(7, 25, chances, seed, false);
      ASSERT_TRUE(bus.run(600'000'000)) << "seed " << seed;
      for (const auto& host : bus.hosts) {
        EXPECT_EQ(host->done(), 25U);
        repeats += host->repeats();
        refusals += host->refusals();
      }
      slowest_s = std::max(slowest_s, bus.seconds());
    }
  }
  std::printf("7 hosts, 4 places, 30 runs: %u requests repeated, %u claims refused, slowest %.1f s\n",
              repeats, refusals, slowest_s);
  EXPECT_GT(repeats, 100U) << "the bus was not bad";
  EXPECT_GT(refusals, 100U) << "all places were never taken";
}

}  // namespace
}  // namespace thimble::test
