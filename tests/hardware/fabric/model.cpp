// The verilated logic as a shared object, which the test loads (model.h): so the C++ build needs no Verilator.
#include "model.h"

#include <memory>

#include "Vfabric_axi.h"
#include "verilated.h"

namespace {

struct Model {
  VerilatedContext context;
  Vfabric_axi logic{&context};
};

}  // namespace

extern "C" {

void* fabric_new(int seed) {
  auto model = std::make_unique<Model>();
  model->context.randReset(2);  // registers without a reset begin with anything
  model->context.randSeed(seed);
  model->logic.aclk = 0;
  model->logic.eval();
  return model.release();
}

void fabric_delete(void* model) { delete static_cast<Model*>(model); }

void fabric_clock(void* model, const FabricIn* in, FabricOut* out) {
  Vfabric_axi& logic = static_cast<Model*>(model)->logic;
  logic.aresetn = in->aresetn;
  logic.s_axi_awaddr = in->awaddr;
  logic.s_axi_awvalid = in->awvalid;
  logic.s_axi_wdata = in->wdata;
  logic.s_axi_wstrb = in->wstrb;
  logic.s_axi_wvalid = in->wvalid;
  logic.s_axi_bready = in->bready;
  logic.s_axi_araddr = in->araddr;
  logic.s_axi_arvalid = in->arvalid;
  logic.s_axi_rready = in->rready;
  logic.encoder_a = in->encoder_a;
  logic.encoder_b = in->encoder_b;
  logic.e_stop_released = in->e_stop_released;
  logic.dead_man_held = in->dead_man_held;
  logic.index = in->index;
  logic.drives_good = in->drives_good;
  logic.aclk = 0;
  logic.eval();
  // What the master sees at the edge: the ready lines follow from its own valid ones.
  out->awready = logic.s_axi_awready;
  out->wready = logic.s_axi_wready;
  out->bvalid = logic.s_axi_bvalid;
  out->bresp = logic.s_axi_bresp;
  out->arready = logic.s_axi_arready;
  out->rvalid = logic.s_axi_rvalid;
  out->rresp = logic.s_axi_rresp;
  out->rdata = logic.s_axi_rdata;
  out->enable = logic.enable;
  out->enable_pulse = logic.enable_pulse;
  out->dac_sync_n = logic.dac_sync_n;
  out->dac_sclk = logic.dac_sclk;
  out->dac_sdin = logic.dac_sdin;
  logic.aclk = 1;
  logic.eval();
}
}
