// The compiler of a command on a terminal: with the user's cache, and with progress on stderr. For main().
#pragma once

namespace thimble::host {

// `quiet` (--json), or stderr is no terminal: nothing is printed. Otherwise one line while an object takes longer than half a second; it is
// removed at its end.
void help_compiler(bool quiet);

}  // namespace thimble::host
