#include "fit/surface/spline_sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/number.h"
#include "fit/surface/border_curves.h"
#include "fit/surface/flatten.h"
#include "fit/surface/spline_fit.h"
#include "fit/surface/triangulate.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
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

double signed_area(const std::vector<Vec2>& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

/// The points of the scan that lie on a piece, at their places in its plane.
SplineData data_on(const TriangleMesh& piece, const std::vector<Vec2>& places, const FitInput& input, double reach,
                   Context& context) {
  const MeshDistance distance(piece, context.threads);
  const auto hits = distance.closest(input.cloud.points, context.threads);
  SplineData data;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].distance > reach) continue;
    const auto& t = piece.triangles[hits[i].triangle];
    const Vec3 a = piece.vertices[t[0]], ab = piece.vertices[t[1]] - a, ac = piece.vertices[t[2]] - a,
               d = hits[i].point - a;
    const double bb = ab.squaredNorm(), cc = ac.squaredNorm(), bc = ab.dot(ac);
    const double det = std::max(bb * cc - bc * bc, 1e-300);
    const double s = (cc * d.dot(ab) - bc * d.dot(ac)) / det, r = (bb * d.dot(ac) - bc * d.dot(ab)) / det;
    data.points.push_back(input.cloud.points[i]);
    data.places.push_back(places[t[0]] + s * (places[t[1]] - places[t[0]]) + r * (places[t[2]] - places[t[0]]));
  }
  return data;
}

/// Does a place lie to the left of all outlines?
bool inside(const std::vector<std::vector<Vec2>>& outlines, const Vec2& p) {
  bool odd = false;
  for (const auto& loop : outlines)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      if ((a.y() <= p.y()) != (b.y() <= p.y()) && a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) > p.x())
        odd = !odd;
    }
  return odd;
}

/// Outlines that hold places beyond them.
class Outlines {
 public:
  explicit Outlines(std::vector<std::vector<Vec2>> loops) : loops_(std::move(loops)) {
    std::vector<Vec3> corners;
    for (std::size_t l = 0; l < loops_.size(); ++l)
      for (std::size_t i = 0; i < loops_[l].size(); ++i) {
        corners.emplace_back(loops_[l][i].x(), loops_[l][i].y(), 0);
        corner_.emplace_back(l, i);
      }
    tree_ = std::make_unique<KdTree>(corners);
  }

  /// How far places up to `most` mm outside lie beyond the outline, for each corner that is nearest to one.
  std::vector<std::vector<double>> beyond(const std::vector<Vec2>& places, double most) const {
    std::vector<std::vector<double>> result;
    for (const auto& loop : loops_) result.emplace_back(loop.size(), 0.0);
    for (const Vec2& p : places) {
      const auto [l, i] = corner_[tree_->nearest_one(Vec3(p.x(), p.y(), 0)).index];
      const auto& loop = loops_[l];
      double off = 1e300;
      for (const std::size_t from : {(i + loop.size() - 1) % loop.size(), i}) {
        const Vec2 &a = loop[from], d = loop[(from + 1) % loop.size()] - a;
        const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
        off = std::min(off, (a + t * d - p).norm());
      }
      if (off <= most && off > result[l][i] && !inside(loops_, p)) result[l][i] = off;
    }
    return result;
  }

  /// Moved outwards, each corner by the most that is asked of corners within `window` mm of it.
  std::vector<std::vector<Vec2>> grown(const std::vector<std::vector<double>>& by, double window) const {
    std::vector<std::vector<Vec2>> result = loops_;
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      const auto& loop = loops_[l];
      const std::size_t n = loop.size();
      for (std::size_t i = 0; i < n; ++i) {
        double most = by[l][i];
        for (std::size_t k = 0; k < n; ++k)
          if ((loop[k] - loop[i]).norm() < window) most = std::max(most, by[l][k]);
        const Vec2 along = loop[(i + 1) % n] - loop[(i + n - 1) % n];
        if (along.norm() > 0) result[l][i] += most / along.norm() * Vec2(along.y(), -along.x());
      }
    }
    return result;
  }

 private:
  std::vector<std::vector<Vec2>> loops_;
  std::vector<std::pair<std::size_t, std::size_t>> corner_;  // loop and place in it
  std::unique_ptr<KdTree> tree_;
};

/// One loop of trims for each outline; nothing where one of them is too small to be drawn.
std::vector<std::vector<SurfaceTrim>> trims_of(const std::vector<std::vector<Vec2>>& outlines, double tolerance) {
  std::vector<std::vector<SurfaceTrim>> loops;
  for (const auto& outline : outlines) {
    auto& loop = loops.emplace_back();
    for (auto& curve : border_curves(outline, tolerance)) loop.push_back({std::move(curve), 0});
    if (loop.empty()) return {};
  }
  return loops;
}

/// The same closed line with corners no farther apart than `step`.
std::vector<Vec2> denser(const std::vector<Vec2>& loop, double step) {
  std::vector<Vec2> result;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 d = loop[(i + 1) % loop.size()] - loop[i];
    const int pieces = std::clamp(static_cast<int>(std::ceil(d.norm() / step)), 1, 1000);
    for (int k = 0; k < pieces; ++k) result.push_back(loop[i] + k * d / pieces);
  }
  return result;
}

/// A mesh of scattered points ends before the last of them, at a ragged border. The trims are smooth at the distance of
/// the points, and no point lies farther outside than half of the tolerance.
std::vector<std::vector<SurfaceTrim>> trims_around(std::vector<std::vector<Vec2>> outlines,
                                                   const std::vector<Vec2>& places, const FitInput& input, int& edge) {
  const bool drawn = input.scan && !input.scan->mesh.empty();
  const double spacing = drawn ? 0 : input.thin_spacing;
  const double smooth = std::max(0.5 * input.tolerance, 1.2 * spacing), most = 4 * input.thin_spacing;
  std::stable_sort(outlines.begin(), outlines.end(),
                   [](const auto& a, const auto& b) { return signed_area(a) > signed_area(b); });
  // Holes that no point could be missing from are none.
  outlines.erase(std::remove_if(outlines.begin() + 1, outlines.end(),
                                [&](const auto& loop) { return std::abs(signed_area(loop)) < smooth * smooth; }),
                 outlines.end());
  for (auto& loop : outlines) loop = denser(loop, smooth);
  {
    const Outlines ragged(outlines);
    outlines = ragged.grown(ragged.beyond(places, most), 2 * spacing);
  }
  std::vector<std::vector<SurfaceTrim>> loops;
  for (int round = 0; round < 3; ++round) {
    loops = trims_of(outlines, smooth);
    if (loops.empty() || round == 2) break;
    std::vector<std::vector<Vec2>> drawn_loops;
    for (const auto& loop : loops) {
      auto& line = drawn_loops.emplace_back();
      for (const auto& trim : loop)
        for (int i = 0; i < 200; ++i)
          line.push_back(trim.curve.at(trim.curve.t.low() + (trim.curve.t.high() - trim.curve.t.low()) * i / 200));
    }
    auto missed = Outlines(drawn_loops).beyond(places, most);
    bool all = true;
    std::vector<std::vector<double>> by;
    for (std::size_t l = 0; l < loops.size(); ++l) {
      const double worst = *std::max_element(missed[l].begin(), missed[l].end()) - 0.5 * input.tolerance;
      by.emplace_back(outlines[l].size(), std::max(worst, 0.0));
      all = all && worst <= 0;
    }
    if (all) break;
    outlines = Outlines(outlines).grown(by, 0);
  }
  for (auto& loop : loops)
    for (auto& trim : loop) trim.edge = ++edge;
  return loops;
}

/// Numbers as they are printed: control points to a hundredth of the tolerance, parameters likewise.
void round_numbers(TrimmedSurface& trimmed, double tolerance) {
  const double step = power_of_ten_below(tolerance / 50);
  for (Vec3& p : trimmed.surface.points)
    for (int k = 0; k < 3; ++k) p[k] = snapped(p[k], step);
  for (KnotVector* t : {&trimmed.surface.u, &trimmed.surface.v})
    for (double& knot : t->knots) knot = snapped(knot, step);
  for (auto& loop : trimmed.loops)
    for (auto& trim : loop) {
      for (Vec2& p : trim.curve.points) p = {snapped(p.x(), step), snapped(p.y(), step)};
      for (double& knot : trim.curve.t.knots) knot = snapped(knot, 1e-6);
    }
}

}  // namespace

std::optional<Candidate> spline_sheet(const TriangleMesh& mesh, const FitInput& input, Context& context) {
  if (mesh.empty() || topology(mesh).closed()) return std::nullopt;
  const double tolerance = input.tolerance;
  const double whole = area(mesh);
  SurfaceSet set;
  int edge = 0;
  std::vector<std::pair<TriangleMesh, std::vector<Vec2>>> laid_out;
  for (TriangleMesh& piece : connected_pieces(mesh)) {
    if (area(piece) < 0.002 * whole) break;
    auto places = flattened(piece);
    if (!places) {
      context.say("free form: a piece of the surface cannot be laid out in a plane");
      return std::nullopt;
    }
    laid_out.emplace_back(std::move(piece), std::move(*places));
  }
  for (const auto& [piece, places] : laid_out) {
    // Corners of the border are points as well: where they come to lie on the surface, it ends.
    SplineData data = data_on(piece, places, input, 3 * tolerance, context);
    const auto border = border_loops(piece);
    const std::size_t first_of_border = data.points.size();
    for (const auto& loop : border)
      for (const auto v : loop) data.points.push_back(piece.vertices[v]), data.places.push_back(places[v]);
    SplineFitOptions options;
    options.tolerance = 0.7 * tolerance;
    options.noise = input.sampling.sigma;
    options.low = Vec2::Constant(1e300), options.high = Vec2::Constant(-1e300);
    for (const Vec2& p : data.places) options.low = options.low.cwiseMin(p), options.high = options.high.cwiseMax(p);
    // A little beyond the border, which is free to move while parameters are corrected; whole hundredths of a
    // tolerance.
    const double step = power_of_ten_below(tolerance / 50),
                 margin = 2 * tolerance + 0.01 * (options.high - options.low).norm();
    for (int k = 0; k < 2; ++k) {
      options.low[k] = step * std::floor((options.low[k] - margin) / step);
      options.high[k] = step * std::ceil((options.high[k] + margin) / step);
    }
    context.say("free form: " + std::to_string(data.points.size()) + " points over " +
                print_number(snapped(options.high.x() - options.low.x(), tolerance)) + " x " +
                print_number(snapped(options.high.y() - options.low.y(), tolerance)) + " mm");
    auto fit = fit_spline(data, options, context);
    if (!fit) {
      context.say("free form: it would take too many control points");
      return std::nullopt;
    }
    std::vector<std::vector<Vec2>> outlines;
    std::size_t next = first_of_border;
    for (const auto& loop : border) {
      const auto from = fit->places.begin() + static_cast<std::ptrdiff_t>(next);
      outlines.emplace_back(from, from + static_cast<std::ptrdiff_t>(loop.size()));
      next += loop.size();
    }
    const std::vector<Vec2> points(fit->places.begin(),
                                   fit->places.begin() + static_cast<std::ptrdiff_t>(first_of_border));
    auto loops = trims_around(std::move(outlines), points, input, edge);
    if (loops.empty()) {
      context.say("free form: its border cannot be drawn");
      return std::nullopt;
    }
    TrimmedSurface trimmed{std::move(fit->surface), std::move(loops)};
    round_numbers(trimmed, tolerance);
    context.say("free form: " + std::to_string(trimmed.surface.u.count()) + " x " +
                std::to_string(trimmed.surface.v.count()) + " control points, deviation " +
                print_number(snapped(fit->worst, tolerance / 1000)) + " mm");
    set.patches.push_back(trimmed_patch(trimmed, "surface " + std::to_string(set.patches.size() + 1)));
  }
  if (set.patches.empty()) return std::nullopt;
  if (set.patches.size() == 1) set.patches[0].name = "surface";
  Candidate candidate;
  candidate.procedure = "free form";
  candidate.object_name = "sheet";
  candidate.parameters.push_back(sheet_thickness(tolerance));
  set.thickness = Expr::of(candidate.parameters.back().name);
  for (const auto& patch : set.patches) candidate.extra_numbers += static_cast<int>(3 * patch.control.size());
  candidate.shape = std::move(set);
  return candidate;
}

}  // namespace partscribe::fit
