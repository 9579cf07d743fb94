#include "host-tools/in_page/page_scenes.h"

#include <utility>

#include "firmware/link/crc32.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/in_page/exports.h"

// A job for the worker that compiles: JSON, {"file", "text"}. Without a text the page reads the file.
THIMBLE_IMPORT(void, compile)(const char* job, std::size_t bytes);
// The text of a scene's file as it is now: JSON, {"file", "text"}.
THIMBLE_IMPORT(void, save)(const char* file, std::size_t bytes);

namespace thimble::host {
namespace {

[[noreturn]] void raise(const Json& head) {
  std::vector<SceneIssue> issues;
  for (const Json& it : head["issues"]) {
    SceneIssue& issue = issues.emplace_back();
    issue.name = it["name"];
    issue.cause = it["cause"];
    issue.remedy = it["remedy"];
    issue.pointer = it.value("pointer", "");
    issue.place.line = it.value("line", issue.place.line);
    issue.place.column = it.value("column", issue.place.column);
  }
  SceneErrors errors(ExitCode::kBadInput, std::move(issues));
  errors.more += head.value("more", std::size_t{0});
  throw errors;
}

// Whether what is compiled is the text of the scene in memory, not that of its file.
bool has_text(SceneJob::Kind kind) {
  return kind == SceneJob::Kind::kEdited || kind == SceneJob::Kind::kDraft;
}

}  // namespace

std::optional<OpenScene> PageScenes::with_crc(const std::string& name, std::uint32_t crc) {
  const auto found = opened_.find(crc);
  if (found == opened_.end() || found->second.name != name) return std::nullopt;
  return found->second;
}

void PageScenes::begin(SceneJob job) {
  result_.reset();
  Json order = {{"file", job.scene.file.string()}};
  if (has_text(job.kind)) order["text"] = changed_text(job.scene);
  job_ = std::move(job);
  const std::string text = to_text(order);
  page_compile(text.data(), text.size());
}

PageScenes::Result PageScenes::result_of(std::string_view head, std::string_view image) {
  const auto bytes = std::as_bytes(std::span(image));
  return {Json::parse(head), {bytes.begin(), bytes.end()}};
}

void PageScenes::deliver(std::string_view head, std::string_view image) { result_ = result_of(head, image); }

void PageScenes::learn(std::string_view head, std::string_view image) {
  const Result result = result_of(head, image);
  OpenScene scene;
  scene.file = result.head["file"].get<std::string>();
  scene.file_text = result.head["text"];
  if (result.head.contains("draft")) scene.draft = result.head["draft"];
  keep(std::move(scene), result);
  knows_more_ = true;
}

OpenScene PageScenes::take() {
  const Result result = *std::exchange(result_, std::nullopt);
  if (!result.head["issues"].empty()) raise(result.head);
  OpenScene scene = std::move(job_.scene);
  if (!has_text(job_.kind)) scene.file_text = result.head["text"];
  return keep(std::move(scene), result);
}

const OpenScene& PageScenes::keep(OpenScene scene, const Result& result) {
  scene.name = result.head["name"];
  scene.objects = result.head["objects"].get<std::vector<std::string>>();
  scene.crc = link::crc32(result.image);
  scene.image = std::make_shared<const std::vector<std::byte>>(result.image);
  return opened_.insert_or_assign(scene.crc, std::move(scene)).first->second;
}

void PageScenes::save(OpenScene& scene, bool /*replaces*/) {
  scene.file_text = changed_text(scene);
  scene.draft.reset();
  scene.changed_materials.clear();
  const std::string text = to_text(Json{{"file", scene.file.string()}, {"text", scene.file_text}});
  page_save(text.data(), text.size());
}

}  // namespace thimble::host
