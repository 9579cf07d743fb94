// A second process that outlives this one by a moment: when the board's process ends, however it ends (SIGKILL, a crash), the
// guardian puts its outputs into the safe state. The kernel alone would not: most GPIO drivers leave a line as it was when
// its holder is gone, and a converter keeps its voltages.
//
// To be made when the outputs are open and before threads are started and memory is locked. SIGTERM and SIGINT are not for it.
#pragma once

#include <sys/types.h>

#include "board/posix/descriptor.h"

namespace thimble::board {

class Guardian {
 public:
  // Forks; throws std::system_error. In the other process `outputs` is kept as it is now and
  // outputs.make_safe() called at the end.
  template <typename Outputs>
  explicit Guardian(Outputs& outputs) {
    if (!begin()) return;
    outputs.make_safe();
    leave();
  }
  Guardian(const Guardian&) = delete;
  Guardian& operator=(const Guardian&) = delete;
  ~Guardian();  // lets it do its work, and waits until it has

  [[nodiscard]] bool gone() noexcept;  // somebody ended it: the board must not go on without

 private:
  [[nodiscard]] bool begin();  // true: in the guardian, and the board has ended
  [[noreturn]] static void leave() noexcept;

  Descriptor pipe_;  // the board's end: it closes with the board
  pid_t process_ = -1;
};

}  // namespace thimble::board
