/// The models of a scan that were offered to whoever asked for one, and what was said of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fit/finish.h"

namespace partscribe::fit {

class Offers {
 public:
  Offers(Scan& scan, const BuildOptions& options, Context& context)
      : scan_(scan), options_(options), context_(context) {}

  /// Offers what was found in an attempt, and for as long as that is refused the next best. True if one was taken.
  Result<bool> take(Attempt& attempt);

  /// Offers B-spline surfaces of an attempt where these describe it, then its triangulation. If that fails as well, a
  /// refused procedure is still better than no model.
  Result<bool> take_mesh(const Attempt& attempt);

  /// Each trial costs a verification; after so many no procedure describes the part.
  bool enough() const { return refused_.size() >= 3; }

  /// The accepted model; else the first one, which was the best candidate.
  CheckedModel answer();

 private:
  Scan& scan_;
  const BuildOptions& options_;
  Context& context_;
  std::optional<CheckedModel> answer_, first_;
  std::vector<std::uint8_t> first_rejected_;
  std::vector<Rival> refused_;

  /// Why the model is not taken; empty if it is the answer.
  Result<std::string> offer(CheckedModel model);
};

}  // namespace partscribe::fit
