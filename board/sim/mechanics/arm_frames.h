// The moving frames of an arm of any family, from its geometry: its links and its tip.
#pragma once

#include <vector>

#include "board/sim/mechanics/moving_frame.h"

namespace thimble::board {

struct ArmFrames {
  std::vector<MovingFrame> chain;  // the links behind the joints of the chain
  std::vector<MovingFrame> inner,
      outer;                       // of a five-bar: at the base joints and at the elbows, x along the link
  std::vector<MovingFrame> thigh;  // of a delta, x along it
  MovingFrame plate;               // of the platform; the base where there is none
  MovingFrame tip;
  // Of a closed loop: what the directions of its last links span. 1: they are square to each other; 0: in line, where they part or fold, and no
  // torque of the axes moves or holds the tip. Of an arm without a loop 1.
  double spread = 1;
};

// q, qd: of the joints. frames: those of a place near by, from which a delta looks for its plate; frames.plate alone matters. False: the
// links do not meet.
[[nodiscard]] bool find_frames(const kinematics::Geometry& geometry, const JointVector& q,
                               const JointVector& qd, ArmFrames& frames);

// Where a delta begins to look, and nothing of the others.
[[nodiscard]] ArmFrames frames_at_rest(const kinematics::Geometry& geometry);

}  // namespace thimble::board
