// Logs of CAN frames as `candump -L` and `candump -l` write them, a frame a line:
//   (1700000000.123456) can0 181#0102030405060708     29-bit ids have eight digits, ID##FLAGSDATA is an FD frame, ID#R a remote one
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "firmware/link/can_frame.h"

namespace thimble::host {

struct LoggedFrame {
  double time_s = 0.0;  // as in the log
  std::string interface;
  bool error = false;  // an error frame of the driver; the rest is not set
  firmware::link::CanFrame frame;
};

// No value: the line is not a frame.
[[nodiscard]] std::optional<LoggedFrame> parse_log_line(std::string_view line);

}  // namespace thimble::host
