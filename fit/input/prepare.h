/// Prepares a scan for fitting: normals, noise, outliers, and an even, order-independent selection of points.
#pragma once

#include "core/result.h"
#include "fit/candidate.h"

namespace partscribe::fit {

/// Fills what the scan's cloud lacks (normals, sigma, rejected). Fails if fewer than 50 points are left.
Result<FitInput> prepare(Scan& scan, double tolerance, Context& context);

/// Some `wanted` points of a prepared scan, for judgements that need more of them than fitting does.
FitInput selection(const Scan& scan, const SamplingSummary& sampling, double tolerance, std::size_t wanted);

}  // namespace partscribe::fit
