// A scene file in memory, its image, and the materials that a viewer has changed. No files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/compiler/compiled_parts.h"
#include "host-tools/viewer/protocol.h"

namespace thimble::host {

using ImageBytes = std::shared_ptr<const std::vector<std::byte>>;

// A scene file in memory, and its image.
struct OpenScene {
  std::filesystem::path file;
  std::string file_text;             // as it was read, or written since
  std::optional<std::string> draft;  // in place of that text, not yet in the file
  std::map<std::pair<std::size_t, std::string>, double>
      changed_materials;  // by object and key, neither in the file nor in the draft
  std::string name;
  std::vector<std::string> objects;  // their names
  ImageBytes image;
  std::uint32_t crc = 0;                       // of the image
  std::shared_ptr<const CompiledParts> parts;  // which a change of a material leaves as they are
};

// The object gets this value; as with_material() of scene_text.h. Error kUsage: there is no such object.
void set_material(OpenScene& scene, const MaterialMessage& change);
// What is changed in one and not saved, in the other too: by the names of objects, as far as it has them.
void carry_changes(const OpenScene& from, OpenScene& to);
// The text of the draft, if there is one, or of the file, with the changes: only the numbers that were changed differ from it.
[[nodiscard]] std::string changed_text(const OpenScene& scene);
[[nodiscard]] const std::string& text_before_changes(const OpenScene& scene);
[[nodiscard]] bool has_changes(const OpenScene& scene);  // that are not in the file

// Under which a list of scenes has the file: "ring" of ring.scene.json.
inline constexpr std::string_view kSceneSuffix = ".scene.json";
[[nodiscard]] std::string name_of(const std::filesystem::path& file);

// "objects" of the scene message: names and materials, as the image has them.
[[nodiscard]] Json scene_json(const std::vector<std::byte>& image, std::uint32_t crc);

}  // namespace thimble::host
