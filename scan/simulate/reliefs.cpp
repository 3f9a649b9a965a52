#include "scan/simulate/reliefs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/number.h"

namespace partscribe::scan {
namespace {

/// A hill of `height` and half widths `sx` along a direction `turn` from x, `sy` across it; negative: a hollow.
double hill(double x, double y, double cx, double cy, double sx, double sy, double height, double turn = 0) {
  const double u = (x - cx) * std::cos(turn) + (y - cy) * std::sin(turn);
  const double v = (y - cy) * std::cos(turn) - (x - cx) * std::sin(turn);
  return height * std::exp(-0.5 * (u * u / (sx * sx) + v * v / (sy * sy)));
}

/// Rises from 0 at `from` to 1 at `to` with three continuous derivatives; `to` may be the smaller.
double rise(double from, double to, double at) {
  const double t = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return t * t * t * t * (35 - t * (84 - t * (70 - 20 * t)));
}

/// A groove of `depth` and half width `sigma` along y = a + b x + c x^2, fading out beyond |x - middle| = `reach`.
double groove(double x, double y, double a, double b, double c, double middle, double reach, double depth,
              double sigma) {
  const double off = (y - a - b * x - c * x * x) / std::hypot(1.0, b + 2 * c * x);
  return -depth * std::exp(-0.5 * off * off / (sigma * sigma)) * std::exp(-std::pow((x - middle) / reach, 4));
}

}  // namespace

double face_mask_height(double x, double y) {
  const double down = -y / 98, half = 72 * (1 - 0.14 * down - 0.12 * down * down);
  const double out = x * x / (half * half) + down * down;
  if (!(out < 0.94)) return std::numeric_limits<double>::quiet_NaN();
  double z = 47 * std::pow(1 - out, 0.6) - 6;
  for (const double s : {x, -x}) {  // what both halves have
    // Brows, the sockets under them, eyes with lids.
    z += hill(s, y, 27, 29, 16, 5.5, 6, -0.12) + hill(s, y, 60, 30, 9, 22, -3);
    z += hill(s, y, 29, 11, 14, 9.5, -11) + hill(s, y, 29, 9.5, 9.5, 6.8, 8);
    const double eye = s - 29;
    z += groove(eye, y, 15.5, 0.05, -0.028, 0, 13, 1.9, 1.0) + groove(eye, y, 4.6, 0.02, 0.022, 0, 12, 1.3, 1.0);
    z += groove(eye, y, 8.6, 0.03, -0.012, 0, 11, 1.5, 0.8);
    // Wings of the nose, nostrils, cheeks, the folds between them and the corners of the mouth.
    z += hill(s, y, 11, -25, 4.2, 5, 6) + hill(s, y, 5.8, -30.5, 2.7, 1.9, -3) + hill(s, y, 16.5, -24, 2.2, 7, -2, 0.2);
    z += hill(s, y, 41, -9, 14, 11, 6) + hill(s, y, 42, -44, 11, 15, -4);
    const double fold = std::clamp((-20 - y) / 34, -0.5, 1.5);
    const double across = (s - 15.5 - 14 * fold - 2.5 * fold * fold) * 0.9;
    z -= 2.4 * std::exp(-0.5 * across * across / 5.3) * rise(-18, -28, y) * rise(-60, -48, y);
    z += hill(s, y, 4.6, -45, 3.6, 1.9, 1.3) + hill(s, y, 23, -49.5, 3, 3, -1.8);
  }
  // The nose: a ridge that grows and widens to its tip.
  const double along = rise(28, -22, y), wide = 5 + 3.2 * along;
  z += 18 * along * (1 - rise(-19, -37, y)) * std::exp(-0.5 * x * x / (wide * wide));
  z += hill(x, y, 0, 27, 9, 7, 3) + hill(x, y, 0, -21, 6.5, 6, 4);
  // Lips on a gentle mound, the line between them, the groove above and the crease below, the chin.
  z += hill(x, y, 0, -50, 25, 15, 4) + hill(x, y, 0, -40, 2.2, 4.5, -2);
  z += hill(x, y, 0, -47.2, 13, 3, 4.2) + hill(x, y, 0, -55.5, 12, 3.6, 5.6);
  z += groove(x, y, -51, 0, 0.006, 0, 19, 4.2, 1.2);
  z += hill(x, y, 0, -63.5, 14, 3.8, -4.5) + hill(x, y, 0, -78, 14, 9, 8.5);
  return z;
}

double hand_height(double x, double y) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  if (!(y >= 0)) return nothing;
  constexpr double power = 8;  // of the mean that joins the pieces: the larger, the sharper where they meet
  double sum = 0, least = 2, groove_depth = 0;
  const auto add = [&](double height, double sq_out) {
    least = std::min(least, sq_out);
    if (sq_out < 1) sum += std::pow(height * std::sqrt(1 - sq_out), power);
  };
  // The palm and the wrist.
  const double px = std::abs(x - 3) / (36 + 4 * (y - 46) / 52), py = std::abs(y - 48) / 53;
  add(21, px * px * px + py * py * py);
  const double wrist = std::max(0.0, y - 15) / 35;
  add(19, (x - 3) * (x - 3) / (27.0 * 27) + wrist * wrist * wrist * wrist);
  // Fingers taper from a foot to a round tip, with two creases each; three pads swell between them.
  struct Finger {
    double x0, y0, x1, y1, r0, r1, height;
  };
  constexpr std::array<Finger, 6> fingers = {{{-21, 90, -28, 158, 9.3, 7.6, 15},
                                              {-2.5, 95, -3.5, 172, 9.6, 7.8, 16},
                                              {15.5, 92, 20.5, 163, 9.2, 7.4, 15},
                                              {32, 82, 43, 139, 8.2, 6.6, 13},
                                              {-15, 31, -38, 64, 15, 10.5, 20},
                                              {-38, 64, -46, 99, 10.3, 8.4, 17}}};
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    const Finger& f = fingers[i];
    const double dx = f.x1 - f.x0, dy = f.y1 - f.y0, length = std::hypot(dx, dy);
    const double along = ((x - f.x0) * dx + (y - f.y0) * dy) / length;
    const double off = ((x - f.x0) * dy - (y - f.y0) * dx) / length;
    const double t = std::clamp(along / length, 0.0, 1.0), beyond = along - t * length;
    const double swell = i < 4 ? 1 + 0.04 * std::sin(3 * pi * t) * std::sin(3 * pi * t) : 1;
    const double radius = (f.r0 + (f.r1 - f.r0) * t) * swell;
    add(f.height * swell, (off * off + beyond * beyond) / (radius * radius));
    const double fade = std::exp(-std::pow(off / radius, 4));
    const auto crease = [&](double at, double depth) {
      const double d = along - at * length - 0.02 * off * off;
      groove_depth += depth * std::exp(-0.5 * d * d / 1.2) * fade;
    };
    if (i < 4)
      crease(0.22, 1.5), crease(0.5, 1.4), crease(0.75, 1.2);
    else if (i == 5)
      crease(0.05, 1.5), crease(0.5, 1.3);
  }
  if (!(least < 0.93)) return nothing;
  double z = std::pow(sum, 1 / power) - groove_depth;
  // The balls of the thumb and of the hand, the pads under the fingers, the hollow between them.
  const double inside = rise(0.93, 0.6, std::min(least, 0.93));
  z += inside * (hill(x, y, -17, 36, 12, 17, 8, 0.4) + hill(x, y, 25, 36, 10, 20, 6) + hill(x, y, 5, 58, 13, 13, -5));
  for (const double at : {-18.0, -1.0, 16.0, 30.0}) z += inside * hill(x, y, at, 84 - 0.005 * at * at, 6, 6, 2.5);
  // Life, head and heart line; two across the wrist.
  const double from_thumb = std::hypot(x + 27, y - 26) - 33, turn = std::atan2(y - 26, x + 27);
  z -= 1.8 * std::exp(-0.5 * from_thumb * from_thumb / 1.4) * rise(-0.55, -0.25, turn) * rise(1.6, 1.3, turn);
  z += groove(x, y, 57, -0.28, -0.002, 0, 24, 1.6, 1.1) + groove(x, y, 68, -0.05, 0.006, 14, 21, 1.6, 1.1);
  z += groove(x, y, 7, 0, 0.004, 3, 20, 1.2, 1.0) + groove(x, y, 3, 0, 0.004, 3, 20, 1.0, 0.9);
  return z;
}

}  // namespace partscribe::scan
