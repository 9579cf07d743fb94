// thimble: the command. Parses, calls a verb, and turns every failure into a message and an exit code
// (docs/cli.md).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "board/sim/plant.h"
#include "host-tools/cli/compile_progress.h"
#include "host-tools/cli/completion.h"
#include "host-tools/cli/number_between.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/usage.h"
#include "host-tools/cli/verb_options.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/lab/cost_report.h"

namespace thimble::host {
namespace {

// The options of all verbs, filled by the parser.
struct Choices {
  Common common;
  Remote remote;
  DoctorChoice doctor;
  UploadChoice upload;
  MonitorChoice monitor;
  PublishChoice publish;
  ViewChoice view;
  ScanChoice scan;
  SimulateChoice simulate;
  SweepChoice sweep;
  ShowChoice show;
  CompileChoice compile;
  MeshChoice mesh;
  CommissionChoice commission;
  ModelCompileChoice model_compile;
  ModelUploadChoice model_upload;
  ModelImportChoice model_import;
  ImportVolumeChoice import_volume;
  ImportDeviceLogChoice import_device_log;
  RecordChoice record;
  ReplayChoice replay;
  PlotChoice plot;
  std::filesystem::path scene;
  std::filesystem::path image;
  std::filesystem::path file;
  std::string name;
  std::string value;
  std::vector<std::string> words;
  double wait_s = 30;
};

std::string arm_names() {
  std::string names;
  for (const board::PlantVariant& variant : board::plant_variants()) names.append(variant.name).append(", ");
  return names + "an arm of `thimble model list`, an arm file or an arm image";
}

// Adds a verb with the options that all verbs have.
CLI::App* verb(CLI::App& parent, Choices& choices, const std::string& name, const std::string& text,
               std::function<void()> run) {
  CLI::App* sub = parent.add_subcommand(name, text);
  sub->add_flag("--json", choices.common.json, "print JSON");
  sub->callback(std::move(run));
  return sub;
}

CLI::App* remote_verb(CLI::App& parent, Choices& choices, const std::string& name, const std::string& text,
                      std::function<void()> run) {
  const std::string group = parent.get_parent() == nullptr ? "" : parent.get_name() + " ";
  CLI::App* sub = verb(parent, choices, name, text,
                       [&choices, program = "thimble " + group + name, run = std::move(run)] {
                         choices.remote.program = program;
                         run();
                       });
  sub->add_option("--device", choices.remote.device,
                  "address or name of the device; default: the only device found");
  sub->add_option("--node", choices.remote.node, "its node number")
      ->check(CLI::Range(1U, 127U))
      ->capture_default_str();
  sub->add_option("--timeout", choices.remote.timeout_s, "seconds to wait for an answer")
      ->check(number_between(0.1, 600.0))
      ->capture_default_str();
  sub->add_option("--key", choices.remote.key, "file with the key of a device that has one")
      ->envname("THIMBLE_KEY");
  return sub;
}

void define_scan(CLI::App& app, Choices& c) {
  CLI::App* scan_verb = remote_verb(
      app, c, "scan", "probe a surface with the arm, and write a scene with the measured stiffness",
      [&c] { scan(c.common, c.remote, c.scan); });
  scan_verb->add_option("plan", c.scan.plan, "scan plan (JSON), see docs/scan.md")->required();
  scan_verb->add_option("--log", c.scan.log, "log of the measurements (CSV); it grows point by point")
      ->required();
  scan_verb->add_option("--output,-o", c.scan.output, "scene file to write")->required();
  scan_verb->add_flag("--resume", c.scan.resume, "continue the log of an interrupted scan");
  scan_verb->add_flag("--allow-moves", c.scan.allow_moves,
                      "permit the arm to move by itself; keep hands off it and the e-stop within reach");
  CLI::Option* simulated = scan_verb->add_flag(
      "--simulate", c.scan.simulate, "scan with the simulated arm, faster than real time; no device");
  scan_verb
      ->add_option("--specimen", c.scan.specimen,
                   "the specimen that the simulated arm touches (JSON), see docs/scan.md")
      ->needs(simulated);
  scan_verb->add_option("--arm", c.scan.arm, "with --simulate: " + arm_names())->capture_default_str();
  scan_verb->add_option("--seed", c.scan.seed, "with --simulate: seed of the simulated arm")
      ->capture_default_str();
}

void define_record(CLI::App& app, Choices& c) {
  CLI::App* record_verb = remote_verb(app, c, "record", "record every tick of a device, for an exact replay",
                                      [&c] { record(c.common, c.remote, c.record); });
  record_verb->add_option("output", c.record.output, "recording to write")->required();
  record_verb->add_option("--scene", c.record.scene, "the scene file (*.json) or image that the device runs")
      ->required();
  record_verb->add_option("--seconds", c.record.seconds, "stop after this time; default: Ctrl-C")
      ->check(number_between(0.001, 1e6));
  record_verb->add_flag("--home", c.record.home, "home the arm first");
  record_verb->add_flag("--arm", c.record.arm, "arm the device first, and disarm it at the end");
  record_verb->add_flag("--force", c.record.force,
                        "replace an existing file, and end the recording of another program");

  CLI::App* replay_verb =
      verb(app, c, "replay", "replay a recording with the same core, and compare every force",
           [&c] { replay(c.common, c.replay); });
  replay_verb->add_option("recording", c.replay.file, "recording of `thimble record`")->required();
  replay_verb->add_option("--log", c.replay.log, "log to write: CSV, one row per tick and arm");
  replay_verb->add_option("--events", c.replay.events, "table of its events and trials to write, CSV");

  CLI::App* plot_verb =
      verb(app, c, "plot", "plot the force of a recording or a log", [&c] { plot(c.common, c.plot); });
  plot_verb->add_option("file", c.plot.file, "a recording, or a log of `simulate` or `replay`")->required();
  plot_verb->add_option("--output,-o", c.plot.output, "picture to write: *.svg or *.png")->required();
  plot_verb->add_option("--kind", c.plot.kind, "all, time, depth or spectrum")
      ->check(CLI::IsMember({"all", "time", "depth", "spectrum"}))
      ->capture_default_str();
  plot_verb->add_option("--tip", c.plot.tip, "the arm: 0 or 1")
      ->check(CLI::Range(0U, 1U))
      ->capture_default_str();
}

void define_can_tools(CLI::App& app, Choices& c) {
  CLI::App* dbc_verb = app.add_subcommand("dbc", "the real-time messages as a DBC file, for other CAN tools");
  dbc_verb->callback([&c] { write_dbc(c.remote.node, c.image); });
  dbc_verb->add_option("--node", c.remote.node, "the controller's node number")
      ->check(CLI::Range(1U, 127U))
      ->capture_default_str();
  dbc_verb->add_option("--output,-o", c.image, "file to write; default: standard output");
  verb(app, c, "decode", "decode a log of CAN frames", [&c] { decode(c.common, c.image); })
      ->add_option("log", c.image, "log of `candump -L`; - is standard input")
      ->required();
}

void define_view(CLI::App& app, Choices& c) {
  CLI::App* view_verb = remote_verb(app, c, "view", "show a device, or a simulated one, in a browser",
                                    [&c] { view(c.common, c.remote, c.view); });
  CLI::Option* scene = view_verb->add_option("--scene", c.view.scene,
                                             "start a simulated device with this scene file (*.json)");
  scene->excludes(view_verb->get_option("--device"));
  view_verb->add_option("--arm", c.view.arm, "with --scene: " + arm_names())
      ->capture_default_str()
      ->needs(scene);
  view_verb->add_option("--arms", c.view.arms, "with --scene: number of arms")
      ->check(CLI::Range(1U, 2U))
      ->capture_default_str()
      ->needs(scene);
  view_verb->add_option("--scenes", c.view.scenes,
                        "a folder of scenes to choose from, in addition to Thimble's own");
  add_page_options(*view_verb, c.view.listen, c.view.port, c.view.browser);
}

void define_doctor_and_compile(CLI::App& app, Choices& c) {
  CLI::App* doctor_verb = verb(app, c, "doctor", "check whether this machine is ready for a device",
                               [&c] { doctor(c.common, c.doctor); });
  doctor_verb->add_option("--device", c.doctor.device,
                          "an address (can:can0, slcan:/dev/ttyACM0) or a name; default: all");
  doctor_verb->add_flag("--board", c.doctor.board, "check also what thimble-board needs");

  CLI::App* compile_verb =
      verb(app, c, "compile", "turn a scene file into a scene image", [&c] { compile(c.common, c.compile); });
  compile_verb->add_option("scene", c.compile.scene, "the scene file")->required();
  compile_verb->add_option("--output,-o", c.compile.output, "image to write; on an error nothing is written")
      ->required();
  compile_verb->add_flag("--report", c.compile.report, "print what was done to each mesh");
  compile_verb
      ->add_option("--model,--arm", c.compile.arm,
                   "warn of what is too stiff for this arm, or out of its reach: " + arm_names())
      ->capture_default_str();
  compile_verb->add_option("--rate", c.compile.rate_Hz, "at so many ticks a second")->capture_default_str();
  compile_verb->add_option("--board", c.compile.board, "tell the cost on this board: " + board_names());
}

void define_new_and_show(CLI::App& app, Choices& c) {
  verb(app, c, "new", "write a scene file to begin with", [&c] { new_scene(c.common, c.name); })
      ->add_option("name", c.name, "name of the scene: NAME.scene.json is written")
      ->required();
  CLI::App* show_verb =
      verb(app, c, "show", "the objects of a scene: sizes, feel, motion, and what they cost",
           [&c] { show(c.common, c.show); });
  show_verb->add_option("scene", c.show.scene, "the scene file")->required();
  show_verb->add_option("--rate", c.show.rate_Hz, "the costs at so many ticks a second")
      ->check(number_between(100.0, 20000.0))
      ->capture_default_str();
}

void define_mesh_and_commission(CLI::App& app, Choices& c) {
  add_mesh_options(
      *verb(app, c, "mesh", "repair a mesh file and say what was done", [&c] { mesh(c.common, c.mesh); }),
      c.mesh);
  add_commission_options(*remote_verb(app, c, "commission", "prove and measure an arm step by step",
                                      [&c] { commission(c.common, c.remote, c.commission); }),
                         c.commission);
}

void define_model(CLI::App& app, Choices& c) {
  CLI::App* model = app.add_subcommand("model", "arm files: what an arm is, and what it can do");
  model->require_subcommand(1);
  const char* const kWhich = "name of an arm that comes with Thimble, or an arm file (docs/arm-format.md)";
  verb(*model, c, "check", "say what is wrong with an arm file", [&c] { model_check(c.common, c.name); })
      ->add_option("model", c.name, kWhich)
      ->required();
  verb(*model, c, "show", "what an arm can do", [&c] { model_show(c.common, c.name); })
      ->add_option("model", c.name, kWhich)
      ->required();
  CLI::App* compiled = verb(*model, c, "compile", "make the image that boards and thimble-sim read",
                            [&c] { model_compile(c.common, c.model_compile); });
  compiled->add_option("model", c.model_compile.model, kWhich)->required();
  compiled->add_option("--output,-o", c.model_compile.output, "image to write: *.tarm")->required();
  CLI::App* uploaded =
      remote_verb(*model, c, "upload", "store an arm on a device, and restart it with that arm",
                  [&c] { model_upload(c.common, c.remote, c.model_upload); });
  uploaded->add_option("model", c.model_upload.model, kWhich)->required();
  uploaded->add_option("--number", c.model_upload.arm, "which of the device's arms, from 0")
      ->check(number_between(0, 1))
      ->capture_default_str();
  verb(*model, c, "list", "the arms that come with Thimble", [&c] { model_list(c.common); });
  CLI::App* import = model->add_subcommand("import", "make an arm file from another one");
  import->require_subcommand(1);
  CLI::App* urdf =
      verb(*import, c, "urdf", "from the joints of a URDF", [&c] { model_import(c.common, c.model_import); });
  urdf->add_option("urdf", c.model_import.urdf, "the URDF")->required();
  urdf->add_option("--tip", c.model_import.tip,
                   "the link that carries the tip; default: the only one without a child");
  urdf->add_option("--output,-o", c.model_import.output, "arm file to write: *.arm.json")->required();
}

void define_device(CLI::App& app, Choices& c) {
  CLI::App* upload_verb = remote_verb(app, c, "upload", "send a scene to a device and run it",
                                      [&c] { upload(c.common, c.remote, c.upload); });
  upload_verb->add_option("file", c.upload.file, "a scene file (*.json) or an image")->required();
  upload_verb->add_option("--model", c.upload.model,
                          "warn of what is too stiff for this arm, as --model of `compile`; default: the "
                          "arms of the device");
  upload_verb->add_flag("!--no-verify", c.upload.verify, "do not check afterwards which image runs");

  remote_verb(app, c, "arm", "turn the forces on", [&c] { arm(c.common, c.remote); });
  remote_verb(app, c, "disarm", "turn the forces off", [&c] { disarm(c.common, c.remote); });
  remote_verb(app, c, "stop", "e-stop: brake and switch off the motors of every device on the bus",
              [&c] { stop(c.common, c.remote); });
  remote_verb(app, c, "restart", "disarm and restart the controller", [&c] { restart(c.common, c.remote); });
  remote_verb(app, c, "home", "find the arm's home position", [&c] { home(c.common, c.remote, c.wait_s); })
      ->add_option("--wait", c.wait_s, "seconds that homing may take")
      ->check(number_between(0.1, 600.0))
      ->capture_default_str();

  add_monitor_options(*remote_verb(app, c, "monitor", "show the position of the tip and the force, live",
                                   [&c] { monitor(c.common, c.remote, c.monitor); }),
                      c.monitor);
  add_publish_options(
      *remote_verb(app, c, "publish", "send the telemetry of a device to an MQTT broker, live",
                   [&c] { publish(c.common, c.remote, c.publish); }),
      c.publish);
}

void define_param_and_fault(CLI::App& app, Choices& c) {
  CLI::App* param = app.add_subcommand("param", "read and change parameters");
  param->require_subcommand(1);
  remote_verb(*param, c, "list", "all of them", [&c] { param_list(c.common, c.remote); });
  remote_verb(*param, c, "get", "one", [&c] { param_get(c.common, c.remote, c.name); })
      ->add_option("name", c.name, "its name")
      ->required();
  CLI::App* set = remote_verb(*param, c, "set", "change one, until power-off (then `param save`)",
                              [&c] { param_set(c.common, c.remote, c.name, c.value); });
  set->add_option("name", c.name, "its name")->required();
  set->add_option("value", c.value, "its new value")->required();
  remote_verb(*param, c, "save", "save all of them, so that they survive power-off",
              [&c] { param_save(c.common, c.remote); });

  CLI::App* fault = app.add_subcommand("fault", "read, clear and explain faults");
  fault->require_subcommand(1);
  remote_verb(*fault, c, "list", "faults since the last clear, with their freeze frames",
              [&c] { fault_list(c.common, c.remote); });
  remote_verb(*fault, c, "clear", "clear the faults after their cause is removed",
              [&c] { fault_clear(c.common, c.remote); });
  verb(*fault, c, "explain", "what a fault means and what to do", [&c] { fault_explain(c.common, c.name); })
      ->add_option("fault", c.name, "number or name")
      ->required();

  remote_verb(app, c, "audit", "what was done with a device, when and by whom",
              [&c] { audit(c.common, c.remote); });
}

void define_key(CLI::App& app, Choices& c) {
  CLI::App* key = app.add_subcommand("key", "decide which programs may command a device");
  key->require_subcommand(1);
  remote_verb(*key, c, "set",
              "only programs with a key may command the device from now on; all may look and stop",
              [&c] { key_set(c.common, c.remote, c.file); })
      ->add_option("file", c.file, "file of the new key; made if it is not there; default: that of --key");
  remote_verb(*key, c, "remove", "every program may command the device again",
              [&c] { key_remove(c.common, c.remote); });
}

void define_import(CLI::App& app, Choices& c) {
  CLI::App* import = app.add_subcommand("import", "make a scene or a path from other data");
  import->require_subcommand(1);
  CLI::App* volume_verb =
      verb(*import, c, "volume", "a scene from the path of a needle through a NIfTI volume",
           [&c] { import_volume(c.common, c.import_volume); });
  volume_verb->add_option("volume", c.import_volume.volume, "the volume: .nii or .nii.gz")->required();
  volume_verb
      ->add_option("--from", c.import_volume.from,
                   "start of the needle's path: x,y,z in mm of the volume's world")
      ->required();
  volume_verb->add_option("--to", c.import_volume.to, "end of the needle's path: x,y,z")->required();
  volume_verb->add_flag("--voxel", c.import_volume.in_voxels, "--from and --to are voxels, counted from 0");
  CLI::Option* table = volume_verb->add_option("--layers", c.import_volume.table,
                                               "table of tissues by intensity (CSV); see docs/cli.md");
  volume_verb
      ->add_option("--classes", c.import_volume.classes,
                   "without a table: number of kinds of tissue, including air")
      ->check(CLI::Range(2U, 16U))
      ->capture_default_str()
      ->excludes(table);
  volume_verb
      ->add_option("--min-thickness", c.import_volume.thinnest_mm,
                   "in mm: thinner layers are merged with a neighbour")
      ->check(number_between(0.0, 1000.0))
      ->capture_default_str();
  volume_verb
      ->add_option("--output,-o", c.import_volume.output,
                   "scene file to write; on an error nothing is written")
      ->required();

  CLI::App* log_verb = verb(*import, c, "devicelog", "the log of a HAPI DeviceLog",
                            [&c] { import_device_log(c.common, c.import_device_log); });
  log_verb->add_option("devicelog", c.import_device_log.log, "the log, text or binary")->required();
  log_verb->add_option("--output,-o", c.import_device_log.path,
                       "path of the tip to write: CSV, for `simulate --path`");
  log_verb->add_option("--log", c.import_device_log.forces, "forces to write: CSV, for `plot`");
  log_verb->add_flag("--thimble-frame", c.import_device_log.thimble_frame,
                     "y of the log points away from the user and z up; default: y up, z to the user");
}

void define_simulate(CLI::App& app, Choices& c) {
  add_simulate_options(*verb(app, c, "simulate", "run a scene on the simulated arm, faster than real time",
                             [&c] { simulate(c.common, c.simulate); }),
                       c.simulate, arm_names());
  add_sweep_options(*verb(app, c, "sweep", "run many simulations on all processors, as a plan says",
                          [&c] { sweep(c.common, c.sweep); }),
                    c.sweep);
}

void define(CLI::App& app, Choices& c) {
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("thimble ") + THIMBLE_VERSION);

  verb(app, c, "list", "list the devices found", [&c] { list(c.common); });
  remote_verb(app, c, "info", "show a device: versions, scene, state and limits",
              [&c] { info(c.common, c.remote); });

  define_doctor_and_compile(app, c);
  define_new_and_show(app, c);
  define_mesh_and_commission(app, c);
  define_model(app, c);
  define_device(app, c);
  define_param_and_fault(app, c);
  define_key(app, c);
  define_import(app, c);
  define_view(app, c);
  define_record(app, c);
  define_scan(app, c);
  define_can_tools(app, c);
  define_simulate(app, c);

  CLI::App* help = app.add_subcommand("help", "what a verb does, and its options");
  help->add_option("verb", c.words, "the words of a verb, as in `thimble help param get`");
  help->callback([&app, &c] { std::cout << help_of(app, c.words); });
}

int run(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const bool json = std::ranges::find(arguments, "--json") != arguments.end();
  Choices choices;
  CLI::App app{"Thimble: scenes and devices of a force-feedback arm", "thimble"};
  try {
    define(app, choices);
    if (!arguments.empty() && arguments.front() == "__complete") {
      complete(app, {arguments.begin() + 1, arguments.end()});
      return 0;
    }
    if (arguments.empty()) {
      std::cerr << app.help();
      return static_cast<int>(ExitCode::kUsage);
    }
    refuse_unknown(app, arguments);
    help_compiler(json);
    app.parse(argc, argv);
    demand_written();
    return 0;
  } catch (const CLI::Success& wish) {  // --help, --version
    return app.exit(wish);
  } catch (const CLI::ParseError& error) {
    const std::string verb = full_name(*find_verb(app, arguments).verb);
    const Error usage(ExitCode::kUsage, "usage", verb + ": " + error.what(), "see `" + verb + " --help`");
    report(usage, json);
    return static_cast<int>(usage.code);
  } catch (const Error& error) {
    report(error, json);
    return static_cast<int>(error.code);
  } catch (const std::exception& error) {
    const Error failure(ExitCode::kRefused, "failed", error.what(),
                        "report this with the command that you gave");
    report(failure, json);
    return static_cast<int>(failure.code);
  }
}

}  // namespace
}  // namespace thimble::host

int main(int argc, char** argv) { return thimble::host::run(argc, argv); }
