// Where there is no folder of the user's own, as in a page: nothing is kept.
#include "host-tools/compiler/solved_cache.h"

namespace thimble::host {

std::filesystem::path SolvedCache::user_folder() { return {}; }
std::optional<std::string> SolvedCache::find(std::string_view /*key*/) const { return std::nullopt; }
void SolvedCache::keep(std::string_view /*key*/, std::string_view /*value*/) const {}

}  // namespace thimble::host
