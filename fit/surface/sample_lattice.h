/// Samples of one view in the rows and columns of its picture, and which of them lie on one surface.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/images/range_image.h"

namespace partscribe::fit {

/// What one view saw, pixel by pixel. Straight lines in space are straight in the picture: parallel rays or a pinhole.
struct SampleLattice {
  int columns = 0, rows = 0;  ///< at most 16384
  std::vector<Vec3> places;   ///< mm, row by row; NaN where nothing was seen
  std::vector<Vec3> normals;  ///< unit, on the sensor's side; a pixel without one (zero) counts as not seen
};

/// Places in the world, with normals of planes through 5x5 pixels (geometry/images/grid_normals.h).
SampleLattice sample_lattice(const geometry::RangeImage& image, int threads);

/// The lattice as a plane of pixels, in which locations are exact.
class LatticePicture {
 public:
  using Pixel = std::uint32_t;  ///< row * columns + column
  using Corners = std::array<Pixel, 3>;
  static constexpr Pixel nobody = ~0u;

  /// Neighbouring samples farther apart than `longest_chord` typical ones are a step of depth, unless both normals
  /// stand square to their chord, as on a steep wall. `lattice` outlives this.
  LatticePicture(const SampleLattice& lattice, double longest_chord);

  const SampleLattice& lattice() const { return lattice_; }
  std::size_t size() const { return seen_.size(); }
  double pitch() const { return pitch_; }  ///< mm, the median between neighbours; 0 if there are none
  bool seen(Pixel p) const { return seen_[p] != 0; }
  const Vec3& place(Pixel p) const { return lattice_.places[p]; }
  const Vec3& normal(Pixel p) const { return lattice_.normals[p]; }
  int column(Pixel p) const { return static_cast<int>(p) % lattice_.columns; }
  int row(Pixel p) const { return static_cast<int>(p) / lattice_.columns; }
  bool holds(int column, int row) const {
    return column >= 0 && row >= 0 && column < lattice_.columns && row < lattice_.rows;
  }
  Pixel pixel(int column, int row) const { return static_cast<Pixel>(row * lattice_.columns + column); }

  /// Twice the area of a triangle, positive if it runs from the columns' direction to the rows'.
  std::int64_t turn(Pixel a, Pixel b, Pixel c) const {
    return std::int64_t(column(b) - column(a)) * (row(c) - row(a)) -
           std::int64_t(row(b) - row(a)) * (column(c) - column(a));
  }
  /// Does d lie inside the circle through a, b, c, whose turn is positive?
  bool in_circle(Pixel a, Pixel b, Pixel c, Pixel d) const;

  /// Is the neighbour so many columns and rows on, -1 to 1, a sample of the same surface?
  bool linked(Pixel p, int columns, int rows) const { return (links_[p] >> ((rows + 1) * 3 + columns + 1) & 1) != 0; }
  /// Does a row of linked samples run from a to b, no farther than one pixel from the straight line?
  bool accompanied(Pixel a, Pixel b) const;
  /// Is a triangle of positive turn part of the surface? Rows of linked samples run along its edges, and none of its
  /// pixels is farther than one from all samples.
  bool is_surface(const Corners& v) const;

  /// Calls `use` for the pixels of a triangle of positive turn, edges and corners included, until it returns false.
  template <class Use>
  bool all_pixels(const Corners& v, const Use& use) const;

 private:
  template <class Use>
  void for_neighbours(const Use& use) const;

  const SampleLattice& lattice_;
  double pitch_ = 0;
  std::vector<std::uint8_t> seen_, lonely_;  // lonely: neither it nor any of the 8 around it was seen
  std::vector<std::uint16_t> links_;         // which of the 9 pixels around it, row by row, are on the same surface
};

template <class Use>
bool LatticePicture::all_pixels(const Corners& v, const Use& use) const {
  int top = row(v[0]), bottom = top;
  for (const Pixel p : v) top = std::min(top, row(p)), bottom = std::max(bottom, row(p));
  for (int r = top; r <= bottom; ++r) {
    std::int64_t left = 0, right = lattice_.columns - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      // turn(a, b, (c, r)) = rest - slope * c >= 0
      const Pixel a = v[k], b = v[(k + 1) % 3];
      const std::int64_t slope = row(b) - row(a);
      const std::int64_t rest = std::int64_t(column(b) - column(a)) * (r - row(a)) + slope * column(a);
      if (slope > 0)
        right = std::min(right, rest >= 0 ? rest / slope : -1);
      else if (slope < 0)
        left = std::max(left, rest < 0 ? (rest + slope + 1) / slope : 0);
      else if (rest < 0)
        right = -1;
    }
    for (std::int64_t c = left; c <= right; ++c)
      if (!use(pixel(static_cast<int>(c), r))) return false;
  }
  return true;
}

}  // namespace partscribe::fit
