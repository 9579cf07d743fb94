// The telemetry of a device as a picture in a terminal: the tip, its force as bars and over time, and the state of the controller.
// No I/O: frames in, text out. `thimble monitor` draws it if its output is a terminal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/scene/limits.h"
#include "firmware/link/messages.h"

namespace thimble::host {

class MonitorScreen {
 public:
  // title: what is shown. utf8: the terminal has block characters.
  MonitorScreen(std::string title, std::uint8_t node, bool utf8)
      : title_(std::move(title)), node_(node), utf8_(utf8) {}

  void take(const firmware::link::CanFrame& frame);
  // The name of an object of the scene.
  void name(std::uint8_t object, const std::string& name) { names_[object] = name; }
  // Why the arm is no longer armed; shown until it is armed again.
  void stopped(std::string why) { stopped_by_ = std::move(why); }
  // A step of the curves: the largest force since the last one.
  void step();
  // Lines of at most so many characters, each ending in a line feed.
  [[nodiscard]] std::string text(std::size_t columns) const;

 private:
  struct Arm {
    bool seen = false;
    firmware::link::Pose pose;
    firmware::link::Force force;
    float most_N = 0.0F;  // since the last step
    std::vector<float> past_N;
    std::map<std::uint8_t, int>
        inside;  // objects that the tip is inside of, and the steps since that was told
  };

  void take(const firmware::link::Pose& pose);
  void take(const firmware::link::Force& force);
  void take(const firmware::link::Status& status) {
    status_ = status;
    if (status.mode == firmware::link::Mode::kArmed) stopped_by_.clear();
  }
  void take(const firmware::link::Inside& inside);
  template <class Message>
  void take(const Message&) {}
  [[nodiscard]] std::string bar(float value, float full, std::size_t half) const;
  [[nodiscard]] std::string curve(const Arm& arm, float full, std::size_t columns) const;

  std::string title_;
  std::uint8_t node_;
  bool utf8_;
  std::optional<firmware::link::Status> status_;
  std::string stopped_by_;
  std::array<Arm, control::kMaxArms> arms_;
  std::map<std::uint8_t, std::string> names_;
};

}  // namespace thimble::host
