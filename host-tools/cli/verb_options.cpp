#include "host-tools/cli/verb_options.h"

#include "host-tools/cli/number_between.h"
#include "host-tools/commission/steps.h"

namespace thimble::host {

void add_monitor_options(CLI::App& verb, MonitorChoice& choice) {
  verb.add_option("--seconds", choice.seconds, "stop after this time")->check(number_between(0.001, 1e6));
  verb.add_option("--count", choice.count, "stop after this number of rows (with --json: messages)")
      ->check(number_between(1, 1e9));
  verb.add_flag("--rows", choice.rows, "print rows also in a terminal, instead of a picture");
  verb.add_flag("--keep-alive", choice.keep_alive, "feed the device's host supervision");
}

void add_publish_options(CLI::App& verb, PublishChoice& choice) {
  verb.add_option("--broker", choice.broker,
                  "HOST, HOST:PORT or [IPv6]:PORT of the broker; without a port 1883")
      ->required();
  verb.add_option("--topic", choice.topic, "topic of the stream; default: thimble/SERIAL_NUMBER");
  verb.add_option("--seconds", choice.seconds, "stop after this time; default: Ctrl-C")
      ->check(number_between(0.001, 1e6));
  CLI::Option* user = verb.add_option("--user", choice.user, "user name for the broker");
  verb.add_option("--password-file", choice.password_file, "file with the user's password")->needs(user);
  verb.add_option("--ca", choice.ca_file,
                  "encrypt, and demand a certificate of the broker signed by one of these (PEM)");
}

void add_mesh_options(CLI::App& verb, MeshChoice& choice) {
  verb.add_option("file", choice.file, "the mesh: OBJ, STL, PLY, OFF, glTF, .plg ...")->required();
  verb.add_option("--output,-o", choice.output, "mesh to write: *.obj, in metres")->required();
  verb.add_option("--scale", choice.scale_m, "metres per unit of the file")
      ->check(number_between(1e-9, 1e9))
      ->capture_default_str();
  verb.add_option("--max-hole", choice.max_hole_m,
                  "in m: holes whose box has a diagonal up to this are closed; 0: none")
      ->check(number_between(0.0, 100.0))
      ->capture_default_str();
  verb.add_flag("--keep-crossings", choice.keep_crossings,
                "do not resolve closed parts that cross to their outer surface");
}

void add_commission_options(CLI::App& verb, CommissionChoice& choice) {
  verb.add_option("model", choice.model, "the arm file, or the name of an arm that comes with Thimble")
      ->required();
  CLI::Option* simulate =
      verb.add_flag("--simulate", choice.simulate, "on a simulated arm, with a simulated builder; no device");
  verb.add_option("--number", choice.arm, "number of the arm on the device, from 0")
      ->check(CLI::Range(0U, 1U))
      ->excludes(simulate);
  for (const char* option : {"--device", "--node"}) verb.get_option(option)->excludes(simulate);
  verb.add_option("--fault", choice.faults,
                  "plant a fault in the simulated arm: NAME@AXIS[:FACTOR], NAME@AXIS,AXIS for an exchange; "
                  "may be repeated; see docs/commissioning.md")
      ->allow_extra_args(false)
      ->needs(simulate);
  verb.add_option("--seed", choice.seed, "of the simulated arm: which figures are off, and by how much")
      ->check(CLI::Range(0, 1'000'000'000))
      ->needs(simulate)
      ->capture_default_str();
  CLI::Option* ask =
      verb.add_flag("--ask", choice.ask, "you answer the prompts; the simulated hands then do it");
  ask->needs(simulate);
  CLI::Option* corrects = verb.add_flag("--accept-corrections", choice.accept_corrections,
                                        "where the file may be wrong and not the arm, correct the new file")
                              ->excludes(ask)
                              ->needs(simulate);
  verb.add_option("--state", choice.state,
                  "where the progress is kept; default: NAME.commission.json beside the arm file");
  verb.add_option("--step", choice.step, "do only this step, again if it was done")
      ->check(CLI::Range(0, static_cast<int>(steps().size()) - 1));
  verb.add_flag("--restart", choice.restart, "begin anew, whatever was done");
  ask->excludes(verb.get_option("--json"));
  CLI::Option* page = verb.add_flag(
      "--page", choice.page,
      "serve a web page with the steps, the prompts and a picture of the arm; you answer there or here");
  page->excludes(corrects)->excludes(verb.get_option("--json"));
  add_page_options(verb, choice.listen, choice.port, choice.browser);
  for (const char* option : {"--port", "--listen", "--no-browser"}) verb.get_option(option)->needs(page);
}

void add_simulate_options(CLI::App& verb, SimulateChoice& choice, const std::string& arms) {
  verb.add_option("scene", choice.scene, "a scene file (*.json) or an image")->required();
  verb.add_option("--path", choice.path, "the hand's path: CSV time_s,x_m,y_m,z_m[,arm]")->required();
  verb.add_option("--log", choice.log, "log to write: CSV, one row per tick and arm")->required();
  verb.add_flag("--ideal", choice.ideal,
                "the tip follows the path exactly; the force is computed and does not act");
  verb.add_option("--rate", choice.rate_Hz, "ticks a second")->capture_default_str();
  verb.add_option("--arm", choice.arm, arms)->capture_default_str();
  verb.add_option("--seed", choice.seed, "seed of the simulated arm")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.add_option("--trial", choice.trial, "the parameter trial: which force fields of the scene act")
      ->check(CLI::Range(0, 255));
  verb.add_flag("--watch", choice.watch,
                "again each time the scene, a file that it names, or the path is saved; ends with Ctrl-C");
}

void add_sweep_options(CLI::App& verb, SweepChoice& choice) {
  verb.add_option("plan", choice.plan, "sweep plan (JSON), see docs/sweep.md")->required();
  verb.add_option(
      "--output,-o", choice.output,
      "results to write: CSV, a row per run; a sweep that was interrupted goes on where it ended");
  CLI::Option* table =
      verb.add_option("--table", choice.table, "page to write with the table of the plan: Markdown");
  verb.add_option("--jobs", choice.jobs, "runs at a time; default: one per processor, with --slurm one")
      ->check(CLI::Range(1U, 1024U));
  CLI::Option* array = verb.add_option(
      "--array", choice.array, "I/N: only the I-th of N parts; without this option all parts are collected");
  array->excludes(table);
  verb.add_option("--slurm", choice.slurm,
                  "run as a job array of Slurm with this number of tasks, and collect")
      ->check(CLI::Range(1U, 10000U))
      ->excludes(array);
  verb.add_flag("--dry-run", choice.dry_run, "check the plan, and say how many runs it has");
}

void add_page_options(CLI::App& verb, std::string& listen, std::uint16_t& port, bool& browser) {
  verb.add_option("--port", port, "port of the server; 0: any free port")->capture_default_str();
  verb.add_option("--listen", listen,
                  "the address of this machine on which other machines reach the page, 0.0.0.0 for "
                  "all; default: only this machine");
  verb.add_flag("!--no-browser", browser, "print the address and do not open a browser");
}

}  // namespace thimble::host
