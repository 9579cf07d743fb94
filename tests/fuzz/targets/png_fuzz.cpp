// PNG images as grids of heights. The checksums of the chunks are mended first, or no mutant would come past them.
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>

#include "host-tools/compiler/height_grid.h"
#include "host-tools/error.h"
#include "tests/fuzz/targets/target.h"

namespace {

std::size_t number_at(const std::string& bytes, std::size_t at) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number = number << 8U | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

void mend_checksums(std::string& png) {
  constexpr std::size_t kSignature = 8, kLengthAndType = 8, kSum = 4;
  for (std::size_t at = kSignature; at + kLengthAndType + kSum <= png.size();) {
    const std::size_t length = number_at(png, at);
    if (length > png.size() - at - kLengthAndType - kSum) return;
    const auto sum = crc32(0, reinterpret_cast<const unsigned char*>(png.data()) + at + 4,
                           static_cast<unsigned>(length + 4));
    at += kLengthAndType + length;
    for (std::size_t i = 0; i < kSum; ++i) png[at + i] = static_cast<char>(sum >> (24 - 8 * i) & 0xFFU);
    at += kSum;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  static const fuzz::MemoryFile kFile;
  constexpr std::size_t kMostSamples = 1U << 16U;
  std::string png(fuzz::text_of({data, size}));
  mend_checksums(png);
  try {
    const host::HeightGrid grid = host::read_height_grid(kFile.with(png), kMostSamples, "image.png");
    fuzz::demand(grid.values.size() == grid.columns * grid.rows && grid.values.size() <= kMostSamples,
                 "the grid is as large as it says");
    const bool image = png.starts_with("\x89PNG");
    fuzz::demand(!image || std::ranges::all_of(grid.values, [](double v) { return v >= 0 && v <= 1; }),
                 "brightness is from 0 to 1");
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad image is bad input");
  }
  return 0;
}
