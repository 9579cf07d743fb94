// DeviceSession: what pages are told of the device: which one it is, and its states.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include "firmware/params.h"
#include "host-tools/compiler/stable_stiffness.h"
#include "host-tools/viewer/device_session.h"

namespace thimble::host {
namespace {

using link::Micros;

constexpr Micros kLook_us = 500'000;  // interval of reading the state: another host may have sent a scene

}  // namespace

// What is to be drawn of them. A simulated device tells the angles of its joints; what a real one tells is a parameter of its user.
void DeviceSession::learn_arms() {
  const std::vector<std::string> names = names_of_arms(device_->text(link::kDidArmName));
  const link::ArmImages images = device_->arm_images();
  std::array<std::size_t, 2> axes{};
  for (std::size_t arm = 0; arm < drawings_.size(); ++arm) {
    drawings_.at(arm).reset();
    if (arm >= arms_ || arm >= names.size()) continue;
    std::optional<kinematics::ArmData> data = options_.arm_data;
    if (!data && options_.arm_of) data = options_.arm_of(names[arm], images.crc.at(arm));
    if (!data) continue;
    drawings_.at(arm) = std::make_unique<ArmDrawing>(*data);
    axes.at(arm) = drawings_.at(arm)->axes();
  }
  live_ = LiveState(device_->info().node, arms_, axes);
  if (hands_ == nullptr) return;
  const firmware::ParamRow& content = *firmware::find_param(std::string_view("telemetry_content"));
  const auto told = static_cast<std::uint32_t>(device_->read_param(content));
  if ((told & link::kContentJointAngles) == 0)
    device_->write_param(content, told | static_cast<std::uint32_t>(link::kContentJointAngles));
}

void DeviceSession::send_hello() {
  Json hello = {{"type", "hello"},
                {"version", options_.version},
                {"simulated", hands_ != nullptr},
                {"may_control", false},
                {"arms", arms_}};
  hello["device"] = {{"address", address_},
                     {"board", device_->text(link::kDidBoardName)},
                     {"firmware", device_->text(link::kDidFirmwareVersion)},
                     {"arm", device_->text(link::kDidArmName)}};
  hello["parameters"] = Json::array();
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    const double value = device_->read_param(row);
    if (std::string_view(row.name) == "telemetry_decimation") decimation_ = value;
    hello["parameters"].push_back(
        {{"name", row.name},
         {"value", row.type == firmware::ParamType::kUnsigned ? Json(static_cast<std::uint64_t>(value))
                                                              : Json(exact(static_cast<float>(value)))},
         {"unit", row.unit},
         {"min", exact(row.min)},
         {"max", exact(row.max)},
         {"writable", row.access == firmware::Access::kAlways},  // while armed
         {"text", row.text}});
  }
  sink_.hello(std::move(hello));
}

void DeviceSession::send_state(Micros now) {
  Json json = {{"type", "state"}};
  json["time_s"] = std::round(static_cast<double>(now - begun_us_) * 1e-2) / 1e4;
  if (hands_ != nullptr) {
    const SimulatedHands::Stamp stamp = hands_->stamp(live_.sequence());
    json["tick"] = stamp.tick;
    json["since_us"] = stamp.since_us;
  } else if (device_state_us_ != 0) {
    const double since_s = static_cast<double>(now - device_state_us_) * 1e-6;
    json["tick"] = device_state_.tick + static_cast<std::uint64_t>(std::max(
                                            0.0, since_s * static_cast<double>(device_state_.tick_rate_Hz)));
  }
  json.update(live_.json(now));
  for (std::size_t arm = 0; arm < json["arms"].size() && arm < drawings_.size(); ++arm) {
    const std::optional<LiveState::Joints>& joints = live_.joints(arm);
    if (json["arms"][arm].is_null() || !joints || !drawings_.at(arm)) continue;
    if (Json lines = drawings_.at(arm)->lines(joints->axes, joints->tip_m); !lines.is_null())
      json["arms"][arm]["links_m"] = std::move(lines);
  }
  if (hands_ != nullptr) {
    for (std::size_t arm = 0; arm < json["arms"].size() && arm < hands_->arms(); ++arm) {
      if (json["arms"][arm].is_null()) continue;
      Json hand = Json::array();
      for (const double value : hands_->hand_m(arm)) hand.push_back(std::round(value * 1e6) / 1e6);
      json["arms"][arm]["hand_m"] = std::move(hand);
    }
  }
  sink_.state(to_text(json));
}

void DeviceSession::look_at_device() {
  look_due_us_ = now_us() + kLook_us;
  device_state_ = device_->state();
  device_state_us_ = now_us();
  live_.take_state(device_state_);
  if (device_state_.tick_rate_Hz > 0)
    live_.set_record_period(decimation_ / static_cast<double>(device_state_.tick_rate_Hz));
  if (shown_crc_ == device_state_.scene_crc && (running_ || !scenes_.knows_more())) return;
  const std::uint32_t crc = device_state_.scene_crc;
  show_scene(device_state_.scene_bytes == 0 ? "" : device_->text(link::kDidSceneName), crc);
}

}  // namespace thimble::host
