#include "host-tools/client/remedies.h"

#include "firmware/core/conditions.h"

namespace thimble::host {

// The remedies of the condition table, and of what is no condition.
std::string remedy_of(const std::string& reasons) {
  std::string remedy;
  const auto add = [&remedy](const char* what) {
    remedy += (remedy.empty() ? "" : "; ") + std::string(what);
  };
  for (const firmware::ConditionRow& row : firmware::kConditionTable) {
    if (reasons.find(row.name) != std::string::npos) add(row.remedy);
  }
  // Not a condition: the scene has more of something than the controller takes.
  if (reasons.find("too_many") != std::string::npos) add("leave some out; the limits are in `thimble info`");
  // Busy: it passes by itself.
  if (reasons == "scene_switching" || reasons == "command_pending") add("repeat the command");
  if (reasons == "restarting") add("repeat the command when the controller has started again");
  if (reasons == "other_host_uploads") add("upload again");
  if (reasons == "other_host_commands" || reasons == "other_hosts_arm")
    add("let it end, or disarm the device (`thimble disarm`), then repeat");
  if (reasons == "no_key") add("set a key (`thimble key set`)");
  if (reasons == "key_damaged") add("erase what is stored of the key by hand (docs/link.md)");
  if (reasons.find("sound_arm_image") != std::string::npos)
    add("upload the arm's image again (`thimble model upload`)");
  // Of the bus.
  if (reasons == "needs_can_fd_or_lower_rate")
    add("run the loop at a lower rate, or use a controller and a bus with CAN FD");
  if (reasons == "bus_without_can_fd")
    add("leave telemetry_fd at 0, or use a controller and a bus with CAN FD");
  if (reasons == "lost_ticks_above_5_ms")
    add("choose a smaller one: (lost_ticks + 1) periods of the loop may be 5 ms");
  return remedy.empty() ? "remove what the device names, then repeat" : remedy;
}

bool is_of_its_own(const std::string& reason) { return reason == "lost_ticks_above_5_ms"; }

}  // namespace thimble::host
