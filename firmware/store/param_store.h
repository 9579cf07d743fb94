// The parameters that were saved: the newest sound one of two small slots. Called from the background.
#pragma once

#include <cstdint>

#include "firmware/params.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class ParamStore {
 public:
  explicit ParamStore(Storage& storage) noexcept : storage_(&storage) {}

  // At start. A parameter that was not saved, is not known any more or has a value that is not allowed now keeps its
  // default.
  void load(Params& params) noexcept;

  // All of them, as they are now. kStorage: the hardware refused; what was saved before is still there.
  [[nodiscard]] StoreStatus save(const Params& params) noexcept;

 private:
  static constexpr unsigned kFirstSlot = Storage::kSceneSlots;

  Storage* storage_;
  unsigned active_ = kFirstSlot;
  std::uint32_t sequence_ = 0;  // of the set saved last; 0: none
};

}  // namespace thimble::firmware
