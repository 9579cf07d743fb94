// Who has the key commands (firmware/services/authenticator.h): the key over power-off, proofs right and wrong, and what a host without it may do.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <set>

#include "firmware/link/proof.h"
#include "firmware/services/authenticator.h"
#include "firmware/store/key_store.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using firmware::KeyStore;
using firmware::Storage;
using firmware::StoreStatus;
using link::KeyState;
using link::Nrc;

link::Key key_of(std::uint8_t fill) {
  link::Key key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(fill + i);
  return key;
}

KeyStore reopened(TestStorage& storage) {
  storage.power_left = std::numeric_limits<std::size_t>::max();
  KeyStore store(storage);
  store.open();
  return store;
}

// HMAC-SHA256 by Python: hmac.new(bytes(range(32)), b"thimble proof" + bytes([1, 0xF2]) + bytes(range(100, 132)), "sha256").
TEST(Access, AProofIsWhatAnotherLibraryComputes) {
  link::Challenge challenge;
  for (std::size_t i = 0; i < challenge.size(); ++i) challenge[i] = static_cast<std::uint8_t>(100 + i);
  const link::Proof proof = link::proof_of(key_of(0), 1, 0xF2, challenge);
  const link::Proof wanted = {0xCB, 0x2F, 0xA2, 0xC0, 0x59, 0x06, 0x56, 0x7B, 0x50, 0xFE, 0xE7,
                              0x7D, 0x06, 0xAA, 0xC3, 0xD1, 0x62, 0x34, 0x24, 0x49, 0x45, 0x49,
                              0xD1, 0xBE, 0xE2, 0x03, 0x71, 0xEB, 0x15, 0xDC, 0x48, 0x36};
  EXPECT_EQ(proof, wanted);
}

// Power fails after every byte of setting a first key, another one, and of removing it: the state is the one before or the one after.
TEST(Access, TheKeySurvivesPowerLossAtEveryByte) {
  int cuts = 0;
  for (const int steps : {1, 2, 3}) {
    for (std::size_t budget = 0;; ++budget, ++cuts) {
      TestStorage storage;
      KeyStore store(storage);
      store.open();
      EXPECT_EQ(store.state(), KeyState::kNone);
      for (int step = 1; step < steps; ++step)
        ASSERT_EQ(store.set(key_of(static_cast<std::uint8_t>(step))), StoreStatus::kOk);
      storage.power_left = budget;
      const StoreStatus done =
          steps == 3 ? store.remove() : store.set(key_of(static_cast<std::uint8_t>(steps)));
      const bool whole = storage.power_left != 0;
      const KeyStore after = reopened(storage);
      EXPECT_FALSE(storage.overwritten);
      if (done == StoreStatus::kOk) {
        EXPECT_EQ(after.state(), steps == 3 ? KeyState::kNone : KeyState::kSet);
        EXPECT_TRUE(steps == 3 || after.key() == key_of(static_cast<std::uint8_t>(steps)));
      } else if (steps == 1) {
        EXPECT_NE(after.state(), KeyState::kSet);  // none; damaged while the header is torn
      } else {
        EXPECT_EQ(after.state(), KeyState::kSet);
        EXPECT_EQ(after.key(), key_of(static_cast<std::uint8_t>(steps - 1)));
      }
      if (whole) break;
    }
  }
  EXPECT_GT(cuts, 300);
}

// Whatever byte is damaged, and whatever was there before: no key becomes none, and none that was removed comes back.
TEST(Access, ADamagedKeyIsAKeyThatNobodyHas) {
  for (const bool removed : {false, true}) {
    TestStorage storage;
    KeyStore store = reopened(storage);
    ASSERT_EQ(store.set(key_of(1)), StoreStatus::kOk);
    ASSERT_EQ(store.remove(), StoreStatus::kOk);
    ASSERT_EQ(store.set(key_of(2)), StoreStatus::kOk);
    ASSERT_TRUE(!removed || store.remove() == StoreStatus::kOk);
    int damaged = 0;
    for (unsigned slot = Storage::kFirstKeySlot; slot < Storage::kFirstArmSlot; ++slot) {
      for (std::size_t at = 0; at < 64 + link::kKeyBytes; ++at) {
        const std::byte before = storage.at(slot, at);
        storage.at(slot, at) ^= std::byte{0x40};
        const KeyStore after = reopened(storage);
        EXPECT_TRUE(removed || after.state() != KeyState::kNone) << slot << " " << at;
        EXPECT_FALSE(after.state() == KeyState::kSet && after.key() != key_of(2)) << slot << " " << at;
        EXPECT_FALSE(removed && after.state() == KeyState::kSet);
        damaged += after.state() == KeyState::kDamaged ? 1 : 0;
        storage.at(slot, at) = before;
      }
    }
    EXPECT_GE(damaged, removed ? 24 : 56);
  }
}

const Bytes kOpenIt = {0x10, 0x03}, kStoreAll = {0x31, 0x01, 0x02, 0x07};

Bytes set_key_request(const link::Key& key) {
  return join({0x31, 0x01, 0x02, 0x0B}, Bytes(key.begin(), key.end()));
}

Bytes ask_challenge(Tester& host) {
  const Bytes answer =
      host.ask(join({0x29, 0x05, 0x00}, Bytes(link::kAlgorithm.begin(), link::kAlgorithm.end())));
  if (answer.size() != 3 + 16 + 2 + 32 + 2) return {};
  EXPECT_EQ(answer[2], 0x00);
  return Bytes(answer.begin() + 21, answer.begin() + 53);
}

Nrc prove(Tester& host, const link::Key& key, const Bytes& challenge, std::uint8_t address) {
  link::Challenge given{};
  std::copy_n(challenge.begin(), std::min(challenge.size(), given.size()), given.begin());
  const link::Proof proof = link::proof_of(key, 1, address, given);
  Bytes request = join({0x29, 0x06}, Bytes(link::kAlgorithm.begin(), link::kAlgorithm.end()));
  request.insert(request.end(), {0, 32});
  request.insert(request.end(), proof.begin(), proof.end());
  request.insert(request.end(), {0, 0, 0, 0});
  const Bytes answer = host.ask(request);
  if (answer.size() == 3 && answer[0] == link::kNegative) return static_cast<Nrc>(answer[2]);
  EXPECT_EQ(answer.size(), 3U + 16 + 2);
  EXPECT_EQ(answer[2], link::kOwnershipVerified);
  return Nrc::kOk;
}

Nrc prove(Tester& host, const link::Key& key) {
  return prove(host, key, ask_challenge(host), host.address());
}

void run_seconds(Tester& host, double seconds) { host.run(static_cast<int>(seconds * 4000)); }

TEST(Access, OnlyWhoHasTheKeyCommands) {
  Bench bench;
  bench.load();
  Tester owner(bench, false, 21), other(bench, false, 22);
  ASSERT_TRUE(owner.ok(kOpenIt));
  ASSERT_TRUE(other.ok(kOpenIt));
  EXPECT_TRUE(ask_challenge(owner).empty());
  EXPECT_EQ(owner.text(link::kDidRefusal), "no_key");
  ASSERT_TRUE(owner.ok(set_key_request(key_of(7)))) << "a new board takes its first key from anybody";
  EXPECT_TRUE(owner.ok(kStoreAll)) << "who sets it has it";
  run_seconds(other, 1.6);
  for (const Bytes& request :
       {Bytes{0x31, 0x01, 0x02, 0x01}, Bytes{0x31, 0x01, 0x02, 0x03}, kStoreAll, set_key_request(key_of(8)),
        Bytes{0x31, 0x02, 0x02, 0x0B}, Bytes{0x2E, 0x01, 0x00, 0, 0, 0x20, 0x41}})
    EXPECT_EQ(other.refused(request), Nrc::kAuthenticationRequired);
  link::DeviceState state;
  ASSERT_TRUE(link::decode(other.read(link::DeviceState::kId), state));
  EXPECT_EQ(state.key, KeyState::kSet);
  EXPECT_EQ(state.commander, 0) << "what was refused took no lease";
  EXPECT_TRUE(other.ok({0x31, 0x01, 0x02, 0x02})) << "a stop needs no key";
  EXPECT_TRUE(other.ok({0x2E, 0x01, 0x00, 0, 0, 0x80, 0x40})) << "nor does a smaller maximum force";
  EXPECT_EQ(prove(other, key_of(7)), Nrc::kOk);
  EXPECT_TRUE(other.ok(kStoreAll));

  // Another key: who had the old one has none.
  ASSERT_TRUE(other.ok(set_key_request(key_of(8))));
  run_seconds(other, 1.6);
  EXPECT_EQ(owner.refused(kStoreAll), Nrc::kAuthenticationRequired);
  bench.restart("power_on");
  Tester late(bench, false, 23);
  ASSERT_TRUE(late.ok(kOpenIt));
  EXPECT_EQ(late.refused(kStoreAll), Nrc::kAuthenticationRequired) << "over power-off";
  EXPECT_EQ(prove(late, key_of(8)), Nrc::kOk);
  ASSERT_TRUE(late.ok({0x31, 0x02, 0x02, 0x0B}));
  Tester anybody(bench, false, 24);
  ASSERT_TRUE(anybody.ok(kOpenIt));
  run_seconds(anybody, 1.6);
  EXPECT_TRUE(anybody.ok(kStoreAll)) << "the key was removed";
}

TEST(Access, NobodyCommandsABoardWhoseKeyIsDamaged) {
  Bench bench;
  {
    Tester owner(bench, false, 71);
    ASSERT_TRUE(owner.ok(kOpenIt));
    ASSERT_TRUE(owner.ok(set_key_request(key_of(7))));
  }
  bench.storage.at(Storage::kFirstKeySlot, 70) ^= std::byte{1};
  bench.restart("power_on");
  Tester host(bench, false, 72);
  ASSERT_TRUE(host.ok(kOpenIt));
  for (const Bytes& request :
       {Bytes{0x31, 0x01, 0x02, 0x03}, kStoreAll, set_key_request(key_of(8)), Bytes{0x31, 0x02, 0x02, 0x0B},
        Bytes{0x31, 0x01, 0x02, 0x0C}, Bytes{0x31, 0x01, 0x02, 0x09, 0x70, 0, 0, 0},
        Bytes{0x2E, 0x01, 0x00, 0, 0, 0x20, 0x41}})
    EXPECT_EQ(host.refused(request), Nrc::kAuthenticationRequired);
  EXPECT_TRUE(ask_challenge(host).empty());
  EXPECT_EQ(host.text(link::kDidRefusal), "key_damaged");
  EXPECT_EQ(prove(host, link::Key{}), Nrc::kRequestSequenceError);
  EXPECT_TRUE(host.ok({0x31, 0x01, 0x02, 0x02})) << "a stop needs no key";
}

TEST(Access, AProofIsForOneHostAndOneChallenge) {
  Bench bench;
  Tester owner(bench, false, 31), other(bench, false, 32);
  ASSERT_TRUE(owner.ok(kOpenIt));
  ASSERT_TRUE(other.ok(kOpenIt));
  const link::Key key = key_of(3);
  ASSERT_TRUE(owner.ok(set_key_request(key)));
  EXPECT_EQ(prove(other, key, Bytes(32), other.address()), Nrc::kRequestSequenceError)
      << "without a challenge";
  const Bytes first = ask_challenge(other);
  ASSERT_EQ(first.size(), 32U);
  EXPECT_EQ(prove(other, key, first, owner.address()), Nrc::kOwnershipVerificationFailed)
      << "another host's proof";
  EXPECT_EQ(prove(other, key, first, other.address()), Nrc::kRequestSequenceError)
      << "a challenge is for one proof";
  EXPECT_TRUE(ask_challenge(other).empty());
  run_seconds(other, 0.6);
  const Bytes second = ask_challenge(other);
  EXPECT_NE(first, second);
  EXPECT_EQ(prove(other, key, first, other.address()), Nrc::kOwnershipVerificationFailed)
      << "an old challenge";
  run_seconds(other, 1.1);
  EXPECT_EQ(prove(other, key), Nrc::kOk);
}

// Guessing: the delay doubles up to kLongestDelay_us, and a right proof ends it.
TEST(Access, WrongProofsHaveToWait) {
  Bench bench;
  Tester owner(bench, false, 41), thief(bench, false, 42);
  ASSERT_TRUE(owner.ok(kOpenIt));
  ASSERT_TRUE(owner.ok(set_key_request(key_of(3))));
  std::vector<double> waits_s;
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(thief.ok(kOpenIt));
    double waited_s = 0;
    Bytes challenge = ask_challenge(thief);
    for (; challenge.empty() && waited_s < 20; waited_s += 0.125) {
      run_seconds(thief, 0.125);
      challenge = ask_challenge(thief);
    }
    waits_s.push_back(waited_s);
    EXPECT_EQ(prove(thief, key_of(static_cast<std::uint8_t>(50 + i)), challenge, thief.address()),
              Nrc::kOwnershipVerificationFailed);
  }
  const std::vector<double> least_s = {0, 0.5, 1, 2, 4, 8, 16, 16};
  for (std::size_t i = 0; i < waits_s.size(); ++i) {
    EXPECT_GE(waits_s[i], 0.97 * least_s[i]);
    EXPECT_LE(waits_s[i], least_s[i] + 0.2);
  }
  EXPECT_TRUE(ask_challenge(thief).empty());
  Tester friendly(bench, false, 43);
  ASSERT_TRUE(friendly.ok(kOpenIt));
  EXPECT_EQ(prove(friendly, key_of(3)), Nrc::kOk) << "who has the key does not wait for a thief";
  for (int i = 0; i < 17; ++i) run_seconds(thief, 1), static_cast<void>(thief.read(link::kDidSession));
  ASSERT_TRUE(thief.ok(kOpenIt));
  EXPECT_EQ(prove(thief, key_of(3)), Nrc::kOk);
  EXPECT_FALSE(ask_challenge(thief).empty());
}

// A challenge that came again after its proof could be answered by who heard that.
TEST(Access, NoChallengeComesTwice) {
  TestStorage kept;
  std::set<Bytes> seen;
  Bench bench;
  {
    Tester owner(bench, false, 51);
    ASSERT_TRUE(owner.ok(kOpenIt));
    ASSERT_TRUE(owner.ok(set_key_request(key_of(3))));
  }
  int asked = 0;
  for (int start = 0; start < 20; ++start) {
    bench.restart(start % 3 == 0 ? "watchdog" : "power_on");
    bench.inputs.time_us = 0;  // the clock begins anew
    Tester host(bench, false, 52);
    ASSERT_TRUE(host.ok(kOpenIt));
    for (int i = 0; i < 10; ++i, ++asked) {
      const Bytes challenge = ask_challenge(host);
      EXPECT_EQ(ask_challenge(host), challenge) << "before a proof came";
      seen.insert(challenge);
      EXPECT_EQ(prove(host, key_of(3), challenge, host.address()), Nrc::kOk);
    }
  }
  EXPECT_FALSE(seen.contains(Bytes{}));
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(asked));
}

// Random bytes as requests of service 29, and random changes of a right one: nobody gets the key's rights by them.
TEST(Access, NothingButTheProofOpens) {
  Bench bench;
  Tester owner(bench, false, 61), other(bench, false, 62);
  ASSERT_TRUE(owner.ok(kOpenIt));
  ASSERT_TRUE(other.ok(kOpenIt));
  const link::Key key = key_of(9);
  ASSERT_TRUE(owner.ok(set_key_request(key)));
  run_seconds(other, 1.6);
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < 400; ++i) {
    Bytes request = {0x29, static_cast<std::uint8_t>(random() % 2 == 0 ? 0x06 : random())};
    const Bytes challenge = ask_challenge(other);
    if (!challenge.empty() && random() % 2 == 0) {
      link::Challenge given{};
      std::ranges::copy(challenge, given.begin());
      const link::Proof proof = link::proof_of(key, 1, other.address(), given);
      request = join({0x29, 0x06}, Bytes(link::kAlgorithm.begin(), link::kAlgorithm.end()));
      request.insert(request.end(), {0, 32});
      request.insert(request.end(), proof.begin(), proof.end());
      request.insert(request.end(), {0, 0, 0, 0});
      request[2 + random() % (request.size() - 2)] ^= static_cast<std::uint8_t>(1U << random() % 8);
    } else {
      request.resize(2 + random() % 70);
      for (std::size_t at = 2; at < request.size(); ++at) request[at] = static_cast<std::uint8_t>(random());
    }
    refused += other.refused(request) == Nrc::kOk ? 0 : 1;
    run_seconds(other, 0.002);
    ASSERT_EQ(other.refused(kStoreAll), Nrc::kAuthenticationRequired) << i;
    if (i % 50 == 49) run_seconds(other, 4.0), static_cast<void>(other.ok(kOpenIt));
  }
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace thimble::test
