// What a program gives to the compiler besides scenes: a cache, and somebody who watches. For the whole process, because scenes are compiled by
// many verbs, and in the viewer by a thread of its own.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host-tools/compiler/solved_cache.h"

namespace thimble::host {

struct CompileHelp {
  std::optional<SolvedCache> cache;
  // Called by the thread that compiles: at the beginning of each object (share 0), between the steps of a long one, and at its end
  // (share 1), also if that is an error.
  std::function<void(const std::string& object, double share)> progress;
};

// Without a call the compiler has neither. Before the first scene is compiled, by one thread: in main().
void set_compile_help(CompileHelp help);
[[nodiscard]] const CompileHelp& compile_help();

}  // namespace thimble::host
