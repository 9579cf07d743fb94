// The download of a scene image into the spare slot (services 34, 36, 37; routines 0205 prepare, 0204 activate). The running
// scene is never touched before the activation.
//
// There is one download at a time. It belongs to the host that prepared it, until it is activated or fails, or until that host's
// session ends. Other hosts are answered "busy" meanwhile (refusal.h, kOtherHostUploads). If the owner was silent for more than
// kSilence_us, the next host that prepares a download becomes the owner. The next block of the old owner is then refused (24, wrong
// order), and it may prepare again.
#pragma once

#include <cstdint>

#include "firmware/services/call.h"

namespace thimble::firmware {

class Download {
 public:
  explicit Download(std::uint16_t block_bytes) noexcept : block_bytes_(block_bytes) {}

  // Longer than the gaps of an upload, because a host repeats a lost block after 0.1 s. Shorter than link::kHostTimeout_us, so that
  // an upload whose program was killed need not wait until that program's place ends.
  static constexpr link::Micros kSilence_us = 1'000'000;

  [[nodiscard]] bool belongs_to_another(const Host& host) const noexcept {
    return owner_ != nullptr && owner_ != &host;
  }
  [[nodiscard]] bool may_be_prepared_by(const Host& host, link::Micros now_us) const noexcept {
    return !belongs_to_another(host) || now_us - owner_->heard_us > kSilence_us;
  }
  void prepare(const Host& host, std::uint32_t length, std::uint32_t has) noexcept;
  // The host must prepare again; the download still belongs to it.
  void start_over(const Host& host) noexcept;
  // Ends the host's download, if it has one. The bytes that have arrived stay in the store; a host that prepares the same image goes on
  // from there.
  void end(const Host& host) noexcept;

  // Checks the host's next step against the protocol; kOk: the store may act.
  [[nodiscard]] Nrc begin(const Host& host, std::uint32_t offset, std::uint32_t bytes) noexcept;
  // `repeated`: the block is stored already; its answer was lost.
  [[nodiscard]] Nrc check_block(const Host& host, std::uint8_t number, std::size_t bytes,
                                bool& repeated) const noexcept;
  void block_stored(std::uint8_t number, std::size_t bytes) noexcept;
  // `finished`: it has ended well already; its answer was lost.
  [[nodiscard]] Nrc check_exit(const Host& host, bool& finished) const noexcept;
  // No more blocks. After success the download belongs to the host until the activation; after a failure to nobody.
  void finish(bool well) noexcept;

  [[nodiscard]] std::uint32_t offset() const noexcept { return offset_; }
  [[nodiscard]] std::uint16_t block_bytes() const noexcept { return block_bytes_; }

 private:
  enum class State : std::uint8_t { kNone, kPrepared, kTakesBlocks, kFinished };

  [[nodiscard]] State state(const Host& host) const noexcept {
    return owner_ == &host ? state_ : State::kNone;
  }

  std::uint16_t block_bytes_;    // the most that a block may hold
  const Host* owner_ = nullptr;  // null: nobody's
  State state_ = State::kNone;
  std::uint32_t length_ = 0;
  std::uint32_t offset_ = 0;  // bytes that the controller holds
  std::uint8_t last_block_ = 0;
  bool any_block_ = false;
};

}  // namespace thimble::firmware
