#include "fit/offers.h"

#include <utility>

namespace partscribe::fit {

Result<bool> Offers::take(Attempt& attempt) {
  ProcedureSearch& search = attempt.search;
  while (search.found && !context_.cancelled) {
    scan_.cloud.rejected = attempt.scan.rejected;
    auto model = finished(attempt, refused_, scan_, options_, context_);
    if (!model) return model.error();
    auto reason = offer(std::move(*model));
    if (!reason) return reason.error();
    if (reason->empty()) return true;
    *reason = "refused: " + *reason;
    refused_.push_back(rival_of(search.judged.front(), search.evidence, *reason));
    if (enough())
      search.found = false;
    else
      choose_another(search, *reason, attempt.scan.input, options_, context_);
  }
  return false;
}

Result<bool> Offers::take_mesh(const Attempt& attempt) {
  scan_.cloud.rejected = attempt.scan.rejected;
  Triangulator triangulator(attempt.scan.input, context_);
  if (options_.force != only_a_mesh) {
    auto surfaces = as_free_form(attempt, triangulator, refused_, scan_, options_, context_);
    if (!surfaces) return surfaces.error();
    if (*surfaces) {
      const auto reason = offer(std::move(**surfaces));
      if (!reason) return reason.error();
      if (reason->empty()) return true;
    }
  }
  auto mesh = triangulated(attempt, triangulator, refused_, scan_, options_, context_);
  if (!mesh && (refused_.empty() || mesh.error().kind == ErrorKind::stopped)) return mesh.error();
  if (!mesh) return false;
  const auto reason = offer(std::move(*mesh));
  return reason ? Result<bool>(reason->empty()) : reason.error();
}

Result<std::string> Offers::offer(CheckedModel model) {
  auto reason = options_.refusal ? options_.refusal(model) : Result<std::string>(std::string());
  if (!reason) return reason;
  if (!reason->empty()) context_.say("refused: " + *reason);
  if (reason->empty()) {
    answer_ = std::move(model);
  } else if (!first_) {
    first_ = std::move(model);
    first_rejected_ = scan_.cloud.rejected;
  }
  return reason;
}

CheckedModel Offers::answer() {
  if (answer_) return std::move(*answer_);
  ensure(first_.has_value(), "a build that offered no model");
  scan_.cloud.rejected = first_rejected_;
  return std::move(*first_);
}

}  // namespace partscribe::fit
