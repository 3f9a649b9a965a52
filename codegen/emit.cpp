#include "codegen/emit.h"

#include "codegen/alpha1/alpha1.h"
#include "codegen/exchange/iges.h"
#include "codegen/exchange/step.h"
#include "codegen/openscad/openscad.h"

namespace partscribe::codegen {

const std::vector<Backend>& backends() {
  static const std::vector<Backend> all = {openscad_backend(), alpha1_backend(), iges_backend(), step_backend()};
  return all;
}

Result<Artifact> emit(const CheckedModel& model, const std::string& backend, const EmitOptions& options,
                      Context& context) {
  if (context.cancelled) return Error{"stopped before writing " + backend, ErrorKind::stopped};
  std::string known;
  for (const auto& b : backends()) {
    if (b.name == backend) return b.emit(model, options, context);
    known += (known.empty() ? "" : ", ") + b.name;
  }
  return usage_error("expected a backend (" + known + "), found '" + backend + "'");
}

}  // namespace partscribe::codegen
