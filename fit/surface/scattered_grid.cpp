#include "fit/surface/scattered_grid.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "geometry/mesh/plane_delaunay.h"

namespace partscribe::fit {
namespace {

/// Where the plane y = at cuts the edges of the triangles, by x. An edge of two triangles is cut twice, which changes
/// nothing.
std::vector<Vec3> contour(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 3>>& triangles,
                          double at) {
  std::vector<Vec3> cuts;
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      // An edge is run through the same way in both of its triangles, so that they cut it in the same bits.
      const Vec3 &a = points[std::min(t[k], t[(k + 1) % 3])], &b = points[std::max(t[k], t[(k + 1) % 3])];
      if ((a.y() < at) == (b.y() < at)) continue;
      Vec3 cut = a + (at - a.y()) / (b.y() - a.y()) * (b - a);
      cut.y() = at;
      cuts.push_back(cut);
    }
  std::sort(cuts.begin(), cuts.end(),
            [](const Vec3& a, const Vec3& b) { return a.x() != b.x() ? a.x() < b.x() : a.z() < b.z(); });
  return cuts;
}

/// The place at x of a polyline that ascends in x.
Vec3 place_at(const std::vector<Vec3>& line, double x) {
  const auto above =
      std::upper_bound(line.begin() + 1, line.end() - 1, x, [](double value, const Vec3& p) { return value < p.x(); });
  const Vec3 &a = *(above - 1), &b = *above;
  const double width = b.x() - a.x();
  return width > 0 ? Vec3(a + std::clamp((x - a.x()) / width, 0.0, 1.0) * (b - a)) : a;
}

}  // namespace

Result<PlaceGrid> grid_of_scattered(const std::vector<Vec3>& points, const Pose& world_from_plane,
                                    const ScatteredGridOptions& options) {
  ensure(options.columns >= 2 && options.rows >= 2, "a grid has two columns and two rows at least");
  ensure(options.inset > 0 && options.longest_edge > 0, "rows lie inside of the points, and edges are longer than 0");
  const Pose plane_from_world = world_from_plane.inverse();
  std::vector<Vec3> local;
  std::vector<Vec2> feet;
  for (const Vec3& p : points) local.push_back(plane_from_world * p), feet.emplace_back(local.back().head<2>());
  auto triangles = delaunay_triangles(feet);
  if (triangles.empty())
    return bad_input("expected scattered points that span a plane, found " + std::to_string(points.size()) +
                     " that are on one line");
  std::erase_if(triangles, [&](const auto& t) {
    for (std::size_t k = 0; k < 3; ++k)
      if ((feet[t[k]] - feet[t[(k + 1) % 3]]).norm() > options.longest_edge) return true;
    return false;
  });
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& t : triangles)
    for (const std::uint32_t v : t) low = std::min(low, feet[v].y()), high = std::max(high, feet[v].y());
  PlaceGrid grid{options.columns, options.rows, {}};
  const double step = (high - low) / (options.rows - 1 + 2 * options.inset);
  for (int r = 0; r < options.rows; ++r) {
    const auto line = contour(local, triangles, low + (options.inset + r) * step);
    if (line.size() < 2)
      return bad_input("expected triangles at every row of a grid, found none at row " + std::to_string(r + 1) +
                       " of " + std::to_string(options.rows) + " with edges of the length that is allowed");
    const double from = line.front().x(), to = line.back().x();
    for (int c = 0; c < options.columns; ++c)
      grid.places.push_back(world_from_plane * place_at(line, from + (to - from) * c / (options.columns - 1)));
  }
  return grid;
}

}  // namespace partscribe::fit
