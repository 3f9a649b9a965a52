#include "geometry/images/window_kernels.h"

#include <cstring>
#include <limits>

// The loops are written once and compiled for two processors. Products are never fused into sums, so that both give
// the same bits.
#if defined(__GNUC__) && defined(__x86_64__)
#define PARTSCRIBE_INLINE __attribute__((always_inline)) inline
#define PARTSCRIBE_AVX2 __attribute__((target("avx2")))
#else
#define PARTSCRIBE_INLINE inline
#endif

namespace partscribe::geometry {
namespace {

#ifdef PARTSCRIBE_AVX2
bool has_avx2() {
  static const bool yes = __builtin_cpu_supports("avx2") != 0;
  return yes;
}
#endif

// One window per lane; without vectors, and at the end of a row, one window at a time.
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wpsabi"  // nothing here is called across an interface, all is inlined
typedef float Lanes __attribute__((vector_size(32)));
typedef int LanesMask __attribute__((vector_size(32)));
PARTSCRIBE_INLINE Lanes select(LanesMask yes, const Lanes& a, const Lanes& b) { return yes ? a : b; }
#else
using Lanes = float;
#endif
PARTSCRIBE_INLINE float select(bool yes, float a, float b) { return yes ? a : b; }

template <class F>
constexpr int width_of = sizeof(F) / sizeof(float);

template <class F>
PARTSCRIBE_INLINE F load(const float* p) {
  F f;
  std::memcpy(&f, p, sizeof f);
  return f;
}

template <class F>
PARTSCRIBE_INLINE void store(float* p, const F& f) {
  std::memcpy(p, &f, sizeof f);
}

/// The least-squares line through three of five samples at t = -2 .. 2, as products with these numbers.
struct Triple {
  int i, j, k;
  float contrast[3];  // unit; its product with the samples is the root of the sum of squared residuals
  float at_zero[3];
  float slope[3];
  float mean;  // of t
  float inverse_stt;
};

constexpr float root_of_sum(float a, float b, float c) {
  double s = static_cast<double>(a) * a + static_cast<double>(b) * b + static_cast<double>(c) * c, x = s;
  for (int n = 0; n < 60; ++n) x = 0.5 * (x + s / x);
  return static_cast<float>(x);
}

constexpr std::array<Triple, 10> all_triples() {
  std::array<Triple, 10> result{};
  int n = 0;
  for (int i = 0; i < 5; ++i)
    for (int j = i + 1; j < 5; ++j)
      for (int k = j + 1; k < 5; ++k) {
        Triple& t = result[static_cast<std::size_t>(n++)];
        t.i = i, t.j = j, t.k = k;
        const float at[3] = {static_cast<float>(i - 2), static_cast<float>(j - 2), static_cast<float>(k - 2)};
        const float raw[3] = {at[1] - at[2], at[2] - at[0], at[0] - at[1]};
        const float norm = root_of_sum(raw[0], raw[1], raw[2]);
        t.mean = (at[0] + at[1] + at[2]) / 3;
        float stt = 0;
        for (int m = 0; m < 3; ++m) stt += (at[m] - t.mean) * (at[m] - t.mean);
        t.inverse_stt = 1 / stt;
        for (int m = 0; m < 3; ++m) {
          t.contrast[m] = raw[m] / norm;
          t.slope[m] = (at[m] - t.mean) / stt;
          t.at_zero[m] = 1.F / 3 - t.slope[m] * t.mean;
        }
      }
  return result;
}

constexpr std::array<Triple, 10> triples = all_triples();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// A sample is accepted within 2.5 deviations of its prediction. Three samples alone tell next to nothing of the noise
/// (their sum of squares is the least of ten), so they count only where the surface bends too much for a line, and
/// never for more than three times the noise.
template <class F>
PARTSCRIBE_INLINE void lines_at(const std::array<const float*, 5>& samples, const float* sigma, int i,
                                const LineRow& out) {
  F z[5];
  for (std::size_t k = 0; k < 5; ++k) z[k] = load<F>(samples[k] + i);
  const F zero{}, one = zero + 1.F;
  F best = zero + std::numeric_limits<float>::infinity(), value = zero + nan, slope = zero, mean = zero, inverse = zero;
#pragma GCC unroll 10
  for (const Triple& t : triples) {
    const F b = z[t.j], left = z[t.i] - b, right = z[t.k] - b;
    const F e = t.contrast[0] * left + t.contrast[2] * right;
    const F sse = e * e;
    const auto better = sse < best;  // never true for NaN
    best = select(better, sse, best);
    value = select(better, b + (t.at_zero[0] * left + t.at_zero[2] * right), value);
    slope = select(better, t.slope[0] * left + t.slope[2] * right, slope);
    mean = select(better, zero + t.mean, mean);
    inverse = select(better, zero + t.inverse_stt, inverse);
  }
  const F own_noise = load<F>(sigma + i), noise = own_noise * own_noise;
  const F bent = best * (2.16F * 2.16F / 3), most = 9 * noise;
  // Three samples that lie on no line even so are accepted nowhere: where no others are, they would be on their own.
  const F level = select(bent < noise, noise, select(bent < most, bent, most));
  const F s2 = select(best > 6.25F * level, zero - 1.F, level);
  F m = zero, st = zero, stt = zero, sr = zero, str = zero, own = zero;
#pragma GCC unroll 5
  for (int k = 0; k < 5; ++k) {
    const float t = static_cast<float>(k - 2);
    const F r = z[k] - (value + slope * t);
    const F limit = 6.25F * s2 * (4.F / 3 + (t - mean) * (t - mean) * inverse);
    const auto accept = r * r <= limit;
    const F w = select(accept, one, zero), wr = select(accept, r, zero);
    m += w, st += w * t, stt += w * (t * t), sr += wr, str += wr * t;
    if (k == 2) own = w;
  }
  const F det = m * stt - st * st;
  const F inverse_det = 1.F / select(det > 0.F, det, one);
  store<F>(out.value + i, value + (stt * sr - st * str) * inverse_det);
  store<F>(out.slope + i, slope + (m * str - st * sr) * inverse_det);
  store<F>(out.variance + i, stt * inverse_det);
  store<F>(out.accepted + i, m);
  store<F>(out.middle + i, own);
}

PARTSCRIBE_INLINE void lines_body(const std::array<const float*, 5>& samples, const float* sigma, int count,
                                  const LineRow& out) {
  int i = 0;
  for (; i + width_of<Lanes> <= count; i += width_of<Lanes>) lines_at<Lanes>(samples, sigma, i, out);
  for (; i < count; ++i) lines_at<float>(samples, sigma, i, out);
}

/// Sums over samples, reduced to the plane through them.
template <class F>
struct PlaneSums {
  F n{}, x{}, y{}, xx{}, xy{}, yy{}, u{}, xu{}, yu{}, uu{};
};

template <class F>
struct PlaneFit {
  F value, slope_x, slope_y, variance, sse;  // variance 0: no plane
};

template <class F>
PARTSCRIBE_INLINE void plane_of(const PlaneSums<F>& s, PlaneFit<F>& f) {
  const F zero{}, one = zero + 1.F;
  const F inverse_n = 1.F / select(s.n > 0.F, s.n, one);
  const F mx = s.x * inverse_n, my = s.y * inverse_n, mu = s.u * inverse_n;
  const F cxx = s.xx - s.x * mx, cxy = s.xy - s.x * my, cyy = s.yy - s.y * my;
  const F cxu = s.xu - s.x * mu, cyu = s.yu - s.y * mu, cuu = s.uu - s.u * mu;
  const F det = cxx * cyy - cxy * cxy;
  const auto enough = det > 0.5F;
  const F inverse_det = 1.F / select(enough, det, one);
  f.slope_x = (cxu * cyy - cyu * cxy) * inverse_det;
  f.slope_y = (cyu * cxx - cxu * cxy) * inverse_det;
  f.value = mu - f.slope_x * mx - f.slope_y * my;
  const F variance = inverse_n + (mx * mx * cyy - 2 * (mx * my) * cxy + my * my * cxx) * inverse_det;
  f.variance = select(enough, variance, zero);
  const F sse = cuu - f.slope_x * cxu - f.slope_y * cyu;
  f.sse = select(sse > 0.F, sse, zero);
}

template <class F>
PARTSCRIBE_INLINE void facets_at(const std::array<const float*, 5>& heights, const std::array<const float*, 5>& weights,
                                 int i, const FacetRow& out) {
  const F middle = load<F>(heights[2] + i);
  PlaneSums<F> s;
#pragma GCC unroll 5
  for (int r = 0; r < 5; ++r)
#pragma GCC unroll 5
    for (int c = 0; c < 5; ++c) {
      const float x = static_cast<float>(c - 2), y = static_cast<float>(r - 2);
      const F w = load<F>(weights[static_cast<std::size_t>(r)] + i + c - 2);
      const F u = w * (load<F>(heights[static_cast<std::size_t>(r)] + i + c - 2) - middle);
      s.n += w;
      if (c != 2) s.x += w * x, s.xx += w * (x * x), s.xu += u * x;
      if (r != 2) s.y += w * y, s.yy += w * (y * y), s.yu += u * y;
      if (r != 2 && c != 2) s.xy += w * (x * y);
      s.u += u;
    }
  PlaneFit<F> f;
  plane_of(s, f);
  F sse{}, largest{}, bxx{}, byy{}, bxy{};
#pragma GCC unroll 5
  for (int r = 0; r < 5; ++r)
#pragma GCC unroll 5
    for (int c = 0; c < 5; ++c) {
      const float x = static_cast<float>(c - 2), y = static_cast<float>(r - 2);
      const F w = load<F>(weights[static_cast<std::size_t>(r)] + i + c - 2);
      const F u = load<F>(heights[static_cast<std::size_t>(r)] + i + c - 2) - middle;
      const F d = w * (u - (f.value + f.slope_x * x + f.slope_y * y));
      const F size = select(d < 0.F, -d, d);
      bxx += d * (x * x - 2), byy += d * (y * y - 2);
      if (r != 2 && c != 2) bxy += d * (x * y);
      sse += d * d;
      largest = select(size > largest, size, largest);
    }
  store<F>(out.value + i, f.value), store<F>(out.slope_x + i, f.slope_x), store<F>(out.slope_y + i, f.slope_y);
  store<F>(out.variance + i, f.variance), store<F>(out.count + i, s.n);
  store<F>(out.sse + i, sse), store<F>(out.largest + i, largest);
  store<F>(out.bend_xx + i, bxx * (1.F / 70)), store<F>(out.bend_yy + i, byy * (1.F / 70));
  store<F>(out.bend_xy + i, bxy * (1.F / 100));
}

PARTSCRIBE_INLINE void facets_body(const std::array<const float*, 5>& heights,
                                   const std::array<const float*, 5>& weights, int count, const FacetRow& out) {
  int i = 0;
  for (; i + width_of<Lanes> <= count; i += width_of<Lanes>) facets_at<Lanes>(heights, weights, i, out);
  for (; i < count; ++i) facets_at<float>(heights, weights, i, out);
}

template <class F>
PARTSCRIBE_INLINE void on_lines_at(const std::array<const float*, 5>& rows, float tolerance, int i, float* weight,
                                   float* height) {
  constexpr int step[4][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
  const F zero{}, one = zero + 1.F, limit = zero + tolerance;
  const F own = load<F>(rows[2] + i);
  F agrees = zero, asked = zero, nearest = zero + std::numeric_limits<float>::infinity(), between = zero;
#pragma GCC unroll 4
  for (int d = 0; d < 4; ++d) {
    const int down = step[d][0], right = step[d][1];
    const F before = load<F>(rows[static_cast<std::size_t>(2 - down)] + i - right),
            after = load<F>(rows[static_cast<std::size_t>(2 + down)] + i + right),
            first = load<F>(rows[static_cast<std::size_t>(2 - 2 * down)] + i - 2 * right),
            last = load<F>(rows[static_cast<std::size_t>(2 + 2 * down)] + i + 2 * right);
    // The second is right on parabolas, too; NaN, and so no line, where one is missing.
    const F mean = (before + after) * 0.5F, wide = mean + (mean - (first + last) * 0.5F) * (1.F / 3);
    const F off = mean - own, off_wide = wide - own, climb = before - after;
    const F size = select(off < zero, -off, off), size_wide = select(off_wide < zero, -off_wide, off_wide);
    const F apart = select(climb < zero, -climb, climb);
    agrees = select(size <= limit, one, agrees);
    agrees = select(size_wide <= limit, one, agrees);
    asked = select(mean == mean, one, asked);
    between = select(apart < nearest, mean, between);
    nearest = select(apart < nearest, apart, nearest);
  }
  const F kept = select(own == own, select(asked > zero, agrees, one), zero);
  store<F>(weight + i, kept);
  store<F>(height + i,
           select(kept > zero, own,
                  select(nearest < std::numeric_limits<float>::infinity(), between, select(own == own, own, zero))));
}

PARTSCRIBE_INLINE void on_lines_body(const std::array<const float*, 5>& rows, float tolerance, int count, float* weight,
                                     float* height) {
  int i = 0;
  for (; i + width_of<Lanes> <= count; i += width_of<Lanes>) on_lines_at<Lanes>(rows, tolerance, i, weight, height);
  for (; i < count; ++i) on_lines_at<float>(rows, tolerance, i, weight, height);
}

using SideMasks = std::array<std::array<float, side_count>, 25>;

SideMasks side_masks() {
  SideMasks masks{};
  for (int k = 0; k < 25; ++k)
    for (int j = 0; j < side_count; ++j)
      masks[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)] = on_side(j, k % 5 - 2, k / 5 - 2) ? 1.F : 0.F;
  return masks;
}

constexpr float far_cost = 7.5F;  // of a sample that the far side's plane does not explain: (2.5 sigma)^2 * 1.2
constexpr float own_limit = 7;    // chi^2 of the middle sample against the rest of its own side
constexpr float impossible = 1e9F;

/// One side per lane, from side j on. What is not near is far.
template <class F>
PARTSCRIBE_INLINE void split_at(const std::array<float, 25>& heights, const std::array<float, 25>& weights,
                                const SideMasks& masks, const PlaneSums<float>& all, int j, Sides& out) {
  PlaneSums<F> near, far;
  for (std::size_t k = 0; k < 25; ++k) {
    const float x = static_cast<float>(k % 5) - 2, y = static_cast<float>(k / 5) - 2;
    const F w = load<F>(masks[k].data() + j) * weights[k], h = w * heights[k];
    near.n += w, near.x += w * x, near.y += w * y, near.xx += w * (x * x), near.xy += w * (x * y);
    near.yy += w * (y * y), near.u += h, near.xu += h * x, near.yu += h * y, near.uu += h * heights[k];
  }
  far.n = all.n - near.n, far.x = all.x - near.x, far.y = all.y - near.y, far.xx = all.xx - near.xx;
  far.xy = all.xy - near.xy, far.yy = all.yy - near.yy, far.u = all.u - near.u, far.xu = all.xu - near.xu;
  far.yu = all.yu - near.yu, far.uu = all.uu - near.uu;
  const F zero{};
  PlaneFit<F> own, other;
  plane_of(near, own), plane_of(far, other);
  const F bound = far_cost * far.n;
  const F beyond = select(other.variance > 0.F, select(other.sse < bound, other.sse, bound), bound);
  // The middle's residual against the plane's prediction without it; a plane that hangs on the middle predicts nothing.
  const F any = own.sse + beyond;
  const F agreeing = select(own.value * own.value <= own_limit * (1.F - own.variance), any, zero + impossible);
  const F cost = weights[12] == 0 ? any : agreeing;
  const F usable = select(own.variance > 0.F, select(near.n > 5.5F, cost, zero + impossible), zero + impossible);
  const auto at = static_cast<std::size_t>(j);
  store<F>(&out.cost[at], usable);
  store<F>(&out.value[at], own.value), store<F>(&out.slope_x[at], own.slope_x);
  store<F>(&out.slope_y[at], own.slope_y), store<F>(&out.variance[at], own.variance);
  store<F>(&out.near_sse[at], own.sse), store<F>(&out.near_count[at], near.n);
}

PARTSCRIBE_INLINE void split_body(const std::array<float, 25>& heights, const std::array<float, 25>& weights,
                                  const SideMasks& masks, Sides& out) {
  PlaneSums<float> all;
  for (std::size_t k = 0; k < 25; ++k) {
    const float x = static_cast<float>(k % 5) - 2, y = static_cast<float>(k / 5) - 2;
    const float w = weights[k], h = w * heights[k];
    all.n += w, all.x += w * x, all.y += w * y, all.xx += w * (x * x), all.xy += w * (x * y), all.yy += w * (y * y);
    all.u += h, all.xu += h * x, all.yu += h * y, all.uu += h * heights[k];
  }
  for (int j = 0; j < side_count; j += width_of<Lanes>) split_at<Lanes>(heights, weights, masks, all, j, out);
}

#ifdef PARTSCRIBE_AVX2
PARTSCRIBE_AVX2 void lines_avx2(const std::array<const float*, 5>& samples, const float* sigma, int count,
                                const LineRow& out) {
  lines_body(samples, sigma, count, out);
}
PARTSCRIBE_AVX2 void facets_avx2(const std::array<const float*, 5>& heights, const std::array<const float*, 5>& weights,
                                 int count, const FacetRow& out) {
  facets_body(heights, weights, count, out);
}
PARTSCRIBE_AVX2 void on_lines_avx2(const std::array<const float*, 5>& rows, float tolerance, int count, float* weight,
                                   float* height) {
  on_lines_body(rows, tolerance, count, weight, height);
}
PARTSCRIBE_AVX2 void split_avx2(const std::array<float, 25>& heights, const std::array<float, 25>& weights,
                                const SideMasks& masks, Sides& out) {
  split_body(heights, weights, masks, out);
}
#endif

}  // namespace

void trimmed_lines(const std::array<const float*, 5>& samples, const float* sigma, int count, const LineRow& out) {
#ifdef PARTSCRIBE_AVX2
  if (has_avx2()) return lines_avx2(samples, sigma, count, out);
#endif
  lines_body(samples, sigma, count, out);
}

void facets(const std::array<const float*, 5>& heights, const std::array<const float*, 5>& weights, int count,
            const FacetRow& out) {
#ifdef PARTSCRIBE_AVX2
  if (has_avx2()) return facets_avx2(heights, weights, count, out);
#endif
  facets_body(heights, weights, count, out);
}

void samples_on_lines(const std::array<const float*, 5>& rows, float tolerance, int count, float* weight,
                      float* height) {
#ifdef PARTSCRIBE_AVX2
  if (has_avx2()) return on_lines_avx2(rows, tolerance, count, weight, height);
#endif
  on_lines_body(rows, tolerance, count, weight, height);
}

bool on_side(int side, int x, int y) {
  constexpr int direction[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
  if (side < 16) {
    const auto& d = direction[side / 2];
    return d[0] * x + d[1] * y <= side % 2;
  }
  const int quadrant = (side - 16) / 2, reach = side % 2;
  return (quadrant % 2 ? -x : x) <= reach && (quadrant / 2 ? -y : y) <= reach;
}

void split_window(const std::array<float, 25>& heights, const std::array<float, 25>& weights, Sides& out) {
  static const SideMasks masks = side_masks();
#ifdef PARTSCRIBE_AVX2
  if (has_avx2()) return split_avx2(heights, weights, masks, out);
#endif
  split_body(heights, weights, masks, out);
}

}  // namespace partscribe::geometry
