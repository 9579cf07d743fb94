// A tester on a controller's link (ISO-TP and services in, real-time frames out), which runs the controller's ticks meanwhile.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "firmware/link/host_address.h"
#include "firmware/link/iso_tp.h"
#include "firmware/link/services.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {

namespace link = firmware::link;
using Bytes = std::vector<std::uint8_t>;

// A tester on the same wire; the controller ticks on meanwhile. Several may share a bench: while one waits for its answer, the
// others' frames wait for them. Board: a Bench, or what has its members controller, inputs.time_us, tick(), for_testers and alive.
template <class Board>
class TesterOf {
 public:
  explicit TesterOf(Board& bench, bool fd = false)
      : bench_(bench), channel_(link::request_id(1), link::response_id(1), {.fd = fd}) {
    bench_.alive = false;  // only the link keeps the controller's link alive
  }
  // A host that claims an address of its own.
  TesterOf(Board& bench, bool fd, std::uint64_t key) : TesterOf(bench, fd) {
    key_ = key;
    bench.controller->on_frame(link::to_frame(link::HostClaim{key, link::ClaimAction::kClaim}, 1, 0), now());
    link::CanFrame frame;
    link::HostGrant grant;
    while (bench.controller->next_frame(frame, now()))
      if (link::from_frame(frame, 1, grant) && grant.key == key && grant.address != 0)
        address_ = grant.address;
    EXPECT_NE(address_, link::kTesterAddress) << "no grant";
    channel_.set_ids(link::request_id(1, address_), link::response_id(1, address_));
  }
  [[nodiscard]] std::uint8_t address() const { return address_; }
  // Such a host gives its place back.
  void leave() {
    bench_.controller->on_frame(link::to_frame(link::HostClaim{key_, link::ClaimAction::kRelease}, 1, 0),
                                now());
  }

  // The answer, "response pending" ones left out. Empty: none within 5 s.
  Bytes ask(const Bytes& request) {
    post(request);
    return posted_answer();
  }
  void post(const Bytes& request) {
    EXPECT_TRUE(channel_.send(request, now()));
    flush();
  }
  Bytes posted_answer() {
    for (int i = 0; i < 20000; ++i) {
      step();
      const auto got = channel_.received();
      if (got.empty()) continue;
      Bytes answer(got.begin(), got.end());
      channel_.release();
      if (answer.size() == 3 && answer[0] == link::kNegative &&
          answer[2] == static_cast<std::uint8_t>(link::Nrc::kResponsePending)) {
        ++pending;
        continue;
      }
      return answer;
    }
    return {};
  }
  // Sends it, and waits 50 ms for answers that should not come: seen_answers().
  void say(const Bytes& request) {
    EXPECT_TRUE(channel_.send(request, now()));
    answers_ = 0;
    for (int i = 0; i < 200; ++i) {
      step();
      if (channel_.received().empty()) continue;
      ++answers_;
      channel_.release();
    }
  }
  [[nodiscard]] int seen_answers() const { return answers_; }
  bool ok(const Bytes& request) {
    const Bytes answer = ask(request);
    return !answer.empty() && answer[0] == request[0] + link::kPositive;
  }
  link::Nrc refused(const Bytes& request) {
    const Bytes answer = ask(request);
    return answer.size() == 3 && answer[0] == link::kNegative ? static_cast<link::Nrc>(answer[2])
                                                              : link::Nrc::kOk;
  }
  Bytes read(std::uint16_t did) {
    const Bytes answer = ask({0x22, static_cast<std::uint8_t>(did >> 8), static_cast<std::uint8_t>(did)});
    return answer.size() >= 3 && answer[0] == 0x62 ? Bytes(answer.begin() + 3, answer.end()) : Bytes{};
  }
  std::string text(std::uint16_t did) {
    const Bytes answer = read(did);
    return {answer.begin(), answer.end()};
  }
  bool routine(std::uint16_t id) {
    return ok({0x31, 0x01, static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id)});
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }

  std::vector<link::CanFrame> seen;  // real-time frames
  int pending = 0;

 private:
  link::Micros now() const { return bench_.inputs.time_us; }
  void flush() {
    link::CanFrame frame;
    while (channel_.next_frame(frame, now())) bench_.controller->on_frame(frame, now());
  }
  void step() {
    bench_.tick();
    flush();
    link::CanFrame frame;
    while (bench_.controller->next_frame(frame, now())) {
      if (frame.extended) {
        bench_.for_testers.push_back(frame);
      } else {
        seen.push_back(frame);
      }
    }
    std::erase_if(bench_.for_testers, [&](const link::CanFrame& sent) {
      return channel_.received().empty() && channel_.on_frame(sent, now());
    });
    flush();
    channel_.poll(now());
  }

  Board& bench_;
  link::IsoTpChannel channel_;
  std::uint64_t key_ = 0;
  std::uint8_t address_ = link::kTesterAddress;
  int answers_ = 0;
};
using Tester = TesterOf<Bench>;

inline Bytes big_endian(std::initializer_list<std::uint32_t> words) {
  Bytes bytes;
  for (const std::uint32_t word : words)
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
  return bytes;
}
inline Bytes join(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Prepare, request, blocks, exit. Returns the answer to the exit.
template <class Board>
Bytes download(TesterOf<Board>& tester, std::span<const std::byte> image, std::uint32_t crc,
               std::size_t block_bytes = 100) {
  const auto length = static_cast<std::uint32_t>(image.size());
  const Bytes prepared = tester.ask(join({0x31, 0x01, 0x02, 0x05}, big_endian({length, crc})));
  EXPECT_EQ(prepared.size(), 8U);
  EXPECT_EQ(prepared.empty() ? 0 : prepared[0], 0x71);
  const Bytes request = tester.ask(join({0x34, 0x00, 0x44}, big_endian({0, length})));
  EXPECT_EQ(request.empty() ? 0 : request[0], 0x74);
  std::uint8_t block = 1;
  for (std::size_t at = 0; at < image.size(); at += block_bytes, ++block) {
    Bytes data{0x36, block};
    for (std::size_t i = at; i < std::min(at + block_bytes, image.size()); ++i)
      data.push_back(std::to_integer<std::uint8_t>(image[i]));
    EXPECT_TRUE(tester.ok(data)) << at;
  }
  return tester.ask({0x37});
}

}  // namespace thimble::test
