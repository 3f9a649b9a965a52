/// The constrained iterative closest point algorithm of 1993: one view against the model so far
/// (sections 2.1.1, 2.1.2).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scan/register/as_published/constraints.h"

namespace partscribe::scan {

struct IcpResult {
  StateVector state;                ///< world_from_view: all displacements cumulated upon the first estimate
  std::vector<double> errors;       ///< e(q) of each iteration, mm^2, of the matches that counted
  std::vector<std::uint8_t> valid;  ///< 1 for each point that counted in the last iteration
  std::size_t overlapping = 0;      ///< points that lie on the model at the end, within a pixel and facing the same way
  std::size_t asked = 0;            ///< points that were matched: those that are visible
  std::string failure;              ///< empty, or why the state is not to be used
};

/// Matches points with the model, leaves mismatches and inconsistent normals out, displaces the points and starts
/// again, until e(q) is below the threshold or no longer falls. `visible`: points that take part, 1 each. `pixel`: mm
/// between neighbours in the view.
///
/// It fails where the paper says that it must: where what does not overlap predominates among the matched points and
/// the first estimate is wrong. Then less than `least_overlap` of them lie on the model at the end.
IcpResult constrained_icp(const std::vector<ReferencePoint>& points, const std::vector<std::uint8_t>& visible,
                          const PublishedModel& model, const StateVector& first_estimate, double pixel,
                          const PaperOptions& options);

}  // namespace partscribe::scan
