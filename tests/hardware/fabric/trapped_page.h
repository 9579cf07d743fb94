// A page of addresses whose every access goes to a bus model: code that drives registers as volatile memory runs unchanged, and the model
// sees its reads and writes, one by one and in order.
//
// An access is a page fault. Its handler asks the bus for the word that is read, opens the page and has the processor execute this one
// instruction (trap flag); then the page is closed again, and a word that was written goes to the bus. An instruction that both reads and
// writes memory would be seen as a write alone; aligned volatile words do not need one. x86-64 Linux; one page at a time, one thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace thimble::tests {

class RegisterBus {
 public:
  virtual ~RegisterBus() = default;
  virtual std::uint32_t read(std::uint32_t offset) = 0;
  virtual void write(std::uint32_t offset, std::uint32_t value) = 0;
};

class TrappedPage {
 public:
  explicit TrappedPage(RegisterBus& bus);  // throws std::system_error
  TrappedPage(const TrappedPage&) = delete;
  TrappedPage& operator=(const TrappedPage&) = delete;
  ~TrappedPage();

  [[nodiscard]] std::uintptr_t address() const noexcept;
};

}  // namespace thimble::tests
