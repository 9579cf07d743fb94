// An arm file from a URDF: the joints from the root to one link, their limits and masses. What a URDF does not have (encoders, drives, motors) stands
// in the file as a guess, to be replaced.
#pragma once

#include <string>

namespace thimble::host {

// urdf: the text. name: of the arm. tip: the link at whose origin the tip is; empty: the only leaf. The text of an arm file, which
// read_arm_file() accepts if names, lengths and limits are within those of the format. A body has the mass of its link and of all that is fixed to it;
// what moves beside the way to the tip is left out. Throws Error (kBadInput): not a URDF, no tree, no such link or several leaves, joints that are not
// revolute, continuous, prismatic or fixed, or that mimic others, none or more than kMaxJoints.
[[nodiscard]] std::string import_urdf(const std::string& urdf, const std::string& name,
                                      const std::string& tip);

}  // namespace thimble::host
