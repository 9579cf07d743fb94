// The commissioning of one arm: its steps, what they found, and the arm file that comes of it. All of it is one JSON state, so that it can be interrupted:
// save() after each step writes it whole or not at all, and a Commission made from it goes on.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host-tools/commission/steps.h"

namespace thimble::host {

// Where in the arm file a measured value goes; empty: there is no place, or the spread is above what the method promises.
[[nodiscard]] std::string place_of(const Measure& measure);

class Commission {
 public:
  // arm_text: the arm file as it is given. by: stands at every measured value, "commission 2026-12-01". Throws Error (kBadInput) for a file that
  // read_arm_file() refuses.
  Commission(std::string arm_text, std::string arm_name, std::string by);
  // From what state() gave. Throws Error (kBadInput, "bad-state").
  [[nodiscard]] static Commission from_state(const std::string& text);
  // Whether it was begun with an arm file of this content.
  [[nodiscard]] bool is_of(const std::string& arm_text) const;

  // Does a step, again if it was done. A fault that was found may be in the file: the builder is asked, and a correction goes into the new file. Throws
  // Error (kRefused, "step-order") for a step before those that it builds on, or in another session of the counters than step 2. What `bench` throws passes
  // through, and the results are as before the step.
  const StepResult& run(int number, Bench& bench);
  [[nodiscard]] int next() const;  // the first step that has not passed; 11: none
  [[nodiscard]] bool passed(int number) const;
  // Whether step 2 has to be done again before this one, because the counters have begun anew.
  [[nodiscard]] bool needs_place(int number, Bench& bench) const;
  [[nodiscard]] const std::map<int, StepResult>& results() const { return results_; }
  [[nodiscard]] const std::vector<Correction>& corrections() const { return corrections_; }  // so far
  [[nodiscard]] const ArmFile& arm() const { return *file_; }                                // with them

  // What the caller knows of the bench, for the saved state: which arm it is. Null: nothing was told.
  [[nodiscard]] const nlohmann::ordered_json& bench() const { return bench_; }
  void tell_bench(nlohmann::ordered_json bench) { bench_ = std::move(bench); }

  [[nodiscard]] std::string state() const;
  void save(const std::filesystem::path& file) const;

  // The arm file with corrections and measured values; a value whose spread is above what its method promises is left as it was. proved_on: the day,
  // if this was the real arm and every step has passed; empty: the file does not count as commissioned.
  [[nodiscard]] std::string arm_file(const std::string& proved_on) const;
  // Measured against given, step by step, for people: Markdown.
  [[nodiscard]] std::string report() const;

 private:
  void accept(StepResult& result, Bench& bench);
  // False: with the corrections the file would be refused; it is as before, and a note says why.
  [[nodiscard]] bool correct(const ArmFinding& found, std::vector<std::string>& notes);
  void reread();
  void complete_friction(nlohmann::ordered_json& arm) const;
  void demand_axes() const;  // of the results: those of the arm

  std::string name_, by_;
  nlohmann::ordered_json given_, arm_;  // as it was given, and with corrections
  nlohmann::ordered_json bench_;
  std::unique_ptr<ArmFile> file_;
  std::unique_ptr<Expectation> expectation_;
  Known known_;
  std::vector<Correction> corrections_;
  std::map<int, StepResult> results_;
};

}  // namespace thimble::host
