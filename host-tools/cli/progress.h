// How far a long verb is, on stderr: on a terminal one line that is redrawn, and removed at the end.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "host-tools/client/transport.h"

namespace thimble::host {

class Progress {
 public:
  // quiet (--json): nothing is printed. begun_at: the share that was done before. tenths: where stderr is no terminal, a line per 10 %.
  explicit Progress(bool quiet, double begun_at = 0, bool tenths = false);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { end(); }

  // share: 0 to 1, of all. what: "step 3 of 10". In a terminal nothing is shown in the first second. Cheap: may be called in each tick.
  void show(double share, std::string_view what);
  // The same where the caller knows better what is left.
  void show(double share, std::string_view what, double left_s);
  // The line is removed, as what follows is printed.
  void end();

 private:
  bool quiet_, terminal_, tenths_;
  double begun_at_;
  link::Micros begin_us_, shown_us_ = 0;
  bool drawn_ = false;
  unsigned tenth_;
};

}  // namespace thimble::host
