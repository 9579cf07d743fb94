// The report of a commissioning, in Markdown.
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "host-tools/commission/procedure.h"

namespace thimble::host {
namespace {

std::string figure(double value) { return std::isnan(value) ? "" : fmt::format("{:.5g}", value); }

// What a table takes for its own, in names and sentences.
std::string cell(const std::string& text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char letter : text) {
    if (letter == '|') safe += '\\';
    safe += letter == '\n' ? ' ' : letter;
  }
  return safe;
}

const char* fate_of(const Measure& measure) {
  if (!place_of(measure).empty()) return std::isnan(measure.rate_Hz) ? "yes" : "half of it";
  return measure.promise > 0 && !(measure.spread <= measure.promise * std::abs(measure.value))
             ? "no: spread above the promise"
             : "";
}

void add_measures(std::string& text, const ArmFile& arm, const std::vector<Measure>& measures) {
  auto out = std::back_inserter(text);
  text +=
      "\n| axis | what | given | measured | spread | promise | in the new file "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const Measure& measure : measures) {
    std::string name = measure.name;
    if (!std::isnan(measure.rate_Hz))
      fmt::format_to(std::back_inserter(name), " at {:.0f} Hz, B = {:.2g} N s/m", measure.rate_Hz,
                     measure.damping_N_s_m);
    fmt::format_to(out, "| {} | {} | {} | {} | {} | {} | {} |\n",
                   measure.axis < 0 ? "" : cell(arm.axes[static_cast<std::size_t>(measure.axis)].name), name,
                   figure(measure.given), figure(measure.value),
                   std::isnan(measure.spread) ? "one run" : fmt::format("{:.2g}", measure.spread),
                   measure.promise > 0 ? fmt::format("{:.3g} %", 100 * measure.promise) : "",
                   fate_of(measure));
  }
}

}  // namespace

std::string Commission::report() const {
  std::string text =
      fmt::format("# Commissioning of {}\n\nBy: {}.\n\n| step | what it proves | result |\n|---|---|---|\n",
                  cell(file_->name), by_);
  auto out = std::back_inserter(text);
  for (const Step& step : steps()) {
    const auto found = results_.find(step.number);
    const char* word = found == results_.end() ? "not done" : found->second.passed ? "passed" : "**FAILED**";
    fmt::format_to(out, "| {} {} | {} | {} |\n", step.number, step.name, step.text, word);
  }
  if (!corrections_.empty()) text += "\n## Corrected in the file\n\n";
  for (const Correction& correction : corrections_)
    fmt::format_to(out, "- `{}` is {:.4g} in the new file\n", correction.pointer, correction.value);
  for (const auto& [number, result] : results_) {
    if (result.findings.empty() && result.notes.empty() && result.measures.empty()) continue;
    fmt::format_to(out, "\n## Step {}, {}\n", number, steps()[static_cast<std::size_t>(number)].name);
    if (!result.findings.empty() || !result.notes.empty()) text += "\n";
    for (const ArmFinding& found : result.findings)
      fmt::format_to(out, "- **{}**: {}\n", text_of(found.fault).name, found.text);
    for (const std::string& note : result.notes) fmt::format_to(out, "- {}\n", note);
    if (!result.measures.empty()) add_measures(text, *file_, result.measures);
  }
  return text;
}

}  // namespace thimble::host
