/// What is written where no procedure describes a scan.
#pragma once

#include <optional>

#include "core/result.h"
#include "fit/evidence/evidence.h"
#include "fit/surface/triangulate.h"

namespace partscribe::fit {

struct Fallback {
  Candidate candidate;
  CandidateEvidence evidence;  ///< of up to 400,000 points
  double covered = 0;          ///< share of its surface that the data saw
};

/// Trimmed B-spline surfaces where they describe the surface of the data within the tolerance, unless the faces of a
/// mesh are known. `input` must come from a scan.
std::optional<Fallback> free_form_of(const FitInput& input, Triangulator& triangulator, Context& context);

/// The smallest triangulation that lies safely within the tolerance of the scan. It aims at a share of the tolerance.
/// Where that was not enough it tries again with finer triangles, as long as the triangles and not the surface that
/// they approximate are the cause. `input` must come from a scan.
Result<Fallback> fallback_of(const FitInput& input, Triangulator& triangulator, Context& context);

}  // namespace partscribe::fit
