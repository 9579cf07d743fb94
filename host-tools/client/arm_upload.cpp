#include "host-tools/client/arm_upload.h"

#include <chrono>
#include <thread>
#include <utility>

namespace thimble::host {
namespace {

// Its arms after its restart, which begins when the audit record has room (firmware/store/audit_log.h), and takes a moment. Returns what they
// are at last, also where that is not `crc`.
std::string restarted_arms(const std::function<Device()>& open, std::size_t arm, std::uint32_t crc,
                           bool& has_it) {
  constexpr auto kPatience = std::chrono::seconds(30);
  constexpr auto kPause = std::chrono::milliseconds(300);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    std::this_thread::sleep_for(kPause);
    const bool is_last = std::chrono::steady_clock::now() > deadline;
    try {
      Device device = open();
      has_it = device.arm_images().crc.at(arm) == crc;
      if (has_it || is_last) return device.text(link::kDidArmName);
    } catch (const Error& error) {
      if (!is_last) continue;
      throw Error(ExitCode::kVerification, "verification-failed",
                  "the arm is stored, and the device does not answer after its restart: " + error.cause,
                  "read what its program says: the configuration of a thimble-board may not fit the arm "
                  "(`thimble-board --check` there; docs/board-linux.md)");
    }
  }
}

}  // namespace

ArmUpload replace_arm(const std::function<Device()>& open, Device device, std::uint8_t arm,
                      const std::string& name, std::span<const std::byte> image) {
  ArmUpload result;
  {
    Device old = std::move(device);  // some links carry one program at a time
    result.upload = old.upload(image, {.arm = arm}, {});
    old.restart();
  }
  bool has_it = false;
  result.arms = restarted_arms(open, arm, result.upload.crc, has_it);
  if (!has_it) {
    throw Error(
        ExitCode::kVerification, "verification-failed",
        "after its restart the device works with " + result.arms + ", not with " + name,
        "read `thimble info`: it says what is stored, and whether it is damaged; then repeat the upload");
  }
  return result;
}

}  // namespace thimble::host
