#include "scan/filter/background.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/ensure.h"
#include "core/sample_consensus.h"
#include "core/statistics.h"

namespace partscribe::scan {
namespace {

constexpr double same_way = 0.9;            // cosine of normals on the plane
constexpr std::size_t fewest_points = 100;  // of a plane, and of a thing
constexpr double reach = 4;                 // spacings between connected points; far places are scanned more sparsely

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
  double above(const Vec3& p) const { return normal.dot(p) - offset; }
};

std::vector<std::uint32_t> on_plane(const PointCloud& cloud, const Plane& plane, double within) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (std::abs(plane.above(cloud.points[i])) < within && std::abs(cloud.normals[i].dot(plane.normal)) > same_way)
      result.push_back(i);
  return result;
}

/// Through the given points, by least squares.
Plane through(const PointCloud& cloud, const std::vector<std::uint32_t>& some) {
  Vec3 mean = Vec3::Zero();
  for (const auto i : some) mean += cloud.points[i] / static_cast<double>(some.size());
  Mat3 scatter = Mat3::Zero();
  for (const auto i : some) scatter += (cloud.points[i] - mean) * (cloud.points[i] - mean).transpose();
  const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
  return {normal, normal.dot(mean)};
}

/// The plane with most points, by random samples of three.
Plane most_common_plane(const PointCloud& cloud, double within) {
  constexpr std::size_t most_points = 4000;
  constexpr int tries = 1000;
  std::vector<std::uint32_t> some;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points);
  for (std::size_t i = 0; i < cloud.size(); i += step) some.push_back(static_cast<std::uint32_t>(i));
  Random random(1);
  const auto through_three = [&](auto offer) {
    const Vec3 &a = cloud.points[drawn_from(some, random)], &b = cloud.points[drawn_from(some, random)],
               &c = cloud.points[drawn_from(some, random)];
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.norm() > 0) offer({normal.normalized(), normal.normalized().dot(a)});
  };
  const auto points_on = [&](const Plane& plane, double) {
    return double(std::ranges::count_if(some, [&](std::uint32_t i) {
      return std::abs(plane.above(cloud.points[i])) < within && std::abs(cloud.normals[i].dot(plane.normal)) > same_way;
    }));
  };
  const auto best = consensus<Plane>(tries, 0, through_three, points_on);
  return best ? best->hypothesis : Plane{};
}

/// Connected pieces: points are joined by a chain of cubes of edge `cell` that touch. The largest first.
std::vector<std::vector<std::uint32_t>> pieces(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& some,
                                               double cell) {
  using Cell = std::array<std::int64_t, 3>;
  std::map<Cell, std::vector<std::uint32_t>> cells;
  for (const auto i : some) {
    const Vec3 at = points[i] / cell;
    cells[{std::int64_t(std::floor(at.x())), std::int64_t(std::floor(at.y())), std::int64_t(std::floor(at.z()))}]
        .push_back(i);
  }
  std::vector<std::vector<std::uint32_t>> result;
  while (!cells.empty()) {
    std::vector<std::uint32_t> piece;
    std::vector<decltype(cells)::node_type> waiting;
    waiting.push_back(cells.extract(cells.begin()));
    while (!waiting.empty()) {
      const auto node = std::move(waiting.back());
      waiting.pop_back();
      piece.insert(piece.end(), node.mapped().begin(), node.mapped().end());
      for (int k = 0; k < 27; ++k)
        if (auto next = cells.extract(
                Cell{node.key()[0] + k % 3 - 1, node.key()[1] + k / 3 % 3 - 1, node.key()[2] + k / 9 - 1}))
          waiting.push_back(std::move(next));
    }
    result.push_back(std::move(piece));
  }
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return result;
}

/// Counter-clockwise (Andrew's monotone chain).
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  const auto turns_left = [](const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 0;
  };
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= first + 2 && !turns_left(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

bool inside(const std::vector<Vec2>& hull, const Vec2& p) {
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vec2 along = hull[(k + 1) % hull.size()] - hull[k], d = p - hull[k];
    if (along.x() * d.y() - along.y() * d.x() < 0) return false;
  }
  return true;
}

}  // namespace

Result<Foreground> cut_background(const PointCloud& cloud, double sigma, double spacing, int which) {
  ensure(cloud.normals.size() == cloud.size() && which >= 1, "normals tell the plane from what stands on it");
  const Error no_plane = bad_input("expected a plane with at least " + std::to_string(fewest_points) +
                                   " points under the part, found none");
  if (cloud.size() < 3) return no_plane;
  const double rough = std::max(4 * sigma, 2 * spacing);
  Plane plane = most_common_plane(cloud, rough);
  std::vector<std::uint32_t> flat = on_plane(cloud, plane, rough);
  for (int round = 0; round < 3 && flat.size() >= fewest_points; ++round) {
    plane = through(cloud, flat);
    flat = on_plane(cloud, plane, rough);
  }
  if (flat.size() < fewest_points) return no_plane;
  flat = std::move(pieces(cloud.points, flat, reach * spacing).front());

  Foreground result;
  result.support = flat.size();
  std::vector<double> off;
  for (const auto i : flat) off.push_back(std::abs(plane.above(cloud.points[i])));
  result.lost = std::max(4 * 1.4826 * median(std::move(off)), 2 * spacing);
  const Vec3 x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  const auto place = [&](const Vec3& p) { return Vec2(x.dot(p), y.dot(p)); };
  std::vector<Vec2> footprint;
  for (const auto i : flat) footprint.push_back(place(cloud.points[i]));
  const std::vector<Vec2> hull = convex_hull(std::move(footprint));
  std::vector<std::uint32_t> above, below;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (const double height = plane.above(cloud.points[i]);
        std::abs(height) > result.lost && inside(hull, place(cloud.points[i])))
      (height > 0 ? above : below).push_back(i);
  // Nothing is seen through the plane.
  if (below.size() > above.size()) above.swap(below), plane = {-plane.normal, -plane.offset};
  result.normal = plane.normal, result.offset = plane.offset;
  result.above = above.size(), result.behind = below.size();
  std::map<std::pair<std::int64_t, std::int64_t>, std::pair<std::size_t, std::size_t>>
      columns;  // points on the plane; over it
  const auto column = [&](const Vec3& p) -> auto& {
    const Vec2 at = place(p) / (reach * spacing);
    return columns[{std::int64_t(std::floor(at.x())), std::int64_t(std::floor(at.y()))}];
  };
  for (const auto i : flat) ++column(cloud.points[i]).first;
  for (const auto i : above) ++column(cloud.points[i]).second;
  for (const auto& [at, points] : columns) result.covered += points.second >= points.first ? points.first : 0;
  result.keep.assign(cloud.size(), 0);
  for (const auto& piece : pieces(cloud.points, above, reach * spacing)) {
    const bool stands = std::any_of(piece.begin(), piece.end(), [&](std::uint32_t i) {
      return plane.above(cloud.points[i]) < result.lost + 2 * reach * spacing;
    });
    if (piece.size() < fewest_points || !stands) continue;
    result.things.push_back(piece.size());
    if (result.things.size() != static_cast<std::size_t>(which)) continue;
    for (const auto i : piece) result.keep[i] = 1;
  }
  if (result.things.size() < static_cast<std::size_t>(which))
    return bad_input("expected at least " + std::to_string(which) + (which == 1 ? " thing" : " things") +
                     " standing on the largest plane, found " + std::to_string(result.things.size()));
  return result;
}

}  // namespace partscribe::scan
