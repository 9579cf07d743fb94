// Why a request is refused, as text: what kDidRefusal (22 F1AA) tells the host that was refused.
//
//   condition names   arming, homing, moves, recordings: firmware/core/conditions.def, a list ("not_homed,no_scene")
//   store statuses    downloads: name(StoreStatus), or the verdict on the image
//   busy reasons      all reasons for the answer "busy, repeat" (21) to a host with a place: kBusyTable; docs/link.md has them for users
#pragma once

#include <array>

#include "firmware/core/core.h"
#include "firmware/services/call.h"
#include "firmware/store/scene_store.h"

namespace thimble::firmware {

// Each ends by itself: the host may repeat its request.
enum class Busy : std::uint8_t {
  kSceneSwitching,
  kOtherHostCommands,
  kOtherHostUploads,
  kCommandPending,
  kRestarting
};
struct BusyRow {
  Busy busy;
  const char* name;
  const char* meaning;
};
inline constexpr std::array<BusyRow, 5> kBusyTable = {{
    {Busy::kSceneSwitching, "scene_switching",
     "the tick has not taken the scene that was activated last; until then it reads the slot that a download "
     "would erase"},
    {Busy::kOtherHostCommands, "other_host_commands", "another host has given a command in the last 1.5 s"},
    {Busy::kOtherHostUploads, "other_host_uploads",
     "the image to activate is another host's; it is so until that host's session ends or another host "
     "prepares a download"},
    {Busy::kCommandPending, "command_pending", "the tick has not executed the last command yet"},
    {Busy::kRestarting, "restarting",
     "a host has asked for a restart, and the board restarts once the motors are off"},
}};

// The text of a command that is refused while another host has the arm armed (answer 22).
inline constexpr const char* kOtherHostsArm = "other_hosts_arm";

Nrc busy(Host& host, Busy reason) noexcept;                                       // kBusyRepeatRequest
Nrc refuse(Host& host, Conditions conditions, const char* board_lacks) noexcept;  // kConditionsNotCorrect
Nrc refuse(Host& host, StoreStatus status) noexcept;  // the code that belongs to it; kOk for kOk

}  // namespace thimble::firmware
