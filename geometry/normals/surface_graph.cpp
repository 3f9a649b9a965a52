#include "geometry/normals/surface_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::geometry {
namespace {

/// Whether two points next to each other lie on one smooth surface.
bool smooth(const SurfaceGraph& g, std::size_t a, std::size_t b, const SurfaceGraphOptions& options) {
  if (!g.usable[a] || !g.usable[b]) return false;
  const Vec3 d = g.points[b] - g.points[a];
  const double length = d.norm(), noise = g.sigma[a] + g.sigma[b];
  const double climb = std::max(std::abs(d.dot(g.normals[a])), std::abs(d.dot(g.normals[b])));
  if (climb > options.max_climb * length + 2 * noise) return false;
  // Two normals, each from a part of a 5x5 window and uncertain by up to sigma / (sqrt 10 spacing).
  const double turn = options.max_turn + (length > 0 ? 0.35 * noise / length : 0);
  return g.normals[a].cross(g.normals[b]).norm() <= std::sin(std::min(turn, 1.2)) && g.normals[a].dot(g.normals[b]) > 0;
}

void set_spacing(SurfaceGraph& g) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < g.size(); ++i)
    for (const std::uint32_t j : g.around(i)) lengths.push_back((g.points[j] - g.points[i]).norm());
  g.spacing = median_in_place(lengths);
}

}  // namespace

SurfaceGraph surface_graph(const RangeImage& image, const FilteredImage& filtered, const SurfaceGraphOptions& options) {
  ensure(filtered.width == image.width && filtered.height == image.height, "image and filtered image have one size");
  const std::size_t n = image.codes.size();
  SurfaceGraph g;
  g.points.assign(n, Vec3::Zero()), g.normals.assign(n, Vec3::Zero());
  g.sigma.assign(n, 0), g.usable.assign(n, 0);
  const bool pinhole = image.projection == Projection::pinhole;
  const auto place = [&](double row, double column, double z) {
    return pinhole ? Vec3((column - image.cx) / image.fx * z, (row - image.cy) / image.fy * z, z)
                   : Vec3(image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, z);
  };
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const auto i = static_cast<std::size_t>(r) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(c);
      if (!filtered.kept[i]) continue;
      const double z = filtered.depth[i];
      // Tangents of the surface along a row and a column, by differences of half a pixel.
      const double sx = 0.5 * static_cast<double>(filtered.slope_column[i]),
                   sy = 0.5 * static_cast<double>(filtered.slope_row[i]);
      const Vec3 along = place(r, c + 0.5, z + sx) - place(r, c - 0.5, z - sx);
      const Vec3 down = place(r + 0.5, c, z + sy) - place(r - 0.5, c, z - sy);
      Vec3 normal = along.cross(down);
      if (!(normal.norm() > 0)) continue;
      normal.normalize();
      g.points[i] = *view_point(image, r, c);
      const Vec3 ray = pinhole ? Vec3(g.points[i] / z) : Vec3(0, 0, 1);
      if (normal.dot(ray) > 0) normal = -normal;
      g.normals[i] = normal, g.usable[i] = 1;
      // Noise moves a point along its ray.
      g.sigma[i] = static_cast<double>(filtered.raw_sigma[i]) * std::abs(normal.dot(ray));
    }
  g.first.assign(1, 0);
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t r = i / width, c = i % width;
    const auto link = [&](bool inside, std::size_t j) {
      if (inside && smooth(g, i, j, options)) g.links.push_back(static_cast<std::uint32_t>(j));
    };
    if (g.usable[i]) {
      link(r > 0, i - width), link(c > 0, i - 1), link(c + 1 < width, i + 1), link(i + width < n, i + width);
    }
    g.first.push_back(static_cast<std::uint32_t>(g.links.size()));
  }
  set_spacing(g);
  return g;
}

SurfaceGraph surface_graph(const PointCloud& cloud, const SurfaceGraphOptions& options, Context& context) {
  const std::size_t n = cloud.size();
  ensure(cloud.normals.size() == n && cloud.sigma.size() == n, "a cloud has normals and noise before it has a surface");
  SurfaceGraph g;
  g.points = cloud.points, g.normals = cloud.normals;
  g.usable.assign(n, 0);
  std::vector<Vec3> used;
  std::vector<std::uint32_t> source;
  for (std::size_t i = 0; i < n; ++i) {
    g.sigma.push_back(cloud.sigma[i]);
    const bool rejected = !cloud.rejected.empty() && cloud.rejected[i];
    if (rejected || !(cloud.normals[i].squaredNorm() > 0.5)) continue;
    g.usable[i] = 1;
    used.push_back(cloud.points[i]), source.push_back(static_cast<std::uint32_t>(i));
  }
  const KdTree tree(used);
  std::vector<std::vector<std::uint32_t>> near(n);
  tree.nearest_of_each(static_cast<std::size_t>(options.neighbours) + 1, context.threads,
                       [&](std::uint32_t k, std::span<const Neighbour> found) {
                         for (const Neighbour& f : found)
                           if (f.index != k && smooth(g, source[k], source[f.index], options))
                             near[source[k]].push_back(source[f.index]);
                       });
  std::vector<std::vector<std::uint32_t>> both = near;
  for (std::size_t i = 0; i < n; ++i)
    for (const std::uint32_t j : near[i]) both[j].push_back(static_cast<std::uint32_t>(i));
  g.first.assign(1, 0);
  for (std::vector<std::uint32_t>& list : both) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    g.links.insert(g.links.end(), list.begin(), list.end());
    g.first.push_back(static_cast<std::uint32_t>(g.links.size()));
  }
  set_spacing(g);
  return g;
}

}  // namespace partscribe::geometry
