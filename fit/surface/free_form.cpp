#include "fit/surface/free_form.h"

#include <algorithm>
#include <string>

#include "fit/surface/flatten.h"
#include "fit/surface/piece_fit.h"
#include "fit/surface/spline_charts.h"
#include "fit/surface/spline_sheet.h"
#include "fit/surface/triangulate.h"
#include "model/surface_patches.h"

namespace partscribe::fit {
namespace {

/// The connected pieces of a mesh, the largest first.
std::vector<TriangleMesh> connected_pieces(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> root(mesh.vertices.size());
  for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = i;
  const auto find = [&](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 1; k < 3; ++k) {
      const auto a = find(t[0]), b = find(t[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::vector<TriangleMesh> pieces;
  std::vector<std::uint32_t> piece_of(root.size(), ~0u), index(root.size(), ~0u);
  for (const auto& t : mesh.triangles) {
    const auto r = find(t[0]);
    if (piece_of[r] == ~0u) piece_of[r] = static_cast<std::uint32_t>(pieces.size()), pieces.emplace_back();
    TriangleMesh& piece = pieces[piece_of[r]];
    auto& corners = piece.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      if (index[t[k]] == ~0u) {
        index[t[k]] = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back(mesh.vertices[t[k]]);
      }
      corners[k] = index[t[k]];
    }
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const TriangleMesh& a, const TriangleMesh& b) { return area(a) > area(b); });
  return pieces;
}

/// One surface for a piece that can be laid out, several else.
std::vector<TrimmedSurface> surfaces_of(const TriangleMesh& piece, const FitInput& input, Context& context) {
  if (!topology(piece).closed())
    if (const auto places = flattened(piece)) {
      std::vector<TrimmedSurface> result;
      if (auto one = spline_sheet(piece, *places, input, context)) result.push_back(std::move(*one));
      return result;
    }
  return spline_charts(piece, input, context);
}

}  // namespace

std::optional<Candidate> free_form(const TriangleMesh& mesh, const FitInput& input, Context& context) {
  if (mesh.empty()) return std::nullopt;
  const double tolerance = input.tolerance, whole = area(mesh);
  SurfaceSet set;
  set.closed = topology(mesh).closed();
  int edges = 0;
  for (const TriangleMesh& piece : connected_pieces(mesh)) {
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

}  // namespace partscribe::fit
