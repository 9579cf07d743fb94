// Grids of numbers from text and from images: every value is exact, every error is refused with its position.
#include "host-tools/compiler/height_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/png.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using host::HeightGrid;
using testing::ElementsAre;
using testing::HasSubstr;

HeightGrid read(const std::string& bytes, std::size_t most_samples = 1000) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("grid", bytes);
  return host::read_height_grid(file, most_samples, "grid");
}

TEST(HeightGrid, ReadsTextWithItsLastLineFirst) {
  const HeightGrid grid = read("\xEF\xBB\xBF# a note\r\n1, 2.5 ,-3e-2\r\n\r\n  4,5,6  # the near row\r\n");
  EXPECT_EQ(grid.columns, 3U);
  EXPECT_EQ(grid.rows, 2U);
  EXPECT_THAT(grid.values, ElementsAre(4, 5, 6, 1, 2.5, -3e-2));
  EXPECT_EQ(grid.at(1, 1), 2.5);
  EXPECT_THAT(read("1,2\n3,4\n5,6").values, ElementsAre(5, 6, 3, 4, 1, 2));
}

TEST(HeightGrid, ReadsTextTheSameInEveryLocale) {
  const char* const changed = std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_THAT(read("1.5,2.25\n3,4").values, ElementsAre(3, 4, 1.5, 2.25));
  if (changed != nullptr) std::setlocale(LC_ALL, "C");
}

TEST(HeightGrid, BrightnessIsExact) {
  // Every value of 8 bits and a spread of those of 16, as grey and as colour with all channels alike.
  PngImage grey{.width = 16, .height = 16};
  PngImage colour{.width = 16, .height = 16, .colour_type = 2};
  PngImage clear{.width = 16, .height = 16, .colour_type = 6};
  std::vector<std::uint16_t> deep;
  for (unsigned i = 0; i < 256; ++i) {
    for (PngImage* image : {&grey, &colour, &clear}) {
      if (i % 16 == 0) image->scanlines.push_back(0);
      const std::size_t channels = image == &grey ? 1 : 3;
      image->scanlines.insert(image->scanlines.end(), channels, static_cast<std::uint8_t>(i));
      if (image == &clear) image->scanlines.push_back(255);
    }
    deep.push_back(static_cast<std::uint16_t>(257U * i + i % 7 * 31));
  }
  double worst = 0;
  const HeightGrid sixteen = read(encode(grey_png(16, deep)));
  for (const PngImage* image : {&grey, &colour, &clear}) {
    const HeightGrid eight = read(encode(*image));
    ASSERT_EQ(eight.values.size(), 256U);
    for (std::size_t i = 0; i < 256; ++i) {
      const std::size_t column = i % 16;
      const std::size_t row = 15 - i / 16;
      worst = std::max(worst, std::abs(eight.at(column, row) - static_cast<double>(i) / 255.0));
      worst = std::max(worst, std::abs(sixteen.at(column, row) - deep[i] / 65535.0));
    }
  }
  figure("brightness of grey, 8 and 16 bit: error", worst, "0");
  EXPECT_EQ(worst, 0.0);
}

TEST(HeightGrid, BrightnessOfColoursPalettesAndTransparency) {
  const std::vector<std::uint8_t> primaries{0, 255, 0, 0, 0, 255, 0, 0, 0, 0, 255, 255, 255, 255};
  EXPECT_THAT(read(encode({.width = 2, .height = 2, .colour_type = 2, .scanlines = primaries})).values,
              ElementsAre(0.0722, 1.0, 0.2126, 0.7152));
  // 1 bit a pixel, palette of blue and half transparent white.
  const PngImage palette{.width = 2,
                         .height = 2,
                         .bit_depth = 1,
                         .colour_type = 3,
                         .scanlines = {0, 0x40, 0, 0x80},
                         .palette = {0, 0, 255, 255, 255, 255},
                         .transparency = {255, 51}};
  EXPECT_THAT(read(encode(palette)).values, ElementsAre(0.2, 0.0722, 0.0722, 0.2));
  const PngImage alpha{
      .width = 2, .height = 2, .colour_type = 4, .scanlines = {0, 255, 0, 255, 51, 0, 51, 255, 0, 0}};
  EXPECT_THAT(read(encode(alpha)).values, ElementsAre(0.2, 0.0, 0.0, 0.2));
  // Adam7: pixel (0, 0), then (1, 0), then the second row.
  const PngImage interlaced{
      .width = 2, .height = 2, .interlace = 1, .scanlines = {0, 51, 0, 102, 0, 153, 204}};
  EXPECT_THAT(read(encode(interlaced)).values, ElementsAre(0.6, 0.8, 0.2, 0.4));
}

TEST(HeightGrid, EveryMistakeIsRefusedWithItsPlace) {
  const std::string good = encode(grey_png(2, {1, 2, 3, 4}));
  std::string bad_crc = good;
  bad_crc[bad_crc.size() - 14] ^= 1;
  const PngImage few_rows{.width = 2, .height = 3, .scanlines = {0, 1, 2, 0, 3, 4}};
  const PngImage bad_depth{.width = 2, .height = 2, .bit_depth = 3, .scanlines = {0, 1, 0, 1}};
  const PngImage no_palette{.width = 2, .height = 2, .colour_type = 3, .scanlines = {0, 1, 0, 0, 1, 0}};
  const PngImage huge{.width = 2000000000, .height = 2000000000, .scanlines = {0}};
  struct Case {
    std::string bytes;
    std::string name;
    std::string part;
  };
  const std::vector<Case> cases{
      {"", "too-few-samples", "grid: the grid is 0 x 0 values, at least 2 x 2"},
      {"1,2,3", "too-few-samples", "3 x 1"},
      {"1\n2\n", "too-few-samples", "1 x 2"},
      {"1,2\n3,x\n", "bad-number", "grid:2: column 2 is \"x\""},
      {"1,2\n3,\n", "bad-number", "grid:2: column 2 is \"\""},
      {"1,2\n\n3 4,5\n", "bad-number", "grid:3: column 1 is \"3 4\""},
      {"1;2\n3;4\n", "bad-number", "grid:1: column 1 is \"1;2\""},
      {"1,2\n3,nan\n", "bad-number", "grid:2: column 2 is \"nan\""},
      {"1,2\ninf,3\n", "bad-number", "grid:2: column 1 is \"inf\""},
      {"1,2\n1e999,3\n", "bad-number", "1e999"},
      {std::string("1,2\n\0\x01\xFF,3\n", 10), "bad-number", "grid:2: column 1 is \"???\""},
      {"1,2\n3,4,5\n", "uneven-rows", "grid:2: the row has 3 values, the rows before it have 2"},
      {"1,2,3,4,5\n1,2,3,4,5\n6", "too-many-samples", "grid:3: the grid has more than 10 values"},
      {encode(grey_png(2, std::vector<std::uint16_t>(12))), "too-many-samples", "2 x 6 values, at most 10"},
      {encode(grey_png(1, {1, 2})), "too-few-samples", "1 x 2"},
      {encode(huge), "unreadable-png", "grid: the PNG image cannot be read: "},
      {good.substr(0, good.size() / 2), "unreadable-png", "the file ends too early"},
      {good.substr(0, 8), "unreadable-png", "the file ends too early"},
      {bad_crc, "unreadable-png", "CRC"},
      {encode(few_rows), "unreadable-png", "Not enough image data"},
      {encode(bad_depth), "unreadable-png", "IHDR"},
      {encode(no_palette), "unreadable-png", "PLTE"},
  };
  for (const Case& c : cases) {
    try {
      static_cast<void>(read(c.bytes, 10));
      ADD_FAILURE() << c.name << " " << c.part;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, c.name) << error.cause;
      EXPECT_THAT(error.cause, HasSubstr(c.part));
      EXPECT_THAT(error.cause, testing::StartsWith("grid:"));
      EXPECT_FALSE(error.remedy.empty());
    }
  }
  for (std::size_t i = 0; i < good.size(); ++i) {  // every broken file gives an error or a grid
    for (const std::string& bytes : {good.substr(0, i), good.substr(0, i) + '\x55' + good.substr(i + 1)}) {
      try {
        EXPECT_EQ(read(bytes).values.size(), 4U);
      } catch (const host::Error&) {
      }
    }
  }
  EXPECT_THROW(static_cast<void>(host::read_height_grid("/no/such/file.csv", 10, "grid")), host::Error);
  const TemporaryFolder folder;
  const auto fifo = folder.path() / "fifo.csv";  // to open it would wait for a writer
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THROW(static_cast<void>(host::read_height_grid(fifo, 10, "grid")), host::Error);
  figure("kinds of broken grids tried", static_cast<double>(cases.size()), "each refused with its place");
}

}  // namespace
}  // namespace thimble::test
