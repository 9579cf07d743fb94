// Services that take several polls: the handler calls Jobs::run() with its job, and the router calls the handler again at every
// poll while the result is kResponsePending. One job runs at a time, for one host. Requests of other hosts that need a job wait;
// those that need none are answered meanwhile.
//
// A job is an object with its own state and a `Nrc poll()`. It lives in Services, and only the handler that begins it uses it.
#pragma once

#include "firmware/core/core.h"
#include "firmware/services/call.h"

namespace thimble::firmware {

class Jobs {
 public:
  // begin(): prepares the job and posts what it waits for. kResponsePending: the job runs. Any other result is the answer.
  template <class Job, class Begin>
  [[nodiscard]] Nrc run(Call& call, Job& job, Begin&& begin) noexcept {
    if (owner_ == nullptr) {
      const Nrc begun = begin();
      if (begun != Nrc::kResponsePending) return begun;
      owner_ = &call.host;
    } else if (owner_ != &call.host) {
      return Nrc::kResponsePending;  // another host's job runs
    }
    const Nrc result = job.poll(call);
    if (result != Nrc::kResponsePending) owner_ = nullptr;
    return result;
  }

  void give_up(const Host& host) noexcept {
    if (owner_ == &host) owner_ = nullptr;
  }

 private:
  const Host* owner_ = nullptr;  // of the job that runs; null: none
};

// A command that the tick executes: arming, homing, clearing faults, moves, the start of a recording.
class CommandJob {
 public:
  explicit CommandJob(Core& core, const char* lacks) noexcept : core_(core), lacks_(lacks) {}

  // Posts the command, or refuses it with the unmet conditions.
  [[nodiscard]] Nrc begin(Call& call, Command command) noexcept;
  [[nodiscard]] Nrc begin_move(Call& call, const MoveOrder& order) noexcept;
  [[nodiscard]] Nrc begin_axes(Call& call, const link::AxisOrder& order) noexcept;
  [[nodiscard]] Nrc poll(Call& call) noexcept;

 private:
  // A command with an order, which post() hands over or refuses.
  [[nodiscard]] Nrc begin_guest(Call& call, auto&& post) noexcept;
  [[nodiscard]] bool yields(const Call& call, Command command) const noexcept;
  [[nodiscard]] Nrc begun(Call& call, Command command, Conditions against) noexcept;
  [[nodiscard]] bool done() const noexcept;

  Core& core_;
  const char* lacks_;  // Config::lacks
  Command command_ = Command::kNone;
};

// The end of the recording that runs; the tick ends it.
class EndRecordingJob {
 public:
  explicit EndRecordingJob(Core& core) noexcept : core_(core) {}

  [[nodiscard]] Nrc begin(RecordingEnd reason) noexcept;  // kOk: none runs
  [[nodiscard]] Nrc poll(Call& call) noexcept;

 private:
  Core& core_;
};

// A tick takes the mark of a host (firmware/core/marks.h).
class MarkJob {
 public:
  explicit MarkJob(Core& core) noexcept : core_(core) {}

  // Posts it and writes the parameter.
  [[nodiscard]] Nrc begin(Call& call, Params& params, const ParamRow& row, std::uint32_t bits) noexcept;
  [[nodiscard]] Nrc poll(Call& call) noexcept;

 private:
  Core& core_;
};

// The tick takes the scene that was posted.
class SwitchSceneJob {
 public:
  explicit SwitchSceneJob(Core& core) noexcept : core_(core) {}
  [[nodiscard]] Nrc poll(Call& call) noexcept;

 private:
  Core& core_;
};

}  // namespace thimble::firmware
