// Straight pokes into every usable model of Debian's assimp-testmodels as it is: closed or open, with parts that cross or
// not. Embree judges: where closed parts wind round the god object it has fallen, and a tip inside is held in every tick.
// THIMBLE_POKES sets the number of pokes, THIMBLE_POKE_SEED the seed, THIMBLE_POKE_BYTES the size of the largest file,
// THIMBLE_POKE_FOLDER another folder with models.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh_file.h"
#include "host-tools/error.h"
#include "tests/support/assimp_leaks.h"
#include "tests/support/embree_oracle.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/pokes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultPokes = kUnderSanitizers ? 200 : 1e4;
constexpr double kDefaultBytes = 1e5;  // of the file; with larger ones reading takes longer than poking
constexpr double kSize_m = 0.1;
constexpr double kInside_m = 2e-6;

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}

fs::path model_folder() {
  const char* folder =
      std::getenv("THIMBLE_POKE_FOLDER");  // NOLINT(concurrency-mt-unsafe): before any thread
  return folder == nullptr ? test_model_path("") : fs::path(folder);
}

struct Tally {
  long models = 0;
  long pokes = 0;
  long ticks = 0;
  long in_contact = 0;
  long fallen = 0;  // ticks in which the god object came to be inside a closed part
  long silent = 0;  // ticks in which the tip was inside and nothing pushed
};

host::TriangleSoup closed_parts(const host::CompiledMesh& mesh, host::TriangleSoup soup) {
  std::size_t t = 0;
  std::erase_if(soup.triangles, [&](const auto&) {
    return (mesh.flags[t++] & static_cast<unsigned>(scene::TriangleFlag::TwoSided)) != 0;
  });
  return soup;
}

constexpr std::uint32_t kNoTriangle = 0xFFFFFFFF;

class Judge {
 public:
  Judge(std::string name, const host::CompiledMesh& mesh)
      : name_(std::move(name)), soup_(as_soup(mesh)), oracle_(soup_), solids_(closed_parts(mesh, soup_)) {}

  [[nodiscard]] const host::TriangleSoup& soup() const { return soup_; }
  [[nodiscard]] bool free(const Vector3d& p) const {
    return solids_.in_the_open(p) && oracle_.nearest(p, 1e-5).triangle == kNoTriangle;
  }

  // In the mesh's own frame. True for a fall.
  bool judge(const Vector3d& tip, const Vector3d& god, int contacts, Tally& tally) {
    ++tally.ticks;
    if (contacts > 0) ++tally.in_contact;
    if (solids_.winding(god) <= 0 || oracle_.nearest(god, kInside_m).triangle != kNoTriangle) return false;
    ++(contacts > 0 ? tally.fallen : tally.silent);
    if (++shown_ <= 3) {
      std::printf("  %s: inside: tip (%.9g %.9g %.9g), god object (%.9g %.9g %.9g)\n", name_.c_str(), tip.x(),
                  tip.y(), tip.z(), god.x(), god.y(), god.z());
    }
    return true;
  }

 private:
  std::string name_;
  host::TriangleSoup soup_;
  MeshOracle oracle_;
  EmbreeOracle solids_;
  int shown_ = 0;
};

void poke_model(const std::string& name, const host::CompiledMesh& mesh, long pokes, Random& random,
                Tally& tally) {
  Judge judge(name, mesh);
  const host::TriangleSoup& soup = judge.soup();
  const Pose pose{random.in_box(Vector3d::Constant(0.02)), random_turn(random)};
  const auto to_world = [&](const Vector3d& p) { return Vector3d(pose.position_m + pose.rotation * p); };
  const auto to_local = [&](const Vector3d& p) {
    return Vector3d(pose.rotation.conjugate() * (p - pose.position_m));
  };
  const SceneImage image = SceneBuilder().mesh(mesh, random_material(random), pose).image();
  IdealRun run(image);
  ++tally.models;
  for (long i = 0; i < pokes; ++i) {
    const auto& triangle = soup.triangles[random.below(soup.triangles.size())];
    const double u = random.uniform(0.0, 1.0);
    const double v = random.uniform(0.0, 1.0 - u);
    const Vector3d on = u * soup.vertices_m[triangle[0]] + v * soup.vertices_m[triangle[1]] +
                        (1.0 - u - v) * soup.vertices_m[triangle[2]];
    const bool slow = i % 10 == 9;  // a fiftieth of the speed
    const double reach_m = (slow ? 0.01 : 0.05) * kSize_m;
    const Vector3d from = on + reach_m * random.direction();
    const Vector3d to = on + reach_m * random.direction();
    if (!judge.free(from)) continue;
    ++tally.pokes;
    run.restart(to_world(from));
    const auto ticks = 1 + static_cast<int>((to - from).norm() / (slow ? 2e-6 : 1e-4));
    for (int tick = 1; tick <= ticks; ++tick) {
      const Felt& felt = run.step(to_world(from + (to - from) * tick / ticks));
      if (judge.judge(to_local(felt.tip_m), to_local(felt.god_object_m), felt.contacts, tally)) break;
    }
  }
}

// Every file below the folder that the compiler accepts, 100 mm large.
std::vector<std::pair<std::string, host::CompiledMesh>> models(double most_bytes) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(model_folder()))
    if (entry.is_regular_file() && static_cast<double>(entry.file_size()) <= most_bytes)
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::pair<std::string, host::CompiledMesh>> result;
  for (const fs::path& file : files) {
    const std::string name = fs::relative(file, model_folder()).string();
    try {
      host::TriangleSoup soup = host::read_mesh_file(file, 1.0, name);
      Eigen::AlignedBox3d box;
      for (const auto& t : soup.triangles)
        for (const std::uint32_t index : t) box.extend(soup.vertices_m[index]);
      const double scale = kSize_m / box.sizes().maxCoeff();
      result.emplace_back(
          name, host::compile_mesh(
                    transformed(std::move(soup), Eigen::Matrix3d::Identity() * scale, -scale * box.center()),
                    {}, name));
    } catch (const host::Error&) {  // test_models_test lists them
    }
  }
  return result;
}

TEST(PublicMeshes, NeverLetAPokeThrough) {
  const double wanted = from_environment("THIMBLE_POKES", kDefaultPokes);
  const auto seed = static_cast<std::uint64_t>(from_environment("THIMBLE_POKE_SEED", 1.0));
  const auto all = models(from_environment("THIMBLE_POKE_BYTES", kDefaultBytes));
  ASSERT_FALSE(all.empty());
  Tally tally;
  Random random(seed);
  std::size_t index = 0;
  for (const auto& [name, mesh] : all) {
    const auto left = static_cast<double>(all.size() - index++);
    const double pokes = std::ceil((wanted - static_cast<double>(tally.pokes)) / left);
    poke_model(name, mesh, static_cast<long>(1.05 * pokes) + 1, random, tally);
  }
  figure("public meshes: models", static_cast<double>(tally.models), "");
  figure("public meshes: pokes", static_cast<double>(tally.pokes), "");
  figure("public meshes: ticks", static_cast<double>(tally.ticks), "");
  figure("public meshes: ticks in contact", static_cast<double>(tally.in_contact), "> 0");
  figure("public meshes: inside a closed part", static_cast<double>(tally.fallen), "0");
  figure("public meshes: ticks inside without a contact", static_cast<double>(tally.silent), "0");
  EXPECT_GT(tally.in_contact, 0);
  EXPECT_EQ(tally.fallen, 0);
  EXPECT_EQ(tally.silent, 0);
}

}  // namespace
}  // namespace thimble::test
