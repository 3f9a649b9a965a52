/// The fallback that always works: a triangulation within tolerance of the data, as small as that allows.
#pragma once

#include <optional>
#include <utility>

#include "core/result.h"
#include "fit/candidate.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::fit {

/// The parameter of an open surface that says how thick the solid made from it is; chosen, not measured.
Parameter sheet_thickness(double tolerance);

/// The surface of one scan, found once and simplified to any tolerance.
class Triangulator {
 public:
  /// `input` and `context` must outlive it.
  Triangulator(const FitInput& input, Context& context) : input_(input), context_(context) {}

  /// A candidate whose shape is a TriSurface in the scan's frame (scan_from_part is the identity or a plain shift), as
  /// few triangles as lie within a share of `tolerance` (mm) of the surface. From a source mesh: cleaned, small holes
  /// closed, decimated. From points: reconstructed, then decimated. The result is manifold and consistently oriented;
  /// closed if the data bound a solid. Points that span no surface are an error.
  Result<Candidate> within(double tolerance);

  /// The source mesh as a body whose triangles stand for planes, cylinders and the like; nothing for points, and for
  /// meshes that are mostly free form.
  const std::optional<Candidate>& of_faces(double tolerance);

  /// The surface that the data span, as finely as it is known if it is closed; nothing where they span none.
  std::optional<TriangleMesh> surface_of_data(double tolerance);

  /// The surface itself, before anything was simplified; nothing where it is made for a tolerance only (points seen
  /// from one side, meshes).
  std::optional<Candidate> unsimplified() const;

 private:
  /// The repaired mesh of the scan, or the surface of its points.
  const TriangleMesh& surface(double tolerance);
  TriangleMesh repaired(double tolerance) const;
  TriangleMesh from_points(double tolerance);

  const FitInput& input_;
  Context& context_;
  std::optional<TriangleMesh> surface_;
  std::optional<std::pair<double, std::optional<Candidate>>> faced_;
  std::optional<std::pair<double, TriangleMesh>> last_;  // what surface() gave, and for which tolerance
};

}  // namespace partscribe::fit
