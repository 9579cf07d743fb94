// `thimble replay` in a page.
#include <span>
#include <sstream>

#include "host-tools/error.h"
#include "host-tools/in_page/exports.h"
#include "host-tools/lab/event_table.h"
#include "host-tools/lab/recording_json.h"
#include "host-tools/lab/run_log.h"

// A part of the log, CSV; they come in order.
THIMBLE_IMPORT(void, log)(const char* text, std::size_t bytes);

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::streamoff kPart = 1 << 20;

// Rows to the page, part by part: a log is some twenty times as large as its recording.
class PageLog {
 public:
  explicit PageLog(const Recording& recording) : columns_(recording.header.scene) {
    write_log_header(part_, columns_);
  }
  void take(const board::LogRow& row) {
    write_log_row(part_, row, columns_);
    if (part_.tellp() >= kPart) give_part();
  }
  void give_part() {
    const std::string text = std::move(part_).str();
    page_log(text.data(), text.size());
    part_ = std::ostringstream();
  }

 private:
  SceneColumns columns_;
  std::ostringstream part_;
};

Json replayed(const std::string& name, const std::string& file, bool wants_log) {
  try {
    const Recording recording = parse_recording(std::as_bytes(std::span(file)), name);
    ReplayVerdict verdict;
    if (wants_log) {
      PageLog log(recording);
      verdict = replay_recording(recording, [&](const board::LogRow& row) { log.take(row); });
      log.give_part();
    } else {
      verdict = replay_recording(recording);
    }
    Json json = about_json(recording);
    json.update(verdict_json(verdict));
    json["events"] = events_json(recording);
    json["cut_bytes"] = recording.cut_bytes;
    return json;
  } catch (const Error& error) {
    return {{"error", {{"name", error.name}, {"cause", error.cause}, {"remedy", error.remedy}}}};
  }
}

}  // namespace
}  // namespace thimble::host

// In: the name of a recording's file, and its bytes. Out: JSON, that of `thimble replay --json`, and cut_bytes; or "error".
THIMBLE_EXPORT(int, replay)(std::size_t name_bytes, int wants_log) {
  using namespace thimble::host;
  const std::string in = std::move(page_buffer);
  return give(replayed(in.substr(0, name_bytes), in.substr(name_bytes), wants_log != 0)
                  .dump(-1, ' ', false, Json::error_handler_t::replace));
}
