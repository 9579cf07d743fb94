// The error of the compiler for input that it refuses.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <string>

#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"

namespace thimble::test {

struct Refusal {
  std::string name;
  std::string cause;
};

// Its name is "nothing refused" when `read()` goes through.
template <typename Read>
[[nodiscard]] Refusal refusal_of(Read&& read) {
  try {
    read();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.code, host::ExitCode::kBadInput);
    EXPECT_FALSE(error.remedy.empty());
    return {error.name, error.cause};
  }
  return {"nothing refused", ""};
}

[[nodiscard]] inline Refusal refusal_of_scene(const std::string& text, const std::filesystem::path& folder) {
  return refusal_of([&] { static_cast<void>(host::compile_scene_text(text, "test.scene.json", folder)); });
}

// `text` with the first `from` in it made `to`; there must be one.
[[nodiscard]] inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace thimble::test
