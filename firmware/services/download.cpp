#include "firmware/services/download.h"

#include "control/scene/image_verdict.h"
#include "firmware/services/handlers.h"
#include "firmware/services/refusal.h"

namespace thimble::firmware {

// --- The protocol

void Download::prepare(const Host& host, Of of, std::uint32_t length, std::uint32_t has) noexcept {
  owner_ = &host;
  state_ = State::kPrepared;
  of_ = of;
  length_ = length;
  offset_ = has;
}

void Download::end(const Host& host) noexcept {
  if (owner_ != &host) return;
  owner_ = nullptr;
  state_ = State::kNone;
}

void Download::start_over(const Host& host) noexcept {
  if (owner_ == &host) state_ = State::kNone;
}

Nrc Download::begin(const Host& host, std::uint32_t offset, std::uint32_t bytes) noexcept {
  if (state(host) != State::kPrepared && state(host) != State::kTakesBlocks)
    return Nrc::kRequestSequenceError;
  if (offset != offset_ || bytes != length_ - offset_) return Nrc::kRequestOutOfRange;
  state_ = State::kTakesBlocks;
  last_block_ = 0;
  any_block_ = false;
  return Nrc::kOk;
}

Nrc Download::check_block(const Host& host, std::uint8_t number, std::size_t bytes,
                          bool& repeated) const noexcept {
  if (state(host) != State::kTakesBlocks) return Nrc::kRequestSequenceError;
  if (bytes > block_bytes_) return Nrc::kRequestOutOfRange;
  repeated = any_block_ && number == last_block_;
  if (repeated) return Nrc::kOk;
  if (number != static_cast<std::uint8_t>(last_block_ + 1)) return Nrc::kWrongBlockCounter;
  return bytes > length_ - offset_ ? Nrc::kTransferSuspended : Nrc::kOk;
}

void Download::block_stored(std::uint8_t number, std::size_t bytes) noexcept {
  offset_ += static_cast<std::uint32_t>(bytes);
  last_block_ = number;
  any_block_ = true;
}

Nrc Download::check_exit(const Host& host, bool& finished) const noexcept {
  finished = state(host) == State::kFinished;
  if (finished) return Nrc::kOk;
  return state(host) == State::kTakesBlocks && offset_ == length_ ? Nrc::kOk : Nrc::kRequestSequenceError;
}

void Download::finish(bool well) noexcept {
  state_ = well ? State::kFinished : State::kNone;
  if (!well) owner_ = nullptr;
}

// --- The services

// 31 01 0205 length(4) crc32(4): answers how many bytes of this very image the store holds already.
Nrc prepare_download(Services& services, Call& call) noexcept {
  ServiceParts& parts = services.parts;
  call.host.refuse("");
  // The tick still reads the slot that is to be erased.
  if (parts.core.sources().scene.pending()) return busy(call.host, Busy::kSceneSwitching);
  services.download.finish(false);  // whosever it was
  const std::uint32_t length = u32_at(routine_arguments(call), 0);
  const StoreStatus status = parts.store.begin(length, u32_at(routine_arguments(call), 4));
  if (status != StoreStatus::kOk) return refuse(call.host, status);
  const auto has = static_cast<std::uint32_t>(parts.store.offset());
  services.download.prepare(call.host, Download::Of::kScene, length, has);
  call.answer.put_u32(has);
  return Nrc::kOk;
}

// 31 01 020D arm(1) length(4) crc32(4): the same of an arm's image.
Nrc prepare_arm(Services& services, Call& call) noexcept {
  ServiceParts& parts = services.parts;
  call.host.refuse("");
  if (!motors_off(parts.core)) return refuse(call.host, kWrongMode, "");
  const std::uint8_t arm = routine_arguments(call)[0];
  if (arm >= parts.config.arm_count) return Nrc::kRequestOutOfRange;
  services.download.finish(false);  // whosever it was
  const std::uint32_t length = u32_at(routine_arguments(call), 1);
  const StoreStatus status = parts.arms.begin(arm, length, u32_at(routine_arguments(call), 5));
  if (status != StoreStatus::kOk) return refuse(call.host, status);
  const auto has = static_cast<std::uint32_t>(parts.arms.offset());
  services.download.prepare(call.host, Download::Of::kArm, length, has);
  call.answer.put_u32(has);
  return Nrc::kOk;
}

// 34 00 44 offset(4) bytes to come(4): the prepared image, from where the controller's copy ends.
Nrc request_download(Services& services, Call& call) noexcept {
  if (call.request.size() != 11) return Nrc::kIncorrectLength;
  if (call.request[1] != 0x00 || call.request[2] != 0x44) return Nrc::kRequestOutOfRange;
  const Nrc result = services.download.begin(call.host, u32_at(call.request, 3), u32_at(call.request, 7));
  if (result != Nrc::kOk) return result;
  call.answer.put(0x20);
  call.answer.put_u16(static_cast<std::uint16_t>(services.download.block_bytes() + link::kMaxPduBytes -
                                                 link::kMaxBlockBytes));
  return Nrc::kOk;
}

// 36 number data.
Nrc transfer_data(Services& services, Call& call) noexcept {
  if (call.request.size() < 3) return Nrc::kIncorrectLength;
  const std::uint8_t number = call.request[1];
  const std::span<const std::uint8_t> data = call.request.subspan(2);
  bool repeated = false;
  const Nrc allowed = services.download.check_block(call.host, number, data.size(), repeated);
  if (allowed != Nrc::kOk) return allowed;
  call.answer.put(number);
  if (repeated) return Nrc::kOk;
  const std::uint32_t offset = services.download.offset();
  const StoreStatus status = services.download.of_arm()
                                 ? services.parts.arms.write(offset, std::as_bytes(data))
                                 : services.parts.store.write(offset, std::as_bytes(data));
  if (status != StoreStatus::kOk) {
    services.download.finish(false);
    return refuse(call.host, status);
  }
  services.download.block_stored(number, data.size());
  return Nrc::kOk;
}

// 37: every byte is there. Checks length, CRC and the image itself.
Nrc transfer_exit(Services& services, Call& call) noexcept {
  if (call.request.size() != 1) return Nrc::kIncorrectLength;
  bool finished = false;
  const Nrc allowed = services.download.check_exit(call.host, finished);
  if (allowed != Nrc::kOk || finished) return allowed;
  SceneStore& store = services.parts.store;
  ArmStore& arms = services.parts.arms;
  const bool of_arm = services.download.of_arm();
  const StoreStatus status = of_arm ? arms.verify() : store.verify();
  services.download.finish(status == StoreStatus::kOk);
  if (status == StoreStatus::kWrongCrc || status == StoreStatus::kRefused)
    services.parts.audit.add(link::AuditEvent::kUploadRefused, call.host, call.now_us);
  const Nrc result = refuse(call.host, status);
  if (status != StoreStatus::kRefused) return result;
  if (of_arm) {
    call.host.refuse(name(arms.verdict()));
  } else {
    control::write_text(store.image_verdict(), call.host.refusal);
  }
  return result;
}

// 31 01 0204: the image that was downloaded and checked last becomes the running scene.
Nrc activate(Services& services, Call& call) noexcept {
  ServiceParts& parts = services.parts;
  const Nrc result = services.jobs.run(call, services.switch_scene, [&]() noexcept {
    if (services.download.belongs_to_another(call.host)) return busy(call.host, Busy::kOtherHostUploads);
    if (parts.core.sources().scene.pending()) return busy(call.host, Busy::kSceneSwitching);
    call.host.refuse("");
    const StoreStatus status = parts.store.commit(parts.running);
    if (status == StoreStatus::kNoDownload) {
      call.host.refuse(name(status));
      return Nrc::kConditionsNotCorrect;
    }
    if (status != StoreStatus::kOk) return refuse(call.host, status);
    static_cast<void>(
        parts.core.sources().scene.post(parts.running, parts.store.sequence(), parts.store.binding()));
    // Here, because a disarm may come before the tick takes it.
    parts.audit.add(link::AuditEvent::kScene, call.host, call.now_us, parts.store.image_crc());
    return Nrc::kResponsePending;
  });
  if (result == Nrc::kOk) services.download.end(call.host);
  return result;
}

// 31 01 020E: the arm's image that was downloaded and checked last is its own from the next start on.
Nrc activate_arm(Services& services, Call& call) noexcept {
  ServiceParts& parts = services.parts;
  if (services.download.belongs_to_another(call.host)) return busy(call.host, Busy::kOtherHostUploads);
  call.host.refuse("");
  if (!motors_off(parts.core)) return refuse(call.host, kWrongMode, "");
  const StoreStatus status = parts.arms.commit();
  if (status == StoreStatus::kNoDownload) {
    call.host.refuse(name(status));
    return Nrc::kConditionsNotCorrect;
  }
  const std::size_t arm = parts.arms.arm();
  if (status == StoreStatus::kOk)
    parts.audit.add(link::AuditEvent::kArmImage, call.host, call.now_us, parts.arms.stored_crc(arm),
                    static_cast<std::uint16_t>(arm));
  services.download.end(call.host);
  return refuse(call.host, status);
}

}  // namespace thimble::firmware
