// A grid of numbers from a file: a table in text (CSV) or the brightness of an image (PNG). Height fields and
// textures take their heights from one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace thimble::host {

// Seen from above as the file looks on a screen: its last line or row is nearest to the user and comes first
// here, x (columns, to the right) runs fastest, y (rows) goes away from the user.
struct HeightGrid {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<double> values;

  [[nodiscard]] double at(std::size_t column, std::size_t row) const {
    return values[row * columns + column];
  }
};

// A file that begins as a PNG is one: 0 is black and 1 white, any bit depth and colour type. Brightness is
// (0.2126 R + 0.7152 G + 0.0722 B) A of the stored values (the luma of ITU-R BT.709, no gamma undone), so
// that a grey g of 255 is exactly g / 255, and transparent is 0. Any other file is text: one row of the grid
// a line, numbers with a decimal point separated by commas, whatever the locale; empty lines and what follows
// a # are skipped.
//
// The grid has at least 2 x 2 and at most `most_samples` values, all finite. `name` stands in messages.
// Throws Error (kBadInput) with the line and column, or what is wrong with the image.
[[nodiscard]] HeightGrid read_height_grid(const std::filesystem::path& file, std::size_t most_samples,
                                          const std::string& name);

}  // namespace thimble::host
