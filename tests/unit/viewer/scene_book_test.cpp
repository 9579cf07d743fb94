// The list of scenes: found by the CRC of their image, changed and saved.
#include "host-tools/viewer/scene_book.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/support/temporary_folder.h"

namespace thimble::host {
namespace {

namespace fs = std::filesystem;

std::string scene_text(const std::string& name, double stiffness_N_m = 800) {
  return R"({"thimble_scene": 1, "name": ")" + name +
         R"(", "description": "two walls of one material", "objects": [
    {"name": "left", "shape": {"plane": {"normal": [1, 0, 0], "offset_m": -0.03}}, "material": "wall"},
    {"name": "right", "shape": {"plane": {"normal": [-1, 0, 0], "offset_m": -0.03}}, "material": "wall"}],
    "materials": {"wall": {"stiffness_N_m": )" +
         std::to_string(stiffness_N_m) + R"(, "damping_N_s_m": 1, "static_friction": 0.1}}})";
}

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

std::string read(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(SceneBook, FindsScenesByNameAndByCrc) {
  const test::TemporaryFolder folder;
  write(folder.path() / "a" / "a.scene.json", scene_text("walls", 500));
  write(folder.path() / "b.scene.json", scene_text("walls", 600));
  write(folder.path() / "c.scene.json", "{");
  write(folder.path() / "d.scene.json", scene_text("walls", -1));
  write(folder.path() / "e.json", scene_text("walls"));
  SceneBook book({folder.path(), folder.path() / "nowhere"});
  std::string names;
  for (const auto& [name, file] : book.list()) names += name + " ";
  EXPECT_EQ(names, "a b c d ");
  EXPECT_EQ(book.find("a"), folder.path() / "a" / "a.scene.json");
  EXPECT_THROW(static_cast<void>(book.find("../a/a")), Error);

  const OpenScene a = open_scene(book.find("a"));
  const OpenScene b = open_scene(book.find("b"));
  EXPECT_NE(a.crc, b.crc);
  EXPECT_EQ(book.with_crc("walls", a.crc)->file, a.file);
  EXPECT_EQ(book.with_crc("walls", b.crc)->file, b.file);
  EXPECT_FALSE(book.with_crc("walls", a.crc + 1));
  EXPECT_FALSE(book.with_crc("doors", a.crc));
  // A file that has changed since is compiled again.
  write(a.file, scene_text("walls", 700));
  fs::last_write_time(a.file, a.file_time + std::chrono::seconds(2));
  EXPECT_FALSE(book.with_crc("walls", a.crc));
  EXPECT_EQ(book.with_crc("walls", open_scene(a.file).crc)->file, a.file);
}

TEST(SceneBook, AMaterialOfOneObject) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "walls.scene.json";
  write(file, scene_text("walls"));
  OpenScene scene = open_scene(file);
  EXPECT_EQ(scene_json(*scene.image, scene.crc)["objects"][1], Json::parse(R"({"name": "right", "material":
              {"stiffness": 800, "damping": 1, "static_friction": 0.1, "dynamic_friction": 0.1}})"))
      << scene_json(*scene.image, scene.crc);
  const std::uint32_t before = scene.crc;
  set_material(scene, {1, "stiffness_N_m", 300});
  compile_changes(scene);
  EXPECT_NE(scene.crc, before);
  const Json objects = scene_json(*scene.image, scene.crc)["objects"];
  EXPECT_EQ(objects[0]["material"]["stiffness"], 800);
  EXPECT_EQ(objects[1]["material"]["stiffness"], 300);

  set_material(scene, {0, "static_friction", -1});
  const ImageBytes good = scene.image;
  EXPECT_THROW(compile_changes(scene), Error);
  EXPECT_EQ(scene.image, good);
  EXPECT_THROW(set_material(scene, {2, "stiffness_N_m", 300}), Error);
  set_material(scene, {0, "static_friction", 0.2});

  save_scene(scene);
  EXPECT_EQ(open_scene(file).crc, (compile_changes(scene), scene.crc));
  EXPECT_NE(read(file).find("two walls of one material"), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  fs::last_write_time(file, scene.file_time + std::chrono::seconds(2));
  EXPECT_THROW(save_scene(scene), Error) << "somebody else wrote it";
  fs::remove(file);
  EXPECT_THROW(save_scene(scene), Error);
  EXPECT_FALSE(fs::exists(file));
}

TEST(SceneBook, PrettyIsAsPeopleWrite) {
  const Json json = Json::parse(R"({"a": [1, 2.5, 3], "b": {}, "c": []})");
  EXPECT_EQ(pretty(json), "{\n  \"a\": [1, 2.5, 3],\n  \"b\": {},\n  \"c\": []\n}\n");
  const Json deep = Json::parse(scene_text("walls"));
  EXPECT_EQ(Json::parse(pretty(deep)), deep);
  std::size_t longest = 0, at = 0;
  for (const char c : pretty(deep)) longest = std::max(longest, at = c == '\n' ? 0 : at + 1);
  EXPECT_LE(longest, 120U);
}

}  // namespace
}  // namespace thimble::host
