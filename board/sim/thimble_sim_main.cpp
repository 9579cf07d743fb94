// thimble-sim: the simulated board in real time with its link, for users without an arm and for tests.
//
// Prints one address per line (tcp:HOST:PORT, slcan:PTY, canfd:INTERFACE ...), then "ready". Ends with
// SIGTERM, SIGINT or SIGHUP and removes its files. Exit codes: 0 ended by signal, 1 failed, 2 usage.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "board/sim/arm_image_file.h"
#include "board/sim/live_board.h"

namespace thimble::board {
namespace {

volatile std::sig_atomic_t stopping = 0;

// In one write, so that nobody else's text comes between.
void tell(const std::string& text) { std::cerr << "thimble-sim: " + text + '\n'; }

void run(const LiveOptions& options) {
  LiveBoard live(options);
  for (const std::string& uri : live.uris()) std::cout << uri << '\n';
  std::cout << "ready" << std::endl;
  live.run([] { return stopping != 0; }, {}, tell);
  std::ostringstream summary;
  summary << live.board().time_s() << " s simulated, " << live.skipped_s() << " s skipped, " << live.dropped()
          << " frames dropped";
  tell(summary.str());
}

int main_of(int argc, char** argv) {
  LiveOptions options;
  CLI::App app{"A simulated Thimble device in real time", "thimble-sim"};
  app.set_version_flag("--version", "thimble-sim " THIMBLE_VERSION);
  std::string arms;
  for (const PlantVariant& variant : plant_variants())
    arms += (arms.empty() ? "" : ", ") + std::string(variant.name);
  app.add_option("--arm", options.arm,
                 "one of: " + arms + "; or an arm image (`thimble model compile`): *.tarm")
      ->capture_default_str();
  app.add_option("--rate", options.rate_Hz, "ticks per second")
      ->check(CLI::Range(100.0, 20000.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "seed of the simulated arm")->capture_default_str();
  CLI::Option* tcp = app.add_option(
      "--tcp", options.tcp_port,
      "also offer the link on this port of 127.0.0.1 to programs of this user; 0: any free port");
  app.add_flag("--open", options.open, "let programs of every user of this machine connect to it")
      ->needs(tcp);
  app.add_flag("!--no-pty", options.pty, "offer the link without a pty");
  app.add_option("--link", options.link, "path of a symbolic link to the pty");
  app.add_option("--can", options.can, "also offer the link on this SocketCAN interface, classic and FD");
  app.add_option("--tty", options.tty,
                 "also offer the link as SLCAN on this serial port, such as /dev/ttyGS0 of a USB gadget");
  CLI::Option* hand = app.add_option(
      "--hand", options.hand, "path of the hand once the device is armed: CSV time_s,x_m,y_m,z_m[,arm]");
  app.add_flag("--loop", options.loop, "the hand repeats its path")->needs(hand);
  app.add_option("--specimen", options.specimen,
                 "an object for `thimble scan` to touch, and no hand: JSON, see docs/scan.md")
      ->excludes(hand);
  app.add_option("--inject", options.inject, "faults of the hardware, and when: JSON, see docs/cli.md");
  std::vector<std::string> senses;
  std::map<std::string, bool Sensors::*> sensors = {{"line-loss", &Sensors::line_loss},
                                                    {"current", &Sensors::current},
                                                    {"supply", &Sensors::supply},
                                                    {"temperature", &Sensors::temperature},
                                                    {"index", &Sensors::index}};
  app.add_option("--senses", senses, "what the hardware has besides encoders, separated by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(sensors));
  app.add_option("--store", options.store, "file that keeps the scenes between runs");
  app.add_option("--name", options.name, "name in `thimble list`; default: sim-PID")
      ->check([](const std::string& name) {
        return name.find_first_of("/:") == std::string::npos ? "" : "must not contain / or :";
      });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  for (const std::string& sense : senses) options.sensors.*sensors.at(sense) = true;
  try {
    options.arm_data = arm_of_image(options.arm);
  } catch (const std::exception& error) {
    tell(error.what());
    return 1;
  }
  if (options.name.empty()) options.name = "sim-" + std::to_string(getpid());
  const auto stop = [](int) { stopping = 1; };
  std::signal(SIGTERM, stop);
  std::signal(SIGINT, stop);
  if (std::signal(SIGHUP, stop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
  std::signal(SIGPIPE, SIG_IGN);
  try {
    run(options);
    return 0;
  } catch (const std::exception& error) {
    tell(error.what());
    return 1;
  }
}

}  // namespace
}  // namespace thimble::board

int main(int argc, char** argv) { return thimble::board::main_of(argc, argv); }
