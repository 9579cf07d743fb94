// The validated view of a scene image: the only way from bytes to the renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::scene {
struct Scene;
}

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

// The field's name for a status, for logs and telemetry ("bad_tree").
[[nodiscard]] const char* name(ImageStatus status) noexcept;

// Refers to the bytes that were checked; they must stay unchanged and in place for as long as the view is
// used.
class SceneView {
 public:
  // Verifies bytes (FlatBuffers, then numbers, ranges and tree) and sets `view` when they are sound; `view`
  // is untouched otherwise. Cost O(bytes). Never reads outside `bytes`, whatever they hold.
  [[nodiscard]] static ImageStatus check(std::span<const std::byte> bytes, SceneView& view) noexcept;

  [[nodiscard]] const scene::Scene* scene() const noexcept { return scene_; }  // null: the empty scene

 private:
  const scene::Scene* scene_ = nullptr;
};

}  // namespace thimble::control
