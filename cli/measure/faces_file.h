/// A measured part as files for programs and sheets: faces.json (docs/faces.schema.json), faces.csv, features.csv.
#pragma once

#include <string>
#include <vector>

#include "cli/measure/measured_part.h"
#include "core/files.h"

namespace partscribe::cli {

/// All of it; positions in the scan's frame, mm and degrees. The number of a face is its "id".
std::string faces_json(const MeasuredPart& part);

/// `faces_json` and, besides, the files that were written and the warnings: for --json.
std::string faces_json(const MeasuredPart& part, const std::vector<Path>& files,
                       const std::vector<std::string>& warnings);

/// A row for each face.
std::string faces_csv(const MeasuredPart& part);

/// A row for each dimension of a feature.
std::string features_csv(const MeasuredPart& part);

}  // namespace partscribe::cli
