// The volumes of a scene: their poses and their state. Called by the renderer only, in scenes that have
// volumes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/bodies/collide.h"
#include "control/fields/volume.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "control/work.h"

namespace thimble::control {

// The state of a needle or a finger in tissue, for the viewer.
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

class Bodies;  // control/bodies/bodies.h

class Fields {
 public:
  // With Binding::kKeepPlaces a volume of the kind and the pose of one in the last scene keeps its state: a needle stays in its hole, a finger
  // presses on. With a tip of another radius all begin anew.
  [[gnu::cold]] void bind(const SceneView& scene, Binding binding) noexcept;
  [[gnu::cold]] void apply_materials(const SceneView& scene) noexcept;  // Binding::kKeepState

  // Resets every volume to its initial state.
  void reset() noexcept;
  void reset(std::size_t arm) noexcept;  // what the volumes keep of one arm's tip

  // Adds the forces of the volumes on the tip of `arm` to `touch`. In contact with a surface the god object
  // is unchanged; otherwise it is the proxy of the first volume that pushes.
  void tick(std::size_t arm, const Tip& tip, float period_s, Touch& touch) noexcept;

  // The forces of soft tissue on the bodies that lie on it or sink into it, for the step that the bodies do next. While they stand still
  // (Bodies::wait) each call goes on where the work of the last one ended. True: all forces are known.
  [[nodiscard]] bool press(const World& world, float period_s, Bodies& bodies, Work& work) noexcept;

  // Writes the state of every needle track and every tissue for each arm; returns how many there are.
  std::size_t show(TissueViews& views) const noexcept;

  // From the next tick on: a force field of another trial ends, those of this one begin.
  void set_trial(std::uint8_t trial) noexcept { trial_ = trial; }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }

 private:
  struct Placed {
    const VolumeOps* ops = nullptr;
    const scene::Object* source = nullptr;  // in the image
    std::uint8_t object = 0;                // its place there
    std::uint8_t state = 0;                 // its place in state_
    std::uint8_t trial = 0;                 // in which it acts; 0: in all
    Material material;
    Mat3 rotation = Mat3::Identity();  // object to world
    Vec3 position_m = Vec3::Zero();
    VolumeBounds bounds;
    Vec3 to_tip_m =
        Vec3::Zero();  // from the place of the tip that the volume acts on to the tip, in the object's frame
  };
  struct State {
    std::uint32_t of = 0;  // which volume: which_of() in fields.cpp; 0: none
    SharedState shared;
    std::array<ArmState, kMaxArms> arms;
    [[gnu::cold, gnu::noinline]] void reset() noexcept;
  };

  // How far press() is.
  struct Press {
    std::size_t volume = 0;
    std::size_t object = 0;  // in the world
    bool begun = false;
    std::size_t piece = 0;
    std::size_t corner = 0;
    Manifold manifold;
  };

  [[gnu::cold]] void find_states(float tip_radius_m) noexcept;
  [[nodiscard]] bool press_next(const Placed& placed, const PlacedObject& plane, const PlacedObject& body,
                                float period_s, Bodies& bodies, Work& work) noexcept;
  static void push_body(const Placed& placed, const Manifold& manifold, const PlacedObject& body,
                        float period_s, Bodies& bodies) noexcept;

  std::array<Placed, kMaxVolumes> placed_;
  std::array<State, kMaxVolumes> state_;
  Press press_;
  std::uint8_t count_ = 0;
  std::uint8_t trial_ = 0;
};

}  // namespace thimble::control
