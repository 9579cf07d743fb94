#include "tests/support/png.h"

#include <zlib.h>

#include <stdexcept>
#include <string_view>

namespace thimble::test {
namespace {

void append_number(std::string& to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    to += static_cast<char>((value >> static_cast<unsigned>(shift)) & 0xFFU);
}

void append_chunk(std::string& to, std::string_view type, std::string_view data) {
  append_number(to, static_cast<std::uint32_t>(data.size()));
  std::string body(type);
  body += data;
  to += body;
  append_number(to, static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                                                     static_cast<uInt>(body.size()))));
}

std::string_view text(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

std::string encode(const PngImage& image) {
  std::string png = "\x89PNG\r\n\x1A\n";
  std::string header;
  append_number(header, image.width);
  append_number(header, image.height);
  for (const std::uint8_t byte :
       {image.bit_depth, image.colour_type, std::uint8_t{0}, std::uint8_t{0}, image.interlace})
    header += static_cast<char>(byte);
  append_chunk(png, "IHDR", header);
  if (!image.palette.empty()) append_chunk(png, "PLTE", text(image.palette));
  if (!image.transparency.empty()) append_chunk(png, "tRNS", text(image.transparency));
  uLongf size = compressBound(static_cast<uLong>(image.scanlines.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress(packed.data(), &size, image.scanlines.data(), static_cast<uLong>(image.scanlines.size())) !=
      Z_OK)
    throw std::runtime_error("zlib");
  packed.resize(size);
  append_chunk(png, "IDAT", text(packed));
  append_chunk(png, "IEND", "");
  return png;
}

PngImage grey_png(std::uint32_t width, const std::vector<std::uint16_t>& brightness) {
  PngImage image;
  image.width = width;
  image.height = static_cast<std::uint32_t>(brightness.size()) / width;
  image.bit_depth = 16;
  for (std::size_t i = 0; i < brightness.size(); ++i) {
    if (i % width == 0) image.scanlines.push_back(0);
    image.scanlines.push_back(static_cast<std::uint8_t>(brightness[i] >> 8U));
    image.scanlines.push_back(static_cast<std::uint8_t>(brightness[i] & 0xFFU));
  }
  return image;
}

}  // namespace thimble::test
