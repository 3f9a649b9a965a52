#include "geometry/images/deriche.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/ensure.h"

namespace partscribe::geometry {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Both directions of a second-order recursion over a run; out = forward + backward. The letters are Deriche's.
struct Recursion {
  double a0, a1, a2, a3;  // forward: a0 x[i] + a1 x[i - 1]; backward: a2 x[i + 1] + a3 x[i + 2]
  double b1, b2;
};

Recursion derivative_of(double alpha) {
  const double e = std::exp(-alpha), c = (1 - e) * (1 - e) * (1 - e) / (2 * (1 + e));
  return {0, -c, c, 0, 2 * e, -e * e};
}

Recursion smoother_of(double alpha) {
  const double e = std::exp(-alpha), k = (1 - e) * (1 - e) / (1 + 2 * alpha * e - e * e);
  return {k, k * e * (alpha - 1), k * e * (alpha + 1), -k * e * e, 2 * e, -e * e};
}

/// A run with `memory` values more at both ends: turned about its end values, so that a ramp stays one.
std::vector<double> extended(const std::vector<double>& run, int memory) {
  const int n = static_cast<int>(run.size());
  std::vector<double> x(static_cast<std::size_t>(n + 2 * memory), run.front());
  double* first = x.data() + memory;
  std::copy(run.begin(), run.end(), first);
  for (int m = 1; m <= memory && n > 1; ++m) {  // each uses what the one before has written
    first[-m] = 2 * first[0] - first[m];
    first[n - 1 + m] = 2 * first[n - 1] - first[n - 1 - m];
  }
  return x;
}

/// Filters one run in place. It goes on beyond its ends for as long as the recursion remembers, and starts there in
/// steady state.
void filter_run(std::vector<double>& run, const Recursion& f, int memory) {
  const std::vector<double> x = extended(run, memory);
  std::vector<double> forward(x), backward(x);
  const double rest = 1 - f.b1 - f.b2;
  double y1 = (f.a0 + f.a1) * x.front() / rest, y2 = y1, x1 = x.front();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double y = f.a0 * x[i] + f.a1 * x1 + f.b1 * y1 + f.b2 * y2;
    forward[i] = y, x1 = x[i], y2 = y1, y1 = y;
  }
  double x2 = x.back();
  x1 = x2, y1 = y2 = (f.a2 + f.a3) * x2 / rest;
  for (std::size_t i = x.size(); i-- > 0;) {
    const double y = f.a2 * x1 + f.a3 * x2 + f.b1 * y1 + f.b2 * y2;
    backward[i] = y, x2 = x1, x1 = x[i], y2 = y1, y1 = y;
  }
  for (std::size_t k = 0; k < run.size(); ++k) {
    const std::size_t i = k + static_cast<std::size_t>(memory);
    run[k] = forward[i] + backward[i];
  }
}

int memory_of(double alpha) { return static_cast<int>(std::ceil(8 / alpha)) + 2; }

/// Filters every run of every row (`down` false) or column.
std::vector<double> filtered_lines(const std::vector<double>& values, int width, int height, bool down,
                                   const Recursion& f, int memory) {
  std::vector<double> result(values.size(), none);
  const auto w = static_cast<std::size_t>(width);
  const int lines = down ? width : height, length = down ? height : width;
  const std::size_t step = down ? w : 1;
  std::vector<double> run;
  for (int line = 0; line < lines; ++line) {
    const std::size_t start = static_cast<std::size_t>(line) * (down ? 1 : w);
    run.clear();
    for (int k = 0; k <= length; ++k) {
      const std::size_t i = start + static_cast<std::size_t>(k) * step;
      if (k < length && !std::isnan(values[i])) {
        run.push_back(values[i]);
        continue;
      }
      if (run.empty()) continue;
      filter_run(run, f, memory);
      for (std::size_t j = 0; j < run.size(); ++j) result[i - (run.size() - j) * step] = run[j];
      run.clear();
    }
  }
  return result;
}

/// What white noise of deviation 1 becomes: the norm of the response to one sample, after `times` passes.
double noise_gain(const Recursion& f, int memory, int times) {
  std::vector<double> response(static_cast<std::size_t>(4 * memory * times + 1), 0);
  response[response.size() / 2] = 1;
  for (int k = 0; k < times; ++k) filter_run(response, f, memory);
  double sum = 0;
  for (const double v : response) sum += v * v;
  return std::sqrt(sum);
}

/// A signed quantity with a direction at every pixel.
struct Field {
  int width = 0, height = 0;
  /// The quantity at a pixel in the direction (dx, dy); NaN where there is none.
  std::function<double(std::size_t pixel, double dx, double dy)> along;
};

/// How far |value| at (r, c) in direction (dx, dy) stands out from both sides; 0 if it is no ridge or if more than
/// `most_beside` of it is found beside it.
double prominence(const Field& field, int r, int c, double dx, double dy, double most_beside) {
  constexpr int aside = 4;  // pixels; wider than what the filter makes of a step
  const auto size_at = [&](int k) {
    const int row = r + static_cast<int>(std::lround(k * dy)), column = c + static_cast<int>(std::lround(k * dx));
    if (row < 0 || column < 0 || row >= field.height || column >= field.width) return none;
    return std::abs(field.along(
        static_cast<std::size_t>(row) * static_cast<std::size_t>(field.width) + static_cast<std::size_t>(column), dx,
        dy));
  };
  const double own = size_at(0);
  double beside = 0;
  for (const int side : {-1, 1}) {
    const double next = size_at(side), far = size_at(side * aside);
    if (std::isnan(next) || std::isnan(far) || next > own) return 0;
    beside = std::max(beside, far);
  }
  return beside <= most_beside * own ? own - beside : 0;
}

/// Pixels above `low` that are connected to one above `high`.
std::vector<std::uint8_t> hysteresis(const std::vector<double>& strength, int width, int height, double low,
                                     double high) {
  std::vector<std::uint8_t> chosen(strength.size(), 0);
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < strength.size(); ++i)
    if (strength[i] > high) chosen[i] = 1, open.push_back(i);
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    const int r = static_cast<int>(i / static_cast<std::size_t>(width)),
              c = static_cast<int>(i % static_cast<std::size_t>(width));
    for (int y = std::max(r - 1, 0); y <= std::min(r + 1, height - 1); ++y)
      for (int x = std::max(c - 1, 0); x <= std::min(c + 1, width - 1); ++x) {
        const std::size_t j =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        if (chosen[j] || !(strength[j] > low)) continue;
        chosen[j] = 1;
        open.push_back(j);
      }
  }
  return chosen;
}

/// Raw depths of kept pixels; a rejected pixel between two kept ones is their mean.
std::vector<double> depths(const RangeImage& image, const FilteredImage& filtered) {
  std::vector<double> z(filtered.depth.size(), none);
  for (std::size_t i = 0; i < z.size(); ++i)
    if (filtered.kept[i]) z[i] = image.z0 + image.q * (static_cast<double>(image.codes[i]) - 1);
  const std::vector<double> seen = z;
  const auto w = static_cast<std::size_t>(image.width);
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (filtered.model[i] == RltsModel::none || filtered.kept[i]) continue;
    const std::size_t c = i % w;
    if (c > 0 && c + 1 < w) z[i] = 0.5 * (seen[i - 1] + seen[i + 1]);
    if (std::isnan(z[i]) && i >= w && i + w < z.size()) z[i] = 0.5 * (seen[i - w] + seen[i + w]);
  }
  return z;
}

}  // namespace

Gradient deriche_gradient(const std::vector<double>& values, int width, int height, double alpha) {
  ensure(values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "one value per pixel");
  ensure(alpha > 0.05 && alpha < 20, "Deriche's alpha is about 1 per pixel");
  const int memory = memory_of(alpha);
  const Recursion derivative = derivative_of(alpha), smoother = smoother_of(alpha);
  Gradient g;
  g.x = filtered_lines(filtered_lines(values, width, height, false, derivative, memory), width, height, true, smoother,
                       memory);
  g.y = filtered_lines(filtered_lines(values, width, height, true, derivative, memory), width, height, false, smoother,
                       memory);
  return g;
}

std::vector<RangeEdge> range_edges(const RangeImage& image, const FilteredImage& filtered, const EdgeOptions& options) {
  ensure(filtered.width == image.width && filtered.height == image.height, "image and filtered image have one size");
  const int width = image.width, height = image.height, memory = memory_of(options.alpha);
  const Recursion derivative = derivative_of(options.alpha), smoother = smoother_of(options.alpha);
  const Gradient g = deriche_gradient(depths(image, filtered), width, height, options.alpha);
  const Gradient gx = deriche_gradient(g.x, width, height, options.alpha);
  const Gradient gy = deriche_gradient(g.y, width, height, options.alpha);
  const double slope_gain = noise_gain(derivative, memory, 1) * noise_gain(smoother, memory, 1);
  const double bend_gain = noise_gain(derivative, memory, 2) * noise_gain(smoother, memory, 2);
  const Field slope{width, height, [&](std::size_t i, double dx, double dy) { return g.x[i] * dx + g.y[i] * dy; }};
  const auto cross = [&](std::size_t i) { return 0.5 * (gx.y[i] + gy.x[i]); };
  const Field bend{width, height, [&](std::size_t i, double dx, double dy) {
                     return gx.x[i] * dx * dx + 2 * cross(i) * dx * dy + gy.y[i] * dy * dy;
                   }};
  std::vector<double> steps(g.x.size(), 0), roofs(g.x.size(), 0);
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) {
      const auto i = static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c);
      const double sigma = static_cast<double>(filtered.raw_sigma[i]), size = std::hypot(g.x[i], g.y[i]);
      if (std::isnan(size) || !(sigma > 0)) continue;
      if (size > 0) steps[i] = prominence(slope, r, c, g.x[i] / size, g.y[i] / size, 1) / (sigma * slope_gain);
      // The direction of the larger bend: half the angle of (xx - yy, 2 xy), or across it.
      double angle = 0.5 * std::atan2(2 * cross(i), gx.x[i] - gy.y[i]);
      if (gx.x[i] + gy.y[i] < 0) angle += 1.5707963267948966;
      if (std::isnan(angle)) continue;
      // Half: the bend of round surfaces changes too, but not within a few pixels.
      roofs[i] = prominence(bend, r, c, std::cos(angle), std::sin(angle), 0.5) / (sigma * bend_gain);
    }
  const auto step = hysteresis(steps, width, height, options.low, options.high);
  const auto roof = hysteresis(roofs, width, height, options.low, options.high);
  std::vector<RangeEdge> edges(step.size(), RangeEdge::none);
  constexpr int beside_step = 4;  // a step bends the smoothed slope on both its sides
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) {
      const auto i = static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c);
      if (step[i]) edges[i] = RangeEdge::step;
      if (step[i] || !roof[i]) continue;
      bool near = false;
      for (int y = std::max(r - beside_step, 0); y <= std::min(r + beside_step, height - 1) && !near; ++y)
        for (int x = std::max(c - beside_step, 0); x <= std::min(c + beside_step, width - 1) && !near; ++x)
          near = step[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] != 0;
      if (!near) edges[i] = RangeEdge::roof;
    }
  return edges;
}

}  // namespace partscribe::geometry
