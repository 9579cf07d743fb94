// Writes PNG images byte by byte, so that the reader under test is compared with an independent writer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace thimble::test {

// As in the format (ISO 15948): `scanlines` with a filter byte before each row.
struct PngImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint8_t bit_depth = 8;
  std::uint8_t colour_type = 0;  // 0 grey, 2 RGB, 3 palette, 4 grey + alpha, 6 RGBA
  std::uint8_t interlace = 0;    // 1: Adam7
  std::vector<std::uint8_t> scanlines{};
  std::vector<std::uint8_t> palette{};       // RGB triples
  std::vector<std::uint8_t> transparency{};  // tRNS
};

[[nodiscard]] std::string encode(const PngImage& image);

// 16 bit grey, the first row on top; unfiltered.
[[nodiscard]] PngImage grey_png(std::uint32_t width, const std::vector<std::uint16_t>& brightness);

}  // namespace thimble::test
