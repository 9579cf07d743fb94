// The options of verbs that have many of them.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "host-tools/cli/verbs.h"

namespace thimble::host {

void add_mesh_options(CLI::App& verb, MeshChoice& choice);
void add_commission_options(CLI::App& verb, CommissionChoice& choice);
// Of verbs that serve a page.
void add_page_options(CLI::App& verb, std::string& listen, std::uint16_t& port, bool& browser);

}  // namespace thimble::host
