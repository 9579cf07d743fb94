#include "tests/closed_loop/commission/linked_bench.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace thimble::test {

using host::Prompt;
namespace link = firmware::link;

// The host waits by the board's clock: in real time nothing would be left of its deadlines.
class MemoryTransport final : public host::Transport {
 public:
  explicit MemoryTransport(LinkedBench& bench) : bench_(bench) {}
  void send(const link::CanFrame& frame) override {
    bench_.controller_->on_frame(frame, LinkedBench::now_us());
  }
  [[nodiscard]] std::optional<link::CanFrame> receive(link::Micros deadline_us) override {
    while (bench_.to_host_.empty()) {
      if (LinkedBench::now_us() >= deadline_us) return std::nullopt;
      bench_.tick();
    }
    const link::CanFrame frame = bench_.to_host_.front();
    bench_.to_host_.pop_front();
    return frame;
  }

 private:
  LinkedBench& bench_;
};

LinkedBench::LinkedBench(const host::ArmFile& arm, std::vector<host::SimFault> faults,
                         const host::SimBenchOptions& options, std::uint64_t tick_us)
    : SimBench(arm, std::move(faults), options),
      given_axes_(arm.axes.size()),
      measures_current_(options.measures_current),
      storage_(std::size_t{1} << 16U),
      tick_us_(tick_us),
      tick_s_(static_cast<double>(tick_us) * 1e-6) {
  use(arm);
  config_.period_s = static_cast<float>(tick_s_);
  witnesses_.resize(kinematics::kMaxJoints, {kPeak_A, kLag_s, config_.period_s});
  config_.board = "bench";
  config_.arm[0].has_index = options.has_mark;
  if (measures_current_) config_.board_data = &measured_;
  start();
  host::use_clock(now_us);
}

LinkedBench::~LinkedBench() { host::use_clock(nullptr); }

void LinkedBench::start() {
  controller_.reset();
  to_host_.clear();
  controller_ = std::make_unique<firmware::Controller>(config_, storage_);
}

host::Device LinkedBench::open() { return host::Device(std::make_unique<MemoryTransport>(*this)); }

void LinkedBench::tick() {
  wait_a_tick();
  if (ticks_ == lost_tick_) wait_a_tick();
  firmware::Inputs in;
  in.tick = ticks_;
  in.time_us = now_us();
  in.dead_man = dead_man_;
  in.e_stop = e_stop_;
  in.arm[0].sample_tick = ticks_ < known_tick_ ? 0 : ticks_;
  in.arm[0].index = config_.arm[0].has_index && at_home_mark();
  read_arm(in);
  if (measures_current_) measured_.take(in);
  const firmware::Outputs out = controller_->tick(in);
  for (std::size_t j = 0; j < given_axes_; ++j)
    most_A_.at(j) = std::max(most_A_.at(j), std::abs(out.arm[0].enable ? out.arm[0].current_A[j] : 0));
  drive_arm(out);
  controller_->poll(now_us());
  link::CanFrame frame;
  while (controller_->next_frame(frame, now_us())) to_host_.push_back(frame);
  if (controller_->take_reset()) start();
}

void LinkedBench::read_arm(firmware::Inputs& in) {
  const host::PerAxis<std::int64_t> now = counts();
  for (std::size_t j = 0; j < given_axes_; ++j) in.arm[0].counts[j] = static_cast<std::uint32_t>(now.at(j));
  if (!measures_current_) return;
  const host::PerAxis<host::AxisReading> readings = SimBench::read();
  for (std::size_t j = 0; j < given_axes_; ++j) {
    witnesses_.at(j).reported(static_cast<float>(readings.at(j).current_A), 1);
    in.arm[0].evidence.current_A[j] = asked_A_.at(j) + witnesses_.at(j).difference_N_m();
  }
}

void LinkedBench::drive_arm(const firmware::Outputs& out) {
  host::PerAxis<double> current_A{};
  for (std::size_t j = 0; j < given_axes_; ++j) {
    current_A.at(j) = static_cast<double>(out.arm[0].current_A[j]);
    asked_A_.at(j) = out.arm[0].enable ? out.arm[0].current_A[j] : 0;
    witnesses_.at(j).asked(asked_A_.at(j));
  }
  if (out.arm[0].enable && !round_) take_fine_steps();  // the hands have their own
  move_arm(current_A, out.arm[0].enable, tick_s_);
}

void LinkedBench::move_arm(const host::PerAxis<double>& current_A, bool enable, double seconds) {
  SimBench::command(current_A, enable);
  SimBench::step_plant(seconds);
  judge(!round_ && std::ranges::any_of(current_A, [](double current) { return current != 0; }));
}

void LinkedBench::step_plant(double seconds) {
  constexpr std::uint64_t kRound_us = 2000;
  for (owed_s_ += seconds; owed_s_ >= tick_s_ / 2; owed_s_ -= tick_s_) {
    tick();
    if (!round_ || round_over_ || ticks_ % (kRound_us / tick_us_) != 0) continue;
    in_round_ = true;
    round_over_ = !round_();
    in_round_ = false;
  }
}

host::Answer LinkedBench::ask(const Prompt& prompt) {
  if (round_over_) let_tip_go();
  round_over_ = false;
  most_A_ = {};
  return SimBench::ask(prompt);
}

host::Answer LinkedBench::ask(const Prompt& prompt, const std::function<bool()>& round) {
  constexpr double kTime_s = .2;
  round_ = round;
  round_over_ = false;
  host::Answer answer = host::Answer::kDone;
  e_stop_ = prompt.kind == Prompt::Kind::kOpenEStop && !ignores_lines();
  dead_man_ = prompt.kind != Prompt::Kind::kReleaseDeadMan || ignores_lines();
  if (e_stop_ || !dead_man_) {
    step_plant(kTime_s);
    round_over_ = false;
  } else if (prompt.kind == Prompt::Kind::kHang || prompt.kind == Prompt::Kind::kLetGo) {
    answer = SimBench::ask(prompt);
    step_plant(kTime_s);
  } else {
    hands(prompt);
  }
  e_stop_ = false;
  dead_man_ = true;
  round_ = nullptr;
  return answer;
}

}  // namespace thimble::test
