/// Which wider tolerance to try where a build did not verify a procedure: one at which a procedure was built and
/// verified.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "model/model.h"
#include "verify/verify.h"

namespace partscribe::cli {

/// A procedure (one of procedure_words()) and a tolerance in mm.
struct Wider {
  std::string procedure;
  double tolerance;
};

/// `deviation` and a little, mm, rounded up to two digits: the tolerance to ask for where something is that far off.
double tolerance_that_lets(double deviation);

/// The largest deviation of what a verdict finds wrong, mm; nothing if nothing is wrong, or if it is not all a matter
/// of how far something is off.
std::optional<double> most_off(const Verdict& verdict);

/// The same procedure at the tolerance that lets what its verdict found; nothing if no tolerance does, or only one
/// above `reach` (mm).
std::optional<Wider> wider_for(const std::string& procedure, const Verdict& verdict, double reach);

/// The verdict of a build of one procedure at one tolerance; nothing if it found no such procedure.
using WiderTrial = std::function<Result<std::optional<Verdict>>(const Wider&)>;

/// The first of the proposals that is verified, the least tolerance first, each once more as far off as its verdict
/// says, three trials at most. `reach` (mm): nothing wider is of use to anyone.
Result<std::optional<Wider>> first_verified(std::vector<Wider> proposals, double reach, const WiderTrial& trial);

}  // namespace partscribe::cli
