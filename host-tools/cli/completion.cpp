#include "host-tools/cli/completion.h"

#include <algorithm>
#include <iostream>
#include <iterator>

#include "board/sim/plant.h"
#include "firmware/core/faults.h"
#include "firmware/params.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/cli/usage.h"
#include "host-tools/cli/verb_options.h"
#include "host-tools/client/discovery.h"
#include "host-tools/lab/cost_report.h"

namespace thimble::host {
namespace {

struct Candidates {
  std::vector<std::string> words;
  bool files = false;
};

// What an option or an argument may be.
Candidates values_of(const CLI::App& verb, const CLI::Option& option) {
  Candidates values;
  const std::string name = option.get_name();
  const bool is_arm = option.check_lname("arm") || option.check_lname("model") || name == "model";
  values.files = is_arm || option.get_type_name() == kFileType;
  if (name == "--device") {
    for (const DeviceEntry& device : discover()) values.words.push_back(device.name);
  } else if (name == "--board") {
    for (const board::BoardCost& board : board::board_costs()) values.words.emplace_back(board.name);
  } else if (name == "--kind") {
    values.words = {"all", "time", "depth", "spectrum"};
  } else if (full_name(verb).starts_with("thimble param ") && name == "name") {
    for (const firmware::ParamRow& row : firmware::kParamTable) values.words.emplace_back(row.name);
  } else if (name == "fault") {
    for (const firmware::FaultRow& row : firmware::kFaultTable) values.words.emplace_back(row.name);
  } else if (is_arm) {
    if (option.check_lname("arm"))
      for (const board::PlantVariant& variant : board::plant_variants())
        values.words.emplace_back(variant.name);
    for (const std::filesystem::path& file : arm_files()) values.words.push_back(file.stem().stem().string());
  }
  return values;
}

// For the last of the words.
Candidates candidates_for(const CLI::App& app, const std::vector<std::string>& words) {
  const std::vector<std::string> before(words.begin(), words.empty() ? words.end() : words.end() - 1);
  const FoundVerb found = find_verb(app, before);
  const CLI::App& verb = *found.verb;
  std::size_t place = 0;  // of the last word among the arguments
  for (std::size_t i = found.words; i < before.size(); ++i) {
    if (!before[i].starts_with("-") || before[i] == "-") {
      ++place;
      continue;
    }
    const CLI::Option* const option = verb.get_option_no_throw(before[i]);
    if (option == nullptr || !takes_value(*option)) continue;
    if (++i == before.size()) return values_of(verb, *option);
  }
  if (full_name(verb) == "thimble help")
    return {names_of_verbs(*find_verb(app, {before.begin() + 1, before.end()}).verb)};
  Candidates candidates;
  if (!words.empty() && words.back().starts_with("-")) {
    for (const CLI::Option* option : verb.get_options())
      for (const std::string& name : option->get_lnames()) candidates.words.push_back("--" + name);
    return candidates;
  }
  for (const CLI::Option* option : verb.get_options())
    if (option->get_positional() && place-- == 0) return values_of(verb, *option);
  return {names_of_verbs(verb)};
}

}  // namespace

void complete(const CLI::App& app, const std::vector<std::string>& words) {
  const Candidates candidates = candidates_for(app, words);
  const std::string last = words.empty() ? "" : words.back();
  std::vector<std::string> shown;
  std::ranges::copy_if(candidates.words, std::back_inserter(shown),
                       [&last](const std::string& word) { return word.starts_with(last); });
  std::ranges::sort(shown);
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  for (const std::string& word : shown) std::cout << word << '\n';
  if (candidates.files) std::cout << ":files\n";
}

}  // namespace thimble::host
