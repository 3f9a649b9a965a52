#include "scan/views/next_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "scan/simulate/simulate.h"

namespace partscribe::scan {
namespace {

enum class Space : std::uint8_t { unknown, empty, surface };

/// Cubes around the part.
class Grid {
 public:
  Grid(const Box3& bounds, int cells)
      : edge_(bounds.size().maxCoeff() / cells), low_(bounds.low - Vec3::Constant(3 * edge_)) {
    for (int k = 0; k < 3; ++k)
      count_[static_cast<std::size_t>(k)] = static_cast<int>(std::ceil(bounds.size()[k] / edge_)) + 6;
    space.assign(size(), Space::unknown);
  }
  std::size_t size() const { return std::size_t(count_[0]) * std::size_t(count_[1]) * std::size_t(count_[2]); }
  double edge() const { return edge_; }
  Vec3 middle(std::size_t i) const {
    const auto nx = std::size_t(count_[0]), ny = std::size_t(count_[1]);
    return low_ + edge_ * Vec3(double(i % nx) + 0.5, double(i / nx % ny) + 0.5, double(i / (nx * ny)) + 0.5);
  }
  std::size_t cell_of(const Vec3& p) const {
    std::array<std::size_t, 3> c;
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      c[at] = static_cast<std::size_t>(std::clamp(static_cast<int>((p[k] - low_[k]) / edge_), 0, count_[at] - 1));
    }
    return c[0] + std::size_t(count_[0]) * (c[1] + std::size_t(count_[1]) * c[2]);
  }
  struct Sides {
    Vec3 empty = Vec3::Zero();  // sum of the directions to empty neighbours
    bool surface = false;       // is one of them surface?
  };
  Sides sides_of(std::size_t i) const {
    Sides sides;
    const Vec3 p = middle(i);
    for (int k = 0; k < 3; ++k)
      for (const int side : {-1, 1}) {
        const std::size_t next = cell_of(p + side * edge_ * Vec3::Unit(k));
        // Beyond the grid: nothing is there that the part's points would not show.
        if (next == i || space[next] == Space::empty) sides.empty[k] += side;
        if (next == i) continue;
        sides.surface = sides.surface || space[next] == Space::surface;
      }
    return sides;
  }
  std::vector<Space> space;

 private:
  double edge_;
  Vec3 low_;
  std::array<int, 3> count_;
};

/// A picture of places as one view sees them: pixels as wide as a cell, and depth.
class Eye {
 public:
  /// Rays that meet within the view make it a pinhole at that place.
  Eye(const std::vector<Vec3>& points, const std::vector<Vec3>& rays, bool pinhole, const Vec3& sensor, double edge)
      : pinhole_(pinhole), sensor_(sensor) {
    Vec3 mean = Vec3::Zero(), middle = Vec3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) mean += rays[i], middle += points[i] / double(points.size());
    forward_ = mean.normalized(), across_ = forward_.unitOrthogonal(), up_ = forward_.cross(across_);
    pixel_ = pinhole_ ? edge / std::max((middle - sensor_).norm(), edge) : edge;
    for (const Vec3& p : points) {
      const auto [x, y, depth] = look(p);
      const auto [it, is_new] = nearest_.try_emplace({x, y}, depth);
      if (!is_new) it->second = std::min(it->second, depth);
    }
  }
  /// True if the view looked through the place, or past the part there.
  bool sees_through(const Vec3& p) const {
    const auto [x, y, depth] = look(p);
    if (const auto own = nearest_.find({x, y}); own != nearest_.end()) return depth < own->second;
    bool any = false;
    double least = 1e300;
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        if (const auto it = nearest_.find({x + dx, y + dy}); it != nearest_.end())
          any = true, least = std::min(least, it->second);
    return !any || depth < least;
  }

 private:
  struct Place {
    int x, y;
    double depth;
  };
  Place look(const Vec3& p) const {
    const Vec3 d = p - sensor_;
    const double depth = d.dot(forward_), scale = pinhole_ ? 1 / std::max(depth, 1e-9) : 1;
    return {static_cast<int>(std::floor(scale * d.dot(across_) / pixel_)),
            static_cast<int>(std::floor(scale * d.dot(up_) / pixel_)), depth};
  }
  bool pinhole_;
  Vec3 sensor_, forward_, across_, up_;
  double pixel_;
  std::map<std::pair<int, int>, double> nearest_;
};

void look_through(const Scan& scan, Grid& grid) {
  const PointCloud& cloud = scan.cloud;
  std::map<std::int32_t, std::pair<std::vector<Vec3>, std::vector<Vec3>>> views;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if ((!cloud.rejected.empty() && cloud.rejected[i]) || cloud.rays[i].isZero()) continue;
    auto& [points, rays] = views[cloud.view.empty() ? 0 : cloud.view[i]];
    points.push_back(cloud.points[i]), rays.push_back(cloud.rays[i]);
  }
  for (const auto& [number, view] : views) {
    const bool known = number >= 0 && static_cast<std::size_t>(number) < scan.views.size();
    const bool pinhole = known && scan.views[static_cast<std::size_t>(number)].has_sensor;
    const Vec3 sensor =
        pinhole ? scan.views[static_cast<std::size_t>(number)].world_from_view.translation : view.first.front();
    const Eye eye(view.first, view.second, pinhole, sensor, grid.edge());
    for (std::size_t i = 0; i < grid.size(); ++i)
      if (grid.space[i] == Space::unknown && eye.sees_through(grid.middle(i))) grid.space[i] = Space::empty;
  }
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i]) grid.space[grid.cell_of(cloud.points[i])] = Space::surface;
}

/// What is not empty, as one direction would see it.
struct Solid {
  Vec3 middle, normal;  // normal: towards empty space; zero inside
  std::size_t border;   // index of the unseen border; none for surface and inside
  bool surface;
};

constexpr std::size_t none = ~std::size_t{0};

struct Look {
  std::vector<std::size_t> borders;  // seen ones
  double gain = 0, overlap = 0;      // pixels; share
};

Look look_from(const Vec3& direction, const std::vector<Solid>& solids, const std::vector<char>& done, double edge,
               double least_cosine) {
  const Vec3 u = direction.unitOrthogonal(), v = direction.cross(u);
  std::map<std::pair<int, int>, std::pair<double, std::size_t>> first;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Vec3& p = solids[i].middle;
    const std::pair<int, int> pixel(static_cast<int>(std::floor(p.dot(u) / edge)),
                                    static_cast<int>(std::floor(p.dot(v) / edge)));
    const double height = p.dot(direction);
    const auto [it, is_new] = first.try_emplace(pixel, height, i);
    if (!is_new && height > it->second.first) it->second = {height, i};
  }
  Look look;
  std::size_t known = 0;
  for (const auto& [pixel, hit] : first) {
    const Solid& solid = solids[hit.second];
    const bool was_seen = solid.surface || (solid.border != none && done[solid.border]);
    known += was_seen;
    if (was_seen || solid.border == none || solid.normal.dot(direction) < least_cosine) continue;
    look.borders.push_back(solid.border), look.gain += 1;
  }
  look.overlap = first.empty() ? 0 : double(known) / double(first.size());
  return look;
}

}  // namespace

NextViews next_views(const Scan& scan, const NextViewsOptions& options, Context& context) {
  NextViews result;
  const PointCloud& cloud = scan.cloud;
  if (cloud.empty() || cloud.rays.size() != cloud.size()) return result;
  Grid grid(cloud.bounds(), options.cells);
  look_through(scan, grid);
  const double area = grid.edge() * grid.edge();
  std::vector<Solid> solids;
  std::size_t borders = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (grid.space[i] == Space::empty) continue;
    const Grid::Sides sides = grid.sides_of(i);
    const bool surface = grid.space[i] == Space::surface;
    if (!surface && sides.empty.isZero()) continue;  // inside: something lies before it from everywhere
    // Beside surface an unknown cell is one that no point happened to fall into.
    const bool border = !surface && !sides.surface;
    solids.push_back({grid.middle(i), border ? Vec3(sides.empty.normalized()) : Vec3(Vec3::Zero()),
                      border ? borders : none, !border});
    borders += border;
    if (border)
      result.unseen += area;
    else if (surface)
      result.seen += area;
  }
  const std::vector<Vec3> candidates = *viewpoints("162");
  const double least_cosine = std::cos(options.max_incidence);
  std::vector<char> done(borders, 0), visible(borders, 0);
  for (std::size_t round = 0; round <= options.most && !context.cancelled; ++round) {
    double best = 0;
    Look chosen;
    Vec3 direction = Vec3::Zero();
    for (const Vec3& d : candidates) {
      const Look look = look_from(d, solids, done, grid.edge(), least_cosine);
      if (round == 0)
        for (const auto b : look.borders) visible[b] = 1;
      const double worth = look.gain * std::min(1.0, look.overlap / options.least_overlap);
      if (worth > best) best = worth, chosen = look, direction = d;
    }
    if (round == options.most || chosen.gain * area < options.least_gain * (result.seen + result.unseen)) break;
    result.views.push_back({direction, chosen.gain * area, chosen.overlap});
    for (const auto b : chosen.borders) done[b] = 1;
  }
  for (const char v : visible) result.hidden += v ? 0 : area;
  return result;
}

}  // namespace partscribe::scan
