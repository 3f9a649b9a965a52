#include "fit/sketch/round_holes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/sample_consensus.h"

namespace partscribe::fit {
namespace {

/// Sectors of 10 degrees that hold points.
int sectors_of(const PlaneCircle& c, const std::vector<Vec2>& on) {
  std::array<bool, 36> hit = {};
  for (const Vec2& p : on) {
    const double angle = std::atan2(p.y() - c.center.y(), p.x() - c.center.x()) + pi;
    hit[std::min<std::size_t>(35, static_cast<std::size_t>(angle / (2 * pi) * 36))] = true;
  }
  return static_cast<int>(std::count(hit.begin(), hit.end(), true));
}

/// True if the end faces lie around the circle, not only to one side, and not in it.
bool is_hole(const PlaneCircle& c, const std::vector<Vec2>& ends) {
  constexpr double inner = 0.85, from = 1.1, to = 1.5;
  constexpr int least_sectors = 16;
  std::size_t inside = 0;
  std::vector<Vec2> around;
  for (const Vec2& p : ends) {
    const double r = (p - c.center).norm() / c.radius;
    inside += r < inner;
    if (r > from && r < to) around.push_back(p);
  }
  const double area_ratio = inner * inner / (to * to - from * from);
  return sectors_of(c, around) >= least_sectors && double(inside) < 0.2 * area_ratio * double(around.size());
}

/// Wall points within `band` of a circle, with normals across it.
std::vector<Vec2> points_of(const PlaneCircle& c, const std::vector<PlanePoint>& walls, double band) {
  std::vector<Vec2> on;
  for (const auto& w : walls) {
    const Vec2 d = w.position - c.center;
    const double r = d.norm();
    if (std::abs(r - c.radius) < band && std::abs(d.dot(w.normal)) > 0.9 * r) on.push_back(w.position);
  }
  return on;
}

std::vector<Vec2> points_of(const PlaneCircle& c, const std::vector<Vec2>& points, double band) {
  std::vector<Vec2> on;
  for (const Vec2& p : points)
    if (std::abs((p - c.center).norm() - c.radius) < band) on.push_back(p);
  return on;
}

std::size_t inside_of(const PlaneCircle& c, const std::vector<Vec2>& points, double band) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(), [&](const Vec2& p) { return (p - c.center).norm() < c.radius - band; }));
}

/// Points of the end faces per area, on the average of the box around them.
double density_of(const std::vector<Vec2>& ends) {
  Vec2 low = ends[0], high = low;
  for (const Vec2& p : ends) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return double(ends.size()) / std::max((high - low).prod(), 1e-12);
}

constexpr double free_area = 0.3;  // evidence for a hole from a free area of one point's share of the end faces

/// Evidence for a hole: wall points on it, and the part of the end faces that it leaves out, if `density` is above 0; a
/// few outliers count little.
double worth_of(const PlaneCircle& c, const std::vector<Vec2>& between, const std::vector<Vec2>& ends, double density,
                double band) {
  constexpr double outlier = 4.5, inside = 2;
  double sum = 0;
  for (const Vec2& p : between) {
    const double u = 2.5 * ((p - c.center).norm() - c.radius) / band;
    sum += outlier - std::min(0.5 * u * u, outlier);
  }
  return sum + free_area * density * pi * c.radius * c.radius - inside * double(inside_of(c, ends, 0.5 * band));
}

/// Moves to the nearest maximum of the evidence.
void climb(PlaneCircle& c, const std::vector<Vec2>& between, const std::vector<Vec2>& ends, double density,
           double band) {
  constexpr int halvings = 5, most_rounds = 40;
  double step = 2 * band, worth = worth_of(c, between, ends, density, band);
  for (int round = 0, halved = 0; round < most_rounds && halved < halvings; ++round) {
    bool better = false;
    for (double* number : {&c.center.x(), &c.center.y(), &c.radius})
      for (const double way : {step, -step}) {
        const double before = *number;
        *number += way;
        const double now = c.radius > band ? worth_of(c, between, ends, density, band) : -1e300;
        if (now > worth) {
          worth = now, better = true;
          break;
        }
        *number = before;
      }
    if (!better) step /= 2, ++halved;
  }
}

}  // namespace

std::vector<PlaneCircle> partly_seen_holes(std::vector<PlanePoint> walls, const std::vector<Vec2>& ends, double band,
                                           double size) {
  constexpr int draws = 600, least_sectors = 7;
  constexpr std::size_t least_points = 12, most_holes = 12;
  Random random(1);
  std::vector<PlaneCircle> holes;
  while (holes.size() < most_holes && walls.size() >= least_points) {
    const auto where_two_meet = [&](auto offer) {
      const PlanePoint &a = drawn_from(walls, random), &b = drawn_from(walls, random);
      const auto meeting = where_normals_meet(a, b, 0.2);
      if (!meeting || std::abs(meeting->from_b - meeting->from_a) > 4 * band) return;
      if (meeting->from_a > 0.5 * size || meeting->from_a < 3 * band) return;
      offer({meeting->place, 0.5 * (meeting->from_a + meeting->from_b)});
    };
    const auto wall_points = [&](const PlaneCircle& c, double most) {
      const std::vector<Vec2> on = points_of(c, walls, band);
      return double(on.size()) > most && sectors_of(c, on) >= least_sectors && is_hole(c, ends) ? double(on.size()) : 0;
    };
    const auto found = consensus<PlaneCircle>(draws, least_points - 1, where_two_meet, wall_points);
    if (!found) break;
    PlaneCircle best = found->hypothesis;
    for (int round = 0; round < 3; ++round) best = polished(best, points_of(best, walls, band));
    const std::vector<Vec2> on = points_of(best, walls, band);
    if (on.size() < least_points || sectors_of(best, on) < least_sectors || !is_hole(best, ends)) break;
    holes.push_back(best);
    std::erase_if(walls,
                  [&](const PlanePoint& w) { return (w.position - best.center).norm() < best.radius + 3 * band; });
  }
  return holes;
}

std::vector<PlaneCircle> hardly_seen_holes(std::vector<Vec2> between, const std::vector<Vec2>& ends, double band,
                                           double size, bool by_walls) {
  constexpr int draws = 400, least_sectors = 5;
  constexpr std::size_t least_points = 10, most_holes = 6;
  if (ends.empty()) return {};
  const double density = by_walls ? 0 : density_of(ends);
  const auto has_wall = [&](const PlaneCircle& c) {
    const std::vector<Vec2> on = points_of(c, between, band);
    return on.size() >= least_points && sectors_of(c, on) >= least_sectors;
  };
  Random random(1);
  std::vector<PlaneCircle> holes;
  while (holes.size() < most_holes && between.size() >= least_points) {
    // A circle through two neighbours, of a size drawn at random.
    const auto through_two = [&](auto offer) {
      const Vec2 &a = drawn_from(between, random), &b = drawn_from(between, random);
      const Vec2 half = 0.5 * (b - a);
      const double radius = 2 * band + random.uniform() * (0.3 * size - 2 * band);
      if (!(half.norm() > 0.5 * band) || half.norm() > radius) return;
      const Vec2 across = Vec2(-half.y(), half.x()).normalized() * std::sqrt(radius * radius - half.squaredNorm());
      for (const double side : {1.0, -1.0}) offer({a + half + side * across, radius});
    };
    const auto worth_as_hole = [&](const PlaneCircle& c, double most) {
      const double worth = has_wall(c) ? worth_of(c, between, ends, density, band) : 0;
      return worth > most && is_hole(c, ends) ? worth : 0;
    };
    const auto found = consensus<PlaneCircle>(draws, 0, through_two, worth_as_hole);
    if (!found) break;
    const PlaneCircle drawn = found->hypothesis;
    PlaneCircle best = drawn;
    climb(best, between, ends, density, band);
    // Beside a shadow in the end faces the best circle is one that fills it.
    if (!has_wall(best) || !is_hole(best, ends)) best = drawn;
    holes.push_back(best);
    std::erase_if(between, [&](const Vec2& p) { return (p - best.center).norm() < best.radius + 3 * band; });
  }
  return holes;
}

std::vector<PlaneCircle> holes_about(const std::vector<Vec2>& centres, double most, const std::vector<Vec2>& between,
                                     const std::vector<Vec2>& ends, double band) {
  constexpr std::size_t least_points = 10;
  if (ends.empty()) return {};
  const double density = density_of(ends);
  const auto worth = [&](const Vec2& c, double r) { return worth_of({c, r}, between, ends, density, band); };
  double radius = 0, best = 0;
  for (double r = 2 * band; r < most - 2 * band; r += 0.25 * band) {
    double sum = 0;
    std::size_t on = 0;
    for (const Vec2& c : centres) sum += std::max(worth(c, r), 0.0), on += points_of({c, r}, between, band).size();
    if (on >= least_points && sum > best) best = sum, radius = r;
  }
  std::vector<PlaneCircle> result;
  for (const Vec2& c : centres)
    if (radius > 0 && worth(c, radius) > 0) result.push_back({c, radius});
  return result;
}

}  // namespace partscribe::fit
