// What CLI::Range checks, and nan.
#pragma once

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

namespace thimble::host {

// Of an option: a number from `least` to `most`. CLI::Range lets nan pass.
inline CLI::Validator number_between(double least, double most) {
  const auto check = [least, most](const std::string& text) {
    double number = 0;
    if (CLI::detail::lexical_cast(text, number) && number >= least && number <= most) return std::string();
    std::ostringstream out;
    out << "'" << text << "' is not a number from " << least << " to " << most;
    return out.str();
  };
  return {[check](std::string& text) { return check(text); }, "", ""};
}

}  // namespace thimble::host
