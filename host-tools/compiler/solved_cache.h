// Results that take long to compute, kept between the runs of a program. The compiler keeps solved potentials here.
//
// A folder of the user's own (mode 0700, no symbolic link) with a file for each result, whole or not at all; several programs may use it
// at once. A cache never fails: without a folder that it may use, and with an entry that is damaged, the result is computed again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace thimble::host {

class SolvedCache {
 public:
  static constexpr std::uintmax_t kMostBytes = std::uintmax_t{256}
                                               << 20U;  // then the entries unused for longest are removed

  // An empty path: nothing is kept.
  explicit SolvedCache(std::filesystem::path folder, std::uintmax_t most_bytes = kMostBytes)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}

  // $XDG_CACHE_HOME/thimble or ~/.cache/thimble; empty without both.
  [[nodiscard]] static std::filesystem::path user_folder();

  // Bytes. The key is everything that the result depends on; it is compared as a whole.
  [[nodiscard]] std::optional<std::string> find(std::string_view key) const;
  void keep(std::string_view key, std::string_view value) const;

 private:
  std::filesystem::path folder_;
  [[maybe_unused]] std::uintmax_t most_bytes_;  // not by no_solved_cache.cpp
};

}  // namespace thimble::host
