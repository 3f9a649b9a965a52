#include "scan/register/register_surface.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/decompose.h"
#include "geometry/normals/normals.h"
#include "geometry/points/thin.h"

namespace partscribe::scan {

Vec3 SightRaster::project(const Vec3& p) const {
  const Vec3 q = axes.transpose() * (p - origin);
  const double scale = pinhole ? 1 / std::max(q.z(), 1e-9) : 1;
  return {fx * q.x() * scale + cx, fy * q.y() * scale + cy, q.z()};
}

Sight sight(const SightRaster& raster, const Vec3& p, double margin) {
  const Vec3 at = raster.project(p);
  const int column = static_cast<int>(std::lround(std::clamp(at.x(), -1e6, 1e6)));
  const int row = static_cast<int>(std::lround(std::clamp(at.y(), -1e6, 1e6)));
  if (column < 1 || row < 1 || column + 1 >= raster.width || row + 1 >= raster.height || at.z() <= 0)
    return Sight::outside;
  double nearest = 1e30, farthest = -1;
  int returns = 0;
  for (int r = row - 1; r <= row + 1; ++r)
    for (int c = column - 1; c <= column + 1; ++c) {
      const double depth = raster.depth[std::size_t(r) * std::size_t(raster.width) + std::size_t(c)];
      if (depth < 0) continue;
      nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
      ++returns;
    }
  if (returns == 0) return Sight::empty;
  if (at.z() > farthest + margin) return Sight::hidden;
  if (at.z() < nearest - margin) return returns >= 7 ? Sight::in_front : Sight::outside;
  return Sight::measured;
}

Neighbour ViewSurface::nearest(const Vec3& p) const {
  PixelGrid::Found found;
  if (grid && grid->nearest(p, std::numeric_limits<double>::infinity(), found)) return {found.first, found.sq_first};
  return tree->nearest_one(p);
}

void ViewSurface::nearest(const Vec3& p, std::size_t count, std::vector<Neighbour>& result) const {
  if (!grid || !grid->nearest(p, count, result)) tree->nearest(p, count, result);
}

Neighbour ViewSurface::nearest_within(const Vec3& p, double limit) const {
  constexpr Neighbour none{0, std::numeric_limits<double>::infinity()};
  PixelGrid::Found found;
  const Neighbour first = !grid || !grid->nearest(p, limit, found) ? tree->nearest_two(p, limit * limit)[0]
                          : found.first == PixelGrid::nobody       ? none
                                                                   : Neighbour{found.first, found.sq_first};
  return first.sq_distance <= limit * limit ? first : none;
}

/// Least squares over the neighbours on the same smooth piece.
Mat3 ViewSurface::bending(std::size_t sample) const {
  return bendings.at(sample, [&]() -> Mat3 {
    constexpr std::size_t neighbours = 12;
    std::vector<Neighbour> near;
    const Vec3 &p = points[samples[sample]], &n = normals[samples[sample]];
    nearest(p, neighbours, near);
    Mat3 places = spacing * spacing * Mat3::Identity(), changes = Mat3::Zero();
    for (const Neighbour& at : near) {
      const Vec3 change = normals[at.index] - n, along = points[at.index] - p;
      if (!smooth[at.index] || change.norm() > 0.5) continue;
      const Vec3 t = along - along.dot(n) * n;
      places += t * t.transpose(), changes += change * t.transpose();
    }
    return changes * places.inverse();
  });
}

std::vector<std::uint32_t> spread_sample(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                                         const std::vector<std::uint32_t>& from, std::size_t count) {
  if (from.size() <= count) return from;
  // Ordered by place, so that equal strides are spread over the surface.
  std::vector<Vec3> places(from.size());
  for (std::size_t k = 0; k < from.size(); ++k) places[k] = points[from[k]];
  std::vector<std::uint32_t> all = coordinate_order(places);
  for (auto& o : all) o = from[o];
  // Cells of a cube's faces, five by five each: 150 bins of directions.
  constexpr std::size_t most_bins = 150;
  std::vector<std::uint8_t> bin_of(all.size());
  std::array<std::uint32_t, most_bins + 1> end{};  // of the bin before, and later of the bin itself
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Vec3& n = normals[all[k]];
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const double size = std::abs(n[axis]);
    const auto cell = [&](int i) { return std::min(4, static_cast<int>((n[i] / size + 1) * 2.5)); };
    bin_of[k] =
        static_cast<std::uint8_t>(((axis * 2 + (n[axis] > 0)) * 5 + cell((axis + 1) % 3)) * 5 + cell((axis + 2) % 3));
    ++end[bin_of[k] + 1u];
  }
  for (std::size_t b = 1; b <= most_bins; ++b) end[b] += end[b - 1];
  std::vector<std::uint32_t> by_bin(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) by_bin[end[bin_of[k]]++] = all[k];
  std::vector<std::uint8_t> taken(points.size(), 0);
  using List = std::span<const std::uint32_t>;
  const auto take = [&](const List& list, std::size_t most) {
    const std::size_t n = std::min(list.size(), most);
    for (std::size_t k = 0; k < n; ++k) taken[list[(2 * k + 1) * list.size() / (2 * n)]] = 1;
  };
  // Bins share what is left of the budget; the emptiest are served first, so that none of it is lost.
  std::vector<List> lists;
  for (std::size_t b = 0; b < most_bins; ++b)
    if (const std::size_t begin = b ? end[b - 1] : 0; end[b] > begin)
      lists.push_back(List(by_bin).subspan(begin, end[b] - begin));
  std::stable_sort(lists.begin(), lists.end(), [](const List& a, const List& b) { return a.size() < b.size(); });
  std::size_t budget = count * 7 / 10;
  for (std::size_t b = 0; b < lists.size(); ++b) {
    const std::size_t share = std::min(lists[b].size(), budget / (lists.size() - b));
    if (share > 0) take(lists[b], share);
    budget -= share;
  }
  take(all, count * 3 / 10);
  std::vector<std::uint32_t> result;
  for (const auto i : all)
    if (taken[i]) result.push_back(i);
  return result;
}

namespace {

/// A line through (x, y) pairs and how far they are off it.
struct Line {
  double slope = 0, offset = 0, rms = 1e30;
};

Line line_through(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sx += x[i], sy += y[i];
  sx /= n, sy /= n;
  for (std::size_t i = 0; i < x.size(); ++i) sxx += (x[i] - sx) * (x[i] - sx), sxy += (x[i] - sx) * (y[i] - sy);
  Line line;
  if (!(sxx > 0)) return line;
  line.slope = sxy / sxx, line.offset = sy - line.slope * sx;
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += std::pow(y[i] - line.slope * x[i] - line.offset, 2);
  line.rms = std::sqrt(sum / n);
  return line;
}

/// The camera that put these points into these pixels; nothing if the grid is not that of a camera looking along z.
std::optional<SightRaster> camera_of(const RegisterView& view) {
  const PointCloud& cloud = view.cloud;
  if (view.width < 8 || view.height < 8 || cloud.pixel.size() != cloud.size()) return {};
  std::vector<double> column(cloud.size()), row(cloud.size()), x(cloud.size()), y(cloud.size()), xz(cloud.size()),
      yz(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.points[i];
    if (cloud.pixel[i] < 0 || cloud.pixel[i] >= view.width * view.height || !(p.z() > 0)) return {};
    column[i] = cloud.pixel[i] % view.width, row[i] = cloud.pixel[i] / view.width;
    x[i] = p.x(), y[i] = p.y(), xz[i] = p.x() / p.z(), yz[i] = p.y() / p.z();
  }
  SightRaster raster;
  Line u = line_through(xz, column), v = line_through(yz, row);
  const Line flat_u = line_through(x, column), flat_v = line_through(y, row);
  raster.pinhole = u.rms + v.rms < flat_u.rms + flat_v.rms;
  if (!raster.pinhole) u = flat_u, v = flat_v;
  if (!(u.rms < 0.3 && v.rms < 0.3) || u.slope == 0 || v.slope == 0) return {};
  raster.fx = u.slope, raster.cx = u.offset, raster.fy = v.slope, raster.cy = v.offset;
  raster.width = view.width, raster.height = view.height;
  return raster;
}

/// The grid of one range image, with everything that is fitted to its windows.
struct Grid {
  const SightRaster& raster;
  std::vector<Vec3> point;  // by pixel
  std::vector<std::uint8_t> returned, kept;
  double sigma = 0;  // of the depth at frontal incidence
  int half = 2;      // of the window

  int width() const { return raster.width; }
  bool in(int r, int c) const { return r >= 0 && c >= 0 && r < raster.height && c < raster.width; }
  std::size_t at(int r, int c) const { return std::size_t(r) * std::size_t(raster.width) + std::size_t(c); }
  bool has(int r, int c) const { return in(r, c) && kept[at(r, c)]; }
  double z(int r, int c) const { return point[at(r, c)].z(); }
  double pixel(std::size_t i) const {
    return std::abs((raster.pinhole ? point[i].z() : 1) / std::sqrt(std::abs(raster.fx * raster.fy)));
  }
};

constexpr std::array<std::array<int, 2>, 4> directions{{{0, 1}, {1, 0}, {1, 1}, {1, -1}}};

/// 1.4826 MAD(z[i-1] - 2 z[i] + z[i+1]) / sqrt 6, each multiplied by the cosine of incidence.
double depth_noise(const Grid& grid) {
  std::vector<double> bends;
  for (int r = 1; r + 1 < grid.raster.height; ++r)
    for (int c = 1; c + 1 < grid.raster.width; ++c) {
      if (!grid.has(r, c - 1) || !grid.has(r, c) || !grid.has(r, c + 1) || !grid.has(r - 1, c) || !grid.has(r + 1, c))
        continue;
      const double step = 2 * grid.pixel(grid.at(r, c));
      const double u = (grid.z(r, c + 1) - grid.z(r, c - 1)) / step, v = (grid.z(r + 1, c) - grid.z(r - 1, c)) / step;
      const double cosine = std::max(1 / std::sqrt(1 + u * u + v * v), 1.0 / 3);
      bends.push_back(std::abs(grid.z(r, c - 1) - 2 * grid.z(r, c) + grid.z(r, c + 1)) * cosine);
    }
  return 1.4826 * median(std::move(bends)) / std::sqrt(6.0);
}

/// A return stays if it continues two neighbours, on one side of it or on both, in any of the four directions.
std::vector<std::uint8_t> screened(const Grid& grid) {
  std::vector<std::uint8_t> kept(grid.kept.size(), 0);
  for (int r = 0; r < grid.raster.height; ++r)
    for (int c = 0; c < grid.raster.width; ++c) {
      if (!grid.has(r, c)) continue;
      const double pitch = grid.pixel(grid.at(r, c));
      const double limit = 3 * std::sqrt(6.0) * 1.5 * grid.sigma + 0.3 * pitch;
      for (const auto& direction : directions) {
        const auto line = [&](int a, int b) {
          const auto [dr, dc] = direction;
          if (!grid.has(r + a * dr, c + a * dc) || !grid.has(r + b * dr, c + b * dc)) return false;
          const double z0 = grid.z(r, c), za = grid.z(r + a * dr, c + a * dc), zb = grid.z(r + b * dr, c + b * dc);
          const double bend = a == -1 ? za - 2 * z0 + zb : z0 - 2 * za + zb;
          return std::abs(bend) < limit && std::abs(z0 - za) < 6 * pitch + limit;
        };
        if (line(-1, 1) || line(1, 2) || line(-1, -2)) kept[grid.at(r, c)] = 1;
      }
    }
  return kept;
}

/// The local surface through a window.
struct Facet {
  Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
  bool fitted = false;  // its own side of a crease is clean
  bool smooth = false;  // the whole window is
  bool inlier = true;
  float variance = 1;  // of the place, relative to that of most
};

/// The returns of a window relative to its middle, in pixels.
struct Window {
  std::array<Vec3, 81> d;
  std::size_t count = 0;
};

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// z = x0 + x1 u + x2 v (+ x3 u^2 + x4 uv + x5 v^2) by iterated Welsch weights.
struct WindowFit {
  Vec6 x = Vec6::Zero();
  double rms = 1e30, share = 0;  // of the residuals in sigmas; of the weight that is left
  double slope() const { return std::sqrt(1 + x[1] * x[1] + x[2] * x[2]); }
  // Welsch weights of pure noise average 0.93.
  bool clean() const { return rms < 1.3 && share > 0.85; }
};

constexpr double least_noise = 0.01;  // pixels: below it curvature counts more

WindowFit fit_window(const Window& window, int terms, double sigma) {
  WindowFit fit;
  for (int round = 0; round < 4; ++round) {
    const double scale = std::max(sigma * std::min(fit.slope(), 3.0), least_noise);
    Mat6 a = Mat6::Zero();
    Vec6 b = Vec6::Zero(), row;
    double weights = 0, squares = 0;
    for (std::size_t k = 0; k < window.count; ++k) {
      const double u = window.d[k].x(), v = window.d[k].y();
      row << 1, u, v, u * u, u * v, v * v;
      const double e = window.d[k].z() - row.head(terms).dot(fit.x.head(terms));
      // The first round has no fit to weigh by.
      const double w = round == 0 ? 1 : std::exp(-e * e / (2 * 6.25 * scale * scale));
      a.topLeftCorner(terms, terms) += w * row.head(terms) * row.head(terms).transpose();
      b.head(terms) += w * window.d[k].z() * row.head(terms);
      weights += w, squares += w * e * e;
    }
    fit.rms = std::sqrt(squares / std::max(weights, 1e-12)) / scale;
    fit.share = weights / static_cast<double>(window.count);
    if (weights < terms + 2) return WindowFit{Vec6::Zero(), 1e30, 0};
    const Vec6 before = fit.x;
    fit.x.head(terms) = a.topLeftCorner(terms, terms).ldlt().solve(b.head(terms));
    if (!fit.x.allFinite()) return WindowFit{Vec6::Zero(), 1e30, 0};
    if ((fit.x - before).cwiseAbs().maxCoeff() < 1e-3 * scale) break;
  }
  return fit;
}

/// A plane, or a quadric where a plane leaves more than noise; beside a crease the plane of the cleanest half window.
Facet facet_at(const Grid& grid, int row, int column) {
  const std::size_t center = grid.at(row, column);
  const Vec3 p = grid.point[center];
  const double pitch = grid.pixel(center), sigma = grid.sigma / pitch;
  Window window;
  for (int r = row - grid.half; r <= row + grid.half; ++r)
    for (int c = column - grid.half; c <= column + grid.half; ++c) {
      if (!grid.has(r, c)) continue;
      const Vec3 q = (grid.point[grid.at(r, c)] - p) / pitch;
      const int steps = std::max(std::abs(r - row), std::abs(c - column));
      if (std::abs(q.z()) < 3.0 * steps + 5 * sigma) window.d[window.count++] = q;
    }
  Facet facet;
  facet.place = p;
  if (window.count < 8) return facet;
  WindowFit fit = fit_window(window, 3, sigma);
  if (!fit.clean() && window.count >= 16) {
    const WindowFit second = fit_window(window, 6, sigma);
    // A quadric can follow a sharp edge; its normal there is of neither side.
    const double bend = 2 * grid.half * second.x.tail<3>().cwiseAbs().maxCoeff() / (second.slope() * second.slope());
    if (second.clean() && bend < 0.25) fit = second;
  }
  const int side = 2 * grid.half + 1;
  facet.smooth = facet.fitted = fit.clean() && window.count >= static_cast<std::size_t>(side * side) * 3 / 5;
  if (!facet.smooth) {
    if (fit.clean()) facet.fitted = true;
    for (int k = 0; k < 8 && !fit.clean(); ++k) {
      Window half;
      const double a = std::cos(k * pi / 4), b = std::sin(k * pi / 4);
      for (std::size_t i = 0; i < window.count; ++i)
        if (a * window.d[i].x() + b * window.d[i].y() > -0.3) half.d[half.count++] = window.d[i];
      if (half.count < 8) continue;
      const WindowFit one = fit_window(half, 3, sigma);
      if (one.clean() && std::abs(one.x[0]) < 3 * std::max(sigma * one.slope(), least_noise) &&
          (!facet.fitted || one.rms < fit.rms))
        fit = one, facet.fitted = true;
    }
  }
  if (!(fit.rms < 1e30)) return facet;
  facet.normal = Vec3(fit.x[1], fit.x[2], -1).normalized();
  facet.inlier = std::abs(fit.x[0]) < 5 * std::max(sigma * fit.slope(), least_noise);
  // Along the normal, so that the places of neighbours stay as evenly spread as they were.
  if (facet.fitted) facet.place = p + facet.normal * (fit.x[0] * pitch * facet.normal.z());
  return facet;
}

std::vector<Facet> fitted_facets(Grid& grid, double pitch, int threads) {
  // A window wide enough that normals are good to about two degrees.
  grid.half = grid.sigma < 0.12 * pitch ? 2 : grid.sigma < 0.35 * pitch ? 3 : 4;
  std::vector<Facet> facets(grid.point.size());
  parallel_for(
      std::size_t(grid.raster.height), threads,
      [&](std::size_t begin, std::size_t end) {
        for (int r = static_cast<int>(begin); r < static_cast<int>(end); ++r)
          for (int c = 0; c < grid.raster.width; ++c)
            if (grid.has(r, c)) facets[grid.at(r, c)] = facet_at(grid, r, c);
      },
      8);
  return facets;
}

bool is_filtered(const PointCloud& cloud) {
  return cloud.normals.size() == cloud.size() && cloud.sigma.size() == cloud.size();
}

double median_sigma(const PointCloud& cloud) {
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if ((cloud.rejected.empty() || !cloud.rejected[i]) && cloud.sigma[i] > 0) sigmas.push_back(cloud.sigma[i]);
  return sigmas.empty() ? 0 : median(std::move(sigmas));
}

/// Most places are planes through windows of 25 returns.
double noise_before_filter(double usual) { return 5 * usual; }

/// What the filter found: its places follow curved surfaces and stay on their side of an edge. `usual`: the median of
/// its sigmas.
Facet filtered_facet(const PointCloud& cloud, std::size_t i, double usual) {
  Facet facet;
  facet.place = cloud.points[i], facet.normal = cloud.normals[i];
  facet.fitted = !facet.normal.isZero();
  facet.smooth = facet.fitted && cloud.sigma[i] < 4 * usual;
  facet.variance = static_cast<float>(std::pow(cloud.sigma[i] / usual, 2));
  return facet;
}

std::vector<Facet> filtered_facets(const PointCloud& cloud, const Grid& grid) {
  std::vector<Facet> facets(grid.point.size());
  const double usual = median_sigma(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i])
      facets[static_cast<std::size_t>(cloud.pixel[i])] = filtered_facet(cloud, i, usual);
  return facets;
}

/// Borders: a fitted, not too slanted return beyond which three pixels are missing or deeper.
std::vector<ContourPoint> contour_of(const Grid& grid, const std::vector<Facet>& facets) {
  std::vector<ContourPoint> result;
  for (int r = 0; r < grid.raster.height; ++r)
    for (int c = 0; c < grid.raster.width; ++c) {
      const std::size_t i = grid.at(r, c);
      const Facet& facet = facets[i];
      if (!facet.fitted) continue;
      const double slant = -facet.normal.dot(grid.raster.ray(facet.place));
      if (slant < 0.57) continue;  // 55 degrees; beyond 60 returns get thin and borders ragged
      const double pitch = grid.pixel(i);
      for (const auto& [dr, dc] : {std::array{0, 1}, std::array{0, -1}, std::array{1, 0}, std::array{-1, 0}}) {
        bool border = grid.in(r + 3 * dr, c + 3 * dc) && grid.has(r - dr, c - dc) && grid.has(r - 2 * dr, c - 2 * dc);
        // A return that was screened out is no gap: the border would move inward.
        for (int k = 1; border && k <= 3; ++k) {
          const std::size_t beside = grid.at(r + k * dr, c + k * dc);
          border =
              !grid.returned[beside] || (grid.kept[beside] && grid.point[beside].z() > facet.place.z() + 3 * k * pitch);
        }
        if (!border) continue;
        // Where the sight half a pixel farther out meets the plane.
        const double u = (c + 0.5 * dc - grid.raster.cx) / grid.raster.fx,
                     v = (r + 0.5 * dr - grid.raster.cy) / grid.raster.fy;
        const Vec3 n = facet.normal, p = facet.place;
        const Vec3 edge = grid.raster.pinhole ? Vec3(Vec3(u, v, 1) * (n.dot(p) / n.dot(Vec3(u, v, 1))))
                                              : Vec3(u, v, p.z() - (n.x() * (u - p.x()) + n.y() * (v - p.y())) / n.z());
        const double z = grid.raster.pinhole ? edge.z() : 1;
        const Vec3 step(dc / grid.raster.fx * z, dr / grid.raster.fy * z, 0);
        const Vec3 ray = grid.raster.ray(edge);
        result.push_back({edge, n, (step - step.dot(ray) * ray).normalized(), step.norm()});
      }
    }
  return result;
}

void add_facet(const Facet& facet, const Vec3& measured, std::size_t pixel, ViewSurface& surface) {
  surface.points.push_back(facet.place), surface.measured.push_back(measured), surface.normals.push_back(facet.normal);
  surface.smooth.push_back(facet.smooth), surface.variance.push_back(facet.variance);
  surface.pixels.push_back(static_cast<std::uint32_t>(pixel));
}

/// What add_grid makes of a filtered image whose points come pixel by pixel, without its borders, in a fraction of the
/// time.
void add_filtered(const RegisterView& view, ViewSurface& surface) {
  SightRaster& raster = surface.raster;
  const PointCloud& cloud = view.cloud;
  const double usual = median_sigma(cloud);
  raster.depth.assign(std::size_t(raster.width) * std::size_t(raster.height), -1.f);
  const auto reserve = [&](auto&... columns) { (columns.reserve(cloud.size()), ...); };
  reserve(surface.points, surface.measured, surface.normals, surface.smooth, surface.variance, surface.pixels);
  std::vector<double> depths;
  depths.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    const auto pixel = static_cast<std::size_t>(cloud.pixel[i]);
    depths.push_back(cloud.points[i].z()), raster.depth[pixel] = static_cast<float>(cloud.points[i].z());
    if (!cloud.normals[i].isZero())
      add_facet(filtered_facet(cloud, i, usual), view.measured.empty() ? cloud.points[i] : view.measured[i], pixel,
                surface);
  }
  surface.sigma = noise_before_filter(usual);
  surface.spacing =
      depths.empty()
          ? 0
          : std::abs((raster.pinhole ? median(std::move(depths)) : 1) / std::sqrt(std::abs(raster.fx * raster.fy)));
}

bool pixel_by_pixel(const PointCloud& cloud) {
  return std::adjacent_find(cloud.pixel.begin(), cloud.pixel.end(), std::greater_equal<>()) == cloud.pixel.end();
}

void add_grid(const RegisterView& view, ViewSurface& surface, bool contours, int threads) {
  if (!contours && is_filtered(view.cloud) && pixel_by_pixel(view.cloud)) return add_filtered(view, surface);
  SightRaster& raster = surface.raster;
  Grid grid{raster, {}, {}, {}};
  const std::size_t pixels = std::size_t(raster.width) * std::size_t(raster.height);
  grid.point.resize(pixels, Vec3::Zero()), grid.kept.resize(pixels, 0), grid.returned.resize(pixels, 0);
  const PointCloud& cloud = view.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto pixel = static_cast<std::size_t>(cloud.pixel[i]);
    grid.returned[pixel] = 1;
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    grid.point[pixel] = cloud.points[i], grid.kept[pixel] = 1;
  }
  std::vector<Vec3> measured = grid.point;
  for (std::size_t i = 0; i < view.measured.size(); ++i)
    measured[static_cast<std::size_t>(cloud.pixel[i])] = view.measured[i];
  const auto before = static_cast<std::size_t>(std::count(grid.kept.begin(), grid.kept.end(), 1));
  const bool filtered = is_filtered(cloud);
  grid.sigma = filtered ? noise_before_filter(median_sigma(cloud)) : depth_noise(grid);
  if (!filtered) grid.kept = screened(grid);
  std::vector<double> pitches;
  for (std::size_t i = 0; i < pixels; ++i)
    if (grid.kept[i]) pitches.push_back(grid.pixel(i));
  const double pitch = median(std::move(pitches));
  const std::vector<Facet> facets = filtered ? filtered_facets(cloud, grid) : fitted_facets(grid, pitch, threads);
  raster.depth.assign(pixels, -1.f);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!grid.kept[i]) continue;
    const Facet& facet = facets[i];
    if (!facet.inlier) continue;
    raster.depth[i] = static_cast<float>(grid.point[i].z());
    if (facet.normal.isZero()) continue;
    add_facet(facet, measured[i], i, surface);
  }
  surface.rejected = before - static_cast<std::size_t>(std::count_if(raster.depth.begin(), raster.depth.end(),
                                                                     [](float z) { return z >= 0; }));
  if (contours) surface.contour = contour_of(grid, facets);
  surface.sigma = grid.sigma, surface.spacing = pitch;
}

/// The direction in which a view without rays was seen: most normals' lines lie along it, and the part bulges against
/// it.
Vec3 sight_direction(const std::vector<Vec3>& points, const std::vector<Vec3>& normals) {
  // The lines of the normals fill a half space; the thinnest extent of the points serves where they do not tell.
  Mat3 spread = Mat3::Zero();
  for (const Vec3& n : normals) spread += n * n.transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
  Vec3 best = eigen.eigenvectors().col(2);
  double best_score = -1;
  // A range image is a height field: along its direction of sight few normals stand across.
  for (const auto& a : {0, 1, 2})
    for (int i = -4; i <= 4; ++i)
      for (int j = -4; j <= 4; ++j) {
        Vec3 d;
        d[a] = 1, d[(a + 1) % 3] = i / 4.0, d[(a + 2) % 3] = j / 4.0;
        d.normalize();
        double score = 0;
        for (std::size_t k = 0; k < normals.size(); k += 7) score += std::abs(normals[k].dot(d)) > 0.2;
        if (score > best_score) best_score = score, best = d;
      }
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  // Normals on a bulge point away from the middle.
  double bulge = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vec3 across = (points[k] - mean) - (points[k] - mean).dot(best) * best;
    const Vec3 n = normals[k].dot(best) < 0 ? normals[k] : Vec3(-normals[k]);
    bulge += n.dot(across);
  }
  return bulge >= 0 ? best : Vec3(-best);
}

/// Where the rays meet, if they do.
std::optional<Vec3> sensor_of(const PointCloud& cloud) {
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Mat3 across = Mat3::Identity() - cloud.rays[i] * cloud.rays[i].transpose();
    a += across, b += across * cloud.points[i];
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(a / static_cast<double>(cloud.size()));
  if (eigen.eigenvalues()[0] < 1e-5) return {};
  return Vec3(solve_ldlt(a, b));
}

/// A raster across an unorganised view, two spacings wide.
void add_raster(const RegisterView& view, ViewSurface& surface) {
  SightRaster& raster = surface.raster;
  const PointCloud& cloud = view.cloud;
  Vec3 direction = Vec3::Zero();
  if (cloud.rays.size() == cloud.size()) {
    for (const Vec3& r : cloud.rays) direction += r;
    if (const auto sensor = sensor_of(cloud)) raster.pinhole = true, raster.origin = *sensor;
  }
  if (direction.norm() < 1e-9 * static_cast<double>(cloud.size()))
    direction = sight_direction(surface.points, surface.normals);
  raster.axes = rotation_onto_axis(direction.normalized());
  for (std::size_t i = 0; i < surface.normals.size(); ++i)
    if (surface.normals[i].dot(raster.ray(surface.points[i])) > 0) surface.normals[i] = -surface.normals[i];
  if (!raster.pinhole) {  // depths stay positive
    double low = 1e30;
    for (const Vec3& p : surface.points) low = std::min(low, raster.axes.col(2).dot(p));
    raster.origin = (low - 1e3) * raster.axes.col(2);
  }
  Box3 box;
  for (const Vec3& p : surface.points) box.add(raster.project(p));
  const double depth = box.center().z();
  const double cell = 2 * surface.spacing / (raster.pinhole ? depth : 1);
  raster.fx = raster.fy = 1 / cell;
  raster.cx = 3 - box.low.x() / cell, raster.cy = 3 - box.low.y() / cell;
  raster.width = std::min(4096, static_cast<int>(box.size().x() / cell) + 7);
  raster.height = std::min(4096, static_cast<int>(box.size().y() / cell) + 7);
  raster.depth.assign(std::size_t(raster.width) * std::size_t(raster.height), -1.f);
  for (const Vec3& p : surface.points) {
    const Vec3 at = raster.project(p);
    const long c = std::lround(at.x()), r = std::lround(at.y());
    if (c < 0 || r < 0 || c >= raster.width || r >= raster.height) continue;
    float& z = raster.depth[std::size_t(r) * std::size_t(raster.width) + std::size_t(c)];
    if (z < 0 || at.z() < z) z = static_cast<float>(at.z());
  }
}

constexpr std::size_t most_unorganised = 40000;

void add_unorganised(const RegisterView& view, ViewSurface& surface, Context& context) {
  PointCloud cloud;
  const double spacing = spacing_for_count(view.cloud.points, view.cloud.rejected, most_unorganised);
  for (const auto i : thinned(view.cloud.points, view.cloud.rejected, spacing)) {
    cloud.points.push_back(view.cloud.points[i]);
    if (view.cloud.rays.size() == view.cloud.size()) cloud.rays.push_back(view.cloud.rays[i]);
  }
  if (cloud.size() < 50) return;
  const SamplingSummary summary = estimate_normals(cloud, {}, context);
  if (context.cancelled) return;
  surface.spacing = std::max(summary.spacing, spacing), surface.sigma = summary.sigma;
  surface.rejected = summary.rejected;
  std::vector<Vec3> raw;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!cloud.rejected[i] && !cloud.normals[i].isZero())
      raw.push_back(cloud.points[i]), surface.normals.push_back(cloud.normals[i]);
  surface.points = surface.measured = raw, surface.smooth.assign(raw.size(), 0), surface.variance.assign(raw.size(), 1);
  if (raw.empty()) return;
  const KdTree tree(raw);
  const double width = std::max(1.5 * surface.spacing, 3 * surface.sigma);
  parallel_for(raw.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    std::vector<double> angles;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest(raw[i], 16, near);
      const Vec3& n = surface.normals[i];
      const Mat3 frame = rotation_onto_axis(n);
      double weights = 0, heights = 0, bend = 0;
      angles.clear();
      for (const Neighbour& neighbour : near) {
        const Vec3 d = frame.transpose() * (raw[neighbour.index] - raw[i]);
        const double agree = std::abs(n.dot(surface.normals[neighbour.index]));
        const double w = std::exp(-d.z() * d.z() / (2 * width * width)) * std::pow(agree, 4);
        weights += w, heights += w * d.z();
        bend += agree < 0.85;
        if (neighbour.index != i) angles.push_back(std::atan2(d.y(), d.x()));
      }
      std::sort(angles.begin(), angles.end());
      double gap = angles.empty() ? 2 * pi : angles.front() + 2 * pi - angles.back();
      for (std::size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
      surface.points[i] = raw[i] + n * (heights / weights);
      surface.smooth[i] =
          gap < 2.0 && bend < 3 &&
          std::abs(heights / weights) < 2 * std::max(surface.sigma, 0.02 * surface.spacing) + 0.1 * surface.spacing;
    }
  });
  add_raster(view, surface);
}

ViewSurface surface_of_view(const RegisterView& view, int samples, bool contours, Context& context) {
  ViewSurface surface;
  if (view.cloud.size() < 50) return surface;
  if (auto camera = camera_of(view)) {
    surface.raster = std::move(*camera), surface.organised = true;
    add_grid(view, surface, contours, context.threads);
  } else {
    add_unorganised(view, surface, context);
  }
  if (surface.points.empty()) return surface;
  for (const Vec3& p : surface.points) surface.center += p;
  surface.center /= static_cast<double>(surface.points.size());
  for (const Vec3& p : surface.points) surface.radius += (p - surface.center).squaredNorm();
  surface.radius = std::sqrt(surface.radius / static_cast<double>(surface.points.size()));
  std::vector<std::uint32_t> smooth;
  for (std::uint32_t i = 0; i < surface.points.size(); ++i)
    if (surface.smooth[i]) smooth.push_back(i);
  surface.samples =
      spread_sample(surface.points, surface.normals, smooth, static_cast<std::size_t>(std::max(samples, 50)));
  return surface;
}

}  // namespace

std::vector<ViewSurface> view_surfaces(const std::vector<RegisterView>& views, int samples, Context& context,
                                       bool contours) {
  std::vector<ViewSurface> surfaces(views.size());
  for (std::size_t v = 0; v < views.size() && !context.cancelled; ++v) {
    context.report("looking at views", static_cast<double>(v) / static_cast<double>(views.size()));
    ViewSurface& surface = surfaces[v];
    surface = surface_of_view(views[v], samples, contours, context);
    if (surface.points.empty()) continue;
    surface.cosine.resize(surface.points.size());
    for (std::size_t i = 0; i < surface.points.size(); ++i)
      surface.cosine[i] = -surface.normals[i].dot(surface.raster.ray(surface.points[i]));
    // Trees and grids refer to their points: they are built where the surface stays.
    if (surface.organised) {
      const SightRaster& r = surface.raster;
      surface.grid = std::make_unique<PixelGrid>(PixelCamera{r.pinhole, r.fx, r.fy, r.cx, r.cy, r.width, r.height},
                                                 surface.pixels, surface.points);
      surface.tree = std::make_unique<KdTree>(surface.points, surface.grid->order());
    } else {
      surface.tree = std::make_unique<KdTree>(surface.points);
    }
    if (contours) {
      for (const auto i : surface.samples) surface.sample_points.push_back(surface.points[i]);
      surface.sample_tree = std::make_unique<KdTree>(surface.sample_points);
    }
    surface.bendings = FoundOnce<Mat3>(surface.samples.size());
  }
  return surfaces;
}

}  // namespace partscribe::scan
