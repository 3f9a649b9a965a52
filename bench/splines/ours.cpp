#include <algorithm>
#include <cmath>

#include "fit/surface/grid_fit.h"
#include "fit/surface/spline_fit.h"
#include "peers.h"

namespace bench {
namespace {

std::optional<NurbsSurface> of_grid(const Question& question, double allowed) {
  partscribe::fit::SplineGrid grid;
  for (int i = 0; i < question.columns; ++i) grid.u.push_back(question.points[std::size_t(i * question.rows)].x());
  for (int j = 0; j < question.rows; ++j) grid.v.push_back(question.points[std::size_t(j)].y());
  grid.points = question.points;
  partscribe::fit::GridFitOptions options;
  options.tolerance = allowed, options.noise = question.sigma;
  partscribe::core::Context context;
  auto fit = partscribe::fit::fit_grid(grid, options, context);
  if (!fit) return std::nullopt;
  return std::move(fit->surface);
}

}  // namespace

// Points on a grid by fit_grid; others as fit_piece of fit/surface/piece_fit.h calls it: places in the plane of
// projection, a margin around the points.
Contestant ours(bool driven, double seconds) {
  Contestant result{driven ? "ours, driven" : "ours", {}, false, false, 3, {}, driven};
  if (!driven) result.loosest = 0.7;  // what the program leaves for rounding and trims
  result.ask = [seconds](const Question& question, double allowed) {
    return asked_apart(
        [&]() -> std::optional<NurbsSurface> {
          if (question.columns > 0) return of_grid(question, allowed);
          partscribe::core::Context context;
          partscribe::fit::SplineData data;
          data.points = question.points;
          partscribe::fit::SplineFitOptions options;
          options.tolerance = allowed;
          options.noise = question.sigma;
          options.low = Vec2::Constant(1e300), options.high = Vec2::Constant(-1e300);
          for (const Vec3& p : data.points) {
            data.places.push_back(p.head<2>());
            options.low = options.low.cwiseMin(data.places.back());
            options.high = options.high.cwiseMax(data.places.back());
          }
          const double margin = 2 * question.tolerance + 0.01 * (options.high - options.low).norm();
          options.low.array() -= margin, options.high.array() += margin;
          auto fit = partscribe::fit::fit_spline(data, options, context);
          if (!fit) return std::nullopt;
          return std::move(fit->surface);
        },
        seconds);
  };
  return result;
}

}  // namespace bench
