/// What `verify`, `report` and `render` share: which files are judged by which, under which rules.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/session.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"
#include "model/model.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// At least one of each.
struct Operands {
  std::vector<Path> artifacts, scans;
};

/// CAD files are artifacts, everything else is a scan; where there is no CAD file, the first file is the artifact. The
/// usage error of a missing one begins with the `command`.
Result<Operands> told_apart(const std::vector<Path>& files, const std::string& command);

/// The model that an artifact was written from: `named`, or model.json in the artifact's folder. Edited scripts keep
/// it, under whatever name: their features are judged by its names.
Result<std::optional<Model>> model_of(const Path& artifact, const Path& named = {});

/// Tolerance and share of outliers as they were asked for, else those of the model, else chosen from the scan; what was
/// chosen is printed.
VerifyOptions verify_options(const std::optional<Model>& model, const Scan& scan, std::optional<double> outliers,
                             Session& session);

}  // namespace partscribe::cli
