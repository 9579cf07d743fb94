// info: what a device is, and the state that it is in.
#include <fmt/format.h>

#include "control/scene/limits.h"
#include "firmware/core/faults.h"
#include "host-tools/cli/limits.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/flag_names.h"

namespace thimble::host {
namespace {

// "built in (no image is stored)", "stored, CRC 0123abcd; another one is used from the next start on".
std::string arm_source(const link::ArmImages& images, std::size_t arm) {
  if (images.damaged[arm]) return "DAMAGED in the store: upload it again (`thimble model upload`)";
  std::string text = images.crc[arm] == 0 ? "built in (no image is stored)"
                                          : fmt::format("stored, CRC {:08x}", images.crc[arm]);
  if (images.next_crc[arm] != images.crc[arm]) text += "; another one is used from the next start on";
  return text;
}

void say_arms(const link::LinkInfo& info, const std::string& names, const link::ArmImages& images) {
  say("arm        {}, {} arm(s), node {}, {}\n", names, info.arms, info.node,
      info.frame_bytes == link::kFdDataBytes ? "CAN FD" : "classic CAN");
  for (std::size_t i = 0; i < info.arms && i < images.crc.size(); ++i)
    say("arm {}      {}\n", i, arm_source(images, i));
}

// The bins that are not empty: " below_1us 39990, below_10us 10".
std::string histogram(const link::Lateness& late) {
  std::string text;
  link::visit_fields(late, [&text](auto row, const auto& value) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, std::uint32_t>) {
      if (value != 0) text += fmt::format("{} {} {}", text.empty() ? "" : ",", row.name, value);
    }
  });
  return text.empty() ? " none" : text;
}

Json limits_json() {
  Json json = Json::object();
  for (const LimitRow& row : scene_limits()) json[row.key] = row.value;
  return json;
}

void say_limits() {
  say("limits     {} objects, {} triangles, {} bytes a scene; {:g} N/m, {:g} Ns/m, friction {:g}\n",
      control::kMaxObjects, control::kMaxTriangles, control::kMaxImageBytes, control::kMaxStiffness_N_m,
      control::kMaxDamping_N_s_m, control::kMaxFriction);
  for (const LimitRow& row : scene_limits()) {
    say("  {:<24} {:>10}  {}\n", row.key, row.value.dump(), row.of);
  }
}

}  // namespace

void info(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  const link::DeviceState state = device.state();
  const link::Lateness late = device.lateness();
  const link::HostOrders orders = device.orders();
  const std::string board = device.text(link::kDidBoardName);
  const std::string reset_reason = device.text(link::kDidResetReason);
  const std::string set_aside = device.text(link::kDidSetAside);
  const std::string version = device.text(link::kDidFirmwareVersion);
  const std::string serial = device.text(link::kDidSerialNumber);
  const std::string arm = device.text(link::kDidArmName);
  const link::ArmImages images = device.arm_images();
  const std::string scene = device.text(link::kDidSceneName);
  const std::string commander = device.text(link::kDidCommander);
  const std::vector<Device::Inside> inside = device.inside();
  if (common.json) {
    Json json = document("info");
    json["firmware"] = version;
    json["board"] = board;
    json["reset_reason"] = reset_reason;
    json["set_aside"] = set_aside;
    json["serial"] = serial;
    json["arm"] = arm;
    json["arm_images"] = host::to_json(images);
    json["scene"] = scene;
    json["commander"] = commander;
    json["link"] = host::to_json(device.info());
    json["state"] = host::to_json(state);
    json["lateness"] = host::to_json(late);
    json["inside"] = Json::array();
    for (const Device::Inside& solid : inside)
      json["inside"].push_back({{"arm", solid.arm}, {"object", solid.object}, {"name", solid.name}});
    json["host_orders"] = host::to_json(orders);
    json["limits"] = limits_json();
    print(json);
    return;
  }
  say("firmware   {} (protocol {}, scene image {})\n", version, device.info().protocol, device.info().image);
  say("board      {}, last start: {}\n", board, reset_reason.empty() ? "not known why" : reset_reason);
  if (!set_aside.empty()) {
    say("left out   {}: the board crashed three times in a row with it; upload a scene or save the "
        "parameters "
        "again\n",
        set_aside);
  }
  say("serial     {}\n", serial);
  say_arms(device.info(), arm, images);
  say("mode       {}\n", mode_shown(state.mode, state.flags));
  say("commands   {}\n",
      state.commander == 0 ? "nobody" : fmt::format("host {:X} {}", state.commander, commander));
  say("key        {}: {}\n", link::name(state.key), description(state.key));
  if (state.stopped_by != link::StoppedBy::kNothing)
    say("last stop  {}: {}\n", link::name(state.stopped_by), description(state.stopped_by));
  if (const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(state.fault))) {
    say("fault      {} {}: {}\n", state.fault, row->name, row->cause);
  }
  if (state.scene_bytes == 0) {
    say("scene      none\n");
  } else {
    say("scene      {} ({} bytes, CRC {:08x}, activation {})\n", scene, state.scene_bytes, state.scene_crc,
        state.scene_sequence);
  }
  say("loop       {:.0f} Hz, tick {}, worst tick {:.1f} us, {} overruns\n", state.tick_rate_Hz, state.tick,
      state.worst_tick_s * 1e6F, state.overruns);
  say("probes     {} times some force was taken away to see whether the encoders count\n", state.probes);
  say("late       worst {:.1f} us; ticks:{}\n", late.worst_s * 1e6F, histogram(late));
  say("contact    {} ticks, peak {:.3f} N, mean {:.3f} N\n", state.contact_ticks, state.peak_force_N,
      state.mean_force_N);
  say("work       {} units a tick, at most {} done; {} ticks put something off{}\n", state.work_units,
      state.most_work, state.put_off,
      state.put_off == 0 ? "" : fmt::format(", the last at object {} of the scene", state.put_off_object));
  for (const Device::Inside& solid : inside)
    say("inside     the tip of arm {} is inside {}: move out\n", solid.arm, solid.name);
  if (orders.taken + orders.old + orders.wrong != 0) {
    say("orders     {} forces taken from a host, {} old, {} wrong; {} times none in time\n", orders.taken,
        orders.old, orders.wrong, orders.expired);
  }
  say_limits();
}

}  // namespace thimble::host
