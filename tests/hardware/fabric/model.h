// Pins of the logic (board/zynqmp/fabric/fabric_axi.v), and the functions of the shared object that build_model makes of it.
#pragma once

#include <cstdint>

extern "C" {

struct FabricIn {
  std::uint32_t wdata, awaddr, araddr;
  std::uint8_t aresetn, awvalid, wstrb, wvalid, bready, arvalid, rready;
  std::uint8_t encoder_a, encoder_b, e_stop_released, dead_man_held, index, drives_good;
};

struct FabricOut {
  std::uint32_t rdata;
  std::uint8_t awready, wready, bvalid, bresp, arready, rvalid, rresp;
  std::uint8_t enable, enable_pulse, dac_sync_n, dac_sclk, dac_sdin;
};

void* fabric_new(int seed);
void fabric_delete(void* model);
// One clock: `out` is what the outputs are at the rising edge that takes `in`.
void fabric_clock(void* model, const FabricIn* in, FabricOut* out);
}
