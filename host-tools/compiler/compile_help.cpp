#include "host-tools/compiler/compile_help.h"

#include <utility>

namespace thimble::host {
namespace {

CompileHelp& help_of_process() {
  static CompileHelp help;
  return help;
}

}  // namespace

void set_compile_help(CompileHelp help) { help_of_process() = std::move(help); }
const CompileHelp& compile_help() { return help_of_process(); }

}  // namespace thimble::host
