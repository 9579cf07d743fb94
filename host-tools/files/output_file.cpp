#include "host-tools/files/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "host-tools/error.h"

namespace thimble::host {

void keep_apart(const std::filesystem::path& input, const std::filesystem::path& output) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(output, none) || !std::filesystem::equivalent(input, output, none))
    return;
  throw Error(ExitCode::kUsage, "same-file", output.string() + " is the file that is read",
              "give the output another name");
}

void keep_apart(std::span<const std::filesystem::path> inputs, const std::filesystem::path& output) {
  for (const std::filesystem::path& input : inputs) keep_apart(input, output);
}

void keep_outputs_apart(const std::filesystem::path& one, const std::filesystem::path& other) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::status(one, none);
  const bool is_device = fs::exists(status) && !fs::is_regular_file(status);  // such as /dev/null
  if (one.empty() || other.empty() || is_device) return;
  // A relative path of which nothing exists would stay relative, and "./a" not be "a".
  const bool same = fs::weakly_canonical(fs::absolute(one)) == fs::weakly_canonical(fs::absolute(other)) ||
                    fs::equivalent(one, other, none);
  if (same)
    throw Error(ExitCode::kUsage, "same-file", other.string() + " would be written twice",
                "give each output a name of its own");
}

OutputFile::OutputFile(std::filesystem::path place) : place_(std::move(place)) {
  std::error_code none;
  if (std::filesystem::path real = std::filesystem::canonical(place_, none); !none) place_ = std::move(real);
  const auto status = std::filesystem::status(place_, none);
  const auto kind = status.type();
  if (kind == std::filesystem::file_type::directory) fail(EISDIR);
  const bool direct =
      kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::regular;
  draft_ = place_;
  if (!direct) {
    draft_ += ".part-" + std::to_string(getpid());
    removed_.emplace(draft_);  // before it exists: a signal may come at once
  }
  errno = 0;
  stream_.open(draft_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail(errno);
  if (!direct && kind == std::filesystem::file_type::regular)
    std::filesystem::permissions(draft_, status.permissions(), none);
}

OutputFile::~OutputFile() {
  stream_.close();
  std::error_code ignored;
  if (draft_ != place_ && !kept_) std::filesystem::remove(draft_, ignored);
}

void OutputFile::flush() {
  errno = 0;
  stream_.flush();
  if (!stream_) fail(errno);
}

void OutputFile::commit() {
  errno = 0;
  stream_.close();
  if (!stream_) fail(errno != 0 ? errno : ENOSPC);  // a write that ended early leaves none
  if (draft_ == place_) return;
  std::error_code failed;
  std::filesystem::rename(draft_, place_, failed);
  if (failed) fail(failed.value());
  removed_.reset();
}

void OutputFile::fail(int error) const {
  std::string cause = "cannot write " + place_.string() + ": " + std::strerror(error);
  if (kept_ && draft_ != place_) cause += "; what was written until now is " + draft_.string();
  if (error == EACCES || error == EPERM || error == EROFS) {
    throw Error(ExitCode::kPermission, "permission", cause, "choose a place that you may write to");
  }
  throw Error(ExitCode::kRefused, "cannot-write", cause, "check the folder and the space left");
}

}  // namespace thimble::host
