// The parameters that were saved: the newest valid one of two small slots. Called from the background.
#pragma once

#include <cstdint>

#include "firmware/params.h"
#include "firmware/store/scene_store.h"
#include "firmware/store/storage.h"

namespace thimble::firmware {

class ParamStore {
 public:
  explicit ParamStore(Storage& storage) noexcept : storage_(&storage) {}

  // At start. A parameter keeps its default where it was not saved, is not persistent or not known any more, or where the
  // saved value is not allowed now.
  void load(Params& params) noexcept;

  // All that are persistent (params.def), as they are now. kStorage: the hardware refused; what was saved before is still there.
  [[nodiscard]] StoreStatus save(const Params& params) noexcept;

 private:
  static constexpr unsigned kFirstSlot = Storage::kSceneSlots;

  Storage* storage_;
  unsigned active_ = kFirstSlot;
  std::uint32_t sequence_ = 0;  // of the set saved last; 0: none
};

}  // namespace thimble::firmware
