#include "board/linux/drives/protocol.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"

namespace thimble::board::drives {
namespace {

class Moteus final : public Protocol {
 public:
  explicit Moteus(const DriveConfig& config)
      : config_(config),
        timeout_ms_(static_cast<std::uint16_t>(std::max(1L, std::lround(config.watchdog_s * 1000)))) {}

  WatchdogProof proof() const noexcept override { return WatchdogProof::kReadBack; }
  bool owns(const CanFrame& frame) const noexcept override {
    return !frame.remote && (frame.id & 0xFFFFU) == moteus::reply_id(config_.id);
  }
  Reply hear(const CanFrame& frame, Sample& sample) noexcept override {
    const moteus::Unpacked unpacked = moteus::unpack(config_.id, frame, sample);
    if (unpacked.reply == Reply::kAnswer) take_text(unpacked.text);
    return unpacked.reply;
  }
  void discover(Outbox& out) noexcept override { out.add(moteus::pack_home_query(config_.id)); }
  void ask(const ConfigItem& item, bool again, Outbox& out) noexcept override {
    if (again) {
      out.add(moteus::pack_text(config_.id, {}));
      return;
    }
    std::array<char, moteus::kMostText> text{};
    std::size_t used = 0;
    for (const std::string_view part :
         {std::string_view("conf get "), std::string_view(item.name), std::string_view("\n")})
      for (const char c : part)
        if (used < text.size()) text[used++] = c;
    line_ = 0;
    out.add(moteus::pack_text(config_.id, {text.data(), used}));
  }
  void poll(Outbox& out) noexcept override {
    out.add(moteus::pack_query(config_.id, moteus::Query::kCounted));
  }
  bool enable(unsigned step, Outbox& out) noexcept override {
    (void)step, (void)out;
    return false;  // a command enables
  }
  void command(const Command& command, Outbox& out) noexcept override {
    const bool brief = config_.short_frames && ++since_all_ < 10;
    if (!brief) since_all_ = 0;
    // The short form is without a watchdog word: the drive's own default is checked and holds.
    out.add(moteus::pack_motion(
        config_.id,
        {command.torque_N_m, moteus::kd_scale_of(command.damping_N_m_s_rad, config_.moteus_kd),
         config_.short_frames ? std::uint16_t{0} : timeout_ms_},
        !config_.short_frames ? moteus::Query::kCounted
        : brief               ? moteus::Query::kMotion
                              : moteus::Query::kAll));
  }
  void switch_off(Outbox& out) noexcept override {
    out.add(moteus::pack_stop(config_.id, moteus::Query::kCounted));
  }
  void send_unheard(Outbox& out) noexcept override { poll(out); }
  void clear_faults(Outbox& out) noexcept override { switch_off(out); }

 private:
  void take_text(std::string_view text) noexcept {
    for (const char c : text) {
      if (c != '\r' && c != '\n') {
        if (line_ < text_.size()) text_[line_++] = c;
        continue;
      }
      if (line_ == 0) continue;
      double value = static_cast<double>(kNoValue);  // "ERR ...": no such name
      std::from_chars(text_.data(), text_.data() + line_, value);
      line_ = 0;
      set_answer(value);
    }
  }

  DriveConfig config_;
  std::uint16_t timeout_ms_;
  unsigned since_all_ = 0;
  std::array<char, 64> text_{};
  std::size_t line_ = 0;
};

class Odrive final : public Protocol {
 public:
  explicit Odrive(const DriveConfig& config) : config_(config), is06_(config.kind == Kind::kOdrive06) {}

  WatchdogProof proof() const noexcept override {
    return is06_ ? WatchdogProof::kReadBack : WatchdogProof::kBySilence;
  }
  bool owns(const CanFrame& frame) const noexcept override {
    return !frame.extended && !frame.remote && frame.id >> 5U == config_.id && frame.size != 0;
  }
  Reply hear(const CanFrame& frame, Sample& sample) noexcept override {
    const odrive::Unpacked unpacked =
        odrive::unpack(config_.id, is06_, config_.torque_constant_N_m_A, frame, sample);
    if (unpacked.reply != Reply::kAnswer) return unpacked.reply;
    if (unpacked.message == odrive::Message::kVersion) {
      wrong_version_ = !is06_ || (unpacked.version.major == 0 && unpacked.version.minor < 6);
    } else if (unpacked.endpoint == asked_) {
      set_answer(asked_integer_ ? static_cast<double>(unpacked.value)
                                : static_cast<double>(std::bit_cast<float>(unpacked.value)));
    }
    return Reply::kAnswer;
  }
  bool wrong_version() const noexcept override { return wrong_version_; }
  void discover(Outbox& out) noexcept override {
    out.add(odrive::pack_request(config_.id, odrive::Message::kVersion));
  }
  void ask(const ConfigItem& item, bool again, Outbox& out) noexcept override {
    if (again) return;
    asked_ = item.number;
    asked_integer_ = item.integer;
    out.add(odrive::pack_read_endpoint(config_.id, item.number));
  }
  // Its watchdog runs while it is off too, so it is fed.
  void poll(Outbox& out) noexcept override { add_with_request(odrive::pack_torque(config_.id, 0), out); }
  bool enable(unsigned step, Outbox& out) noexcept override {
    const bool damped = config_.base_damping_N_m_s_rad > 0;
    const CanFrame steps[] = {
        // Above three times the top speed: the drive takes torque away near its limit.
        odrive::pack_limits(config_.id, 3.5F * config_.top_speed_rad_s, config_.current_limit_A),
        // Without damping the gain stays: a gain of 0 with the drive's velocity limit would leave no torque.
        damped ? odrive::pack_damping(config_.id, config_.base_damping_N_m_s_rad) : torque_frame(0),
        odrive::pack_controller_modes(config_.id,
                                      damped ? odrive::ControlMode::kVelocity : odrive::ControlMode::kTorque),
        torque_frame(0),
        odrive::pack_axis_state(config_.id, odrive::AxisState::kClosedLoop),
    };
    if (step >= std::size(steps)) return false;
    add_with_request(steps[step], out);
    return true;
  }
  void command(const Command& command, Outbox& out) noexcept override {
    add_with_request(torque_frame(command.torque_N_m), out);
  }
  void switch_off(Outbox& out) noexcept override {
    add_with_request(odrive::pack_axis_state(config_.id, odrive::AxisState::kIdle), out);
  }
  // Any frame feeds its watchdog, so it must not be one that leaves the last torque on.
  void send_unheard(Outbox& out) noexcept override { command({}, out); }
  void clear_faults(Outbox& out) noexcept override {
    out.add(odrive::pack_axis_state(config_.id, odrive::AxisState::kIdle));
    out.add(odrive::pack_clear_errors(config_.id, is06_));
  }

 private:
  [[nodiscard]] CanFrame torque_frame(float torque_N_m) const noexcept {
    return config_.base_damping_N_m_s_rad > 0 ? odrive::pack_damped_torque(config_.id, torque_N_m)
                                              : odrive::pack_torque(config_.id, torque_N_m);
  }
  void add_with_request(const CanFrame& frame, Outbox& out) const noexcept {
    out.add(frame);
    if (config_.request_estimates) out.add(odrive::pack_request(config_.id, odrive::Message::kEstimates));
  }

  DriveConfig config_;
  bool is06_;
  bool wrong_version_ = false;
  std::uint16_t asked_ = 0;
  bool asked_integer_ = false;
};

class Mit final : public Protocol {
 public:
  explicit Mit(const DriveConfig& config) : config_(config), fd_(is_fd(config.kind)) {}

  WatchdogProof proof() const noexcept override {
    return is_damiao(config_.kind) ? WatchdogProof::kReadBack : WatchdogProof::kByHand;
  }
  bool owns(const CanFrame& frame) const noexcept override {
    return !frame.extended && !frame.remote && frame.id == config_.reply_id;
  }
  Reply hear(const CanFrame& frame, Sample& sample) noexcept override {
    if (frame.fd != fd_) return Reply::kMalformed;
    const mit::Unpacked unpacked =
        mit::unpack(config_.kind, config_.id, config_.reply_id, config_.ranges, asked_, frame, sample);
    if (unpacked.reply == Reply::kAnswer) {
      set_answer(asked_integer_ ? static_cast<double>(unpacked.value)
                                : static_cast<double>(std::bit_cast<float>(unpacked.value)));
      asked_ = 0;
    }
    return unpacked.reply;
  }
  void discover(Outbox& out) noexcept override { switch_off(out); }
  void ask(const ConfigItem& item, bool again, Outbox& out) noexcept override {
    if (again) return;
    asked_ = static_cast<std::uint8_t>(item.number);
    asked_integer_ = item.integer;
    out.add(mit::pack_read_register(config_.id, asked_, fd_));
  }
  void poll(Outbox& out) noexcept override { switch_off(out); }
  bool enable(unsigned step, Outbox& out) noexcept override {
    if (step > 0) return false;
    out.add(mit::pack_magic(config_.id, mit::Magic::kEnable, fd_));
    return true;
  }
  void command(const Command& command, Outbox& out) noexcept override {
    out.add(mit::pack(config_.id, dither_.codes(command, config_.ranges), fd_));
  }
  void switch_off(Outbox& out) noexcept override {
    asked_ = 0;
    out.add(mit::pack_magic(config_.id, mit::Magic::kDisable, fd_));
  }
  void send_unheard(Outbox& out) noexcept override { command({0, config_.base_damping_N_m_s_rad}, out); }
  void clear_faults(Outbox& out) noexcept override {
    if (is_damiao(config_.kind)) out.add(mit::pack_magic(config_.id, mit::Magic::kClearError, fd_));
    switch_off(out);
  }

 private:
  DriveConfig config_;
  bool fd_;
  mit::Dither dither_;
  std::uint8_t asked_ = 0;  // a register; 0: none
  bool asked_integer_ = false;
};

}  // namespace

std::unique_ptr<Protocol> make_protocol(const DriveConfig& config) {
  if (is_moteus(config.kind)) return std::make_unique<Moteus>(config);
  if (is_odrive(config.kind)) return std::make_unique<Odrive>(config);
  return std::make_unique<Mit>(config);
}

}  // namespace thimble::board::drives
