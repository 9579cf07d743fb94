#include "host-tools/viewer/commission_page.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <thread>
#include <utility>

namespace thimble::host {
namespace {

using Steady = std::chrono::steady_clock;

constexpr auto kLeastBetween = std::chrono::milliseconds(20);  // two states
constexpr auto kMostBetween =
    std::chrono::milliseconds(500);                          // a page takes the server for silent after 1.5 s
constexpr auto kLastState = std::chrono::milliseconds(200);  // for it to leave before the server ends

Json rounded_json(const Eigen::Vector3d& vector) {
  Json numbers = Json::array();
  for (const double number : vector) numbers.push_back(std::round(number * 1e4) / 1e4);
  return numbers;
}

Json lines_json(const std::vector<ArmPose::Line>& lines) {
  Json all = Json::array();
  for (const ArmPose::Line& line : lines) {
    Json points = Json::array();
    for (const Eigen::Vector3d& point : line) points.push_back(rounded_json(point));
    all.push_back(std::move(points));
  }
  return all;
}

Json steps_json(const std::vector<CommissionStepShown>& steps) {
  Json all = Json::array();
  for (const CommissionStepShown& step : steps) {
    Json findings = Json::array();
    for (const CommissionStepShown::Finding& found : step.findings)
      findings.push_back({{"name", found.name}, {"text", found.text}});
    all.push_back({{"state", step.state}, {"findings", findings}, {"notes", step.notes}});
  }
  return all;
}

Json hello_json(const CommissionPageOptions& options) {
  Json steps = Json::array();
  for (const CommissionPageOptions::Step& step : options.steps)
    steps.push_back({{"name", step.name}, {"text", step.text}});
  return {{"type", "hello"},
          {"version", options.version},
          {"simulated", options.simulated},
          {"may_control", false},
          {"arms", 1},
          {"device", {{"arm", options.arm}}},
          {"commission", {{"steps", steps}}}};
}

}  // namespace

CommissionPicture commission_picture(const CommissionShown& shown,
                                     const std::optional<CommissionPrompt>& prompt,
                                     const kinematics::ArmData& arm, ArmPose& pose,
                                     const std::vector<std::string>& names) {
  static_cast<void>(pose.move_to(shown.axes.empty() ? pose.home() : shown.axes));
  CommissionPicture picture;
  picture.arm = {{"tip_m", rounded_json(pose.tip_m())}, {"links_m", lines_json(pose.links())}};
  picture.marks = {{"is_live", !shown.axes.empty()}};
  const std::optional<std::size_t> axis = prompt ? prompt->axis : shown.axis;
  if (axis && *axis < pose.axes()) {
    const ArmPose::AxisLine line = pose.axis_line(*axis);
    picture.marks["axis"] = {{"name", names.at(*axis)},
                             {"slides", line.slides},
                             {"at_m", rounded_json(line.at_m)},
                             {"direction", rounded_json(line.direction)}};
    if (prompt && prompt->turn != 0) picture.marks["turn"] = prompt->turn;
  }
  if (prompt && !prompt->way.isZero()) picture.marks["way"] = rounded_json(prompt->way);
  if (prompt && prompt->goal) {
    ArmPose goal(arm);
    if (goal.move_to(*prompt->goal)) picture.marks["goal_m"] = lines_json(goal.links());
  }
  return picture;
}

// Two threads beside the caller's: the server's, and one that sends states.
class CommissionPage::Impl {
 public:
  Impl(CommissionPageOptions options, const kinematics::ArmData& arm)
      : options_(std::move(options)),
        arm_(arm),
        pose_(arm_),
        server_(options_.web, {.message = [this](const PageMessage& message) { take(message); },
                               .scenes = [] { return Json::array(); }}) {
    shown_.steps.resize(options_.steps.size());
    server_.hello(hello_json(options_));
    // Signals are for the caller's thread.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    serving_ = std::thread([this] { server_.run(); });
    sending_ = std::thread([this] { send_states(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    {
      const std::scoped_lock lock(mutex_);
      ending_ = changed_ = true;
    }
    wake_.notify_all();
    sending_.join();
    std::this_thread::sleep_for(kLastState);
    server_.stop();
    serving_.join();
  }

  [[nodiscard]] const std::string& url() const { return server_.url(); }

  void change(const std::function<void(CommissionShown&)>& how) {
    {
      const std::scoped_lock lock(mutex_);
      how(shown_);
      changed_ = true;
    }
    wake_.notify_all();
  }

  void ask(CommissionPrompt prompt) {
    change([&](CommissionShown&) {
      prompt_ = std::move(prompt);
      answer_.reset();
      ++number_;
    });
  }

  void withdraw() {
    change([&](CommissionShown&) { prompt_.reset(); });
  }

  [[nodiscard]] std::optional<Answer> answer() const {
    const std::scoped_lock lock(mutex_);
    return answer_;
  }

  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  // In the server's thread.
  void take(const PageMessage& message) {
    if (const auto* command = std::get_if<CommandMessage>(&message);
        command != nullptr && command->verb == ViewCommand::kStop) {
      stopped_ = true;
      return;
    }
    const auto* answer = std::get_if<AnswerMessage>(&message);
    if (answer == nullptr)
      throw Error(ExitCode::kRefused, "not-here",
                  "an arm is being commissioned: only prompts are answered here",
                  "end the commissioning first; then `thimble view`");
    const std::scoped_lock lock(mutex_);
    if (!prompt_ || answer_ || answer->prompt != number_)
      throw Error(ExitCode::kRefused, "too-late", "the prompt was answered already, here or at the terminal",
                  "see what is asked now");
    if (answer->declines && prompt_->decline.empty())
      throw Error(ExitCode::kRefused, "not-offered", "this prompt cannot be declined",
                  "do what it says, or stop");
    answer_ = answer->declines ? Answer::kDecline : Answer::kDone;
  }

  void send_states() {
    std::unique_lock lock(mutex_);
    for (bool last = false; !last;) {
      wake_.wait_for(lock, kMostBetween, [this] { return changed_; });
      changed_ = false;
      last = ending_;
      server_.state(state());
      if (last) return;
      lock.unlock();
      std::this_thread::sleep_for(kLeastBetween);
      lock.lock();
    }
  }

  [[nodiscard]] std::string state() {
    const CommissionPicture picture = commission_picture(shown_, prompt_, arm_, pose_, options_.axes);
    const double time_s = std::chrono::duration<double>(Steady::now() - begun_).count();
    Json json = {
        {"type", "state"}, {"time_s", std::round(1e3 * time_s) / 1e3}, {"arms", Json::array({picture.arm})}};
    Json& commission = json["commission"] = picture.marks;
    commission["steps"] = steps_json(shown_.steps);
    commission["doing"] = shown_.doing;
    if (prompt_) {
      commission["prompt"] = {{"number", number_}, {"text", prompt_->text}, {"done", prompt_->done}};
      if (!prompt_->decline.empty()) commission["prompt"]["decline"] = prompt_->decline;
    }
    if (shown_.over) commission["over"] = {{"passed", shown_.over->passed}, {"text", shown_.over->text}};
    return to_text(json);
  }

  const CommissionPageOptions options_;
  const kinematics::ArmData arm_;
  ArmPose pose_;
  const Steady::time_point begun_ = Steady::now();
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  CommissionShown shown_;
  std::optional<CommissionPrompt> prompt_;
  std::size_t number_ = 0;  // of the prompt
  std::optional<Answer> answer_;
  bool changed_ = true, ending_ = false;
  std::atomic<bool> stopped_ = false;
  WebServer server_;
  std::thread serving_, sending_;
};

CommissionPage::CommissionPage(CommissionPageOptions options, const kinematics::ArmData& arm)
    : impl_(std::make_unique<Impl>(std::move(options), arm)) {}

CommissionPage::~CommissionPage() = default;

const std::string& CommissionPage::url() const { return impl_->url(); }
void CommissionPage::change(const std::function<void(CommissionShown&)>& how) { impl_->change(how); }
void CommissionPage::ask(CommissionPrompt prompt) { impl_->ask(std::move(prompt)); }
std::optional<CommissionPage::Answer> CommissionPage::answer() const { return impl_->answer(); }
void CommissionPage::withdraw() { impl_->withdraw(); }
bool CommissionPage::stopped() const { return impl_->stopped(); }

}  // namespace thimble::host
