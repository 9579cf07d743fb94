#include "host-tools/compiler/height_grid.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>

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

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  return first == std::string_view::npos ? std::string_view()
                                         : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

double read_number(std::string_view cell, const std::string& place, std::size_t column) {
  double value = 0;
  const auto [stop, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (code != std::errc() || stop != cell.data() + cell.size() || !std::isfinite(value)) {
    std::string given(cell.substr(0, 40));
    std::replace_if(
        given.begin(), given.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    refuse("bad-number",
           place + ": column " + std::to_string(column) + " is \"" + given + "\", which is not a number",
           "separate numbers such as 1.5 or -2e-3 by commas");
  }
  return value;
}

HeightGrid read_csv(std::string_view text, std::size_t most_samples, const std::string& name) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  HeightGrid grid;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    row = trimmed(row.substr(0, row.find('#')));
    if (row.empty()) continue;
    const std::string place = name + ":" + std::to_string(line);
    std::size_t columns = 0;
    for (bool more = true; more;) {
      const std::size_t comma = row.find(',');
      more = comma != std::string_view::npos;
      const std::string_view cell = trimmed(row.substr(0, comma));
      row.remove_prefix(more ? comma + 1 : row.size());
      ++columns;
      const double value = read_number(cell, place, columns);
      if (grid.values.size() == most_samples) {
        refuse("too-many-samples",
               place + ": the grid has more than " + std::to_string(most_samples) +
                   " values, as many as are allowed",
               "make the grid coarser");
      }
      grid.values.push_back(value);
    }
    if (grid.rows == 0) grid.columns = columns;
    if (columns != grid.columns) {
      refuse("uneven-rows",
             place + ": the row has " + std::to_string(columns) + " values, the rows before it have " +
                 std::to_string(grid.columns),
             "give each row as many values");
    }
    ++grid.rows;
  }
  check_size(grid.columns, grid.rows, most_samples, name);
  return grid;
}

// One image in the making. libpng leaves by longjmp where it fails, so what needs a destructor lives in the caller.
struct PngReader {
  std::string_view bytes;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 128> complaint{};

  explicit PngReader(std::string_view image) : bytes(image) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
    if (png != nullptr) info = png_create_info_struct(png);
    if (info != nullptr) png_set_read_fn(png, this, read);
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
  std::error_code code;
  std::ifstream stream(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, code) || !stream) {
    refuse("missing-heights", name + ": there is no such file, or it cannot be opened",
           "give a CSV or PNG file, relative to the scene file");
  }
  const std::uintmax_t size = std::filesystem::file_size(file, code);
  if (code || size > kMaxGridBytes) {
    refuse("heights-file-too-large",
           name + ": the file has " + std::to_string(size) + " bytes, at most " +
               std::to_string(kMaxGridBytes) + " are allowed",
           "make the grid coarser");
  }
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  HeightGrid grid = bytes.starts_with(kPngSignature) ? read_png(bytes, most_samples, name)
                                                     : read_csv(bytes, most_samples, name);
  turn_over(grid);
  return grid;
}

}  // namespace thimble::host
