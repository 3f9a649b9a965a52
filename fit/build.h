/// From a scan to the model of a part: the whole fitting pipeline behind one call.
#pragma once

#include <functional>
#include <string>

#include "core/context.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"
#include "model/check.h"

namespace partscribe::fit {

struct BuildOptions {
  double tolerance = 0.1;     ///< mm; the model must lie within this of the data everywhere
  std::string name = "part";  ///< of the part, for the artifacts
  bool nominal = true;        ///< replace a fitted value by a nominal one where the data cannot tell them apart
  bool triangulate = true;    ///< false: fail where no procedure meets the tolerance, instead of a triangulation
  std::string force = {};     ///< only this procedure ("revolve", "extrude", ...); empty: the best
  /// Called with each model before it is returned. Answers why the model must be rejected (no CAD system can build it,
  /// the verifier refuses it), or nothing. After a rejection the next best model is tried, and finally a triangulation.
  /// Empty: no model is rejected.
  std::function<Result<std::string>(const CheckedModel&)> refusal = {};
};

/// The scan's cloud gets normals, noise and outlier flags on the way (they belong into cloud.ply).
/// Every usable scan yields a model; Model::fallback says when it is only a triangulation. Where every model is refused
/// the first one is the answer.
Result<CheckedModel> build_model(Scan& scan, const BuildOptions& options, Context& context);

}  // namespace partscribe::fit
