/// What chord lengths and equal steps do to fits of 1993 where a surface changes fast or ends.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "fit/surface/published_spline.h"

using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

constexpr int side = 121;          // places of a grid along x and y, 1 mm apart
constexpr double half_width = 45;  // of a wavy square, mm
constexpr double depth = 40;       // of what lies behind it, mm

/// mm from the square's border, positive inside.
double from_border(int column, int row) {
  return half_width + 0.5 - std::max(std::abs(column - side / 2), std::abs(row - side / 2));
}

/// The bounding box of a square in front of a plane.
PlaceGrid square_in_box() {
  PlaceGrid grid{side, side, {}};
  for (int r = 0; r < side; ++r)
    for (int c = 0; c < side; ++c)
      grid.places.emplace_back(c, r, from_border(c, r) > 0 ? 4 * std::sin(c / 3.0) * std::cos(r / 3.5) : -depth);
  return grid;
}

struct BorderErrors {
  double inside = 0, beside = 0;  // rms, mm, of valid places more than 20 mm from the border, and less than 3
};

BorderErrors errors_of(const PublishedSurface& fit) {
  double sums[2] = {}, counts[2] = {};
  for (int r = 0; r < side; ++r)
    for (int c = 0; c < side; ++c) {
      const double in = from_border(c, r);
      if (in <= 0 || (in >= 3 && in <= 20)) continue;
      const int k = in > 20 ? 0 : 1;
      sums[k] += std::pow(fit.errors[std::size_t(r * side + c)], 2), counts[k] += 1;
    }
  return {std::sqrt(sums[0] / counts[0]), std::sqrt(sums[1] / counts[1])};
}

/// The share of the domain between the two columns on either side of the border.
double spent_on_border(const PublishedSurface& fit) {
  double spent = 0;
  for (int c = 0; c + 1 < side; ++c)
    if ((from_border(c, side / 2) > 0) != (from_border(c + 1, side / 2) > 0))
      spent += fit.u[std::size_t(c) + 1] - fit.u[std::size_t(c)];
  return spent;
}

}  // namespace

TEST_CASE("published spline: a denser net keeps the error of a border at the border") {
  const PlaceGrid grid = square_in_box();
  double inside = 1e3, share = 1e3;
  for (const int controls : {20, 36, 60}) {
    const auto fit = published_surface(grid, equal_spans(controls), equal_spans(controls), Parameters::uniform);
    const BorderErrors e = errors_of(fit);
    UNSCOPED_INFO(controls << " controls: inside " << e.inside << ", beside the border " << e.beside);
    CHECK(e.inside < 0.2 * inside);
    CHECK(e.inside / e.beside < 0.5 * share);
    CHECK(e.beside > 1);
    inside = e.inside, share = e.inside / e.beside;
  }
  CHECK(inside < 0.02);
}

TEST_CASE("published spline: chord lengths spend the domain on a border, equal steps are better inside of it") {
  const PlaceGrid grid = square_in_box();
  const auto chord = published_surface(grid, equal_spans(36), equal_spans(36), Parameters::chord_length);
  const auto equal = published_surface(grid, equal_spans(36), equal_spans(36), Parameters::uniform);
  const BorderErrors c = errors_of(chord), e = errors_of(equal);
  INFO("chord lengths: inside " << c.inside << ", beside " << c.beside << ", domain " << spent_on_border(chord));
  INFO("equal steps: inside " << e.inside << ", beside " << e.beside << ", domain " << spent_on_border(equal));
  CHECK(spent_on_border(chord) > 10 * spent_on_border(equal));
  CHECK(c.beside < e.beside);
  CHECK(e.inside < 0.8 * c.inside);
  // Knots where errors are large mend some of what equal steps leave at the border, and nearly all inside.
  const auto refined = refined_surface(grid, equal_spans(36), equal_spans(36), Parameters::uniform, 2);
  const BorderErrors r = errors_of(refined);
  INFO("with knots: inside " << r.inside << ", beside " << r.beside);
  CHECK(r.beside < 0.8 * e.beside);
  CHECK(r.inside < 0.2 * c.inside);
}

TEST_CASE("published spline: with chord lengths errors are larger where the shape changes fast") {
  std::vector<Vec3> places;
  for (int i = 0; i <= 500; ++i) {
    const double x = 0.2 * i;
    places.emplace_back(x, 0, 3 * std::sin(x / 25) + 6 * std::exp(-(x - 60) * (x - 60) / 4));
  }
  const auto at = parameters_of(places, Parameters::chord_length);
  const auto fit = published_curve(places, at, equal_spans(24));
  double fast = 0, smooth = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double x = places[i].x();
    if (std::abs(x - 60) < 4) fast = std::max(fast, fit.errors[i]);
    if (std::abs(x - 60) > 15) smooth = std::max(smooth, fit.errors[i]);
  }
  INFO(fast << " " << smooth);
  CHECK(fast > 5 * smooth);
}
