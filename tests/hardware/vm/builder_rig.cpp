#include "tests/hardware/vm/builder_rig.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "board/linux/open_file.h"
#include "host-tools/commission/expectation.h"

namespace thimble::test {

using board::JointVector;
using host::Prompt;
using std::numbers::pi;

namespace {

// Of the arm's simulation: with the drives on, and with hands alone.
constexpr std::uint64_t kDrivenStep_us = 100, kHandStep_us = 500;

std::uint64_t steady_us() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000U +
         static_cast<std::uint64_t>(now.tv_nsec) / 1000U;
}

void write_to(const std::string& file, const char* text) {
  const board::Descriptor opened = board::open_file(file, O_WRONLY);
  const std::string_view bytes(text);
  if (write(opened.get(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error(file + " cannot be written");
}

// The number that stands after the word. Regular expressions would hold the drives up for milliseconds.
std::optional<double> number_after(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  if (at == std::string::npos) return std::nullopt;
  return std::strtod(text.c_str() + at + word.size(), nullptr);
}

bool has_word(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(' ' + word);
  if (at == std::string::npos) return false;
  const std::size_t end = at + 1 + word.size();
  return end == text.size() || std::isalpha(static_cast<unsigned char>(text[end])) == 0;
}

// "to the right and away from you" and the like.
Eigen::Vector3d direction_in(const std::string& text) {
  const std::pair<const char*, Eigen::Vector3d> words[] = {{"to the right", Eigen::Vector3d::UnitX()},
                                                           {"to the left", -Eigen::Vector3d::UnitX()},
                                                           {"away from you", Eigen::Vector3d::UnitY()},
                                                           {"towards you", -Eigen::Vector3d::UnitY()},
                                                           {"up", Eigen::Vector3d::UnitZ()},
                                                           {"down", -Eigen::Vector3d::UnitZ()}};
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (const auto& [word, axis] : words)
    if (has_word(text, word)) way += axis;
  return way.norm() > 0 ? Eigen::Vector3d(way.normalized()) : way;
}

}  // namespace

BuilderRig::BuilderRig(const host::ArmFile& arm, std::vector<host::SimFault> faults,
                       const host::SimBenchOptions& options, board::emulated::EmulatedBus& bus,
                       std::vector<board::emulated::EmulatedDrive*> drives, const Places& places)
    : SimBench(arm, std::move(faults), options),
      bus_(bus),
      drives_(std::move(drives)),
      places_(places),
      arm_(arm),
      prompts_(board::open_file(places.prompts, O_RDWR | O_NONBLOCK)),  // writers come and go
      answers_(board::open_file(places.answers, O_RDWR)),
      plant_us_(steady_us()) {
  if (drives_.size() != arm.axes.size())
    throw std::runtime_error("the arm needs a drive for each of its axes");
  for (board::emulated::EmulatedDrive* drive : drives_) drive->shaft.moves = false;
  move_on(1e-4);
  for (board::emulated::EmulatedDrive* drive : drives_)
    drive->reboot();  // power comes on where the arm stands
}

std::string BuilderRig::figures() const {
  return fmt::format("{{\"most_N\": {:.4f}, \"most_m_s\": {:.4f}}}", most_tip_force_N(),
                     most_tip_speed_m_s());
}

// --- Time

// What the hands do takes its time.
void BuilderRig::step_plant(double seconds) {
  until_us_ = std::max(until_us_, plant_us_) + static_cast<std::uint64_t>(std::lround(seconds * 1e6));
  while (plant_us_ < until_us_) serve();
}

void BuilderRig::pass(double seconds) {
  for (double t = 0; t < seconds; t += 1e-3) step_plant(1e-3);
}

void BuilderRig::go_on() {
  serve();
  if (!waits_) return;
  const std::string text = std::exchange(told_, {});
  doing_ = prompts_read_;
  at_work_ = true;
  do_as_told(text);
  at_work_ = false;
}

void BuilderRig::serve() {
  const std::uint64_t due_us = std::max(bus_.next_due_us(), steady_us()) - steady_us();
  pollfd waited[] = {{bus_.descriptor(), POLLIN, 0}, {prompts_.get(), POLLIN, 0}};
  const timespec shortly{0, static_cast<long>(std::min(due_us, kDrivenStep_us)) * 1000};
  (void)ppoll(waited, 2, &shortly, nullptr);
  const std::uint64_t now_us = steady_us();
  bus_.run(now_us);
  const bool on = std::ranges::any_of(drives_, [](const auto* drive) { return drive->follows(); });
  const std::uint64_t step_us = on ? kDrivenStep_us : kHandStep_us;
  for (; plant_us_ + step_us <= now_us; plant_us_ += step_us) move_on(static_cast<double>(step_us) * 1e-6);
  if ((waited[1].revents & POLLIN) != 0) listen();
}

void BuilderRig::move_on(double seconds) {
  host::PerAxis<double> current_A{};
  bool any = false;
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    current_A.at(j) = drives_[j]->torque_N_m() / arm_.axes[j].motor->torque_constant_N_m_A.value;
    any = any || current_A.at(j) != 0;
  }
  if (any && !at_work_) take_fine_steps();  // the hands have their own
  SimBench::command(current_A, true);       // a drive without power gives no torque
  SimBench::step_plant(seconds);
  judge(any && !at_work_);
  const host::PerAxis<std::int64_t> now = counts();
  for (std::size_t j = 0; j < drives_.size(); ++j) {
    const double at_rad =
        2 * pi * (static_cast<double>(now.at(j)) + .5) / arm_.axes[j].encoder.counts_per_turn.value;
    drives_[j]->shaft.velocity_rad_s = (at_rad - last_rad_.at(j)) / seconds;
    drives_[j]->shaft.position_rad = last_rad_.at(j) = at_rad;
  }
}

// --- What the tool prints

void BuilderRig::listen() {
  char bytes[512];
  const ssize_t got = ::read(prompts_.get(), bytes, sizeof(bytes));
  for (ssize_t k = 0; k < got; ++k) {
    waits_ = false;  // it has gone on
    std::cout << bytes[k];
    if (bytes[k] == '\n') {
      take_line(std::exchange(partial_, {}));
    } else {
      partial_ += bytes[k];
    }
  }
  std::cout << std::flush;
  waits_ = !told_.empty() && partial_.starts_with("    [") && partial_.ends_with("] ");
}

void BuilderRig::take_line(const std::string& line) {
  told_ = line.starts_with("  > ") ? line.substr(4) : "";
  if (!told_.empty()) ++prompts_read_;
  if (line.starts_with("  ! ")) found_.push_back(line.substr(4));
  if (line.starts_with("step ")) {
    std::cout << "before " << line.substr(0, line.find(' ', 5)) << ": " << figures() << '\n';
    found_.clear();
  }
}

void BuilderRig::answer(const char* text) {
  const std::string_view bytes(text);
  std::cout << "<answered>\n" << std::flush;
  partial_.clear();
  waits_ = false;
  if (::write(answers_.get(), bytes.data(), bytes.size()) < 0)
    throw std::runtime_error("nobody hears the answer");
}

Prompt BuilderRig::understood(const std::string& text) const {
  Prompt prompt;
  prompt.text = text;
  prompt.axis = arm_.axes.size();
  prompt.direction = direction_in(text);
  const auto begins = [&](const char* with) { return text.starts_with(with); };
  const auto axis_after = [&](const std::string& word) {
    for (std::size_t j = 0; j < arm_.axes.size(); ++j)
      if (text.find(fmt::format("{}'{}'", word, arm_.axes[j].name)) != std::string::npos) prompt.axis = j;
  };
  using Kind = Prompt::Kind;
  if (begins("Bring the arm to")) {
    prompt.kind = Kind::kPlace;
    for (std::size_t j = 0; j < arm_.axes.size(); ++j) {
      const std::optional<double> degrees = number_after(text, fmt::format("'{}' ", arm_.axes[j].name));
      if (!degrees) throw std::runtime_error("where to? " + text);
      prompt.place.at(j) = *degrees * pi / 180;
    }
    axis_after("let ");
  } else if (begins("Hold the other joints still")) {
    prompt.kind = Kind::kTurn;
    axis_after("");
    prompt.times =
        has_word(text, "once") ? 1 : static_cast<int>(number_after(text, "stop to stop, ").value_or(1));
  } else if (begins("Turn ")) {
    prompt.kind = Kind::kSwing;
    axis_after("");
  } else if (begins("Hold the tip and move it")) {
    prompt.kind = Kind::kMoveAbout;
  } else if (begins("Push the tip slowly")) {
    prompt.kind = Kind::kPush;
  } else if (begins("Hang a weight")) {
    prompt.kind = Kind::kHang;
    prompt.mass_kg = number_after(text, "Hang a weight of ").value_or(0) * 1e-3;
  } else if (begins("Take the weight off") || begins("Nothing hangs")) {
    prompt.kind = Kind::kHang;
  } else if (begins("Take your hands off")) {
    prompt.kind = Kind::kLetGo;
  } else if (begins("Lay the arm")) {
    prompt.kind = Kind::kRest;
  } else {
    throw std::runtime_error("the builder does not understand: " + text);
  }
  return prompt;
}

// --- What the builder does

bool BuilderRig::use_contacts(const std::string& text) {
  constexpr double kSettle_s = .1, kPatience_s = 3;
  const auto until_seen = [&] {
    for (double t = 0; t < kPatience_s && !over(); t += .01) pass(.01);
  };
  if (text == "Press the e-stop.") {
    write_to(places_.e_stop, "pull-down");
    until_seen();
  } else if (text == "Release the e-stop.") {
    write_to(places_.e_stop, "pull-up");
    pass(kSettle_s);
  } else if (text == "Hold the dead-man switch, then release it.") {
    write_to(places_.dead_man, "pull-down");
    until_seen();
    write_to(places_.dead_man, "pull-up");
    pass(kSettle_s);
  } else {
    return false;
  }
  return true;
}

// What the tool has named, if it is wrong indeed.
bool BuilderRig::repair() {
  for (std::size_t i = 0; i < faults().size(); ++i) {
    const host::SimFault& fault = faults()[i];
    const std::string named =
        fmt::format("{}: '{}':", host::text_of(fault.fault).name, arm_.axes[fault.axis].name);
    if (std::ranges::none_of(found_, [&](const std::string& line) { return line.starts_with(named); }))
      continue;
    std::cout << "<the builder repairs " << named << ">\n";
    mend(i);
    return true;
  }
  return false;
}

void BuilderRig::do_as_told(const std::string& text) {
  bool done = true;
  if (text.starts_with("Repair it")) {
    done = repair();
  } else if (text.ends_with("the file wrong?")) {
    done = false;  // the file is right
  } else if (text.starts_with("Bring '")) {
    const host::Expectation told(arm_);
    Prompt prompt;
    prompt.kind = Prompt::Kind::kPlace;
    prompt.axis = arm_.axes.size();
    for (std::size_t j = 0; j < arm_.axes.size(); ++j) {
      const bool next = text.find(fmt::format("'{}'", arm_.axes[j].name)) != std::string::npos;
      const host::Expectation::Span span = told.span(j, told.home());
      prompt.place.at(j) = next ? .5 * (span.lower + span.upper) : told.home()[static_cast<Eigen::Index>(j)];
    }
    static_cast<void>(SimBench::ask(prompt));
  } else if (text.starts_with("Push the tip") && text.find("until you feel a wall") != std::string::npos) {
    const std::optional<double> press_N = number_after(text, "press it with ");
    if (!press_N) throw std::runtime_error("how hard? " + text);
    press(direction_in(text.substr(0, text.find(" until"))), *press_N);
  } else if (!use_contacts(text)) {
    const Prompt prompt = understood(text);
    static_cast<void>(SimBench::ask(prompt));
    hands(prompt);
  }
  if (!over()) answer(done ? "\n" : "n\n");
}

// The hand goes on until the wall pushes back as hard as it was told, and holds.
void BuilderRig::press(const Eigen::Vector3d& direction, double press_N) {
  constexpr double kStep_s = 1e-3, kSpeed_m_s = .05, kFarthest_m = .06, kSmooth_s = .02, kHeld_s = 2,
                   kMeasured_s = .5;
  take_fine_steps();
  board::AnyPlant& plant = moved_plant();
  plant.release_grip();
  plant.set_hand(board::Hand{});
  const Eigen::Vector3d from_m = plant.force_point_m(), tip_from_m = plant.tip_m();
  double way_m = 0, felt_N = 0;
  Eigen::Vector3d sum_N = Eigen::Vector3d::Zero(), sum_m = sum_N;
  int measured = 0;
  for (double held_s = 0; held_s < kHeld_s && !over();) {
    const bool goes_on = felt_N < press_N && way_m < kFarthest_m && held_s == 0;
    if (goes_on) way_m += kSpeed_m_s * kStep_s;
    if (!goes_on) held_s += kStep_s;
    plant.set_hand_target(from_m + way_m * direction,
                          goes_on ? Eigen::Vector3d(kSpeed_m_s * direction) : Eigen::Vector3d::Zero());
    step_plant(kStep_s);
    felt_N += kStep_s / kSmooth_s * (-plant.hand_force_N().dot(direction) - felt_N);
    if (held_s <= kHeld_s - kMeasured_s) continue;
    sum_N += plant.hand_force_N();
    sum_m += plant.tip_m();
    ++measured;
  }
  if (measured > 0) {
    const Eigen::Vector3d hand_N = sum_N / measured, tip_mm = 1e3 * sum_m / measured;
    fmt::print(
        "\n{{\"way_mm\": {:.3f}, \"hand_N\": [{:.4f}, {:.4f}, {:.4f}], \"tip_mm\": [{:.3f}, {:.3f}, "
        "{:.3f}]}}\n",
        (sum_m / measured - tip_from_m).dot(direction) * 1e3, hand_N.x(), hand_N.y(), hand_N.z(), tip_mm.x(),
        tip_mm.y(), tip_mm.z());
    std::fflush(stdout);
  }
  let_tip_go();
}

}  // namespace thimble::test
