// The parameters that were saved: the newest valid one of two small slots. Called from the background.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/params.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class ParamStore {
 public:
  explicit ParamStore(Storage& storage) noexcept : storage_(&storage) {}

  // At start: open() finds the set, apply() takes it, load() is both. A parameter keeps its default where it was not saved, is not persistent or not known any more, or where the
  // saved value is not allowed now.
  void open() noexcept;
  void apply(Params& params) const noexcept;
  void load(Params& params) noexcept {
    open();
    apply(params);
  }
  [[nodiscard]] std::uint32_t crc() const noexcept {
    return crc_;
  }  // of the set found or saved last; 0: none
  [[nodiscard]] std::uint32_t sequence() const noexcept { return sequence_; }  // of that set; 0: none
  [[nodiscard]] bool damaged() const noexcept { return damaged_; }             // what open() saw was

  // All that are persistent (params.def), as they are now. kStorage: the hardware refused; what was saved before is still there.
  [[nodiscard]] StoreStatus save(const Params& params) noexcept;

 private:
  static constexpr unsigned kFirstSlot = Storage::kSceneSlots;

  Storage* storage_;
  unsigned active_ = kFirstSlot;
  std::uint32_t sequence_ = 0;
  std::uint32_t crc_ = 0;
  std::size_t length_ = 0;  // of the set that open() found
  bool damaged_ = false;
};

}  // namespace thimble::firmware
