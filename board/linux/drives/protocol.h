// One drive's protocol behind one interface: which frames say a thing, and what a frame from the drive says. No time, no life cycle
// (drive_life.h), no socket (drive_bus.h). make_protocol() allocates once; the rest neither allocates nor fails.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "board/linux/drives/drive_config.h"

namespace thimble::board::drives {

// Frames of a tick in the order in which they are to be sent.
class Outbox {
 public:
  void clear() { count_ = 0; }
  // Beyond kMost frames are dropped: check_drives() keeps the drives of a bus below that.
  void add(const CanFrame& frame) {
    if (count_ < kMost) frames_[count_++] = frame;
  }
  [[nodiscard]] std::span<const CanFrame> frames() const { return {frames_.data(), count_}; }

 private:
  static constexpr std::size_t kMost = 64;
  std::array<CanFrame, kMost> frames_{};
  std::size_t count_ = 0;
};

// How the drive's watchdog is known to be on.
enum class WatchdogProof : std::uint8_t {
  kReadBack,   // its registers say so, or each command carries it
  kBySilence,  // it is let run out once, and reports that
  kByHand,     // DriveConfig::watchdog_proven
};

class Protocol {
 public:
  virtual ~Protocol() = default;

  [[nodiscard]] virtual WatchdogProof proof() const noexcept = 0;
  // True: the frame has this drive's reply id.
  [[nodiscard]] virtual bool owns(const CanFrame& frame) const noexcept = 0;
  // Sets what the frame says in `sample`; an answer about the configuration in answer().
  [[nodiscard]] virtual Reply hear(const CanFrame& frame, Sample& sample) noexcept = 0;

  // Asks the drive to show itself, power stage off.
  virtual void discover(Outbox& out) noexcept = 0;
  // Asks for a value of its configuration; `again`: the question has been sent, the answer is awaited.
  virtual void ask(const ConfigItem& item, bool again, Outbox& out) noexcept = 0;
  [[nodiscard]] std::optional<double> take_answer() noexcept { return std::exchange(answer_, std::nullopt); }
  // True: the drive has named a firmware that is not of this protocol.
  [[nodiscard]] virtual bool wrong_version() const noexcept { return false; }

  // Asks for position and velocity, gives no torque, enables nothing.
  virtual void poll(Outbox& out) noexcept = 0;
  // The steps that switch it on without torque, one a tick; false: there is none of this number.
  [[nodiscard]] virtual bool enable(unsigned step, Outbox& out) noexcept = 0;
  virtual void command(const Command& command, Outbox& out) noexcept = 0;
  virtual void switch_off(Outbox& out) noexcept = 0;
  // For a drive that does not answer: without torque where it still hears, and nothing that enables it where it has restarted. A drive
  // that brakes by itself on silence gets silence.
  virtual void send_unheard(Outbox& out) noexcept = 0;
  // Switches it off too: whoever clears may not have seen that it is on.
  virtual void clear_faults(Outbox& out) noexcept = 0;

 protected:
  void set_answer(double value) { answer_ = value; }

 private:
  std::optional<double> answer_;
};

[[nodiscard]] std::unique_ptr<Protocol> make_protocol(const DriveConfig& config);

}  // namespace thimble::board::drives
