// The other node on the emulated bus: the machine's second CAN controller, driven from outside by its registers.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/link/can_frame.h"
#include "tests/hardware/cortex/qtest.h"

namespace thimble::tests {

class QtestCan {
 public:
  explicit QtestCan(Qtest& qtest);

  // Everything that has come. To be asked often: 64 frames wait, further ones are lost.
  [[nodiscard]] std::vector<firmware::link::CanFrame> receive();
  void send(const firmware::link::CanFrame& frame);

 private:
  Qtest& qtest_;
};

}  // namespace thimble::tests
