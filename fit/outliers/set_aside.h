/// A scan without the points that are no surface.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

/// A scan as it is fitted, and which of its points are not.
struct Fitted {
  FitInput input;
  std::vector<std::uint8_t> rejected;  ///< of the scan's points
};

/// The scan without its outliers; none if there are hardly any, or of a mesh. The planes by which outliers are
/// recognised also give better normals and a better estimate of the noise than neighbourhoods that contain outliers.
std::optional<Fitted> without_outliers(const Scan& scan, FitInput input, Context& context);

}  // namespace partscribe::fit
