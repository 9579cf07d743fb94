#include "board/sim/injection.h"

#include <algorithm>
#include <array>

namespace thimble::board {
namespace {

constexpr std::array kInjections = {
#define THIMBLE_INJECTION(identifier, name, of, value, text) \
  InjectionRow{Injection::identifier, name, InjectionOf::of, value, text},
#include "board/sim/injection.def"
#undef THIMBLE_INJECTION
};

}  // namespace

std::span<const InjectionRow> injections() noexcept { return kInjections; }

const InjectionRow* find_injection(std::string_view name) noexcept {
  const auto row = std::ranges::find(kInjections, name, &InjectionRow::name);
  return row == kInjections.end() ? nullptr : &*row;
}

}  // namespace thimble::board
