/// Executes an Alpha_1 procedure and tells which objects it makes.
#pragma once

#include <string>
#include <vector>

#include "core/files.h"
#include "core/result.h"
#include "verify/scl/scl_geometry.h"

namespace partscribe::verify {

/// So that no text, however it is meant, runs without end.
struct SclLimits {
  std::size_t steps = 5'000'000;    ///< statements and calls
  std::size_t values = 10'000'000;  ///< members of arrays altogether
  std::size_t objects = 200'000;    ///< curves, surfaces and shells
  int recursion = 64;               ///< procedures in procedures
  int include_depth = 16;
  std::uint64_t bytes = 256u << 20;  ///< of one file
  SclStop stop;                      ///< asked often; true gives up
};

/// What came out, or why the text is refused.
struct SclOutcome {
  std::vector<SclGeometryPtr> objects;  ///< of the last dump, else of the last show, else the last labelled solid
  std::vector<std::string> complaints;  ///< file:line:column: what is wrong; not empty: refused
};

/// Errors: the file itself cannot be read, or the run was stopped. Everything else that is wrong is a complaint.
Result<SclOutcome> run_scl(const Path& path, const SclLimits& limits);

}  // namespace partscribe::verify
