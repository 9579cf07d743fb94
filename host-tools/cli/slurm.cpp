#include "host-tools/cli/slurm.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr auto kSlurmLook = std::chrono::milliseconds(200);
constexpr auto kSlurmAsk = std::chrono::seconds(2);

// As one word of a shell.
std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

struct ShellAnswer {
  int status = 0;
  std::string text;  // both outputs
};

ShellAnswer ask_shell(const std::string& command) {
  ShellAnswer answer;
  std::FILE* const out = popen((command + " 2>&1").c_str(), "re");
  if (out == nullptr) return {-1, "cannot start a shell"};
  std::array<char, 4096> buffer{};
  for (std::size_t size = 0; (size = std::fread(buffer.data(), 1, buffer.size(), out)) > 0;)
    answer.text.append(buffer.data(), size);
  answer.status = pclose(out);
  while (answer.text.ends_with('\n')) answer.text.pop_back();
  return answer;
}

// The number of the job.
std::string submit(const SlurmArray& array) {
  if (ask_shell("command -v sbatch").status != 0)
    throw Error(ExitCode::kNotFound, "no-slurm", "there is no sbatch on this machine",
                "submit where Slurm is installed, or give --array I/N to another scheduler");
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string plan = std::filesystem::absolute(array.plan).string();
  const std::string output = std::filesystem::absolute(array.output).string();
  const std::string task =
      fmt::format("exec {} sweep {} --output {} --jobs {} --array \"$SLURM_ARRAY_TASK_ID/{}\"",
                  quoted(program), quoted(plan), quoted(output), array.jobs, array.tasks);
  const ShellAnswer answer = ask_shell(fmt::format(
      "sbatch --parsable --job-name=thimble-sweep --array=1-{} --cpus-per-task={} --output={} --wrap={}",
      array.tasks, array.jobs, quoted(output + ".slurm.%a"), quoted(task)));
  // "NUMBER" or "NUMBER;CLUSTER", maybe below a warning.
  const std::string last = answer.text.substr(answer.text.rfind('\n') + 1);
  std::string number = last.substr(0, last.find(';'));
  if (answer.status != 0 || number.empty() || number.find_first_not_of("0123456789") != std::string::npos)
    throw Error(ExitCode::kRefused, "slurm-refused", "sbatch: " + answer.text,
                "correct what it says; options for sbatch can be given as SBATCH_... variables");
  return number;
}

}  // namespace

void run_in_slurm(const SlurmArray& array, const std::function<bool()>& go_on) {
  const std::string number = submit(array);
  auto asked = std::chrono::steady_clock::now();
  while (true) {
    std::this_thread::sleep_for(kSlurmLook);
    if (!go_on()) {
      static_cast<void>(ask_shell("scancel " + number));
      return;
    }
    if (const auto now = std::chrono::steady_clock::now(); now - asked < kSlurmAsk) continue;
    // A job that has ended long ago is unknown. Without an answer from Slurm the wait goes on.
    const ShellAnswer left = ask_shell("squeue --noheader --array --jobs=" + number);
    asked = std::chrono::steady_clock::now();
    if (left.status == 0 ? left.text.empty() : left.text.find("Invalid job id") != std::string::npos) return;
  }
}

}  // namespace thimble::host
