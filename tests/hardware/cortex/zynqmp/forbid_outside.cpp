// A tick of a replayed run that uses what is not in the tightly coupled memory is a crash.
#include "board/zynqmp/memory.h"
#include "tests/hardware/cortex/replay.h"

extern "C" {
void before_tick() { thimble::board::permit_outside(false); }
void after_tick() { thimble::board::permit_outside(true); }
}
