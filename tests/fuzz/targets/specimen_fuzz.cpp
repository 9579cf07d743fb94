// Specimens. What is read pushes with a finite force, and never pulls.
#include "board/sim/specimen_file.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  static const fuzz::MemoryFile kFile;
  try {
    const board::Specimen specimen = board::read_specimen(kFile.with(fuzz::text_of({data, size})));
    board::SpecimenGrip grip;
    for (int i = 0; i < 64; ++i) {
      const Eigen::Vector3d tip_m(0.03 * (i % 4) - 0.05, 0.03 * (i / 4 % 4) - 0.05, 0.01 - 0.01 * (i / 16));
      const Eigen::Vector3d velocity_m_s(0.01, -0.02, 0.1 * (i % 2));
      fuzz::demand(specimen.force_N(tip_m, velocity_m_s, grip).allFinite(), "the force is finite");
      specimen.update(tip_m, velocity_m_s, grip);
    }
  } catch (const board::SpecimenError&) {
  }
  return 0;
}
