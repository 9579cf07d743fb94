// The runs of a plan: each gives a line of the results. Several threads may run at once.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "host-tools/sweep/sweep_plan.h"

namespace thimble::host {

class SweepRuns {
 public:
  explicit SweepRuns(SweepPlan plan) : plan_(std::move(plan)) {}

  [[nodiscard]] const SweepPlan& plan() const { return plan_; }
  [[nodiscard]] std::size_t count() const { return plan_.runs(); }
  // The two lines before the results: what they are of, and the names of the columns.
  [[nodiscard]] std::string head() const;
  [[nodiscard]] std::size_t columns() const;
  // How long a run takes, compared with other runs of this plan.
  [[nodiscard]] double cost(std::size_t run) const;
  // The line without its end. go_on: asked in each tick; what it throws ends the run.
  [[nodiscard]] std::string line(
      std::size_t run, const std::function<void()>& go_on = [] {}) const;

 private:
  [[nodiscard]] SweepSettings settings(std::size_t run) const;
  [[nodiscard]] MeasuredRun input(const SweepSettings& settings) const;
  struct Outcome {
    Measured measured;
    std::string_view status;
  };
  [[nodiscard]] Outcome outcome(const SweepSettings& settings, const std::function<void()>& go_on) const;
  [[nodiscard]] std::string search(SweepSettings settings, const std::function<void()>& go_on) const;

  SweepPlan plan_;
};

}  // namespace thimble::host
