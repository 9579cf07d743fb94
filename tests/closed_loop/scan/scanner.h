// A whole scan of a specimen with the simulated arm, like `thimble scan --simulate`.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/sim_probe.h"
#include "host-tools/lab/scan.h"
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
  std::vector<host::StiffnessFit> fits;
  host::ScannedSurface surface;
  std::string scene;
};

inline Scanned scan(const host::ScanPlan& plan, std::shared_ptr<const board::Specimen> specimen,
                    const std::string& arm = "premium-1.5") {
  const TemporaryFolder folder;
  SimulatedProbe probe(std::move(specimen), arm);
  Scanned scanned;
  {
    host::ScanLog log(folder.path() / "log.csv", plan.crc, plan.points(), false);
    EXPECT_TRUE(host::probe_points(
        plan, log, [&]() -> host::Probe& { return probe; }, [](std::size_t) { return true; }));
    scanned.fits = host::fit_points(plan, log);
  }
  scanned.surface = host::surface_of(plan, scanned.fits);
  scanned.scene = host::scene_text(plan, scanned.surface);
  return scanned;
}

}  // namespace thimble::test
