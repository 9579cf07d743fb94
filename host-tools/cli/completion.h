// The words that a shell may complete (completion.bash).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace thimble::host {

// Prints the candidates for the last of the words that follow `thimble` on the command line, one per line.
void complete(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace thimble::host
