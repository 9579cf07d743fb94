// The key that hosts must have to command this board (firmware/link/proof.h). Called from the background.
//
// It is written into the one of two small slots that is empty, and then the other one is erased. So power may fail after any byte: the key
// before still counts until the new one is whole; a first key whose header is torn counts as damaged. What is damaged counts as a key that nobody has, and nobody commands until the slots are
// erased by hand (docs/link.md).
#pragma once

#include <cstdint>

#include "firmware/link/messages.h"
#include "firmware/link/proof.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class KeyStore {
 public:
  explicit KeyStore(Storage& storage) noexcept : storage_(&storage) {}

  void open() noexcept;  // at start
  [[nodiscard]] link::KeyState state() const noexcept { return state_; }
  // If the state is kSet: the key, and its number, which no key before it had. Not 0.
  [[nodiscard]] const link::Key& key() const noexcept { return key_; }
  [[nodiscard]] std::uint32_t number() const noexcept { return sequence_; }

  // Over power-off. kStorage: the hardware refused; what was there before still counts.
  [[nodiscard]] StoreStatus set(const link::Key& key) noexcept;
  [[nodiscard]] StoreStatus remove() noexcept;

 private:
  [[nodiscard]] StoreStatus write(std::span<const std::byte> contents) noexcept;
  void erase_older() noexcept;

  Storage* storage_;
  unsigned active_ = Storage::kFirstKeySlot;
  std::uint32_t sequence_ = 0;
  link::KeyState state_ = link::KeyState::kNone;
  link::Key key_{};
};

}  // namespace thimble::firmware
