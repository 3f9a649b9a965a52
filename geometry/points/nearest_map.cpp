#include "geometry/points/nearest_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/ensure.h"

namespace partscribe::geometry {
namespace {

constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

/// One line of cells: the lower envelope of the parabolas that are the squared distances of the line's places to the
/// points that its cells know (Felzenszwalb & Huttenlocher 2012).
class Line {
 public:
  explicit Line(const std::vector<Vec3>& points) : points_(points) {}

  /// `middle`: of the first cell; `step` between the cells along `axis`.
  void sweep(std::uint32_t* cells, std::size_t step, std::size_t count, const Vec3& middle, int axis, double cell) {
    hull_.clear();
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t i = cells[k * step];
      if (i == nobody) continue;
      const Vec3& p = points_[i];
      Arc arc{p[axis], (p[u] - middle[u]) * (p[u] - middle[u]) + (p[v] - middle[v]) * (p[v] - middle[v]),
              -std::numeric_limits<double>::infinity(), i};
      bool below = true;
      while (!hull_.empty()) {
        const Arc& last = hull_.back();
        const double apart = arc.at - last.at;
        if (!(apart > 0)) {  // on the border of two cells
          below = arc.height < last.height;
          if (!below) break;
          hull_.pop_back();
          continue;
        }
        arc.from = 0.5 * (arc.at + last.at + (arc.height - last.height) / apart);
        if (arc.from > last.from) break;
        hull_.pop_back();
      }
      if (hull_.empty()) arc.from = -std::numeric_limits<double>::infinity();
      if (below) hull_.push_back(arc);
    }
    if (hull_.empty()) return;
    std::size_t at = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double place = middle[axis] + static_cast<double>(k) * cell;
      while (at + 1 < hull_.size() && hull_[at + 1].from <= place) ++at;
      cells[k * step] = hull_[at].point;
    }
  }

 private:
  struct Arc {
    double at, height, from;
    std::uint32_t point;
  };
  const std::vector<Vec3>& points_;
  std::vector<Arc> hull_;
};

}  // namespace

NearestMap::NearestMap(const std::vector<Vec3>& points, double cell, std::size_t most_cells) : cell_(cell) {
  ensure(!points.empty() && cell > 0, "a map needs points and a size of its cells");
  Box3 box;
  for (const Vec3& p : points) box.add(p);
  const auto cells_along = [&](int axis) { return std::floor(box.size()[axis] / cell_) + 1; };
  while (cells_along(0) * cells_along(1) * cells_along(2) > static_cast<double>(most_cells)) cell_ *= 1.1;
  inverse_ = 1 / cell_;
  for (int axis = 0; axis < 3; ++axis) {
    count_[axis] = static_cast<int>(cells_along(axis)), last_[axis] = count_[axis] - 1;
    low_[axis] = box.center()[axis] - 0.5 * count_[axis] * cell_;
  }
  const std::size_t nx = static_cast<std::size_t>(count_[0]), ny = static_cast<std::size_t>(count_[1]),
                    nz = static_cast<std::size_t>(count_[2]);
  index_.assign(nx * ny * nz, nobody);
  const auto middle_of = [&](std::size_t x, std::size_t y, std::size_t z) {
    return Vec3(low_[0] + (double(x) + 0.5) * cell_, low_[1] + (double(y) + 0.5) * cell_,
                low_[2] + (double(z) + 0.5) * cell_);
  };
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t x = place(points[i].x(), 0), y = place(points[i].y(), 1), z = place(points[i].z(), 2);
    std::uint32_t& known = index_[x + nx * (y + ny * z)];
    const Vec3 middle = middle_of(x, y, z);
    if (known == nobody || (points[i] - middle).squaredNorm() < (points[known] - middle).squaredNorm()) known = i;
  }
  Line line(points);
  for (std::size_t z = 0; z < nz; ++z)
    for (std::size_t y = 0; y < ny; ++y) line.sweep(&index_[nx * (y + ny * z)], 1, nx, middle_of(0, y, z), 0, cell_);
  for (std::size_t z = 0; z < nz; ++z)
    for (std::size_t x = 0; x < nx; ++x) line.sweep(&index_[x + nx * ny * z], nx, ny, middle_of(x, 0, z), 1, cell_);
  for (std::size_t y = 0; y < ny; ++y)
    for (std::size_t x = 0; x < nx; ++x) line.sweep(&index_[x + nx * y], nx * ny, nz, middle_of(x, y, 0), 2, cell_);
}

}  // namespace partscribe::geometry
