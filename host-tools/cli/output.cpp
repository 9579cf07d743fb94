#include "host-tools/cli/output.h"

#include <iostream>

#include "board/files/json_value.h"
#include "host-tools/client/printable.h"

namespace thimble::host {

void vsay(std::FILE* to, fmt::string_view format, fmt::format_args arguments) {
  const std::string text = printable(fmt::vformat(format, arguments));
  std::fwrite(text.data(), 1, text.size(), to);
}

Json document(std::string_view verb) {
  Json json;
  json["schema"] = kJsonSchema;
  json["verb"] = verb;
  return json;
}

void print(const Json& json) {
  std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
}
void print_line(const Json& json) {
  std::cout << json.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
}

void report(const Error& error, bool json) {
  if (json) {
    Json out;
    out["schema"] = kJsonSchema;
    out["error"] = {{"name", error.name},
                    {"cause", error.cause},
                    {"remedy", error.remedy},
                    {"exit_code", static_cast<int>(error.code)}};
    std::cerr << out.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
  } else {
    std::cerr << printable("thimble: " + error.name + ": " + error.cause + "\n  remedy: " + error.remedy)
              << std::endl;
  }
}

double tidy(float value) { return board::as_written(value); }

}  // namespace thimble::host
