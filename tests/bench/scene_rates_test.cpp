#include "tests/bench/scene_rates.h"

#include <gtest/gtest.h>

#include "tests/support/generated_docs.h"

namespace thimble::test {
namespace {

TEST(SceneRates, DocsHaveThem) { expect_generated("docs/bench.md", "rates", scene_rates("all")); }

TEST(SceneRates, ACoreByItself) {
  EXPECT_NE(core_names().find("a8-1000"), std::string::npos);
  EXPECT_EQ(scene_rates("a9"), "");
}

}  // namespace
}  // namespace thimble::test
