// The page of a commissioning: its steps, the prompt of the moment with buttons, and a picture of the arm. What it shows is given; what comes back are
// answers and a stop. The same page, server and rules of access as `thimble view` (web_server.h).
//
// A state message has, beside what one of `thimble view` has of an arm (tip and links):
//   commission: {steps, doing, prompt, axis, turn, way, goal_m, is_live, over}   commission_picture() and CommissionPage::Impl say how
// All public functions may be called from any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/arms/arm_pose.h"
#include "host-tools/viewer/web_server.h"

namespace thimble::host {

struct CommissionPrompt {
  std::string text;
  std::string done = "Done", decline;  // words of the buttons; empty: it cannot be declined
  std::optional<std::size_t> axis;     // in question
  double turn = 0;  // which way it is to go first, by the sign of its angle; 0: none is asked for
  Eigen::Vector3d way =
      Eigen::Vector3d::Zero();              // of the tip, world frame, of length 1; 0: none is asked for
  std::optional<std::vector<double>> goal;  // where all axes are to be, rad or m
};

struct CommissionStepShown {
  std::string state = "not yet";  // or "now", "passed", "found"
  struct Finding {
    std::string name, text;  // text: with the remedy
  };
  std::vector<Finding> findings{};
  std::vector<std::string> notes{};
};

struct CommissionShown {
  std::vector<CommissionStepShown> steps{};
  std::string doing;                  // while nothing is asked
  std::optional<std::size_t> axis{};  // that moves meanwhile
  std::vector<double> axes{};         // rad or m; empty: not known, the arm stands at home
  struct Over {
    bool passed = false;
    std::string text;
  };
  std::optional<Over> over{};
};

// Tip, links and what is marked in the picture: `arm` as a state message has it, `marks` for its `commission`.
struct CommissionPicture {
  Json arm, marks;
};
// names: of the axes. Where the links do not meet at `shown.axes`, the arm stays where `pose` has it.
[[nodiscard]] CommissionPicture commission_picture(const CommissionShown& shown,
                                                   const std::optional<CommissionPrompt>& prompt,
                                                   const kinematics::ArmData& arm, ArmPose& pose,
                                                   const std::vector<std::string>& names);

struct CommissionPageOptions {
  WebOptions web;
  std::string version, arm;
  bool simulated = false;
  std::vector<std::string> axes{};  // their names
  struct Step {
    std::string name, text;
  };
  std::vector<Step> steps{};
};

class CommissionPage {
 public:
  // Serves from now on. Errors: those of WebServer.
  CommissionPage(CommissionPageOptions options, const kinematics::ArmData& arm);
  CommissionPage(const CommissionPage&) = delete;
  CommissionPage& operator=(const CommissionPage&) = delete;
  // Pages get the last state before.
  ~CommissionPage();

  [[nodiscard]] const std::string& url() const;

  void change(const std::function<void(CommissionShown&)>& how);

  enum class Answer { kDone, kDecline };
  void ask(CommissionPrompt prompt);
  // The first answer to the prompt that is asked; later ones are refused.
  [[nodiscard]] std::optional<Answer> answer() const;
  void withdraw();  // the prompt
  [[nodiscard]] bool stopped() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thimble::host
