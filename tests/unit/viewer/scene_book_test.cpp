// The list of scenes: found by the CRC of their image, changed and saved.
#include "host-tools/viewer/scene_book.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <utility>

#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/compile_help.h"
#include "tests/support/sanitizers.h"
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
  fs::last_write_time(a.file, fs::last_write_time(a.file) + std::chrono::seconds(2));
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
  write(file, read(file) + " ");
  EXPECT_THROW(save_scene(scene), Error) << "somebody else wrote it";
  fs::remove(file);
  EXPECT_THROW(save_scene(scene), Error);
  EXPECT_FALSE(fs::exists(file));
}

// What tests of scene_text.h show for the text, for the file.
TEST(SceneBook, SavingKeepsWhatWasNotChanged) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "walls.scene.json";
  const std::string text =
      "// by hand\r\n{\t\"thimble_scene\": 1, \"name\": \"walls\", /* two */\r\n"
      "\"materials\": {\"wall\":\t{\"stiffness_N_m\": 800.0, \"damping_N_s_m\": 1}},\r\n\"objects\": [\r\n"
      "\t{\"name\": \"left\", \"shape\": {\"plane\": {\"normal\": [1, 0, 0], \"offset_m\": -3e-2}}, "
      "\"material\": "
      "\"wall\"},\r\n"
      "\t{\"name\": \"right\", \"shape\": {\"plane\": {\"normal\": [-1, 0, 0], \"offset_m\": -0.030}},\r\n"
      "\t \"material\": {\"stiffness_N_m\": 700, // softer\r\n\t\t\"damping_N_s_m\": 1.0}}]}\r\n";
  write(file, text);
  OpenScene scene = open_scene(file);
  set_material(scene, {1, "stiffness_N_m", 650});
  set_material(scene, {0, "stiffness_N_m", 500});
  set_material(scene, {0, "stiffness_N_m", 800});  // as it was
  compile_changes(scene);
  save_scene(scene);
  std::string expected = text;
  expected.replace(expected.find("700"), 3, "650");
  EXPECT_EQ(read(file), expected);
  EXPECT_TRUE(scene.changed_materials.empty());
  save_scene(scene);
  EXPECT_EQ(read(file), expected);
}

TEST(SceneBook, ADraftIsSavedAsItIsWritten) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "walls.scene.json";
  write(file, scene_text("walls"));
  OpenScene scene = open_scene(file);
  const std::string draft = "// by hand\r\n" + scene_text("walls", 650) + "\n\n";
  scene.draft = draft;
  set_material(scene, {1, "damping_N_s_m", 2});
  compile_changes(scene);
  EXPECT_EQ(scene_json(*scene.image, scene.crc)["objects"][0]["material"]["stiffness"], 650);
  EXPECT_TRUE(has_changes(scene));
  EXPECT_EQ(read(file), scene_text("walls")) << "nothing is saved yet";
  const std::string expected = changed_text(scene);
  EXPECT_TRUE(expected.starts_with("// by hand\r\n")) << expected;

  // Somebody else writes the file: neither is lost unless that is wanted.
  write(file, scene_text("walls", 700));
  EXPECT_THROW(save_scene(scene), Error);
  EXPECT_EQ(read(file), scene_text("walls", 700));
  EXPECT_TRUE(has_changes(scene));
  save_scene(scene, true);
  EXPECT_EQ(read(file), expected);
  EXPECT_FALSE(has_changes(scene));
}

TEST(SceneBook, AFileIsPutBesideAndReplacesNone) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "walls.scene.json";
  write(file, scene_text("walls"));
  const OpenScene scene = open_scene(file);
  put_file(scene, {"part.obj", "v 0 0 0\n"});
  put_file(scene, {"part.obj", "v 0 0 0\n"});  // the same again
  EXPECT_EQ(read(folder.path() / "part.obj"), "v 0 0 0\n");
  EXPECT_THROW(put_file(scene, {"part.obj", "v 1 0 0\n"}), Error);
  EXPECT_EQ(read(folder.path() / "part.obj"), "v 0 0 0\n");
  fs::create_symlink("nowhere", folder.path() / "link.obj");
  EXPECT_THROW(put_file(scene, {"link.obj", "v 0 0 0\n"}), Error);
  EXPECT_FALSE(fs::exists(folder.path() / "nowhere"));
}

TEST(SceneBook, AFileThatHasChangedKeepsWhatIsNotSaved) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "walls.scene.json";
  write(file, scene_text("walls"));
  OpenScene scene = open_scene(file);
  set_material(scene, {1, "stiffness_N_m", 300});
  set_material(scene, {0, "damping_N_s_m", 2});
  compile_changes(scene);
  // The objects change places, and one its name.
  std::string text = scene_text("walls", 900);
  text.replace(text.find("\"left\""), 6, "\"right\"");
  text.replace(text.rfind("\"right\""), 7, "\"other\"");
  write(file, text);
  const OpenScene again = reopen_scene(scene);
  const Json objects = scene_json(*again.image, again.crc)["objects"];
  EXPECT_EQ(objects[0]["material"]["stiffness"], 300);
  EXPECT_EQ(objects[0]["material"]["damping"], 1);
  EXPECT_EQ(objects[1]["material"]["stiffness"], 900);
  write(file, "{");
  EXPECT_THROW(static_cast<void>(reopen_scene(scene)), Error);
}

TEST(SceneBook, AChangedFileIsSeenWhenItHasSettled) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "a.scene.json";
  write(file, "one");
  FileWatch watch;
  const auto looks = [&](const std::string& known) {
    std::string seen;
    for (int i = 0; i < 4; ++i) seen += watch.has_changed(file, known) ? '1' : '0';
    return seen;
  };
  EXPECT_EQ(looks("one"), "0000");
  write(file, "four");
  EXPECT_EQ(looks("one"), "0100") << "once";
  // Another with the same size and an older time, by its name.
  write(folder.path() / "draft", "five");
  fs::last_write_time(folder.path() / "draft", fs::last_write_time(file) - std::chrono::hours(1));
  fs::rename(folder.path() / "draft", file);
  EXPECT_EQ(looks("four"), "0100");
  // Put away, and written in several steps.
  fs::rename(file, folder.path() / "away");
  EXPECT_EQ(looks("five"), "0000");
  write(file, "f");
  EXPECT_FALSE(watch.has_changed(file, "five"));
  write(file, "fi");
  EXPECT_FALSE(watch.has_changed(file, "five"));
  write(file, "six");
  EXPECT_EQ(looks("five"), "0100");
  // Touched only.
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::hours(1));
  EXPECT_EQ(looks("six"), "0000");
}

// A slider of a page is felt after a compilation and an upload: no solving, and no mesh, is part of the compilation.
TEST(SceneBook, AChangeOfAMaterialComputesNothingAgain) {
  int steps = 0;  // of what takes long: those between the beginning and the end of an object
  set_compile_help(
      {std::nullopt, [&steps](const std::string&, double share) { steps += share > 0.0 && share < 1.0; }});
  const auto cpu_ms = [] {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1.0e3 * static_cast<double>(now.tv_sec) + 1.0e-6 * static_cast<double>(now.tv_nsec);
  };
  int steps_of_all = 0;
  std::printf("%-28s %12s %12s\n", "scene", "open, ms", "change, ms");
  for (const auto& [name, file] : SceneBook({fs::path(THIMBLE_SOURCE_DIR) / "scenes"}).list()) {
    double begun_ms = cpu_ms();
    const OpenScene opened = open_scene(file);
    const double open_ms = cpu_ms() - begun_ms;
    steps_of_all += std::exchange(steps, 0);
    double slowest_ms = 0;
    for (const std::size_t object : {std::size_t{0}, opened.objects.size() - 1}) {
      for (const char* key : {"stiffness_N_m", "damping_N_s_m", "static_friction", "dynamic_friction"}) {
        double fastest_ms = 1.0e9;  // of three: what else the machine does
        for (int run = 0; run < 3; ++run) {
          OpenScene scene = opened;
          if (key == std::string("dynamic_friction")) set_material(scene, {object, "static_friction", 1.5});
          set_material(scene, {object, key,
                               key == std::string("stiffness_N_m")     ? 401.5
                               : key == std::string("static_friction") ? 1.5
                                                                       : 0.4375});
          begun_ms = cpu_ms();
          compile_changes(scene);
          fastest_ms = std::min(fastest_ms, cpu_ms() - begun_ms);
          EXPECT_EQ(steps, 0) << name;
          // Those parts do not change the image.
          if (run != 0) continue;
          EXPECT_EQ(*scene.image, compile_scene_text(changed_text(scene), name, file.parent_path()).image);
          steps = 0;
        }
        slowest_ms = std::max(slowest_ms, fastest_ms);
      }
    }
    std::printf("%-28s %12.1f %12.1f\n", name.c_str(), open_ms, slowest_ms);
    if (!test::kUnderSanitizers) {
      EXPECT_LT(slowest_ms, 100.0) << name;
    }
  }
  EXPECT_GT(steps_of_all, 10);
  set_compile_help({});
}

}  // namespace
}  // namespace thimble::host
