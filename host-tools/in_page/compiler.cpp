// The scene compiler as a module of a page: a scene's text in, its image out. The files that the scene names are in the page's file system.
#include <map>

#include "firmware/link/crc32.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/in_page/exports.h"
#include "host-tools/viewer/protocol.h"

namespace thimble::host {
namespace {

std::string compiled_image;
std::map<std::string, std::shared_ptr<const CompiledParts>> known_parts;  // by the scene's file

Json compile(const std::string& file, const std::string& text) {
  Json result = {{"name", ""},
                 {"objects", Json::array()},
                 {"warnings", Json::array()},
                 {"issues", Json::array()},
                 {"more", 0}};
  try {
    std::shared_ptr<const CompiledParts>& parts = known_parts[file];
    const CompiledScene scene =
        compile_scene_text(text, file, std::filesystem::path(file).parent_path(), parts.get());
    parts = scene.parts;
    compiled_image.assign(reinterpret_cast<const char*>(scene.image.data()), scene.image.size());
    result["name"] = scene.report.name;
    result["crc"] = firmware::link::crc32(scene.image);
    for (const SceneReport::Object& object : scene.report.objects) result["objects"].push_back(object.name);
    result["warnings"] = scene.report.warnings;
  } catch (const SceneErrors& errors) {
    for (const SceneIssue& issue : errors.issues) result["issues"].push_back(json_of(issue));
    result["more"] = errors.more;
  } catch (const Error& error) {
    result["issues"].push_back(json_of({error.name, error.cause, error.remedy, "", {}}));
  }
  return result;
}

}  // namespace
}  // namespace thimble::host

// In: the path of the scene's file, and its text. Out: JSON: name, objects, warnings, crc of the image; issues (name, cause, remedy, pointer, line,
// column) where there is no image, and how many more there are. compiled(): the image.
THIMBLE_EXPORT(int, compile)(std::size_t file_bytes) {
  using namespace thimble::host;
  const std::string file = page_buffer.substr(0, file_bytes);
  const std::string text = page_buffer.substr(file_bytes);
  compiled_image.clear();
  return give(compile(file, text).dump(-1, ' ', false, Json::error_handler_t::replace));
}
THIMBLE_EXPORT(int, compiled)() { return thimble::host::give(thimble::host::compiled_image); }
