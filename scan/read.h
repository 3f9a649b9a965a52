/// Reads scans: one or several files in any supported form become one Scan in one frame, in millimetres.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/point_cloud.h"

namespace partscribe {

/// Millimetres per unit.
struct Unit {
  std::string name;  ///< "mm", "cm", "m", "inch"
  double millimetres = 1;
};

std::optional<Unit> parse_unit(const std::string& name);

struct ReadOptions {
  std::optional<Unit> unit;  ///< none: what the file or its sidecar says, else mm with a plausibility warning
};

/// Inputs: files of read_geometry's formats; a scan.json (range images or clouds with poses) or a folder holding
/// one; a 16-bit PNG or PGM range image with a .json sidecar; a Stanford .conf. Several files are several views in
/// one common frame. Fails on the first file that cannot be used.
Result<Scan> read_scan(const std::vector<Path>& inputs, const ReadOptions& options, Context& context);

}  // namespace partscribe
