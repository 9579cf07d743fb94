#include "host-tools/compiler/height_grid.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "board/files/csv.h"
#include "board/files/text_file.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::uintmax_t kMaxGridBytes = std::uintmax_t{64} << 20U;
constexpr std::size_t kLeastSide = 2;
constexpr std::string_view kPngSignature("\x89PNG\r\n\x1A\n", 8);

[[noreturn]] void refuse(const std::string& slug, const std::string& cause, const std::string& remedy) {
  throw Error(ExitCode::kBadInput, slug, cause, remedy);
}

void check_size(std::size_t columns, std::size_t rows, std::size_t most_samples, const std::string& name) {
  const std::string size =
      name + ": the grid is " + std::to_string(columns) + " x " + std::to_string(rows) + " values, ";
  if (columns < kLeastSide || rows < kLeastSide) {
    refuse("too-few-samples", size + "at least 2 x 2 are needed", "give a larger grid");
  }
  if (rows > most_samples / columns) {
    refuse("too-many-samples", size + "at most " + std::to_string(most_samples) + " values are allowed",
           "make the grid coarser");
  }
}

// The first row becomes the last, see HeightGrid.
void turn_over(HeightGrid& grid) {
  const auto width = static_cast<std::ptrdiff_t>(grid.columns);
  for (auto low = grid.values.begin(), high = grid.values.end() - width; low < high;
       low += width, high -= width) {
    std::swap_ranges(low, low + width, high);
  }
}

HeightGrid read_csv(std::string_view text, std::size_t most_samples, const std::string& name) {
  board::CsvReader csv(text, name, '#');
  HeightGrid grid;
  while (csv.next()) {
    const std::size_t columns = csv.cells().size();
    for (std::size_t column = 0; column < columns; ++column) {
      const std::optional<double> value = csv.number(column);
      if (!value) {
        std::string given(csv.cells()[column].substr(0, 40));
        std::ranges::replace_if(
            given, [](char c) { return c < ' ' || c > '~'; }, '?');
        refuse("bad-number",
               csv.place() + ": column " + std::to_string(column + 1) + " is \"" + given +
                   "\", which is not a number",
               "separate numbers such as 1.5 or -2e-3 by commas");
      }
      if (grid.values.size() == most_samples) {
        refuse("too-many-samples",
               csv.place() + ": the grid has more than " + std::to_string(most_samples) +
                   " values, as many as are allowed",
               "make the grid coarser");
      }
      grid.values.push_back(*value);
    }
    if (grid.rows == 0) grid.columns = columns;
    if (columns != grid.columns) {
      refuse("uneven-rows",
             csv.place() + ": the row has " + std::to_string(columns) + " values, the rows before it have " +
                 std::to_string(grid.columns),
             "give each row as many values");
    }
    ++grid.rows;
  }
  check_size(grid.columns, grid.rows, most_samples, name);
  return grid;
}

// Decodes one image. libpng reports errors by longjmp, so objects with destructors belong to the caller.
struct PngReader {
  std::string_view bytes;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 128> complaint{};

  explicit PngReader(std::string_view image) : bytes(image) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
    if (png != nullptr) info = png_create_info_struct(png);
    if (info != nullptr) png_set_read_fn(png, this, read);
    // Only the chunks that make the pixels. Of a text, libpng takes as much memory as it announces before it reads a byte: 654 MB for a
    // file of 200 bytes.
    if (png != nullptr) png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  [[noreturn]] static void on_error(png_structp png, png_const_charp message) {
    auto* const self = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(self->complaint.data(), message, self->complaint.size() - 1);
    png_longjmp(png, 1);
  }
  static void read(png_structp png, png_bytep to, std::size_t count) {
    auto* const self = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > self->bytes.size()) png_error(png, "the file ends too early");
    std::memcpy(to, self->bytes.data(), count);
    self->bytes.remove_prefix(count);
  }

  // To 16 bit red, green, blue, alpha, whatever the file holds. False with a complaint.
  bool read_header() {
    // NOLINTNEXTLINE(cert-err52-cpp): libpng's way to fail
    if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_info(png, info);
    png_set_expand_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xFFFFU, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    return true;
  }
  bool read_pixels(png_bytepp rows) {
    // NOLINTNEXTLINE(cert-err52-cpp)
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
  }
};

HeightGrid read_png(std::string_view bytes, std::size_t most_samples, const std::string& name) {
  PngReader reader(bytes);
  const auto broken = [&] {
    refuse("unreadable-png", name + ": the PNG image cannot be read: " + reader.complaint.data(),
           "save the image again, as PNG");
  };
  if (!reader.read_header()) broken();
  HeightGrid grid;
  grid.columns = png_get_image_width(reader.png, reader.info);
  grid.rows = png_get_image_height(reader.png, reader.info);
  check_size(grid.columns, grid.rows, most_samples, name);

  constexpr std::size_t kPixelBytes = 8;
  if (png_get_rowbytes(reader.png, reader.info) != kPixelBytes * grid.columns) broken();
  std::vector<png_byte> pixels(kPixelBytes * grid.columns * grid.rows);
  std::vector<png_bytep> rows(grid.rows);
  for (std::size_t row = 0; row < grid.rows; ++row) {
    rows[row] = pixels.data() + kPixelBytes * grid.columns * row;
  }
  if (!reader.read_pixels(rows.data())) broken();

  const auto channel = [&](std::size_t at) { return 256U * pixels[at] + pixels[at + 1]; };
  constexpr double kWhite = 10000.0 * 65535.0 * 65535.0;
  grid.values.reserve(grid.columns * grid.rows);
  for (std::size_t at = 0; at < pixels.size(); at += kPixelBytes) {
    // In whole numbers, so that the division rounds once.
    const std::uint64_t luma = std::uint64_t{2126} * channel(at) + std::uint64_t{7152} * channel(at + 2) +
                               std::uint64_t{722} * channel(at + 4);
    grid.values.push_back(static_cast<double>(luma * channel(at + 6)) / kWhite);
  }
  return grid;
}

}  // namespace

HeightGrid read_height_grid(const std::filesystem::path& file, std::size_t most_samples,
                            const std::string& name) {
  const std::optional<std::uintmax_t> size = board::size_of_file(file);
  if (size > kMaxGridBytes) {
    refuse("heights-file-too-large",
           name + ": the file has " + std::to_string(*size) + " bytes, at most " +
               std::to_string(kMaxGridBytes) + " are allowed",
           "make the grid coarser");
  }
  std::string bytes;
  try {
    if (!size) throw board::FileError("no file");
    bytes = board::read_text(file);
  } catch (const board::FileError&) {
    refuse("missing-heights", name + ": there is no such file, or it cannot be opened",
           "give a CSV or PNG file, relative to the scene file");
  }
  HeightGrid grid = bytes.starts_with(kPngSignature) ? read_png(bytes, most_samples, name)
                                                     : read_csv(bytes, most_samples, name);
  turn_over(grid);
  return grid;
}

}  // namespace thimble::host
