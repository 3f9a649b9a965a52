/// What was found in a scan, as a model that says where it comes from, how well it fits and what else it may be.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/build.h"
#include "fit/outliers/set_aside.h"
#include "fit/search/search.h"
#include "fit/surface/triangulate.h"

namespace partscribe::fit {

/// A scan, with or without its outliers, and what was found in it.
struct Attempt {
  Fitted scan;
  ProcedureSearch search;
};

/// A rival that is named in the model.
Rival rival_of(const Judged& judged, const CandidateEvidence& evidence, const std::string& reason);

/// The attempt's procedure with its provenance, its evidence and its rivals. `refused` are named first.
Result<CheckedModel> finished(const Attempt& attempt, const std::vector<Rival>& refused, const Scan& scan,
                              const BuildOptions& options, Context& context);

/// The same for free form, as B-spline surfaces of what `triangulator` has of the attempt's points; nothing where they
/// do not describe the attempt's points.
Result<std::optional<CheckedModel>> as_free_form(const Attempt& attempt, Triangulator& triangulator,
                                                 const std::vector<Rival>& refused, const Scan& scan,
                                                 const BuildOptions& options, Context& context);

/// The same for a triangulation of the attempt's points.
Result<CheckedModel> triangulated(const Attempt& attempt, Triangulator& triangulator, const std::vector<Rival>& refused,
                                  const Scan& scan, const BuildOptions& options, Context& context);

}  // namespace partscribe::fit
