#include "geometry/surfaces/primitive_kernels.h"

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/instructions.h"

// The loops are written once and compiled for several processors. Lanes are fixed at 8 and products are never fused
// into sums, so that every processor gives the same bits.
#if defined(__GNUC__) && defined(__x86_64__)
#define PARTSCRIBE_INLINE __attribute__((always_inline)) inline
#define PARTSCRIBE_WIDE 1
#else
#define PARTSCRIBE_INLINE inline
#define PARTSCRIBE_WIDE 0
#endif

namespace partscribe::geometry {
namespace {

constexpr int block_size = 256;
constexpr int lanes = 8;

#if defined(__GNUC__)
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double)), may_alias));
#else
struct Lanes {
  double v[lanes];
  double operator[](int i) const { return v[i]; }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    Lanes r;
    for (int i = 0; i < lanes; ++i) r.v[i] = a.v[i] * b.v[i];
    return r;
  }
  Lanes& operator+=(const Lanes& b) {
    for (int i = 0; i < lanes; ++i) v[i] += b.v[i];
    return *this;
  }
};
#endif

/// Derivatives and distance (the last column in use) of up to 256 points.
struct alignas(64) Block {
  double column[max_unknowns + 1][block_size];
  double second[4][block_size];  ///< a circle's other residual: two tilts, shift along its axis, height
  double x[block_size], y[block_size], z[block_size];
  double weight[block_size];
  double weighted[block_size];
};

/// out[j] += sum of a * b[j] for N columns at a time, as many as the registers of a small processor hold.
template <int N>
PARTSCRIBE_INLINE void add_products(const double* a, const double* const* b, int padded, Lanes* out) {
  const Lanes* va = reinterpret_cast<const Lanes*>(a);
  const Lanes* b0 = reinterpret_cast<const Lanes*>(b[0]);
  const Lanes* b1 = reinterpret_cast<const Lanes*>(b[N > 1 ? 1 : 0]);
  const Lanes* b2 = reinterpret_cast<const Lanes*>(b[N > 2 ? 2 : 0]);
  const Lanes* b3 = reinterpret_cast<const Lanes*>(b[N > 3 ? 3 : 0]);
  Lanes s0 = {}, s1 = {}, s2 = {}, s3 = {};
  for (int k = 0; k < padded / lanes; ++k) {
    const Lanes v = va[k];
    s0 += v * b0[k];
    if constexpr (N > 1) s1 += v * b1[k];
    if constexpr (N > 2) s2 += v * b2[k];
    if constexpr (N > 3) s3 += v * b3[k];
  }
  out[0] += s0;
  if constexpr (N > 1) out[1] += s1;
  if constexpr (N > 2) out[2] += s2;
  if constexpr (N > 3) out[3] += s3;
}

/// One row of the products: a with `count` columns.
PARTSCRIBE_INLINE void add_row(const double* a, const double* const* b, int count, int padded, Lanes* out) {
  int j = 0;
  for (; j + 4 <= count; j += 4) add_products<4>(a, b + j, padded, out + j);
  if (count - j == 3) add_products<3>(a, b + j, padded, out + j);
  if (count - j == 2) add_products<2>(a, b + j, padded, out + j);
  if (count - j == 1) add_products<1>(a, b + j, padded, out + j);
}

PARTSCRIBE_INLINE double sum_of(const Lanes& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/// What the loops need of a chart.
struct Coefficients {
  double r[9], o[3];
  double kappa, radius, sq_radius;  ///< radius: 1 / kappa, 0 for a plane
  double c, s;                      ///< cos and sin of psi
  double ring, tube;
};

PARTSCRIBE_INLINE void move_block(const ScaledPoints& points, std::size_t begin, int n, const Coefficients& f,
                                  Block& b) {
  const double* p = (*points.points)[begin].data();
  const double cx = points.center.x(), cy = points.center.y(), cz = points.center.z(), factor = points.factor;
  for (int k = 0; k < n; ++k) {
    const double dx = (p[3 * k] - cx) * factor - f.o[0];
    const double dy = (p[3 * k + 1] - cy) * factor - f.o[1];
    const double dz = (p[3 * k + 2] - cz) * factor - f.o[2];
    b.x[k] = f.r[0] * dx + f.r[1] * dy + f.r[2] * dz;
    b.y[k] = f.r[3] * dx + f.r[4] * dy + f.r[5] * dz;
    b.z[k] = f.r[6] * dx + f.r[7] * dy + f.r[8] * dz;
  }
}

constexpr double tiny = 1e-150;  // keeps a point on the axis from dividing by zero; its square is still a number

/// rho - radius and its derivative by kappa. `Round`: the radius is near the size of the points, so that nothing
/// cancels in the short forms; else the forms that stay exact until the surface is flat.
template <bool Round>
PARTSCRIBE_INLINE void excess(const Coefficients& f, double x, double across, double u, double S, double inverse,
                              double& E, double& by_kappa) {
  if constexpr (Round) {
    E = (S - 1) * f.radius;
    by_kappa = (S - u) * inverse * f.sq_radius;
  } else {
    E = (2 * x + f.kappa * (x * x + across)) / (1 + S);
    const double near = across * inverse / (S + u), far = (S - u) * inverse * f.sq_radius;
    by_kappa = u > 0 ? near : far;
  }
}

template <bool Round>
PARTSCRIBE_INLINE void sphere_block(int n, const Coefficients& f, Block& b) {
  for (int k = 0; k < n; ++k) {
    const double x = b.x[k], y = b.y[k], z = b.z[k];
    const double u = 1 + f.kappa * x, across = y * y + z * z;
    const double S = __builtin_sqrt(u * u + f.kappa * f.kappa * across) + tiny;
    const double inverse = 1 / S;
    double E, by_kappa;
    excess<Round>(f, x, across, u, S, inverse, E, by_kappa);
    b.column[0][k] = -u * inverse;
    b.column[1][k] = y * inverse;
    b.column[2][k] = z * inverse;
    b.column[3][k] = by_kappa;
    b.column[4][k] = E;
  }
}

template <bool Round>
PARTSCRIBE_INLINE void cylinder_block(int n, const Coefficients& f, Block& b) {
  for (int k = 0; k < n; ++k) {
    const double x = b.x[k], y = b.y[k], z = b.z[k];
    const double u = 1 + f.kappa * x, v = f.kappa * y;
    const double S = __builtin_sqrt(u * u + v * v) + tiny;
    const double inverse = 1 / S;
    double E, by_kappa;
    excess<Round>(f, x, y * y, u, S, inverse, E, by_kappa);
    b.column[0][k] = -u * inverse;
    b.column[1][k] = y * inverse;
    b.column[2][k] = z * (v * inverse);
    b.column[3][k] = -z * (u * inverse);
    b.column[4][k] = by_kappa;
    b.column[5][k] = E;
  }
}

/// The other residual of a circle is the height over its plane.
PARTSCRIBE_INLINE void height_block(int n, Block& b) {
  for (int k = 0; k < n; ++k) {
    b.second[0][k] = -b.y[k];
    b.second[1][k] = b.x[k];
    b.second[2][k] = -1;
    b.second[3][k] = b.z[k];
  }
}

/// A point behind the apex is nearest to the apex itself.
void behind_apex(int k, const Coefficients& f, Block& b) {
  const double radius = 1 / f.kappa, height = f.c / (f.s * f.kappa);
  const Vec3 q(b.x[k], b.y[k], b.z[k]);
  const Vec3 to = q + Vec3(radius, 0, height);
  const double d = to.norm() + tiny;
  const Vec3 g = to / d, turn = q.cross(g);
  b.column[0][k] = -(g.x() * f.c - g.z() * f.s);
  b.column[1][k] = -turn.z();
  b.column[2][k] = -turn.x();
  b.column[3][k] = -turn.y();
  b.column[4][k] = -(g.x() * radius * radius + g.z() * height * radius);
  b.column[5][k] = -g.z() * radius / (f.s * f.s);
  b.column[6][k] = d;
}

template <bool Round>
PARTSCRIBE_INLINE void cone_block(int n, const Coefficients& f, Block& b) {
  int behind = 0;
  const double cc = f.c * f.c, ss = f.s * f.s, kcs = f.kappa * f.c * f.s;
  for (int k = 0; k < n; ++k) {
    const double x = b.x[k], y = b.y[k], z = b.z[k];
    const double u = 1 + f.kappa * x, v = f.kappa * y;
    const double S = __builtin_sqrt(u * u + v * v) + tiny;
    const double inverse = 1 / S;
    double E, by_kappa;
    excess<Round>(f, x, y * y, u, S, inverse, E, by_kappa);
    b.column[0][k] = -(cc * (u * inverse) + ss);
    b.column[1][k] = f.c * (y * inverse);
    b.column[2][k] = f.s * y + f.c * (z * (v * inverse));
    b.column[3][k] = -(f.s * x) - f.c * (z * (u * inverse));
    b.column[4][k] = f.c * by_kappa;
    b.column[5][k] = -(f.s * E) - f.c * z;
    b.column[6][k] = f.c * E - f.s * z;
    b.weighted[k] = ss * S + kcs * z + cc;  // > 0 in front of the apex
  }
  if (f.kappa <= 0 || f.s == 0) return;
  for (int k = 0; k < n; ++k) behind |= b.weighted[k] < 0;
  if (!behind) return;
  for (int k = 0; k < n; ++k)
    if (b.weighted[k] < 0) behind_apex(k, f, b);
}

PARTSCRIBE_INLINE void torus_block(int n, const Coefficients& f, Block& b) {
  for (int k = 0; k < n; ++k) {
    const double x = b.x[k], y = b.y[k], z = b.z[k];
    const double rho = __builtin_sqrt(x * x + y * y) + tiny;
    const double w = rho - f.ring;
    const double L = __builtin_sqrt(w * w + z * z) + tiny;
    const double inverse = 1 / (rho * L);
    const double il = rho * inverse;
    b.column[0][k] = -(w * x) * inverse;
    b.column[1][k] = -(w * y) * inverse;
    b.column[2][k] = -z * il;
    b.column[3][k] = -(f.ring * y * z) * inverse;
    b.column[4][k] = f.ring * x * z * inverse;
    b.column[5][k] = -w * il;
    b.column[6][k] = -1;
    b.column[7][k] = L - f.tube;
  }
}

/// Fills b.weight with the robust weight times the weight of each point, and adds the scalar sums.
void weigh(const ScaledPoints& points, std::size_t begin, int n, int residual, bool circle, double reach, Block& b,
           KernelEquations& out) {
  const double half = reach > 0 ? 0.5 / (reach * reach) : 0;
  for (int k = 0; k < n; ++k) {
    const double w = points.weight.empty() ? 1 : points.weight[begin + static_cast<std::size_t>(k)];
    double sq = b.column[residual][k] * b.column[residual][k];
    if (circle) sq += b.second[3][k] * b.second[3][k];
    const double e = half > 0 ? std::exp(-w * sq * half) : 1;
    out.cost += half > 0 ? -std::expm1(-w * sq * half) / half : w * sq;
    out.squares += e * w * sq;
    out.weight += e * w;
    out.count += e;
    b.weight[k] = e * w;
  }
}

/// All products of `count` columns with each other, weighted or not, into the upper triangle of `sums`.
PARTSCRIBE_INLINE void add_block(const double* const* column, int count, int n, bool weighted, Block& b, Lanes* sums) {
  const int padded = (n + lanes - 1) / lanes * lanes;
  int offset = 0;
  for (int i = 0; i < count; ++i) {
    const double* a = column[i];
    if (weighted) {
      for (int k = 0; k < padded; ++k) b.weighted[k] = b.weight[k] * a[k];
      a = b.weighted;
    }
    add_row(a, column + i, count - i, padded, sums + offset);
    offset += count - i;
  }
}

PARTSCRIBE_INLINE void clear_tail(double* column, int n) {
  for (int k = n; k % lanes != 0; ++k) column[k] = 0;
}

/// The sums of one chart kind over all blocks.
template <ChartKind Kind, bool Round>
PARTSCRIBE_INLINE void sum_blocks(const ScaledPoints& points, const Coefficients& f, double reach,
                                  KernelEquations& out) {
  constexpr int unknowns = Kind == ChartKind::sphere     ? 4
                           : Kind == ChartKind::cylinder ? 5
                           : Kind == ChartKind::circle   ? 5
                           : Kind == ChartKind::cone     ? 6
                                                         : 7;
  constexpr int columns = unknowns + 1;
  constexpr bool circle = Kind == ChartKind::circle;
  const bool weighted = reach > 0 || !points.weight.empty();
  alignas(64) Lanes sums[columns * (columns + 1) / 2] = {};
  alignas(64) Lanes second[10] = {};
  Block b;
  const double* column[columns];
  for (int i = 0; i < columns; ++i) column[i] = b.column[i];
  const double* other[4] = {b.second[0], b.second[1], b.second[2], b.second[3]};

  for (std::size_t begin = 0; begin < points.size(); begin += block_size) {
    const std::size_t rest = points.size() - begin;
    const int n = rest < block_size ? static_cast<int>(rest) : block_size;
    move_block(points, begin, n, f, b);
    if constexpr (Kind == ChartKind::sphere) sphere_block<Round>(n, f, b);
    if constexpr (Kind == ChartKind::cylinder || circle) cylinder_block<Round>(n, f, b);
    if constexpr (Kind == ChartKind::cone) cone_block<Round>(n, f, b);
    if constexpr (Kind == ChartKind::torus) torus_block(n, f, b);
    if constexpr (circle) height_block(n, b);
    if (weighted) weigh(points, begin, n, unknowns, circle, reach, b, out);
    if (n % lanes != 0) {
      for (int i = 0; i < columns; ++i) clear_tail(b.column[i], n);
      for (int i = 0; i < 4 && circle; ++i) clear_tail(b.second[i], n);
      clear_tail(b.weight, n);
    }
    add_block(column, columns, n, weighted, b, sums);
    if constexpr (circle) add_block(other, 4, n, weighted, b, second);
  }

  int offset = 0;
  for (int i = 0; i < columns; ++i)
    for (int j = i; j < columns; ++j, ++offset) {
      const double sum = sum_of(sums[offset]);
      if (j < unknowns)
        out.H(i, j) = out.H(j, i) = sum;
      else if (i < unknowns)
        out.g[i] = sum;
      else if (!weighted)
        out.cost = sum;
    }
  if constexpr (circle) {
    const int place[3] = {2, 3, 5};
    offset = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j, ++offset) {
        const double sum = sum_of(second[offset]);
        if (j < 3)
          out.H(place[i], place[j]) += sum;
        else if (i < 3)
          out.g[place[i]] += sum;
        else if (!weighted)
          out.cost += sum;
        if (j < 3 && i != j) out.H(place[j], place[i]) = out.H(place[i], place[j]);
      }
  }
  if (!weighted) {
    out.squares = out.cost;
    out.weight = out.count = static_cast<double>(points.size());
  }
}

template <bool Round>
PARTSCRIBE_INLINE void sum_round(ChartKind kind, const ScaledPoints& points, const Coefficients& f, double reach,
                                 KernelEquations& out) {
  switch (kind) {
    case ChartKind::sphere:
      sum_blocks<ChartKind::sphere, Round>(points, f, reach, out);
      break;
    case ChartKind::cylinder:
      sum_blocks<ChartKind::cylinder, Round>(points, f, reach, out);
      break;
    case ChartKind::cone:
      sum_blocks<ChartKind::cone, Round>(points, f, reach, out);
      break;
    case ChartKind::circle:
      sum_blocks<ChartKind::circle, Round>(points, f, reach, out);
      break;
    case ChartKind::torus:
      break;
  }
}

PARTSCRIBE_INLINE void sum_kind(ChartKind kind, const ScaledPoints& points, const Coefficients& f, double reach,
                                KernelEquations& out) {
  if (kind == ChartKind::torus)
    sum_blocks<ChartKind::torus, false>(points, f, reach, out);
  else if (f.kappa > 0.05)
    sum_round<true>(kind, points, f, reach, out);
  else
    sum_round<false>(kind, points, f, reach, out);
}

/// Ten lanes of sums: w, w x, w y, w z and the six products.
PARTSCRIBE_INLINE void sum_moments(const Vec3* points, std::size_t count, const double* weights, const double* o,
                                   double* out) {
  Block b;
  alignas(64) Lanes sums[10] = {};
  const double* column[4] = {b.column[0], b.column[1], b.column[2], b.column[3]};
  for (std::size_t begin = 0; begin < count; begin += block_size) {
    const int n = count - begin < block_size ? static_cast<int>(count - begin) : block_size;
    const double* p = points[begin].data();
    for (int k = 0; k < n; ++k) {
      b.column[0][k] = 1;
      b.column[1][k] = p[3 * k] - o[0];
      b.column[2][k] = p[3 * k + 1] - o[1];
      b.column[3][k] = p[3 * k + 2] - o[2];
    }
    if (weights)
      for (int k = 0; k < n; ++k) b.weight[k] = weights[begin + static_cast<std::size_t>(k)];
    for (int i = 0; i < 4; ++i) clear_tail(b.column[i], n);
    clear_tail(b.weight, n);
    add_block(column, 4, n, weights != nullptr, b, sums);
  }
  for (int i = 0; i < 10; ++i) out[i] = sum_of(sums[i]);
}

void kind_plain(ChartKind kind, const ScaledPoints& points, const Coefficients& f, double reach, KernelEquations& out) {
  sum_kind(kind, points, f, reach, out);
}
void moments_plain(const Vec3* points, std::size_t count, const double* weights, const double* o, double* out) {
  sum_moments(points, count, weights, o, out);
}

#if PARTSCRIBE_WIDE
__attribute__((target("avx2"))) void kind_avx2(ChartKind kind, const ScaledPoints& points, const Coefficients& f,
                                               double reach, KernelEquations& out) {
  sum_kind(kind, points, f, reach, out);
}
__attribute__((target("avx512f,avx512vl,avx512dq"))) void kind_avx512(ChartKind kind, const ScaledPoints& points,
                                                                      const Coefficients& f, double reach,
                                                                      KernelEquations& out) {
  sum_kind(kind, points, f, reach, out);
}
__attribute__((target("avx2"))) void moments_avx2(const Vec3* points, std::size_t count, const double* weights,
                                                  const double* o, double* out) {
  sum_moments(points, count, weights, o, out);
}
__attribute__((target("avx512f,avx512vl,avx512dq"))) void moments_avx512(const Vec3* points, std::size_t count,
                                                                         const double* weights, const double* o,
                                                                         double* out) {
  sum_moments(points, count, weights, o, out);
}
#endif

}  // namespace

int unknowns_of(ChartKind kind) {
  switch (kind) {
    case ChartKind::sphere:
      return 4;
    case ChartKind::cylinder:
      return 5;
    case ChartKind::cone:
    case ChartKind::circle:
      return 6;
    case ChartKind::torus:
      return 7;
  }
  return 0;
}

KernelEquations normal_equations(const ScaledPoints& points, const PrimitiveChart& chart, double reach) {
  Coefficients f;
  for (int i = 0; i < 3; ++i) {
    f.o[i] = chart.origin[i];
    for (int j = 0; j < 3; ++j) f.r[3 * i + j] = chart.frame(i, j);
  }
  f.kappa = chart.kappa;
  f.radius = chart.kappa != 0 ? 1 / chart.kappa : 0;
  f.sq_radius = f.radius * f.radius;
  f.c = std::cos(chart.psi), f.s = std::sin(chart.psi);
  f.ring = chart.ring, f.tube = chart.tube;
  KernelEquations out;
#if PARTSCRIBE_WIDE
  if (widest_instructions() == Instructions::avx512) return kind_avx512(chart.kind, points, f, reach, out), out;
  if (widest_instructions() == Instructions::avx2) return kind_avx2(chart.kind, points, f, reach, out), out;
#endif
  kind_plain(chart.kind, points, f, reach, out);
  return out;
}

Moments moments(const std::vector<Vec3>& points, const double* weights, const Vec3& origin) {
  double s[10];
#if PARTSCRIBE_WIDE
  if (widest_instructions() == Instructions::avx512)
    moments_avx512(points.data(), points.size(), weights, origin.data(), s);
  else if (widest_instructions() == Instructions::avx2)
    moments_avx2(points.data(), points.size(), weights, origin.data(), s);
  else
#endif
    moments_plain(points.data(), points.size(), weights, origin.data(), s);
  Moments m;
  m.weight = s[0];
  m.first = Vec3(s[1], s[2], s[3]);
  m.second << s[4], s[5], s[6], s[5], s[7], s[8], s[6], s[8], s[9];
  return m;
}

}  // namespace partscribe::geometry
