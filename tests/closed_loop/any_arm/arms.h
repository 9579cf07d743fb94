// The arms that come with Thimble, for the tests of any arm.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"

namespace thimble::test {

inline kinematics::ArmData arm_named(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return host::arm_data(host::read_arm_file({std::istreambuf_iterator<char>(in), {}}, name));
}

// The arm's name as a part of a test's.
inline std::string test_name(const testing::TestParamInfo<const char*>& one) {
  std::string name(one.param);
  std::erase_if(name, [](char c) { return c == '-' || c == '.'; });
  return name;
}

}  // namespace thimble::test
