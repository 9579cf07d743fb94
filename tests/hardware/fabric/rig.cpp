#include "tests/hardware/fabric/rig.h"

#include <dlfcn.h>

#include <cstdlib>
#include <stdexcept>

namespace thimble::tests {
namespace {

constexpr std::uint32_t kPatience = 100;  // clocks

template <class Function>
Function find(void* library, const char* name) {
  void* const found = dlsym(library, name);
  if (found == nullptr) throw std::runtime_error(dlerror());
  return reinterpret_cast<Function>(found);
}

void* load() {
  const char* const name = std::getenv("THIMBLE_FABRIC");
  if (name == nullptr) throw std::runtime_error("THIMBLE_FABRIC does not name a model (build_model)");
  void* const library = dlopen(name, RTLD_NOW);
  if (library == nullptr) throw std::runtime_error(dlerror());
  return library;
}

}  // namespace

Rig::Rig(std::uint32_t seed)
    : random(seed),
      library_(load()),
      new_(find<decltype(new_)>(library_, "fabric_new")),
      delete_(find<decltype(delete_)>(library_, "fabric_delete")),
      clock_(find<decltype(clock_)>(library_, "fabric_clock")),
      model_(new_(static_cast<int>(seed))) {
  in.e_stop_released = in.dead_man_held = 1;
  in.drives_good = 3;
  reset();
}

Rig::~Rig() {
  delete_(model_);
  dlclose(library_);
}

void Rig::reset() {
  const std::array<Converter, kArms> before = converter;
  in.aresetn = 0;
  run(8);
  in.aresetn = 1;
  run(2);
  for (std::size_t arm = 0; arm < kArms; ++arm)  // a frame that the reset cuts short is none
    converter[arm].violations = before[arm].violations;
}

void Rig::run(std::uint64_t clocks) {
  for (; clocks > 0; --clocks) clock();
}

void Rig::clock() {
  if (on_clock) on_clock();
  const bool answered_write = out.bvalid != 0 && at_edge_.bready == 0;
  const bool answered_read = out.rvalid != 0 && at_edge_.rready == 0;
  const FabricOut before = out;
  at_edge_ = in;
  clock_(model_, &in, &out);
  if (in.aresetn != 0 && now > 20) {
    if (answered_write && (out.bvalid == 0 || out.bresp != before.bresp)) ++bus_errors;
    if (answered_read && (out.rvalid == 0 || out.rdata != before.rdata)) ++bus_errors;
  }
  for (std::uint32_t arm = 0; arm < kArms && now >= 2; ++arm)  // from the reset on
    converter[arm].clock((out.dac_sync_n >> arm & 1) != 0, (out.dac_sclk >> arm & 1) != 0,
                         (out.dac_sdin >> arm & 1) != 0);
  ++now;
}

std::uint32_t Rig::read(std::uint32_t offset) {
  ++reads;
  run(delay());
  in.araddr = offset;
  in.arvalid = 1;
  std::uint32_t patience = kPatience;
  do clock();
  while (out.arready == 0 && --patience > 0);
  in.arvalid = 0;
  if (out.rvalid != 0) ++bus_errors;
  run(delay());
  in.rready = 1;
  do clock();
  while (out.rvalid == 0 && --patience > 0);
  in.rready = 0;
  if (patience == 0 || out.rresp != 0) ++bus_errors;
  return out.rdata;
}

std::uint32_t Rig::write(std::uint32_t offset, std::uint32_t value, std::uint8_t strobes) {
  ++writes;
  // Address first, data first or both at once.
  std::uint32_t address_in = delay(), data_in = delay(), patience = kPatience;
  bool address_taken = false, data_taken = false;
  in.awaddr = offset;
  in.wdata = value;
  in.wstrb = strobes;
  while ((!address_taken || !data_taken) && --patience > 0) {
    in.awvalid = !address_taken && address_in == 0;
    in.wvalid = !data_taken && data_in == 0;
    clock();
    if (out.bvalid != 0) ++bus_errors;
    address_taken = address_taken || (in.awvalid != 0 && out.awready != 0);
    data_taken = data_taken || (in.wvalid != 0 && out.wready != 0);
    if (address_in > 0) --address_in;
    if (data_in > 0) --data_in;
  }
  taken = now - 1;
  in.awvalid = in.wvalid = 0;
  run(delay());
  in.bready = 1;
  do clock();
  while (out.bvalid == 0 && --patience > 0);
  in.bready = 0;
  if (patience == 0) ++bus_errors;
  return out.bresp;
}

}  // namespace thimble::tests
