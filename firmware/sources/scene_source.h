// The scene as a force source: the renderer of control/, and the scenes on their way to it from the background.
#pragma once

#include <cstdint>

#include "control/renderer.h"
#include "control/scene/scene_view.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/sources/force_source.h"

namespace thimble::firmware {

class SceneSource final : public ForceSource {
 public:
  // work_units: what rendering may do in a tick (control/work.h).
  explicit SceneSource(std::uint32_t work_units) noexcept : ForceSource({.name = "scene", .scene = true}) {
    renderer_.bound_work(work_units);
  }

  // --- background
  // The next scene (its bytes must stay until a later scene is the running one). False: the last one is still
  // waiting. binding: how it follows the last one.
  [[nodiscard]] bool post(const control::SceneView& view, std::uint32_t sequence,
                          control::Binding binding = control::Binding::kStart) noexcept;
  [[nodiscard]] bool pending() const noexcept {
    return posted_.sent();
  }  // the tick has not taken the last one yet

  // --- tick
  [[nodiscard]] bool wanted(const Params&) const noexcept override { return true; }
  void start(const SourceTick&) noexcept override { renderer_.reset(); }
  void forces(const SourceTick& tick, SourceForces& out) noexcept override;
  // Another source has led the arm to where it is: it is in contact with nothing, as at arming.
  void begin_at_tip(std::size_t arm) noexcept { renderer_.reset(arm); }

  [[nodiscard]] bool waiting() const noexcept { return posted_.letter() != nullptr; }  // for take()
  // What waits would make the force jump: it is more than other materials.
  [[nodiscard]] bool waits_to_fade() const noexcept {
    const Posted* posted = posted_.letter();
    return posted != nullptr && posted->binding != control::Binding::kKeepState;
  }
  void take() noexcept;   // what waits is the scene from now on
  void adopt() noexcept;  // the same, but nothing is bound: restart() follows
  void restart() noexcept {
    renderer_.bind(view_);
  }  // every contact, moving object and tissue as at the scene's start

  // Which force fields act, from this tick on.
  void set_trial(std::uint8_t trial) noexcept { renderer_.set_trial(trial); }

  [[nodiscard]] std::uint32_t sequence() const noexcept { return sequence_; }  // 0: there is no scene
  [[nodiscard]] const control::Renderer& renderer() const noexcept { return renderer_; }

 private:
  struct Posted {
    control::SceneView view;
    std::uint32_t sequence = 0;
    control::Binding binding = control::Binding::kStart;
  };

  Mailbox<Posted> posted_;
  control::Renderer renderer_;
  control::SceneView view_;
  std::uint32_t sequence_ = 0;
};

}  // namespace thimble::firmware
