// The words that a shell may complete (completion.bash, .zsh, .fish).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace thimble::host {

// Prints the candidates for the last of the words that follow `thimble` on the command line, one per line, sorted; and a line ":files" where
// it may be the name of a file as well, which the shell knows better.
void complete(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace thimble::host
