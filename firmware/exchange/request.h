// A command from the background to the tick. post() replaces a command that the tick has not taken yet, so the newest one wins; the
// tick acknowledges what it took, at the end of the tick that executed it. Used for the commands of firmware/core/modes.h.
//
//   writer  post(command), pending()
//   reader  take() once a tick: the command, if there is a new one; done() when its effects are published
//
// Memory order. word_ holds a serial number and the command; done_ the serial number of the command that was executed.
//   post() releases word_, take() acquires it: the reader sees what the writer wrote before post().
//   done() releases done_, pending() acquires it: a writer that finds nothing pending sees all that the reader wrote before done(),
//   so the effects of the command. A command that replaces another between take() and done() has a later serial number: it stays
//   pending, and the next take() gives it.
// Each word has one writer and is written whole, so an interrupt at any instruction finds either the old word or the new one. Two
// commands of one kind are told apart by their serial number, which wraps after 2^24: the writer cannot post that many in one tick.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

namespace thimble::firmware {

template <class T>  // an enum of at most 8 bits
class Request {
  static_assert(sizeof(T) == 1);

 public:
  // --- writer
  void post(T command) noexcept {
    const std::uint32_t serial = (word_.load(std::memory_order_relaxed) >> kSerialShift) + 1U;
    word_.store(serial << kSerialShift | static_cast<std::uint32_t>(command), std::memory_order_release);
  }
  [[nodiscard]] bool pending() const noexcept {
    return word_.load(std::memory_order_relaxed) >> kSerialShift != done_.load(std::memory_order_acquire);
  }

  // --- reader
  [[nodiscard]] std::optional<T> take() noexcept {
    const std::uint32_t word = word_.load(std::memory_order_acquire);
    taken_ = word >> kSerialShift;
    if (taken_ == done_.load(std::memory_order_relaxed)) return std::nullopt;
    return static_cast<T>(word & kCommandMask);
  }
  void done() noexcept { done_.store(taken_, std::memory_order_release); }

 private:
  static constexpr std::uint32_t kSerialShift = 8;
  static constexpr std::uint32_t kCommandMask = 0xFF;

  std::atomic<std::uint32_t> word_{0};
  std::atomic<std::uint32_t> done_{0};
  std::uint32_t taken_ = 0;  // the reader's
};

}  // namespace thimble::firmware
