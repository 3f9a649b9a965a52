#include "fit/surface/spline_sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/number.h"
#include "fit/surface/border_curves.h"
#include "fit/surface/curve_fit.h"
#include "fit/surface/flatten.h"
#include "fit/surface/piece_fit.h"
#include "fit/surface/triangulate.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
#include "model/surface_patches.h"

namespace partscribe::fit {
namespace {

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
    data.points.push_back(input.cloud.points[i]);
    data.places.push_back(place_on(piece, places, hits[i].triangle, hits[i].point));
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

/// A mesh of scattered points ends before the last of them, at a ragged border. The trims are smooth at the distance of
/// the points, and no point lies farther outside than half of the tolerance.
std::vector<std::vector<SurfaceTrim>> trims_around(std::vector<std::vector<Vec2>> outlines,
                                                   const std::vector<Vec2>& places, const FitInput& input) {
  const bool drawn = input.scan && !input.scan->mesh.empty();
  const double spacing = drawn ? 0 : input.thin_spacing;
  const double smooth = std::max(0.5 * input.tolerance, 1.2 * spacing), most = 4 * input.thin_spacing;
  std::stable_sort(outlines.begin(), outlines.end(),
                   [](const auto& a, const auto& b) { return signed_area(a) > signed_area(b); });
  // Holes that no point could be missing from are none.
  outlines.erase(std::remove_if(outlines.begin() + 1, outlines.end(),
                                [&](const auto& loop) { return std::abs(signed_area(loop)) < smooth * smooth; }),
                 outlines.end());
  for (auto& loop : outlines) loop = denser(loop, smooth, true);
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
  int edge = 0;
  for (auto& loop : loops)
    for (auto& trim : loop) trim.edge = ++edge;
  return loops;
}

}  // namespace

std::optional<TrimmedSurface> spline_sheet(const TriangleMesh& mesh, const std::vector<Vec2>& places,
                                           const FitInput& input, Context& context) {
  // Corners of the border are points as well: where they come to lie on the surface, it ends.
  SplineData data = data_on(mesh, places, input, 3 * input.tolerance, context);
  const auto border = border_loops(mesh);
  const std::size_t first_of_border = data.points.size();
  for (const auto& loop : border)
    for (const auto v : loop) data.points.push_back(mesh.vertices[v]), data.places.push_back(places[v]);
  auto fit = fit_piece(data, input, context);
  if (!fit) return std::nullopt;
  std::vector<std::vector<Vec2>> outlines;
  std::size_t next = first_of_border;
  for (const auto& loop : border) {
    const auto from = fit->places.begin() + static_cast<std::ptrdiff_t>(next);
    outlines.emplace_back(from, from + static_cast<std::ptrdiff_t>(loop.size()));
    next += loop.size();
  }
  const std::vector<Vec2> points(fit->places.begin(),
                                 fit->places.begin() + static_cast<std::ptrdiff_t>(first_of_border));
  auto loops = trims_around(std::move(outlines), points, input);
  if (loops.empty()) {
    context.say("free form: its border cannot be drawn");
    return std::nullopt;
  }
  return TrimmedSurface{std::move(fit->surface), std::move(loops)};
}

}  // namespace partscribe::fit
