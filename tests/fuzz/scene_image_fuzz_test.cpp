// Hostile scene images: SceneView::check reads nothing outside the given bytes (the tests also run under
// ASan, and every mutant is in a heap block of exactly its size), and accepted images can be rendered with
// finite forces in bounded time. THIMBLE_FUZZ_MUTANTS and THIMBLE_FUZZ_SEED set the number of mutants and the
// seed.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "control/scene/limits.h"
#include "control/scene/mesh_triangle.h"
#include "control/scene/scene_view.h"
#include "tests/fuzz/image.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using control::ImageStatus;
using control::SceneView;

constexpr double kShapeMutants = kUnderSanitizers ? 2'000 : 40'000;
constexpr double kMostSeconds =
    5.0;  // for 1000 ticks of a mutant: far above any honest scene, far below for ever

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}

// Every shape, a faceted and a shaded mesh, an open sheet.
const Bytes& shapes_image() {
  static const Bytes bytes = [] {
    const Material m = {.damping_N_s_m = 2.0F, .static_friction = 0.6F, .dynamic_friction = 0.4F};
    const auto at = [](double x, double y) {
      return Pose{{x, y, 0.0}, Eigen::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized()};
    };
    return SceneBuilder()
        .plane(Eigen::Vector3d::UnitZ(), -0.03, m)
        .sphere(0.02, m, at(0.04, 0.04))
        .box({0.03, 0.02, 0.01}, m, at(-0.04, 0.04))
        .cylinder(0.01, 0.01, m, at(-0.04, -0.04))
        .capsule(0.01, 0.01, m, at(0.04, -0.04))
        .mesh(torus(0.02, 0.008, 10, 6), m)
        .mesh(icosphere(1, 0.015), m, {host::MeshSide::kOutside, 60.0}, at(0.0, 0.05))
        .mesh(sheet(0.03, 3), m, {}, at(0.0, -0.05))
        .cone(0.01, 0.02, m, at(0.06, 0.0))
        .bytes();
  }();
  return bytes;
}

class Verdicts {
 public:
  // Checks the bytes and, when they are accepted, renders 1000 ticks.
  ImageStatus judge(const Bytes& bytes, Random& random) {
    SceneView view;
    const ImageStatus status = SceneView::check(bytes, view);
    ++count_[control::name(status)];
    if (status == ImageStatus::kOk) {
      render(view, random);
    } else {
      EXPECT_EQ(view.scene(), nullptr) << "a refused image must leave the view untouched";
    }
    return status;
  }

  void report(const std::string& what) const {
    const std::string prefix = what + ": ";
    for (const auto& [name, count] : count_) figure(prefix + name, count, "");
    figure(what + ": accepted mutants with a force that is not finite", not_finite_, "0");
    figure(what + ": longest 1000 ticks, s", longest_s_, "1");
    EXPECT_EQ(not_finite_, 0);
    EXPECT_LT(longest_s_, kMostSeconds);
  }

 private:
  void render(const SceneView& view, Random& random) {
    static control::Renderer renderer;
    renderer.bind(view);
    const auto start = std::chrono::steady_clock::now();
    Eigen::Vector3d p(0.0, 0.0, 0.05);
    for (int tick = 0; tick < 1000; ++tick) {
      const Eigen::Vector3d target = 0.06 * random.direction();
      const double step_m = random.below(4) == 0 ? 5e-3 : 2e-4;
      p += step_m * (target - p).normalized();
      control::Tip tip;
      tip.position_m = p.cast<float>();
      control::Touch touch;
      renderer.tick(std::span(&tip, 1), 2.5e-4F, std::span(&touch, 1));
      if (!touch.force_N.allFinite() || !touch.god_object_m.allFinite() || touch.contacts > 3) {
        ++not_finite_;
        break;
      }
    }
    longest_s_ =
        std::max(longest_s_, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }

  std::map<std::string, int> count_;
  int not_finite_ = 0;
  double longest_s_ = 0;
};

TEST(SceneImage, TheSeedIsSound) {
  Random random(1);
  Verdicts verdicts;
  EXPECT_EQ(verdicts.judge(shapes_image(), random), ImageStatus::kOk);
  verdicts.report("seed image of " + std::to_string(shapes_image().size()) + " bytes");
}

TEST(SceneImage, TruncatedAtEveryByte) {
  Random random(2);
  Verdicts verdicts;
  for (std::size_t size = 0; size < shapes_image().size(); ++size) {
    const Bytes part(shapes_image().begin(), shapes_image().begin() + static_cast<std::ptrdiff_t>(size));
    const ImageStatus status = verdicts.judge(part, random);
    // The first thing written, an object's name, ends the image: without it or with less nothing is sound.
    if (size + 16 < shapes_image().size()) {
      ASSERT_NE(status, ImageStatus::kOk) << size << " of " << shapes_image().size();
    }
  }
  verdicts.report("truncated");
}

TEST(SceneImage, WithTheWiderTrianglesOfBeforeItIsRefused) {
  SceneView view;
  EXPECT_EQ(SceneView::check(
                changed(shapes_image(), shapes_image().data() + 4, std::array{'T', 'H', 'I', 'M'}), view),
            ImageStatus::kNotAScene);
}

TEST(SceneImage, Misaligned) {
  Bytes shifted(shapes_image().size() + 8);
  for (std::size_t shift = 1; shift < 8; ++shift) {
    std::memcpy(shifted.data() + shift, shapes_image().data(), shapes_image().size());
    SceneView view;
    EXPECT_EQ(SceneView::check(std::span(shifted).subspan(shift, shapes_image().size()), view),
              ImageStatus::kMisaligned);
  }
}

TEST(SceneImage, BitsFlippedAtRandom) {
  Random random(static_cast<std::uint64_t>(from_environment("THIMBLE_FUZZ_SEED", 3.0)));
  Verdicts verdicts;
  const auto mutants = static_cast<int>(from_environment("THIMBLE_FUZZ_MUTANTS", kShapeMutants));
  for (int mutant = 0; mutant < mutants; ++mutant) {
    Bytes bytes = shapes_image();
    const auto flips = 1 + random.below(8);
    for (std::uint64_t flip = 0; flip < flips; ++flip) {
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1U << random.below(8));
    }
    verdicts.judge(bytes, random);
  }
  verdicts.report("bits flipped, " + std::to_string(mutants) + " mutants");
}

TEST(SceneImage, BytesReplacedAtRandom) {
  Random random(static_cast<std::uint64_t>(from_environment("THIMBLE_FUZZ_SEED", 4.0)));
  Verdicts verdicts;
  const auto mutants = static_cast<int>(from_environment("THIMBLE_FUZZ_MUTANTS", kShapeMutants));
  constexpr std::uint32_t kWords[] = {0,          1,          0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7F800000,
                                      0x7FC00000, 0xFF800000, 0x3F800000, 4,          8};
  for (int mutant = 0; mutant < mutants; ++mutant) {
    Bytes bytes = shapes_image();
    const auto words = 1 + random.below(3);
    for (std::uint64_t word = 0; word < words; ++word) {
      const std::uint32_t value = random.below(4) == 0 ? static_cast<std::uint32_t>(random.bits())
                                                       : kWords[random.below(std::size(kWords))];
      std::memcpy(bytes.data() + 4 * random.below(bytes.size() / 4), &value, 4);
    }
    verdicts.judge(bytes, random);
  }
  verdicts.report("words replaced, " + std::to_string(mutants) + " mutants");
}

// The same layout with one field changed. `field` points into the image that is being changed.
template <typename Value>
Bytes shape_with(const std::function<const void*(const scene::Scene&)>& field, Value value) {
  return changed(shapes_image(), field(*scene::GetScene(shapes_image().data())), value);
}

const scene::Object& object(const scene::Scene& scene, unsigned index) {
  return *scene.objects()->Get(index);
}
constexpr unsigned kSphere = 1;
constexpr unsigned kBox = 2;
constexpr unsigned kMesh = 5;
constexpr unsigned kShadedMesh = 6;
const scene::Mesh& mesh(const scene::Scene& scene, unsigned index = kMesh) {
  return *object(scene, index).shape_as_Mesh();
}

TEST(SceneImage, EachFieldOutOfItsRangeIsRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  struct Case {
    std::string what;
    Bytes bytes;
    ImageStatus expected;
  };
  const auto vertex = [](const scene::Scene& s) -> const void* { return mesh(s).vertices()->Get(7); };
  const auto corner = [](const scene::Scene& s) -> const void* { return mesh(s).triangles()->Get(3); };
  const auto triangle_with = [](std::uint32_t first, std::uint32_t beyond) {
    return control::pack_triangle({first, 2, 3}, {beyond, control::kNoEdge, control::kNoEdge});
  };
  const auto child = [](const scene::Scene& s) -> const void* { return part(mesh(s).nodes()->Get(0), 24); };
  const auto last_child = [](const scene::Scene& s) -> const void* {
    return part(mesh(s).nodes()->Get(mesh(s).nodes()->size() - 1), 28);
  };
  const auto quaternion = [](const scene::Scene& s) -> const void* {
    return part(object(s, kBox).pose(), 12);
  };
  const auto position = [](const scene::Scene& s) -> const void* { return object(s, kBox).pose(); };
  const auto material_field = [](std::size_t offset) {
    return [offset](const scene::Scene& s) -> const void* {
      return part(object(s, kSphere).material(), offset);
    };
  };
  const auto radius = [](const scene::Scene& s) -> const void* {
    return object(s, kSphere).shape_as_Sphere();
  };
  const auto half = [](const scene::Scene& s) -> const void* { return object(s, kBox).shape_as_Box(); };
  const auto normal = [](const scene::Scene& s) -> const void* { return object(s, 0).shape_as_Plane(); };
  const std::vector<Case> cases = {
      {"vertex not a number", shape_with(vertex, nan), ImageStatus::kBadNumber},
      {"vertex infinite", shape_with(vertex, infinite), ImageStatus::kBadNumber},
      {"vertex 11 m away", shape_with(vertex, 11.0F), ImageStatus::kBadNumber},
      {"corner that does not exist", shape_with(corner, triangle_with(0xFFFFFU, 0)), ImageStatus::kBadIndex},
      {"corner twice", shape_with(corner, triangle_with(2, 0)), ImageStatus::kBadIndex},
      {"neighbour that does not exist", shape_with(corner, triangle_with(1, 0x3FFFFEU)),
       ImageStatus::kBadIndex},
      {"its own neighbour", shape_with(corner, triangle_with(1, 3 * 3 + 1)), ImageStatus::kBadIndex},
      {"neighbour without this edge", shape_with(corner, triangle_with(1, 3 * 200)), ImageStatus::kBadIndex},
      {"root its own child", shape_with(child, 0U), ImageStatus::kBadTree},
      {"child that does not exist", shape_with(child, 0x00FFFFFFU), ImageStatus::kBadTree},
      {"leaf out of range", shape_with(child, 0x80000000U | (0x00FFFFFFU << 3U)), ImageStatus::kBadTree},
      {"last node points back", shape_with(last_child, 0U), ImageStatus::kBadTree},
      {"rotation zero", shape_with(quaternion, std::array<float, 4>{}), ImageStatus::kBadNumber},
      {"rotation of length 2", shape_with(quaternion, std::array<float, 4>{2.0F, 0.0F, 0.0F, 0.0F}),
       ImageStatus::kBadNumber},
      {"rotation not a number", shape_with(quaternion, nan), ImageStatus::kBadNumber},
      {"position infinite", shape_with(position, infinite), ImageStatus::kBadNumber},
      {"position 11 m", shape_with(position, -11.0F), ImageStatus::kBadNumber},
      {"stiffness negative", shape_with(material_field(0), -1.0F), ImageStatus::kBadNumber},
      {"stiffness not a number", shape_with(material_field(0), nan), ImageStatus::kBadNumber},
      {"stiffness over its limit", shape_with(material_field(0), 2.0F * control::kMaxStiffness_N_m),
       ImageStatus::kBadNumber},
      {"damping negative", shape_with(material_field(4), -1.0F), ImageStatus::kBadNumber},
      {"damping over its limit", shape_with(material_field(4), 2.0F * control::kMaxDamping_N_s_m),
       ImageStatus::kBadNumber},
      {"static friction negative", shape_with(material_field(8), -0.1F), ImageStatus::kBadNumber},
      {"dynamic friction infinite", shape_with(material_field(12), infinite), ImageStatus::kBadNumber},
      {"dynamic over static friction", shape_with(material_field(12), 0.7F), ImageStatus::kBadNumber},
      {"friction mode 7", shape_with(material_field(16), std::uint8_t{7}), ImageStatus::kBadNumber},
      {"radius negative", shape_with(radius, -0.01F), ImageStatus::kBadNumber},
      {"radius zero", shape_with(radius, 0.0F), ImageStatus::kBadNumber},
      {"radius not a number", shape_with(radius, nan), ImageStatus::kBadNumber},
      {"half size negative", shape_with(half, -0.01F), ImageStatus::kBadNumber},
      {"plane's normal of length 3", shape_with(normal, std::array<float, 3>{0.0F, 0.0F, 3.0F}),
       ImageStatus::kBadNumber}};
  int wrong = 0;
  for (const Case& test : cases) {
    SceneView view;
    const ImageStatus status = SceneView::check(test.bytes, view);
    EXPECT_EQ(status, test.expected) << test.what << ": " << control::name(status) << ", not "
                                     << control::name(test.expected);
    if (status != test.expected) ++wrong;
  }
  figure("fields out of range not refused by name, of " + std::to_string(cases.size()), wrong, "0");
}

// Fields that stay in range but lie: wrong neighbours, boxes, flags, normals, pseudonormals, vertices. They
// may be accepted; the tick must live with them.
TEST(SceneImage, LiesInRangeAreLivedWith) {
  Random random(static_cast<std::uint64_t>(from_environment("THIMBLE_FUZZ_SEED", 5.0)));
  Verdicts verdicts;
  const auto mutants = static_cast<int>(from_environment("THIMBLE_FUZZ_MUTANTS", kShapeMutants / 4));
  for (int mutant = 0; mutant < mutants; ++mutant) {
    Bytes bytes = shapes_image();
    const scene::Scene& scene = *scene::GetScene(bytes.data());
    const auto write = [&](const void* place, auto value) {
      std::memcpy(bytes.data() + (static_cast<const std::byte*>(place) - bytes.data()), &value,
                  sizeof(value));
    };
    const auto lies = 1 + random.below(40);
    // The check follows neighbours there and back, so most lies about them are refused.
    const std::uint64_t first_kind = random.below(4) == 0 ? 0 : 2;
    for (std::uint64_t lie = 0; lie < lies; ++lie) {
      const scene::Mesh& m = mesh(scene, random.below(2) == 0 ? kMesh : kShadedMesh);
      const auto triangle = static_cast<unsigned>(random.below(m.triangles()->size()));
      const auto node = static_cast<unsigned>(random.below(m.nodes()->size()));
      const auto vertex = static_cast<unsigned>(random.below(m.vertices()->size()));
      const auto some_float = [&] { return static_cast<float>(random.uniform(-0.05, 0.05)); };
      switch (first_kind + random.below(7 - first_kind)) {
        case 0:
        case 1: {
          std::array<std::uint32_t, 3> vertices{};
          std::array<std::uint32_t, 3> beyond{};
          for (std::uint32_t i = 0; i < 3; ++i) {
            vertices[i] = control::vertex_of(*m.triangles()->Get(triangle), i);
            beyond[i] = control::edge_beyond(*m.triangles()->Get(triangle), i);
          }
          if (random.below(2) == 0)
            vertices[random.below(3)] = static_cast<std::uint32_t>(random.below(m.vertices()->size()));
          else
            beyond[random.below(3)] = static_cast<std::uint32_t>(random.below(3 * m.triangles()->size()));
          write(m.triangles()->Get(triangle), control::pack_triangle(vertices, beyond));
          break;
        }
        case 2:
          write(part(m.nodes()->Get(node), 2 * random.below(12)), static_cast<std::uint16_t>(random.bits()));
          break;
        case 3:
          write(m.flags()->Data() + triangle, static_cast<std::uint8_t>(random.below(4)));
          break;
        case 4:
          if (m.corner_normals() != nullptr) {
            write(m.corner_normals()->Data() + 4 * random.below(m.corner_normals()->size()),
                  static_cast<std::uint32_t>(random.bits()));
          }
          break;
        case 5:
          write(part(m.vertices()->Get(vertex), 4 * random.below(3)), some_float());
          break;
        default:
          write(part(m.vertices()->Get(vertex), 12), static_cast<std::uint32_t>(random.bits()));
      }
    }
    verdicts.judge(bytes, random);
  }
  verdicts.report("lies in range, " + std::to_string(mutants) + " mutants");
}

}  // namespace
}  // namespace thimble::test
