/// Cuts round holes into a body, each group of equal ones a step or a pattern with sizes of its own.
#pragma once

#include <optional>
#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// A hole that was found in a scan.
struct DrilledHole {
  HoleOf<double> form;
  bool floor_seen = true;                          ///< of a blind one; else its depth is where the data end
  double sigma = 0;                                ///< mm, of its place and its sizes
  double sigma_axis = 0;                           ///< rad
  Vec3 mouth = Vec3::Zero(), out = Vec3::UnitZ();  ///< where its axis leaves the part, and which way; scan frame
  Vec3 point = Vec3::Zero();                       ///< of its axis, where that is known best
};

struct DrillOptions {
  double tolerance = 0.1;
  double alike = 0;  ///< mm; sizes and places within it or their sigmas are equal, equally spaced or in the middle
  double end = 0;    ///< mm: how well the last points of a wall say where it ends
};

/// Are all of them plain holes along an extrusion? They are loops of its sketch.
bool in_sketch(const Candidate& body, const std::vector<DrilledHole>& holes);

/// Nothing if a hole runs along none of the body's axes or does not begin in the body.
///
/// Mouths and ends of holes that open at a face of the body are said by the body's own numbers, so that they move with
/// it; so are places in the middle of the body and on its axis.
std::optional<Candidate> with_holes(const Candidate& body, const std::vector<DrilledHole>& holes,
                                    const DrillOptions& options);

}  // namespace partscribe::fit
