// The arm that `thimble commission` works on: a simulated one, or one on the link.
#pragma once

#include <memory>
#include <optional>

#include "host-tools/cli/console_person.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/commission/procedure.h"

namespace thimble::host {

class CommissionedArm {
 public:
  CommissionedArm() = default;
  CommissionedArm(const CommissionedArm&) = delete;
  CommissionedArm& operator=(const CommissionedArm&) = delete;
  virtual ~CommissionedArm() = default;

  [[nodiscard]] virtual Bench& bench() = 0;
  virtual void begin_step(int number) = 0;
  [[nodiscard]] virtual bool stopped() const = 0;  // by the person
  // Whether a person answers the prompts.
  [[nodiscard]] virtual bool is_asked() const = 0;
  // After the person has repaired what was found.
  virtual void repaired(const StepResult& result) = 0;
  // The newest counts of the axes that have come; the device is not asked for them.
  [[nodiscard]] virtual std::optional<PerAxis<std::int64_t>> counts() = 0;
  // Which arm it is, for the saved state; and whether it is the one that was saved: Error kRefused, "other-arm".
  [[nodiscard]] virtual Json identity() = 0;
  virtual void demand_same(const Json& saved) = 0;
};

// state: its name, for errors. second: null, or where prompts are answered, too. Throws Error: bad faults, no device.
[[nodiscard]] std::unique_ptr<CommissionedArm> commissioned_arm(const Common& common, const Remote& remote,
                                                                const CommissionChoice& choice,
                                                                const ArmFile& arm, const std::string& state,
                                                                SecondPlace* second);

}  // namespace thimble::host
