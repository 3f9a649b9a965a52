/// One superellipsoid out of noisy, partial points: a Gaussian-uniform mixture from several starts.
#include "fit/propose/superellipsoid.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>

#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "fit/propose/ball.h"
#include "fit/propose/superellipsoid_body.h"
#include "fit/propose/superquadric_mixture.h"

namespace partscribe::fit {

namespace {

constexpr std::size_t most_points = 1500;   // more do not sharpen a hypothesis
constexpr std::size_t screen_points = 400;  // enough to rank starts

/// Position, shape and mixture, on data of unit size.
struct State : MixtureState, SuperellipsoidBody {
  bool taper = false;  // whether k1 and k2 are free
};

std::uint64_t mixed(std::uint64_t h) {
  h ^= h >> 33, h *= 0xff51afd7ed558ccdull;
  h ^= h >> 33, h *= 0xc4ceb9fe1a85ec53ull;
  return h ^ (h >> 33);
}

/// A selection, and an order, that depend on the coordinates alone: whoever shuffles the file gets the same points.
std::vector<Vec3> drawn(const std::vector<Vec3>& points) {
  using Key = std::tuple<std::uint64_t, double, double, double>;
  std::vector<Key> keys;
  keys.reserve(points.size());
  for (const Vec3& p : points) {
    if (!p.allFinite()) continue;
    std::uint64_t h = 0;
    for (int k = 0; k < 3; ++k) h = mixed(h + std::bit_cast<std::uint64_t>(p[k] + 0.0) + 0x9e3779b97f4a7c15ull);
    keys.emplace_back(h, p.x(), p.y(), p.z());
  }
  const std::size_t count = std::min(keys.size(), most_points);
  std::partial_sort(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count), keys.end());
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < count; ++i)
    result.emplace_back(std::get<1>(keys[i]), std::get<2>(keys[i]), std::get<3>(keys[i]));
  return result;
}

double residual(const State& s, const Vec3& point, SuperellipsoidGradient* gradient) {
  return first_order_distance(s, point, gradient);
}

State stepped(const State& s, const SuperellipsoidGradient& step) {
  State n = s;
  static_cast<SuperellipsoidBody&>(n) = body_after(s, step);
  return n;
}

/// Of the surface without its taper, from triangles over one octant: inliers are spread over it, so of two bodies
/// through the same points the smaller explains them better.
double rough_area(const State& s) {
  constexpr int steps = 6;
  std::array<std::array<Vec3, steps + 1>, steps + 1> at;
  double sum = 0;
  for (int face = 0; face < 3; ++face) {
    for (int i = 0; i <= steps; ++i)
      for (int k = 0; k <= steps; ++k) {
        Vec3 v;
        v[face] = 1, v[(face + 1) % 3] = double(i) / steps, v[(face + 2) % 3] = double(k) / steps;
        const double in = superellipse_gauge(v[0], v[1], 2 / s.e2).value;
        at[i][k] = s.a.cwiseProduct(v) / superellipse_gauge(in, v[2], 2 / s.e1).value;
      }
    for (int i = 0; i < steps; ++i)
      for (int k = 0; k < steps; ++k)
        sum += (at[i + 1][k] - at[i][k]).cross(at[i][k + 1] - at[i][k]).norm() +
               (at[i + 1][k] - at[i + 1][k + 1]).cross(at[i][k + 1] - at[i + 1][k + 1]).norm();
  }
  return 4 * sum;
}

/// Tapers that are not wanted, and what is at its bound and pushed outward.
bool held(const State& s, int k, double push) { return (k >= 11 && !s.taper) || at_bound(s, k, push); }

void improve(State& s, const std::vector<Vec3>& points, std::size_t count, double volume, double floor, bool taper,
             int rounds) {
  s.taper = taper;
  improve_mixture<superellipsoid_unknowns>(s, points, count, volume, floor, rounds);
}

/// The same axes in another order: new x, y, z are the old i, i+1, i+2.
State permuted(const State& s, int i) {
  State n = s;
  for (int k = 0; k < 3; ++k) {
    n.rotation.col(k) = s.rotation.col((i + k) % 3);
    n.a[k] = s.a[(i + k) % 3];
  }
  return n;
}

/// The same axes; centre and sizes from between two percentiles, so that outliers do not move them far. No taper.
State resized(State s, const std::vector<Vec3>& points, std::size_t one_in) {
  Vec3 middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> v;
    for (const Vec3& p : points) v.push_back(s.rotation.col(k).dot(p));
    std::sort(v.begin(), v.end());
    const double low = v[v.size() / one_in], high = v[v.size() - 1 - v.size() / one_in];
    middle[k] = 0.5 * (low + high);
    s.a[k] = std::max(0.05, 0.525 * (high - low));
  }
  s.centre = s.rotation * middle;
  s.k1 = s.k2 = 0;
  return s;
}

/// Axes by PCA.
State upright_start(const std::vector<Vec3>& points) {
  Mat3 scatter = Mat3::Zero();
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  for (const Vec3& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter);
  State s;
  s.rotation = eigen.eigenvectors();
  for (int k = 0; k < 3; ++k) {  // of the two signs the one whose largest component is positive
    int big = 0;
    s.rotation.col(k).cwiseAbs().maxCoeff(&big);
    if (s.rotation(big, k) < 0) s.rotation.col(k) *= -1;
  }
  if (s.rotation.determinant() < 0) s.rotation.col(2) *= -1;
  return resized(s, points, 25);
}

/// The three directions to which normals n keep best: the greatest sum of (n . axis)^4, by fixed-point steps from
/// several frames.
Mat3 frame_of(const std::vector<Vec3>& normals) {
  constexpr int frames = 6, most_steps = 60;
  const std::size_t step = std::max<std::size_t>(1, normals.size() / most_points);
  Random random(5);
  Mat3 best = Mat3::Identity();
  double most = -1;
  for (int frame = 0; frame < frames; ++frame) {
    Mat3 axes =
        frame == 0 ? Mat3(Mat3::Identity()) : rotation_of(Vec3(random.normal(), random.normal(), random.normal()) * 2);
    double sum = 0;
    for (int k = 0; k < most_steps; ++k) {
      Mat3 pull = Mat3::Zero();
      const double before = sum;
      sum = 0;
      for (std::size_t i = 0; i < normals.size(); i += step) {
        const Vec3 along = axes.transpose() * normals[i], cubes = along.cwiseProduct(along).cwiseProduct(along);
        pull += normals[i] * cubes.transpose(), sum += cubes.dot(along);
      }
      const Eigen::JacobiSVD<Mat3> svd(pull, Eigen::ComputeFullU | Eigen::ComputeFullV);
      axes = svd.matrixU() * svd.matrixV().transpose();
      if (sum < before * (1 + 1e-9)) break;
    }
    if (sum > most * (1 + 1e-6)) most = sum, best = axes;
  }
  if (best.determinant() < 0) best.col(2) *= -1;
  return best;
}

/// The ball through the points by least squares, reweighted: finds the far side of a body seen from one side only.
State ball_start(const std::vector<Vec3>& points) {
  const Ball ball = ball_through(points, Vec3::Zero(), 1);
  State s;
  s.centre = ball.centre, s.a = Vec3::Constant(std::clamp(ball.radius, 0.05, 4.0));
  return s;
}

double radial_distance(const State& s, const Vec3& point, double& gauge_value) {
  const Vec3 q = s.rotation.transpose() * (point - s.centre);
  const double z = q[2] / s.a[2], t = std::clamp(z, -1.0, 1.0);
  const Vec3 w(q[0] / (s.a[0] * (1 + s.k1 * t)), q[1] / (s.a[1] * (1 + s.k2 * t)), z);
  const double in = superellipse_gauge(std::abs(w[0]), std::abs(w[1]), 2 / s.e2).value;
  gauge_value = std::max(1e-9, superellipse_gauge(in, std::abs(z), 2 / s.e1).value);
  return w.cwiseProduct(s.a).norm() * (1 - 1 / gauge_value);
}

/// Of the descriptions of the same body the one with the wide end at the bottom and x at least as long as y.
void tidy_axes(State& s) {
  if (s.k1 + s.k2 > 0) {
    s.rotation.col(1) *= -1, s.rotation.col(2) *= -1;
    s.k1 = -s.k1, s.k2 = -s.k2;
  }
  if (s.a[0] < s.a[1]) {
    const Vec3 x = s.rotation.col(0);
    s.rotation.col(0) = s.rotation.col(1), s.rotation.col(1) = -x;
    std::swap(s.a[0], s.a[1]), std::swap(s.k1, s.k2);
  }
}

/// The best body of all starts. `floor` is the least sigma: how closely the points may be asked to follow it.
State recovered(const std::vector<Vec3>& points, const std::optional<Mat3>& frame, double volume, double floor,
                Context& context) {
  const std::size_t n = points.size();
  const std::size_t few = std::min(n, screen_points);
  const State upright = upright_start(points);
  std::vector<State> starts;
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& [e1, e2] : {std::pair{1.0, 1.0}, std::pair{0.3, 0.3}, std::pair{0.3, 1.0}}) {
      starts.push_back(permuted(upright, axis));
      starts.back().e1 = e1, starts.back().e2 = e2;
    }
  for (int axis = 0; axis < 3; ++axis)  // wedges: outliers hide a taper from the starts without
    for (const auto& [k1, k2] :
         {std::pair{-0.5, 0.0}, std::pair{0.0, -0.5}, std::pair{0.5, 0.0}, std::pair{0.0, 0.5}}) {
      starts.push_back(permuted(upright, axis));
      starts.back().e1 = starts.back().e2 = 0.3, starts.back().k1 = k1, starts.back().k2 = k2;
    }
  starts.push_back(ball_start(points));
  if (frame) {
    State square;
    square.rotation = *frame;
    square = resized(square, points, 25);
    for (int axis = 0; axis < 3; ++axis) {
      starts.push_back(permuted(square, axis));
      starts.back().e1 = starts.back().e2 = 0.4;
    }
  }
  const std::size_t drawn_starts = starts.size();
  for (std::size_t i = 0; i < drawn_starts; ++i) {
    State s = starts[i];
    s.sigma = start_sigma(s, points, few);
    s.outliers = 0.15;
    if (s.k1 == 0 && s.k2 == 0) {  // with outliers about, an early taper runs away: keep the straight body too
      improve(s, points, few, volume, floor, false, 12);
      State straight = s;
      improve(straight, points, few, volume, floor, false, 25);
      starts.push_back(straight);
    }
    improve(s, points, few, volume, floor, true, 25);
    starts[i] = s;
    context.report("hypothesis", 0.8 * static_cast<double>(i + 1) / static_cast<double>(drawn_starts));
  }
  const auto by_cost = [](const State& a, const State& b) { return a.cost < b.cost; };
  std::stable_sort(starts.begin(), starts.end(), by_cost);
  starts.resize(4);
  for (State& s : starts) improve(s, points, n, volume, floor, true, 40);
  std::stable_sort(starts.begin(), starts.end(), by_cost);
  State best = starts.front();

  // Other poses of nearly the same body: each axis in turn as z, and half a quarter turn of the section, where a
  // diamond becomes a square. They lead out of the valleys in which the exponents are wrong for the axis.
  std::vector<State> others;
  for (int axis = 1; axis < 3; ++axis) {
    others.push_back(permuted(best, axis));
    std::swap(others.back().e1, others.back().e2);
  }
  if (best.e2 > 1.15) {
    State turned = best;
    turned.rotation = best.rotation * rotation_of({0, 0, pi / 4});
    turned.a[0] = turned.a[1] = std::sqrt(0.5) * 0.5 * (best.a[0] + best.a[1]);
    turned.e1 = turned.e2 = 0.3;
    for (int axis = 0; axis < 3; ++axis) others.push_back(permuted(turned, axis));
  }
  // Half of the body missed, perhaps: the axes may be right all the same. A thin disc among outliers shows its
  // thickness only between the inner percentiles.
  if (best.inliers < 0.75)
    for (const State& s : starts)
      for (const std::size_t one_in : {std::size_t{25}, std::size_t{7}}) {
        others.push_back(resized(s, points, one_in));
        others.back().e1 = std::min(s.e1, 0.5);
      }
  for (State& other : others) {
    other.k1 = other.k2 = 0;
    other.sigma = start_sigma(other, points, n);
    other.outliers = 0.15;
    improve(other, points, few, volume, floor, false, 15);
    improve(other, points, few, volume, floor, true, 25);
    if (other.cost > best.cost + 0.5) continue;
    improve(other, points, n, volume, floor, true, 30);
    if (other.cost < best.cost - 1e-4) best = other;
  }

  // A taper must earn its two numbers; neighbouring residuals are correlated, so points count half.
  if (best.k1 != 0 || best.k2 != 0) {
    State plain = best;
    plain.k1 = plain.k2 = 0;
    improve(plain, points, n, volume, floor, false, 40);
    if (0.5 * static_cast<double>(n) * (plain.cost - best.cost) < 10) best = plain;
  }
  return best;
}

}  // namespace

SuperellipsoidFit recover_superellipsoid(const std::vector<Vec3>& all, Context& context,
                                         const std::vector<Vec3>& normals) {
  SuperellipsoidFit fit;
  fit.hypothesis.suggests = "none";
  fit.shape = {1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0};
  std::vector<Vec3> points = drawn(all);
  if (points.size() < 20) return fit;

  // Centred, divided by the median radius: outliers have no say.
  const auto n = points.size();
  Vec3 origin;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> v;
    for (const Vec3& p : points) v.push_back(p[k]);
    std::sort(v.begin(), v.end());
    origin[k] = 0.5 * (v[n / 20] + v[n - 1 - n / 20]);
  }
  std::vector<double> radii;
  for (const Vec3& p : points) radii.push_back((p - origin).norm());
  std::sort(radii.begin(), radii.end());
  const double unit = radii[n / 2];
  if (!(unit > 0)) return fit;
  Box3 box;
  for (Vec3& p : points) p = (p - origin) / unit, box.add(p);
  const double volume = std::max(0.5, box.size().cwiseMax(0.2).prod());

  const std::optional<Mat3> frame = normals.empty() ? std::nullopt : std::optional(frame_of(normals));
  State best = recovered(points, frame, volume, 1e-5, context);
  // Points that no filter rejected and no single body explains closely are no outliers: then the coarse body around
  // (nearly) all of them says more of the part than a close one of a third of it.
  if (best.inliers < 0.7) {
    const State coarse = recovered(points, frame, volume, 0.12, context);
    if (coarse.inliers > std::max(0.7, best.inliers + 0.1)) best = coarse;
  }
  tidy_axes(best);

  double sum_w = 0, sum_f = 0, sum_r = 0;
  for (const Vec3& p : points) {
    const double d = residual(best, p, nullptr);
    if (std::abs(d) > 5 * best.sigma && best.inliers < 0.999) continue;  // outliers would drown both measures
    double g = 0;
    const double r = radial_distance(best, p, g);
    sum_w += 1, sum_f += std::abs(g * g - 1), sum_r += std::abs(r);
  }
  sum_w = std::max(sum_w, 1.0);

  fit.shape = {unit * best.a[0], unit * best.a[1], unit * best.a[2], best.e1, best.e2, best.k1, best.k2};
  fit.scan_from_shape = {best.rotation, origin + unit * best.centre};
  fit.inlier_share = best.inliers;
  Hypothesis& h = fit.hypothesis;
  h.a1 = fit.shape.a1, h.a2 = fit.shape.a2, h.a3 = fit.shape.a3;
  h.e1 = best.e1, h.e2 = best.e2, h.taper_x = best.k1, h.taper_y = best.k2;
  h.gof = std::sqrt(best.a.prod()) * sum_f / sum_w;
  h.gof_mm = unit * sum_r / sum_w;
  h.suggests = best.inliers < 0.4 ? "none" : suggested_procedure(fit.shape, h.gof_mm, 2 * unit * best.a.norm());
  context.report("hypothesis", 1);
  return fit;
}

std::string suggested_procedure(const SuperellipsoidOf<double>& s, double gof_mm, double size) {
  // Table 1 of the paper prints cylinder and box with e1 and e2 exchanged; equation (5) and Table 2 agree with
  // what stands here: a cylinder about z is square in latitude (e1 small) and round in longitude (e2 near 1).
  const double poor = gof_mm / size;
  const bool good = poor < 0.02;
  const auto round = [](double e) { return e > 0.7 && e < 1.3; };
  const auto square = [](double e) { return e < 0.45; };
  const bool turned = round(s.e2) && std::abs(s.a1 - s.a2) < 0.12 * std::max(s.a1, s.a2);
  if (!(poor < (turned ? 0.09 : 0.06))) return "none";  // the steps of a turned part stand out from any single body
  const double taper = std::max(std::abs(s.taper_x), std::abs(s.taper_y));
  const bool same_taper = std::abs(s.taper_x - s.taper_y) < 0.4 * taper;
  if (taper > 0.25) {
    if (turned && same_taper) return good && s.e1 < 0.6 ? "frustum" : "surface of revolution";
    if (s.e2 < 0.6 && s.e1 < 0.6 && good) return "wedge";
    return turned ? "surface of revolution" : "none";
  }
  const double big = std::max({s.a1, s.a2, s.a3}), small = std::min({s.a1, s.a2, s.a3});
  if (s.e1 > 0.75 && s.e1 < 1.3 && s.e2 > 0.75 && s.e2 < 1.3 && good) {
    if (big - small < 0.05 * big) return "sphere";
    return taper < 0.1 ? "ellipsoid" : (turned ? "surface of revolution" : "ellipsoid");
  }
  if (square(s.e1) && square(s.e2)) return "box";
  if (square(s.e1) && s.e2 > 1.6) return "box";  // turned by 45 degrees
  if (turned) return square(s.e1) && good && taper < 0.1 ? "cylinder" : "surface of revolution";
  return "none";
}

}  // namespace partscribe::fit
