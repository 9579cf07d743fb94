// mesh: repairs a mesh file, and says what it did.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/compiler/mesh_file.h"
#include "host-tools/compiler/mesh_repair.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

// Nine digits are a float exactly: the file holds what was repaired.
void write_obj(std::ostream& out, const TriangleSoup& soup) {
  for (const Eigen::Vector3d& p : soup.vertices_m)
    fmt::print(out, "v {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  for (const auto& t : soup.triangles) fmt::print(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
}

std::vector<std::string> left_undone(const RepairReport& report) {
  std::vector<std::string> left;
  const auto say = [&left](std::size_t count, const std::string& what) {
    if (count != 0) left.push_back(fmt::format("{} {}", count, what));
  };
  say(report.holes_too_large, "holes are larger than --max-hole, and stay open");
  say(report.holes_too_long, fmt::format("holes have more than {} edges, and stay open", kMaxHoleEdges));
  say(report.outlines, "open edges' loops are outlines of sheets, and stay open");
  say(report.holes_folded, "holes cannot be closed without a third face at an edge, and stay open");
  say(report.after.non_manifold_edges, "edges have more than two faces");
  say(report.after.pierced_triangles, "triangles still touch or cross others");
  if (report.resolved == Resolved::kTooLarge)
    left.emplace_back("the parts cross too often to be resolved, and stay as they are");
  if (report.resolved == Resolved::kFailed)
    left.emplace_back("the parts that cross could not be resolved, and stay as they are");
  return left;
}

const char* name_of(Resolved resolved) {
  switch (resolved) {
    case Resolved::kNothingToDo:
      return "nothing to do";
    case Resolved::kYes:
      return "to the outer surface";
    case Resolved::kTooLarge:
      return "too large";
    case Resolved::kFailed:
      return "failed";
  }
  return "";
}

Json counts(const MeshReport& mesh) {
  return {{"triangles", mesh.triangles},
          {"open_edges", mesh.open_edges},
          {"non_manifold_edges", mesh.non_manifold_edges},
          {"components", mesh.components},
          {"pierced_triangles", mesh.pierced_triangles}};
}

}  // namespace

void mesh(const Common& common, const MeshChoice& choice) {
  std::string extension = choice.output.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".obj") {
    throw Error(ExitCode::kUsage, "bad-output",
                fmt::format("'{}' is not an OBJ file", choice.output.string()),
                "give a name that ends with .obj");
  }
  keep_apart(choice.file, choice.output);
  std::optional<Busy> busy(std::in_place, common.json, "repairing the mesh");
  const TriangleSoup soup = read_mesh_file(choice.file, choice.scale_m, choice.file.string());
  const RepairedMesh repaired =
      repair_mesh(soup, {choice.max_hole_m, !choice.keep_crossings}, choice.file.string());
  OutputFile output(choice.output);
  write_obj(output.stream(), repaired.soup);
  output.commit();
  busy.reset();

  const RepairReport& report = repaired.report;
  const std::vector<std::string> left = left_undone(report);
  if (common.json) {
    Json json = document("mesh");
    json["mesh"] = choice.output.string();
    json["max_hole_m"] = choice.max_hole_m;
    json["input_triangles"] = report.before.input_triangles;
    json["input_vertices"] = soup.vertices_m.size();
    json["vertices"] = repaired.soup.vertices_m.size();
    json["degenerate_dropped"] = report.before.degenerate_dropped;
    json["fins_cancelled"] = report.before.fins_cancelled;
    json["reversed_triangles"] = report.reversed_triangles;
    json["holes_closed"] = report.holes_closed;
    json["hole_triangles"] = report.hole_triangles;
    json["crossings"] = choice.keep_crossings ? "kept" : name_of(report.resolved);
    json["before"] = counts(report.before);
    json["after"] = counts(report.after);
    json["warnings"] = left;
    print(json);
    return;
  }
  say("{}: {} triangles -> {}: {} triangles\n", choice.file.string(), report.before.input_triangles,
      choice.output.string(), report.after.triangles);
  say("  vertices            {} -> {}\n", soup.vertices_m.size(), repaired.soup.vertices_m.size());
  say("  without area        {} dropped\n", report.before.degenerate_dropped);
  say("  fins                {} cancelled\n", report.before.fins_cancelled);
  say("  winding             {} triangles reversed\n", report.reversed_triangles);
  say("  holes               {} closed with {} triangles\n", report.holes_closed, report.hole_triangles);
  say("  crossing parts      {}\n", choice.keep_crossings ? "kept" : name_of(report.resolved));
  say("  parts               {} -> {}\n", report.before.components, report.after.components);
  say("  open edges          {} -> {}\n", report.before.open_edges, report.after.open_edges);
  say("  touching, crossing  {} -> {}\n", report.before.pierced_triangles, report.after.pierced_triangles);
  for (const std::string& warning : left) say(stderr, "warning: {}\n", warning);
}

}  // namespace thimble::host
