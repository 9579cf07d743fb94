// A whole scan of a specimen with the simulated arm, like `thimble scan --simulate`.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/sim_probe.h"
#include "host-tools/lab/scan.h"
#include "host-tools/lab/scan_scene.h"
#include "tests/closed_loop/scan/specimens.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {

class SimulatedProbe final : public host::Probe {
 public:
  SimulatedProbe(std::shared_ptr<const board::Specimen> specimen, const std::string& arm)
      : probe_({.variant = arm, .specimen = std::move(specimen)}, free_space()) {}
  Result move(const firmware::link::MoveOrder& order) override {
    board::SimProbe::Result result = probe_.move(order);
    return {result.state, std::move(result.samples)};
  }

 private:
  board::SimProbe probe_;
};

struct Scanned {
  host::ScanResult result;
  std::string scene, heights;
};

inline Scanned scan(const host::ScanPlan& plan, std::shared_ptr<const board::Specimen> specimen,
                    const std::string& arm = "premium-1.5") {
  const TemporaryFolder folder;
  SimulatedProbe probe(std::move(specimen), arm);
  host::ScanLog log(folder.path() / "log.csv", plan, false);
  EXPECT_TRUE(host::probe_steps(
      plan, log, [&]() -> host::Probe& { return probe; }, [](std::size_t) { return true; }));
  const host::ScanResult result = host::result_of(plan, log);
  return {result, host::scene_text(plan, result, "heights.csv"), host::heights_text(plan, result)};
}

}  // namespace thimble::test
