// SLCAN: the port, and the stream behind a terminal or a socket. A frame that is read can stand on a bus and is written as a line that
// reads the same; a closed channel gives nothing but a stop; a host that reads no answer takes no memory.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "board/posix/slcan_stream.h"
#include "firmware/link/messages.h"
#include "firmware/link/slcan_port.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace thimble;
namespace link = firmware::link;

void check_frame(const link::CanFrame& frame) {
  fuzz::demand(link::is_valid(frame), "a frame can stand on a bus");
  link::SlcanLine line;
  const std::size_t size = link::encode_slcan(frame, line);
  link::SlcanParser parser;
  auto event = link::SlcanParser::Event::kNone;
  for (const char c : std::span(line).first(size)) event = parser.push(c);
  fuzz::demand(event == link::SlcanParser::Event::kFrame && parser.frame() == frame,
               "a frame that is written as a line reads the same");
}

void through_port(std::span<const std::uint8_t> bytes) {
  link::SlcanPort port;
  for (const std::uint8_t byte : bytes) {
    const bool open = port.open();
    if (port.push(static_cast<char>(byte)) == link::SlcanPort::Event::kFrame) {
      check_frame(port.frame());
      fuzz::demand(open || (!port.frame().extended && port.frame().id == link::EmergencyStop::kId),
                   "a closed channel gives nothing but a stop");
    }
    fuzz::demand(port.reply().size() <= 8, "an answer is short");
  }
}

void through_stream(std::span<const std::uint8_t> bytes, board::SlcanStream::Kind kind, bool reads) {
  std::array<int, 2> ends{};
  fuzz::demand(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) == 0,
               "there is a pair of sockets");
  const board::Descriptor host(ends[1]);
  board::SlcanStream stream(board::Descriptor(ends[0]), kind);
  constexpr std::size_t kPiece = 512;
  while (!bytes.empty() && !stream.gone()) {
    const auto piece = bytes.first(std::min(kPiece, bytes.size()));
    bytes = bytes.subspan(piece.size());
    fuzz::demand(write(host.get(), piece.data(), piece.size()) == static_cast<ssize_t>(piece.size()),
                 "a piece fits into a socket");
    stream.read();
    while (const auto frame = stream.receive()) {
      check_frame(*frame);
      fuzz::demand(!stream.gone(), "a stream that is closed gives no frame");
      stream.send(*frame);
    }
    stream.flush();
    std::array<char, 16384> answers{};
    while (reads && ::read(host.get(), answers.data(), answers.size()) > 0) {
    }
  }
  fuzz::demand(kind == board::SlcanStream::Kind::kSocket || !stream.gone() || !reads,
               "a terminal that reads its answers is not closed");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  through_port(bytes);
  through_stream(
      bytes, (data[0] & 1U) != 0 ? board::SlcanStream::Kind::kSocket : board::SlcanStream::Kind::kTerminal,
      (data[0] & 2U) != 0);
  return 0;
}
