#include "tests/hardware/fabric/trapped_page.h"

#include <sys/mman.h>
#include <ucontext.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>

namespace thimble::tests {
namespace {

constexpr std::size_t kBytes = 4096;
constexpr greg_t kTrapFlag = 0x100;
constexpr greg_t kFaultOfWrite = 2;  // bit of the processor's error code

// Handlers have no arguments of ours.
struct Trap {
  RegisterBus* bus = nullptr;
  std::byte* page = nullptr;      // what the driver accesses
  std::uint32_t* open = nullptr;  // the same memory, accessible
  std::uint32_t offset = 0;
  bool write = false;
  struct sigaction old_fault = {}, old_step = {};
};
Trap trap;

void on_fault(int, siginfo_t* info, void* context) {
  const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
  const auto page = reinterpret_cast<std::uintptr_t>(trap.page);
  if (address < page ||
      address >= page + kBytes) {  // not ours: the instruction faults again, and ends the program
    sigaction(SIGSEGV, &trap.old_fault, nullptr);
    return;
  }
  greg_t* const registers = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
  trap.offset = static_cast<std::uint32_t>(address - page) & ~3U;
  trap.write = (registers[REG_ERR] & kFaultOfWrite) != 0;
  if (!trap.write) trap.open[trap.offset / 4] = trap.bus->read(trap.offset);
  if (mprotect(trap.page, kBytes, trap.write ? PROT_READ | PROT_WRITE : PROT_READ) != 0) std::abort();
  registers[REG_EFL] |= kTrapFlag;
}

void on_step(int, siginfo_t*, void* context) {
  static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_EFL] &= ~kTrapFlag;
  if (mprotect(trap.page, kBytes, PROT_NONE) != 0) std::abort();
  if (trap.write) trap.bus->write(trap.offset, trap.open[trap.offset / 4]);
}

void* map(int fd, int protection) {
  void* const memory = mmap(nullptr, kBytes, protection, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "mmap");
  return memory;
}

void handle(int signal, void (*handler)(int, siginfo_t*, void*), struct sigaction& old) {
  struct sigaction action = {};
  action.sa_sigaction = handler;
  action.sa_flags = SA_SIGINFO;
  sigaction(signal, &action, &old);
}

}  // namespace

TrappedPage::TrappedPage(RegisterBus& bus) {
  const int fd = memfd_create("registers", MFD_CLOEXEC);
  if (fd < 0 || ftruncate(fd, kBytes) != 0)
    throw std::system_error(errno, std::generic_category(), "memfd_create");
  trap.bus = &bus;
  trap.page = static_cast<std::byte*>(map(fd, PROT_NONE));
  trap.open = static_cast<std::uint32_t*>(map(fd, PROT_READ | PROT_WRITE));
  close(fd);
  handle(SIGSEGV, on_fault, trap.old_fault);
  handle(SIGTRAP, on_step, trap.old_step);
}

TrappedPage::~TrappedPage() {
  sigaction(SIGSEGV, &trap.old_fault, nullptr);
  sigaction(SIGTRAP, &trap.old_step, nullptr);
  munmap(trap.page, kBytes);
  munmap(trap.open, kBytes);
  trap = {};
}

std::uintptr_t TrappedPage::address() const noexcept { return reinterpret_cast<std::uintptr_t>(trap.page); }

}  // namespace thimble::tests
