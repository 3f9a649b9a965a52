#include "geometry/images/bent_surface.h"

#include <cmath>

namespace partscribe::geometry {
namespace {

/// A bend in the frame of a tilt: along it, across it, and mixed.
struct Turned {
  Turned(const Bend& b, const Tilt& t)
      : along(b.xx * t.x * t.x + b.yy * t.y * t.y + b.xy * t.x * t.y),
        across(b.xx * t.y * t.y + b.yy * t.x * t.x - b.xy * t.x * t.y),
        mixed(2 * (b.yy - b.xx) * t.x * t.y + b.xy * (t.x * t.x - t.y * t.y)) {}
  Bend back(const Tilt& t) const {
    return {along * t.x * t.x + across * t.y * t.y - mixed * t.x * t.y,
            along * t.y * t.y + across * t.x * t.x + mixed * t.x * t.y,
            2 * (along - across) * t.x * t.y + mixed * (t.x * t.x - t.y * t.y)};
  }
  float along, across, mixed;
};

// Sums over the offsets -2 to 2.
constexpr float mean_2 = 2, mean_4 = 6.8F;

}  // namespace

float hidden_variance(const Bend& bend, float price) {
  const float shift = 2 * (bend.xx + bend.yy);
  return shift * shift / (1 + std::exp(0.5F * (price - bend.evidence())));
}

Bend curvature_of(const Bend& bend, const Tilt& tilt) {
  const float w = 1 / tilt.secant;
  Turned t(bend, tilt);
  t.along *= w * w * w, t.across *= w, t.mixed *= w * w;
  return t.back(tilt);
}

Bend bend_of(const Bend& curvature, const Tilt& tilt) {
  const float w = tilt.secant;
  Turned t(curvature, tilt);
  t.along *= w * w * w, t.across *= w, t.mixed *= w * w;
  return t.back(tilt);
}

BentSurface::BentSurface(const Bend& bend, const Tilt& tilt, float pixels_per_height)
    : bend_(bend), tilt_(tilt), along_(Turned(bend, tilt).along) {
  const float sq = tilt.tangent * tilt.tangent, w2 = tilt.secant * tilt.secant, a = along_ * pixels_per_height;
  cubic_ = 2 * tilt.tangent * a / w2 * along_;
  quartic_ = (1 + 5 * sq) / (w2 * w2) * a * a * along_;
}

float BentSurface::at(float x, float y) const {
  const float u = tilt_.x * x + tilt_.y * y;
  return bend_.xx * x * x + bend_.yy * y * y + bend_.xy * x * y + (cubic_ + quartic_ * u) * u * u * u;
}

std::array<float, 2> BentSurface::slope(float x, float y) const {
  const float u = tilt_.x * x + tilt_.y * y, along = (3 * cubic_ + 4 * quartic_ * u) * u * u;
  return {2 * bend_.xx * x + bend_.xy * y + along * tilt_.x, 2 * bend_.yy * y + bend_.xy * x + along * tilt_.y};
}

float BentSurface::mean() const {
  const float x2 = tilt_.x * tilt_.x, y2 = tilt_.y * tilt_.y;
  return mean_2 * (bend_.xx + bend_.yy) + quartic_ * (mean_4 * (x2 * x2 + y2 * y2) + 6 * mean_2 * mean_2 * x2 * y2);
}

float BentSurface::steepening() const { return cubic_ * (mean_4 / mean_2); }

}  // namespace partscribe::geometry
