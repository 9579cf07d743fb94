#include "host-tools/thimble/output.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <system_error>

namespace thimble::host {

Json document(std::string_view verb) {
  Json json;
  json["schema"] = kJsonSchema;
  json["verb"] = verb;
  return json;
}

void print(const Json& json) {
  std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
}
void print_line(const Json& json) {
  std::cout << json.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
}

void report(const Error& error, bool json) {
  if (json) {
    Json out;
    out["schema"] = kJsonSchema;
    out["error"] = {{"name", error.name},
                    {"cause", error.cause},
                    {"remedy", error.remedy},
                    {"exit_code", static_cast<int>(error.code)}};
    std::cerr << out.dump(2, ' ', false, Json::error_handler_t::replace) << std::endl;
  } else {
    std::cerr << "thimble: " << error.name << ": " << error.cause << "\n  remedy: " << error.remedy
              << std::endl;
  }
}

double tidy(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double read = 0;
  std::from_chars(text.data(), end, read);
  return read;
}

OutputFile::OutputFile(std::filesystem::path place) : place_(std::move(place)) {
  std::error_code none;
  const auto kind = std::filesystem::status(place_, none).type();
  if (kind == std::filesystem::file_type::directory) fail(EISDIR);
  const bool direct =
      kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::regular;
  draft_ = place_;
  if (!direct) draft_ += ".part-" + std::to_string(getpid());
  errno = 0;
  stream_.open(draft_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail(errno);
}

OutputFile::~OutputFile() {
  stream_.close();
  std::error_code ignored;
  if (draft_ != place_) std::filesystem::remove(draft_, ignored);
}

void OutputFile::commit() {
  errno = 0;
  stream_.close();
  if (!stream_) fail(errno);
  if (draft_ == place_) return;
  std::error_code failed;
  std::filesystem::rename(draft_, place_, failed);
  if (failed) fail(failed.value());
}

void OutputFile::fail(int error) const {
  const std::string cause = "cannot write " + place_.string() + ": " + std::strerror(error);
  if (error == EACCES || error == EPERM || error == EROFS) {
    throw Error(ExitCode::kPermission, "permission", cause, "choose a place that you may write to");
  }
  throw Error(ExitCode::kRefused, "cannot-write", cause, "check the folder and the space left");
}

}  // namespace thimble::host
