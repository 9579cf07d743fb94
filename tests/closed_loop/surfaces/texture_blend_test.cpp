// Textures on curved and meshed solids go on over the whole surface: the force changes with the motion, and a height is one
// potential. Judged by slow strokes, by finite differences and by closed paths.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>

#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/mesh_file.h"
#include "tests/closed_loop/surfaces/rig.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace blended {
namespace {

constexpr double kStiffness_N_m = 1000.0;
constexpr double kRadius_m = 0.02;
constexpr double kHeight_m = 0.0002;
// Of cos cos in tiles of 4 mm: slope and its change.
constexpr double kWave_per_m = 2.0 * std::numbers::pi / 0.004;
constexpr double kSlope = 0.5 * kHeight_m * kWave_per_m;
constexpr double kBend_per_m = kSlope * kWave_per_m;

std::string material(const std::string& kind, double friction, const std::string& more = {}) {
  std::string text = "\"stiffness_N_m\": 1000";
  if (friction > 0)  // steady: a slip would change the force at once
    text += ", \"static_friction\": " + std::to_string(friction) + R"(, "friction_mode": "steady")";
  if (kind.empty()) return text;
  return text + R"(, "texture": {"kind": ")" + kind +
         R"(", "tile_m": [0.004, 0.004], "height_m": 0.0002, "pattern": "cos_cos")" + more + "}";
}

// A body around the origin that every ray from the middle leaves once: `at` is the surface's point in a direction.
struct Subject {
  std::string name;
  std::string shape;
  std::function<Vector3d(const Vector3d&)> at;
  bool faceted = false;
  double most = 2.0;  // change of force over travel, over K, beyond twice that of the bare body
};

// Of a corner of a triangle, with the triangle's middle.
using Coordinates = std::function<Eigen::Vector2d(const Vector3d&, const Vector3d&)>;

void write_obj(const TemporaryFolder& folder, const std::string& name, const host::TriangleSoup& soup,
               const Coordinates& coordinates = {}) {
  std::ostringstream text;
  text.precision(9);
  for (const Vector3d& p : soup.vertices_m) text << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  int corners = 0;
  for (const auto& t : soup.triangles) {
    std::string face = "f";
    const Vector3d middle = (soup.vertices_m[t[0]] + soup.vertices_m[t[1]] + soup.vertices_m[t[2]]) / 3.0;
    for (const std::uint32_t v : t) {
      face += ' ' + std::to_string(v + 1);
      if (!coordinates) continue;
      const Eigen::Vector2d uv = coordinates(soup.vertices_m[v], middle);
      text << "vt " << uv.x() << ' ' << uv.y() << '\n';
      face += '/' + std::to_string(++corners);
    }
    text << face << '\n';
  }
  folder.write(name, text.str());
}

std::string mesh_shape(const std::string& file, int crease_deg) {
  return R"("mesh": {"file": ")" + file + '"' +
         (crease_deg > 0 ? ", \"crease_deg\": " + std::to_string(crease_deg) : "") + "}";
}

Vector3d on_ball(const Vector3d& way) { return kRadius_m * way; }

Vector3d on_capsule(const Vector3d& way) {  // radius 10 mm, 20 mm between the caps' centres
  const double across = way.head<2>().norm();
  const double side = 0.01 / std::max(across, 1e-9);
  if (std::abs(side * way.z()) <= 0.01) return side * way;
  const double along = 0.01 * std::abs(way.z());
  return 2.0 * along * way;
}

Vector3d on_cylinder(const Vector3d& way) {  // radius 15 mm, height 30 mm
  return std::min(0.015 / std::max(way.head<2>().norm(), 1e-9), 0.015 / std::max(std::abs(way.z()), 1e-9)) *
         way;
}

Vector3d on_cone(const Vector3d& way) {  // radius 15 mm, height 30 mm: base at -7.5 mm, apex at 22.5 mm
  const double side = 0.0225 / (way.z() + 2.0 * way.head<2>().norm());
  const double base = way.z() < 0.0 ? -0.0075 / way.z() : 1.0;
  return (side > 0.0 ? std::min(side, base) : base) * way;
}

std::vector<Subject> primitives() {
  return {{"sphere", R"("sphere": {"radius_m": 0.02})", on_ball},
          {"capsule", R"("capsule": {"radius_m": 0.01, "height_m": 0.02})", on_capsule},
          {"cylinder", R"("cylinder": {"radius_m": 0.015, "height_m": 0.03})", on_cylinder},
          {"cone", R"("cone": {"radius_m": 0.015, "height_m": 0.03})", on_cone}};
}

std::vector<Subject> balls(const TemporaryFolder& folder) {
  write_obj(folder, "ball.obj", icosphere(2, kRadius_m));
  write_obj(folder, "fine.obj", icosphere(3, kRadius_m));
  // Coordinates that go on everywhere; of two halves that end at a seam; and of a globe, that go on by whole units.
  write_obj(folder, "wrapped.obj", icosphere(3, kRadius_m), [](const Vector3d& p, const Vector3d&) {
    return Eigen::Vector2d(20.0 * p.x() + 8.0 * p.z(), 20.0 * p.y() - 6.0 * p.z());
  });
  write_obj(folder, "halves.obj", icosphere(3, kRadius_m), [](const Vector3d& p, const Vector3d& middle) {
    return middle.z() > 0 ? Eigen::Vector2d(20.0 * p.x() + 1.0, 20.0 * p.y() + 1.0)
                          : Eigen::Vector2d(20.0 * p.y() - 1.1, 25.0 * p.x());
  });
  write_obj(folder, "globe.obj", uv_sphere(48, 24, kRadius_m), [](const Vector3d& p, const Vector3d& middle) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const double middle_u = std::atan2(middle.y(), middle.x()) / kTurn;
    const bool pole = p.head<2>().norm() < 1e-6;
    const double u = pole ? middle_u : std::atan2(p.y(), p.x()) / kTurn;
    return Eigen::Vector2d(u - std::round(u - middle_u), std::acos(p.z() / p.norm()) / kTurn * 2.0);
  });
  return {{"shaded ball", mesh_shape("ball.obj", 180), on_ball},
          {"faceted ball", mesh_shape("ball.obj", 0), on_ball, true},
          {"fine ball, shaded", mesh_shape("fine.obj", 60), on_ball},
          {"ball with coordinates, shaded", mesh_shape("wrapped.obj", 180), on_ball},
          {"halves", mesh_shape("halves.obj", 180), on_ball},
          {"globe", mesh_shape("globe.obj", 180), on_ball, false, 4.0},
          {"ball with coordinates, faceted", mesh_shape("wrapped.obj", 0), on_ball, true}};
}

// A path of the tip: from outside to place 0, then on by millimetres along the surface, below it.
using Path = std::function<Vector3d(double along_m)>;

Path arc(const Subject& subject, Random& random) {
  const Vector3d from = random.direction();
  const Vector3d side = from.cross(random.direction()).normalized();
  const double depth_m = random.uniform(0.0003, 0.001);
  return [=, at = subject.at](double along_m) {
    const double angle = along_m / kRadius_m;
    const Vector3d surface = at(std::cos(angle) * from + std::sin(angle) * side);
    return Vector3d(surface * (1.0 - depth_m / surface.norm()));
  };
}

// What the force does over its change of place, in steps of 2 um.
struct Strokes {
  double most = 0;  // change over travel, over K
  double most_over =
      0;          // of that, beyond twice what the body does without a texture in one of two ticks, and what
                  // the god object's own jumps do
  int ticks = 0;  // that were judged

  // Ticks in which the tip is deeper than most_depth_m are not judged: what a texture adds grows with depth.
  void run(IdealRun& textured, IdealRun& bare, IdealRun& slippery, const Path& path, const Vector3d& start,
           double length_m, double most_depth_m = 0.002) {
    for (IdealRun* each : {&textured, &bare, &slippery}) {
      each->restart(start);
      each->move(path(0), 2e-5);
    }
    double last_bare_N = 0;
    constexpr double kStep_m = 2e-6;
    for (double along_m = kStep_m; along_m < length_m; along_m += kStep_m) {
      const Felt was = textured.felt();
      const Felt was_bare = bare.felt();
      const Felt was_slippery = slippery.felt();
      const Vector3d tip = path(along_m);
      const double change_N = (textured.step(tip).force_N - was.force_N).norm();
      const double bare_N =
          std::max({(bare.step(tip).force_N - was_bare.force_N).norm(),
                    (slippery.step(tip).force_N - was_slippery.force_N).norm(),
                    kStiffness_N_m * (textured.felt().god_object_m - was.god_object_m).norm()});
      const double travel_m = (textured.felt().tip_m - was.tip_m).norm();
      const double without_N = std::max(bare_N, last_bare_N);
      last_bare_N = bare_N;
      if ((was.god_object_m - was.tip_m).norm() > most_depth_m) continue;
      ++ticks;
      most = std::max(most, change_N / travel_m / kStiffness_N_m);
      most_over = std::max(most_over, (change_N - 2.0 * without_N) / travel_m / kStiffness_N_m);
    }
  }
};

constexpr int kArcs = kUnderSanitizers ? 1 : 2;

// On a faceted mesh the energy account takes back what the force lost or won at once where the god object went to another facet.
constexpr double kFaceted = 6.0;

// All kinds, with friction and without, over paths of one body.
void strokes_change_with_the_motion(const std::string& name, const std::string& shape, double most_over,
                                    const std::filesystem::path& folder,
                                    const std::function<Path(Random&)>& paths, double most_depth_m = 0.002) {
  Random random(name.size());
  Strokes all;
  for (const char* kind : {"height", "normal", "lateral"}) {
    for (const double friction : {0.0, 0.4}) {
      IdealRun textured(surface_scene(material(kind, friction), shape, folder));
      IdealRun bare(surface_scene(material("", friction), shape, folder));
      IdealRun slippery(surface_scene(material("", 0), shape, folder));
      for (int i = 0; i < kArcs; ++i) {
        const Path path = paths(random);
        all.run(textured, bare, slippery, path, path(-1.0), 0.008, most_depth_m);
      }
    }
  }
  figure(name + ": force's change over travel, over K, beyond twice that of the bare body", all.most_over,
         std::to_string(most_over) + "; " + std::to_string(all.most) + " in all");
  EXPECT_LT(all.most_over, most_over) << name;
  EXPECT_GT(all.ticks, 5000) << name;
}

TEST(BlendedTexture, TheForceChangesWithTheMotion) {
  const TemporaryFolder folder;
  std::vector<Subject> subjects = primitives();
  for (const Subject& subject : balls(folder)) subjects.push_back(subject);
  for (const Subject& subject : subjects) {
    strokes_change_with_the_motion(subject.name, subject.shape, subject.faceted ? kFaceted : subject.most,
                                   folder.path(), [&](Random& random) {
                                     const Path path = arc(subject, random);
                                     return [path](double along_m) {
                                       return along_m < 0 ? Vector3d(1.3 * path(0)) : path(along_m);
                                     };
                                   });
  }
}

TEST(BlendedTexture, TheForceChangesWithTheMotionOverTorusAndHills) {
  const TemporaryFolder folder;
  constexpr double kRing_m = 0.02;
  constexpr double kTube_m = 0.008;
  write_obj(folder, "torus.obj", torus(kRing_m, kTube_m, 40, 20));
  const auto on_torus = [](Random& random) -> Path {
    const double around = random.uniform(0, 6.28);
    const double across = random.uniform(0, 6.28);
    const double way = random.uniform(0, 6.28);
    const double depth_m = random.uniform(0.0003, 0.001);
    return [=](double along_m) {
      const double s = std::max(along_m, 0.0);
      const double a = around + std::cos(way) * s / kRing_m;
      const double b = across + std::sin(way) * s / kTube_m;
      const double tube_m = along_m < 0 ? 1.3 * kTube_m : kTube_m - depth_m;
      const double out_m = kRing_m + tube_m * std::cos(b);
      return Vector3d(out_m * std::cos(a), out_m * std::sin(a), tube_m * std::sin(b));
    };
  };
  strokes_change_with_the_motion("shaded torus", mesh_shape("torus.obj", 180), 2.0, folder.path(), on_torus);
  strokes_change_with_the_motion("faceted torus", mesh_shape("torus.obj", 0), kFaceted, folder.path(),
                                 on_torus);
  // Hills of 2 mm with slopes of up to 40 degrees, an open sheet.
  const auto height = [](double x, double y) { return 0.002 * std::sin(400 * x) * std::cos(350 * y); };
  host::TriangleSoup hills = sheet(0.05, 60);
  for (Vector3d& p : hills.vertices_m) p.z() = height(p.x(), p.y());
  write_obj(folder, "hills.obj", hills);
  const auto on_hills = [&](Random& random) -> Path {
    const Vector3d from = random.in_box({0.01, 0.01, 0});
    const Vector3d way = Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0).normalized();
    const double depth_m = random.uniform(0.0003, 0.0008);
    return [=](double along_m) {
      const Vector3d p = from + std::max(along_m, 0.0) * way;
      return Vector3d(p.x(), p.y(), along_m < 0 ? 0.004 : height(p.x(), p.y()) - depth_m);
    };
  };
  strokes_change_with_the_motion("shaded hills", mesh_shape("hills.obj", 180), 2.0, folder.path(), on_hills);
  strokes_change_with_the_motion("faceted hills", mesh_shape("hills.obj", 0), kFaceted, folder.path(),
                                 on_hills);
}

// Straight through models of other people that have coordinates.
TEST(BlendedTexture, TheForceChangesWithTheMotionOverModels) {
  for (const char* file : {"OBJ/spider.obj", "OBJ/WusonOBJ.obj"}) {
    const std::filesystem::path path = test_model_path(file);
    host::TriangleSoup soup = host::read_mesh_file(path, 1.0, file);
    ASSERT_FALSE(soup.vertices_uv.empty());
    double most = 0;
    for (const Vector3d& p : soup.vertices_m) most = std::max(most, p.cwiseAbs().maxCoeff());
    const double scale = 0.05 / most;
    const auto on_model = [&](Random& random) -> Path {
      const auto& t = soup.triangles[random.below(soup.triangles.size())];
      const Vector3d a = scale * soup.vertices_m[t[0]];
      const Vector3d b = scale * soup.vertices_m[t[1]];
      const Vector3d c = scale * soup.vertices_m[t[2]];
      const Vector3d normal = (b - a).cross(c - a).normalized();
      const Vector3d way = normal.cross(random.direction()).normalized();
      const double depth_m = random.uniform(0.0002, 0.0006);
      return [=](double along_m) {
        return Vector3d((a + b + c) / 3.0 + std::max(along_m, 0.0) * way -
                        (along_m < 0 ? -0.001 : depth_m) * normal);
      };
    };
    // Shaded, the vertex normals are far from those of the faces, and the shaded place jumps.
    for (const int crease_deg : {0, 180}) {
      strokes_change_with_the_motion(std::string(file) + (crease_deg > 0 ? ", shaded" : ""),
                                     R"("mesh": {"file": ")" + path.string() + R"(", "scale": )" +
                                         std::to_string(scale) + R"(, "crease_deg": )" +
                                         std::to_string(crease_deg) + "}",
                                     kFaceted, {}, on_model, 0.001);
    }
  }
}

// A textured ball that lies in a textured block: over the groove between them.
TEST(BlendedTexture, TheForceChangesWithTheMotionWhereTwoSolidsTouch) {
  for (const char* kind : {"height", "normal", "lateral"}) {
    for (const double friction : {0.0, 0.4}) {
      const auto scene = [&](const std::string& what, double rubs) {
        const auto object = [&](const std::string& name, const std::string& shape, const std::string& at) {
          return R"({"name": ")" + name + R"(", "shape": {)" + shape + R"(}, "pose": {"position_m": )" + at +
                 R"(}, "material": {)" + material(what, rubs) + "}}";
        };
        return SceneImage(
            host::compile_scene_text(
                R"({"thimble_scene": 1, "name": "two", "objects": [)" +
                    object("block", R"("box": {"size_m": [0.1, 0.1, 0.02]})", "[0, 0, -0.01]") + ", " +
                    object("ball", R"("sphere": {"radius_m": 0.02})", "[0.003, 0, 0.005]") + "]}",
                "two.scene.json", {})
                .image);
      };
      IdealRun textured(scene(kind, friction));
      IdealRun bare(scene("", friction));
      IdealRun slippery(scene("", 0));
      Random random(5);
      Strokes strokes;
      for (int i = 0; i < kArcs; ++i) {
        const double way = random.uniform(0, 6.28);
        const double depth_m = random.uniform(0.0003, 0.0008);
        const Path path = [=](double along_m) {  // towards the groove over the block, and up the ball
          const double out_m = 0.026 - along_m;
          const double up_m =
              out_m > 0.0198 ? 0.0 : 0.005 + std::sqrt(std::max(0.0004 - out_m * out_m, 0.0)) - 0.0078;
          return Vector3d(0.003 + out_m * std::cos(way), out_m * std::sin(way),
                          std::max(up_m, 0.0) - depth_m);
        };
        strokes.run(textured, bare, slippery, path, path(0) + Vector3d(0, 0, 0.002), 0.012);
      }
      figure(std::string("groove, ") + kind + (friction > 0 ? ", friction" : "") +
                 ": force's change over travel, over K, beyond twice that without texture",
             strokes.most_over, "2");
      EXPECT_LT(strokes.most_over, 2.0);
      EXPECT_GT(strokes.ticks, 5000);
    }
  }
}

// U = K p^2 / 2, where p = F . n / K is how far the tip is below the relief, and n the shape's normal: the gradient lies along
// the surface. F is -grad U by central differences. On a mesh all places are above one face.
TEST(BlendedTexture, AHeightsForceIsTheGradientOfItsPotential) {
  const TemporaryFolder folder;
  std::vector<Subject> subjects = primitives();
  for (const Subject& subject : balls(folder))
    if (subject.faceted) subjects.push_back(subject);
  for (const Subject& subject : subjects) {
    IdealRun run(surface_scene(material("height", 0), subject.shape, folder.path()));
    const SceneImage plain = surface_scene(material("", 0), subject.shape, folder.path());
    IdealRun bare(plain);
    Random random(7);
    double worst_N = 0;
    double most_N = 0;
    int places = 0;
    while (places < 2000) {
      const Vector3d at = subject.at(random.direction());
      const Vector3d p = at * (1.0 - random.uniform(0.0005, 0.001) / at.norm());
      constexpr double kStep_m = 2e-5;
      bool one_face = true;
      const auto press = [&](const Vector3d& tip, Vector3d& normal) {
        for (IdealRun* each : {&run, &bare}) {
          each->restart(1.3 * tip);
          each->step(tip);
        }
        const Vector3d n = bare.felt().force_N.normalized();
        if (normal.isZero()) normal = n;
        if (subject.faceted) one_face = one_face && n.dot(normal) > 1 - 1e-6;
        const double pressed_m = run.felt().force_N.dot(n) / kStiffness_N_m;
        return 0.5 * kStiffness_N_m * pressed_m * pressed_m;
      };
      Vector3d normal = Vector3d::Zero();
      const double middle_J = press(p, normal);
      const Vector3d force_N = run.felt().force_N;
      if (middle_J == 0) continue;
      Vector3d expected_N;
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d step = kStep_m * Vector3d::Unit(axis);
        expected_N[axis] = (press(p - step, normal) - press(p + step, normal)) / (2.0 * kStep_m);
      }
      // At an edge of the shape, and at the axis of a cone, it is pressed by another part of the surface.
      const double across = p.head<2>().norm();
      const bool at_edge = (subject.name == "cylinder" && across > 0.013 && std::abs(p.z()) > 0.013) ||
                           (subject.name == "cone" && (p.z() < -0.004 || across < 0.003));
      if (!one_face || at_edge) continue;
      ++places;
      most_N = std::max(most_N, force_N.norm());
      worst_N = std::max(worst_N, (force_N - expected_N).norm());
    }
    figure(subject.name + ": largest difference of a force from -grad U, N", worst_N,
           "0.01, of up to " + std::to_string(most_N));
    EXPECT_LT(worst_N, 0.01);
  }
}

// Random paths under the surface that end where they began.
TEST(BlendedTexture, ClosedPathsGiveNothing) {
  const TemporaryFolder folder;
  std::vector<Subject> subjects = primitives();
  for (const Subject& subject : balls(folder)) subjects.push_back(subject);
  for (const Subject& subject : subjects) {
    for (const char* kind : {"height", "normal", "lateral"}) {
      for (const double friction : {0.0, 0.4}) {
        const SceneImage image = surface_scene(material(kind, friction), subject.shape, folder.path());
        IdealRun run(image);
        Random random(3);
        constexpr double kStep_m = 1e-5;
        constexpr double kMost_m = 0.0015;
        double most = -1;
        for (int loop = 0; loop < 12; ++loop) {
          const Vector3d way = random.direction();
          const Vector3d start = subject.at(way) + 0.0005 * way;
          run.restart(start);
          Vector3d last = way;
          for (int leg = 0; leg < 4; ++leg) {
            last = (leg == 3 ? way : (way + random.in_box({0.25, 0.25, 0.25})).normalized());
            const Vector3d at = subject.at(last);
            run.move(at * (1.0 - random.uniform(0.0006, kMost_m) / at.norm()), kStep_m);
          }
          run.move(start, kStep_m);
          most = std::max(most, run.work_mean_force_J());
        }
        // Of a path in steps: what a force that grows by K over each step can give (docs/decisions.md).
        const double bound_J = kStiffness_N_m * kStep_m * kMost_m;
        figure(subject.name + ", " + kind + (friction > 0 ? ", friction" : "") +
                   ": most that a closed path gave, over K T v x",
               most / bound_J, "1");
        EXPECT_LT(most, bound_J);
      }
    }
  }
}

}  // namespace
}  // namespace blended
}  // namespace thimble::test
