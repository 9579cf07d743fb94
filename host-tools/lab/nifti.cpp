#include "host-tools/lab/nifti.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr std::size_t kHeaderBytes = 348;
constexpr std::size_t kFirstVoxelByte = 352;  // the earliest: after the header and 4 bytes of extension flags

struct DataType {
  int code;
  std::size_t bytes;
  const char* name;
};
constexpr std::array<DataType, 10> kTypes{{{2, 1, "uint8"},
                                           {4, 2, "int16"},
                                           {8, 4, "int32"},
                                           {16, 4, "float32"},
                                           {64, 8, "float64"},
                                           {256, 1, "int8"},
                                           {512, 2, "uint16"},
                                           {768, 4, "uint32"},
                                           {1024, 8, "int64"},
                                           {1280, 8, "uint64"}}};

template <typename Number>
Number number_at(const unsigned char* place, bool swapped) {
  std::array<unsigned char, sizeof(Number)> bytes{};
  std::copy_n(place, bytes.size(), bytes.begin());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

[[noreturn]] void fail(const char* name, const std::filesystem::path& file, const std::string& what,
                       const std::string& remedy) {
  throw Error(ExitCode::kBadInput, name, file.string() + ": " + what, remedy);
}

// A file, compressed or not.
class Stream {
 public:
  explicit Stream(const std::filesystem::path& path)
      : path_(path), file_(gzopen(path.c_str(), "rb"), gzclose) {
    std::error_code ignored;
    if (file_ == nullptr || !std::filesystem::is_regular_file(path, ignored))
      fail("missing-volume", path, file_ == nullptr ? std::strerror(errno) : "is no file",
           "give the path of a .nii or .nii.gz file");
  }

  // Adds bytes until there are `size`, or fewer where the file ends.
  void fill(std::vector<unsigned char>& bytes, std::size_t size) {
    while (bytes.size() < size) {
      const std::size_t had = bytes.size();
      const std::size_t wanted = std::min(kPiece, size - had);
      bytes.resize(had + wanted);
      const std::size_t got = read(bytes.data() + had, wanted);
      bytes.resize(had + got);
      if (got == 0) return;
    }
  }

  // Reads what is left: at the end of a compressed file stands its checksum.
  void finish() {
    std::vector<unsigned char> rest(kPiece);
    for (std::size_t all = 0; all < kMaxVolumeBytes;) {
      const std::size_t got = read(rest.data(), rest.size());
      if (got == 0) return;
      all += got;
    }
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 20U;

  std::size_t read(unsigned char* place, std::size_t size) {
    const int got = gzread(file_.get(), place, static_cast<unsigned>(size));
    int code = Z_OK;
    const char* text = gzerror(file_.get(), &code);
    if (got < 0 || (code != Z_OK && code != Z_BUF_ERROR))
      fail("bad-volume", path_, std::string("cannot be decompressed: ") + text, "fetch the file again");
    return static_cast<std::size_t>(got);
  }

  std::filesystem::path path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile_s*)> file_;
};

// Fields of the header, by their offset.
class Header {
 public:
  Header(std::span<const unsigned char> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
  [[nodiscard]] int i16(std::size_t at) const {
    return number_at<std::int16_t>(bytes_.data() + at, swapped_);
  }
  [[nodiscard]] double f32(std::size_t at) const {
    return static_cast<double>(number_at<float>(bytes_.data() + at, swapped_));
  }

  [[nodiscard]] int dim(int i) const { return i16(40 + 2 * static_cast<std::size_t>(i)); }
  [[nodiscard]] double pixdim(int i) const { return f32(76 + 4 * static_cast<std::size_t>(i)); }

  // Method 3: the rows of the affine are written down.
  [[nodiscard]] Eigen::Affine3d sform() const {
    Eigen::Affine3d world = Eigen::Affine3d::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        world.matrix()(row, column) = f32(280 + static_cast<std::size_t>(16 * row + 4 * column));
      }
    }
    return world;
  }
  // Method 2: a rotation, the voxel's edges and an offset. pixdim[0] < 0 turns k round.
  [[nodiscard]] Eigen::Affine3d qform() const {
    const Eigen::Vector3d v(f32(256), f32(260), f32(264));
    const Eigen::Quaterniond q(std::sqrt(std::max(1.0 - v.squaredNorm(), 0.0)), v.x(), v.y(), v.z());
    Eigen::Affine3d world = Eigen::Affine3d::Identity();
    const double side = pixdim(0) < 0.0 ? -1.0 : 1.0;
    world.linear() = q.normalized().toRotationMatrix() *
                     Eigen::Vector3d(pixdim(1), pixdim(2), side * pixdim(3)).asDiagonal();
    world.translation() = Eigen::Vector3d(f32(268), f32(272), f32(276));
    return world;
  }
  // Method 1: edges alone.
  [[nodiscard]] Eigen::Affine3d edges() const {
    return Eigen::Affine3d(Eigen::Scaling(Eigen::Vector3d(pixdim(1), pixdim(2), pixdim(3))));
  }

 private:
  std::span<const unsigned char> bytes_;
  bool swapped_;
};

// The file's length unit in mm; mm if the file does not say.
double unit_mm(unsigned units, const std::filesystem::path& file) {
  switch (units & 7U) {
    case 0:
    case 2:
      return 1.0;
    case 1:
      return 1000.0;
    case 3:
      return 0.001;
    default:
      break;
  }
  fail("bad-volume", file, "xyzt_units is " + std::to_string(units) + ", which is no unit of length",
       "write the file again with a NIfTI-1 tool");
}

// The byte order, or none when this is no NIfTI-1 header.
std::optional<bool> byte_order(const std::vector<unsigned char>& bytes) {
  for (const bool swapped : {false, true}) {
    if (number_at<std::int32_t>(bytes.data(), swapped) == static_cast<std::int32_t>(kHeaderBytes))
      return swapped;
  }
  return std::nullopt;
}

void check_magic(const std::vector<unsigned char>& bytes, const std::filesystem::path& file) {
  constexpr std::int32_t kNifti2 = 540;
  const bool other = bytes.size() >= 4 && (number_at<std::int32_t>(bytes.data(), false) == kNifti2 ||
                                           number_at<std::int32_t>(bytes.data(), true) == kNifti2);
  if (other)
    fail("unsupported-volume", file, "is NIfTI-2",
         "convert it to NIfTI-1 (nifti_tool, fslchfiletype, nibabel)");
  if (bytes.size() < kHeaderBytes || !byte_order(bytes))
    fail("not-nifti", file, "is not a NIfTI-1 file", "give a .nii or .nii.gz file");
  const std::string magic(bytes.begin() + 344, bytes.begin() + 347);
  if (magic == "ni1")
    fail("unsupported-volume", file, "is the header of a pair of files (.hdr and .img)",
         "convert it to a single .nii file");
  if (magic != "n+1")
    fail("not-nifti", file, "is an ANALYZE file, or damaged: it has no NIfTI-1 magic",
         "convert it to NIfTI-1");
}

}  // namespace

Volume Volume::read(const std::filesystem::path& file) {
  const std::string again = "write the file again with a NIfTI-1 tool";
  Stream stream(file);
  Volume volume;
  std::vector<unsigned char>& bytes = volume.bytes_;
  stream.fill(bytes, kHeaderBytes);
  check_magic(bytes, file);
  volume.swapped_ = *byte_order(bytes);
  const std::vector<unsigned char> header_bytes = bytes;
  const Header header(header_bytes, volume.swapped_);

  const int dimensions = header.dim(0);
  if (dimensions < 3 || dimensions > 7)
    fail("unsupported-volume", file, "has " + std::to_string(dimensions) + " dimensions, not 3",
         "give a volume of 3 dimensions");
  for (int i = 1; i <= dimensions; ++i) {
    if (i <= 3 ? header.dim(i) < 1 : header.dim(i) > 1)
      fail("unsupported-volume", file,
           "has " + std::to_string(header.dim(i)) + " samples along dimension " + std::to_string(i),
           "take one volume of 3 dimensions out of it");
    if (i <= 3) volume.size_[i - 1] = header.dim(i);
  }

  volume.type_ = header.i16(70);
  const auto* const type = std::find_if(
      kTypes.begin(), kTypes.end(), [&volume](const DataType& each) { return each.code == volume.type_; });
  if (type == kTypes.end())
    fail("unsupported-volume", file, "has voxels of data type " + std::to_string(volume.type_),
         "convert them to integers or floats (complex, colour and 128-bit voxels are not read)");
  volume.type_name_ = type->name;

  const double begin = header.f32(108);
  if (!(begin >= static_cast<double>(kFirstVoxelByte) && begin <= static_cast<double>(kMaxVolumeBytes)) ||
      begin != std::floor(begin))
    fail("bad-volume", file, "vox_offset is " + std::to_string(begin), again);
  volume.begin_ = static_cast<std::size_t>(begin);
  const double data = volume.size_.cast<double>().prod() * static_cast<double>(type->bytes);
  if (data + begin > static_cast<double>(kMaxVolumeBytes))
    fail("unsupported-volume", file,
         "has " + std::to_string(data / 1048576.0) + " MiB of voxels, at most " +
             std::to_string(kMaxVolumeBytes / 1048576) + " MiB are allowed",
         "cut the volume down to where the line goes");

  // A slope of zero or NaN means that values are not scaled.
  const double slope = header.f32(112);
  const double offset = header.f32(116);
  if (slope != 0.0 && std::isfinite(slope) && std::isfinite(offset)) {
    volume.slope_ = slope;
    volume.offset_ = offset;
  }

  if (header.i16(254) > 0) {
    volume.world_mm_ = header.sform();
    volume.frame_name_ = "sform";
  } else if (header.i16(252) > 0) {
    volume.world_mm_ = header.qform();
    volume.frame_name_ = "qform";
  } else {
    volume.world_mm_ = header.edges();
    volume.frame_name_ = "pixdim";
  }
  volume.world_mm_ = Eigen::Scaling(unit_mm(header_bytes[123], file)) * volume.world_mm_;
  constexpr double kSmallestVoxel_mm3 = 1.0e-9;
  if (!volume.world_mm_.matrix().allFinite() ||
      !(std::abs(volume.world_mm_.linear().determinant()) > kSmallestVoxel_mm3))
    fail("bad-volume", file, std::string("its ") + volume.frame_name_ + " gives voxels without a volume",
         again);

  const std::size_t needed = volume.begin_ + static_cast<std::size_t>(data);
  stream.fill(bytes, needed);
  if (bytes.size() < needed)
    fail("truncated-volume", file,
         "ends after " + std::to_string(bytes.size()) + " of " + std::to_string(needed) + " bytes",
         "fetch the file again");
  stream.finish();
  return volume;
}

double Volume::at(const Eigen::Vector3i& voxel) const {
  const Eigen::Matrix<std::size_t, 3, 1> n = size_.cast<std::size_t>();
  const Eigen::Matrix<std::size_t, 3, 1> v = voxel.cast<std::size_t>();
  const std::size_t flat = v[0] + n[0] * (v[1] + n[1] * v[2]);
  const auto stored = [this, flat]<typename Number>(Number) {
    return static_cast<double>(number_at<Number>(bytes_.data() + begin_ + flat * sizeof(Number), swapped_));
  };
  double value = 0.0;
  switch (type_) {
    case 2:
      value = stored(std::uint8_t{});
      break;
    case 4:
      value = stored(std::int16_t{});
      break;
    case 8:
      value = stored(std::int32_t{});
      break;
    case 16:
      value = stored(float{});
      break;
    case 64:
      value = stored(double{});
      break;
    case 256:
      value = stored(std::int8_t{});
      break;
    case 512:
      value = stored(std::uint16_t{});
      break;
    case 768:
      value = stored(std::uint32_t{});
      break;
    case 1024:
      value = stored(std::int64_t{});
      break;
    case 1280:
      value = stored(std::uint64_t{});
      break;
    default:
      break;  // read() has refused it
  }
  return slope_ * value + offset_;
}

}  // namespace thimble::host
