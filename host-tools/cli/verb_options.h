// The options of verbs that have many of them.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "host-tools/cli/verbs.h"

namespace thimble::host {

// The type of options and arguments that are files, in the help and for completion.cpp. Each source that adds options includes this header.
inline constexpr const char* kFileType = "FILE";

}  // namespace thimble::host

template <>
constexpr const char* CLI::detail::type_name<std::filesystem::path>() {
  return thimble::host::kFileType;
}

namespace thimble::host {

void add_monitor_options(CLI::App& verb, MonitorChoice& choice);
void add_publish_options(CLI::App& verb, PublishChoice& choice);
void add_mesh_options(CLI::App& verb, MeshChoice& choice);
void add_commission_options(CLI::App& verb, CommissionChoice& choice);
// arms: the names that --arm may have, for the help.
void add_simulate_options(CLI::App& verb, SimulateChoice& choice, const std::string& arms);
void add_sweep_options(CLI::App& verb, SweepChoice& choice);
// Of verbs that serve a page.
void add_page_options(CLI::App& verb, std::string& listen, std::uint16_t& port, bool& browser);

}  // namespace thimble::host
