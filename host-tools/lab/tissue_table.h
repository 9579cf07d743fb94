// Tissues by intensity: which values of a volume belong to which tissue, and its mechanical properties. Read from the user's file, or
// invented if there is none.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace thimble::host {

struct TissueKind {
  std::string name;
  double from = 0;  // holds the values from <= value < to
  double to = 0;
  double stiffness_N_m = 0;  // 0: a gap, such as air: nothing tears there
  double tear_N = 0;
  double friction_N = 0;
  double viscosity_N_s_m2 = 0;
};

// CSV with the header `name,from,to,stiffness_N_m,tear_N,friction_N,viscosity_N_s_m2`, in any order. Throws Error (bad-layers, with
// file and line): what is no number, not in its range, an empty or overlapping range.
[[nodiscard]] std::vector<TissueKind> read_tissue_table(const std::filesystem::path& file);

// The kind whose range holds the value.
[[nodiscard]] std::optional<std::size_t> kind_of(const std::vector<TissueKind>& kinds, double value);

// At most `count` kinds from the values themselves: the classes of one-dimensional k-means, found exactly by dynamic programming (Wang and
// Song 2011, Ckmeans.1d.dp), in rising order. Their properties are invented: stiffer and tougher with intensity; the lowest is a gap. values:
// not empty, finite.
[[nodiscard]] std::vector<TissueKind> kinds_by_k_means(std::vector<double> values, std::size_t count);

}  // namespace thimble::host
