// Scene images in files, and arm images by write_image(). `thimble compile` and `thimble model compile` write the image followed by kImageTrailer and
// the image's CRC-32 (little-endian). FlatBuffers readers ignore the trailer. An upload announces this CRC, so the device refuses a
// scene image that changed on disk; thimble-sim refuses such an arm image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace thimble::host {

inline constexpr std::string_view kImageTrailer = "CRC1";

struct ImageFile {
  std::vector<std::byte> image;
  std::optional<std::uint32_t> crc;          // what the trailer says; none without a trailer
  std::vector<std::filesystem::path> files;  // that the scene file names
};

void write_image(const std::filesystem::path& file, std::span<const std::byte> image);

// An image file, or a scene file (*.json), which is compiled. Error kBadInput, kPermission.
[[nodiscard]] ImageFile load_image(const std::filesystem::path& file);

}  // namespace thimble::host
