// gpio_test CHIP_A CHIP_B: board/linux/gpio.h against two simulated GPIO chips, whose folders in sysfs are given; lines A0 to A3 and B0
// to B3. In the virtual machine only; built against libgpiod 1 and 2 alike. Exit code 1: it says what is wrong.
#include "board/linux/gpio.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using thimble::board::GpioBias;
using thimble::board::GpioError;
using thimble::board::GpioInputs;
using thimble::board::GpioLine;
using thimble::board::GpioOutput;

int checks = 0;

void check(bool right, const std::string& what) {
  ++checks;
  if (!right) throw std::runtime_error(what);
}

std::array<std::string, 2> chips;

std::string file_of(const std::string& line, const char* file) {
  return chips[line[0] == 'A' ? 0 : 1] + "/sim_gpio" + line[1] + "/" + file;
}
// The irq of a simulated line comes by way of a work queue.
void settle() { usleep(20'000); }
void pull(const std::string& line, bool up) {
  std::ofstream(file_of(line, "pull")) << (up ? "pull-up" : "pull-down");
}
bool value(const std::string& line) {
  int level = 0;
  std::ifstream(file_of(line, "value")) >> level;
  return level == 1;
}

int error_of(const std::vector<GpioLine>& lines) {
  try {
    const GpioInputs inputs(lines);
  } catch (const GpioError& error) {
    check(std::string(error.what()).find(lines.back().name) != std::string::npos,
          "an error without the line's name");
    return error.code.value();
  }
  return 0;
}

void inputs() {
  const std::vector<GpioLine> lines = {{"A0", false, GpioBias::kPullDown},
                                       {"B1", true, GpioBias::kPullUp},
                                       {"A2", false, GpioBias::kAsIs},
                                       {"B3", true, GpioBias::kAsIs}};
  GpioInputs inputs(lines);
  std::array<bool, 4> levels{};
  // The bias is what an open wire reads as: neither contact is closed.
  check(inputs.levels(levels) && !levels[0] && !levels[1], "an open wire counts as closed");
  check(inputs.edges()->edges.empty(), "an edge from nowhere");
  pull("A0", true);
  pull("B1", false);
  pull("A2", true);
  pull("B3", true);
  settle();
  check(inputs.levels(levels), "no levels");
  check(levels == std::array{true, true, true, false}, "wrong levels");
  const auto first = inputs.edges();
  check(first && !first->lost && first->edges.size() == 4, "not one edge a line");
  const std::array<int, 4> order = {0, 1, 2, 3};
  for (std::size_t i = 0; i < order.size(); ++i) {
    check(first->edges[i].line == order[i] && first->edges[i].active == levels[i],
          "wrong edge " + std::to_string(i));
    check(i == 0 || first->edges[i].time_ns > first->edges[i - 1].time_ns, "edges out of order");
  }
  // An opening between two looks: the level is as before, the edges tell.
  pull("A0", false);
  settle();
  pull("A0", true);
  settle();
  check(inputs.levels(levels) && levels[0], "A0 is not active");
  const auto pulse = inputs.edges();
  check(pulse && pulse->edges.size() == 2 && !pulse->edges[0].active && pulse->edges[1].active,
        "the pulse was not seen");
  // As many as the kernel keeps for all lines of the chip, and more.
  for (int i = 0; i < 40; ++i) {
    pull("A0", i % 2 != 0);
    settle();
  }
  check(inputs.edges()->lost, "edges were lost, and nobody says so");
  check(!inputs.edges()->lost && inputs.edges()->edges.empty(), "lost for ever");
  check(error_of({{"A0"}}) == EBUSY, "a line that is in use can be had");
}

void output() {
  {
    GpioOutput output({"B2"});
    check(!value("B2"), "active at first");
    check(output.set(true) && value("B2"), "not set");
    check(output.set(false) && !value("B2"), "not reset");
    check(output.set(true) && value("B2"), "not set again");
  }
  check(!value("B2"), "active after its end");
  GpioOutput low({"A3", true});
  check(value("A3"), "an active-low line is low at first");
  check(low.set(true) && !value("A3"), "an active-low line is high when set");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  chips = {argv[1], argv[2]};
  try {
    inputs();
    output();
    check(error_of({{"NOWHERE"}}) == ENOENT, "a missing line is there");
  } catch (const std::exception& error) {
    std::cout << thimble::board::gpio_library() << ": " << error.what() << '\n';
    return 1;
  }
  std::printf("figure: %s: %d checks\n", thimble::board::gpio_library().c_str(), checks);
  return 0;
}
