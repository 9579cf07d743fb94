// The options of verbs that have many of them.
#pragma once

#include <CLI/CLI.hpp>

#include "host-tools/cli/verbs.h"

namespace thimble::host {

void add_mesh_options(CLI::App& verb, MeshChoice& choice);
void add_commission_options(CLI::App& verb, CommissionChoice& choice);

}  // namespace thimble::host
