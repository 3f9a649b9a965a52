#include "codegen/emit.h"

#include "codegen/alpha1/alpha1.h"
#include "codegen/exchange/iges.h"
#include "codegen/exchange/step.h"
#include "codegen/openscad/openscad.h"

namespace partscribe {

const std::vector<Backend>& backends() {
  static const std::vector<Backend> all = {
      {"openscad", ".scad", "OpenSCAD script with named parameters (2021.01 or later)"},
      {"alpha1", ".scl", "Alpha_1 procedural model in SCL"},
      {"iges", ".igs", "IGES 5.3: exact solid and, where possible, its CSG tree"},
      {"step", ".step", "STEP AP214: exact solid with names and colours"},
  };
  return all;
}

Result<Artifact> emit(const CheckedModel& model, const std::string& backend, const EmitOptions& options,
                      Context& context) {
  if (context.cancelled) return Error{"stopped before writing " + backend, ErrorKind::stopped};
  if (backend == "openscad") return emit_openscad(model, options, context);
  if (backend == "alpha1") return emit_alpha1(model, options, context);
  if (backend == "iges") return emit_iges(model, options, context);
  if (backend == "step") return emit_step(model, options, context);
  std::string known;
  for (const auto& b : backends()) known += (known.empty() ? "" : ", ") + b.name;
  return usage_error("expected a backend (" + known + "), found '" + backend + "'");
}

}  // namespace partscribe
