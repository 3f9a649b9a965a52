/// Depth images as arrays of numpy.
#pragma once

#include "scan/read/range_file.h"

namespace partscribe::scan {

/// A .npy file (format 1 to 3, row by row, two axes). '<u2': codes as those of a PNG. '<f4', '<f8': depths in the
/// sidecar's unit, put into 65,533 equal steps from the least to the largest; what is no number, not above 0, or ten
/// times as far as the middle one did not return.
Result<RangeCodes> parse_npy(std::string_view bytes, const std::string& name);

}  // namespace partscribe::scan
