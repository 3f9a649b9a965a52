#include "verify/evaluate/alpha1.h"

#include <chrono>

#include "verify/scl/scl_evaluate.h"

namespace partscribe::verify {

Result<Evaluation> evaluate_alpha1(const Path& path, const EvaluateOptions& options, Context& context) {
  // The clock only ends a run that takes too long, and fills the field that reports how long it took.
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  SclLimits limits;
  limits.stop = [&] { return context.cancelled.load() || seconds() > options.seconds; };

  Evaluation evaluation;
  evaluation.backend = "alpha1";
  evaluation.program = "partscribe scl interpreter";
  evaluation.version = "1.0";
  auto outcome = run_scl(path, limits);
  if (!outcome.ok()) return outcome.error();
  evaluation.complaints = outcome->complaints;
  if (evaluation.complaints.empty()) {
    auto mesh = scl_mesh(outcome->objects, options.tolerance / 10, limits.stop);
    if (!mesh.ok() && mesh.error().kind == ErrorKind::stopped)
      return Error{path.string() + ": " + mesh.error().message, ErrorKind::stopped};
    if (!mesh.ok()) {
      evaluation.complaints.push_back(path.filename().string() + ": " + mesh.error().message);
    } else {
      evaluation.mesh = std::move(mesh->mesh);
      evaluation.error = mesh->error;
      evaluation.solid = mesh->solid;
    }
  }
  evaluation.failed = !evaluation.complaints.empty();
  evaluation.seconds = seconds();
  return evaluation;
}

}  // namespace partscribe::verify
