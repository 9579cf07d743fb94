#include "host-tools/files/image_file.h"

#include <thimble_scene_schema/scene_generated.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/client/device.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

constexpr std::size_t kTrailerBytes = kImageTrailer.size() + 4;
constexpr std::size_t kLeastBytes = 8;  // the root's offset and the mark

}  // namespace

void write_image(const std::filesystem::path& file, std::span<const std::byte> image) {
  OutputFile out(file);
  const std::uint32_t crc = crc32(image);
  out.stream().write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size()));
  out.stream() << kImageTrailer;
  for (unsigned shift = 0; shift < 32; shift += 8) out.stream().put(static_cast<char>(crc >> shift & 0xFFU));
  out.commit();
}

ImageFile load_image(const std::filesystem::path& file) {
  if (file.extension() == ".json") {
    CompiledScene compiled = compile_scene(file);
    return {std::move(compiled.image), std::nullopt, std::move(compiled.report.files)};
  }

  const std::string bytes = read_input(file);
  ImageFile result;
  std::size_t size = bytes.size();
  if (size > kTrailerBytes && bytes.compare(size - kTrailerBytes, kImageTrailer.size(), kImageTrailer) == 0) {
    std::uint32_t crc = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      crc |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[size - 4 + i])) << (8U * i);
    }
    result.crc = crc;
    size -= kTrailerBytes;
  }
  if (size == 0 || size > control::kMaxImageBytes) {
    throw Error(ExitCode::kBadInput, "bad-image",
                file.string() + " has " + std::to_string(bytes.size()) + " bytes; a scene image has 1 to " +
                    std::to_string(control::kMaxImageBytes),
                "give a scene file or what `thimble compile` wrote");
  }
  // The device would say so too, but only after the upload.
  if (size < kLeastBytes || !scene::SceneBufferHasIdentifier(bytes.data())) {
    throw Error(ExitCode::kBadInput, "bad-image", file.string() + " is no scene image",
                "give a scene file (*.json) or what `thimble compile` wrote");
  }
  result.image.resize(size);
  std::memcpy(result.image.data(), bytes.data(), size);
  return result;
}

}  // namespace thimble::host
