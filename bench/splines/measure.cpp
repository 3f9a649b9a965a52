#include "measure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/points/kd_tree.h"

namespace bench {
namespace {

using partscribe::geometry::KdTree;
using partscribe::geometry::SurfacePoint;

constexpr int columns = 321, rows = 241;

bool over_field(const Vec3& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= field_size.x() && p.y() <= field_size.y();
}

double between(double low, double high, double share) { return low + (high - low) * share; }

/// Squared principal curvatures, summed, times the area of a unit of the parameters.
double bending_density(const SurfacePoint& p) {
  const Vec3 n = p.normal();
  const double e = p.du.squaredNorm(), f = p.du.dot(p.dv), g = p.dv.squaredNorm();
  const double l = p.duu.dot(n), m = p.duv.dot(n), q = p.dvv.dot(n), det = e * g - f * f;
  if (!(det > 0)) return 0;
  const double mean2 = (e * q - 2 * f * m + g * l) / det, gauss = (l * q - m * m) / det;
  return (mean2 * mean2 - 2 * gauss) * std::sqrt(det);
}

}  // namespace

Quality quality(const Field& field, const NurbsSurface& surface) {
  Quality result;
  const double u0 = surface.u.low(), u1 = surface.u.high(), v0 = surface.v.low(), v1 = surface.v.high();
  std::vector<Vec3> there;
  std::vector<Vec2> places;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      const Vec2 place(between(u0, u1, double(i) / (columns - 1)), between(v0, v1, double(j) / (rows - 1)));
      there.push_back(surface.at(place.x(), place.y())), places.push_back(place);
      if (over_field(there.back())) result.to_truth = std::max(result.to_truth, field.distance(there.back()));
    }
  const KdTree tree(there);
  double sum = 0;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      const double x = field_size.x() * i / (columns - 1), y = field_size.y() * j / (rows - 1);
      const Vec3 p(x, y, field.height(x, y));
      const auto near = tree.nearest_one(p);
      const Vec2& start = places[near.index];
      const double d = foot_near(surface, p, start.x(), start.y()).distance;
      result.to_fit = std::max(result.to_fit, d), sum += d * d;
    }
  result.rms = std::sqrt(sum / (columns * rows));
  const int fine = 2;
  const double cell = (u1 - u0) * (v1 - v0) / (fine * columns) / (fine * rows);
  for (int i = 0; i < fine * columns; ++i)
    for (int j = 0; j < fine * rows; ++j) {
      const SurfacePoint p = surface.derivatives(between(u0, u1, (i + 0.5) / (fine * columns)),
                                                 between(v0, v1, (j + 0.5) / (fine * rows)));
      if (over_field(p.p)) result.bending += cell * bending_density(p);
    }
  return result;
}

}  // namespace bench
