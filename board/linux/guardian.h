// A second process that switches the drives off when the board process cannot: when it has ended in any way
// (SIGKILL, a crash), when it is stopped (SIGSTOP, a debugger), and when its servo hangs with a drive on. The
// kernel does none of this: most GPIO drivers leave a line as it was, and a converter keeps its voltages.
//
// Create it when the outputs are open, before threads are started and memory is locked. It ignores SIGTERM
// and SIGINT, and runs above the servo's priority.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>

#include "board/linux/servo_beat.h"
#include "board/posix/descriptor.h"

namespace thimble::board {

class Guardian {
 public:
  // The longest time between two outputs of the servo with a drive on.
  static constexpr std::uint64_t kLimit_ns = 5'000'000;

  // Forks; throws std::system_error. The child process keeps the outputs in their present state. It calls
  // make_safe() when the servo is later than the limit by `beat`, again at each further limit, and when the
  // parent has ended. priority: of SCHED_FIFO; without the privilege it runs at the usual one.
  Guardian(const std::function<void()>& make_safe, ServoBeat& beat, int priority);
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;
  ~Guardian();  // triggers make_safe() in the guardian and waits for it

  [[nodiscard]] bool gone() noexcept;  // the guardian was ended or stopped: the board must stop

 private:
  Descriptor pipe_;  // the board's end of the pipe; the kernel closes it with the board
  pid_t process_ = -1;
  bool stopped_ = false;
};

}  // namespace thimble::board
