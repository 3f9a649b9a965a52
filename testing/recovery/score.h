/// Judges what was recovered from a hard scan against the truth.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "model/check.h"
#include "testing/recovery/cases.h"

namespace partscribe::testing::recovery {

enum class Answer {
  right,        ///< the kind, or an equivalent description of the same surface, and its numbers
  cannot_tell,  ///< no procedure, a simpler one that names the truth as a rival the data cannot tell it from, or one
                ///< whose surface is off only where four of its own sigmas hold the truth
  wrong
};
const char* name_of(Answer answer);

struct Score {
  Answer answer = Answer::wrong;
  std::string found;         ///< kind, "mesh" if none
  std::string why;           ///< for anything but `right`
  double surface_error = 0;  ///< root mean square distance of the exact places, in units of their expected error
  /// A parameter of the truth that the data fix, and 0.6745 sigma of its Cramer-Rao bound, in its own unit.
  struct Number {
    std::size_t parameter = 0;
    double typical = 0;  ///< half of all errors are smaller, if they are as small as can be
    double ratio = 0;    ///< |error| / typical
  };
  std::vector<Number> numbers;
  std::vector<double> open;  ///< |error| / its own sigma, of numbers that the scanned places leave open
  double seconds = 0;        ///< processor time
  std::optional<CheckedModel> model;
  std::vector<std::uint8_t> rejected;  ///< points of the scan that were set aside
};

/// Fits the scan and compares the answer with the truth. The bound of a number is the Cramer-Rao bound in the truth's
/// own parameters with the true noise of each point. A number whose bound is more than a tenth of the size is open, and
/// is not judged. A number is right within 4 of its own sigmas or 6 times the bound; a surface within 6 times the error
/// expected of the fit.
Score recovered(const Case& c, Context& context);

}  // namespace partscribe::testing::recovery
