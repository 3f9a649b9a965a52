#include "fit/surface/free_form.h"

#include <algorithm>
#include <string>

#include "fit/surface/flatten.h"
#include "fit/surface/grid_fit.h"
#include "fit/surface/height_map.h"
#include "fit/surface/piece_fit.h"
#include "fit/surface/spline_charts.h"
#include "fit/surface/spline_sheet.h"
#include "fit/surface/triangulate.h"
#include "geometry/mesh/mesh_neighbours.h"
#include "geometry/mesh/mesh_part.h"
#include "model/surface_patches.h"

namespace partscribe::fit {
namespace {

/// The connected pieces of a mesh, the largest first.
std::vector<TriangleMesh> pieces_by_area(const TriangleMesh& mesh) {
  std::vector<TriangleMesh> pieces;
  for (const auto& triangles : connected_pieces(mesh_neighbours(mesh))) pieces.push_back(part_of(mesh, triangles).mesh);
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const TriangleMesh& a, const TriangleMesh& b) { return area(a) > area(b); });
  return pieces;
}

/// One surface for a piece that can be laid out and fitted so, several else.
std::vector<TrimmedSurface> surfaces_of(const TriangleMesh& piece, const FitInput& input, Context& context) {
  if (!topology(piece).closed())
    if (const auto places = flattened(piece))
      if (auto one = spline_sheet(piece, *places, input, context)) return {std::move(*one)};
  return spline_charts(piece, input, context);
}

Candidate sheet_or_body(SurfaceSet set, double tolerance, Context& context) {
  if (set.patches.size() == 1) set.patches[0].name = "surface";
  Candidate candidate;
  candidate.procedure = "free form";
  candidate.object_name = set.closed ? "body" : "sheet";
  if (!set.closed) {
    candidate.parameters.push_back(sheet_thickness(tolerance));
    set.thickness = Expr::of(candidate.parameters.back().name);
  }
  for (const auto& patch : set.patches) candidate.extra_numbers += static_cast<int>(3 * patch.control.size());
  context.say("free form: " + std::to_string(set.patches.size()) + " surfaces, " +
              std::to_string(candidate.extra_numbers / 3) + " control points");
  candidate.shape = std::move(set);
  return candidate;
}

}  // namespace

std::optional<Candidate> free_form(const TriangleMesh& mesh, const FitInput& input, Context& context) {
  if (mesh.empty()) return std::nullopt;
  const double tolerance = input.tolerance, whole = area(mesh);
  SurfaceSet set;
  set.closed = topology(mesh).closed();
  int edges = 0;
  for (const TriangleMesh& piece : pieces_by_area(mesh)) {
    if (!set.closed && area(piece) < 0.002 * whole) break;
    auto surfaces = surfaces_of(piece, input, context);
    if (surfaces.empty() || context.cancelled) return std::nullopt;
    int most = edges;
    for (TrimmedSurface& surface : surfaces) {
      for (auto& loop : surface.loops)
        for (auto& trim : loop) most = std::max(most, trim.edge += edges);
      round_numbers(surface, tolerance);
      set.patches.push_back(trimmed_patch(surface, "surface " + std::to_string(set.patches.size() + 1)));
    }
    edges = most;
  }
  if (set.patches.empty()) return std::nullopt;
  return sheet_or_body(std::move(set), tolerance, context);
}

std::optional<Candidate> free_form_of_map(const FitInput& input, Context& context) {
  if (!input.scan || !input.scan->mesh.empty()) return std::nullopt;
  const auto grid = height_map_of(input.scan->cloud);
  if (!grid) return std::nullopt;
  context.say("free form: a height map of " + std::to_string(grid->u.size()) + " x " + std::to_string(grid->v.size()) +
              " points");
  GridFitOptions options;
  options.tolerance = fit_share * input.tolerance, options.noise = input.sampling.sigma;
  auto fit = fit_grid(*grid, options, context);
  if (!fit) return std::nullopt;
  TrimmedSurface whole{std::move(fit->surface), {}};
  round_numbers(whole, input.tolerance);
  SurfaceSet set;
  set.patches.push_back(with_border(trimmed_patch(whole, "surface")));
  return sheet_or_body(std::move(set), input.tolerance, context);
}

}  // namespace partscribe::fit
