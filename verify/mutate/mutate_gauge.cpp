#include "verify/mutate/mutate_gauge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "core/ensure.h"
#include "core/number.h"
#include "core/random.h"
#include "model/check.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t probes = 2000;           // places by which displacements are measured
constexpr std::size_t visible = probes / 200;  // so many of them must lie off the damaged surface
constexpr std::size_t harm_probes = 1000;      // of either surface

Vec3 gradient(const ModelDistance& distance, const Vec3& p, double h) {
  Vec3 g;
  for (int k = 0; k < 3; ++k)
    g[k] = (distance(p + h * Vec3::Unit(k)).distance - distance(p - h * Vec3::Unit(k)).distance) / (2 * h);
  return g;
}

/// From far away the nearest places are the outermost ones of the part: they span its box.
Box3 bounds_of(const ModelDistance& distance, Vec3 center) {
  double reach = 1000;
  Box3 box;
  // The first look is from anywhere, the second from about the part and closer.
  for (int look = 0; look < 2; ++look) {
    Random random(7);
    box = {};
    for (int i = 0; i < 400; ++i) {
      Vec3 direction(random.normal(), random.normal(), random.normal());
      if (i < 6) direction = (i % 2 ? -1.0 : 1.0) * Vec3::Unit(i / 2);
      Vec3 p = center + reach * direction.normalized();
      double d = distance(p).distance;
      for (int step = 0; step < 60 && std::abs(d) > 1e-7 * reach; ++step) {
        const Vec3 g = gradient(distance, p, 1e-6 * reach);
        if (g.squaredNorm() < 0.01) break;
        p -= d * g.normalized();
        d = distance(p).distance;
      }
      if (std::abs(d) < 1e-3 * reach) box.add(p);
    }
    ensure(!box.empty(), "a model has a surface");
    center = box.center();
    reach = 2 * box.diagonal();
  }
  return box;
}

/// So many of the points are farther than this.
double off_by(const std::vector<PlaceOnPart>& points, const ModelDistance& distance, std::size_t count) {
  std::vector<double> off;
  for (const auto& p : points) off.push_back(std::abs(distance(p.point).distance));
  std::nth_element(off.begin(), off.begin() + long(count), off.end(), std::greater<>());
  return off[count];
}

}  // namespace

Box3 bounds_of(const Model& model, const ModelDistance& distance) {
  return bounds_of(distance,
                   model.as_scanned ? evaluate(model.scan_from_part, values_of(model)).translation : Vec3(0, 0, 0));
}

bool passes_check(const Model& model) { return std::holds_alternative<CheckedModel>(check(model)); }

Gauge::Gauge(const Model& model) : distance_(model), points_(surface_points(model, probes, 11)) {
  for (const auto& p : points_) box_.add(p.point);
}

double Gauge::moved(const Model& damaged) const { return off_by(points_, ModelDistance(damaged), visible); }

double Gauge::moved_either(const Model& damaged) const {
  return std::max(moved(damaged), off_by(surface_points(damaged, probes, 13), distance_, visible / 2));
}

bool Gauge::same(const Model& damaged) const {
  const ModelDistance distance(damaged);
  const double limit = 1e-6 * box_.diagonal();
  for (const auto& p : points_)
    if (std::abs(distance(p.point).distance) > limit) return false;
  for (const auto& p : surface_points(damaged, probes / 4, 13))
    if (std::abs(distance_(p.point).distance) > limit) return false;
  return true;
}

std::vector<PlaceOnPart> surface_points(const Model& model, std::size_t count, std::uint64_t seed) {
  const ModelDistance distance(model);
  const Box3 box = distance.bounds();
  const Vec3 center = box.center();
  const double radius = 0.51 * box.diagonal();
  const double least_step = 1e-3 * radius, sharp = 1e-9 * radius, h = 1e-6 * radius;
  Random random(seed);
  std::vector<PlaceOnPart> points;
  // Lines uniform in direction and offset meet every piece of surface in proportion to its area (Crofton).
  for (std::size_t lines = 0; points.size() < count; ++lines) {
    ensure(lines < 1000 * count + 10000, "random lines meet the surface");
    const Vec3 direction = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3 side = direction.unitOrthogonal();
    const double angle = random.uniform(0, 2 * pi), offset = radius * std::sqrt(random.uniform());
    const Vec3 start = center + offset * (std::cos(angle) * side + std::sin(angle) * direction.cross(side));
    auto along = [&](double t) { return distance.bound(start + t * direction); };
    double t = -radius, d = along(t);
    while (t < radius && points.size() < count) {
      const double next = t + std::max(std::abs(d), least_step), d_next = along(next);
      if ((d < 0) != (d_next < 0)) {
        double low = t, high = next, d_low = d, d_high = d_next, root = t;
        for (int i = 0; i < 80 && high - low > 0.1 * sharp; ++i) {
          root = i % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * d_low / (d_low - d_high);
          const double d_root = along(root);
          if (std::abs(d_root) < sharp) break;
          if ((d_root < 0) == (d_low < 0))
            low = root, d_low = d_root;
          else
            high = root, d_high = d_root;
        }
        const Vec3 p = start + root * direction;
        // Beside an open sheet the sign changes where there is no surface.
        const Vec3 g = gradient(distance, p, h);
        if (std::abs(distance(p).distance) < 10 * sharp && g.norm() > 0.5) points.push_back({p, g.normalized()});
      }
      t = next, d = d_next;
    }
  }
  return points;
}

Harm harm_of(const Model& truth, const Model& damaged, double beyond) {
  const ModelDistance of_truth(truth), of_damaged(damaged);
  std::map<int, std::size_t> hits;
  Harm harm;
  for (const bool added : {false, true})
    for (const auto& p : surface_points(added ? damaged : truth, harm_probes, 17)) {
      const ModelHit here = of_truth(p.point);
      if (std::abs(added ? here.distance : of_damaged(p.point).distance) <= beyond) continue;
      harm.places.push_back(p.point);
      if (here.face >= 0) ++hits[here.face];
    }
  std::vector<std::pair<std::size_t, int>> order;
  for (const auto& [face, count] : hits) order.push_back({count, face});
  std::sort(order.begin(), order.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
  for (const auto& [count, face] : order)
    if (5 * count >= order[0].first) harm.faces.push_back(of_truth.faces()[static_cast<std::size_t>(face)].name);
  return harm;
}

}  // namespace partscribe::verify
