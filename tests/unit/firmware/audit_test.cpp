// What the controller puts into its audit record: each event with who and when. The judge keeps a list of its own, from the answers that
// hosts had and from what the arm did.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <deque>
#include <string>
#include <vector>

#include "firmware/link/crc32.h"
#include "firmware/link/proof.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using link::StoppedBy;

std::string text_of(const AuditRecord& entry) {
  std::string text(entry.text.begin(), entry.text.end());
  return text.substr(0, text.find('\0'));
}

// What the judge expects of an entry.
struct Expected {
  AuditEvent event;
  std::uint8_t host = 0;
  std::string text = {};
  std::uint32_t value = 0;
  std::uint16_t detail = 0;
  std::uint16_t start = 1;
};

void expect_entry(const AuditRecord& is, const Expected& expected) {
  EXPECT_EQ(name(is.event), std::string(name(expected.event)));
  EXPECT_EQ(is.host, expected.host);
  EXPECT_EQ(text_of(is), expected.text);
  EXPECT_EQ(is.value, expected.value);
  EXPECT_EQ(is.detail, expected.detail);
  EXPECT_EQ(is.start, expected.start);
  EXPECT_EQ(is.left_out, 0U);
}

Bytes call_me(const std::string& name) { return join({0x2E, 0xF1, 0xAF}, Bytes(name.begin(), name.end())); }

// Hosts of one controller, and what the judge has seen them do.
class Scene {
 public:
  explicit Scene(std::uint64_t seed) : random(seed), bench_(slow()) { begin("power_on"); }

  // Between two actions: room for as many entries as there were.
  void rest(std::size_t entries) {
    const double until_s = time_s() + static_cast<double>(AuditLog::kInterval_s * (entries + 1));
    while (time_s() < until_s) {
      for (Host& host : hosts_) host.tester.post({0x3E, 0x80});
      hosts_.front().tester.run(150);
    }
  }

  void check() {
    std::vector<AuditRecord> entries = audit_page(any().tester, newest_ + 1);
    ASSERT_EQ(entries.size(), expected.size());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      EXPECT_EQ(entries[i].number, newest_ + 1);
      newest_ = entries[i].number;
      expect_entry(entries[i], expected[i]);
      EXPECT_NEAR(entries[i].uptime_s, time_s() - start_s_, 3) << name(entries[i].event);
      EXPECT_EQ(entries[i].utc_s != 0, told_);
      ++seen[static_cast<std::size_t>(entries[i].event)];
    }
    const std::size_t count = entries.size();
    expected.clear();
    rest(count);
  }

  void act() {
    Host& host = any();
    const Mode before = bench_.mode();
    const Fault fault = bench_.controller->fault();
    const bool damping = before == Mode::kDamping;
    switch (random.below(damping ? 2 : 13)) {
      case 0:
        return hosts_.front().tester.run(20);
      case 1:
        if (host.tester.routine(0x0202) && before == Mode::kArmed)
          expect(AuditEvent::kDisarmed, host, 0, static_cast<std::uint16_t>(StoppedBy::kDisarm));
        return;
      case 2:
      case 3:
        EXPECT_TRUE(host.tester.ok({0x3E, 0x00}));
        if (host.tester.routine(0x0201) && before != Mode::kArmed) expect(AuditEvent::kArmed, host);
        return;
      case 4:
        if (host.tester.routine(0x0203)) expect(AuditEvent::kHoming, host);
        return;
      case 5:
        if (host.tester.ok({0x14, 0xFF, 0xFF, 0xFF}) && fault != Fault::kNone)
          expect(AuditEvent::kCleared, host, static_cast<std::uint32_t>(fault));
        return;
      case 6:
        return write_parameter(host);
      case 7:
        if (host.tester.routine(0x0207)) expect(AuditEvent::kSaved, host, saved_crc());
        return;
      case 8:
        return trip(Fault::host_stop, before, fault);
      case 9:
        return trip(Fault::e_stop, before, fault);
      case 10:
        bench_.inputs.dead_man = false;
        host.tester.run(5);
        if (before == Mode::kArmed)
          expected.push_back(
              at_start({AuditEvent::kDisarmed, 0, "", 0, static_cast<std::uint16_t>(StoppedBy::kDeadMan)}));
        bench_.inputs.dead_man = true;
        return host.tester.run(50);
      case 11:
        return upload(host);
      default:
        return rare(host);
    }
  }

  Random random;
  std::vector<Expected> expected;
  std::array<int, 32> seen{};  // by AuditEvent

 private:
  struct Host {
    Tester tester;
    std::string name;
  };

  static firmware::Config slow() {
    firmware::Config config;
    config.period_s = 0.02F;
    config.reset_reason = "power_on";
    return config;
  }
  double time_s() const { return static_cast<double>(bench_.inputs.time_us) * 1e-6; }
  Host& any() { return hosts_[random.below(hosts_.size())]; }
  Expected at_start(Expected one) const {
    one.start = starts_;
    return one;
  }
  void expect(AuditEvent event, const Host& host, std::uint32_t value = 0, std::uint16_t detail = 0) {
    expected.push_back(at_start({event, host.tester.address(), host.name, value, detail}));
  }

  void begin(const char* reason) {
    ++starts_;
    told_ = false;
    expected.push_back(at_start({AuditEvent::kStart, 0, reason}));
    hosts_.clear();
    bench_.for_testers.clear();
    bench_.tick();
    start_s_ = time_s();
    for (std::uint64_t key = 1; key <= 3; ++key) {
      Host& host = hosts_.emplace_back(Host{Tester(bench_, key == 2, key), ""});
      EXPECT_TRUE(host.tester.ok({0x10, 0x02}));
    }
  }

  std::uint32_t saved_crc() const {
    firmware::ParamStore store(bench_.storage);
    store.open();
    return store.crc();
  }

  void write_parameter(Host& host) {
    const firmware::ParamRow& row = firmware::kParamTable[random.below(std::size(firmware::kParamTable))];
    const float value = random.below(2) == 0 ? row.initial : row.max;
    // What would let an arm that this test expects to be armed go, or needs CAN FD.
    if (std::string(row.name) == "host_forces" || std::string(row.name) == "host_supervision") return;
    const std::uint32_t bits = row.type == firmware::ParamType::kFloat ? std::bit_cast<std::uint32_t>(value)
                                                                       : static_cast<std::uint32_t>(value);
    const Bytes request = {0x2E,
                           static_cast<std::uint8_t>(row.id >> 8),
                           static_cast<std::uint8_t>(row.id),
                           static_cast<std::uint8_t>(bits),
                           static_cast<std::uint8_t>(bits >> 8),
                           static_cast<std::uint8_t>(bits >> 16),
                           static_cast<std::uint8_t>(bits >> 24)};
    const bool recorded = row.recorded == firmware::Recording::kRecorded;
    if (host.tester.ok(request) && recorded) expect(AuditEvent::kParameter, host, bits, row.id);
  }

  void trip(Fault fault, Mode before, Fault latched) {
    if (fault == Fault::host_stop) {
      bench_.controller->on_frame(link::to_frame(link::EmergencyStop{}, 0), bench_.inputs.time_us);
    } else {
      bench_.inputs.e_stop = true;
    }
    hosts_.front().tester.run(5);
    bench_.inputs.e_stop = false;
    hosts_.front().tester.run(50);
    const auto number = static_cast<std::uint32_t>(fault);
    if (latched != Fault::kNone) return;
    expected.push_back(at_start({AuditEvent::kFault, 0, "", number}));
    if (before == Mode::kArmed)
      expected.push_back(at_start(
          {AuditEvent::kDisarmed, 0, "", number,
           static_cast<std::uint16_t>(fault == Fault::host_stop ? StoppedBy::kStop : StoppedBy::kFault)}));
  }

  void upload(Host& host) {
    std::vector<std::byte> image = plane_image(100.0F * static_cast<float>(1 + random.below(20)));
    const bool spoiled = random.below(3) == 0;
    if (spoiled) image[image.size() / 2] ^= std::byte{0xFF};
    if (!host.tester.ok({0x10, 0x02}) || !host.tester.ok({0x31, 0x01, 0x02, 0x0C}))
      return;  // another one commands
    const std::uint32_t crc = link::crc32(image);
    const Bytes exit = download(host.tester, image, spoiled && random.below(2) == 0 ? crc + 1 : crc);
    if (exit.at(0) != 0x77) return expect(AuditEvent::kUploadRefused, host);
    if (host.tester.routine(0x0204)) expect(AuditEvent::kScene, host, crc);
    host.tester.run(20);
  }

  // A key is set, somebody tries without it, and it is removed.
  void keys(Host& host) {
    const Bytes algorithm(link::kAlgorithm.begin(), link::kAlgorithm.end());
    if (!host.tester.ok(join({0x31, 0x01, 0x02, 0x0B}, Bytes(link::kKeyBytes, 7)))) return;
    expect(AuditEvent::kKeySet, host);
    Host& thief = any();
    EXPECT_TRUE(thief.tester.ok(join({0x29, 0x05, 0x00}, algorithm)));
    const Bytes proof = join(join({0x29, 0x06}, algorithm), join({0x00, 0x20}, Bytes(32 + 4)));
    EXPECT_EQ(thief.tester.refused(proof), link::Nrc::kOwnershipVerificationFailed);
    expect(AuditEvent::kProofRefused, thief);
    EXPECT_TRUE(host.tester.ok({0x31, 0x02, 0x02, 0x0B}));
    expect(AuditEvent::kKeyRemoved, host);
  }

  void rare(Host& host) {
    switch (random.below(4)) {
      case 3:
        return keys(host);
      case 0: {
        host.name = "user" + std::to_string(random.below(1000)) + "@lab";
        EXPECT_TRUE(host.tester.ok(call_me(host.name)));
        EXPECT_EQ(host.tester.text(link::kDidHostName), host.name);
        return;
      }
      case 1: {
        const auto now_s =
            static_cast<std::uint32_t>(1'800'000'000 + 1000 * static_cast<std::uint32_t>(starts_) +
                                       static_cast<std::uint32_t>(time_s()));
        EXPECT_TRUE(host.tester.ok(join({0x31, 0x01, 0x02, 0x09}, big_endian({now_s}))));
        if (!told_) expect(AuditEvent::kTimeTold, host, now_s);
        told_ = true;
        return;
      }
      default: {
        const bool armed = bench_.mode() == Mode::kArmed;
        if (!host.tester.ok({0x11, 0x01})) return;
        expect(AuditEvent::kRestart, host);
        hosts_.front().tester.run(50);
        if (armed) expect(AuditEvent::kDisarmed, host, 0, static_cast<std::uint16_t>(StoppedBy::kDisarm));
        EXPECT_TRUE(bench_.controller->take_reset());
        check();
        bench_.restart("host");
        return begin("host");
      }
    }
  }

  mutable Bench bench_;
  std::deque<Host> hosts_;
  std::uint32_t newest_ = 0;
  std::uint16_t starts_ = 0;
  double start_s_ = 0;
  bool told_ = false;
};

TEST(Audit, EveryEventOfSeveralHostsWithWhoAndWhen) {
  std::array<int, 32> seen{};  // by AuditEvent
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Scene scene(seed);
    scene.check();
    for (int step = 0; step < 120; ++step) {
      scene.act();
      scene.check();
      if (::testing::Test::HasFailure()) FAIL() << "seed " << seed << ", step " << step;
    }
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] += scene.seen[i];
  }
  for (const link::EnumRow& row : link::EnumTable<AuditEvent>::kRows) {
    figure(std::string("entries of ") + row.name, seen[row.number], "");
    // Of a stored arm: ArmStore.IsUploadedByServicesAndUsedFromTheNextStartOn.
    if (row.number != static_cast<unsigned>(AuditEvent::kMove) &&
        row.number != static_cast<unsigned>(AuditEvent::kArmImage)) {
      EXPECT_GT(seen[row.number], 3) << row.name;
    }
  }
}

// With the events of all ticks at once, as a background sees them that was away for a while.
TEST(Audit, ArmedAndLetGoBetweenTwoPolls) {
  Bench bench;
  bench.load();
  bench.home();
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  const std::uint32_t newest = audit_page(host, 0).back().number;
  host.post({0x31, 0x01, 0x02, 0x01});
  const auto tick = [&bench] {
    ++bench.inputs.tick;
    bench.inputs.arm[0].sample_tick = bench.inputs.arm[1].sample_tick = bench.inputs.tick;
    static_cast<void>(bench.controller->tick(bench.inputs));
  };
  bench.controller->keep_alive();
  tick();
  ASSERT_EQ(bench.mode(), Mode::kArmed);
  bench.inputs.dead_man = false;
  tick();
  ASSERT_EQ(bench.mode(), Mode::kDamping);
  static_cast<void>(host.posted_answer());
  const std::vector<AuditRecord> entries = audit_page(host, newest + 1);
  ASSERT_EQ(entries.size(), 2U);
  expect_entry(entries[0], {AuditEvent::kArmed, host.address()});
  expect_entry(entries[1],
               {AuditEvent::kDisarmed, 0, "", 0, static_cast<std::uint16_t>(StoppedBy::kDeadMan)});
}

// A host that gives up its activation by a disarm has started a scene all the same.
TEST(Audit, ASceneWhoseHostDoesNotWait) {
  Bench bench;
  bench.start();
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x02}));
  ASSERT_TRUE(host.ok(call_me("mallory")));
  const std::vector<std::byte> image = plane_image(100.0F);
  ASSERT_EQ(download(host, image, link::crc32(image)).at(0), 0x77);
  const std::uint32_t newest = audit_page(host, 0).back().number;
  host.post({0x31, 0x01, 0x02, 0x04});
  host.post({0x31, 0x01, 0x02, 0x02});
  static_cast<void>(host.posted_answer());
  const std::vector<AuditRecord> entries = audit_page(host, newest + 1);
  ASSERT_EQ(entries.size(), 2U);
  expect_entry(entries[0], {AuditEvent::kScene, host.address(), "mallory", link::crc32(image)});
  expect_entry(entries[1], {AuditEvent::kDisarmed, host.address(), "mallory", 0,
                            static_cast<std::uint16_t>(StoppedBy::kDisarm)});
}

TEST(Audit, AGuardedMove) {
  Bench bench;
  bench.let_jump();
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("allow_moves")->id, 1),
            firmware::ParamStatus::kOk);
  bench.start();
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  bench.load(1000.0F, -0.05F);
  bench.ticks(2000);
  host.say({0x3E, 0x80});
  link::MoveOrder order;
  order.target_z_m = -0.01F;
  order.speed_m_s = 0.01F;
  order.force_limit_N = 1.0F;
  Bytes start = {0x31, 0x01, 0x02, 0x06};
  start.resize(4 + link::wire_size<link::MoveOrder>());
  ASSERT_NE(link::encode(order, std::span(start).subspan(4)), 0U);
  ASSERT_TRUE(host.ok(start));
  expect_entry(audit_page(host, 0).back(), {AuditEvent::kMove, host.address()});
}

TEST(Audit, AnOrderForTheAxes) {
  Bench bench;
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("allow_moves")->id, 1),
            firmware::ParamStatus::kOk);
  bench.load(1000.0F, -0.05F);
  bench.home();
  bench.arm();
  Tester host(bench, false, 1);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  host.run(900);
  link::AxisOrder order;
  order.driven_s = 0.2F;
  Bytes start = {0x31, 0x01, 0x02, 0x0F};
  start.resize(4 + link::wire_size<link::AxisOrder>());
  ASSERT_NE(link::encode(order, std::span(start).subspan(4)), 0U);
  ASSERT_TRUE(host.ok(start));
  expect_entry(audit_page(host, 0).back(), {AuditEvent::kMove, host.address(), "", 1});
}

// A tester that found no place is named by the address of testers.
TEST(Audit, ADisarmByAHostWithoutAPlace) {
  Bench bench;
  bench.start();
  std::deque<Tester> hosts;
  for (std::uint64_t key = 1; key <= link::kMaxHosts; ++key) hosts.emplace_back(bench, false, key);
  Tester tester(bench);
  static_cast<void>(tester.ask({0x31, 0x01, 0x02, 0x02}));
  tester.run(200);
  expect_entry(audit_page(hosts.front(), 0).back(), {AuditEvent::kDisarmed, link::kTesterAddress, "", 0,
                                                     static_cast<std::uint16_t>(StoppedBy::kDisarm)});
}

TEST(Audit, ANameHasPrintableCharactersOnly) {
  Bench bench;
  Tester host(bench, false, 1);
  ASSERT_EQ(host.refused(call_me("alice")), link::Nrc::kNotInThisSession);
  ASSERT_TRUE(host.ok({0x10, 0x03}));
  EXPECT_EQ(host.text(link::kDidHostName), "");
  ASSERT_TRUE(host.ok(call_me("alice")));
  for (int byte = 0; byte < 256; ++byte) {
    const std::string name = std::string("al") + static_cast<char>(byte) + "ce";
    EXPECT_EQ(host.ok(call_me(name)), byte >= 0x20 && byte < 0x7F) << byte;
  }
  ASSERT_TRUE(host.ok(call_me(std::string(24, 'x'))));
  EXPECT_EQ(host.refused(call_me(std::string(25, 'y'))), link::Nrc::kIncorrectLength);
  EXPECT_EQ(host.text(link::kDidHostName), std::string(24, 'x'));
  // A place has its own name.
  Tester other(bench, false, 2);
  EXPECT_EQ(other.text(link::kDidHostName), "");
}

}  // namespace
}  // namespace thimble::test
