// The codecs of the drives as a filter, for codec_sweep.py: a line of JSON on stdin is a command to pack or a frame to unpack, a line on
// stdout is the frame or the sample.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "board/linux/drives/mit.h"
#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"
#include "tests/unit/drives/hex.h"

namespace {

using namespace thimble::board::drives;
using nlohmann::json;
using thimble::test::frame_of_hex;
using thimble::test::hex_of;

json of(const CanFrame& frame) {
  return {{"id", frame.id},
          {"fd", frame.fd},
          {"extended", frame.extended},
          {"remote", frame.remote},
          {"data", hex_of(frame)}};
}

json number(float value) { return std::isnan(value) ? json() : json(value); }

json of(Reply reply, const Sample& sample) {
  return {{"reply", static_cast<int>(reply)},
          {"position_rad", number(sample.position_rad)},
          {"velocity_rad_s", number(sample.velocity_rad_s)},
          {"torque_N_m", number(sample.torque_N_m)},
          {"current_A", number(sample.current_A)},
          {"supply_V", number(sample.supply_V)},
          {"drive_C", number(sample.drive_C)},
          {"motor_C", number(sample.motor_C)},
          {"stage", static_cast<int>(sample.stage)},
          {"fault", sample.drive_fault}};
}

mit::Ranges ranges(const json& in) {
  return mit::ranges_of(in["ranges"][0].get<float>(), in["ranges"][1].get<float>(),
                        in["ranges"][2].get<float>());
}

json pack(const json& in) {
  const std::string what = in["pack"];
  const auto id = in["id"].get<std::uint8_t>();
  const auto value = [&in](const char* name) { return in[name].get<float>(); };
  if (what == "moteus")
    return of(moteus::pack_motion(id,
                                  {value("torque"), value("kd_scale"), in["timeout_ms"].get<std::uint16_t>()},
                                  static_cast<moteus::Query>(in["query"].get<int>())));
  if (what == "torque") return of(odrive::pack_torque(id, value("torque")));
  if (what == "damped_torque") return of(odrive::pack_damped_torque(id, value("torque")));
  if (what == "damping") return of(odrive::pack_damping(id, value("damping")));
  if (what == "limits") return of(odrive::pack_limits(id, value("velocity"), value("current")));
  if (what == "state")
    return of(odrive::pack_axis_state(id, static_cast<odrive::AxisState>(in["state"].get<int>())));
  if (what == "modes")
    return of(odrive::pack_controller_modes(id, static_cast<odrive::ControlMode>(in["mode"].get<int>())));
  const mit::Ranges r = ranges(in);  // "mit"
  const mit::Codes codes{mit::nearest(value("p"), r.position), mit::nearest(value("v"), r.velocity),
                         mit::nearest(value("kp"), r.kp), mit::nearest(value("kd"), r.kd),
                         mit::nearest(value("t"), r.torque)};
  return of(mit::pack(id, codes, in["fd"].get<bool>()));
}

json unpack(const json& in) {
  const std::string what = in["unpack"];
  const auto id = in["id"].get<std::uint8_t>();
  const CanFrame frame =
      frame_of_hex(in["frame_id"].get<std::uint32_t>(), in["data"].get<std::string>(), in["fd"].get<bool>());
  Sample sample;
  if (what == "moteus") {
    const auto reply = moteus::unpack(id, frame, sample).reply;
    return of(reply, sample);
  }
  if (what == "odrive") {
    const auto reply =
        odrive::unpack(id, in["firmware06"].get<bool>(), in["kt"].get<float>(), frame, sample).reply;
    return of(reply, sample);
  }
  const auto reply = mit::unpack(static_cast<Kind>(in["kind"].get<int>()), id,
                                 in["frame_id"].get<std::uint16_t>(), ranges(in), 0, frame, sample)
                         .reply;
  return of(reply, sample);
}

}  // namespace

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    const json in = json::parse(line);
    std::puts((in.contains("pack") ? pack(in) : unpack(in)).dump().c_str());
  }
}
