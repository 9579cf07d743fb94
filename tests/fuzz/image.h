// Scene images as bytes, and functions to corrupt them.
#pragma once

#include <flatbuffers/flatbuffers.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "tests/support/random.h"

namespace thimble::test {

using Bytes = std::vector<std::byte>;

// A copy of the image with `value` at `place`, which points into `image`.
template <typename Value>
[[nodiscard]] Bytes changed(const Bytes& image, const void* place, Value value) {
  Bytes bytes = image;
  std::memcpy(&bytes.at(static_cast<std::size_t>(static_cast<const std::byte*>(place) - image.data())),
              &value, sizeof value);
  return bytes;
}

// A byte inside a struct of the schema, by its offset there.
[[nodiscard]] inline const void* part(const void* start, std::size_t offset) {
  return static_cast<const std::byte*>(start) + offset;
}

// A scalar of a table has no address in the interface: by its offset in the vtable.
[[nodiscard]] inline const void* scalar(const void* table, flatbuffers::voffset_t field) {
  return static_cast<const flatbuffers::Table*>(table)->GetAddressOf(field);
}

// One to three changes: a bit turned, or a word replaced by one that readers trip over.
inline void spoil(Bytes& bytes, Random& random) {
  constexpr std::array<std::uint32_t, 8> kWords{0,          1,          0x7FFFFFFF, 0xFFFFFFFF,
                                                0x7F800000, 0x7FC00000, 0x3F800000, 8};
  const std::uint64_t changes = 1 + random.below(3);
  for (std::uint64_t change = 0; change < changes; ++change) {
    if (random.below(2) == 0) {
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1U << random.below(8));
    } else {
      std::memcpy(bytes.data() + 4 * random.below(bytes.size() / 4), &kWords.at(random.below(kWords.size())),
                  4);
    }
  }
}

}  // namespace thimble::test
