// Messages of a page. What is one is in the ranges that the device takes.
#include <algorithm>
#include <cmath>

#include "host-tools/viewer/protocol.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  try {
    const host::PageMessage message = host::parse_page_message(fuzz::text_of({data, size}));
    if (const auto* hand = std::get_if<host::HandMessage>(&message))
      fuzz::demand(std::ranges::all_of(hand->position_m, [](double x) { return std::isfinite(x); }),
                   "a hand is somewhere");
    if (const auto* parameter = std::get_if<host::ParameterMessage>(&message))
      fuzz::demand(parameter->value >= static_cast<double>(parameter->row->min) &&
                       parameter->value <= static_cast<double>(parameter->row->max),
                   "a parameter is within its limits");
    if (const auto* material = std::get_if<host::MaterialMessage>(&message))
      fuzz::demand(std::isfinite(material->value), "a material is finite");
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kUsage, "what is no message is refused as one");
    fuzz::demand(host::Json::accept(host::to_text(host::event_json(error))), "the page can read the refusal");
  }
  return 0;
}
