#include "geometry/images/rlts_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/images/curvature_map.h"
#include "geometry/images/range_heights.h"
#include "geometry/images/range_noise.h"
#include "geometry/images/trimmed_window.h"
#include "geometry/images/window_facet.h"
#include "geometry/images/window_kernels.h"

namespace partscribe::geometry {
namespace {

using Grid = PaddedGrid<float>;

std::size_t index_of(const RangeHeights& h, int r, int c) {
  return static_cast<std::size_t>(r) * static_cast<std::size_t>(h.width) + static_cast<std::size_t>(c);
}

/// Calls body(row) for every row of the image.
template <class Body>
void each_row(const RangeHeights& h, Context& context, const Body& body) {
  parallel_for(
      static_cast<std::size_t>(h.height_px), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) body(static_cast<int>(r));
      },
      8);
}

/// One line per pixel of a row, in one direction.
struct Lines {
  explicit Lines(int width)
      : value(static_cast<std::size_t>(width)), slope(value), variance(value), accepted(value), middle(value) {}
  LineRow out() { return {value.data(), slope.data(), variance.data(), accepted.data(), middle.data()}; }
  std::vector<float> value, slope, variance, accepted, middle;
};

void lines_along(const RangeHeights& h, const Grid& sigma, int row, int down, int right, Lines& lines) {
  std::array<const float*, 5> samples{};
  for (int k = -2; k <= 2; ++k) samples[static_cast<std::size_t>(k + 2)] = h.grid.row(row + k * down) + k * right;
  trimmed_lines(samples, sigma.row(row), h.width, lines.out());
}

/// Which pixels lie on the trimmed line of any direction: 1 or 0.
struct Screen {
  Screen(int width, int height) : kept(width, height, 0), firm(kept) {}
  Grid kept;
  Grid firm;  ///< on a line of four: three can meet by chance
};

/// In the first `directions` of four directions.
Screen screened(const RangeHeights& h, const Grid& sigma, int directions, Context& context) {
  constexpr std::array<std::pair<int, int>, 4> steps = {{{0, 1}, {1, 0}, {1, 1}, {1, -1}}};
  Screen screen(h.width, h.height_px);
  each_row(h, context, [&](int r) {
    Lines lines(h.width);
    float *kept = screen.kept.row(r), *firm = screen.firm.row(r);
    for (int d = 0; d < directions; ++d) {
      const auto& [down, right] = steps[static_cast<std::size_t>(d)];
      lines_along(h, sigma, r, down, right, lines);
      for (std::size_t c = 0; c < lines.middle.size(); ++c) {
        kept[c] = std::max(kept[c], lines.middle[c]);
        firm[c] = std::max(firm[c], lines.accepted[c] > 3 ? lines.middle[c] : 0.F);
      }
    }
  });
  return screen;
}

/// The least-squares planes of all 5x5 windows.
struct Planes {
  Planes(int width, int height)
      : value(width, height, 0),
        slope_x(value),
        slope_y(value),
        variance(value),
        count(value),
        sse(value),
        largest(value),
        bend_xx(value),
        bend_yy(value),
        bend_xy(value) {}
  Bend bend(int r, int c) const { return {bend_xx.row(r)[c], bend_yy.row(r)[c], bend_xy.row(r)[c]}; }
  FacetRow out(int r) {
    return {value.row(r), slope_x.row(r), slope_y.row(r), variance.row(r), count.row(r),
            sse.row(r),   largest.row(r), bend_xx.row(r), bend_yy.row(r),  bend_xy.row(r)};
  }
  Grid value, slope_x, slope_y, variance, count, sse, largest, bend_xx, bend_yy, bend_xy;
};

/// Heights with 0 for what is missing, as planes want them.
Grid finite(const RangeHeights& h) {
  Grid result(h.width, h.height_px, 0);
  for (int r = 0; r < h.height_px; ++r)
    for (int c = 0; c < h.width; ++c)
      if (!std::isnan(h.grid.row(r)[c])) result.row(r)[c] = h.grid.row(r)[c];
  return result;
}

void fit_planes(const RangeHeights& h, const Grid& heights, const Grid& kept, Planes& planes, Context& context) {
  each_row(h, context, [&](int r) {
    std::array<const float*, 5> z{}, w{};
    for (int k = -2; k <= 2; ++k)
      z[static_cast<std::size_t>(k + 2)] = heights.row(r + k), w[static_cast<std::size_t>(k + 2)] = kept.row(r + k);
    facets(z, w, h.width, planes.out(r));
  });
}

/// Slope and incidence at each pixel from that window around it which is most like a plane: none of them reaches
/// across an edge if one does not (Kuwahara's choice).
struct Slopes {
  Slopes(int width, int height) : x(width, height, 0), y(x), incidence(x), down(width, height, 0), right(down) {}
  Grid x, y, incidence;
  PaddedGrid<std::int8_t> down, right;  ///< from the pixel to that window's middle
};

Slopes slopes_of(const RangeHeights& h, const Planes& planes, Context& context) {
  static constexpr std::array<std::pair<int, int>, 9> offsets = {
      {{0, 0}, {-2, -2}, {-2, 2}, {2, -2}, {2, 2}, {-2, 0}, {2, 0}, {0, -2}, {0, 2}}};
  Slopes slopes(h.width, h.height_px);
  each_row(h, context, [&](int r) {
    for (int c = 0; c < h.width; ++c) {
      const float height = h.grid.row(r)[c];
      if (std::isnan(height)) continue;
      float best = std::numeric_limits<float>::infinity(), x = 0, y = 0;
      for (const auto& [dr, dc] : offsets) {
        if (r + dr < 0 || r + dr >= h.height_px) continue;
        const float count = planes.count.row(r + dr)[c + dc];
        if (!(planes.variance.row(r + dr)[c + dc] > 0) || count < 6) continue;
        const float score = planes.sse.row(r + dr)[c + dc] / (count - 3);
        if (!(score < best)) continue;
        best = score, x = planes.slope_x.row(r + dr)[c + dc], y = planes.slope_y.row(r + dr)[c + dc];
        slopes.down.row(r)[c] = static_cast<std::int8_t>(dr), slopes.right.row(r)[c] = static_cast<std::int8_t>(dc);
      }
      slopes.x.row(r)[c] = x, slopes.y.row(r)[c] = y;
      slopes.incidence.row(r)[c] = static_cast<float>(std::min(h.incidence(r, c, height, x, y), 100.0));
    }
  });
  return slopes;
}

/// Noise of every sample in heights.
Grid noise_map(const RangeHeights& h, const RangeNoise& noise, const Grid* incidence) {
  Grid sigma(h.width, h.height_px, 1);
  for (int r = 0; r < h.height_px; ++r)
    for (int c = 0; c < h.width; ++c) {
      const float height = h.grid.row(r)[c];
      if (std::isnan(height)) continue;
      const double mm = noise.sigma(incidence ? incidence->row(r)[c] : 1);
      sigma.row(r)[c] = static_cast<float>(std::max(mm / h.mm_per_height(height), 1e-6));
    }
  return sigma;
}

/// Upper limit of chi^2, some 99.9 %.
float chi2_limit(float freedom) { return freedom + 3.1F * std::sqrt(2 * freedom) + 4; }

/// Residuals from the plane of a whole window beyond this many deviations are no noise.
constexpr float acceptance = 4;

enum class Fitness : std::uint8_t { none, plane, quadric, broken };

/// Whether one plane, or one quadric, explains a window.
Fitness fitness(const Planes& p, int r, int c, float sigma) {
  const float inverse = 1 / (sigma * sigma), chi2 = p.sse.row(r)[c] * inverse, count = p.count.row(r)[c];
  if (!(p.variance.row(r)[c] > 0)) return Fitness::none;
  if (chi2 <= chi2_limit(count - 3) && p.largest.row(r)[c] <= acceptance * sigma) return Fitness::plane;
  if (count < 25) return Fitness::broken;
  const float gain = p.bend(r, c).evidence() * inverse;
  return gain > significant_bend && chi2 - gain <= chi2_limit(count - 6) ? Fitness::quadric : Fitness::broken;
}

/// The bend of every smooth window as the curvature of a surface.
CurvatureGrids window_curvatures(const RangeHeights& h, const Planes& p, const PaddedGrid<Fitness>& fit,
                                 const Grid& sigma) {
  CurvatureGrids one(h.width, h.height_px);
  for (int r = 0; r < h.height_px; ++r)
    for (int c = 0; c < h.width; ++c) {
      if (p.count.row(r)[c] < 25 || (fit.row(r)[c] != Fitness::plane && fit.row(r)[c] != Fitness::quadric)) continue;
      const float height = h.grid.row(r)[c];
      const Tilt tilt = h.tilt(r, c, height, p.slope_x.row(r)[c], p.slope_y.row(r)[c]);
      const Bend k = curvature_of(p.bend(r, c), tilt);
      const float frontal = 1 / (tilt.secant * tilt.secant), s = sigma.row(r)[c];
      one.xx.row(r)[c] = k.xx, one.yy.row(r)[c] = k.yy, one.xy.row(r)[c] = k.xy;
      one.variance.row(r)[c] = s * s * frontal * frontal * frontal, one.count.row(r)[c] = 1;
    }
  return one;
}

/// Kept samples above the middle one less slope and bend, in noise levels.
void gather(const Grid& heights, const Grid& kept, int r, int c, float slope_x, float slope_y, const BentSurface& shape,
            float sigma, Window& u, Window& w) {
  constexpr float reach = 50;  // beyond it a sample is on another surface however far
  const float middle = heights.row(r)[c], inverse = 1 / sigma;
  for (int y = -2; y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      const auto k = static_cast<std::size_t>((y + 2) * 5 + x + 2);
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      const float trend = slope_x * fx + slope_y * fy + shape.at(fx, fy);
      u[k] = std::clamp((heights.row(r + y)[c + x] - middle - trend) * inverse, -reach, reach);
      w[k] = kept.row(r + y)[c + x];
    }
}

constexpr float steepest = 52;  // 1 / cos^2 of 82 degrees

/// The bend at a pixel; next to an edge, that of the surface to which it belongs.
KnownBend bend_at(const CurvatureMap& curvatures, const Slopes& slopes, int r, int c, const Tilt& tilt) {
  if (curvatures.known(r, c)) return curvatures.at(r, c, tilt);
  return curvatures.at(r + slopes.down.row(r)[c], c + slopes.right.row(r)[c], tilt);
}

/// The value of one pixel from its window.
struct Fitter {
  const RangeHeights& h;
  const Grid& heights;
  const Screen& screen;
  const Planes& planes;
  const Slopes& slopes;
  const CurvatureMap& curvatures;

  /// Of a window that a plane or a quadric explains.
  WindowFacet smooth(int r, int c, float sigma, Fitness how) const {
    WindowFacet f{planes.value.row(r)[c],    planes.slope_x.row(r)[c], planes.slope_y.row(r)[c],
                  planes.variance.row(r)[c], RltsModel::plane,         planes.sse.row(r)[c] / (sigma * sigma)};
    const Tilt tilt = h.tilt(r, c, h.grid.row(r)[c], f.slope_x, f.slope_y);
    const KnownBend bend = bend_at(curvatures, slopes, r, c, tilt);
    if (how == Fitness::quadric && !explains(bend.shape, r, c, sigma)) return broken(r, c, sigma);
    f.doubt = bend.doubt + hidden(planes.bend(r, c) - bend.shape.second_order(), sigma);
    if (bend.shape.flat()) return f;
    if (planes.count.row(r)[c] < 25 || bend.far_steeper)
      return better(f, bent(f, bend, r, c, sigma), bend.far_steeper, sigma);
    // Where it ends within the window no arc is right.
    if (std::abs(f.value - bend.shape.mean()) > acceptance * sigma) return broken(r, c, sigma);
    f.value -= bend.shape.mean();
    f.slope_x -= bend.shape.steepening() * tilt.x, f.slope_y -= bend.shape.steepening() * tilt.y;
    f.variance += bend.variance, f.model = RltsModel::quadric;
    return f;
  }

  /// Of a window that needs the long way.
  WindowFacet broken(int r, int c, float sigma) const {
    const float sx = slopes.x.row(r)[c], sy = slopes.y.row(r)[c], height = h.grid.row(r)[c];
    const KnownBend there = bend_at(curvatures, slopes, r, c, h.tilt(r, c, height, sx, sy));
    if (there.shape.flat()) return facet(r, c, sx, sy, {}, sigma);
    // From the middle of the window that tells the slope to here.
    const auto [turn_x, turn_y] =
        there.shape.slope(static_cast<float>(-slopes.right.row(r)[c]), static_cast<float>(-slopes.down.row(r)[c]));
    const KnownBend here = bend_at(curvatures, slopes, r, c, h.tilt(r, c, height, sx + turn_x, sy + turn_y));
    WindowFacet f = facet(r, c, sx + turn_x, sy + turn_y, here.shape, sigma);
    if (f.model == RltsModel::plane) f.doubt += here.variance + here.doubt;
    if (!there.far_steeper && !here.far_steeper) return f;
    return better(facet(r, c, sx, sy, {}, sigma), f, true, sigma);
  }

 private:
  /// What a window bends otherwise than its surroundings is noise, or a crease passes.
  static float hidden(const Bend& own, float sigma) {
    constexpr float price = 10;
    return hidden_variance({own.xx / sigma, own.yy / sigma, own.xy / sigma}, price);
  }

  /// Whether a window bends as its surroundings do. One that lies on a crease may pass for a quadric of its own.
  bool explains(const BentSurface& shape, int r, int c, float sigma) const {
    const Bend own = planes.bend(r, c);
    const float without = own.evidence(), with = (own - shape.second_order()).evidence();
    return (planes.sse.row(r)[c] - without + with) / (sigma * sigma) <= chi2_limit(planes.count.row(r)[c] - 3);
  }

  /// A plane through part of a window, less the bend of its surroundings.
  WindowFacet bent(WindowFacet f, KnownBend bend, int r, int c, float sigma) const {
    // The slope hangs on the bend, and so does the bend on the slope.
    for (int round = 0; round < 2; ++round) {
      if (round > 0) bend = bend_at(curvatures, slopes, r, c, h.tilt(r, c, h.grid.row(r)[c], f.slope_x, f.slope_y));
      Window u, w;
      gather(heights, screen.kept, r, c, f.slope_x, f.slope_y, bend.shape, sigma, u, w);
      const WindowFit rest = plane_fit(u, w);
      f.value = rest.facet.value * sigma, f.cost = rest.sse;
      f.slope_x += rest.facet.slope_x * sigma, f.slope_y += rest.facet.slope_y * sigma;
      f.variance = planes.variance.row(r)[c] + bend.variance;
    }
    f.model = RltsModel::quadric;
    return f;
  }

  WindowFacet facet(int r, int c, float slope_x, float slope_y, const BentSurface& shape, float sigma) const {
    Window u, w;
    gather(heights, screen.kept, r, c, slope_x, slope_y, shape, sigma, u, w);
    WindowFacet f = window_facet(u, w, screen.firm.row(r)[c] != 0);
    f.value *= sigma;
    f.slope_x = f.slope_x * sigma + slope_x, f.slope_y = f.slope_y * sigma + slope_y;
    return f;
  }

  /// A bend from less steep places beside may be that of another face: then the samples have to ask for it. What they
  /// do not tell makes the value uncertain.
  static WindowFacet better(const WindowFacet& flat, const WindowFacet& bent, bool doubtful, float sigma) {
    const float gain = flat.cost - bent.cost;
    if (bent.model == RltsModel::raw || gain < -significant_bend) return flat;
    if (!doubtful || gain > significant_bend) return bent;
    WindowFacet either = flat;
    const float off = (flat.value - bent.value) / sigma;
    either.variance += 0.25F * off * off;
    return either;
  }
};

FilteredImage empty_result(const RangeImage& image) {
  FilteredImage result;
  result.width = image.width, result.height = image.height;
  const std::size_t n = image.codes.size();
  result.depth.assign(n, std::numeric_limits<double>::quiet_NaN());
  result.sigma.assign(n, 0), result.raw_sigma.assign(n, 0), result.doubt.assign(n, 0);
  result.slope_column.assign(n, 0), result.slope_row.assign(n, 0);
  result.kept.assign(n, 0);
  result.model.assign(n, RltsModel::none);
  return result;
}

/// Writes one pixel; `facet` is in heights above the sample, its variance in units of the noise squared.
void put(const RangeHeights& h, int r, int c, const WindowFacet& facet, float sigma, FilteredImage& out) {
  const std::size_t i = index_of(h, r, c);
  const double raw = h.grid.row(r)[c], value = raw + static_cast<double>(facet.value);
  const double scale = h.mm_per_height(value);
  out.depth[i] = h.depth(value);
  out.raw_sigma[i] = static_cast<float>(sigma * scale);
  out.sigma[i] = static_cast<float>(std::sqrt(facet.variance) * sigma * scale);
  out.doubt[i] = static_cast<float>(std::sqrt(facet.doubt) * sigma * scale);
  out.slope_column[i] = static_cast<float>(facet.slope_x * scale);
  out.slope_row[i] = static_cast<float>(facet.slope_y * scale);
  out.model[i] = facet.model;
  out.kept[i] = facet.model != RltsModel::rejected;
}

constexpr WindowFacet rejected_facet{0, 0, 0, 1, RltsModel::rejected};

/// A sample that lies on the surfaces of two or more pixels beside it, one of them known well: the mean of its own
/// height and what they predict, with the slope of the one known best; rejected if there are none. Where a bent edge
/// passes, or three faces meet, no two planes explain its own window, but one of theirs may hold it.
WindowFacet continued(const RangeHeights& h, const FilteredImage& out, int r, int c, float sigma) {
  constexpr double limit = 3;  // deviations
  constexpr int enough = 2;
  constexpr double well_known = 0.55;  // of the noise: surfaces of a handful of samples can be drawn through anything
  const double own = h.grid.row(r)[c], noise = sigma;
  int agreeing = 0;
  double least = well_known, weight = 0, mean = 0, square = 0;
  WindowFacet best = rejected_facet;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      if (r + y < 0 || c + x < 0 || r + y >= h.height_px || c + x >= h.width) continue;
      const std::size_t i = index_of(h, r + y, c + x);
      const RltsModel model = out.model[i];
      if (model != RltsModel::plane && model != RltsModel::quadric && model != RltsModel::side) continue;
      const double there = h.height(out.depth[i]), scale = h.mm_per_height(there);
      const double slope_x = out.slope_column[i] / scale, slope_y = out.slope_row[i] / scale;
      const double off = (there - x * slope_x - y * slope_y - own) / noise, known_to = out.sigma[i] / scale / noise;
      if (std::abs(off) > limit * std::hypot(1, known_to)) continue;
      ++agreeing;
      const double w = 1 / (known_to * known_to);
      weight += w, mean += w * off, square += w * off * off;
      const double share = out.sigma[i] / out.raw_sigma[i];
      if (share > least) continue;
      least = share;
      best = {0, static_cast<float>(slope_x), static_cast<float>(slope_y), static_cast<float>(2 * known_to * known_to),
              RltsModel::side};
    }
  if (agreeing < enough || best.model == RltsModel::rejected) return rejected_facet;
  mean /= weight;
  const double variance = best.variance + square / weight - mean * mean, share = 1 / (1 + variance);
  best.value = static_cast<float>(share * mean * noise), best.variance = static_cast<float>(share * variance);
  return best;
}

/// The bit whose flip brings a rejected code back to the surface around it; -1 if there is none.
int flipped_bit(const RangeImage& image, const RangeHeights& h, const Planes& planes, int r, int c, float sigma) {
  if (planes.count.row(r)[c] < 8 || fitness(planes, r, c, sigma) != Fitness::plane) return -1;
  const double expected = h.depth(static_cast<double>(h.grid.row(r)[c]) + static_cast<double>(planes.value.row(r)[c]));
  const double limit = 3 * static_cast<double>(sigma) * h.mm_per_height(h.height(expected));
  const int code = image.codes[index_of(h, r, c)];
  int best = -1;
  double least = limit;
  for (int bit = 0; bit < 16; ++bit) {
    const double off = std::abs(image.z0 + image.q * ((code ^ (1 << bit)) - 1) - expected);
    if (off <= least) least = off, best = bit;
  }
  return best;
}

void count(const RangeImage& image, const RangeHeights& h, const Planes* planes, const Grid* sigma,
           FilteredImage& out) {
  out.returns = h.returns;
  for (int r = 0; r < h.height_px; ++r)
    for (int c = 0; c < h.width; ++c) {
      const std::size_t i = index_of(h, r, c);
      if (out.model[i] == RltsModel::none || out.kept[i]) continue;
      ++out.rejected;
      if (!planes) continue;
      if (const int bit = flipped_bit(image, h, *planes, r, c, sigma->row(r)[c]); bit >= 0)
        ++out.bit_errors[static_cast<std::size_t>(bit)];
    }
}

FilteredImage combined(const RangeImage& image, const RangeHeights& h, const RltsOptions& options, Context& context) {
  FilteredImage out = empty_result(image);
  const Grid heights = finite(h);
  const bool known = options.sigma > 0;
  out.noise = known ? RangeNoise{options.sigma, 0} : even_noise(h);
  Grid sigma = noise_map(h, out.noise, nullptr);
  // Two directions are enough to learn slopes and noise.
  Screen screen = screened(h, sigma, known ? 4 : 2, context);
  Planes planes(h.width, h.height_px);
  fit_planes(h, heights, screen.kept, planes, context);
  const Slopes slopes = slopes_of(h, planes, context);
  if (!known) {
    out.noise = sloped_noise(h, screen.kept, slopes.incidence);
    sigma = noise_map(h, out.noise, &slopes.incidence);
    screen = screened(h, sigma, 4, context);
    fit_planes(h, heights, screen.kept, planes, context);
  }
  PaddedGrid<Fitness> fit(h.width, h.height_px, Fitness::none);
  each_row(h, context, [&](int r) {
    for (int c = 0; c < h.width; ++c)
      if (!std::isnan(h.grid.row(r)[c])) fit.row(r)[c] = fitness(planes, r, c, sigma.row(r)[c]);
  });
  const CurvatureMap curvatures(h, window_curvatures(h, planes, fit, sigma), sigma);
  const Fitter fitter{h, heights, screen, planes, slopes, curvatures};
  PaddedGrid<std::uint8_t> unexplained(h.width, h.height_px, 0);
  each_row(h, context, [&](int r) {
    for (int c = 0; c < h.width; ++c) {
      if (std::isnan(h.grid.row(r)[c])) continue;
      const float s = sigma.row(r)[c];
      WindowFacet facet = rejected_facet;
      if (screen.kept.row(r)[c] != 0) {
        const bool smooth = fit.row(r)[c] == Fitness::plane || fit.row(r)[c] == Fitness::quadric;
        facet = smooth ? fitter.smooth(r, c, s, fit.row(r)[c]) : fitter.broken(r, c, s);
        // A sample that agrees with no surface around it has only met three others in a line.
        const bool alone = facet.model == RltsModel::raw && planes.count.row(r)[c] > 6;
        unexplained.row(r)[c] = alone;
        // Nor does anything return from a surface so steep: it bridges a step.
        if (alone || h.incidence(r, c, h.grid.row(r)[c], facet.slope_x, facet.slope_y) > steepest)
          facet = rejected_facet;
      }
      put(h, r, c, facet, s, out);
    }
  });
  // Only pixels with a surface of their own are asked: all are, before any is changed.
  std::vector<std::vector<std::pair<int, WindowFacet>>> found(static_cast<std::size_t>(h.height_px));
  each_row(h, context, [&](int r) {
    for (int c = 0; c < h.width; ++c)
      if (unexplained.row(r)[c])
        found[static_cast<std::size_t>(r)].emplace_back(c, continued(h, out, r, c, sigma.row(r)[c]));
  });
  for (int r = 0; r < h.height_px; ++r)
    for (const auto& [c, facet] : found[static_cast<std::size_t>(r)]) put(h, r, c, facet, sigma.row(r)[c], out);
  count(image, h, &planes, &sigma, out);
  return out;
}

/// The paper's profile filter: five samples of a row.
FilteredImage profiles(const RangeImage& image, const RangeHeights& h, const RltsOptions& options, Context& context) {
  FilteredImage out = empty_result(image);
  out.noise = options.sigma > 0 ? RangeNoise{options.sigma, 0} : even_noise(h);
  const Grid sigma = noise_map(h, out.noise, nullptr);
  each_row(h, context, [&](int r) {
    Lines lines(h.width);
    lines_along(h, sigma, r, 0, 1, lines);
    for (int c = 0; c < h.width; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (std::isnan(h.grid.row(r)[c])) continue;
      WindowFacet f = rejected_facet;
      // The paper's filter replaces every sample by its line, an outlier too.
      if (lines.accepted[i] >= 3)
        f = {lines.value[i] - h.grid.row(r)[c], lines.slope[i], 0, lines.variance[i], RltsModel::line};
      put(h, r, c, f, sigma.row(r)[c], out);
      if (lines.middle[i] == 0) out.kept[index_of(h, r, c)] = 0;
    }
  });
  count(image, h, nullptr, nullptr, out);
  return out;
}

/// The paper's window filters.
FilteredImage windows(const RangeImage& image, const RangeHeights& h, const RltsOptions& options, Context& context) {
  FilteredImage out = empty_result(image);
  out.noise = options.sigma > 0 ? RangeNoise{options.sigma, 0} : even_noise(h);
  const Grid sigma = noise_map(h, out.noise, nullptr), heights = finite(h);
  Grid present(h.width, h.height_px, 0);
  for (int r = 0; r < h.height_px; ++r)
    for (int c = 0; c < h.width; ++c) present.row(r)[c] = std::isnan(h.grid.row(r)[c]) ? 0.F : 1.F;
  each_row(h, context, [&](int r) {
    Window u, w;
    for (int c = 0; c < h.width; ++c) {
      if (present.row(r)[c] == 0) continue;
      const float s = sigma.row(r)[c], inverse = 1 / s;
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
          const auto k = static_cast<std::size_t>((y + 2) * 5 + x + 2);
          u[k] = (heights.row(r + y)[c + x] - heights.row(r)[c]) * inverse, w[k] = present.row(r + y)[c + x];
        }
      const TrimmedWindow t = trimmed_window(u, w, options.form == RltsForm::quadric);
      WindowFacet f = t.facet;
      f.value *= s, f.slope_x *= s, f.slope_y *= s;
      put(h, r, c, f, s, out);
      out.kept[index_of(h, r, c)] = t.middle;
    }
  });
  count(image, h, nullptr, nullptr, out);
  return out;
}

}  // namespace

FilteredImage rlts_filter(const RangeImage& image, const RltsOptions& options, Context& context) {
  ensure(image.codes.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
         "a range image has one code per pixel");
  const RangeHeights heights(image);
  if (heights.returns == 0) return empty_result(image);
  if (options.form == RltsForm::profile) return profiles(image, heights, options, context);
  if (options.form != RltsForm::combined) return windows(image, heights, options, context);
  return combined(image, heights, options, context);
}

double detectable_share(int bit, double q, double sigma) {
  const double off = std::ldexp(q, bit) / sigma, limit = acceptance;
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); };
  return 1 - (below(limit - off) - below(-limit - off));
}

}  // namespace partscribe::geometry
