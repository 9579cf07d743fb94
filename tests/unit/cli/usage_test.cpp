#include "host-tools/cli/usage.h"

#include <gtest/gtest.h>

#include <random>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

TEST(Nearest, IsTheOneWithTheFewestLettersToChange) {
  const std::vector<std::string> names = {"--log", "--path", "--ideal", "--rate", "--arm", "--seed"};
  EXPECT_EQ(nearest("--lgo", names), "--log");
  EXPECT_EQ(nearest("--ideel", names), "--ideal");
  EXPECT_EQ(nearest("--rat", names), "--rate");
  EXPECT_EQ(nearest("--i", names), "--ideal") << "the only one that begins so";
  EXPECT_EQ(nearest("--colour", names), "");
  EXPECT_EQ(nearest("", {}), "");
}

// Any one slip of the finger leads back to the name, as no other one is as near.
TEST(Nearest, FindsANameBehindAnySlip) {
  const std::vector<std::string> names = {"upload", "monitor", "simulate", "commission", "record", "decode"};
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::string& name = names[random() % names.size()];
    std::string word = name;
    const std::size_t at = random() % (word.size() - 1);
    const char other = static_cast<char>('a' + random() % 26);
    switch (random() % 4) {
      case 0:
        word[at] = other;
        break;
      case 1:
        word.erase(at, 1);
        break;
      case 2:
        word.insert(at, 1, other);
        break;
      default:
        std::swap(word[at], word[at + 1]);
    }
    EXPECT_EQ(nearest(word, names), name) << word;
  }
}

class Words : public testing::Test {
 protected:
  Words() {
    CLI::App* run = app_.add_subcommand("run", "");
    run->add_option("scene", scene_)->required();
    run->add_option("--log,-l", log_);
    run->add_option("--at", at_)->expected(3);
    run->add_flag("--fast", fast_);
    CLI::App* param = app_.add_subcommand("param", "");
    param->add_subcommand("get", "")->add_option("name", scene_);
    param->add_subcommand("set", "");
  }
  // Cause and remedy, or "".
  std::string refused(const std::vector<std::string>& words) {
    try {
      refuse_unknown(app_, words);
      return "";
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ExitCode::kUsage);
      return error.cause + "; " + error.remedy;
    }
  }

  CLI::App app_{"", "thimble"};
  std::string scene_, log_;
  std::vector<double> at_;
  bool fast_ = false;
};

TEST_F(Words, UnknownOnesAreNamedWithTheNearest) {
  EXPECT_EQ(refused({"rnu", "x"}),
            "'rnu' is no verb of thimble; did you mean `run`? `thimble --help` has all of them");
  EXPECT_EQ(refused({"dance"}), "'dance' is no verb of thimble; `thimble --help` has all of them");
  EXPECT_EQ(refused({"param", "gte"}),
            "'gte' is no verb of thimble param; did you mean `get`? `thimble param --help` has all of them");
  EXPECT_EQ(
      refused({"run", "--lgo", "x"}),
      "'--lgo' is no option of thimble run; did you mean `--log`? `thimble run --help` has all of them");
  EXPECT_EQ(refused({"run", "--lgo=x"}).substr(0, 7), "'--lgo'");
  EXPECT_EQ(refused({"run", "-x"}).substr(0, 4), "'-x'");
  EXPECT_EQ(refused({"--verbose", "run"}).substr(0, 11), "'--verbose'");
}

TEST_F(Words, KnownOnesAndTheirValuesPass) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{},
                                             {"run", "x", "--log", "--strange-file"},
                                             {"run", "--log=-x", "-lfile", "-l", "-file", "--fast"},
                                             {"run", "-", "-1.5", "-.5"},
                                             {"run", "--", "--anything"},
                                             {"run", "--help"},
                                             {"param", "get", "get"},
                                             {"--help", "run"},
                                             {"param", "--help", "get"},
                                             {"--help"}})
    EXPECT_EQ(refused(words), "");
}

TEST_F(Words, FindTheirVerb) {
  EXPECT_EQ(full_name(*find_verb(app_, {"param", "get", "set"}).verb), "thimble param get");
  EXPECT_EQ(find_verb(app_, {"param", "get", "set"}).words, 2U);
  EXPECT_EQ(full_name(*find_verb(app_, {}).verb), "thimble");
}

}  // namespace
}  // namespace thimble::host
