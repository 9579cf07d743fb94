// The types of firmware/exchange/ under two contexts at once: two threads, and an interrupt after every instruction. Each type carries
// plain objects, so that ThreadSanitizer sees a store that is not ordered before its load (exchange_tsan_test is this file under it).
//
// Tried 2026-11: each release and each acquire of word.h, request.h, mailbox.h and ring.h made relaxed in turn; ThreadSanitizer reports a
// race for every one. In snapshot.h the version and the words each order the data, so that it reports a race only when both releases
// are gone; what only the version orders is that words are not older than it, and x86 never shows that.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/request.h"
#include "firmware/exchange/ring.h"
#include "firmware/exchange/snapshot.h"
#include "firmware/exchange/word.h"
#include "tests/support/sanitizers.h"
#include "tests/unit/exchange/two_contexts.h"

namespace thimble::test {
namespace {

constexpr std::uint32_t kMost = 20'000;  // objects that change hands on two threads
// A writer that waits for nobody could end before the reader begins. It stays this close ahead of what was read; the figure it looks at
// is relaxed, so it orders nothing.
constexpr std::uint32_t kAhead = 64;

// Whole when each word follows from the first.
struct Object {
  std::array<std::uint32_t, 8> word{};
  void fill(std::uint32_t number) {
    for (std::uint32_t i = 0; i < word.size(); ++i) word[i] = number * (i + 1);
  }
  [[nodiscard]] bool whole() const {
    for (std::uint32_t i = 0; i < word.size(); ++i)
      if (word[i] != word[0] * (i + 1)) return false;
    return true;
  }
};

struct Tally {
  std::uint32_t seen = 0;   // objects that arrived
  std::uint32_t torn = 0;   // not whole
  std::uint32_t wrong = 0;  // out of order, lost or repeated
};

// Each case: what the writer and the reader do in one step. `step` is true when that context has finished.

struct SignalCase {
  std::vector<Object> objects = std::vector<Object>(kMost + 1);
  firmware::Signal<std::uint32_t> newest;
  firmware::Value<std::uint32_t> progress;  // of the reader
  std::uint32_t written = 0, last = 0;
  Tally tally;
  bool write() {
    if (written == kMost) return true;
    if (written - progress.get() >= kAhead) return false;
    ++written;
    objects[written].fill(written);
    newest.set(written);
    return false;
  }
  bool read() {
    const std::uint32_t number = newest.get();
    if (number != last) {
      ++tally.seen;
      if (!objects[number].whole() || objects[number].word[0] != number) ++tally.torn;
      if (number < last) ++tally.wrong;
      last = number;
      progress.set(last);
    }
    return last == kMost;
  }
};

// The reader doubles what the writer asks for, and the writer checks the result when nothing is pending.
struct RequestCase {
  enum class Command : std::uint8_t { kNone, kDouble };
  firmware::Request<Command> request;
  Object question, answer;
  std::uint32_t asked = 0;
  bool done = false;
  firmware::Signal<bool> ended;
  Tally tally;
  bool write() {
    if (done) return true;
    if (request.pending()) return false;
    if (asked != 0) {
      ++tally.seen;
      if (!answer.whole()) ++tally.torn;
      if (answer.word[0] != 2 * asked) ++tally.wrong;
    }
    if (asked == kMost) {
      done = true;
      ended.set(true);
      return true;
    }
    question.fill(++asked);
    request.post(Command::kDouble);
    return false;
  }
  bool read() {
    if (const auto command = request.take()) {
      if (*command != Command::kDouble || !question.whole()) ++tally.torn;
      answer.fill(2 * question.word[0]);
      request.done();
    }
    return ended.get();
  }
};

// The reader answers in a plain object of its own, which the writer reads once the mailbox is its again.
struct MailboxCase {
  firmware::Mailbox<Object> box;
  Object answer;
  std::uint32_t written = 0, last = 0;
  Tally tally;
  bool write() {
    if (box.sent()) return false;
    if (written != 0 && (!answer.whole() || answer.word[0] != 2 * written)) ++tally.torn;
    if (written == kMost) return true;
    Object* object = box.blank();
    if (object == nullptr || !object->whole()) {
      ++tally.torn;
      return false;
    }
    object->fill(++written);
    box.send();
    return false;
  }
  bool read() {
    if (const Object* object = box.letter()) {
      ++tally.seen;
      if (!object->whole()) ++tally.torn;
      if (object->word[0] != ++last) ++tally.wrong;
      answer.fill(2 * last);
      box.done();
    }
    return last == kMost;
  }
};

// The writer takes its object back after the reader has asked for that: the ticks before a fault, and the clear command.
struct RecallCase {
  enum class Command : std::uint8_t { kNone, kClear };
  firmware::Mailbox<Object> box;
  firmware::Request<Command> request;
  std::uint32_t written = 0;
  Tally tally;
  bool write() {
    if (request.take()) {
      box.recall();
      if (Object* object = box.blank()) {
        object->fill(++written);
        box.send();
      } else {
        ++tally.wrong;
      }
      request.done();
    }
    return written == kMost;
  }
  bool read() {
    if (request.pending()) return false;
    if (const Object* object = box.letter()) {
      ++tally.seen;
      if (!object->whole()) ++tally.torn;
      if (object->word[0] != tally.seen) ++tally.wrong;
    } else if (tally.seen != 0) {
      ++tally.wrong;
    }
    if (tally.seen == kMost) return true;
    request.post(Command::kClear);
    return false;
  }
};

struct RingCase {
  firmware::Ring<Object, 8> ring;
  std::uint32_t written = 0, full = 0;
  Tally tally;
  bool write() {
    if (written == kMost) return true;
    if (Object* object = ring.blank()) {
      object->fill(++written);
      ring.push();
    } else {
      ++full;
    }
    return false;
  }
  bool read() {
    Object object;
    if (ring.pop(object)) {
      ++tally.seen;
      if (!object.whole()) ++tally.torn;
      if (object.word[0] != tally.seen) ++tally.wrong;
    }
    return tally.seen == kMost;
  }
};

struct SnapshotCase {
  std::vector<Object> objects = std::vector<Object>(kMost + 1);  // announced by the value
  firmware::Snapshot<Object> newest;
  firmware::Value<std::uint32_t> progress;  // of the reader
  std::uint32_t written = 0, last = 0;
  Tally tally;
  bool write() {
    if (written == kMost) return true;
    if (written - progress.get() >= kAhead) return false;
    ++written;
    objects[written].fill(written);
    newest.write(objects[written]);
    return false;
  }
  bool read() {
    Object object;
    if (newest.read(object)) {
      ++tally.seen;
      const std::uint32_t number = object.word[0];
      if (!object.whole() || number > kMost || objects[number].word != object.word) ++tally.torn;
      if (number <= last) ++tally.wrong;
      last = number;
      progress.set(last);
    }
    return last == kMost;
  }
};

void report(const char* how, const Tally& tally, unsigned long long interrupts) {
  std::printf("%s: %u objects arrived, %llu interrupts, %u torn, %u wrong\n", how, tally.seen, interrupts,
              tally.torn, tally.wrong);
  EXPECT_EQ(tally.torn, 0U) << how;
  EXPECT_EQ(tally.wrong, 0U) << how;
}

template <class T>
class Exchange : public testing::Test {};
using Cases = testing::Types<SignalCase, RequestCase, MailboxCase, RecallCase, RingCase, SnapshotCase>;
TYPED_TEST_SUITE(Exchange, Cases);

TYPED_TEST(Exchange, HoldsOnTwoThreads) {
  TypeParam c;
  on_two_threads([&] { return c.read(); }, [&] { return c.write(); });
  report("two threads", c.tally, 0);
  EXPECT_GE(c.tally.seen, kMost / kAhead);
}

#if THIMBLE_SINGLE_STEP
TYPED_TEST(Exchange, HoldsWithAnInterruptAfterEveryInstruction) {
  constexpr int kSteps = kUnderSanitizers ? 12 : 120;  // a call has ten times the instructions there
  {
    TypeParam c;
    const auto interrupts =
        interrupted_everywhere([&] { return c.write(); }, [&] { return c.read(); }, kSteps);
    report("the writer is interrupted", c.tally, interrupts);
    EXPECT_GT(interrupts, 1000U);
    EXPECT_GT(c.tally.seen, kSteps * 2U / 5U);
  }
  TypeParam c;
  const auto interrupts = interrupted_everywhere([&] { return c.read(); }, [&] { return c.write(); }, kSteps);
  report("the reader is interrupted", c.tally, interrupts);
  EXPECT_GT(interrupts, 1000U);
}
#endif

// What one context sees of its own calls, step by step.

TEST(ExchangeRules, TheNewestRequestWinsAndIsAcknowledgedBySerialNumber) {
  enum class Command : std::uint8_t { kNone, kA, kB };
  firmware::Request<Command> request;
  EXPECT_FALSE(request.pending());
  EXPECT_FALSE(request.take());
  request.post(Command::kA);
  request.post(Command::kB);
  EXPECT_EQ(request.take(), Command::kB);
  EXPECT_TRUE(request.pending()) << "until it is done";
  request.post(Command::kB);
  request.done();
  EXPECT_TRUE(request.pending()) << "the one that was posted meanwhile";
  EXPECT_EQ(request.take(), Command::kB);
  request.done();
  EXPECT_FALSE(request.pending());
  EXPECT_FALSE(request.take());
}

TEST(ExchangeRules, AFullRingRefusesTheNewest) {
  firmware::Ring<int, 4> ring;
  for (int i = 0; i < 4; ++i) {
    int* place = ring.blank();
    ASSERT_NE(place, nullptr);
    *place = i;
    ring.push();
  }
  EXPECT_EQ(ring.blank(), nullptr);
  int oldest = -1;
  EXPECT_TRUE(ring.pop(oldest));
  EXPECT_EQ(oldest, 0);
  EXPECT_NE(ring.blank(), nullptr);
  for (int i = 1; i < 4; ++i) {
    EXPECT_TRUE(ring.pop(oldest));
    EXPECT_EQ(oldest, i);
  }
  EXPECT_FALSE(ring.pop(oldest));
}

TEST(ExchangeRules, ASnapshotIsReadOnceAndCanBeSkipped) {
  firmware::Snapshot<std::uint32_t> newest;
  std::uint32_t value = 0;
  EXPECT_FALSE(newest.read(value));
  newest.write(7);
  newest.write(8);
  EXPECT_TRUE(newest.read(value));
  EXPECT_EQ(value, 8U);
  EXPECT_FALSE(newest.read(value));
  newest.write(9);
  newest.skip();
  EXPECT_FALSE(newest.read(value));
  newest.write(9);
  EXPECT_TRUE(newest.read(value)) << "the same value again is a new one";
}

TEST(ExchangeRules, ACounterWraps) {
  firmware::Counter counter;
  counter.add(0xFFFFFFFFU);
  counter.add(3);
  EXPECT_EQ(counter.get(), 2U);
  counter.clear();
  EXPECT_EQ(counter.get(), 0U);
}

}  // namespace
}  // namespace thimble::test
