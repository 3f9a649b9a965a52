#include "geometry/surfaces/ellipse_fit.h"

#include <cmath>

#include "geometry/decompose.h"

namespace partscribe::geometry {

double PlaneEllipse::mean_radius() const { return std::sqrt(longer * shorter); }

double PlaneEllipse::off(const Vec2& point) const {
  const Vec2 d = point - center;
  const double along = d.dot(direction) / longer, across = (d.y() * direction.x() - d.x() * direction.y()) / shorter;
  const double gauge = std::hypot(along, across);
  return gauge > 0 ? d.norm() * (1 - 1 / gauge) : -shorter;
}

std::optional<PlaneEllipse> fitted_ellipse(const std::vector<Vec2>& points) {
  const auto count = static_cast<double>(points.size());
  if (points.size() < 6) return std::nullopt;
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : points) mean += p / count;
  double square = 0;
  for (const Vec2& p : points) square += (p - mean).squaredNorm() / count;
  const double unit = std::sqrt(0.5 * square);
  if (!(unit > 0)) return std::nullopt;
  // a x^2 + b x y + c y^2 + d x + e y + f, of points about their mean and of unit size.
  Mat3 s1 = Mat3::Zero(), s2 = Mat3::Zero(), s3 = Mat3::Zero();
  for (const Vec2& p : points) {
    const Vec2 q = (p - mean) / unit;
    const Vec3 second(q.x() * q.x(), q.x() * q.y(), q.y() * q.y()), first(q.x(), q.y(), 1);
    s1 += second * second.transpose() / count, s2 += second * first.transpose() / count;
    s3 += first * first.transpose() / count;
  }
  const Eigensystem<2> spread = eigensystem<2>(Eigen::Matrix2d(s3.topLeftCorner<2, 2>()));
  if (!(spread.values[0] > 1e-10)) return std::nullopt;  // on a line
  const Mat3 first_of_second = solve_ldlt<3, 3>(s3, s2.transpose());
  Mat3 scatter = s1 - s2 * first_of_second;
  scatter = (0.5 * (scatter + scatter.transpose())).eval();
  // Points of an ellipse without noise leave it singular.
  scatter.diagonal().array() += 1e-13;
  Mat3 constraint;  // of an ellipse 4 a c - b^2 is positive
  constraint << 0, 0, 2, 0, -1, 0, 2, 0, 0;
  const auto found = generalized_eigensystem(constraint, scatter);
  const Vec3 conic = found.vectors.col(2);
  const Vec3 rest = -(first_of_second * conic);
  const double a = conic[0], b = conic[1], c = conic[2], d = rest[0], e = rest[1], f = rest[2];
  const double discriminant = 4 * a * c - b * b;
  if (!(discriminant > 0)) return std::nullopt;
  const Vec2 center((b * e - 2 * c * d) / discriminant, (b * d - 2 * a * e) / discriminant);
  const double at_center = 0.5 * (d * center.x() + e * center.y()) + f;
  Eigen::Matrix2d form;
  form << a, 0.5 * b, 0.5 * b, c;
  form /= -at_center;
  const Eigensystem<2> axes = eigensystem<2>(form);
  if (!(axes.values[0] > 0) || !std::isfinite(axes.values[1])) return std::nullopt;
  PlaneEllipse result;
  result.center = mean + unit * center;
  result.direction = axes.vectors.col(0);
  result.longer = unit / std::sqrt(axes.values[0]), result.shorter = unit / std::sqrt(axes.values[1]);
  return result;
}

}  // namespace partscribe::geometry
