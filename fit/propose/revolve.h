/// Proposes solids of revolution: axis from the normals, profile in (radius, height) as lines and arcs.
#pragma once

#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// A line in space about which most normals turn.
struct Axis {
  Vec3 point = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();
  double share = 0;  ///< of the points whose normal meets the axis within 8 degrees, or as near as noise lets it
};

/// Axes by decreasing share. The normals of a surface of revolution meet its axis: a . (p x n) + m . n = 0
/// (line complex, Pottmann & Wallner 2001), solved with reweighting from several starts.
std::vector<Axis> revolution_axes(const FitInput& input, const std::vector<Vec3>& start_directions);

/// Candidates of increasing detail: cylinder, cone, sphere and torus where the profile is one of theirs, Revolve
/// otherwise. Ends that nobody scanned are closed by a flat face named "unseen end".
std::vector<Candidate> propose_revolves(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        Context& context);

}  // namespace partscribe::fit
