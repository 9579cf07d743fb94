#include "host-tools/cli/talking_bench.h"

#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"

namespace thimble::host {

bool TalkingBench::stopped() const { return person_.stopped(); }

Answer TalkingBench::tell(const Prompt& prompt) {
  if (asks_) return person_.ask(prompt);
  const bool about_correction = prompt.kind == Prompt::Kind::kAcceptCorrection;
  if (stopped()) {
    if (about_correction) return Answer::kNo;
    throw BuilderStops{};
  }
  // The program answers a question about a correction by its options. What a log has had in this step it does not get again.
  if (silent_ || about_correction || !told_.insert(prompt.text).second) return Answer::kDone;
  erase_progress();
  say(stderr, "  > {}\n", prompt.text);
  return Answer::kDone;
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
