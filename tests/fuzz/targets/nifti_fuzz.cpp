// NIfTI volumes, compressed or not, and a line through them.
#include "host-tools/error.h"
#include "host-tools/lab/tissue_layers.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  static const fuzz::MemoryFile kFile;
  try {
    const host::Volume volume = host::Volume::read(kFile.with(fuzz::text_of({data, size})));
    const Eigen::Vector3i last = volume.size() - Eigen::Vector3i::Ones();
    fuzz::demand(volume.holds(Eigen::Vector3i::Zero()) && volume.holds(last), "it holds its corners");
    fuzz::demand(!volume.holds(volume.size()), "it ends");
    static_cast<void>(volume.at(Eigen::Vector3i::Zero()) + volume.at(last));
    const auto world_mm = [&](const Eigen::Vector3i& voxel) -> Eigen::Vector3d {
      return volume.world() * voxel.cast<double>();
    };
    const host::LineProfile profile =
        host::profile_along(volume, world_mm(Eigen::Vector3i::Zero()), world_mm(last), "volume");
    const auto kinds = host::kinds_by_k_means(
        {profile.values.begin(), profile.values.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                              profile.values.size(), std::size_t{64}))},
        4);
    fuzz::demand(!kinds.empty() && kinds.size() <= 4, "there is a tissue");
    static_cast<void>(host::layers_of(profile, kinds, 2.0));
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad volume is bad input");
  }
  return 0;
}
