// Which scene of scenes/ runs at which rate on which core, by the estimate that `thimble compile --board` gives (board/sim/scene_cost.h), and a
// stated factor for what instructions do not tell. No clock is read: the same on every machine.
#pragma once

#include <string>
#include <string_view>

namespace thimble::test {

// A Markdown table. core: "all", or a name of core_names(); of another one it is empty.
[[nodiscard]] std::string scene_rates(std::string_view core);
[[nodiscard]] std::string core_names();  // "m7-480, ..."

}  // namespace thimble::test
