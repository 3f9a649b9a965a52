#include "verify/compare/sight.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/statistics.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::verify {
namespace {

constexpr double widest_view = 0.34;         // cosine of 70 degrees
constexpr double flattest_sight = 0.26;      // cosine of 75 degrees
constexpr double facing = 0.5;               // cosine of 60 degrees: so steep a surface returns for certain
constexpr std::size_t most_cells = 4000000;  // per view

struct ViewPoints {
  std::vector<std::uint32_t> index;
  std::vector<Vec3> rays;
};

/// The point nearest to all the lines point + t ray, if they nearly meet there.
std::optional<Vec3> common_origin(const PointCloud& cloud, const ViewPoints& view) {
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < view.index.size(); ++i) {
    const Mat3 across = Mat3::Identity() - view.rays[i] * view.rays[i].transpose();
    sum += across;
    right += across * cloud.points[view.index[i]];
  }
  if (std::abs(sum.determinant()) < 1e-12 * std::pow(double(view.index.size()), 3)) return std::nullopt;
  return Vec3(sum.inverse() * right);
}

/// Distance between neighbouring rays in the image plane: the median over a sample of nearest neighbours.
double pitch_of(const std::vector<Vec3>& plane_points) {
  const KdTree tree(plane_points);
  std::vector<double> gaps;
  std::vector<Neighbour> near;
  const std::size_t step = std::max<std::size_t>(1, plane_points.size() / 1000);
  for (std::size_t i = 0; i < plane_points.size(); i += step) {
    tree.nearest(plane_points[i], 2, near);
    if (near.size() == 2 && near[1].sq_distance > 0) gaps.push_back(std::sqrt(near[1].sq_distance));
  }
  return median_in_place(gaps);
}

std::optional<SightMap> map_of(const PointCloud& cloud, const View* stated, const ViewPoints& view) {
  if (view.index.size() < 100) return std::nullopt;
  Vec3 axis = Vec3::Zero();
  for (const auto& r : view.rays) axis += r;
  if (!(axis.norm() > 1e-6 * double(view.rays.size()))) return std::nullopt;
  axis.normalize();
  SightMap map;
  double least = 1;
  for (const auto& r : view.rays) least = std::min(least, r.dot(axis));
  if (least < widest_view) return std::nullopt;
  map.parallel = least > 1 - 5e-7;  // all within 1e-3 rad
  Vec3 origin = cloud.points[view.index.front()];
  if (!map.parallel) {
    const auto meeting = stated && stated->has_sensor ? std::optional<Vec3>(stated->world_from_view.translation)
                                                      : common_origin(cloud, view);
    if (!meeting) return std::nullopt;
    origin = *meeting;
    std::size_t astray = 0;
    for (std::size_t i = 0; i < view.index.size(); ++i) {
      const Vec3 d = cloud.points[view.index[i]] - origin;
      astray += !(d.cross(view.rays[i]).norm() < 0.01 * d.norm()) || !(d.dot(axis) > 0);
    }
    if (astray * 100 > view.index.size()) return std::nullopt;  // a moving sensor: no single picture
  }
  const Mat3 world_from_map = rotation_onto_axis(axis);
  map.view_from_world = Pose{world_from_map, origin}.inverse();

  std::vector<Vec3> plane;
  std::vector<double> depths;
  plane.reserve(view.index.size()), depths.reserve(view.index.size());
  Box3 box;
  for (const auto i : view.index) {
    const Vec3 p = map.view_from_world * cloud.points[i];
    if (!map.parallel && !(p.z() > 0)) continue;
    const double scale = map.parallel ? 1 : 1 / p.z();
    plane.emplace_back(p.x() * scale, p.y() * scale, 0);
    depths.push_back(p.z());
    box.add(plane.back());
  }
  if (plane.size() < 100) return std::nullopt;
  map.pitch = pitch_of(plane);
  if (!(map.pitch > 0)) return std::nullopt;
  map.cell = 1.5 * map.pitch;  // so that a surface leaves hardly a cell empty
  const Vec3 size = box.size();
  while ((size.x() / map.cell + 3) * (size.y() / map.cell + 3) > double(most_cells)) map.cell *= 1.3;
  map.x0 = box.low.x() - map.cell, map.y0 = box.low.y() - map.cell;
  map.width = static_cast<int>(size.x() / map.cell) + 3, map.height = static_cast<int>(size.y() / map.cell) + 3;
  map.depth.assign(std::size_t(map.width) * std::size_t(map.height), std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const auto column = static_cast<std::size_t>((plane[i].x() - map.x0) / map.cell);
    const auto row = static_cast<std::size_t>((plane[i].y() - map.y0) / map.cell);
    auto& cell = map.depth[row * std::size_t(map.width) + column];
    cell = std::min(cell, static_cast<float>(depths[i]));
  }
  return map;
}

}  // namespace

std::vector<SightMap> sight_maps(const PointCloud& cloud, const std::vector<View>& views,
                                 const std::vector<std::uint32_t>& kept) {
  std::vector<SightMap> maps;
  std::int32_t count = 1;
  for (const auto v : cloud.view) count = std::max(count, v + 1);
  std::vector<ViewPoints> split(static_cast<std::size_t>(count));
  for (const auto i : kept) {
    const std::int32_t v = cloud.view.empty() ? 0 : cloud.view[i];
    if (v < 0) continue;
    Vec3 ray = Vec3::Zero();
    if (!cloud.rays.empty()) ray = cloud.rays[i];
    const auto place = static_cast<std::size_t>(v);
    if (ray.squaredNorm() < 0.5 && place < views.size() && views[place].has_sensor)
      ray = (cloud.points[i] - views[place].world_from_view.translation).normalized();
    if (!(ray.squaredNorm() > 0.5)) continue;
    split[place].index.push_back(i);
    split[place].rays.push_back(ray);
  }
  for (std::size_t v = 0; v < split.size(); ++v)
    if (auto map = map_of(cloud, v < views.size() ? &views[v] : nullptr, split[v])) {
      map->view = static_cast<std::int32_t>(v);
      maps.push_back(std::move(*map));
    }
  return maps;
}

std::optional<Sight> sight_of(const SightMap& map, const Vec3& place) {
  const Vec3 p = map.view_from_world * place;
  if (!map.parallel && !(p.z() > 0)) return {};
  const double scale = map.parallel ? 1 : 1 / p.z();
  const double x = (p.x() * scale - map.x0) / map.cell, y = (p.y() * scale - map.y0) / map.cell;
  if (!(x >= 1 && y >= 1 && x < map.width - 1 && y < map.height - 1)) return {};
  const Mat3 world_from_view = map.view_from_world.rotation.transpose();
  Sight sight;
  sight.to_sensor = map.parallel ? Vec3(-world_from_view.col(2)) : Vec3(-(world_from_view * p.normalized()));
  sight.length = map.parallel ? std::numeric_limits<double>::infinity() : p.norm();
  sight.depth = p.z();
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  std::size_t k = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      sight.around[k++] = map.depth[std::size_t(row + dy) * std::size_t(map.width) + std::size_t(column + dx)];
  return sight;
}

std::optional<Vec3> unanswered_from(const SightMap& map, const Vec3& place, const Vec3& normal) {
  const auto sight = sight_of(map, place);
  if (!sight || sight->to_sensor.dot(normal) < facing) return {};
  const bool empty = std::ranges::all_of(sight->around, [](float depth) { return std::isinf(depth); });
  return empty ? std::optional(sight->to_sensor) : std::nullopt;
}

bool seen_through(const SightMap& map, const Vec3& place, const Vec3& normal, double margin) {
  const auto sight = sight_of(map, place);
  if (!sight || std::abs(sight->to_sensor.dot(normal)) < flattest_sight) return false;
  const bool all_behind =
      std::ranges::all_of(sight->around, [&](float depth) { return depth > sight->depth + margin; });
  const auto returns = std::ranges::count_if(sight->around, [](float depth) { return !std::isinf(depth); });
  return all_behind && returns >= 7;
}

}  // namespace partscribe::verify
