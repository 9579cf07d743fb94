// The download of a scene image or an arm image into the spare slot (services 34, 36, 37; routines 0205 prepare, 0204 activate, and of an arm
// 020D and 020E). The running scene is never touched before the activation, and the arm not before the next start.
//
// There is one download at a time. It belongs to the host that prepared it, until it is activated or fails, until that host's session
// ends, or until another host, which has the lease then (lease.h), prepares one. The next block of the old owner is then refused (24,
// wrong order), and it may prepare again. Meanwhile no other host activates it (refusal.h, kOtherHostUploads).
#pragma once

#include <cstdint>

#include "firmware/services/call.h"

namespace thimble::firmware {

class Download {
 public:
  enum class Of : std::uint8_t { kScene, kArm };

  explicit Download(std::uint16_t block_bytes) noexcept : block_bytes_(block_bytes) {}

  [[nodiscard]] bool belongs_to_another(const Host& host) const noexcept {
    return owner_ != nullptr && owner_ != &host;
  }
  void prepare(const Host& host, Of of, std::uint32_t length, std::uint32_t has) noexcept;
  [[nodiscard]] bool of_arm() const noexcept { return of_ == Of::kArm; }
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
  Of of_ = Of::kScene;
  std::uint32_t length_ = 0;
  std::uint32_t offset_ = 0;  // bytes that the controller holds
  std::uint8_t last_block_ = 0;
  bool any_block_ = false;
};

}  // namespace thimble::firmware
