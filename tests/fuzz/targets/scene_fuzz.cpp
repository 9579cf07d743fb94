// Scene files. What compiles is an image that the controller accepts, the same one each time, and with finite forces.
#include <vector>

#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/fuzz/finite.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  const std::string text(fuzz::text_of({data, size}));
  host::CompiledScene scene;
  try {
    scene = host::compile_scene_text(text, "scene", THIMBLE_FUZZ_FILES);
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput && !error.cause.empty() && !error.remedy.empty(),
                 "a refusal has a cause and a remedy");
    return 0;
  }
  control::SceneView view;
  fuzz::demand(control::SceneView::check(scene.image, view) == control::ImageStatus::kOk,
               "the controller accepts what the compiler writes");
  test::Random random(size);
  fuzz::demand(test::stays_finite(view, random, 50), "the forces are finite");
  fuzz::demand(host::compile_scene_text(text, "scene", THIMBLE_FUZZ_FILES).image == scene.image,
               "the same text gives the same bytes");
  return 0;
}
