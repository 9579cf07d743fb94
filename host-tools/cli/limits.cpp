#include "host-tools/cli/limits.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <string_view>

#include "control/scene/limits.h"

namespace thimble::host {
namespace {

Json to_json(float value) { return tidy(value); }
Json to_json(std::size_t value) { return value; }

std::string key_of(std::string_view constant) {
  std::string key;
  for (const char c : constant.substr(1, constant.find('_') - 1)) {
    const bool capital = std::isupper(static_cast<unsigned char>(c)) != 0;
    if (capital && !key.empty()) key += '_';
    key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return key + std::string(constant.substr(std::min(constant.find('_'), constant.size())));
}

}  // namespace

std::vector<LimitRow> scene_limits() {
  return {
#define THIMBLE_LIMIT(constant, of) {key_of(#constant), to_json(control::constant), of},
#include "thimble_limits/scene_limits.inc"
#undef THIMBLE_LIMIT
  };
}

}  // namespace thimble::host
