#include "host-tools/cli/completion.h"

#include <iostream>

#include "board/sim/plant.h"
#include "firmware/core/faults.h"
#include "firmware/params.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/client/discovery.h"
#include "host-tools/lab/cost_report.h"

namespace thimble::host {

void complete(const CLI::App& app, const std::vector<std::string>& words) {
  const std::string last = words.empty() ? "" : words.back();
  const CLI::App* at = &app;
  std::string path;  // "param get"
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const auto next = at->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == words[i]; });
    if (next.empty()) continue;
    at = next.front();
    path += (path.empty() ? "" : " ") + words[i];
  }
  const std::string before = words.size() < 2 ? "" : words[words.size() - 2];

  std::vector<std::string> candidates;
  if (before == "--device") {
    for (const DeviceEntry& device : discover()) candidates.push_back(device.name);
  } else if (before == "--arm") {
    for (const board::PlantVariant& variant : board::plant_variants()) candidates.emplace_back(variant.name);
  } else if (before == "--board" && path == "compile") {
    for (const board::BoardCost& board : board::board_costs()) candidates.emplace_back(board.name);
  } else {
    for (const CLI::App* sub : at->get_subcommands([](const CLI::App*) { return true; })) {
      candidates.push_back(sub->get_name());
    }
    for (const CLI::Option* option : at->get_options()) {
      for (const std::string& name : option->get_lnames()) candidates.push_back("--" + name);
    }
    if (path == "model check" || path == "model show" || path == "commission") {
      for (const std::filesystem::path& file : arm_files()) candidates.push_back(file.stem().stem().string());
    }
    if (path == "param get" || path == "param set") {
      for (const firmware::ParamRow& row : firmware::kParamTable) candidates.emplace_back(row.name);
    }
    if (path == "fault explain") {
      for (const firmware::FaultRow& row : firmware::kFaultTable) candidates.emplace_back(row.name);
    }
  }
  for (const std::string& candidate : candidates) {
    if (candidate.starts_with(last) && (!last.empty() || !candidate.starts_with("--")))
      std::cout << candidate << '\n';
  }
}

}  // namespace thimble::host
