#include "host-tools/cli/usage.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

std::vector<std::string> names_of_options(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_fnames()) names.push_back("--" + name);
  }
  return names;
}

[[noreturn]] void refuse(const std::string& cause, const std::string& meant, const CLI::App& where) {
  const std::string help = "`" + full_name(where) + " --help` has all of them";
  throw Error(ExitCode::kUsage, "usage", cause,
              meant.empty() ? help : "did you mean `" + meant + "`? " + help);
}

// Letters to change, add, leave out, or exchange with the next one (optimal string alignment).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

bool is_number(const std::string& word) {
  return word.size() > 1 && (std::isdigit(static_cast<unsigned char>(word[1])) != 0 || word[1] == '.');
}

}  // namespace

std::vector<std::string> names_of_verbs(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_min() > 0; }

FoundVerb find_verb(const CLI::App& app, const std::vector<std::string>& words) {
  FoundVerb found{&app, 0};
  for (const std::string& word : words) {
    const auto named =
        found.verb->get_subcommands([&word](const CLI::App* verb) { return verb->get_name() == word; });
    if (named.empty()) break;
    found = {named.front(), found.words + 1};
  }
  return found;
}

std::string full_name(const CLI::App& verb) {
  const CLI::App* const parent = verb.get_parent();
  return (parent == nullptr ? "" : full_name(*parent) + " ") + verb.get_name();
}

void refuse_unknown(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* verb = &app;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--") return;
    if (!word.starts_with("-") || word == "-" || is_number(word)) {
      if (names_of_verbs(*verb).empty()) continue;
      const FoundVerb next = find_verb(*verb, {word});
      if (next.words == 0)
        refuse("'" + word + "' is no verb of " + full_name(*verb), nearest(word, names_of_verbs(*verb)),
               *verb);
      verb = next.verb;
      continue;
    }
    const bool is_long = word.starts_with("--");
    const std::string name = is_long ? word.substr(0, word.find('=')) : word.substr(0, 2);
    const std::vector<std::string> options = names_of_options(*verb);
    if (std::ranges::find(options, name) == options.end())
      refuse("'" + name + "' is no option of " + full_name(*verb), nearest(name, options), *verb);
    const CLI::Option* const option = verb->get_option_no_throw(name);
    const bool has_value = option != nullptr && takes_value(*option);
    if (has_value && (is_long ? name == word : word.size() == 2)) ++i;
  }
}

std::string help_of(const CLI::App& app, const std::vector<std::string>& words) {
  refuse_unknown(app, words);
  const FoundVerb found = find_verb(app, words);
  const std::string name = full_name(*found.verb);
  if (found.words < words.size())
    refuse("'" + words[found.words] + "' is no verb of " + name, "", *found.verb);
  // Not its help(), which is that of the verb that was given: `thimble help`.
  return found.verb->get_formatter()->make_help(found.verb, name, CLI::AppFormatMode::Normal);
}

std::string nearest(std::string_view word, const std::vector<std::string>& names) {
  std::vector<std::string> begun;
  std::ranges::copy_if(names, std::back_inserter(begun),
                       [word](const std::string& name) { return name.starts_with(word); });
  if (begun.size() == 1) return begun.front();
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t letters = distance(word, name);
    if (letters >= least) continue;
    least = letters;
    best = name;
  }
  return best;
}

}  // namespace thimble::host
