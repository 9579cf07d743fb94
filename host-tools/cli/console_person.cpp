#include "host-tools/cli/console_person.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <optional>

#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"

namespace thimble::host {
namespace {

constexpr std::size_t kLongestAnswer = 100;

// Whether it is over without an answer: called again and again.
using Over = std::function<bool()>;

// One line of standard input; nothing: it has ended, or Ctrl-C, or the line is no answer of a person, or it is over. Byte by byte, because poll()
// does not see what a stream has buffered.
std::optional<std::string> read_answer_line(const Over& over) {
  constexpr int kRound_ms = 5;
  std::string line;
  for (;;) {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    const int ready = poll(&input, 1, over ? kRound_ms : -1);
    if (interrupted != 0 || (ready < 0 && errno != EINTR) || (over && over())) return std::nullopt;
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

Answer read_answer(const Prompt& prompt, const Over& over) {
  const bool refusable = may_be_refused(prompt);
  const char* hint = prompt.kind == Prompt::Kind::kAcceptCorrection ? "Enter: yes, n: no, q: stop here"
                     : refusable                                    ? "Enter: done, n: no, q: stop here"
                                                                    : "Enter: done, q: stop here";
  for (;;) {
    say(stderr, "    [{}] ", hint);
    std::fflush(stderr);
    const std::optional<std::string> line = read_answer_line(over);
    if (!line || *line == "q") return Answer::kStop;
    if (line->empty() || *line == "y") return Answer::kDone;
    if (refusable && *line == "n") return Answer::kNo;
  }
}

}  // namespace

bool ConsolePerson::stopped() const { return stopped_ || interrupted != 0; }

void ConsolePerson::check() const {
  if (stopped()) throw BuilderStops{};
}

Answer ConsolePerson::ask(const Prompt& prompt) {
  const bool about_correction = prompt.kind == Prompt::Kind::kAcceptCorrection;
  if (about_correction && stopped()) return Answer::kNo;
  check();
  say(stderr, "  > {}\n", prompt.text);
  const Answer answer = read_answer(prompt, {});
  if (answer != Answer::kStop) return answer;
  stopped_ = true;
  if (about_correction) return Answer::kNo;
  throw BuilderStops{};
}

Answer ConsolePerson::ask(const Prompt& prompt, const std::function<bool()>& round) {
  check();
  say(stderr, "  > {}\n", prompt.text);
  bool over = false;
  const Answer answer = read_answer(prompt, [&] { return over = over || !round(); });
  if (over) {
    say(stderr, "\n");
    return Answer::kDone;
  }
  if (answer != Answer::kStop) return answer;
  stopped_ = true;
  throw BuilderStops{};
}

}  // namespace thimble::host
