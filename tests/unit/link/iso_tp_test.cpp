// ISO-TP against byte sequences written by hand from ISO 15765-2, and against a channel that loses, repeats,
// exchanges, cuts and holds back frames.
#include "firmware/link/iso_tp.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <initializer_list>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

namespace thimble::firmware::link {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kHostId = request_id(1);
constexpr std::uint32_t kNodeId = response_id(1);

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

Bytes bytes_of(const CanFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

CanFrame frame_of(std::uint32_t id, const Bytes& bytes, bool fd = false) {
  CanFrame frame;
  frame.id = id;
  frame.extended = true;
  frame.fd = fd;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::ranges::copy(bytes, frame.data.begin());
  return frame;
}

Bytes next(IsoTpChannel& channel, Micros now) {
  CanFrame frame;
  if (!channel.next_frame(frame, now)) return {};
  EXPECT_TRUE(is_valid(frame));
  EXPECT_TRUE(frame.extended);
  return bytes_of(frame);
}

Bytes received(const IsoTpChannel& channel) { return {channel.received().begin(), channel.received().end()}; }

IsoTpChannel host(const IsoTpConfig& config = {}) { return {kHostId, kNodeId, config}; }
IsoTpChannel node(const IsoTpConfig& config = {}) { return {kNodeId, kHostId, config}; }

TEST(IsoTp, ClassicSingleFrame) {
  IsoTpChannel channel = host();
  ASSERT_TRUE(channel.send(Bytes{0x3E, 0x00}, 0));
  EXPECT_EQ(next(channel, 0), (Bytes{0x02, 0x3E, 0x00, 0xCC, 0xCC, 0xCC, 0xCC, 0xCC}));
  EXPECT_FALSE(channel.sending());
  EXPECT_EQ(next(channel, 0), Bytes{});
}

TEST(IsoTp, ClassicTwentyBytes) {
  IsoTpChannel channel = host();
  ASSERT_TRUE(channel.send(counting(20), 0));
  EXPECT_EQ(next(channel, 0), (Bytes{0x10, 0x14, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(next(channel, 0), Bytes{}) << "waits for flow control";
  EXPECT_TRUE(channel.on_frame(frame_of(kNodeId, {0x30, 0x00, 0x00}), 100));
  EXPECT_EQ(next(channel, 100), (Bytes{0x21, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(next(channel, 100), (Bytes{0x22, 13, 14, 15, 16, 17, 18, 19}));
  EXPECT_FALSE(channel.sending());
}

TEST(IsoTp, ClassicReceivesTwentyBytesAndSaysContinue) {
  IsoTpChannel channel = node({.block_size = 0, .st_min = 0});
  channel.on_frame(frame_of(kHostId, {0x10, 0x14, 0, 1, 2, 3, 4, 5}), 0);
  EXPECT_EQ(next(channel, 0), (Bytes{0x30, 0x00, 0x00, 0xCC, 0xCC, 0xCC, 0xCC, 0xCC}));
  channel.on_frame(frame_of(kHostId, {0x21, 6, 7, 8, 9, 10, 11, 12}), 1);
  channel.on_frame(frame_of(kHostId, {0x22, 13, 14, 15, 16, 17, 18, 19}), 2);
  EXPECT_EQ(received(channel), counting(20));
  EXPECT_EQ(channel.take_error(), IsoTpError::kNone);
}

TEST(IsoTp, AnUnpaddedLastFrameIsTaken) {
  IsoTpChannel channel = node();
  channel.on_frame(frame_of(kHostId, {0x10, 0x08, 0, 1, 2, 3, 4, 5}), 0);
  (void)next(channel, 0);
  channel.on_frame(frame_of(kHostId, {0x21, 6, 7}), 1);
  EXPECT_EQ(received(channel), counting(8));
}

TEST(IsoTp, FdSingleFrameWithEscape) {
  IsoTpChannel channel = host({.fd = true});
  ASSERT_TRUE(channel.send(counting(20), 0));
  Bytes expected = {0x00, 0x14};
  for (std::uint8_t i = 0; i < 20; ++i) expected.push_back(i);
  expected.insert(expected.end(), 2, 0xCC);  // 24 is the next size of an FD frame
  EXPECT_EQ(next(channel, 0), expected);

  IsoTpChannel peer = node();
  peer.on_frame(frame_of(kHostId, expected, true), 0);
  EXPECT_EQ(received(peer), counting(20));
  EXPECT_TRUE(peer.received_fd());
}

TEST(IsoTp, FdHundredBytes) {
  IsoTpChannel channel = host({.fd = true});
  ASSERT_TRUE(channel.send(counting(100), 0));
  Bytes first = {0x10, 0x64};
  for (std::uint8_t i = 0; i < 62; ++i) first.push_back(i);
  EXPECT_EQ(next(channel, 0), first);
  channel.on_frame(frame_of(kNodeId, {0x30, 0, 0}, true), 0);
  Bytes second = {0x21};
  for (std::uint8_t i = 62; i < 100; ++i) second.push_back(i);
  second.insert(second.end(), 9, 0xCC);  // 39 bytes in 48
  EXPECT_EQ(next(channel, 0), second);
}

TEST(IsoTp, BlockSizeAsksForFlowControlAgain) {
  IsoTpChannel sender = host();
  IsoTpChannel receiver = node({.block_size = 2});
  ASSERT_TRUE(sender.send(counting(40), 0));  // first frame 6, then 7 7 | 7 7 | 6
  CanFrame frame;
  std::vector<std::uint8_t> kinds;
  for (int i = 0; i < 20; ++i) {
    while (sender.next_frame(frame, 0)) {
      kinds.push_back(frame.data[0]);
      receiver.on_frame(frame, 0);
    }
    while (receiver.next_frame(frame, 0)) {
      kinds.push_back(frame.data[0]);
      EXPECT_EQ(frame.data[1], 2);
      sender.on_frame(frame, 0);
    }
  }
  EXPECT_EQ(kinds, (Bytes{0x10, 0x30, 0x21, 0x22, 0x30, 0x23, 0x24, 0x30, 0x25}));
  EXPECT_EQ(received(receiver), counting(40));
}

TEST(IsoTp, StMinIsKept) {
  struct Case {
    std::uint8_t st_min;
    Micros gap_us;
  };
  for (const Case& c : {Case{0x05, 5000}, Case{0x7F, 127'000}, Case{0xF1, 100}, Case{0xF9, 900},
                        Case{0x80, 127'000}, Case{0xFF, 127'000}}) {
    IsoTpChannel channel = host();
    ASSERT_TRUE(channel.send(counting(40), 0));
    (void)next(channel, 0);
    channel.on_frame(frame_of(kNodeId, {0x30, 0x00, c.st_min}), 1000);
    EXPECT_EQ(next(channel, 1000).at(0), 0x21);
    EXPECT_EQ(channel.gap(1000), c.gap_us);
    EXPECT_EQ(next(channel, 1000 + c.gap_us - 1), Bytes{});
    EXPECT_EQ(next(channel, 1000 + c.gap_us).at(0), 0x22);
  }
}

TEST(IsoTp, WaitIsObeyedButNotForEver) {
  IsoTpChannel channel = host();
  ASSERT_TRUE(channel.send(counting(40), 0));
  (void)next(channel, 0);
  for (unsigned i = 0; i < IsoTpSender::kMaxWaits; ++i) {
    channel.on_frame(frame_of(kNodeId, {0x31, 0, 0}), Micros{900'000} * (i + 1));
    ASSERT_TRUE(channel.sending()) << "wait " << i;
  }
  channel.on_frame(frame_of(kNodeId, {0x31, 0, 0}), Micros{900'000} * 17);
  EXPECT_FALSE(channel.sending());
  EXPECT_EQ(channel.take_error(), IsoTpError::kTooManyWaits);
}

TEST(IsoTp, OverflowEndsTheSender) {
  IsoTpChannel channel = host();
  ASSERT_TRUE(channel.send(counting(40), 0));
  (void)next(channel, 0);
  channel.on_frame(frame_of(kNodeId, {0x32, 0, 0}), 0);
  EXPECT_EQ(channel.take_error(), IsoTpError::kOverflow);
}

TEST(IsoTp, AReservedFlowStatusEndsTheSender) {
  IsoTpChannel channel = host();
  ASSERT_TRUE(channel.send(counting(40), 0));
  (void)next(channel, 0);
  channel.on_frame(frame_of(kNodeId, {0x33, 0, 0}), 0);
  EXPECT_EQ(channel.take_error(), IsoTpError::kInvalidFlowControl);
}

TEST(IsoTp, ALongerPduThanOursIsAnsweredWithOverflow) {
  IsoTpChannel channel = node();
  channel.on_frame(frame_of(kHostId, {0x10, 0x00, 0x00, 0x00, 0x10, 0x00, 1, 2}),
                   0);  // 4096 bytes, the 32-bit form
  EXPECT_EQ(next(channel, 0).at(0), 0x32);
  EXPECT_EQ(channel.take_error(), IsoTpError::kOverflow);
}

TEST(IsoTp, EveryWaitOfTheSenderEnds) {
  IsoTpChannel channel = host({.send_timeout_us = 1000, .flow_timeout_us = 2000, .receive_timeout_us = 3000});
  ASSERT_TRUE(channel.send(counting(40), 0));
  channel.poll(1000);
  EXPECT_TRUE(channel.sending());
  channel.poll(1001);
  EXPECT_EQ(channel.take_error(), IsoTpError::kSendTimeout);

  ASSERT_TRUE(channel.send(counting(40), 0));
  (void)next(channel, 0);
  channel.poll(2000);
  EXPECT_TRUE(channel.sending());
  channel.poll(2001);
  EXPECT_EQ(channel.take_error(), IsoTpError::kFlowTimeout);
  EXPECT_EQ(channel.take_error(), IsoTpError::kNone) << "an error is told once";

  ASSERT_TRUE(channel.send(counting(40), 0));
  (void)next(channel, 0);
  channel.on_frame(frame_of(kNodeId, {0x30, 0, 0}), 0);
  (void)next(channel, 0);
  channel.poll(1001);
  EXPECT_EQ(channel.take_error(), IsoTpError::kSendTimeout);
}

TEST(IsoTp, EveryWaitOfTheReceiverEnds) {
  IsoTpChannel channel = node({.receive_timeout_us = 3000});
  channel.on_frame(frame_of(kHostId, {0x10, 0x14, 0, 1, 2, 3, 4, 5}), 0);
  (void)next(channel, 0);
  channel.poll(3000);
  EXPECT_TRUE(channel.receiving());
  channel.poll(3001);
  EXPECT_FALSE(channel.receiving());
  EXPECT_EQ(channel.take_error(), IsoTpError::kReceiveTimeout);
}

TEST(IsoTp, LostRepeatedAndExchangedFramesAreErrors) {
  for (const std::initializer_list<std::uint8_t> sequence :
       {std::initializer_list<std::uint8_t>{0x22}, {0x21, 0x21}, {0x21, 0x23}}) {
    IsoTpChannel channel = node();
    channel.on_frame(frame_of(kHostId, {0x10, 0x40, 0, 1, 2, 3, 4, 5}), 0);
    (void)next(channel, 0);
    for (const std::uint8_t pci : sequence)
      channel.on_frame(frame_of(kHostId, {pci, 1, 2, 3, 4, 5, 6, 7}), 1);
    EXPECT_EQ(channel.take_error(), IsoTpError::kWrongSequence);
    EXPECT_FALSE(channel.receiving());
  }
}

TEST(IsoTp, ANewPduReplacesAHalfReceivedOne) {
  IsoTpChannel channel = node();
  channel.on_frame(frame_of(kHostId, {0x10, 0x14, 0, 1, 2, 3, 4, 5}), 0);
  (void)next(channel, 0);
  channel.on_frame(frame_of(kHostId, {0x02, 0x3E, 0x00}), 1);
  EXPECT_EQ(channel.take_error(), IsoTpError::kUnexpectedPdu);
  EXPECT_EQ(received(channel), (Bytes{0x3E, 0x00}));
}

TEST(IsoTp, NonsenseIsIgnored) {
  IsoTpChannel channel = node();
  const std::vector<Bytes> frames = {
      {},
      {0x00, 1, 2, 3, 4, 5, 6, 7},     // a single frame of no bytes
      {0x08, 1, 2, 3, 4, 5, 6, 7},     // that cannot hold its length
      {0x05, 1, 2},                    // cut off
      {0x10, 0x07, 0, 1, 2, 3, 4, 5},  // a first frame of what fits a single one
      {0x10, 0x14, 0, 1, 2},           // cut off
      {0x21, 1, 2, 3, 4, 5, 6, 7},     // nothing began
      {0x30, 0, 0},                    // nobody waits
      {0x45, 1, 2, 3, 4, 5, 6, 7},     // reserved
  };
  for (const Bytes& bytes : frames) channel.on_frame(frame_of(kHostId, bytes), 0);
  EXPECT_TRUE(channel.received().empty());
  EXPECT_FALSE(channel.receiving());
  EXPECT_EQ(next(channel, 0), Bytes{});
  EXPECT_FALSE(channel.on_frame(frame_of(kNodeId, {0x02, 1, 2}), 0)) << "our own id is not the peer's";
}

TEST(IsoTp, SizesOutsideOneTo4095AreRefused) {
  IsoTpChannel channel = host();
  EXPECT_FALSE(channel.send({}, 0));
  EXPECT_FALSE(channel.send(counting(4096), 0));
  EXPECT_TRUE(channel.send(counting(4095), 0));
  EXPECT_FALSE(channel.send(counting(1), 0)) << "one at a time";
}

// --- The channel

struct Trouble {
  double drop = 0, repeat = 0, exchange = 0, cut = 0, stall = 0;
};

// One direction: frames with the time at which they arrive.
class Wire {
 public:
  Wire(const Trouble& trouble, std::mt19937& random) : trouble_(trouble), random_(random) {}

  void put(CanFrame frame, Micros now) {
    if (chance(trouble_.drop)) return;
    if (chance(trouble_.cut))
      frame.size = static_cast<std::uint8_t>(std::uniform_int_distribution<int>(0, frame.size)(random_));
    if (frame.fd) frame.size = fd_size(frame.size) == frame.size ? frame.size : std::uint8_t{0};
    if (chance(trouble_.stall)) stalled_until_ = std::max(stalled_until_, now + 1'500'000);
    queue_.push_back({std::max(now + 50, stalled_until_), frame});
    if (chance(trouble_.repeat)) queue_.push_back(queue_.back());
    if (queue_.size() > 1 && chance(trouble_.exchange))
      std::swap(queue_.back().frame, queue_[queue_.size() - 2].frame);
  }

  std::optional<CanFrame> take(Micros now) {
    if (queue_.empty() || queue_.front().at > now) return std::nullopt;
    const CanFrame frame = queue_.front().frame;
    queue_.pop_front();
    return frame;
  }

 private:
  struct Entry {
    Micros at;
    CanFrame frame;
  };
  bool chance(double p) { return std::uniform_real_distribution<double>(0, 1)(random_) < p; }

  Trouble trouble_;
  std::mt19937& random_;
  std::deque<Entry> queue_;
  Micros stalled_until_ = 0;
};

struct Outcome {
  std::optional<Bytes> arrived;
  bool told = false;  // an error at either end
  Micros ended_us = 0;
};

// Sends one PDU and lets both ends run until neither does anything any more.
Outcome carry(const Bytes& pdu, const IsoTpConfig& sender_config, const IsoTpConfig& receiver_config,
              const Trouble& trouble, unsigned seed) {
  std::mt19937 random(seed);
  Wire there(trouble, random);
  Wire back(trouble, random);
  IsoTpChannel sender = host(sender_config);
  IsoTpChannel receiver = node(receiver_config);
  EXPECT_TRUE(sender.send(pdu, 0));
  Outcome outcome;
  const auto note = [&](IsoTpChannel& channel) {
    outcome.told = channel.take_error() != IsoTpError::kNone || outcome.told;
  };
  constexpr Micros kStep_us = 250;
  Micros quiet_us = 0;
  Micros now = 0;
  while (quiet_us < 3'000'000) {
    now += kStep_us;
    quiet_us += kStep_us;
    CanFrame frame;
    if (sender.next_frame(frame, now)) there.put(frame, now), quiet_us = 0;
    if (receiver.next_frame(frame, now)) back.put(frame, now), quiet_us = 0;
    if (const auto got = there.take(now)) receiver.on_frame(*got, now), quiet_us = 0;
    if (const auto got = back.take(now)) sender.on_frame(*got, now), quiet_us = 0;
    sender.poll(now);
    receiver.poll(now);
    note(sender);
    note(receiver);
    if (!receiver.received().empty() && !outcome.arrived) {
      outcome.arrived = received(receiver);
      receiver.release();
    }
    EXPECT_LT(now, 600'000'000U) << "somebody waits for ever";
    if (now >= 600'000'000U) break;
  }
  EXPECT_FALSE(sender.sending());
  EXPECT_FALSE(receiver.receiving());
  outcome.ended_us = now;
  return outcome;
}

IsoTpConfig arbitrary_config() {
  IsoTpConfig config;
  config.block_size = *rc::gen::weightedOneOf<std::uint8_t>(
      {{2, rc::gen::just(std::uint8_t{0})}, {3, rc::gen::inRange<std::uint8_t>(1, 20)}});
  config.st_min = *rc::gen::element<std::uint8_t>(0, 0, 1, 3, 0xF1, 0xF5);
  return config;
}

Bytes arbitrary_pdu() {
  const auto size = *rc::gen::weightedOneOf<std::size_t>({{3, rc::gen::inRange<std::size_t>(1, 70)},
                                                          {2, rc::gen::inRange<std::size_t>(1, 600)},
                                                          {1, rc::gen::inRange<std::size_t>(4000, 4096)}});
  const auto seed = *rc::gen::arbitrary<unsigned>();
  std::mt19937 random(seed);
  Bytes pdu(size);
  for (std::uint8_t& byte : pdu) byte = static_cast<std::uint8_t>(random());
  return pdu;
}

// Ten times rapidcheck's default; the environment may ask for more.
[[maybe_unused]] const int kMoreRuns = setenv("RC_PARAMS", "max_success=1000", 0);

TEST(IsoTpProperty, EveryPduArrivesOnACleanChannel) {
  EXPECT_TRUE(rc::check("arrives whole", [] {
    const Bytes pdu = arbitrary_pdu();
    IsoTpConfig sender_config = arbitrary_config();
    IsoTpConfig receiver_config = arbitrary_config();
    sender_config.fd = receiver_config.fd = *rc::gen::arbitrary<bool>();
    const Outcome outcome = carry(pdu, sender_config, receiver_config, {}, 1);
    RC_ASSERT(outcome.arrived == pdu);
    RC_ASSERT(!outcome.told);
  }));
}

TEST(IsoTpProperty, IntactOrReportedOnABadChannel) {
  int runs = 0;
  int arrived = 0;
  EXPECT_TRUE(rc::check("intact, or an error is told", [&] {
    const Bytes pdu = arbitrary_pdu();
    IsoTpConfig sender_config = arbitrary_config();
    IsoTpConfig receiver_config = arbitrary_config();
    sender_config.fd = receiver_config.fd = *rc::gen::arbitrary<bool>();
    const auto level = [] { return *rc::gen::element(0.0, 0.0, 0.002, 0.02, 0.2); };
    const Trouble trouble{level(), level(), level(), level(), level() / 10};
    const Outcome outcome =
        carry(pdu, sender_config, receiver_config, trouble, *rc::gen::arbitrary<unsigned>());
    ++runs;
    if (outcome.arrived) {
      ++arrived;
      RC_ASSERT(*outcome.arrived == pdu);
    } else {
      // A single frame that is lost leaves nothing behind that could tell: the layer above waits for its
      // answer.
      const bool single = pdu.size() < (sender_config.fd ? 63U : 8U);
      RC_ASSERT(outcome.told || single);
    }
  }));
  std::printf("bad channel: %d PDUs, %d arrived, the others were reported\n", runs, arrived);
  EXPECT_GT(arrived, 0);
  EXPECT_LT(arrived, runs);
}

}  // namespace
}  // namespace thimble::firmware::link
