// Configurations of an embedded Linux board. What is read names arm models that there are, and values that the controller takes.
#include "board/linux/board_config.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  try {
    const board::BoardConfig config =
        board::parse_board_config(std::string(fuzz::text_of({data, size})), "board.json");
    fuzz::demand(!config.arms.empty() && config.arms.size() <= 2, "there are one or two arms");
    for (const board::ArmWiring& arm : config.arms) fuzz::demand(!arm.model.empty(), "an arm has a model");
    fuzz::demand(config.node >= 1 && config.node <= 127, "the node is one of the link's");
    fuzz::demand(config.rate_Hz >= 50 && config.rate_Hz <= 25000, "the controller takes the period");
    fuzz::demand(config.settle_s >= 0 && config.settle_s <= 1, "a contact is read at some time");
  } catch (const board::ConfigError&) {
  }
  return 0;
}
