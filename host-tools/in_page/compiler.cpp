// The scene compiler as a module of a page: a scene's text in, its image out. The files that the scene names are in the page's file system.
#include <nlohmann/json.hpp>

#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "host-tools/in_page/exports.h"

namespace {

using thimble::host::give;
using Json = nlohmann::ordered_json;

std::string image;

}  // namespace

// In: a scene's text. `folder` is what its paths are relative to: "/scenes/ring". Out: JSON, {"warnings": [...]}, and the image by compiled();
// or {"error": {"name", "cause", "remedy"}}.
EXPORT(int, compile)(std::size_t name_bytes) {
  using namespace thimble::host;
  const std::string name = page_buffer.substr(0, name_bytes);
  const std::string text = page_buffer.substr(name_bytes);
  image.clear();
  Json result;
  try {
    const CompiledScene scene = compile_scene_text(text, name, std::filesystem::path(name).parent_path());
    image.assign(reinterpret_cast<const char*>(scene.image.data()), scene.image.size());
    result["warnings"] = scene.report.warnings;
  } catch (const Error& error) {
    result["error"] = {{"name", error.name}, {"cause", error.cause}, {"remedy", error.remedy}};
  }
  return give(result.dump(-1, ' ', false, Json::error_handler_t::replace));
}
EXPORT(int, compiled)() { return give(image); }
