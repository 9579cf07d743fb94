// Height fields: a known surface through CSV and PNG, gives the force of its closed form with a second-order
// error in the grid step; the block around it; its limits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/hand_path.h"
#include "board/sim/hand_path_file.h"
#include "control/scene/limits.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/height_grid.h"
#include "host-tools/compiler/scene_height_field.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/png.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kStiffness_N_m = 1000.0;

class Folder : public TemporaryFolder {
 public:
  // A scene of one height field.
  [[nodiscard]] host::CompiledScene compile(const std::string& shape) const {
    return host::compile_scene_text(
        R"({"thimble_scene": 1, "name": "heights", "objects": [{"name": "hill", "shape": {"height_field": )" +
            shape + R"(}, "material": {"stiffness_N_m": 1000}}]})",
        "heights", path());
  }
};

// A smooth surface: hills of 4 mm, 50 and 60 mm apart; least radius of curvature 12 mm.
constexpr double kSize_m = 0.1;
constexpr double kHill_m = 0.004;
constexpr double kX = 2.0 * std::numbers::pi / 0.05;
constexpr double kY = 2.0 * std::numbers::pi / 0.06;
double hill(double x, double y) { return kHill_m * std::sin(kX * x + 0.3) * std::cos(kY * y + 0.5); }
Vector3d hill_normal(double x, double y) {
  return Vector3d(-kHill_m * kX * std::cos(kX * x + 0.3) * std::cos(kY * y + 0.5),
                  kHill_m * kY * std::sin(kX * x + 0.3) * std::sin(kY * y + 0.5), 1.0)
      .normalized();
}
Vector3d below(double x, double y, double depth_m) {
  return Vector3d(x, y, hill(x, y)) - depth_m * hill_normal(x, y);
}

double at(int i, int points) { return kSize_m * (static_cast<double>(i) / (points - 1) - 0.5); }

std::string hill_csv(int points) {
  std::ostringstream text;
  text.precision(12);
  for (int row = points - 1; row >= 0; --row) {  // the file's first line is the back
    for (int i = 0; i < points; ++i) text << (i == 0 ? "" : ",") << hill(at(i, points), at(row, points));
    text << "\n";
  }
  return text.str();
}

// Grey 0 to 65535 for -kHill_m to kHill_m.
std::string hill_png(int points) {
  std::vector<std::uint16_t> grey;
  for (int row = points - 1; row >= 0; --row) {
    for (int i = 0; i < points; ++i) {
      grey.push_back(static_cast<std::uint16_t>(
          std::lround(65535.0 * 0.5 * (hill(at(i, points), at(row, points)) / kHill_m + 1.0))));
    }
  }
  return encode(grey_png(static_cast<std::uint32_t>(points), grey));
}

struct Errors {
  double height_m = 0;  // root mean squares
  double direction_deg = 0;
  double depth_m = 0;
};

// Presses 1 mm deep at random places, at least a coarse cell from the rim.
Errors errors(const SceneImage& image, double raised_m) {
  Random random(3);
  IdealRun run(image);
  Errors sum;
  constexpr int kPlaces = 4000;
  constexpr double kDepth_m = 0.001;
  for (int i = 0; i < kPlaces; ++i) {
    const double x = random.uniform(-0.042, 0.042);
    const double y = random.uniform(-0.042, 0.042);
    run.restart({x, y, hill(x, y) + 0.005 + raised_m});
    const Felt& felt = run.step(below(x, y, kDepth_m) + Vector3d(0, 0, raised_m));
    const Vector3d g = felt.god_object_m;
    sum.height_m += std::pow(g.z() - raised_m - hill(g.x(), g.y()), 2);
    const double cosine = felt.force_N.normalized().dot(hill_normal(g.x(), g.y()));
    sum.direction_deg += std::pow(std::acos(std::min(cosine, 1.0)) / kDegree, 2);
    sum.depth_m += std::pow(felt.force_N.norm() / kStiffness_N_m - kDepth_m, 2);
  }
  return {std::sqrt(sum.height_m / kPlaces), std::sqrt(sum.direction_deg / kPlaces),
          std::sqrt(sum.depth_m / kPlaces)};
}

TEST(HeightField, IsTheSurfaceItSamplesToSecondOrder) {
  const Folder folder;
  std::vector<Errors> found;
  for (const int points : {26, 51, 101}) {
    folder.write("hill.csv", hill_csv(points));
    const SceneImage image(
        folder.compile(R"({"file": "hill.csv", "size_m": [0.1, 0.1], "height_m": 1})").image);
    found.push_back(errors(image, 0.0));
    const std::string name = std::to_string(points) + " x " + std::to_string(points) + ": rms error of ";
    figure(name + "height, um", 1e6 * found.back().height_m, "a quarter of the grid before, 3.4 to 4.6");
    figure(name + "force direction, degrees", found.back().direction_deg, "a quarter, 3.4 to 4.6");
    figure(name + "force over K, um", 1e6 * found.back().depth_m, "a quarter, 3.4 to 4.6");
  }
  for (std::size_t i = 1; i < found.size(); ++i) {
    for (const double ratio :
         {found[i - 1].height_m / found[i].height_m, found[i - 1].direction_deg / found[i].direction_deg,
          found[i - 1].depth_m / found[i].depth_m}) {
      EXPECT_GT(ratio, 3.4);
      EXPECT_LT(ratio, 4.6);
    }
  }
  EXPECT_LT(found.back().height_m, 7e-6);
  EXPECT_LT(found.back().direction_deg, 0.15);

  // The same from an image, whose white is 8 mm above its black.
  folder.write("hill.png", hill_png(101));
  const SceneImage image(
      folder.compile(R"({"file": "hill.png", "size_m": [0.1, 0.1], "height_m": 0.008})").image);
  const Errors png = errors(image, kHill_m);
  figure("from a PNG: rms error of height, um", 1e6 * png.height_m, "as the CSV within 0.1");
  figure("from a PNG: rms error of force direction, degrees", png.direction_deg, "as the CSV within 0.01");
  EXPECT_NEAR(png.height_m, found.back().height_m, 1e-7);
  EXPECT_NEAR(png.direction_deg, found.back().direction_deg, 0.01);
}

TEST(HeightField, HasNoSeamsBetweenItsCells) {
  const Folder folder;
  folder.write("hill.csv", hill_csv(51));
  const SceneImage smooth(
      folder.compile(R"({"file": "hill.csv", "size_m": [0.1, 0.1], "height_m": 1})").image);
  const SceneImage faceted(
      folder.compile(R"({"file": "hill.csv", "size_m": [0.1, 0.1], "height_m": 1, "crease_deg": 0})").image);
  const auto largest_step = [](const SceneImage& image) {
    Random random(4);
    IdealRun run(image);
    double most_deg = 0;
    for (int stroke = 0; stroke < 60; ++stroke) {
      const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
      const double aside = random.uniform(-0.02, 0.02);
      Vector3d before = Vector3d::Zero();
      for (int i = -300; i <= 300; ++i) {  // 0.1 mm apart
        const double along = 1e-4 * i;
        const double x = along * std::cos(angle) - aside * std::sin(angle);
        const double y = along * std::sin(angle) + aside * std::cos(angle);
        if (i == -300) run.restart({x, y, hill(x, y) + 0.002});
        const Vector3d force = run.step(below(x, y, 0.001)).force_N.normalized();
        if (i > -300) most_deg = std::max(most_deg, std::acos(std::min(1.0, force.dot(before))) / kDegree);
        before = force;
      }
    }
    return most_deg;
  };
  // The surface itself turns by 0.1 mm / (12 mm - 1 mm), which is 0.5 degrees.
  const double shaded = figure("turn of the force over 0.1 mm, degrees", largest_step(smooth), "1");
  const double flat = figure("the same with every edge a crease", largest_step(faceted), "above 5");
  EXPECT_LT(shaded, 1.0);
  EXPECT_GT(flat, 5.0);
}

TEST(HeightField, BrightnessIsHeightExactlyAndTheSameBytesEachTime) {
  PngImage picture{.width = 16, .height = 16};
  for (unsigned i = 0; i < 256; ++i) {
    if (i % 16 == 0) picture.scanlines.push_back(0);
    picture.scanlines.push_back(static_cast<std::uint8_t>(i * 73U % 256U));
  }
  const Folder folder;
  folder.write("grey.png", encode(picture));
  const std::string shape = R"({"file": "grey.png", "size_m": [0.15, 0.15], "height_m": 0.02})";
  const host::CompiledScene compiled = folder.compile(shape);
  EXPECT_EQ(compiled.image, folder.compile(shape).image);
  const SceneImage image(compiled.image);
  std::size_t seen = 0;
  std::size_t wrong = 0;
  for (const scene::Vertex* v : *image.view().scene()->objects()->Get(0)->shape_as_Mesh()->vertices()) {
    if (v->position_m().z() < -0.005F) continue;  // the bottom
    const auto column = static_cast<unsigned>(std::lround((v->position_m().x() + 0.075F) / 0.01F));
    const auto row = static_cast<unsigned>(std::lround((0.075F - v->position_m().y()) / 0.01F));
    const unsigned grey = (16U * row + column) * 73U % 256U;
    ++seen;
    if (v->position_m().z() != static_cast<float>(0.02 * (grey / 255.0))) ++wrong;
  }
  figure("points of 256 whose height is not exactly their brightness's", static_cast<double>(wrong), "0");
  EXPECT_EQ(seen, 256U);
  EXPECT_EQ(wrong, 0U);
}

TEST(HeightField, IsAClosedBlockOfAnySize) {
  constexpr std::size_t kSide = kUnderSanitizers ? 110 : 724;
  constexpr std::pair<std::size_t, std::size_t> kLargest{kSide, kSide};
  for (const auto& [columns, rows] : std::vector<std::pair<std::size_t, std::size_t>>{{2, 2},
                                                                                      {2, 5},
                                                                                      {5, 2},
                                                                                      {3, 3},
                                                                                      {3, 8},
                                                                                      {8, 3},
                                                                                      {4, 4},
                                                                                      {41, 7},
                                                                                      {7, 41},
                                                                                      {97, 130},
                                                                                      {98, 98},
                                                                                      {130, 98},
                                                                                      {2, 999},
                                                                                      kLargest}) {
    // A slope, so that the block's volume is exact.
    host::HeightGrid grid{columns, rows, {}};
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < columns; ++x) {
        grid.values.push_back(0.01 * static_cast<double>(x) / static_cast<double>(columns - 1) -
                              0.02 * static_cast<double>(y) / static_cast<double>(rows - 1));
      }
    }
    const host::HeightFieldShape shape{"", {0.1, 0.08}, 1.0, 0.005, 180.0, ""};
    const host::CompiledMesh mesh = host::compile_mesh(
        host::height_field_soup(shape, grid, "grid"),
        {.side = host::MeshSide::kOutside, .crease_deg = 180.0, .height_field = true}, "grid");
    const std::string name = std::to_string(columns) + " x " + std::to_string(rows);
    EXPECT_EQ(mesh.report.open_edges, 0U) << name;
    EXPECT_EQ(mesh.report.non_manifold_edges, 0U) << name;
    EXPECT_EQ(mesh.report.components, 1U) << name;
    EXPECT_EQ(mesh.report.flipped_components, 0U) << name;
    EXPECT_EQ(mesh.report.degenerate_dropped, 0U) << name;
    EXPECT_EQ(mesh.report.pierced_triangles, 0U) << name;
    double volume_m3 = 0;
    std::vector<std::size_t> fan(mesh.vertices.size());
    const host::TriangleSoup soup = as_soup(mesh);
    for (const auto& t : soup.triangles) {
      volume_m3 += soup.vertices_m[t[0]].dot(soup.vertices_m[t[1]].cross(soup.vertices_m[t[2]])) / 6.0;
      for (const std::uint32_t v : t) ++fan[v];
    }
    // Mean height -0.005, bottom at -0.02 - 0.005.
    EXPECT_NEAR(volume_m3, 0.1 * 0.08 * 0.02, 1e-10) << name;
    const std::size_t most = *std::max_element(fan.begin(), fan.end());
    EXPECT_LT(most, 64U) << name;
    if (columns == kSide) figure(name + ": most faces round a point", static_cast<double>(most), "64");
  }
}

TEST(HeightField, WallsAndBottomAreFlat) {
  const Folder folder;
  folder.write("hill.csv", hill_csv(21));
  const SceneImage image(
      folder.compile(R"({"file": "hill.csv", "size_m": [0.1, 0.1], "height_m": 1, "thickness_m": 0.02})")
          .image);
  IdealRun run(image);
  double worst_N = 0;
  for (const Vector3d& side :
       {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)}) {
    const Vector3d middle(0, 0, -0.012);
    run.restart(middle + 0.06 * side);
    for (int i = 0; i < 50; ++i) {
      const Vector3d along = side.cross(Vector3d::UnitZ()) * 0.0005 * i;
      worst_N = std::max(worst_N, (run.step(middle + 0.048 * side + along).force_N - 2.0 * side).norm());
    }
  }
  run.restart({0, 0, -0.05});
  for (int i = 0; i < 50; ++i) {
    const Vector3d force = run.step({0.0004 * i, 0.0003 * i, -0.0235}).force_N;
    worst_N = std::max(worst_N, (force + Vector3d(0, 0, force.norm())).norm());
    EXPECT_GT(force.norm(), 0.1);
  }
  figure("walls and bottom: force aside or amiss, N", worst_N, "0.001");
  EXPECT_LT(worst_N, 0.001);
}

TEST(HeightField, AboveTheLimitsIsRefusedWithFigureAndLimit) {
  const Folder folder;
  const auto grid = [](std::size_t columns, std::size_t rows) {
    std::string line(2 * columns, ',');
    for (std::size_t i = 0; i < columns; ++i) line[2 * i] = '0';
    line.back() = '\n';
    std::string text;
    for (std::size_t i = 0; i < rows; ++i) text += line;
    return text;
  };
  struct Case {
    std::string bytes;
    std::string name;
    std::string part;
  };
  static_assert(control::kMaxHeightSamples == 524288 && control::kMaxTriangles == 1064960);
  for (const Case& c : {Case{grid(3, 174763), "too-many-samples", "more than 524288 values"},
                        Case{grid(97, 5400), "too-many-samples",
                             "97 x 5400 values; with its walls it has 1070932 triangles, at most 1064960"},
                        Case{encode(grey_png(1000, std::vector<std::uint16_t>(600000))), "too-many-samples",
                             "1000 x 600 values, at most 524288"}}) {
    folder.write("heights", c.bytes);
    try {
      static_cast<void>(folder.compile(R"({"file": "heights", "size_m": [0.1, 0.1], "height_m": 0.01})"));
      ADD_FAILURE() << c.part;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, c.name) << error.cause;
      EXPECT_THAT(error.cause, HasSubstr(c.part));
    }
  }
}

// The heights between the points of a grid, as the triangles of its cells have them.
double height_of(const host::HeightGrid& grid, const Eigen::Vector2d& size_m, double height_m, double x,
                 double y) {
  const auto cell = [](double at, std::size_t points) {
    const double last = static_cast<double>(points - 1);
    const double steps = std::clamp((at + 0.5) * last, 0.0, last);
    const double first = std::min(std::floor(steps), last - 1.0);
    return std::pair(static_cast<std::size_t>(first), steps - first);
  };
  const auto [i, u] = cell(x / size_m.x(), grid.columns);
  const auto [j, v] = cell(y / size_m.y(), grid.rows);
  const double a = grid.at(i, j);
  const double b = grid.at(i + 1, j);
  const double c = grid.at(i + 1, j + 1);
  const double d = grid.at(i, j + 1);
  if ((i + j) % 2 == 0)
    return height_m * (u >= v ? a + u * (b - a) + v * (c - b) : a + u * (c - d) + v * (d - a));
  return height_m *
         (u + v <= 1.0 ? a + u * (b - a) + v * (d - a) : c + (1 - u) * (d - c) + (1 - v) * (b - c));
}

// A tip comes down on random places, on points, lines, the rim and the corners of the grid, and is held on the surface that
// its numbers say; so from below.
TEST(HeightField, TheLargestIsFeltWhereItsNumbersSay) {
  std::vector<std::pair<std::size_t, std::size_t>> sizes{{120, 100}};
  if (!kUnderSanitizers) sizes = {{724, 724}, {1024, 512}, {3449, 152}, {120, 100}};
  const Folder folder;
  Random random(7);
  for (const auto& [columns, rows] : sizes) {
    const std::string name = std::to_string(columns) + " x " + std::to_string(rows);
    host::HeightGrid grid{columns, rows, {}};
    std::vector<std::uint16_t> grey(columns * rows);
    for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = static_cast<std::uint16_t>(random.below(65536));
    for (std::size_t y = 0; y < rows; ++y) {
      for (std::size_t x = 0; x < columns; ++x)
        grid.values.push_back(grey[(rows - 1 - y) * columns + x] / 65535.0);
    }
    folder.write("noise.png", encode(grey_png(static_cast<std::uint32_t>(columns), grey)));
    const host::CompiledScene compiled = folder.compile(
        R"({"file": "noise.png", "size_m": [0.3, 0.2], "height_m": 0.0001, "thickness_m": 0.004})");
    EXPECT_TRUE(compiled.report.warnings.empty()) << name << ": " << compiled.report.warnings.front();
    const SceneImage image(compiled.image);
    IdealRun run(image);
    double worst_m = 0;
    const Eigen::Vector2d size_m(0.3, 0.2);
    constexpr double kPress_m = 1e-5;
    const auto place = [&](std::size_t points) {  // -0.5 to 0.5
      const auto last = static_cast<double>(points - 1);
      switch (random.below(4)) {
        case 0:
          return static_cast<double>(random.below(2)) - 0.5;
        case 1:
          return static_cast<double>(random.below(points)) / last - 0.5;
        default:
          return random.uniform(-0.5, 0.5);
      }
    };
    const double bottom_m = 1e-4 * *std::min_element(grid.values.begin(), grid.values.end()) - 0.004;
    constexpr int kPlaces = 8000;
    for (int i = 0; i < kPlaces; ++i) {
      // On the rim: a little inside, where the top is nearer than the wall.
      const double x = (1.0 - 2e-4) * size_m.x() * place(columns);
      const double y = (1.0 - 2e-4) * size_m.y() * place(rows);
      run.restart({x, y, 0.0002});
      Vector3d god = run.step({x, y, height_of(grid, size_m, 1e-4, x, y) - kPress_m}).god_object_m;
      worst_m = std::max(worst_m, std::abs(god.z() - height_of(grid, size_m, 1e-4, god.x(), god.y())));
      worst_m = std::max(worst_m, (god.head<2>() - Eigen::Vector2d(x, y)).norm() - kPress_m);
      run.restart({x, y, bottom_m - 0.0002});
      god = run.step({x, y, bottom_m + kPress_m}).god_object_m;
      worst_m = std::max(worst_m, (god - Vector3d(x, y, bottom_m)).norm());
    }
    figure(name + ": god object off the surface, um", 1e6 * worst_m, "0.5: rounding and surface tolerance");
    EXPECT_LT(worst_m, 0.5e-6) << name;
  }
}

// A scene of one height field under its own hand, against the numbers of its file.
struct Followed {
  double off_m = 0;         // most that the god object is off the heights of the grid, bilinear between them
  int touching = 0;         // ticks
  std::vector<double> x_m;  // while the hand goes along the leg asked for: where it is,
  std::vector<double> lean_deg;  // and how far the force leans from straight up, to +x
};

Followed follow(const std::string& name, const std::string& data, double size_m, double height_m,
                double raised_m, double begin_s, double end_s) {
  const fs::path folder = fs::path(THIMBLE_SOURCE_DIR) / "scenes" / name;
  const host::HeightGrid grid = host::read_height_grid(folder / data, control::kMaxHeightSamples, data);
  const auto height = [&](double x, double y) {
    const auto cell = [&](double at_m, std::size_t points) {
      return std::clamp((at_m / size_m + 0.5) * static_cast<double>(points - 1), 0.0,
                        static_cast<double>(points) - 1.001);
    };
    const double u = cell(x, grid.columns);
    const double v = cell(y, grid.rows);
    const auto i = static_cast<std::size_t>(u);
    const auto j = static_cast<std::size_t>(v);
    const double a = u - static_cast<double>(i);
    const double b = v - static_cast<double>(j);
    return raised_m + height_m * ((1 - b) * ((1 - a) * grid.at(i, j) + a * grid.at(i + 1, j)) +
                                  b * ((1 - a) * grid.at(i, j + 1) + a * grid.at(i + 1, j + 1)));
  };
  const SceneImage image(host::compile_scene(folder / (name + ".scene.json")).image);
  const board::HandPath path(board::read_hand_path(folder / "stroke.csv"));
  IdealRun run(image);
  run.restart(path.at(path.start_s()).position_m);
  Followed felt;
  for (double t = path.start_s(); t <= path.end_s(); t += 1.0 / kRate_Hz) {
    const Felt& now = run.step(path.at(t).position_m);
    if (now.contacts == 0) continue;
    ++felt.touching;
    const Vector3d& g = now.god_object_m;
    felt.off_m = std::max(felt.off_m, std::abs(g.z() - height(g.x(), g.y())));
    if (t < begin_s || t > end_s) continue;
    felt.x_m.push_back(now.tip_m.x());
    felt.lean_deg.push_back(std::atan2(now.force_N.x(), now.force_N.z()) / kDegree);
  }
  return felt;
}

TEST(Heights, TheTelephonesKeysAreFelt) {
  const Followed felt = follow("telephone", "heights_mm.csv", 0.15, 0.001, -0.07, 1.2, 3.2);
  figure("telephone: ticks in contact", felt.touching, "above 20000");
  figure("telephone: god object off the measured heights, mm", 1e3 * felt.off_m,
         "2: a cell at the rim of a cup rises 20 mm");
  EXPECT_GT(felt.touching, 20000);
  EXPECT_LT(felt.off_m, 2e-3);
  // Along the row: up the left edge of each of its three keys, which pushes back to the left, and down the
  // right one.
  for (const double key_m : {-0.028, -0.008, 0.012}) {
    double left_deg = 0;
    double right_deg = 0;
    for (std::size_t i = 0; i < felt.x_m.size(); ++i) {
      const double along_m = felt.x_m[i] - key_m;
      if (std::abs(along_m + 0.006) < 0.003) left_deg = std::min(left_deg, felt.lean_deg[i]);
      if (std::abs(along_m - 0.006) < 0.003) right_deg = std::max(right_deg, felt.lean_deg[i]);
    }
    figure("telephone: lean of the force at a key's left edge, degrees", left_deg, "below -25");
    figure("telephone: lean of the force at its right edge, degrees", right_deg, "above 25");
    EXPECT_LT(left_deg, -25.0);
    EXPECT_GT(right_deg, 25.0);
  }
}

TEST(Heights, TheBaboonIsFeltAsItIsBright) {
  const Followed felt = follow("baboon", "face.png", 0.12, 0.016, -0.045, 3.9, 6.2);
  figure("baboon: ticks in contact", felt.touching, "above 20000");
  figure("baboon: god object off the picture's brightness, mm", 1e3 * felt.off_m, "0.5");
  EXPECT_GT(felt.touching, 20000);
  EXPECT_LT(felt.off_m, 0.5e-3);
  // To and fro over the muzzle: its left side leans the force to the left, its right side to the right.
  double left_deg = 0;
  double right_deg = 0;
  for (std::size_t i = 0; i < felt.x_m.size(); ++i) {
    if (std::abs(felt.x_m[i] + 0.012) < 0.003) left_deg = std::min(left_deg, felt.lean_deg[i]);
    if (std::abs(felt.x_m[i] - 0.012) < 0.003) right_deg = std::max(right_deg, felt.lean_deg[i]);
  }
  figure("baboon: lean of the force left of the muzzle, degrees", left_deg, "below -15");
  figure("baboon: lean of the force right of it, degrees", right_deg, "above 15");
  EXPECT_LT(left_deg, -15.0);
  EXPECT_GT(right_deg, 15.0);
}

}  // namespace
}  // namespace thimble::test
