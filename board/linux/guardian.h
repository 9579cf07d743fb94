// A second process that puts the outputs into the safe state after the board process has ended in any way
// (SIGKILL, a crash). The kernel does not do this: most GPIO drivers leave a line as it was when its owner
// has ended, and a converter keeps its voltages.
//
// Create it when the outputs are open, before threads are started and memory is locked. It ignores SIGTERM
// and SIGINT.
#pragma once

#include <sys/types.h>

#include "board/posix/descriptor.h"

namespace thimble::board {

class Guardian {
 public:
  // Forks; throws std::system_error. The child process keeps `outputs` in its present state and calls
  // outputs.make_safe() when the parent has ended.
  template <typename Outputs>
  explicit Guardian(Outputs& outputs) {
    if (!begin()) return;
    outputs.make_safe();
    leave();
  }
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;
  ~Guardian();  // triggers outputs.make_safe() in the guardian and waits for it

  [[nodiscard]] bool gone() noexcept;  // the guardian was ended: the board must stop

 private:
  [[nodiscard]] bool begin();  // true: in the guardian, and the board has ended
  [[noreturn]] static void leave() noexcept;

  Descriptor pipe_;  // the board's end of the pipe; the kernel closes it with the board
  pid_t process_ = -1;
};

}  // namespace thimble::board
