#include "geometry/surfaces/gregory_patch.h"

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/ensure.h"

namespace partscribe::geometry {
namespace {

struct Cubics {
  double value[4], slope[4];
};

Cubics cubics_at(double t) {
  const double s = 1 - t;
  return {{s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t},
          {-3 * s * s, 3 * s * (s - 2 * t), 3 * t * (2 * s - t), 3 * t * t}};
}

bool is_inner(int i, int j) { return i % 3 != 0 && j % 3 != 0; }

/// The inner control point that holds at (u, v), and its derivatives; 1 or 2 each.
struct MixedPoint {
  Vec3 value, du, dv;
};
MixedPoint mixed_point(const GregoryPatch& patch, int i, int j, double u, double v) {
  const auto row = static_cast<std::size_t>(i - 1), column = static_cast<std::size_t>(j - 1);
  const Vec3 &of_u = patch.across_u[row][column], &of_v = patch.across_v[row][column];
  const double a = i == 1 ? u : 1 - u, b = j == 1 ? v : 1 - v, both = a + b;
  // In the corner itself it counts for nothing.
  if (!(both > 0)) return {0.5 * (of_u + of_v), Vec3::Zero(), Vec3::Zero()};
  const Vec3 turn = (of_v - of_u) / (both * both);
  return {(a * of_v + b * of_u) / both, (i == 1 ? b : -b) * turn, (j == 1 ? -a : a) * turn};
}

/// A polynomial of two variables in Bernstein's form, coefficients [i * (degree + 1) + j], of one degree for both.
template <class T>
struct BernsteinNet {
  int degree = 0;
  std::vector<T> coefficients;
  T& at(int i, int j) { return coefficients[static_cast<std::size_t>(i * (degree + 1) + j)]; }
  const T& at(int i, int j) const { return coefficients[static_cast<std::size_t>(i * (degree + 1) + j)]; }
};

template <class T>
BernsteinNet<T> constant_net(int degree, const T& value) {
  return {degree, std::vector<T>(static_cast<std::size_t>((degree + 1) * (degree + 1)), value)};
}

double choose(int n, int k) {
  double result = 1;
  for (int i = 1; i <= k; ++i) result = result * (n - k + i) / i;
  return result;
}

template <class T>
BernsteinNet<T> product_of(const BernsteinNet<double>& a, const BernsteinNet<T>& b) {
  BernsteinNet<T> result = constant_net<T>(a.degree + b.degree, b.coefficients.front() * 0);
  // Shares of the coefficients i and k of the factors in i + k of the product.
  const auto share = [&](int i, int k) {
    return choose(a.degree, i) * choose(b.degree, k) / choose(a.degree + b.degree, i + k);
  };
  for (int i = 0; i <= a.degree; ++i)
    for (int j = 0; j <= a.degree; ++j)
      for (int k = 0; k <= b.degree; ++k)
        for (int l = 0; l <= b.degree; ++l)
          result.at(i + k, j + l) += share(i, k) * share(j, l) * a.at(i, j) * b.at(k, l);
  return result;
}

template <class T>
void add_to(BernsteinNet<T>& sum, const BernsteinNet<T>& more) {
  for (std::size_t i = 0; i < sum.coefficients.size(); ++i) sum.coefficients[i] += more.coefficients[i];
}

/// A corner whose twists disagree: a, b and a + b as functions of u and v.
struct TornCorner {
  int i, j;  // of its inner control point
  BernsteinNet<double> a, b, both;
};

TornCorner torn_corner(int i, int j) {
  TornCorner corner{i, j, constant_net(1, 0.0), constant_net(1, 0.0), constant_net(1, 0.0)};
  for (int k = 0; k <= 1; ++k)
    for (int l = 0; l <= 1; ++l) {
      corner.a.at(k, l) = i == 1 ? k : 1 - k, corner.b.at(k, l) = j == 1 ? l : 1 - l;
      corner.both.at(k, l) = corner.a.at(k, l) + corner.b.at(k, l);
    }
  return corner;
}

}  // namespace

Vec3 GregoryPatch::at(double u, double v) const {
  const Cubics bu = cubics_at(u), bv = cubics_at(v);
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      p += bu.value[i] * bv.value[j] *
           (is_inner(i, j) ? mixed_point(*this, i, j, u, v).value : points[std::size_t(i)][std::size_t(j)]);
  return p;
}

GregoryPatch::Tangents GregoryPatch::tangents(double u, double v) const {
  const Cubics bu = cubics_at(u), bv = cubics_at(v);
  Tangents t{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const MixedPoint q = is_inner(i, j)
                               ? mixed_point(*this, i, j, u, v)
                               : MixedPoint{points[std::size_t(i)][std::size_t(j)], Vec3::Zero(), Vec3::Zero()};
      t.p += bu.value[i] * bv.value[j] * q.value;
      t.du += bu.slope[i] * bv.value[j] * q.value + bu.value[i] * bv.value[j] * q.du;
      t.dv += bu.value[i] * bv.slope[j] * q.value + bu.value[i] * bv.value[j] * q.dv;
    }
  return t;
}

Vec3 GregoryPatch::Tangents::normal() const {
  const Vec3 n = du.cross(dv);
  const double length = n.norm();
  return length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
}

NurbsSurface rational_bezier(const GregoryPatch& patch, double corner_weight) {
  ensure(corner_weight > 0 && corner_weight < 1, "weights are positive");
  double size = 0;
  for (const auto& row : patch.points)
    for (const Vec3& p : row) size = std::max(size, (p - patch.points[0][0]).norm());
  std::vector<TornCorner> torn;
  BernsteinNet<Vec3> sum = constant_net<Vec3>(3, Vec3::Zero());
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
      if (!is_inner(i, j)) {
        sum.at(i, j) = patch.points[row][column];
      } else if (const Vec3 off = patch.across_u[row - 1][column - 1] - patch.across_v[row - 1][column - 1];
                 off.norm() > 1e-12 * size) {
        torn.push_back(torn_corner(i, j));
      } else {
        sum.at(i, j) = patch.across_u[row - 1][column - 1];
      }
    }
  BernsteinNet<double> denominator = constant_net(0, 1.0);
  for (const TornCorner& corner : torn) {
    denominator = product_of(denominator, corner.both);
    sum = product_of(corner.both, sum);
  }
  for (std::size_t c = 0; c < torn.size(); ++c) {
    const auto row = static_cast<std::size_t>(torn[c].i - 1), column = static_cast<std::size_t>(torn[c].j - 1);
    BernsteinNet<double> basis = constant_net(3, 0.0);
    basis.at(torn[c].i, torn[c].j) = 1;
    BernsteinNet<Vec3> mixed = constant_net<Vec3>(1, Vec3::Zero());
    for (int k = 0; k <= 1; ++k)
      for (int l = 0; l <= 1; ++l)
        mixed.at(k, l) =
            torn[c].a.at(k, l) * patch.across_v[row][column] + torn[c].b.at(k, l) * patch.across_u[row][column];
    BernsteinNet<Vec3> part = product_of(basis, mixed);
    for (std::size_t other = 0; other < torn.size(); ++other)
      if (other != c) part = product_of(torn[other].both, part);
    add_to(sum, part);
  }
  NurbsSurface surface;
  surface.u = surface.v = clamped(sum.degree, {0, 1});
  if (torn.empty()) {
    surface.points = sum.coefficients;
    return surface;
  }
  surface.weights = product_of(constant_net(3, 1.0), denominator).coefficients;
  double largest = 0;
  for (const double w : surface.weights) largest = std::max(largest, w);
  for (std::size_t k = 0; k < surface.weights.size(); ++k) {
    surface.points.push_back(surface.weights[k] > 0 ? Vec3(sum.coefficients[k] / surface.weights[k])
                                                    : Vec3(Vec3::Zero()));
    surface.weights[k] /= largest;
  }
  for (const TornCorner& corner : torn) {
    const int i = corner.i == 1 ? 0 : sum.degree, j = corner.j == 1 ? 0 : sum.degree;
    const auto k = static_cast<std::size_t>(i * (sum.degree + 1) + j);
    surface.weights[k] = corner_weight;
    surface.points[k] = patch.points[corner.i == 1 ? 0 : 3][corner.j == 1 ? 0 : 3];
  }
  return surface;
}

}  // namespace partscribe::geometry
