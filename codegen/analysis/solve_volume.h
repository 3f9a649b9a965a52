/// The value of one parameter at which a model has the volume that was asked for.
#pragma once

#include <string>

#include "codegen/analysis/sensitivity.h"

namespace partscribe::codegen {

/// What came of the search. Every number is of a model that was built.
struct SolvedVolume {
  bool found = false;
  double value = 0;            ///< of the parameter, rounded to what the volume needs; the nearest tried if not found
  double volume = 0;           ///< mm^3, at this value
  double low = 0, high = 0;    ///< of the parameter: the range in which models were built
  double least = 0, most = 0;  ///< mm^3, in that range
  std::string limit;           ///< not found: why the search did not go further
  int builds = 0;
};

/// A usage error if there is no such parameter, or if it is computed or counted: there is nothing to solve for.
Result<Done> check_solvable(const CheckedModel& model, const std::string& parameter);

/// Looks from the present value in the direction in which the volume comes nearer, then in the other, as far as models
/// can be built; then between two values by the Illinois method. Errors: those of check_solvable, stopped.
Result<SolvedVolume> solve_volume(const CheckedModel& model, const std::string& parameter, double volume,
                                  Context& context);

}  // namespace partscribe::codegen
