#include "host-tools/cli/compile_progress.h"

#include <unistd.h>

#include <string>

#include "firmware/link/can_frame.h"
#include "host-tools/cli/output.h"
#include "host-tools/client/transport.h"
#include "host-tools/compiler/compile_help.h"

namespace thimble::host {
namespace {

constexpr link::Micros kQuiet_us = 500000;

class ObjectProgress {
 public:
  void operator()(const std::string& object, double share) {
    if (share <= 0.0) begun_us_ = now_us();
    if (share >= 1.0) {
      if (shown_) fmt::print(stderr, "\r\x1b[K");
      shown_ = false;
    } else if (shown_ || now_us() - begun_us_ > kQuiet_us) {
      shown_ = true;
      fmt::print(stderr, "\r\x1b[K");
      say(stderr, "compiling {}: {:.0f} %", object, 100.0 * share);
    }
  }

 private:
  link::Micros begun_us_ = 0;
  bool shown_ = false;
};

}  // namespace

void help_compiler(bool quiet) {
  CompileHelp help;
  help.cache.emplace(SolvedCache::user_folder());
  if (!quiet && isatty(STDERR_FILENO) != 0) help.progress = ObjectProgress();
  set_compile_help(std::move(help));
}

}  // namespace thimble::host
