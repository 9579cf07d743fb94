#include "host-tools/cli/console_person.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"

namespace thimble::host {
namespace {

constexpr std::size_t kLongestAnswer = 100;

// The prompt stands at the second place while this lives.
class Posted {
 public:
  Posted(SecondPlace* place, const Prompt& prompt, bool bench_waits) : place_(place) {
    if (place_ != nullptr) place_->ask(prompt, bench_waits);
  }
  Posted(const Posted&) = delete;
  Posted& operator=(const Posted&) = delete;
  ~Posted() {
    if (place_ != nullptr) place_->withdraw();
  }

 private:
  SecondPlace* place_;
};

}  // namespace

bool may_be_declined(const Prompt& prompt) {
  return prompt.kind == Prompt::Kind::kAcceptCorrection || prompt.kind == Prompt::Kind::kRepair ||
         (prompt.kind == Prompt::Kind::kHang && prompt.mass_kg > 0);
}

bool ConsolePerson::stopped() const {
  return stopped_ || interrupted != 0 || (second_ != nullptr && second_->stopped());
}

// One line of standard input, byte by byte, because poll() does not see what a stream has buffered. Nothing: it has ended, the line is no answer of a
// person, or what ends every prompt. over() is called again and again.
ConsolePerson::Heard ConsolePerson::hear(const Over& over) {
  constexpr int kRound_ms = 5;
  const bool rounds = over || second_ != nullptr;
  std::string line;
  for (;;) {
    pollfd input{.fd = input_ended_ ? -1 : STDIN_FILENO, .events = POLLIN, .revents = 0};
    const int ready = poll(&input, 1, rounds ? kRound_ms : -1);
    if (stopped() || (ready < 0 && errno != EINTR) || (over && over())) return {};
    if (second_ != nullptr)
      if (const std::optional<Answer> answer = second_->answer()) return {{}, answer};
    if (ready <= 0) continue;
    char letter = 0;
    const ssize_t got = read(STDIN_FILENO, &letter, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      if (second_ == nullptr) return {};
      input_ended_ = true;
      continue;
    }
    if (letter == '\n') return {line, {}};
    line += letter;
    if (line.size() > kLongestAnswer) return {};
  }
}

Answer ConsolePerson::read_answer(const Prompt& prompt, const Over& over) {
  const Posted posted(second_, prompt, !over);
  const bool refusable = may_be_declined(prompt);
  const char* hint = prompt.kind == Prompt::Kind::kAcceptCorrection ? "Enter: yes, n: no, q: stop here"
                     : refusable                                    ? "Enter: done, n: no, q: stop here"
                                                                    : "Enter: done, q: stop here";
  for (;;) {
    say(stderr, "    [{}] ", hint);
    std::fflush(stderr);
    const Heard heard = hear(over);
    if (heard.elsewhere) {
      say(stderr, "{}, by the page\n", *heard.elsewhere == Answer::kDone ? "done" : "no");
      return *heard.elsewhere;
    }
    if (!heard.line || *heard.line == "q") return Answer::kStop;
    if (heard.line->empty() || *heard.line == "y") return Answer::kDone;
    if (refusable && *heard.line == "n") return Answer::kNo;
  }
}

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
