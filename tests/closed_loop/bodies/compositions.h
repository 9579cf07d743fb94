// Random compositions of bodies: solids and meshes of several convex pieces with unlike materials, on level or rough ground, and two
// fingertips that go through the midst of them.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {

struct Composition {
  std::string members;  // of the scene
  std::vector<std::function<double(const Vector3d&)>>
      outside_m;  // of each body: of a point in its frame; below 0 inside
  std::vector<double> mass_kg;
  bool level = false;  // the ground
  std::array<std::array<Vector3d, 4>, 2>
      paths;  // of the fingers: middle, and half the way in three directions

  [[nodiscard]] Vector3d tip_m(std::size_t finger, double time_s) const {
    const std::array<Vector3d, 4>& path = paths.at(finger);
    Vector3d p = path[0];
    for (std::size_t i = 1; i < path.size(); ++i) {
      const double turn = (2.1 + .7 * static_cast<double>(i)) * time_s + static_cast<double>(i * i);
      p += std::sin(turn) * path.at(i);
    }
    return p;
  }
};

class Compositions {
 public:
  // crossing: the bodies begin through each other. Else they begin one above the other.
  Composition compose(Random& random, std::size_t bodies, bool crossing) {
    Composition result;
    std::string text = R"("gravity_m_s2": [0, 0, -9.81], "materials": {)";
    for (int i = 0; i < 4; ++i) {
      const double friction = random.uniform(0, 1);
      text += (i > 0 ? ", " : "") + quoted("m" + std::to_string(i)) + R"(: {"stiffness_N_m": )" +
              std::to_string(random.uniform(200, 1500)) + R"(, "static_friction": )" +
              std::to_string(friction) + R"(, "dynamic_friction": )" + std::to_string(.8 * friction) + "}";
    }
    text += R"(}, "objects": [)";
    result.level = random.below(2) == 0;
    if (result.level) {
      text +=
          object("ground", R"("plane": {"normal": [0, 0, 1]})", Vector3d::Zero(), Vector3d::Zero(), random) +
          "}";
    } else {
      host::TriangleSoup ground = box_mesh({.4, .4, .04}, 24);
      for (Vector3d& p : ground.vertices_m)
        p += Vector3d(0, 0, -.02 + (p.z() > 0 ? random.uniform(0, .002) : 0));
      text += object("ground", mesh(ground), Vector3d::Zero(), Vector3d::Zero(), random) + "}";
    }
    for (std::size_t i = 0; i < bodies; ++i) {
      result.mass_kg.push_back(std::exp(random.uniform(std::log(.02), std::log(.4))));
      const Vector3d at =
          crossing
              ? Vector3d(random.in_box({.02, .02, .015}) + Vector3d(0, 0, .04))
              : Vector3d(random.in_box({.02, .02, 0}) + Vector3d(0, 0, .05 + .045 * static_cast<double>(i)));
      text += ", " +
              object("body " + std::to_string(i), solid(random, result), at,
                     180 * random.in_box(Vector3d::Ones()), random) +
              R"(, "body": {"motion": "free", "mass_kg": )" + std::to_string(result.mass_kg.back()) +
              R"(, "restitution": )" + std::to_string(random.below(2) == 0 ? 0 : random.uniform(0, .8)) +
              "}}";
    }
    result.members = text + "]";
    for (std::array<Vector3d, 4>& path : result.paths) {
      path[0] = Vector3d(0, 0, .045) + random.in_box({.01, .01, .005});
      for (std::size_t i = 1; i < path.size(); ++i) path.at(i) = random.in_box({.03, .03, .015});
    }
    return result;
  }

 private:
  static std::string quoted(const std::string& text) { return '"' + text + '"'; }

  static std::string object(const std::string& name, const std::string& shape, const Vector3d& at_m,
                            const Vector3d& angles_deg, Random& random) {
    return R"({"name": ")" + name + R"(", "material": "m)" + std::to_string(random.below(4)) +
           R"(", "shape": {)" + shape + R"(}, "pose": {"position_m": )" + list(at_m) +
           R"(, "rotation_deg": )" + list(angles_deg) + "}";
  }

  std::string mesh(const host::TriangleSoup& soup) {
    const std::filesystem::path file = folder_.path() / ("mesh" + std::to_string(files_++) + ".obj");
    write_obj(soup, 1000.0, file);
    return R"("mesh": {"file": ")" + file.string() + R"(", "scale": 0.001})";
  }

  std::string solid(Random& random, Composition& into) {
    const double a = random.uniform(.008, .016);
    const double b = random.uniform(.008, .016);
    const double c = random.uniform(.006, .014);
    switch (random.below(6)) {
      case 0:
        into.outside_m.emplace_back([a](const Vector3d& p) { return p.norm() - a; });
        return R"("sphere": {"radius_m": )" + std::to_string(a) + "}";
      case 1:
        into.outside_m.emplace_back(
            [a, b, c](const Vector3d& p) { return (p.cwiseAbs() - Vector3d(a, b, c)).maxCoeff(); });
        return R"("box": {"size_m": )" + list(2 * Vector3d(a, b, c)) + "}";
      case 2:
        into.outside_m.emplace_back(
            [a, b](const Vector3d& p) { return std::max(p.head<2>().norm() - a, std::abs(p.z()) - b); });
        return R"("cylinder": {"radius_m": )" + std::to_string(a) + R"(, "height_m": )" +
               std::to_string(2 * b) + "}";
      case 3:
        return solid_of(torus(.014, .005, 14, 8), into);
      case 4:
        return solid_of(icosphere(2, a), into);
      default:
        return solid_of(box_mesh(2 * Vector3d(a, b, c), 2), into);
    }
  }
  std::string solid_of(const host::TriangleSoup& soup, Composition& into) {
    // As the file has it: rounded.
    const MeshOracle oracle(soup);
    into.outside_m.emplace_back([oracle](const Vector3d& p) { return oracle.signed_distance(p, .01); });
    return mesh(soup);
  }

  TemporaryFolder folder_;
  int files_ = 0;
};

}  // namespace thimble::test
