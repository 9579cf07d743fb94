// The contents of a scene image that somebody else may have made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "control/scene/scene_view.h"

namespace thimble::host {

// Has its own copy, aligned as the check demands.
class CheckedScene {
 public:
  explicit CheckedScene(std::span<const std::byte> image) : aligned_((image.size() + 7) / 8) {
    if (!image.empty()) std::memcpy(aligned_.data(), image.data(), image.size());
    control::SceneView view;
    if (control::SceneView::check(std::as_bytes(std::span(aligned_)).first(image.size()), view) ==
        control::ImageStatus::kOk)
      scene_ = view.scene();
  }
  CheckedScene(const CheckedScene&) = delete;
  CheckedScene& operator=(const CheckedScene&) = delete;
  ~CheckedScene() = default;

  [[nodiscard]] const scene::Scene* scene() const { return scene_; }  // null: not valid

 private:
  std::vector<std::uint64_t> aligned_;
  const scene::Scene* scene_ = nullptr;
};

}  // namespace thimble::host
