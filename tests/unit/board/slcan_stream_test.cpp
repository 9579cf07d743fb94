// The streams of a board's sockets and terminals.
#include "board/posix/slcan_stream.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace thimble::test {
namespace {

using board::Descriptor;
using board::SlcanStream;

// The frames that a program sent which opened the channel, wrote them and ended.
std::vector<std::uint32_t> heard(SlcanStream::Kind kind, std::string_view sent) {
  std::array<int, 2> ends{};
  EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()), 0);
  SlcanStream stream(Descriptor{ends[0]}, kind);
  {
    const Descriptor program{ends[1]};
    EXPECT_EQ(write(program.get(), sent.data(), sent.size()), static_cast<ssize_t>(sent.size()));
  }
  stream.read();
  std::vector<std::uint32_t> ids;
  while (const auto frame = stream.receive()) ids.push_back(frame->id);
  firmware::link::CanFrame out;
  out.id = 0x180;
  stream.send(out);
  EXPECT_EQ(stream.waiting(), kind == SlcanStream::Kind::kSocket);
  return ids;
}

TEST(SlcanStream, TakesOnlyTheStopOfAProgramThatNobodyKnows) {
  constexpr std::string_view kSent = "S8\rO\rT18DA01F120310\rt1002AA55\rt0010\rt1002AA55\r";
  using Ids = std::vector<std::uint32_t>;
  EXPECT_EQ(heard(SlcanStream::Kind::kSocket, kSent), (Ids{0x18DA01F1, 0x100, 0x001, 0x100}));
  EXPECT_EQ(heard(SlcanStream::Kind::kStopsOnly, kSent), (Ids{0x001}));
}

}  // namespace
}  // namespace thimble::test
