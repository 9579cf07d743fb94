// The volumes of a scene, placed, and what the tips do to them. Called by the renderer only, in scenes that have some.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/fields/volume.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"

namespace thimble::control {

// A needle or a finger in tissue, as a picture shows it.
struct TissueView {
  std::uint8_t object = 0;  // in the scene
  std::uint8_t arm = 0;
  bool is_needle = false;
  bool inside = false;    // needle: below the skin; tissue: pressed now
  std::uint8_t torn = 0;  // needle: layers of its hole
  float x_m = 0.0F;       // the track, the middle of the dimple; in the object's frame
  float y_m = 0.0F;
  float depth_m = 0.0F;  // of the needle's tip, of the dimple
};
using TissueViews = std::array<TissueView, kMaxVolumes * kMaxArms>;

class Fields {
 public:
  void bind(const SceneView& scene) noexcept;
  void go_on(const SceneView& scene) noexcept;  // Binding::kGoOn

  // Every volume as it was at the start.
  void reset() noexcept;

  // Adds to `touch` what the volumes do to the tip of `arm` in this period. The god object stays where a surface holds it;
  // without one it is the first volume's proxy.
  void tick(std::size_t arm, const Tip& tip, float period_s, Touch& touch) noexcept;

  // Writes what every arm has done to every needle's way and tissue; returns how many there are.
  std::size_t show(TissueViews& views) const noexcept;

  [[nodiscard]] std::size_t count() const noexcept { return count_; }

 private:
  struct Placed {
    const VolumeOps* ops = nullptr;
    const scene::Object* source = nullptr;  // in the image
    std::uint8_t object = 0;                // its place there
    Material material;
    Mat3 rotation = Mat3::Identity();  // object to world
    Vec3 position_m = Vec3::Zero();
    VolumeBounds bounds;
  };
  struct State {
    SharedState shared;
    std::array<ArmState, kMaxArms> arms;
  };

  std::array<Placed, kMaxVolumes> placed_;
  std::array<State, kMaxVolumes> state_;
  std::size_t count_ = 0;
};

}  // namespace thimble::control
