#include "fit/surface/sample_lattice.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/statistics.h"
#include "geometry/images/grid_normals.h"

namespace partscribe::fit {
namespace {

/// Which bit says that the neighbour so many columns and rows on is linked.
unsigned link_bit(int columns, int rows) { return 1u << ((rows + 1) * 3 + columns + 1); }

}  // namespace

SampleLattice sample_lattice(const geometry::RangeImage& image, int threads) {
  SampleLattice lattice;
  lattice.columns = image.width, lattice.rows = image.height;
  const auto normals = geometry::grid_normals(image, {}, threads);
  for (int row = 0, i = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column, ++i) {
      const auto place = geometry::view_point(image, row, column);
      const Vec3 nowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
      lattice.places.push_back(place ? Vec3(image.world_from_view * *place) : nowhere);
      const Vec3 normal = normals[static_cast<std::size_t>(i)].cast<double>();
      lattice.normals.push_back(image.world_from_view.rotation * normal.normalized());
    }
  return lattice;
}

LatticePicture::LatticePicture(const SampleLattice& lattice, double longest_chord) : lattice_(lattice) {
  const std::size_t n = static_cast<std::size_t>(lattice.columns) * static_cast<std::size_t>(lattice.rows);
  ensure(lattice.places.size() == n && lattice.normals.size() == n, "a lattice has a sample for each pixel");
  ensure(lattice.columns <= 16384 && lattice.rows <= 16384, "circles in the picture are exact up to 16384 pixels");
  seen_.assign(n, 0), lonely_.assign(n, 0), links_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    seen_[i] = lattice.places[i].allFinite() && lattice.normals[i].squaredNorm() > 0.25;

  std::vector<double> chords;
  for_neighbours([&](Pixel a, Pixel b, int dc, int dr) {
    if (dc == 0 || dr == 0) chords.push_back((place(b) - place(a)).norm());
  });
  pitch_ = chords.empty() ? 0 : core::median_in_place(chords);
  const double longest = longest_chord * pitch_;
  for_neighbours([&](Pixel a, Pixel b, int dc, int dr) {
    const Vec3 chord = place(b) - place(a);
    const double length = chord.norm(), most = dc != 0 && dr != 0 ? std::sqrt(2.0) * longest : longest;
    const double lean = std::max(std::abs(chord.dot(normal(a))), std::abs(chord.dot(normal(b))));
    if (length > most && lean > 0.3 * length) return;
    links_[a] |= static_cast<std::uint16_t>(link_bit(dc, dr));
    links_[b] |= static_cast<std::uint16_t>(link_bit(-dc, -dr));
  });
  for (Pixel p = 0; p < n; ++p) {
    bool near = false;
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc)
        near = near || (holds(column(p) + dc, row(p) + dr) && seen_[pixel(column(p) + dc, row(p) + dr)]);
    lonely_[p] = !near;
  }
}

template <class Use>
void LatticePicture::for_neighbours(const Use& use) const {
  constexpr int steps[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
  for (int r = 0; r < lattice_.rows; ++r)
    for (int c = 0; c < lattice_.columns; ++c)
      for (const auto& [dc, dr] : steps)
        if (seen(pixel(c, r)) && holds(c + dc, r + dr) && seen(pixel(c + dc, r + dr)))
          use(pixel(c, r), pixel(c + dc, r + dr), dc, dr);
}

bool LatticePicture::in_circle(Pixel a, Pixel b, Pixel c, Pixel d) const {
  const auto sq = [&](Pixel p) {
    const std::int64_t x = column(p) - column(d), y = row(p) - row(d);
    return x * x + y * y;
  };
  return sq(a) * turn(d, b, c) + sq(b) * turn(d, c, a) + sq(c) * turn(d, a, b) > 0;
}

bool LatticePicture::accompanied(Pixel a, Pixel b) const {
  const int dc = column(b) - column(a), dr = row(b) - row(a);
  const bool wide = std::abs(dc) >= std::abs(dr);
  const int length = wide ? std::abs(dc) : std::abs(dr), rise = wide ? dr : dc;
  const int forward = (wide ? dc : dr) > 0 ? 1 : -1;
  // Steps run forward along the wider direction, places beside a's row or column to its side.
  const auto hangs_together = [&](int step, int beside, int on, int aside) {
    return wide ? linked(pixel(column(a) + forward * step, row(a) + beside), forward * on, aside)
                : linked(pixel(column(a) + beside, row(a) + forward * step), aside, forward * on);
  };
  unsigned reached = 1;  // which places at the step before, bit by bit from `low`
  int low = 0;
  for (int step = 1; step <= length; ++step) {
    const int exact = rise * step;
    const int floor = exact >= 0 ? exact / length : -((length - 1 - exact) / length);
    const bool between = floor * length != exact;
    const int from = step == length || between ? floor : floor - 1, to = step == length ? floor : floor + 1;
    unsigned now = 0;
    for (int beside = from; beside <= to; ++beside)
      for (int before = std::max(low, beside - 1); before <= std::min(low + 2, beside + 1); ++before)
        if ((reached >> (before - low) & 1) != 0 && hangs_together(step - 1, before, 1, beside - before))
          now |= 1u << (beside - from);
    for (int round = from; round < to; ++round)  // and to the side
      for (int beside = from; beside < to; ++beside) {
        const unsigned pair = 3u << (beside - from);
        if ((now & pair) != 0 && (now & pair) != pair)
          if ((now >> (beside - from) & 1) != 0 ? hangs_together(step, beside, 0, 1)
                                                : hangs_together(step, beside + 1, 0, -1))
            now |= pair;
      }
    if (now == 0) return false;
    reached = now, low = from;
  }
  return true;
}

bool LatticePicture::is_surface(const Corners& v) const {
  return accompanied(v[0], v[1]) && accompanied(v[1], v[2]) && accompanied(v[2], v[0]) &&
         all_pixels(v, [&](Pixel p) { return !lonely_[p]; });
}

}  // namespace partscribe::fit
