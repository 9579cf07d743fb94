// compile and simulate: the verbs that need no device.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host-tools/cli/cost_json.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/stable_stiffness.h"
#include "host-tools/error.h"
#include "host-tools/files/image_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/arm_choice.h"
#include "host-tools/lab/reach_warnings.h"
#include "host-tools/lab/run_log.h"
#include "host-tools/lab/simulation_run.h"

namespace thimble::host {
namespace {

constexpr auto kLook = std::chrono::milliseconds(200);  // between two looks at the files

constexpr const char* kTouchesNothing =
    "the path touches nothing: see where the scene's objects are (`thimble view --scene`)";

// "the tip of arm 0 is inside lamp from 0 s to 0.35 s: move out. It is not felt until then".
std::string text_of(const board::BeganInside& inside) {
  const std::string end =
      inside.until_s ? fmt::format("to {:.4g} s", *inside.until_s) : "to the end of the path";
  return fmt::format("the tip of arm {} is inside {} from {:.4g} s {}: move out. Until then {} is not felt",
                     inside.arm, inside.object, inside.from_s, end, inside.object);
}

Json to_json(const board::BeganInside& inside) {
  return {{"arm", inside.arm},
          {"object", inside.object},
          {"from_s", inside.from_s},
          {"until_s", inside.until_s ? Json(*inside.until_s) : Json()}};
}

Json to_json(const MeshReport& mesh) {
  return {{"input_triangles", mesh.input_triangles},
          {"triangles", mesh.triangles},
          {"vertices", mesh.vertices},
          {"open_edges", mesh.open_edges},
          {"non_manifold_edges", mesh.non_manifold_edges},
          {"components", mesh.components},
          {"flipped_components", mesh.flipped_components},
          {"degenerate_dropped", mesh.degenerate_dropped},
          {"fins_cancelled", mesh.fins_cancelled},
          {"unused_vertices", mesh.unused_vertices},
          {"pierced_triangles", mesh.pierced_triangles},
          {"seam_triangles", mesh.seam_triangles},
          {"bytes", mesh.bytes},
          {"depth", mesh.depth}};
}

}  // namespace

void compile(const Common& common, const CompileChoice& choice) {
  const std::filesystem::path& output = choice.output;
  keep_apart(choice.scene, output);
  const ArmChoice arm = chosen_arm(choice.arm);
  if (!(choice.rate_Hz >= 100 && choice.rate_Hz <= 20000))
    throw Error(ExitCode::kUsage, "bad-rate", "the rate is not within 100 Hz to 20 kHz",
                "choose --rate between 100 and 20000");
  const board::BoardCost* const board = board::find_board_cost(choice.board);
  if (board == nullptr && !choice.board.empty())
    throw Error(ExitCode::kUsage, "unknown-board", "there is no board named " + choice.board,
                "choose --board from " + board_names());
  const CompiledScene compiled = compile_scene(choice.scene);
  keep_apart(compiled.report.files, output);
  write_image(output, compiled.image);

  const SceneReport& report = compiled.report;
  std::vector<std::string> warnings = report.warnings;
  for (const std::vector<std::string>& more :
       {stiffness_warnings(compiled.image, std::span(&arm.walls, 1), choice.rate_Hz),
        reach_warnings(compiled.image, arm, report.tip_radius_m)})
    std::ranges::copy(more, std::back_inserter(warnings));
  CostReport cost;
  if (board != nullptr) cost = cost_report(compiled.image, *board, choice.rate_Hz);
  if (!cost.warning.empty()) warnings.push_back(cost.warning);
  if (common.json) {
    Json json = document("compile");
    if (!cost.text.empty()) json["cost"] = to_json(cost);
    json["scene"] = report.name;
    json["image"] = output.string();
    json["bytes"] = compiled.image.size();
    json["tip_radius_m"] = report.tip_radius_m;
    json["objects"] = Json::array();
    for (const SceneReport::Object& object : report.objects) {
      Json entry = {{"name", object.name}, {"shape", object.shape}};
      if (object.mesh.triangles > 0) entry["mesh"] = to_json(object.mesh);
      json["objects"].push_back(entry);
    }
    json["warnings"] = warnings;
    print(json);
    return;
  }
  say("{}: {} objects, {} bytes -> {}\n", report.name, report.objects.size(), compiled.image.size(),
      output.string());
  if (report.tip_radius_m > 0)
    say("  the tip is a sphere with a radius of {:g} mm\n", 1e3 * report.tip_radius_m);
  for (const SceneReport::Object& object : report.objects) {
    if (object.mesh.triangles > 0) {
      const MeshReport& mesh = object.mesh;
      say("  {}: {}, {} triangles, {} vertices, {} open edges, {} bytes ({:.1f} a triangle), tree depth "
          "{}\n",
          object.name, object.shape, mesh.triangles, mesh.vertices, mesh.open_edges, mesh.bytes,
          static_cast<double>(mesh.bytes) / static_cast<double>(mesh.triangles), mesh.depth);
      const Json counts = choice.report ? to_json(mesh) : Json::object();
      for (const auto& [name, count] : counts.items()) say("    {:<20} {}\n", name, count.dump());
    } else {
      say("  {}: {}\n", object.name, object.shape);
    }
  }
  if (!cost.text.empty()) say("{}\n", cost.text);
  for (const std::string& warning : warnings) say(stderr, "warning: {}\n", warning);
}

namespace {

void simulate_once(const Common& common, const SimulateChoice& choice) {
  keep_apart(choice.scene, choice.log);
  keep_apart(choice.path, choice.log);
  const SimulationRun run(load_image(choice.scene), choice.path);
  keep_apart(run.files(), choice.log);
  board::SimulationOptions options;
  options.ideal = choice.ideal;
  options.rate_Hz = choice.rate_Hz;
  options.arm = choice.arm;
  options.arm_data = other_arm(choice.arm);
  options.seed = choice.seed;
  options.trial = choice.trial;

  OutputFile log(choice.log);
  const SceneColumns columns(run.image());
  write_log_header(log.stream(), columns);
  double peak_N = 0;
  double sum_N = 0;
  std::uint64_t contact_rows = 0;
  Progress progress(common.json);
  const board::SimulationResult result = run.go(options, [&](const board::LogRow& row) {
    progress.show((row.time_s - run.start_s()) / std::max(run.end_s() - run.start_s(), 1e-9), "simulating");
    write_log_row(log.stream(), row, columns);
    const double force_N = row.force_N.norm();
    peak_N = std::max(peak_N, force_N);
    if (row.contacts != 0) {
      ++contact_rows;
      sum_N += force_N;
    }
  });
  log.commit();
  progress.end();
  throw_if_faulted(result);

  std::vector<std::string> warnings;
  for (const board::BeganInside& inside : result.inside) warnings.push_back(text_of(inside));
  if (contact_rows == 0 && !(peak_N > 0)) warnings.emplace_back(kTouchesNothing);
  const double mean_N = contact_rows == 0 ? 0.0 : sum_N / static_cast<double>(contact_rows);
  if (common.json) {
    Json json = document("simulate");
    json["log"] = choice.log.string();
    json["ideal"] = choice.ideal;
    json["rate_Hz"] = choice.rate_Hz;
    json["ticks"] = result.ticks;
    json["contact_rows"] = contact_rows;
    json["peak_force_N"] = peak_N;
    json["mean_contact_force_N"] = mean_N;
    json["sweep_bound"] = result.bounds.sweep_bound;
    json["slide_bound"] = result.bounds.slide_bound;
    json["contact_bound"] = result.bounds.contact_bound;
    json["most_work"] = result.bounds.most_work;
    json["put_off"] = result.bounds.put_off;
    json["inside"] = Json::array();
    for (const board::BeganInside& inside : result.inside) json["inside"].push_back(to_json(inside));
    json["warnings"] = warnings;
    print(json);
  } else {
    say(stderr, "{} ticks, {} rows in contact, peak {:.3f} N, mean in contact {:.3f} N -> {}\n", result.ticks,
        contact_rows, peak_N, mean_N, choice.log.string());
    for (const std::string& warning : warnings) say(stderr, "warning: {}\n", warning);
  }
}

// When a file was written, and how much; nothing where it cannot be read.
using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;
Stamp stamp_of(const std::filesystem::path& file) {
  std::error_code gone;
  Stamp stamp;
  stamp.first = std::filesystem::last_write_time(file, gone);
  stamp.second = std::filesystem::file_size(file, gone);
  return gone ? Stamp() : stamp;
}

// The path, the scene, and the files that it names, as far as they are there: also where its text or one of them has errors.
std::map<std::filesystem::path, Stamp> stamps_of(const SimulateChoice& choice) {
  std::map<std::filesystem::path, Stamp> stamps = {{choice.scene, stamp_of(choice.scene)},
                                                   {choice.path, stamp_of(choice.path)}};
  if (choice.scene.extension() != ".json") return stamps;
  std::ifstream text(choice.scene);
  for (std::string quoted; std::getline(text, quoted, '"');) {
    const std::filesystem::path file = choice.scene.parent_path() / quoted;
    std::error_code none;
    if (quoted.size() < 256 && std::filesystem::is_regular_file(file, none)) stamps[file] = stamp_of(file);
  }
  return stamps;
}

}  // namespace

void simulate(const Common& common, const SimulateChoice& choice) {
  if (!choice.watch) {
    simulate_once(common, choice);
    return;
  }
  heed_interrupts();
  while (interrupted == 0) {
    const auto before = stamps_of(choice);
    try {
      simulate_once(common, choice);
    } catch (const Error& error) {
      if (error.code == ExitCode::kUsage) throw;  // no file that is saved corrects it
      report(error, common.json);
    }
    std::fflush(nullptr);
    while (interrupted == 0 && stamps_of(choice) == before) std::this_thread::sleep_for(kLook);
  }
}

}  // namespace thimble::host
