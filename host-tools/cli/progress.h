// How far a long verb is, on stderr: on a terminal one line that is redrawn, and removed at the end.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

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
  // Work whose share is not known: "recorded 12 s".
  void show(std::string_view what);
  // The line is removed, as what follows is printed.
  void end();

 private:
  [[nodiscard]] bool is_due() const;
  void draw(std::string_view line);

  bool quiet_, terminal_, tenths_;
  double begun_at_;
  link::Micros begin_us_, shown_us_ = 0;
  bool drawn_ = false;
  unsigned tenth_;
};

// What takes long and does not say how far it is: on a terminal its name and its seconds, from the second one on.
class Busy {
 public:
  Busy(bool quiet, std::string what);
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;
  ~Busy();

 private:
  void watch();

  Progress progress_;
  std::string what_;
  bool done_ = false;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::thread watcher_;  // where there is a terminal
};

// Before something else is printed while a Busy is there.
void erase_progress();

}  // namespace thimble::host
