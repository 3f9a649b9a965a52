#include "geometry/surfaces/primitive_start.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/decompose.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::geometry {
namespace {

using Charts = std::vector<PrimitiveChart>;

/// Right-handed rows with first axis x and third axis as near to z as it can be.
Mat3 frame_of(const Vec3& x, const Vec3& z) {
  const Vec3 a = x.normalized();
  Vec3 c = z - a * a.dot(z);
  if (c.norm() < 1e-9 * z.norm() + 1e-300) c = a.unitOrthogonal();
  c.normalize();
  Mat3 frame;
  frame.row(0) = a;
  frame.row(1) = c.cross(a);
  frame.row(2) = c;
  return frame;
}

struct Principal {
  Vec3 mean = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns, smallest spread first
};

Principal principal_axes(const std::vector<Vec3>& points) {
  Principal p;
  for (const Vec3& q : points) p.mean += q;
  p.mean /= static_cast<double>(points.size());
  Mat3 m = Mat3::Zero();
  for (const Vec3& q : points) m += (q - p.mean) * (q - p.mean).transpose();
  p.axes = Eigen::SelfAdjointEigenSolver<Mat3>(m).eigenvectors();
  return p;
}

/// Directions spread evenly over half a sphere.
std::vector<Vec3> half_sphere(int count) {
  std::vector<Vec3> directions;
  const double golden = pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, r = std::sqrt(1 - z * z), a = golden * i;
    directions.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return directions;
}

/// Least squares of q.q = 2 c.q + k (Kasa): centre and radius.
void add_sphere(const std::vector<Vec3>& points, Charts& charts) {
  Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
  Eigen::Vector4d g = Eigen::Vector4d::Zero();
  for (const Vec3& q : points) {
    const Eigen::Vector4d row(2 * q.x(), 2 * q.y(), 2 * q.z(), 1);
    H += row * row.transpose();
    g += row * q.squaredNorm();
  }
  const Eigen::Vector4d s = solve_ldlt(H, g);
  const Vec3 center = s.head<3>();
  const double sq = s[3] + center.squaredNorm();
  if (!std::isfinite(sq) || sq <= 0) return;
  const double radius = std::sqrt(sq);
  const Vec3 n = center.norm() > 1e-6 ? Vec3(-center.normalized()) : Vec3(Vec3::UnitX());
  charts.push_back(surface_chart(ChartKind::sphere, center + radius * n, n, n.unitOrthogonal(), 1 / radius, 0));
}

/// The circle of the points seen along `axis` (Kasa) and the rms error to expect of it.
struct Ring {
  Vec3 center = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  double radius = 0;
  double slope = 0;  ///< of the radius along the axis
  double error = 0;
};

/// x^2 + y^2 = 2 a x + 2 b y + k [+ beta h + alpha h^2]: a cylinder, or any quadric of revolution about `axis`.
Ring ring_along(const Vec3& axis, const std::vector<Vec3>& points, bool quadric) {
  const Mat3 frame = frame_of(axis.unitOrthogonal(), axis);
  const int m = quadric ? 5 : 3;
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Identity() * 1e-12;
  Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero(), row;
  double total = 0;
  for (const Vec3& p : points) {
    const Vec3 q = frame * p;
    row << 2 * q.x(), 2 * q.y(), 1, q.z(), q.z() * q.z();
    if (m == 3) row.tail<2>().setZero();
    const double sq = q.x() * q.x() + q.y() * q.y();
    H += row * row.transpose();
    g += row * sq;
    total += sq * sq;
  }
  const Eigen::Matrix<double, 5, 1> s = solve_ldlt(H, g);
  Ring ring;
  ring.axis = axis;
  ring.center = frame.transpose() * Vec3(s[0], s[1], 0);
  const double sq = s[2] + s[0] * s[0] + s[1] * s[1];
  ring.radius = std::sqrt(std::max(sq, 1e-4));
  ring.slope = quadric ? s[3] / (2 * ring.radius) : 0;
  if (quadric && sq < 1e-2 && s[4] > 0) ring.slope = std::copysign(std::sqrt(s[4]), s[3]);
  const double rest = std::max(total - s.dot(g), 0.0) / static_cast<double>(points.size());
  ring.error = std::sqrt(rest) / (2 * ring.radius * std::sqrt(1 + ring.slope * ring.slope));
  return ring;
}

PrimitiveChart ring_chart(ChartKind kind, const Ring& ring) {
  const Vec3 across = ring.center - ring.axis * ring.axis.dot(ring.center);
  const Vec3 n = across.norm() > 1e-6 ? Vec3(-across.normalized()) : ring.axis.unitOrthogonal();
  const double psi = kind == ChartKind::cone ? std::clamp(std::atan(ring.slope), -1.54, 1.54) : 0;
  return surface_chart(kind, across + ring.radius * n, n, ring.axis, 1 / ring.radius, psi);
}

/// The best of many axes, none of them near a better one.
void add_rings(ChartKind kind, std::vector<Vec3> axes, const std::vector<Vec3>& points, std::size_t keep,
               Charts& charts) {
  std::vector<Ring> rings;
  std::vector<Vec3> some;  // enough to rank axes
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 256) some.push_back(points[i]);
  for (const Vec3& axis : axes) rings.push_back(ring_along(axis, some, kind == ChartKind::cone));
  std::stable_sort(rings.begin(), rings.end(), [](const Ring& a, const Ring& b) { return a.error < b.error; });
  std::vector<Vec3> kept;
  for (const Ring& ring : rings) {
    if (kept.size() >= keep) break;
    if (!std::isfinite(ring.error)) continue;
    const bool close =
        std::any_of(kept.begin(), kept.end(), [&](const Vec3& a) { return std::abs(a.dot(ring.axis)) > 0.95; });
    if (close) continue;
    kept.push_back(ring.axis);
    charts.push_back(ring_chart(kind, ring));
  }
}

/// The height over the plane of least spread as a quadratic of the place in it: its curvatures and their axes.
void add_patches(ChartKind kind, const std::vector<Vec3>& points, const Principal& principal, Charts& charts) {
  const Vec3 n = principal.axes.col(0), e = principal.axes.col(2), f = n.cross(e);
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Identity() * 1e-12;
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero(), row;
  for (const Vec3& p : points) {
    const Vec3 q = p - principal.mean;
    const double x = q.dot(e), y = q.dot(f);
    row << 1, x, y, x * x, x * y, y * y;
    H += row * row.transpose();
    g += row * q.dot(n);
  }
  const Eigen::Matrix<double, 6, 1> s = solve_ldlt(H, g);
  const Vec3 place = principal.mean + n * s[0];
  const Vec3 normal = (n - s[1] * e - s[2] * f).normalized();
  Eigen::Matrix2d bend;
  bend << 2 * s[3], s[4], s[4], 2 * s[5];
  const auto solver = eigensystem(bend);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d v = solver.vectors.col(1 - i);
    charts.push_back(surface_chart(kind, place, normal, v.x() * e + v.y() * f, -solver.values[i], 0));
  }
}

std::vector<Vec3> usable(const std::vector<Vec3>& normals, std::size_t count) {
  return normals.size() == count ? normals : std::vector<Vec3>{};
}

/// Normals by the plane of each point's neighbours; their sense does not matter here.
std::vector<Vec3> plane_normals(const std::vector<Vec3>& points) {
  const KdTree tree(points);
  std::vector<Vec3> normals;
  std::vector<Neighbour> near;
  for (const Vec3& p : points) {
    tree.nearest(p, 10, near);
    std::vector<Vec3> local;
    for (const Neighbour& i : near) local.push_back(points[i.index]);
    normals.push_back(principal_axes(local).axes.col(0));
  }
  return normals;
}

/// The circle of (rho, h) about an axis line: ring and tube, and the rms error to expect.
PrimitiveChart torus_about(const Vec3& place, const Vec3& axis, const std::vector<Vec3>& points,
                           double* error = nullptr) {
  const Mat3 frame = frame_of(axis.unitOrthogonal(), axis);
  Mat3 H = Mat3::Identity() * 1e-12;
  Vec3 g = Vec3::Zero();
  double total = 0;
  for (const Vec3& p : points) {
    const Vec3 q = frame * (p - place);
    const double rho = std::hypot(q.x(), q.y());
    const Vec3 row(2 * rho, 2 * q.z(), 1);
    H += row * row.transpose();
    const double sq = rho * rho + q.z() * q.z();
    g += row * sq;
    total += sq * sq;
  }
  const Vec3 s = solve_ldlt(H, g);
  PrimitiveChart chart;
  chart.kind = ChartKind::torus;
  chart.frame = frame;
  chart.origin = place + axis * s[1];
  chart.ring = std::max(std::abs(s[0]), 1e-3);
  chart.tube = std::sqrt(std::max(s[2] + s[0] * s[0] + s[1] * s[1], 1e-4));
  if (error)
    *error = std::sqrt(std::max(total - s.dot(g), 0.0) / static_cast<double>(points.size())) / (2 * chart.tube);
  return chart;
}

/// The axis that the normal lines meet: n.b + (p x n).a = 0 (Pottmann and Wallner 2001), for the best few of six.
void add_line_complexes(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, Charts& charts) {
  Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Matrix<double, 6, 1> row;
    row << points[i].cross(normals[i]), normals[i];
    M += row * row.transpose();
  }
  // Least a^T (A - B D^-1 B^T) a over unit a, with b = -D^-1 B^T a.
  const Mat3 D = M.bottomRightCorner<3, 3>() + Mat3::Identity() * 1e-9, B = M.topRightCorner<3, 3>();
  const Mat3 from_a = -solve_ldlt(D, Mat3(B.transpose()));
  Mat3 schur = M.topLeftCorner<3, 3>() + B * from_a;
  schur = 0.5 * (schur + schur.transpose()).eval();
  const Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(schur).eigenvectors();
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = axes.col(i), moment = from_a * a;
    charts.push_back(torus_about(a.cross(moment - a * a.dot(moment)), a, points));
  }
}

/// For many directions the axis that the normal lines, seen along it, pass most closely; the best few tori about them.
void add_turned_tori(std::vector<Vec3> axes, const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                     std::size_t keep, Charts& charts) {
  struct Turned {
    PrimitiveChart chart;
    double error;
  };
  std::vector<Vec3> some, some_normals;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 128)
    some.push_back(points[i]), some_normals.push_back(normals[i]);
  std::vector<Turned> tori;
  for (const Vec3& axis : axes) {
    const Mat3 frame = frame_of(axis.unitOrthogonal(), axis);
    Eigen::Matrix2d H = Eigen::Matrix2d::Identity() * 1e-9;
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < some.size(); ++i) {
      const Vec3 q = frame * some[i], n = frame * some_normals[i];
      const Eigen::Vector2d row(n.y(), -n.x());
      H += row * row.transpose();
      g += row * row.dot(q.head<2>());
    }
    const Eigen::Vector2d c = solve_ldlt(H, g);
    Turned turned;
    turned.chart = torus_about(frame.transpose() * Vec3(c.x(), c.y(), 0), axis, some, &turned.error);
    if (std::isfinite(turned.error)) tori.push_back(turned);
  }
  std::stable_sort(tori.begin(), tori.end(), [](const Turned& a, const Turned& b) { return a.error < b.error; });
  for (std::size_t i = 0; i < tori.size() && i < keep; ++i) charts.push_back(tori[i].chart);
}

}  // namespace

PrimitiveChart surface_chart(ChartKind kind, const Vec3& place, const Vec3& normal, const Vec3& axis, double kappa,
                             double psi) {
  PrimitiveChart chart;
  chart.kind = kind;
  chart.origin = place;
  // The axis is what a revolved kind keeps; the normal gives way.
  const Vec3 z = axis.normalized();
  chart.frame = kind == ChartKind::sphere ? frame_of(normal, axis) : frame_of(normal - z * z.dot(normal), z);
  chart.kappa = kappa;
  chart.psi = psi;
  return chart;
}

PrimitiveChart recentered(PrimitiveChart chart) {
  if (chart.kind == ChartKind::torus) return chart;
  const bool sphere = chart.kind == ChartKind::sphere;
  const Vec3 q = -(chart.frame * chart.origin);
  const double k = chart.kappa;
  const double across = q.y() * q.y() + (sphere ? q.z() * q.z() : 0);
  Vec3 n(1 + k * q.x(), k * q.y(), sphere ? k * q.z() : 0);
  const double S = n.norm();
  double E = (2 * q.x() + k * (q.x() * q.x() + across)) / (1 + S);
  if (S > 1e-6)
    n /= S;
  else
    n = Vec3::UnitX(), E = q.x();  // the middle of the points is on the axis: any normal is as near
  // n points from the axis to the middle of the points; the foot is E back along it.
  Vec3 foot = q - E * n;
  if (S <= 1e-6) foot = Vec3(0, 0, q.z());
  if (chart.kind == ChartKind::circle) foot.z() = 0;
  if (chart.kind == ChartKind::cone) {
    const double c = std::cos(chart.psi), s = std::sin(chart.psi);
    double along = E * s + q.z() * c;
    // Stay in front of the apex: at least a twentieth of the points' size of radius, if the middle lies behind it.
    const double grown = 1 + k * along * s;
    if (k > 0 && grown < 0.05 * k) along = (0.05 - 1 / k) / s;
    foot = q - E * n;
    foot.z() = along * c;
    foot += n * (along * s);
    chart.kappa = k / (1 + k * along * s);
  }
  chart.origin += chart.frame.transpose() * foot;
  const Vec3 normal = chart.frame.transpose() * n;
  const Vec3 z = chart.frame.row(2);
  chart.frame = sphere ? frame_of(normal, z) : frame_of(normal - z * z.dot(normal), z);
  if (chart.kappa < 0) {  // always the outer side
    chart.kappa = -chart.kappa;
    chart.psi = -chart.psi;
    chart.frame.row(0) *= -1;
    chart.frame.row(1) *= -1;
  }
  return chart;
}

std::vector<PrimitiveChart> start_charts(ChartKind kind, const std::vector<Vec3>& points,
                                         const std::vector<Vec3>& given_normals) {
  Charts charts;
  const std::vector<Vec3> normals = usable(given_normals, points.size());
  const Principal principal = principal_axes(points);
  const Vec3 least = principal.axes.col(0), mid = principal.axes.col(1), most = principal.axes.col(2);
  if (kind == ChartKind::sphere) {
    add_sphere(points, charts);
    charts.push_back(surface_chart(kind, principal.mean, least, mid, 0, 0));
    return charts;
  }
  if (kind == ChartKind::circle) {
    charts.push_back(ring_chart(kind, ring_along(least, points, false)));
    charts.push_back(surface_chart(kind, principal.mean, mid, least, 0, 0));
    return charts;
  }
  if (kind == ChartKind::torus) {
    const std::vector<Vec3> directions = normals.empty() ? plane_normals(points) : normals;
    add_line_complexes(points, directions, charts);
    add_turned_tori(half_sphere(60), points, directions, 6, charts);
    for (int i = 0; i < 3; ++i) charts.push_back(torus_about(principal.mean, principal.axes.col(i), points));
    return charts;
  }
  std::vector<Vec3> axes = {least, mid, most};
  if (!normals.empty()) {
    Mat3 m = Mat3::Zero();
    Vec3 mean = Vec3::Zero();
    for (const Vec3& n : normals) m += n * n.transpose(), mean += n;
    if (kind == ChartKind::cone) m -= mean * mean.transpose() / static_cast<double>(normals.size());
    const Vec3 axis = Eigen::SelfAdjointEigenSolver<Mat3>(m).eigenvectors().col(0);
    charts.push_back(ring_chart(kind, ring_along(axis, points, kind == ChartKind::cone)));
  }
  for (const Vec3& axis : half_sphere(60)) axes.push_back(axis);
  add_rings(kind, axes, points, 4, charts);
  if (kind == ChartKind::cone) {
    Charts cylinders;
    add_rings(ChartKind::cylinder, axes, points, 2, cylinders);
    for (PrimitiveChart& chart : cylinders) chart.kind = kind, charts.push_back(chart);
  }
  add_patches(kind, points, principal, charts);
  return charts;
}

}  // namespace partscribe::geometry
