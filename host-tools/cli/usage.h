// What is wrong with the words of a command line: CLI11 says less, or something else first.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::host {

// The subcommand that the first words name, and how many they are. "param get max_force": get of param, 2.
struct FoundVerb {
  const CLI::App* verb;
  std::size_t words;
};
[[nodiscard]] FoundVerb find_verb(const CLI::App& app, const std::vector<std::string>& words);

// Of its subcommands; none: it is one that does something.
[[nodiscard]] std::vector<std::string> names_of_verbs(const CLI::App& app);
[[nodiscard]] bool takes_value(const CLI::Option& option);

// "thimble param get"
[[nodiscard]] std::string full_name(const CLI::App& verb);

// Throws Error "usage" for a word that is no verb, or an option that its verb does not have, with the nearest name there is.
void refuse_unknown(const CLI::App& app, const std::vector<std::string>& words);

// What `VERB --help` prints. Throws like refuse_unknown().
[[nodiscard]] std::string help_of(const CLI::App& app, const std::vector<std::string>& words);

// The name that was probably meant: the only one that `word` begins, or the one with the fewest letters to change, add, leave out or exchange,
// at most a third of them; "": none.
[[nodiscard]] std::string nearest(std::string_view word, const std::vector<std::string>& names);

}  // namespace thimble::host
