// A line of needle layers through a volume: synthetic volumes with known layers, every variant of the file
// format, and the volumes of Debian's mricron-data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/error.h"
#include "host-tools/lab/import_volume.h"
#include "tests/support/figure.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/lab/nifti_writer.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using host::ImportChoice;
using host::ImportedNeedle;
using testing::HasSubstr;

class Import : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) const {
    return temporary_.write(name, text);
  }
  fs::path write(const NiftiFile& file) const {
    fs::path path = folder_ / (file.compressed ? "volume.nii.gz" : "volume.nii");
    write_nifti(path, file);
    return path;
  }
  // The error's name and cause.
  static std::pair<std::string, std::string> refusal(const ImportChoice& choice) {
    try {
      static_cast<void>(host::import_volume(choice));
    } catch (const host::Error& error) {
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      return {error.name, error.cause};
    }
    return {"nothing refused", ""};
  }

  const TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

// Layers square to a direction that no axis of the volume has.
const Vector3d kInwards = Vector3d(0.3, -0.2, 0.93).normalized();
struct Known {
  double from_mm;  // along kInwards from the world's origin
  double intensity;
};
constexpr std::array<Known, 5> kBody{{{-1e9, 3}, {0, 60}, {3.5, 100}, {11.0, 30}, {19.0, 80}}};

double body(const Vector3d& p) {
  const double depth_mm = p.dot(kInwards);
  double intensity = 0;
  for (const Known& layer : kBody) {
    if (depth_mm >= layer.from_mm) intensity = layer.intensity;
  }
  return intensity;
}

// About 36 x 24 x 40 mm round the world's origin, turned.
Eigen::Affine3d turned(bool mirrored) {
  Eigen::Affine3d world = Eigen::Affine3d::Identity();
  world.linear() = Eigen::Quaterniond(0.8, 0.2, -0.4, 0.3).normalized().toRotationMatrix() *
                   Vector3d(1.5, 1.2, mirrored ? -1.0 : 1.0).asDiagonal();
  world.translation() = -(world.linear() * Vector3d(11.5, 9.5, 19.5)) + 8.0 * kInwards;
  return world;
}

constexpr double kVoxel_mm = 1.5;  // the longest edge

const char* const kTable =
    "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2\n"
    "air,-1000,20,0,0,0,0\n"
    "# a remark\n"
    "muscle,20,45,500,1.5,0.3,20\n"
    "skin,45,70,800,2,0.2,10\n"
    "organ,70,90,400,1,0.1,30\n"
    "fat,90,1000,300,0.6,0.1,5\n";

ImportChoice through(const fs::path& volume, const fs::path& table) {
  ImportChoice choice;
  choice.volume = volume;
  choice.table = table;
  choice.from = -2.0 * kInwards;
  choice.to = 22.0 * kInwards;
  return choice;
}

// The worst distance of a border from where it is known to be; 1e9 when the layers are others.
double worst_border_mm(const ImportedNeedle& imported) {
  const std::vector<std::string> names{"skin", "fat", "muscle", "organ"};
  if (imported.layers.size() != names.size()) return 1e9;
  double worst = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (imported.kinds[imported.layers[i].kind].name != names[i]) return 1e9;
    worst = std::max(worst, std::abs(imported.layers[i].begin_mm - 2.0 - kBody[i + 1].from_mm));
  }
  return std::max(worst, std::abs(imported.layers.back().end_mm - 24.0));
}

TEST_F(Import, FindsKnownLayersWhateverTheFileIsWrittenIn) {
  const fs::path table = write("tissues.csv", kTable);
  double worst = 0;
  int files = 0;
  for (const int type : {2, 4, 8, 16, 64, 256, 512, 768, 1024, 1280}) {
    for (const bool big : {false, true}) {
      for (const bool compressed : {false, true}) {
        NiftiFile file;
        file.type = type;
        file.big_endian = big;
        file.compressed = compressed;
        file.world = turned(false);
        file.value = body;
        const ImportedNeedle imported = host::import_volume(through(write(file), table));
        EXPECT_EQ(imported.frame, "sform");
        worst = std::max(worst, worst_border_mm(imported));
        ++files;
      }
    }
  }
  figure("data types x byte orders x compression", files, "40");
  figure("farthest border from its place, mm", worst, "within a voxel of 1.5 mm");
  EXPECT_LT(worst, kVoxel_mm);
}

TEST_F(Import, TheWorldIsThatOfSformThenQformThenEdges) {
  const fs::path table = write("tissues.csv", kTable);
  double worst = 0;
  for (const bool mirrored : {false, true}) {
    for (const auto frame : {NiftiFile::Frame::kSform, NiftiFile::Frame::kQform}) {
      for (const unsigned units : {0U, 1U, 2U, 3U}) {
        NiftiFile file;
        file.frame = frame;
        file.units = units;
        file.world = turned(mirrored);
        file.value = body;
        const ImportedNeedle imported = host::import_volume(through(write(file), table));
        EXPECT_EQ(imported.frame, frame == NiftiFile::Frame::kSform ? "sform" : "qform");
        worst = std::max(worst, worst_border_mm(imported));
      }
    }
  }
  figure("farthest border over both frames, mirrored or not, in m, mm and um", worst,
         "within a voxel of 1.5 mm");
  EXPECT_LT(worst, kVoxel_mm);

  NiftiFile file;  // edges alone: the world's origin is the first voxel
  file.frame = NiftiFile::Frame::kPixdim;
  file.world = Eigen::Affine3d(Eigen::Scaling(Vector3d(1.0, 2.0, 0.5)));
  file.value = [](const Vector3d& p) { return p.z() < 4.0 ? 0.0 : p.z() < 9.0 ? 60.0 : 100.0; };
  ImportChoice choice = through(write(file), table);
  choice.from = {10.0, 20.0, 0.0};
  choice.to = {10.0, 20.0, 19.0};
  const ImportedNeedle imported = host::import_volume(choice);
  EXPECT_EQ(imported.frame, "pixdim");
  ASSERT_EQ(imported.layers.size(), 2U);
  EXPECT_NEAR(imported.layers[0].begin_mm, 4.0, 0.5);
  EXPECT_NEAR(imported.layers[1].begin_mm, 9.0, 0.5);

  choice.in_voxels = true;
  choice.from = {10.0, 10.0, 0.0};
  choice.to = {10.0, 10.0, 38.0};
  const ImportedNeedle same = host::import_volume(choice);
  EXPECT_EQ(same.scene, imported.scene) << "voxels and mm name the same line";
}

TEST_F(Import, SlopeAndInterceptAreApplied) {
  const fs::path table = write("tissues.csv", kTable);
  NiftiFile file;
  file.world = turned(false);
  file.value = body;
  file.slope = 0.01;
  file.offset = 2.5;
  EXPECT_LT(worst_border_mm(host::import_volume(through(write(file), table))), kVoxel_mm);
  std::vector<unsigned char> bytes = nifti_bytes(file);
  bytes[115] = 0x7F;  // the slope becomes a NaN: nothing is scaled
  bytes[114] = 0xC0;
  write_bytes(folder_ / "nan.nii", bytes, false);
  ImportChoice choice =
      through(folder_ / "nan.nii",
              write("wide.csv",
                    "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2\nall,-1e9,1e9,1,0,0,0\n"));
  const ImportedNeedle imported = host::import_volume(choice);
  EXPECT_GT(imported.layers[0].mean, 1000.0);
}

TEST_F(Import, WithoutATableTheClassesAreFoundInTheValues) {
  NiftiFile file;
  file.type = 16;
  file.world = turned(false);
  file.value = [](const Vector3d& p) {  // noise of known values: 10 % of the gap between the nearest layers
    return body(p) + 2.0 * std::sin(37.0 * p.x() + 91.0 * p.y() + 53.0 * p.z());
  };
  ImportChoice choice = through(write(file), {});
  choice.table.reset();
  choice.classes = 5;
  const ImportedNeedle imported = host::import_volume(choice);
  ASSERT_EQ(imported.kinds.size(), 5U);
  EXPECT_EQ(imported.kinds[0].name, "air");
  ASSERT_EQ(imported.layers.size(), 4U);
  double worst = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    worst = std::max(worst, std::abs(imported.layers[i].begin_mm - 2.0 - kBody[i + 1].from_mm));
    EXPECT_NEAR(imported.layers[i].mean, kBody[i + 1].intensity, 2.0);
  }
  figure("k-means, noisy volume: farthest border, mm", worst, "within a voxel of 1.5 mm");
  EXPECT_LT(worst, kVoxel_mm);
}

TEST(KMeans, IsTheBestOfAllCuts) {
  // Every way to cut 12 sorted values into 3 classes, by brute force.
  const std::vector<double> values{1, 1, 2, 7, 7.5, 8, 8, 9, 20, 21, 21.5, 30};
  const auto squares = [&](std::size_t begin, std::size_t end) {
    double mean = 0;
    for (std::size_t i = begin; i < end; ++i) mean += values[i] / static_cast<double>(end - begin);
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += (values[i] - mean) * (values[i] - mean);
    return sum;
  };
  double best = 1e9;
  std::pair<std::size_t, std::size_t> cut;
  for (std::size_t a = 1; a < 11; ++a) {
    for (std::size_t b = a + 1; b < 12; ++b) {
      const double sum = squares(0, a) + squares(a, b) + squares(b, 12);
      if (sum < best) {
        best = sum;
        cut = {a, b};
      }
    }
  }
  const std::vector<host::TissueKind> kinds = host::kinds_by_k_means(values, 3);
  ASSERT_EQ(kinds.size(), 3U);
  EXPECT_DOUBLE_EQ(kinds[1].from, 0.5 * (values[cut.first - 1] + values[cut.first]));
  EXPECT_DOUBLE_EQ(kinds[2].from, 0.5 * (values[cut.second - 1] + values[cut.second]));
  EXPECT_EQ(host::kinds_by_k_means({4, 4, 4}, 5).size(), 1U) << "no more classes than values";
}

TEST_F(Import, ThinLayersJoinTheNeighbourThatIsLikeThem) {
  NiftiFile file;
  file.world = Eigen::Affine3d::Identity();
  file.value = [](const Vector3d& p) {
    const double z = p.z();
    if (z < 10) return 60.0;
    if (z < 12) return 75.0;  // 2 mm: nearer to 60 than to 100
    return 100.0;
  };
  const fs::path table = write("tissues.csv",
                               "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2\n"
                               "low,0,70,500,1,0,0\nmiddle,70,90,500,1,0,0\nhigh,90,200,500,1,0,0\n");
  ImportChoice choice = through(write(file), table);
  choice.from = {5, 5, 0};
  choice.to = {5, 5, 30};
  choice.thinnest_mm = 1.0;
  EXPECT_EQ(host::import_volume(choice).layers.size(), 3U);
  choice.thinnest_mm = 3.0;
  const ImportedNeedle merged = host::import_volume(choice);
  ASSERT_EQ(merged.layers.size(), 2U);
  EXPECT_NEAR(merged.layers[0].end_mm, 11.5, 0.5) << "to the layer whose mean is nearer";
  const auto scene = nlohmann::json::parse(merged.scene);
  EXPECT_EQ(scene["objects"][0]["shape"]["needle"]["layers"][0]["name"], "low");
}

TEST_F(Import, WhatIsNoSuchVolumeIsRefusedByName) {
  const fs::path table = write("tissues.csv", kTable);
  NiftiFile file;
  file.world = turned(false);
  file.value = body;
  const std::vector<unsigned char> sound = nifti_bytes(file);
  struct Case {
    std::string name;
    std::string part;
    std::function<void(std::vector<unsigned char>&)> change;
  };
  const auto set = [](std::size_t at, const std::vector<unsigned char>& values) {
    return [at, values](std::vector<unsigned char>& bytes) {
      std::copy(values.begin(), values.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    };
  };
  const std::vector<unsigned char> nan{0, 0, 0xC0, 0x7F};
  const std::vector<Case> cases{
      {"nothing refused", "", [](auto&) {}},
      {"not-nifti", "is not a NIfTI-1 file", [](auto& bytes) { bytes.clear(); }},
      {"not-nifti", "is not a NIfTI-1 file", [](auto& bytes) { bytes.resize(100); }},
      {"not-nifti", "is not a NIfTI-1 file", set(0, {1, 2, 3, 4})},
      {"unsupported-volume", "NIfTI-2", set(0, {0x1C, 0x02, 0, 0})},
      {"unsupported-volume", "NIfTI-2", set(0, {0, 0, 0x02, 0x1C})},
      {"unsupported-volume", "a pair of files", set(344, {'n', 'i', '1', 0})},
      {"not-nifti", "ANALYZE", set(344, {0, 0, 0, 0})},
      {"unsupported-volume", "has 2 dimensions", set(40, {2, 0})},
      {"unsupported-volume", "has 0 samples along dimension 2", set(44, {0, 0})},
      {"unsupported-volume", "has -1 samples along dimension 1", set(42, {0xFF, 0xFF})},
      {"unsupported-volume", "has 9 samples along dimension 4",
       [&](auto& bytes) { bytes[40] = 4, bytes[48] = 9; }},
      {"unsupported-volume", "data type 128", set(70, {128, 0})},
      {"unsupported-volume", "data type 32", set(70, {32, 0})},
      {"unsupported-volume", "MiB of voxels", set(42, {0xFF, 0x7F, 0xFF, 0x7F, 0xFF, 0x7F})},
      {"bad-volume", "vox_offset", set(108, {0, 0, 0, 0})},
      {"bad-volume", "vox_offset", set(108, nan)},
      {"bad-volume", "xyzt_units is 5", set(123, {5})},
      {"bad-volume", "sform gives voxels without a volume", set(280, nan)},
      {"bad-volume", "sform gives voxels without a volume",
       [](auto& bytes) { std::fill(bytes.begin() + 280, bytes.begin() + 296, 0); }},
      {"truncated-volume", "ends after", [](auto& bytes) { bytes.pop_back(); }},
      {"truncated-volume", "ends after 348 of", [](auto& bytes) { bytes.resize(348); }},
  };
  for (const Case& c : cases) {
    for (const bool compressed : {false, true}) {
      std::vector<unsigned char> bytes = sound;
      c.change(bytes);
      const fs::path path = folder_ / (compressed ? "changed.nii.gz" : "changed.nii");
      if (bytes.empty() && compressed) continue;
      write_bytes(path, bytes, compressed);
      const auto [name, cause] = refusal(through(path, table));
      EXPECT_EQ(name, c.name) << cause;
      EXPECT_THAT(cause, HasSubstr(c.part));
    }
  }
  figure("kinds of files tried", static_cast<double>(cases.size()),
         "each refused by name, plain and compressed");

  EXPECT_EQ(refusal(through(folder_ / "absent.nii", table)).first, "missing-volume");
  EXPECT_EQ(refusal(through(folder_, table)).first, "missing-volume");
  // A compressed file that is damaged, and one cut off.
  write_bytes(folder_ / "whole.nii.gz", sound, true);
  std::ifstream whole(folder_ / "whole.nii.gz", std::ios::binary);
  const std::string packed((std::istreambuf_iterator<char>(whole)), std::istreambuf_iterator<char>());
  std::string damaged = packed;
  for (std::size_t i = packed.size() / 2; i < packed.size() / 2 + 40; ++i) damaged[i] = '\x5A';
  EXPECT_THAT(refusal(through(write("damaged.nii.gz", damaged), table)).first,
              testing::AnyOf("bad-volume", "truncated-volume"));
  EXPECT_EQ(refusal(through(write("cut.nii.gz", packed.substr(0, packed.size() / 2)), table)).first,
            "truncated-volume");
}

TEST_F(Import, LinesAndTablesThatCannotBeUsedAreRefused) {
  const fs::path table = write("tissues.csv", kTable);
  NiftiFile file;
  file.world = turned(false);
  file.value = body;
  const fs::path volume = write(file);
  ImportChoice choice = through(volume, table);
  choice.to = 100.0 * kInwards;
  auto [name, cause] = refusal(choice);
  EXPECT_EQ(name, "outside-volume");
  EXPECT_THAT(cause, HasSubstr("it reaches from "));
  choice.to = choice.from;
  EXPECT_EQ(refusal(choice).first, "bad-line");
  choice.to = Vector3d(1e9, 0, 0);
  EXPECT_EQ(refusal(choice).first, "bad-line");
  choice = through(volume, table);
  choice.to = -1.0 * kInwards;
  EXPECT_EQ(refusal(choice).first, "no-tissue");

  const std::string header = "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2\n";
  const std::vector<std::pair<std::string, std::string>> tables{
      {"", "has no tissue"},
      {header, "has no tissue"},
      {"name,from,to\n", "bad.csv:1: column 'stiffness_N_m' is missing; the header is name,from,to,"},
      {header + "a,0,1\n", "bad.csv:2: 3 cells where the header has 7"},
      {header + "a,0,x,1,1,1,1\n", "bad.csv:2: to is 'x', allowed is a number from"},
      {header + "a,0,nan,1,1,1,1\n", "to is 'nan'"},
      {header + "a,0,1,-1,1,1,1\n", "stiffness_N_m is '-1', allowed is a number from 0 to 100000"},
      {header + "a,0,1,1,1000,1,1\n", "tear_N is '1000'"},
      {header + "a,0,1,1,1,101,1\n", "friction_N is '101'"},
      {header + "a,0,1,1,1,1,1e9\n", "viscosity_N_s_m2 is '1e9'"},
      {header + "a,1,1,1,1,1,1\n", "from is not below to"},
      {header + "a,0,1,0,1,1,1\n", "has no stiffness"},
      {header + ",0,1,1,1,1,1\n", "name is not a text"},
      {header + "a,0,10,1,1,1,1\nb,9,20,1,1,1,1\n", "bad.csv:3: b overlaps a in intensity"},
  };
  for (const auto& [text, part] : tables) {
    const auto [error, why] = refusal(through(volume, write("bad.csv", text)));
    EXPECT_EQ(error, "bad-layers") << text;
    EXPECT_THAT(why, HasSubstr(part));
  }
  EXPECT_EQ(refusal(through(volume, folder_ / "absent.csv")).first, "bad-layers");
  const auto [unknown, where] = refusal(through(volume, write("few.csv", header + "air,0,10,0,0,0,0\n")));
  EXPECT_EQ(unknown, "unknown-intensity");
  EXPECT_THAT(where, HasSubstr("the intensity 60 at "));

  file.value = [](const Vector3d& p) { return std::fmod(std::abs(p.z()), 0.6) < 0.3 ? 60.0 : 100.0; };
  file.world = Eigen::Affine3d(Eigen::Scaling(0.3));
  file.size = {4, 4, 100};
  choice = through(write(file), table);
  choice.from = {0.3, 0.3, 0.0};
  choice.to = {0.3, 0.3, 29.0};
  choice.thinnest_mm = 0.0;
  EXPECT_EQ(refusal(choice).first, "too-many-layers");

  file.type = 16;
  file.value = [](const Vector3d& p) { return p.z() > 10.0 ? std::nan("") : 60.0; };
  choice = through(write(file), table);
  choice.from = {0.3, 0.3, 0.0};
  choice.to = {0.3, 0.3, 29.0};
  EXPECT_THAT(refusal(choice).second, HasSubstr("is no number"));
}

TEST_F(Import, TheVolumesOfMricronDataBecomeScenes) {
  const fs::path templates = "/usr/share/mricron/templates";
  ASSERT_TRUE(fs::exists(templates / "ch2.nii.gz")) << "the package mricron-data is missing";
  // Into a head from above at the midline: skin, skull, brain.
  ImportChoice choice;
  choice.volume = templates / "ch2.nii.gz";
  choice.from = {20, -20, 88};
  choice.to = {5, -10, 20};
  choice.table = write("head.csv",
                       "name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2\n"
                       "dark,-1,25,0,0,0.05,5\ngrey,25,75,250,0.4,0.1,15\nbright,75,256,600,1.6,0.2,10\n");
  const ImportedNeedle head = host::import_volume(choice);
  EXPECT_EQ(head.frame, "sform");
  EXPECT_GE(head.layers.size(), 3U);
  EXPECT_LT(head.layers[0].begin_mm, 10.0) << "the scalp is at the top of the head";
  figure("layers in ch2 from the crown inwards", static_cast<double>(head.layers.size()), "at least 3");

  int volumes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(templates)) {
    if (!entry.path().string().ends_with(".nii.gz")) continue;
    const host::Volume volume = host::Volume::read(entry.path());
    ImportChoice any;
    any.volume = entry.path();
    any.in_voxels = true;
    const Vector3d last = (volume.size().array() - 1).cast<double>();
    any.from = {last.x() / 3, last.y() / 2, 0};
    any.to = {last.x() / 3, last.y() / 2, last.z()};
    any.thinnest_mm = 8.0;
    EXPECT_NO_THROW(EXPECT_FALSE(host::import_volume(any).layers.empty())) << entry.path();
    ++volumes;
  }
  figure("volumes of mricron-data, each a scene that compiles", volumes, "at least 13");
  EXPECT_GE(volumes, 13);
}

}  // namespace
}  // namespace thimble::test
