#include "tests/unit/lab/nifti_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace thimble::test {
namespace {

class Writer {
 public:
  explicit Writer(bool big_endian)
      : bytes_(352, 0), swapped_(big_endian == (std::endian::native == std::endian::little)) {}

  template <typename Number>
  void put(std::size_t at, Number value) {
    auto raw = std::bit_cast<std::array<unsigned char, sizeof(Number)>>(value);
    if (swapped_) std::reverse(raw.begin(), raw.end());
    if (bytes_.size() < at + raw.size()) bytes_.resize(at + raw.size());
    std::copy(raw.begin(), raw.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }
  void put_short(std::size_t at, int value) { put(at, static_cast<std::int16_t>(value)); }
  void put_float(std::size_t at, double value) { put(at, static_cast<float>(value)); }
  template <typename Number>
  void append(double value) {
    put(bytes_.size(), std::is_floating_point_v<Number> ? static_cast<Number>(value)
                                                        : static_cast<Number>(std::llround(value)));
  }
  void text(std::size_t at, std::string_view text) {
    std::copy(text.begin(), text.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }
  std::vector<unsigned char> take() { return std::move(bytes_); }

 private:
  std::vector<unsigned char> bytes_;
  bool swapped_;
};

void append(Writer& out, int type, double value) {
  switch (type) {
    case 2:
      return out.append<std::uint8_t>(value);
    case 4:
      return out.append<std::int16_t>(value);
    case 8:
      return out.append<std::int32_t>(value);
    case 16:
      return out.append<float>(value);
    case 64:
      return out.append<double>(value);
    case 256:
      return out.append<std::int8_t>(value);
    case 512:
      return out.append<std::uint16_t>(value);
    case 768:
      return out.append<std::uint32_t>(value);
    case 1024:
      return out.append<std::int64_t>(value);
    case 1280:
      return out.append<std::uint64_t>(value);
    default:
      throw std::logic_error("no such type");
  }
}

}  // namespace

std::vector<unsigned char> nifti_bytes(const NiftiFile& file) {
  const double per_mm = file.units == 1 ? 1.0e-3 : file.units == 3 ? 1.0e3 : 1.0;
  Writer out(file.big_endian);
  out.put(0, std::int32_t{348});
  out.put_short(40, 3);
  for (int i = 0; i < 3; ++i) out.put_short(42 + 2 * static_cast<std::size_t>(i), file.size[i]);
  for (std::size_t i = 3; i < 7; ++i) out.put_short(42 + 2 * i, 1);
  out.put_short(70, file.type);
  const Eigen::Vector3d edges = file.world.linear().colwise().norm() * per_mm;
  const double side = file.world.linear().determinant() < 0.0 ? -1.0 : 1.0;
  out.put_float(76, side);
  for (int i = 0; i < 3; ++i) out.put_float(80 + 4 * static_cast<std::size_t>(i), edges[i]);
  out.put_float(108, 352.0);
  out.put_float(112, file.slope);
  out.put_float(116, file.offset);
  out.put(123, static_cast<std::uint8_t>(file.units));
  if (file.frame == NiftiFile::Frame::kQform) {
    Eigen::Matrix3d rotation = file.world.linear() * edges.cwiseInverse().asDiagonal() * per_mm;
    rotation.col(2) *= side;
    Eigen::Quaterniond q(rotation);
    if (q.w() < 0.0) q.coeffs() *= -1.0;
    out.put_short(252, 1);
    out.put_float(256, q.x());
    out.put_float(260, q.y());
    out.put_float(264, q.z());
    for (int i = 0; i < 3; ++i)
      out.put_float(268 + 4 * static_cast<std::size_t>(i), file.world.translation()[i] * per_mm);
  }
  if (file.frame == NiftiFile::Frame::kSform) {
    out.put_short(254, 1);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column)
        out.put_float(280 + static_cast<std::size_t>(16 * row + 4 * column),
                      file.world.matrix()(row, column) * per_mm);
    }
  }
  out.text(344, "n+1");
  for (int k = 0; k < file.size.z(); ++k) {
    for (int j = 0; j < file.size.y(); ++j) {
      for (int i = 0; i < file.size.x(); ++i) {
        const double value = file.value(file.world * Eigen::Vector3d(i, j, k));
        append(out, file.type, file.slope == 0.0 ? value : (value - file.offset) / file.slope);
      }
    }
  }
  return out.take();
}

void write_bytes(const std::filesystem::path& path, const std::vector<unsigned char>& bytes,
                 bool compressed) {
  if (compressed) {
    const gzFile out = gzopen(path.c_str(), "wb1");
    if (out == nullptr || gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size())) <= 0)
      throw std::runtime_error("cannot write " + path.string());
    gzclose(out);
    return;
  }
  std::ofstream out(path, std::ios::binary);
  for (const unsigned char byte : bytes) out.put(static_cast<char>(byte));
}

void write_nifti(const std::filesystem::path& path, const NiftiFile& file) {
  write_bytes(path, nifti_bytes(file), file.compressed);
}

}  // namespace thimble::test
