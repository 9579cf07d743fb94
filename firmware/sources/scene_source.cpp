#include "firmware/sources/scene_source.h"

#include <array>
#include <span>

namespace thimble::firmware {

bool SceneSource::post(const control::SceneView& view, std::uint32_t sequence,
                       control::Binding binding) noexcept {
  Posted* posted = posted_.blank();
  if (posted == nullptr) return false;
  *posted = {view, sequence, binding};
  posted_.send();
  return true;
}

void SceneSource::take() noexcept {
  if (const Posted* posted = posted_.letter()) renderer_.bind(posted->view, posted->binding);
  adopt();
}

void SceneSource::adopt() noexcept {
  const Posted* posted = posted_.letter();
  if (posted == nullptr) return;
  view_ = posted->view;
  sequence_ = posted->sequence;
  posted_.done();
}

void SceneSource::forces(const SourceTick& tick, SourceForces& out) noexcept {
  std::array<control::Tip, kMaxArms> tips;
  const std::size_t count = tick.arms.size();
  for (std::size_t i = 0; i < count; ++i)
    tips[i] = {tick.arms[i].posture.tip_m, tick.arms[i].tip_velocity_m_s};
  renderer_.tick(std::span(tips).first(count), tick.setup.period_s, out.arms);
}

}  // namespace thimble::firmware
