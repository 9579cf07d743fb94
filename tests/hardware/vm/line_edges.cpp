// line_edges FILE [PROCESS]: prints each change of a simulated GPIO line (the file `value` of gpio-sim), as time in ns (CLOCK_MONOTONIC) and level,
// until it is ended. PROCESS: gets SIGKILL when the line rises. In the virtual machine only.
#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "tests/hardware/vm/arm_hardware.h"

int main(int argc, char** argv) {
  const int file = argc >= 2 ? open(argv[1], O_RDONLY) : -1;
  const long process = argc >= 3 ? std::strtol(argv[2], nullptr, 10) : 0;
  if (file < 0) return 1;
  constexpr timespec kLook{0, 100'000};
  for (char level = '0', now = '0';; nanosleep(&kLook, nullptr)) {
    if (pread(file, &now, 1, 0) != 1) return 1;
    if (now == level) continue;
    level = now;
    if (level == '1' && process > 0 && kill(static_cast<pid_t>(process), SIGKILL) != 0) return 1;
    std::printf("%llu %c\n", static_cast<unsigned long long>(thimble::test::now_ns()), level);
    std::fflush(stdout);
  }
}
