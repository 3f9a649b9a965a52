#include "geometry/images/pixel_grid.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"

namespace partscribe::geometry {
namespace {

constexpr int most_half = 4;          // of a window: beyond, a tree is faster
constexpr double rounded = 1 - 1e-9;  // so that no rounding makes another point the nearest

/// Hilbert's curve through a square of `size` (a power of two, 2 or more) pixels from the corner (x, y), first `along`,
/// to the corner that lies `across` from it; squares that `outside` names are left out.
template <class Outside, class Use>
void curve(int x, int y, int along_x, int along_y, int across_x, int across_y, int size, const Outside& outside,
           const Use& use) {
  // The corner of the square with the least coordinates.
  const int left = x + std::min(0, (along_x + across_x) * (size - 1)),
            top = y + std::min(0, (along_y + across_y) * (size - 1));
  if (outside(left, top)) return;
  if (size == 2) {
    use(x, y), use(x + along_x, y + along_y), use(x + along_x + across_x, y + along_y + across_y),
        use(x + across_x, y + across_y);
    return;
  }
  const int half = size / 2, rest = half - 1;
  curve(x, y, across_x, across_y, along_x, along_y, half, outside, use);
  curve(x + half * along_x, y + half * along_y, along_x, along_y, across_x, across_y, half, outside, use);
  curve(x + half * (along_x + across_x), y + half * (along_y + across_y), along_x, along_y, across_x, across_y, half,
        outside, use);
  curve(x + half * across_x + rest * across_x + rest * along_x, y + half * across_y + rest * across_y + rest * along_y,
        -across_x, -across_y, -along_x, -along_y, half, outside, use);
}

}  // namespace

PixelGrid::PixelGrid(const PixelCamera& camera, const std::vector<std::uint32_t>& pixels,
                     const std::vector<Vec3>& points)
    : camera_(camera), points_(&points) {
  ensure(pixels.size() == points.size() && camera.fx != 0 && camera.fy != 0,
         "every point has a pixel, and pixels have a size");
  index_.assign(std::size_t(camera.width) * std::size_t(camera.height), nobody);
  double sq_slope = 0;
  for (std::uint32_t i = 0; i < pixels.size(); ++i) {
    const Vec3& p = points[i];
    ensure(pixels[i] < index_.size() && (i == 0 || pixels[i - 1] < pixels[i]), "points come pixel by pixel");
    index_[pixels[i]] = i;
    if (camera.pinhole && !(p.z() > 0)) off_ = std::numeric_limits<double>::infinity();
    const double scale = camera.pinhole ? 1 / p.z() : 1, x = p.x() * scale, y = p.y() * scale;
    const double column = camera.fx * x + camera.cx - pixels[i] % std::uint32_t(camera.width),
                 row = camera.fy * y + camera.cy - pixels[i] / std::uint32_t(camera.width);
    off_ = std::max({off_, std::abs(column), std::abs(row)});
    if (camera.pinhole) sq_slope = std::max(sq_slope, x * x + y * y);
  }
  // From (u, v, 1) z to the ray along (u', v', 1) it is |(u, v, 1) x (u', v', 1)| z / |(u', v', 1)| >= |(u - u', v -
  // v')| z / |(u', v', 1)|.
  pitch_ = rounded / (std::max(std::abs(camera.fx), std::abs(camera.fy)) * std::sqrt(1 + sq_slope));
}

std::vector<std::uint32_t> PixelGrid::order() const {
  std::vector<std::uint32_t> result;
  result.reserve(points_->size());
  int size = 2;
  while (size < std::max(camera_.width, camera_.height)) size *= 2;
  curve(
      0, 0, 1, 0, 0, 1, size, [&](int left, int top) { return left >= camera_.width || top >= camera_.height; },
      [&](int x, int y) {
        if (x >= camera_.width || y >= camera_.height) return;
        const std::uint32_t i = index_[std::size_t(y) * std::size_t(camera_.width) + std::size_t(x)];
        if (i != nobody) result.push_back(i);
      });
  return result;
}

bool PixelGrid::locate(const Vec3& query, Place& place) const {
  if (camera_.pinhole && !(query.z() > 0)) return false;
  const double scale = camera_.pinhole ? 1 / query.z() : 1;
  const double u = camera_.fx * query.x() * scale + camera_.cx, v = camera_.fy * query.y() * scale + camera_.cy;
  if (!(u > -most_half && v > -most_half && u < camera_.width + most_half && v < camera_.height + most_half))
    return false;
  // Pixels are about whole numbers; both are larger than -most_half.
  place.column = static_cast<int>(u + (most_half + 0.5)) - most_half,
  place.row = static_cast<int>(v + (most_half + 0.5)) - most_half;
  place.pixel = camera_.pinhole ? pitch_ * query.z() : pitch_;
  place.beside = 1 - std::max(std::abs(u - place.column), std::abs(v - place.row)) - off_;
  return true;
}

template <class Use>
void PixelGrid::window(const Place& place, int half, const Use& use) const {
  const int first = std::max(place.column - half, 0), last = std::min(place.column + half, camera_.width - 1);
  const int top = std::max(place.row - half, 0), bottom = std::min(place.row + half, camera_.height - 1);
  for (int r = top; r <= bottom; ++r) {
    const std::uint32_t* row = &index_[std::size_t(r) * std::size_t(camera_.width)];
    for (int c = first; c <= last; ++c)
      if (row[c] != nobody) use(row[c]);
  }
}

bool PixelGrid::nearest(const Vec3& query, double limit, Found& found) const {
  Place place;
  if (!locate(query, place)) return false;
  int half = 1;
  while (true) {
    std::uint32_t first = nobody, second = nobody;
    double sq_first = std::numeric_limits<double>::max(), sq_second = sq_first;
    window(place, half, [&](std::uint32_t i) {
      const Vec3& p = (*points_)[i];
      const double dx = query.x() - p.x(), dy = query.y() - p.y(), dz = query.z() - p.z();
      const double sq = dx * dx + dy * dy + dz * dz;
      if (!(sq < sq_second)) return;  // equally far ones come in order
      if (sq < sq_first)
        second = first, sq_second = sq_first, first = i, sq_first = sq;
      else
        second = i, sq_second = sq;
    });
    const double bound = place.bound(half), distance = std::sqrt(sq_first);
    if (bound > 0 && distance < bound) {
      found = {first, second, sq_first, std::min(std::sqrt(sq_second), bound)};
      return true;
    }
    if (bound > limit) {
      found = {nobody, nobody, std::numeric_limits<double>::max(), bound};
      return true;
    }
    // As wide as it has to be for what is known so far.
    const double needed = std::min(distance, limit) / place.pixel - place.beside;
    if (!(needed < most_half)) return false;
    half = std::max(half + 1, static_cast<int>(needed) + 1);
  }
}

bool PixelGrid::nearest(const Vec3& query, std::size_t count, std::vector<Neighbour>& result) const {
  Place place;
  if (count == 0 || !locate(query, place)) return false;
  result.resize(count);
  for (int half = 2; half <= most_half; ++half) {
    std::size_t size = 0;
    double worst = std::numeric_limits<double>::max();
    Neighbour* list = result.data();
    window(place, half, [&](std::uint32_t i) {
      const Vec3& p = (*points_)[i];
      const double dx = query.x() - p.x(), dy = query.y() - p.y(), dz = query.z() - p.z();
      const double sq = dx * dx + dy * dy + dz * dz;
      if (!(sq < worst)) return;  // equally far ones come in order
      std::size_t at = size == count ? size - 1 : size++;
      for (; at > 0 && sq < list[at - 1].sq_distance; --at) list[at] = list[at - 1];
      list[at] = {i, sq};
      if (size == count) worst = list[size - 1].sq_distance;
    });
    const double bound = place.bound(half);
    if (size == count && bound > 0 && worst < bound * bound) return true;
  }
  return false;
}

}  // namespace partscribe::geometry
