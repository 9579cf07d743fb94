#include "host-tools/cli/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <span>

#include "board/files/json_value.h"
#include "host-tools/client/printable.h"
#include "host-tools/compiler/scene_errors.h"

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

void demand_written() {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if ((flushed && std::ferror(stdout) == 0) || errno == EPIPE) return;
  throw Error(ExitCode::kRefused, "cannot-write",
              std::string("cannot write to standard output: ") + std::strerror(errno != 0 ? errno : EIO),
              "check where it goes, and the space left there");
}

void report(const Error& error, bool json) {
  const auto* const scene = dynamic_cast<const SceneErrors*>(&error);
  if (json) {
    Json out;
    out["schema"] = kJsonSchema;
    out["error"] = {{"name", error.name},
                    {"cause", error.cause},
                    {"remedy", error.remedy},
                    {"exit_code", static_cast<int>(error.code)}};
    if (scene != nullptr) {
      out["errors"] = Json::array();
      for (const SceneIssue& issue : scene->issues)
        out["errors"].push_back({{"name", issue.name},
                                 {"cause", issue.cause},
                                 {"remedy", issue.remedy},
                                 {"pointer", issue.pointer},
                                 {"line", issue.place.line},
                                 {"column", issue.place.column}});
      out["more_errors"] = scene->more;
    }
    std::cerr << out.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
  } else {
    const auto print = [](const auto& each) {
      std::cerr << printable("thimble: " + each.name + ": " + each.cause + "\n  remedy: " + each.remedy)
                << std::endl;
    };
    print(error);
    if (scene == nullptr) return;
    for (const SceneIssue& issue : std::span(scene->issues).subspan(1)) print(issue);
    if (scene->more > 0) std::cerr << "and " << scene->more << " more" << std::endl;
  }
}

double tidy(float value) { return board::as_written(value); }

}  // namespace thimble::host
