// One object that changes hands, in place: the writer fills it, sends it, and leaves it alone until the reader has returned it. Used
// where an object is large and must arrive whole: the next scene, the picture of a scene, the ticks before a fault.
//
//   writer  blank(): the object to fill, null while the reader has it; send(); sent(): the reader still has it
//   reader  letter(): the object to read, null while the writer has it; done()
//
// Memory order. full_ says who owns the object: false the writer, true the reader. Only the owner touches the object, and only the
// owner changes full_.
//   send() releases full_ = true, letter() acquires it: the reader sees the object as it was filled.
//   done() releases full_ = false, blank() acquires it: the writer fills the object after the reader's last load from it.
// Only the owner may act, so neither an interrupt nor a second core can see a half-filled object. Neither side waits: a side that is not
// the owner gets null, and tries again later.
//
// recall() takes the object back without the reader's done(). It is for a writer that the reader has told, through a Request, that it
// is done: the pair post() and take() then orders the reader's last load before the writer's next store. A reader that posts such a
// request does not call letter() again before the request is executed.
#pragma once

#include <atomic>

namespace thimble::firmware {

template <class T>
class Mailbox {
 public:
  // --- writer
  [[nodiscard]] T* blank() noexcept { return full_.load(std::memory_order_acquire) ? nullptr : &object_; }
  void send() noexcept { full_.store(true, std::memory_order_release); }
  [[nodiscard]] bool sent() const noexcept { return full_.load(std::memory_order_acquire); }
  void recall() noexcept { full_.store(false, std::memory_order_relaxed); }

  // --- reader
  [[nodiscard]] const T* letter() const noexcept {
    return full_.load(std::memory_order_acquire) ? &object_ : nullptr;
  }
  void done() noexcept { full_.store(false, std::memory_order_release); }

 private:
  T object_{};
  std::atomic<bool> full_{false};
};

}  // namespace thimble::firmware
