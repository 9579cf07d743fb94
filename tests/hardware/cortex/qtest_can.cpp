#include "tests/hardware/cortex/qtest_can.h"

#include <array>
#include <cstddef>

#include "board/zynqmp/registers.h"

namespace thimble::tests {
namespace {

using board::CanRegisters;
using firmware::link::CanFrame;

constexpr std::uint32_t kCan1 = 0xFF070000;
constexpr std::uint32_t kReceiveNotEmpty = 1U << 7U;

std::uint32_t at(std::size_t offset) { return kCan1 + static_cast<std::uint32_t>(offset); }

// Four words of the receive FIFO.
CanFrame to_frame(const Qtest::Access* words) {
  const std::uint32_t id = words[0].value;
  CanFrame frame;
  frame.extended = (id >> 19U & 1U) != 0;
  frame.id = frame.extended ? (id >> 21U) << 18U | (id >> 1U & 0x3FFFFU) : id >> 21U;
  frame.size = static_cast<std::uint8_t>(words[1].value >> 28U);
  for (unsigned i = 0; i < 8; ++i)
    frame.data[i] = static_cast<std::uint8_t>(words[2 + i / 4].value >> (24 - 8 * (i % 4)));
  return frame;
}

}  // namespace

QtestCan::QtestCan(Qtest& qtest) : qtest_(qtest) {
  qtest_.write(at(offsetof(CanRegisters, srr)), 1);  // reset
  qtest_.write(at(offsetof(CanRegisters, msr)), 0);  // normal mode, every frame taken
  qtest_.write(at(offsetof(CanRegisters, srr)), 2);  // on
}

std::vector<CanFrame> QtestCan::receive() {
  std::vector<CanFrame> frames;
  bool more = (qtest_.read(at(offsetof(CanRegisters, isr))) & kReceiveNotEmpty) != 0;
  while (more) {
    // One frame, known to be there, and whether there is another. Never more at once: the machine runs on between two accesses, so a frame
    // could come in the middle of four reads of an empty FIFO, and all that follow would be read shifted.
    std::array<Qtest::Access, 6> accesses{{{at(offsetof(CanRegisters, rxfifo.id))},
                                           {at(offsetof(CanRegisters, rxfifo.dlc))},
                                           {at(offsetof(CanRegisters, rxfifo.data1))},
                                           {at(offsetof(CanRegisters, rxfifo.data2))},
                                           {at(offsetof(CanRegisters, icr)), true, kReceiveNotEmpty},
                                           {at(offsetof(CanRegisters, isr))}}};
    qtest_.run(accesses);
    frames.push_back(to_frame(accesses.data()));
    more = (accesses.back().value & kReceiveNotEmpty) != 0;
  }
  return frames;
}

void QtestCan::send(const CanFrame& frame) {
  const std::uint32_t id =
      frame.extended ? (frame.id >> 18U) << 21U | 3U << 19U | (frame.id & 0x3FFFFU) << 1U : frame.id << 21U;
  std::array<std::uint32_t, 2> data{};
  for (unsigned i = 0; i < 8; ++i) data[i / 4] |= std::uint32_t{frame.data[i]} << (24 - 8 * (i % 4));
  std::array<Qtest::Access, 4> accesses{
      {{at(offsetof(CanRegisters, txfifo.id)), true, id},
       {at(offsetof(CanRegisters, txfifo.dlc)), true, std::uint32_t{frame.size} << 28U},
       {at(offsetof(CanRegisters, txfifo.data1)), true, data[0]},
       {at(offsetof(CanRegisters, txfifo.data2)), true, data[1]}}};
  qtest_.run(accesses);
}

}  // namespace thimble::tests
