#include <algorithm>
#include <cmath>

#include "fit/surface/spline_fit.h"
#include "peers.h"

namespace bench {

// As fit_piece of fit/surface/piece_fit.h calls it: places in the plane of projection, a margin around the points.
Contestant ours(bool driven, double seconds) {
  Contestant result{driven ? "ours, driven" : "ours", {}, false, false, 3, {}, driven};
  if (!driven) result.loosest = 0.7;  // what the program leaves for rounding and trims
  result.ask = [seconds](const Question& question, double allowed) {
    return asked_apart(
        [&]() -> std::optional<NurbsSurface> {
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
