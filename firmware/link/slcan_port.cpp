#include "firmware/link/slcan_port.h"

#include "firmware/link/messages.h"

namespace thimble::firmware::link {
namespace {

constexpr std::string_view kUnderstood = "\r";
constexpr std::string_view kRefused = "\a";

// Anybody's, at any time: what else the host may say depends on the open channel.
bool is_stop(const CanFrame& frame) noexcept { return !frame.extended && frame.id == EmergencyStop::kId; }

}  // namespace

SlcanPort::Event SlcanPort::push(char byte) noexcept {
  reply_ = {};
  switch (parser_.push(byte)) {
    case SlcanParser::Event::kFrame:
      if (open_ || is_stop(parser_.frame())) return Event::kFrame;
      reply_ = kRefused;
      return Event::kNone;
    case SlcanParser::Event::kBad:
      reply_ = kRefused;
      return Event::kNone;
    case SlcanParser::Event::kNone:
    case SlcanParser::Event::kAck:
    case SlcanParser::Event::kRefused:
      return Event::kNone;
    case SlcanParser::Event::kCommand:
      break;
  }
  switch (parser_.command()[0]) {
    case 'O':
      open_ = true;
      reply_ = kUnderstood;
      break;
    case 'C':
      open_ = false;
      reply_ = kUnderstood;
      return Event::kClosed;
    case 'S':  // any bit rate: there is no bus behind the stream
    case 's':
    case 'Y':
      reply_ = kUnderstood;
      break;
    case 'V':
      reply_ = "V1013\r";
      break;
    case 'N':
      reply_ = "NTHIM\r";
      break;
    case 'F':
      reply_ = "F00\r";
      break;
    default:
      reply_ = kRefused;
  }
  return Event::kNone;
}

}  // namespace thimble::firmware::link
