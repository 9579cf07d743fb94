// Scene images, with the renderer. What is accepted gives finite forces, wherever the tip goes.
#include <algorithm>
#include <cstring>
#include <vector>

#include "tests/fuzz/finite.h"
#include "tests/fuzz/image.h"
#include "tests/fuzz/targets/target.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Half of the mutants keep their length: in a FlatBuffer, bytes that move break every offset.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  using namespace thimble;
  test::Random random(seed);
  if (size < 8 || random.below(2) == 0) return LLVMFuzzerMutate(data, size, most);
  const auto bytes = std::as_bytes(std::span(data, size));
  test::Bytes mutant(bytes.begin(), bytes.end());
  test::spoil(mutant, random);
  std::memcpy(data, mutant.data(), size);
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  const auto bytes = std::as_bytes(std::span(data, size));
  const test::Bytes image(bytes.begin(), bytes.end());
  control::SceneView view;
  if (control::SceneView::check(image, view) != control::ImageStatus::kOk) return 0;
  test::Random random(size);
  fuzz::demand(test::stays_finite(view, random, 100), "the forces are finite");
  return 0;
}
