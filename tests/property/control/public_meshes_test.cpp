// Straight pokes into every usable model of Debian's assimp-testmodels, and of the npm packages in tests/support/npm_models, as it is:
// closed or open, with parts that cross or not. Embree judges: where closed parts wind round the god object it has fallen, and a tip
// inside is held in every tick.
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

// In the mesh's own frame.
struct Poke {
  Vector3d from;
  Vector3d to;
  int ticks = 0;
};

// Up to the first fall.
void poke(const Poke& way, const Pose& pose, IdealRun& run, Judge& judge, Tally& tally) {
  const auto to_world = [&](const Vector3d& p) { return Vector3d(pose.position_m + pose.rotation * p); };
  const auto to_local = [&](const Vector3d& p) {
    return Vector3d(pose.rotation.conjugate() * (p - pose.position_m));
  };
  ++tally.pokes;
  run.restart(to_world(way.from));
  for (int tick = 1; tick <= way.ticks; ++tick) {
    const Felt& felt = run.step(to_world(way.from + (way.to - way.from) * tick / way.ticks));
    if (judge.judge(to_local(felt.tip_m), to_local(felt.god_object_m), felt.contacts, tally)) return;
  }
}

void poke_model(const std::string& name, const host::CompiledMesh& mesh, long pokes, Random& random,
                Tally& tally) {
  Judge judge(name, mesh);
  const host::TriangleSoup& soup = judge.soup();
  const Pose pose{random.in_box(Vector3d::Constant(0.02)), random_turn(random)};
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
    poke({from, to, 1 + static_cast<int>((to - from).norm() / (slow ? 2e-6 : 1e-4))}, pose, run, judge,
         tally);
  }
}

// A file's mesh, 100 mm large.
host::CompiledMesh model(const fs::path& file, const std::string& name) {
  host::TriangleSoup soup = host::read_mesh_file(file, 1.0, name);
  Eigen::AlignedBox3d box;
  for (const auto& t : soup.triangles)
    for (const std::uint32_t index : t) box.extend(soup.vertices_m[index]);
  const double scale = kSize_m / box.sizes().maxCoeff();
  return host::compile_mesh(
      transformed(std::move(soup), Eigen::Matrix3d::Identity() * scale, -scale * box.center()), {}, name);
}

// Every file below the folder that the compiler accepts.
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
      result.emplace_back(name, model(file, name));
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

// Pokes that fell. Rounding decides, so that they are written down to the last bit.
TEST(PublicMeshes, HoldThePokesThatFell) {
  struct Case {
    std::string name;
    Pose pose;
    double static_friction;
    double dynamic_friction;
    Poke way;
  };
  const std::vector<Case> cases = {
      // faces round one vertex cross
      {"Collada/duck.dae",
       {{-0x1.416435e4103c3p-10, -0x1.0f77f1182f9a9p-7, 0x1.d3dacdbb9a631p-7},
        {-0x1.8a6d9832acec4p-1, -0x1.9421257b23c9bp-3, -0x1.3235829131b62p-1, -0x1.97d72360f65edp-4}},
       0.0,
       0.0,
       {{0x1.49d36793fdb46p-5, 0x1.24b0fee4d51c4p-6, -0x1.479ddb486b47ap-9},
        {0x1.5b865095c3566p-5, 0x1.7ae8560758368p-7, 0x1.d5a367011c0c6p-9},
        91}},
      {"Collada/duck.zae",
       {{0x1.6bf1140d86876p-7, -0x1.2d17db6bcd0b6p-7, -0x1.32705ff784bffp-6},
        {-0x1.bfecee72872c4p-1, 0x1.05bb364e8148p-7, -0x1.7b07b475d8b24p-3, -0x1.ca4e40543d28cp-2}},
       0x1.22f6a6p-2,
       0x1.3ca21p-3,
       {{0x1.53ca185c81c41p-5, 0x1.1e256b140c178p-6, -0x1.68159f1745ac3p-9},
        {0x1.4ad362a9945d5p-5, 0x1.9a1c961709861p-7, 0x1.3c9d53610d4f8p-10},
        65}},
      // flat concave edges that another part crosses
      {"Collada/human.zae",
       {{0x1.2a23beb952f9bp-6, 0x1.3b63984080dd8p-6, -0x1.028d314b4b43ap-6},
        {-0x1.926d9ef2c8202p-1, -0x1.eec7c3e3b8564p-6, -0x1.f6dfedd37aa63p-2, -0x1.7f54d044445e6p-2}},
       0.0,
       0.0,
       {{-0x1.828ba0e597bc9p-8, 0x1.4fa17ff823186p-5, 0x1.27a7547ed68adp-9},
        {0x1.90e3bff50d56p-11, 0x1.7912cdbc2546bp-5, -0x1.5026dfefef26fp-9},
        97}},
      {"STL/3DSMaxExport.STL",
       {{-0x1.3a2a4119ad084p-6, -0x1.214d0a09da627p-7, 0x1.02be434ad2651p-6},
        {0x1.f7541b53c0832p-2, 0x1.699c751f23e39p-1, 0x1.fd55849fa8341p-3, 0x1.c755ed1eca948p-2}},
       0x1.e3ff3p-4,
       0x1.2ef01ap-4,
       {{0x1.56967ba2c7165p-9, -0x1.7992ac082766bp-8, -0x1.abc7886dfb9bcp-9},
        {0x1.d73f9a0076f19p-10, -0x1.2f8ad02707ff5p-8, -0x1.9cc12aa3ed5c4p-9},
        700}},
      // a sheet on a solid
      {"glTF2/draco/2CylinderEngine.gltf",
       {{0x1.a4edf1419b2a1p-7, 0x1.ab6c4324d4bfbp-8, -0x1.f07cf0d943d15p-7},
        {-0x1.ad2cdf73aa68bp-1, -0x1.3087e8436baacp-3, 0x1.1d985ce5f678fp-7, 0x1.0c9513e2aad2cp-1}},
       0x1.75bf5ap-1,
       0x1.1a9c94p-1,
       {{0x1.f58216e715336p-10, 0x1.0547c34463ec5p-8, -0x1.3db7c067913ccp-6},
        {-0x1.3d870b713f324p-8, 0x1.c0959bb06480cp-8, -0x1.e622f5842b526p-7},
        87}},
  };
  Tally tally;
  for (const Case& c : cases) {
    const host::CompiledMesh mesh = model(test_model_path(c.name), c.name);
    Judge judge(c.name, mesh);
    const Material material{.stiffness_N_m = 1000.0F,
                            .static_friction = static_cast<float>(c.static_friction),
                            .dynamic_friction = static_cast<float>(c.dynamic_friction)};
    IdealRun run(SceneBuilder().mesh(mesh, material, c.pose).image());
    poke(c.way, c.pose, run, judge, tally);
  }
  figure("pokes that fell: ticks in contact", static_cast<double>(tally.in_contact), "> 0");
  figure("pokes that fell: inside a closed part", static_cast<double>(tally.fallen), "0");
  figure("pokes that fell: ticks inside without a contact", static_cast<double>(tally.silent), "0");
  EXPECT_GT(tally.in_contact, 0);
  EXPECT_EQ(tally.fallen, 0);
  EXPECT_EQ(tally.silent, 0);
}

}  // namespace
}  // namespace thimble::test
