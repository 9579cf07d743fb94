// An arm file from a URDF: the joints from the root to one link, their limits and masses. What a URDF does not have (encoders, drives, motors) stands
// in the file as a guess, to be replaced.
#pragma once

#include <string>

namespace thimble::host {

// urdf: the text. name: of the arm. tip: the link at whose origin the tip is; empty: the only leaf. The text of an arm file that read_arm_file() and
// check_arm() accept, if the URDF's home does. Throws Error (kBadInput): not a URDF, no such link or several leaves, joints that are not revolute,
// continuous, prismatic or fixed, or that mimic others, none or more than kMaxJoints.
[[nodiscard]] std::string import_urdf(const std::string& urdf, const std::string& name,
                                      const std::string& tip);

}  // namespace thimble::host
