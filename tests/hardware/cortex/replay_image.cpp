// The recorded run in memory (QEMU's loader puts it there), replayed on bare metal. Writes "forces.bin"; exit code: 0, or 32 and a
// ReplayEnd, 40 after a crash, 41 when the recording or the file is not there.
#include <array>

#include "board/cortex/runtime.h"
#include "tests/hardware/cortex/replay.h"
#include "tests/hardware/cortex/semihosting.h"

namespace thimble {
namespace {

constexpr int kFirst = 32, kCrashed = 40, kNothingThere = 41;
constexpr std::size_t kMostRecording = std::size_t{6} << 20U;

class SlotsInMemory final : public firmware::Storage {
 public:
  std::span<const std::byte> slot(unsigned index) const noexcept override { return of(index); }
  bool erase(unsigned index, std::size_t bytes) noexcept override { return bytes <= of(index).size(); }
  bool write(unsigned index, std::size_t offset, std::span<const std::byte> bytes) noexcept override {
    std::copy(bytes.begin(), bytes.end(), of(index).begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }

 private:
  static constexpr std::size_t kSceneBytes = std::size_t{3} << 19U;
  static std::span<std::byte> of(unsigned index) noexcept;
};

[[gnu::section(".slots")]] alignas(8) std::array<std::byte, std::size_t{3} << 20U> slots;
[[gnu::section(".slots")]] std::array<std::array<std::byte, firmware::Storage::kJournalSlotBytes>,
                                      firmware::Storage::kFirstArmSlot - firmware::Storage::kSceneSlots>
    small_slots;  // of all but the scenes and the arms, of which none is stored

std::span<std::byte> SlotsInMemory::of(unsigned index) noexcept {
  if (index >= kFirstArmSlot) return {};
  if (index >= kSceneSlots) return small_slots[index - kSceneSlots];
  return std::span(slots).subspan(index * kSceneBytes, kSceneBytes);
}

long file = -1;
[[gnu::section(".slots")]] std::array<float, 4096> waiting_N;
std::size_t waiting = 0;

void flush() noexcept {
  if (!test::write(file, std::as_bytes(std::span(waiting_N).first(waiting)))) test::exit_with(kNothingThere);
  waiting = 0;
}

void keep(std::span<const float> force_N) {
  for (const float component_N : force_N) waiting_N[waiting++] = component_N;
  if (waiting + 6 > waiting_N.size()) flush();
}

}  // namespace

void board::crash(std::uint32_t) noexcept { test::exit_with(kCrashed); }

extern "C" [[noreturn]] void run_board() {
  const auto* memory = reinterpret_cast<const std::byte*>(THIMBLE_RECORDING);
  test::Recording recording;
  file = test::open_for_writing("forces.bin");
  if (file < 0 || !test::open_recording({memory, kMostRecording}, recording)) test::exit_with(kNothingThere);
  static SlotsInMemory storage;
  static firmware::Controller controller(test::config_of(recording), storage);
  const test::ReplayEnd end = test::replay(recording, controller, keep);
  flush();
  test::exit_with(end == test::ReplayEnd::kDone ? 0 : kFirst + static_cast<int>(end));
}

}  // namespace thimble
