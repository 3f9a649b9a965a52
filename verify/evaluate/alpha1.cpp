#include "verify/evaluate/alpha1.h"

#include "verify/scl/scl_evaluate.h"

namespace partscribe::verify {

Result<BrepReading> read_alpha1(const Path& path, const EvaluateOptions& options) {
  BrepReading reading;
  Evaluation& evaluation = reading.evaluation;
  evaluation.backend = "alpha1";
  evaluation.program = scl_interpreter;
  evaluation.version = "1.0";
  auto outcome = run_scl(path, {});
  if (!outcome.ok()) return outcome.error();
  evaluation.complaints = outcome->complaints;
  if (evaluation.complaints.empty()) {
    auto mesh = scl_mesh(outcome->objects, options.tolerance / 10, {});
    if (!mesh.ok()) {
      evaluation.complaints.push_back(path.filename().string() + ": " + mesh.error().message);
    } else {
      evaluation.mesh = std::move(mesh->mesh);
      evaluation.error = mesh->error;
      evaluation.solid = mesh->solid;
    }
  }
  evaluation.failed = !evaluation.complaints.empty();
  return reading;
}

}  // namespace partscribe::verify
