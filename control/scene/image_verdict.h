// The result of the check of a scene image: a status, its name, and for what exceeds a limit the count and
// the limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::control {

// Why an image was refused. The numbers travel over the link: append only.
enum class ImageStatus : std::uint8_t {
  kOk = 0,
  kTooLarge = 1,    // larger than kMaxImageBytes
  kMisaligned = 2,  // the bytes do not start at a multiple of 8
  kNotAScene = 3,   // the FlatBuffers verifier or the file identifier refused it
  kTooManyObjects = 4,
  kTooManyTriangles = 5,
  kBadNumber = 6,  // not finite, or out of its range
  kBadIndex = 7,   // a vertex, triangle or neighbour that does not exist
  kBadTree = 8,    // cyclic, too deep, or a leaf out of range
  kNoShape = 9,
  kTooManyBodies = 10,
  kTooManySamples = 11,  // or columns, layers, subvolumes, curve points
};

struct ImageVerdict {
  // NOLINTNEXTLINE(google-explicit-constructor): most verdicts are a status and no more
  constexpr ImageVerdict(ImageStatus of = ImageStatus::kOk) noexcept : status(of) {}
  constexpr ImageVerdict(ImageStatus of, const char* too_many, std::size_t how_many,
                         std::size_t most) noexcept
      : status(of), what(too_many), count(how_many), limit(most) {}
  constexpr operator ImageStatus() const noexcept { return status; }  // NOLINT(google-explicit-constructor)

  ImageStatus status;
  // What exceeds its limit, the count so far (there may be more) and the limit; null for every other status.
  const char* what = nullptr;
  std::size_t count = 0;
  std::size_t limit = 0;
};

// The name of a status for logs and telemetry ("bad_tree").
[[nodiscard]] const char* name(ImageStatus status) noexcept;

// The name with count and limit, such as "too_many_bodies: 17 objects that move, at most 16"; truncated to
// `out`, which ends with a zero.
void write_text(const ImageVerdict& verdict, std::span<char> out) noexcept;

}  // namespace thimble::control
