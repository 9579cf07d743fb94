#include "host-tools/cli/talking_bench.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <optional>

#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"

namespace thimble::host {
namespace {

constexpr std::size_t kLongestAnswer = 100;

// One line of standard input; nothing: it has ended, or Ctrl-C, or the line is no answer of a person. Byte by byte, because poll() does not see
// what a stream has buffered.
std::optional<std::string> read_answer_line() {
  std::string line;
  for (;;) {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    const int ready = poll(&input, 1, -1);
    if (interrupted != 0 || (ready < 0 && errno != EINTR)) return std::nullopt;
    if (ready <= 0) continue;
    char letter = 0;
    const ssize_t got = read(STDIN_FILENO, &letter, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return std::nullopt;
    if (letter == '\n') return line;
    line += letter;
    if (line.size() > kLongestAnswer) return std::nullopt;
  }
}

bool may_be_refused(const Prompt& prompt) {
  return prompt.kind == Prompt::Kind::kAcceptCorrection || prompt.kind == Prompt::Kind::kRepair ||
         (prompt.kind == Prompt::Kind::kHang && prompt.mass_kg > 0);
}

Answer read_answer(const Prompt& prompt) {
  const bool refusable = may_be_refused(prompt);
  const char* hint = prompt.kind == Prompt::Kind::kAcceptCorrection ? "Enter: yes, n: no, q: stop here"
                     : refusable                                    ? "Enter: done, n: no, q: stop here"
                                                                    : "Enter: done, q: stop here";
  for (;;) {
    say(stderr, "    [{}] ", hint);
    std::fflush(stderr);
    const std::optional<std::string> line = read_answer_line();
    if (!line || *line == "q") return Answer::kStop;
    if (line->empty() || *line == "y") return Answer::kDone;
    if (refusable && *line == "n") return Answer::kNo;
  }
}

}  // namespace

bool TalkingBench::stopped() const { return stopped_ || interrupted != 0; }

Answer TalkingBench::tell(const Prompt& prompt) {
  const bool about_correction = prompt.kind == Prompt::Kind::kAcceptCorrection;
  if (stopped()) {
    if (about_correction) return Answer::kNo;
    throw BuilderStops{};
  }
  // The program answers a question about a correction by its options: only a person sees it. A person is told each time, a log once.
  const bool is_new = told_.insert(prompt.text).second;
  if (!silent_ && (asks_ || (is_new && !about_correction))) say(stderr, "  > {}\n", prompt.text);
  if (!asks_) return Answer::kDone;
  const Answer answer = read_answer(prompt);
  if (answer != Answer::kStop) return answer;
  stopped_ = true;
  if (about_correction) return Answer::kNo;
  throw BuilderStops{};
}

Answer TalkingBench::ask(const Prompt& prompt) {
  const Answer answer = tell(prompt);
  if (answer != Answer::kDone) return answer;
  if (asks_ && (prompt.kind == Prompt::Kind::kAcceptCorrection || prompt.kind == Prompt::Kind::kRepair))
    return answer;
  return bench_.ask(prompt);
}

LineTrial TalkingBench::try_line(Line line, const Prompt& prompt) {
  static_cast<void>(tell(prompt));
  return bench_.try_line(line, prompt);
}

BenchRecording TalkingBench::watch(const Prompt& prompt, bool powered) {
  static_cast<void>(tell(prompt));
  return bench_.watch(prompt, powered);
}

BenchRecording TalkingBench::feel(const TipProgram& program, const Prompt& prompt) {
  static_cast<void>(tell(prompt));
  return bench_.feel(program, prompt);
}

BenchRecording TalkingBench::wait(double seconds, bool powered) {
  if (stopped()) throw BuilderStops{};
  return bench_.wait(seconds, powered);
}

BenchRecording TalkingBench::run(const AxisProgram& program) {
  if (stopped()) throw BuilderStops{};
  return bench_.run(program);
}

BenchRecording TalkingBench::servo(const ServoProgram& program) {
  if (stopped()) throw BuilderStops{};
  return bench_.servo(program);
}

}  // namespace thimble::host
