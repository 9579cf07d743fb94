#include "host-tools/client/upload.h"

#include <algorithm>
#include <utility>

#include "firmware/link/crc32.h"
#include "host-tools/client/requests.h"
#include "host-tools/client/service_client.h"

namespace thimble::host {
namespace {

using link::Micros;
using link::Nrc;
using link::Routine;
using link::Service;
using Answer = ServiceClient::Answer;

constexpr std::size_t kSmallestBlock = 64;
constexpr Micros kBlockAnswer_us = 100'000;  // the shortest time that a block's answer is waited for
constexpr unsigned kMaxStalls = 20;          // failures in a row without a byte of progress
constexpr Micros kSwitch_us = 1'000'000;     // how long the tick may take to switch to the new scene

std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8U | bytes[at + i];
  return value;
}

bool other_sequence(Nrc code) { return code == Nrc::kRequestSequenceError || code == Nrc::kNotInThisSession; }

class Upload {
 public:
  Upload(ServiceClient& services, std::span<const std::byte> image, const UploadOptions& options,
         const UploadListener& progress)
      : services_(services), image_(image), options_(options), progress_(progress) {
    result_.bytes = length_;
    result_.crc = options.crc ? *options.crc : link::crc32(image);
  }

  UploadResult run() {
    // A failed step leaves open how much the device has received. So each attempt begins with that question.
    while (!(prepare() && request_download() && transfer() && exit_transfer())) stalled();
    result_.seconds = seconds();
    result_.bytes_per_s = (length_ - begun_at_) / std::max(result_.seconds, 1e-6);
    activate();
    return result_;
  }

 private:
  // Each step: false, begin again with the first one.

  // Announces the image; the device says how many of its bytes it holds.
  bool prepare() {
    services_.enter(link::Session::kProgramming);
    Bytes request = routine_request(options_.arm ? Routine::kPrepareArm : Routine::kPrepareDownload);
    if (options_.arm) request.push_back(*options_.arm);
    put_u32(request, length_);
    put_u32(request, result_.crc);
    const Answer prepared = services_.request(request);
    if (prepared.code != Nrc::kOk) services_.refused("the upload", prepared.code);
    const Bytes& has = prepared.bytes;
    if (has.size() != 8 || u32_at(has, 4) > length_) services_.refused("the upload", Nrc::kIncorrectLength);
    sent_ = u32_at(has, 4);
    if (first_) result_.resumed_from = begun_at_ = sent_;
    begun_at_ = std::min(begun_at_, sent_);
    first_ = false;
    return true;
  }

  bool request_download() {
    Bytes request = {byte_of(Service::kRequestDownload), 0x00, 0x44};
    put_u32(request, sent_);
    put_u32(request, length_ - sent_);
    const Answer accepted = services_.request(request);
    if (other_sequence(accepted.code)) return false;
    if (accepted.code != Nrc::kOk) services_.refused("the upload", accepted.code);
    if (accepted.bytes.size() >= 4) {
      const std::size_t most = static_cast<std::size_t>(accepted.bytes[2]) << 8U | accepted.bytes[3];
      if (most > 2) most_ = std::min(most_, most - 2);
      block_ = std::min(block_, most_);
    }
    return true;
  }

  bool transfer() {
    std::uint8_t counter = 1;
    while (sent_ < length_) {
      const std::size_t bytes = std::min<std::size_t>(block_, length_ - sent_);
      Bytes request = {byte_of(Service::kTransferData), counter++};
      request.reserve(2 + bytes);
      for (const std::byte b : image_.subspan(sent_, bytes)) request.push_back(static_cast<std::uint8_t>(b));
      const Micros asked_us = now_us();
      const std::optional<Answer> answer =
          services_.try_request(request, 1, std::min(patience_us_, services_.options().answer_us));
      if (answer && answer->code == Nrc::kProgrammingFailure) services_.refused("the upload", answer->code);
      if (!answer || answer->code != Nrc::kOk) {
        ++result_.retried_blocks;
        return false;
      }
      sent_ += static_cast<std::uint32_t>(bytes);
      stalls_ = 0;
      patience_us_ = std::max(kBlockAnswer_us, 4 * (now_us() - asked_us));
      block_ = std::min(most_, block_ + block_ / 8 + 1);
      const double rate = (sent_ - begun_at_) / std::max(seconds(), 1e-6);
      if (progress_) progress_({sent_, length_, result_.resumed_from, rate});
    }
    return true;
  }

  bool exit_transfer() {
    const Answer exit = services_.request({byte_of(Service::kTransferExit)});
    if (other_sequence(exit.code)) return false;
    if (exit.code == Nrc::kProgrammingFailure && services_.text(link::kDidRefusal) == "wrong_crc") {
      throw Error(ExitCode::kVerification, "wrong-crc",
                  "the bytes that the device received do not match the announced CRC (wrong_crc)",
                  "compile the image again if it is a file, and repeat; what the device runs is untouched");
    }
    if (exit.code != Nrc::kOk) services_.refused("the image", exit.code);
    return true;
  }

  void activate() {
    if (options_.arm) {
      activate_arm(*options_.arm);
      return;
    }
    const Answer activated = services_.request(routine_request(Routine::kActivate));
    if (activated.code == Nrc::kOk && !options_.verify) return;
    bool running = false;
    const Micros deadline_us = now_us() + kSwitch_us;
    while (!running && now_us() < deadline_us) {
      const link::DeviceState now = services_.state();
      running = now.scene_bytes == length_ && now.scene_crc == result_.crc;
    }
    // A repeated request may be refused because there is nothing left to activate. The running image decides.
    if (activated.code != Nrc::kOk && !running) services_.refused("running the scene", activated.code);
    if (!running) {
      throw Error(ExitCode::kVerification, "verification-failed",
                  "the device runs another image than the one uploaded", "repeat the upload");
    }
  }

  void activate_arm(std::uint8_t arm) {
    const Answer activated = services_.request(routine_request(Routine::kActivateArm));
    if (activated.code == Nrc::kOk && !options_.verify) return;
    const auto images = services_.record<link::ArmImages>("reading which arms are stored");
    const bool stored = images.next_crc.at(arm) == result_.crc;
    // As in activate(): what is stored decides.
    if (activated.code != Nrc::kOk && !stored) services_.refused("storing the arm", activated.code);
    if (!stored) {
      throw Error(ExitCode::kVerification, "verification-failed",
                  "the device has stored another arm image than the one uploaded", "repeat the upload");
    }
  }

  // The next blocks are smaller: ISO-TP repeats nothing, so a lossy link loses long blocks more often.
  void stalled() {
    block_ = std::max(kSmallestBlock, block_ / 2);
    if (++stalls_ <= kMaxStalls) return;
    throw Error(ExitCode::kLinkLost, "upload-stalled",
                "the upload got no further than " + std::to_string(sent_) + " of " + std::to_string(length_) +
                    " bytes",
                "check the link, then repeat the command: it goes on from there");
  }

  [[nodiscard]] double seconds() const { return static_cast<double>(now_us() - start_us_) * 1e-6; }

  ServiceClient& services_;
  std::span<const std::byte> image_;
  UploadOptions options_;
  const UploadListener& progress_;
  std::uint32_t length_ = static_cast<std::uint32_t>(image_.size());
  UploadResult result_;
  Micros start_us_ = now_us();
  std::size_t most_ = link::kMaxBlockBytes;             // of a block: what the device accepts
  std::size_t block_ = most_;                           // bytes of the next block
  Micros patience_us_ = services_.options().answer_us;  // four times what the last block took
  unsigned stalls_ = 0;
  bool first_ = true;
  std::uint32_t sent_ = 0;      // bytes that the device holds
  std::uint32_t begun_at_ = 0;  // the least of them that it held at the start of an attempt
};

}  // namespace

UploadResult upload_image(ServiceClient& services, std::span<const std::byte> image,
                          const UploadOptions& options, const UploadListener& progress) {
  return Upload(services, image, options, progress).run();
}

}  // namespace thimble::host
