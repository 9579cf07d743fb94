// A part of a page in docs/ that a test generates: between <!-- NAME begin --> and <!-- NAME end -->.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace thimble::test {

// Compares what the page has between the marks with `meant`. With THIMBLE_WRITE_DOCS set it is written instead. `page`: below the
// project's folder.
inline void expect_generated(const std::string& page, const std::string& name, const std::string& meant) {
  const std::string file = (std::filesystem::path(THIMBLE_SOURCE_DIR) / page).string();
  const std::string begin = "<!-- " + name + " begin -->\n";
  const std::string end = "\n<!-- " + name + " end -->";
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t from = text.find(begin);
  const std::size_t to = text.find(end);
  ASSERT_TRUE(from != std::string::npos && to != std::string::npos) << file << " lost its marks";
  const std::string written = text.substr(from + begin.size(), to - from - begin.size());
  if (std::getenv("THIMBLE_WRITE_DOCS") != nullptr) {
    std::ofstream(file) << text.replace(from + begin.size(), written.size(), meant);
    return;
  }
  EXPECT_EQ(written, meant) << "write it anew: run this test with THIMBLE_WRITE_DOCS=1";
}

}  // namespace thimble::test
