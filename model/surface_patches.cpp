#include "model/surface_patches.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::model {
namespace {

bool finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

template <std::size_t N>
bool finite(const std::vector<std::array<double, N>>& points) {
  return std::all_of(points.begin(), points.end(), [](const auto& p) {
    return std::all_of(p.begin(), p.end(), [](double v) { return std::isfinite(v); });
  });
}

/// What is wrong with the knots of `what`; nothing if they are right.
std::optional<std::string> complaint_about(int degree, const std::vector<double>& knots, const std::string& what) {
  if (degree < 1 || degree > most_spline_degree)
    return ": expected a degree from 1 to " + std::to_string(most_spline_degree) + " " + what + ", found " +
           std::to_string(degree);
  const auto order = static_cast<std::size_t>(degree) + 1;
  if (knots.size() < 2 * order || !finite(knots) || !std::is_sorted(knots.begin(), knots.end()))
    return ": expected at least " + std::to_string(2 * order) + " ascending knots " + what;
  if (!(knots.front() < knots.back()) || knots.front() != knots[order - 1] ||
      knots.back() != knots[knots.size() - order])
    return ": the first and the last knot " + what + " must stand there " + std::to_string(order) + " times";
  for (std::size_t i = 1; i + order < knots.size(); ++i)
    if (knots[i + order - 1] == knots[i] && knots[i] != knots.back() && knots[i] != knots.front())
      return ": an inner knot " + what + " stands there more than " + std::to_string(degree) + " times";
  return std::nullopt;
}

/// Twice the area that a loop encloses to its left, by places along its curves.
double turning(const std::vector<SurfaceTrim>& loop) {
  std::vector<Vec2> places;
  for (const auto& trim : loop) {
    const auto breaks = trim.curve.t.breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      for (int k = 0; k < 8; ++k) places.push_back(trim.curve.at(breaks[i] + (breaks[i + 1] - breaks[i]) * k / 8));
  }
  double sum = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec2 &a = places[i], &b = places[(i + 1) % places.size()];
    sum += a.x() * b.y() - b.x() * a.y();
  }
  return sum;
}

std::optional<std::string> complaint_about_loops(const TrimmedPatch& patch) {
  if (patch.trims.empty()) return ": expected an outline, found no trims";
  const double u0 = patch.knots_u.front(), u1 = patch.knots_u.back(), v0 = patch.knots_v.front(),
               v1 = patch.knots_v.back();
  const double slack = 1e-9 * std::max(u1 - u0, v1 - v0);
  int loop = 0;
  for (const auto& trim : patch.trims) {
    if (auto wrong = complaint_about(trim.degree, trim.knots, "of a trim")) return wrong;
    if (trim.knots.size() != trim.control.size() + static_cast<std::size_t>(trim.degree) + 1 || !finite(trim.control))
      return ": a trim of degree " + std::to_string(trim.degree) + " with " + std::to_string(trim.knots.size()) +
             " knots cannot have " + std::to_string(trim.control.size()) + " control points";
    if (trim.loop != loop && trim.loop != loop + 1) return ": its loops must be numbered in order, from 0";
    loop = trim.loop;
    for (const auto& [u, v] : trim.control)
      if (u < u0 - slack || u > u1 + slack || v < v0 - slack || v > v1 + slack)
        return ": a trim reaches (" + print_number(u) + ", " + print_number(v) + "), outside of the surface";
  }
  if (patch.trims.front().loop != 0) return ": its loops must be numbered in order, from 0";
  const TrimmedSurface trimmed = trimmed_surface(patch);
  for (std::size_t l = 0; l < trimmed.loops.size(); ++l) {
    const auto& curves = trimmed.loops[l];
    for (std::size_t i = 0; i < curves.size(); ++i) {
      const Vec2 end = curves[i].curve.points.back(), next = curves[(i + 1) % curves.size()].curve.points.front();
      if ((end - next).cwiseAbs().maxCoeff() > slack)
        return ": its loop " + std::to_string(l) + " is open between (" + print_number(end.x()) + ", " +
               print_number(end.y()) + ") and (" + print_number(next.x()) + ", " + print_number(next.y()) + ")";
    }
    if ((turning(curves) > 0) != (l == 0))
      return l == 0 ? ": its outline must run counter-clockwise" : ": the holes in it must run clockwise";
  }
  return std::nullopt;
}

}  // namespace

TrimmedSurface trimmed_surface(const TrimmedPatch& patch) {
  TrimmedSurface result{{{patch.degree_u, patch.knots_u}, {patch.degree_v, patch.knots_v}, {}, patch.weights}, {}};
  for (const auto& p : patch.control) result.surface.points.emplace_back(p[0], p[1], p[2]);
  for (const auto& trim : patch.trims) {
    if (static_cast<std::size_t>(trim.loop) >= result.loops.size()) result.loops.emplace_back();
    SurfaceTrim curve{{{trim.degree, trim.knots}, {}, {}}, trim.edge};
    for (const auto& p : trim.control) curve.curve.points.emplace_back(p[0], p[1]);
    result.loops.back().push_back(std::move(curve));
  }
  return result;
}

std::vector<TrimmedSurface> trimmed_surfaces(const std::vector<TrimmedPatch>& patches) {
  std::vector<TrimmedSurface> result;
  for (const auto& patch : patches) result.push_back(trimmed_surface(patch));
  return result;
}

TrimmedPatch trimmed_patch(const TrimmedSurface& trimmed, std::string name) {
  const NurbsSurface& s = trimmed.surface;
  TrimmedPatch result{std::move(name), s.u.degree, s.v.degree, s.u.knots, s.v.knots, {}, s.weights, {}};
  for (const Vec3& p : s.points) result.control.push_back({p.x(), p.y(), p.z()});
  for (std::size_t l = 0; l < trimmed.loops.size(); ++l)
    for (const auto& trim : trimmed.loops[l]) {
      PatchTrim& made = result.trims.emplace_back(
          PatchTrim{static_cast<int>(l), trim.edge, trim.curve.t.degree, trim.curve.t.knots, {}});
      for (const Vec2& p : trim.curve.points) made.control.push_back({p.x(), p.y()});
    }
  return result;
}

namespace {

std::optional<std::string> complaint_about_surface(const TrimmedPatch& patch) {
  if (auto wrong = complaint_about(patch.degree_u, patch.knots_u, "along u")) return wrong;
  if (auto wrong = complaint_about(patch.degree_v, patch.knots_v, "along v")) return wrong;
  const std::size_t rows = patch.knots_u.size() - static_cast<std::size_t>(patch.degree_u) - 1;
  const std::size_t columns = patch.knots_v.size() - static_cast<std::size_t>(patch.degree_v) - 1;
  if (patch.control.size() != rows * columns || !finite(patch.control))
    return ": its knots ask for " + std::to_string(rows) + " x " + std::to_string(columns) +
           " control points, there are " + std::to_string(patch.control.size());
  if (!patch.weights.empty() && patch.weights.size() != patch.control.size())
    return ": expected a weight for each of " + std::to_string(patch.control.size()) + " control points, found " +
           std::to_string(patch.weights.size());
  if (!finite(patch.weights) ||
      std::any_of(patch.weights.begin(), patch.weights.end(), [](double w) { return w <= 0; }))
    return ": its weights must be above 0";
  return std::nullopt;
}

/// A straight trim that is an edge of its own number.
SurfaceTrim side_of_rectangle(int edge, const Vec2& from, const Vec2& to) {
  return {{{1, {0, 0, 1, 1}}, {from, to}, {}}, edge};
}

/// All of a surface; `edges` run along v = low, u = high, v = high, u = low.
TrimmedSurface whole(NurbsSurface surface, const std::array<int, 4>& edges) {
  const Vec2 low(surface.u.low(), surface.v.low()), high(surface.u.high(), surface.v.high());
  const Vec2 right(high.x(), low.y()), left(low.x(), high.y());
  return {std::move(surface),
          {{side_of_rectangle(edges[0], low, right), side_of_rectangle(edges[1], right, high),
            side_of_rectangle(edges[2], high, left), side_of_rectangle(edges[3], left, low)}}};
}

}  // namespace

std::optional<std::string> complaint_about(const TrimmedPatch& patch) {
  if (auto wrong = complaint_about_surface(patch)) return wrong;
  return complaint_about_loops(patch);
}

TrimmedPatch with_border(const TrimmedPatch& patch) {
  return trimmed_patch(whole(trimmed_surface(patch).surface, {1, 2, 3, 4}), patch.name);
}

std::optional<std::string> complaint_about_whole(const TrimmedPatch& patch) {
  if (!patch.trims.empty()) return ": expected no trims, found " + std::to_string(patch.trims.size());
  return complaint_about_surface(patch);
}

std::vector<TrimmedPatch> swept(const TrimmedPatch& patch, const Vec3& direction) {
  const NurbsSurface below = trimmed_surface(patch).surface;
  NurbsSurface above = below;
  for (Vec3& p : above.points) p += direction;
  const int rows = below.u.count(), columns = below.v.count();
  /// The ruled surface over a row or column of control points, in ascending order or against it.
  const auto side = [&](bool along_u, bool last, bool against, const std::array<int, 4>& edges) {
    const KnotVector& t = along_u ? below.u : below.v;
    NurbsSurface ruled{t, {1, {0, 0, 1, 1}}, {}, {}};
    if (against)
      for (std::size_t i = 0; i < t.knots.size(); ++i)
        ruled.u.knots[i] = t.low() + t.high() - t.knots[t.knots.size() - 1 - i];
    const int count = along_u ? rows : columns;
    for (int k = 0; k < count; ++k) {
      const int at = against ? count - 1 - k : k;
      const int row = along_u ? at : last ? rows - 1 : 0, column = !along_u ? at : last ? columns - 1 : 0;
      const auto i = static_cast<std::size_t>(row * columns + column);
      ruled.points.push_back(below.points[i]), ruled.points.push_back(above.points[i]);
      if (!below.weights.empty()) ruled.weights.insert(ruled.weights.end(), 2, below.weights[i]);
    }
    return whole(std::move(ruled), edges);
  };
  std::vector<TrimmedSurface> made = {turned_over(whole(below, {1, 2, 3, 4})), whole(above, {5, 6, 7, 8}),
                                      side(true, false, false, {1, 10, 5, 9}), side(false, true, false, {2, 11, 6, 10}),
                                      side(true, true, true, {3, 12, 7, 11}),  side(false, false, true, {4, 9, 8, 12})};
  static constexpr const char* names[] = {"surface", "end", "side 1", "side 2", "side 3", "side 4"};
  std::vector<TrimmedPatch> result;
  const bool by_the_back = leaving_cosine(patch, direction) < 0;
  for (std::size_t i = 0; i < made.size(); ++i)
    result.push_back(trimmed_patch(by_the_back ? turned_over(made[i]) : made[i], names[i]));
  return result;
}

double leaving_cosine(const TrimmedPatch& patch, const Vec3& direction) {
  const NurbsSurface surface = trimmed_surface(patch).surface;
  constexpr int samples = 4;  // of each span and direction
  double least = 1, most = -1;
  const auto places = [](const KnotVector& t) {
    std::vector<double> result;
    const auto breaks = t.breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      for (int k = 0; k < samples; ++k) result.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * (k + 0.5) / samples);
    result.push_back(t.low()), result.push_back(t.high());
    return result;
  };
  for (const double u : places(surface.u))
    for (const double v : places(surface.v)) {
      const Vec3 n = surface.derivatives(u, v).normal();
      const double cosine = n.norm() > 0 && direction.norm() > 0 ? n.dot(direction) / direction.norm() : 0;
      least = std::min(least, cosine), most = std::max(most, cosine);
    }
  return least > 0 ? least : most < 0 ? most : 0;
}

TrimmedPatch mirrored(const TrimmedPatch& patch, int axis) {
  TrimmedSurface surface = trimmed_surface(patch);
  for (Vec3& p : surface.surface.points) p[axis] *= -1;
  return trimmed_patch(turned_over(surface), patch.name);
}

}  // namespace partscribe::model
