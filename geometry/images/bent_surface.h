/// How a smooth surface leaves its tangent plane around a pixel of a range image.
#pragma once

#include <array>

#include "core/layers.h"

namespace partscribe::geometry {

/// The slope of a surface against the ray through a pixel.
struct Tilt {
  float x = 1, y = 0;             ///< unit vector in the image along which the depth grows most
  float tangent = 0, secant = 1;  ///< of the incidence
};

/// Coefficients of x^2, y^2 and xy, in heights per pixel^2; of a curvature, those which it would have if the surface
/// faced the ray.
struct Bend {
  float xx = 0, yy = 0, xy = 0;
  bool none() const { return xx == 0 && yy == 0 && xy == 0; }
  /// chi^2 of its three terms, found by least squares in a 5x5 window of noise 1.
  float evidence() const { return 70 * (xx * xx + yy * yy) + 100 * (xy * xy); }
};

/// chi^2 of a bend's three terms that noise exceeds once in a thousand.
constexpr float significant_bend = 16.3F;

/// What a bend that is perhaps none adds to the variance of the middle of a 5x5 window's plane: as much as it would
/// shift that, as often as `evidence` makes it real; as likely as not if that is `price`. All in units of the noise.
float hidden_variance(const Bend& bend, float price);

inline Bend operator-(const Bend& a, const Bend& b) { return {a.xx - b.xx, a.yy - b.yy, a.xy - b.xy}; }

/// A round surface has one curvature wherever it is seen, while its bend grows with 1 / cos^3 of the incidence.
Bend curvature_of(const Bend& bend, const Tilt& tilt);
Bend bend_of(const Bend& curvature, const Tilt& tilt);

/// A surface less its tangent plane. Along the tilt it is an arc, up to the fourth order: h''' = 3 h' h''^2 / (1 +
/// h'^2), h'''' = 3 h''^3 (1 + 5 h'^2) / (1 + h'^2)^2, with lengths in pixels.
class BentSurface {
 public:
  BentSurface() = default;
  /// `pixels_per_height`: one height in widths of a pixel.
  BentSurface(const Bend& bend, const Tilt& tilt, float pixels_per_height);

  bool flat() const { return bend_.none(); }
  const Bend& second_order() const { return bend_; }
  float at(float x, float y) const;
  std::array<float, 2> slope(float x, float y) const;  ///< along x and y
  float mean() const;        ///< over 5x5 pixels: by so much least squares puts a plane too high in the middle
  float steepening() const;  ///< by so much such a plane is too steep along the tilt

 private:
  Bend bend_;
  Tilt tilt_;
  float cubic_ = 0, quartic_ = 0, along_ = 0;
};

}  // namespace partscribe::geometry
