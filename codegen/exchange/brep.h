/// The exact boundary of a model's part as an OpenCASCADE shape, placed as the artifacts are.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codegen/backend.h"
#include "core/context.h"
#include "core/result.h"
#include "model/check.h"

class TopoDS_Shape;

namespace partscribe::codegen {

/// A face with the name a person gave it.
struct WrittenFace {
  std::shared_ptr<TopoDS_Shape> face;
  std::string name;               ///< as ModelDistance has it: "shank"; unique within the part
  std::array<double, 3> color{};  ///< sRGB, 0..1; one colour per object
};

struct Brep {
  std::shared_ptr<TopoDS_Shape> shape;  ///< a solid (or a compound of several), or the shell of an open sheet
  bool solid = true;
  std::vector<WrittenFace> faces;  ///< in the order of the shape
  double error = 0;                ///< mm, how far the shape is from the model (superellipsoids are approximated)
};

/// Placed by `scan_from_part` when `model.as_scanned`. Checked: valid, closed where it is a solid, and of a volume
/// that agrees with its own tessellation. Errors name the object that could not be built.
Result<Brep> build_brep(const CheckedModel& model, Context& context);

/// The same without names of faces, which take as long as the rest: for bodies that are only measured.
Result<Brep> build_body(const CheckedModel& model, Context& context);

/// The boundary that several backends write.
struct SharedBrep {
  std::optional<Result<Brep>> built;
};

/// The one that the options hold, built if it is not there yet; else a new one.
Result<Brep> brep_of(const CheckedModel& model, const EmitOptions& options, Context& context);

}  // namespace partscribe::codegen
