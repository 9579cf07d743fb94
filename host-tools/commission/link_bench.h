// The bench of a real arm: a device on the link, and a person beside the arm. Its motions are orders for the axes (firmware/sources/axis_drive.h), a
// wall is a scene, and the counts of every tick come as a recording of counts alone.
//
// Before step 7 the device's own limit of force is kTipForce_N. A device whose host is silent stops by itself (host_supervision). What is changed of
// its parameters is given back; its scene is not. Errors: those of Device, and kRefused, kFaulted and kLinkLost with the names in link_bench.cpp.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/sources/axis_drive.h"
#include "host-tools/client/device.h"
#include "host-tools/commission/bench.h"
#include "host-tools/commission/count_stream.h"
#include "host-tools/commission/expectation.h"
#include "host-tools/commission/person.h"

namespace thimble::host {

class LinkBench : public Bench {
 public:
  using Open = std::function<Device()>;

  // open: connects to the device, also again after it has restarted with another arm file. number: of the arm on the device; it goes by this file.
  LinkBench(Open open, Person& person, std::uint8_t number, const ArmFile& arm);
  ~LinkBench() override;

  // Of the steps that follow: up to which force the device's own limit goes.
  void begin_step(int number);

  [[nodiscard]] std::string device_name() { return device_->text(link::kDidSerialNumber); }

  [[nodiscard]] BenchFacts facts() override;
  void use(const ArmFile& arm) override;
  void locate(const PerAxis<double>& at_zero) override;
  [[nodiscard]] PerAxis<AxisReading> read() override;
  // The newest that have come; nothing is sent for them.
  [[nodiscard]] std::optional<PerAxis<std::int64_t>> newest_counts() const {
    if (!counted_) return std::nullopt;
    return stream_ ? stream_->newest() : counts_;
  }
  [[nodiscard]] Answer ask(const Prompt& prompt) override;
  [[nodiscard]] LineTrial try_line(Line line, const Prompt& prompt) override;
  [[nodiscard]] BenchRecording watch(const Prompt& prompt, bool powered) override;
  [[nodiscard]] BenchRecording wait(double seconds, bool powered) override;
  [[nodiscard]] BenchRecording run(const AxisProgram& program) override;
  [[nodiscard]] BenchRecording servo(const ServoProgram& program) override;
  [[nodiscard]] BenchRecording feel(const TipProgram& program, const Prompt& prompt) override;

 private:
  static constexpr link::Micros kRound_us = 10'000;  // between two signs of life
  static constexpr const char* kFreeSpace = R"({"thimble_scene": 1, "name": "commissioning", "objects": []})";
  // What the counts of a motion are cut from.
  struct Motion {
    std::uint64_t begin = 0;               // the first tick with torques
    std::size_t driven = 0, coasting = 0;  // ticks
    link::AxisEnd end = link::AxisEnd::kNotYet;
  };

  [[nodiscard]] std::size_t axes() const { return given_->axes.size(); }
  void connect();
  void set(const char* parameter, double value);
  void limit_force();
  void give_back() noexcept;
  void upload_scene(const std::string& text);

  void begin_recording();
  void start_recording();
  void end_recording();
  void arm_motors();
  void await_drives();
  void let_go();
  void place_arm();
  void pump(link::Micros until_us);
  void check_fault();

  [[nodiscard]] link::AxisOrder order(const EndsAt& ends) const;
  [[nodiscard]] Motion drive(const link::AxisOrder& order, const Prompt* prompt = nullptr);
  [[nodiscard]] BenchRecording cut(const link::AxisOrder& order, const Motion& motion);
  [[nodiscard]] BenchRecording cut(std::uint64_t from, std::uint64_t to, double between_s);
  [[nodiscard]] firmware::Axes angles(std::uint64_t tick) const;
  [[nodiscard]] JointVector believed() const;
  void take_motors();
  void forget_place();
  void read_currents();
  void bring_back();
  [[nodiscard]] bool bring_to_middle(std::size_t axis);
  [[nodiscard]] bool still_armed(std::uint64_t since) const;
  void wait_for_tick(std::uint64_t tick);
  [[noreturn]] static void counts_missing();
  [[nodiscard]] BenchRecording damp(const TipProgram& program, const Prompt& prompt);
  [[nodiscard]] BenchRecording spring(const TipProgram& program, const Prompt& prompt);
  [[nodiscard]] BenchRecording press(const TipProgram& program, const Prompt& prompt);
  [[nodiscard]] std::array<double, 3> tip_m();

  Open open_;
  Person& person_;
  std::uint8_t arm_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<ArmFile> given_;
  std::map<std::string, double> before_;  // parameters as they were
  std::string scene_;                     // that the device runs, of those here
  std::optional<CountStream> stream_;     // of the recording that runs
  PerAxis<std::uint32_t> raw_{};  // registers when they were last read, and the counts that belong to them
  PerAxis<std::int64_t> counts_{};
  PerAxis<double> at_zero_{};
  PerAxis<std::int64_t> from_home_{};  // the device's counts, where those here are 0
  firmware::AxisDrive law_;            // as the device's, fed with the same counts
  std::uint64_t law_tick_ = 0;         // that it is fed with next
  std::optional<link::Pose> pose_;
  double force_N_ = 0;  // at the tip, of the newest telemetry
  double tick_s_ = 0, max_force_N_ = kTipForce_N;
  link::Micros alive_us_ = 0;             // of the last sign of life
  std::optional<PerAxis<double>> place_;  // where the person was last asked to bring the axes
  PerAxis<bool> held_{};                  // by the person's hands
  bool is_strong_ = false;                // a step from 7 on
  bool proves_mark_ = true;               // a step up to 3
  bool has_mark_ = false, measures_current_ = false, told_current_ = false;
  std::vector<link::MeasuredCurrents> measured_;  // in the motion that runs or ran last
  bool counted_ = false, located_ = false, armed_ = false, holds_ = false;
  std::string session_;
};

}  // namespace thimble::host
