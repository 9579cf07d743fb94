// Sends a scene image to a device and makes it the running scene, or an arm image, which is its arm after a restart: the function behind
// Device::upload(). An upload that was broken
// off continues where it stopped, also from another program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

namespace thimble::host {

class ServiceClient;

struct UploadProgress {
  std::uint32_t sent = 0;          // bytes of the image that the device holds
  std::uint32_t total = 0;         // bytes of the image
  std::uint32_t resumed_from = 0;  // bytes that it held at the start
  double bytes_per_s = 0;
};
using UploadListener = std::function<void(const UploadProgress&)>;

struct UploadResult {
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
  std::uint32_t resumed_from = 0;
  std::uint32_t retried_blocks = 0;
  double seconds = 0;
  double bytes_per_s = 0;  // of what was sent
};

struct UploadOptions {
  std::optional<std::uint32_t> crc{};  // announced for the image; default: computed from it
  bool verify = true;                  // afterwards ask the device which image it runs, or has stored
  std::optional<std::uint8_t> arm{};   // the image is that of this arm; default: of a scene
};

// `progress` (may be empty) is called after every block; what it throws ends the upload and passes through.
// Errors: kLinkLost, no progress in kMaxStalls tries. kRefused, with the device's reason. kCommanded: another program's upload did not
// end in 10 s, or it has armed the device.
// kVerification, the device received other bytes than were announced, or runs another image.
UploadResult upload_image(ServiceClient& services, std::span<const std::byte> image,
                          const UploadOptions& options, const UploadListener& progress);

}  // namespace thimble::host
