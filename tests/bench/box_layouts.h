// Boxes at rest, stacked and afloat: the scenes of bodies_bench and tick_instructions.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace thimble::test {

inline constexpr float kSide_m = 0.03F;
inline constexpr float kMass_kg = 0.1F;
inline constexpr float kFriction = 0.5F;

struct Layout {
  std::string name;
  bool gravity = true;
  std::vector<Eigen::Vector3f> at_m;
};

inline Layout towers(const std::string& name, int count, int high) {
  Layout layout;
  layout.name = name;
  for (int i = 0; i < count; ++i) {
    const int tower = i / high;
    layout.at_m.emplace_back(.05F * static_cast<float>(tower), 0.0F,
                             kSide_m * (.5F + static_cast<float>(i % high)));
  }
  return layout;
}

inline Layout afloat(int count) {
  Layout layout;
  layout.name = std::to_string(count) + "-afloat";
  layout.gravity = false;
  for (int i = 0; i < count; ++i) {
    const int row = i / 4;
    layout.at_m.emplace_back(.05F * static_cast<float>(i % 4), 0.0F, .1F + .05F * static_cast<float>(row));
  }
  return layout;
}

inline std::vector<Layout> box_layouts() {
  return {towers("3-at-rest", 3, 3), towers("16-at-rest", 16, 4), afloat(16), towers("stack-of-16", 16, 16)};
}

inline std::string box_scene(const Layout& layout) {
  const std::string material =
      R"("material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.5})";
  std::string text = R"({"thimble_scene": 1, "name": "bench", )";
  if (layout.gravity) text += R"("gravity_m_s2": [0, 0, -9.81], )";
  text += R"("objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, )" + material + "}";
  for (std::size_t i = 0; i < layout.at_m.size(); ++i) {
    const Eigen::Vector3f& p = layout.at_m[i];
    text += R"(, {"name": ")" + std::to_string(i) +
            R"(", "shape": {"box": {"size_m": [0.03, 0.03, 0.03]}}, "pose": {"position_m": [)" +
            std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z()) + "]}, " +
            material + R"(, "body": {"motion": "free", "mass_kg": 0.1}})";
  }
  return text + "]}";
}

}  // namespace thimble::test
