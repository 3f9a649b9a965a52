// Artifacts: procedures in SCL, and what is done with STEP and IGES before and after OpenCASCADE reads them.
#include "core/ensure.h"
#include "testing/fuzz/bundle.h"
#include "testing/fuzz/entries.h"
#include "verify/evaluate/brep_bytes.h"
#include "verify/exchange/check_exchange.h"
#include "verify/scl/scl_evaluate.h"

namespace partscribe::testing {

using namespace verify;

namespace {

void check_fault(const std::optional<std::string>& fault) {
  ensure(!fault || (!fault->empty() && fault->find('\n') == std::string::npos), "a fault is one line");
}

SclLimits limits() {
  SclLimits limits;
  limits.steps = 20'000, limits.values = 100'000, limits.objects = 300;
  limits.stop = [asked = 0]() mutable { return ++asked > 3'000; };
  return limits;
}

/// What the procedure makes that comes first in a bundle; nothing if it is refused.
std::vector<SclGeometryPtr> objects_of(std::string_view bytes) {
  const Bundle bundle(bytes);
  if (bundle.first().empty()) return {};
  auto outcome = run_scl(bundle.first(), limits());
  if (!outcome.ok() || !outcome->complaints.empty()) return {};
  return std::move(outcome->objects);
}

}  // namespace

void fuzz_scl(std::string_view bytes) { (void)objects_of(bytes); }

void fuzz_scl_mesh(std::string_view bytes) {
  const auto mesh = scl_mesh(objects_of(bytes), 1, limits().stop);
  if (!mesh.ok()) return;
  for (const auto& t : mesh->mesh.triangles)
    for (const auto corner : t) ensure(corner < mesh->mesh.vertices.size(), "corners exist");
}

void fuzz_step(std::string_view bytes) { check_fault(fault_of_step(bytes)); }
void fuzz_iges(std::string_view bytes) { check_fault(fault_of_iges(bytes)); }

void fuzz_brep(std::string_view bytes) {
  const auto reading = from_bytes(bytes);
  if (!reading || !reading->ok()) return;
  const auto& mesh = (*reading)->evaluation.mesh;
  for (const auto& t : mesh.triangles)
    for (const auto corner : t) ensure(corner < mesh.vertices.size(), "corners exist");
  const auto again = from_bytes(to_bytes(*reading));
  ensure(again && again->ok(), "what was read can be handed on");
}

}  // namespace partscribe::testing
