#include "scan/register/register_relief.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"

namespace partscribe::scan {
namespace {

/// Heights over the profile on cells along and about the axis.
struct Relief {
  int rows = 0, columns = 0;  ///< columns go once around
  std::vector<float> height;  ///< 0 where nothing is known
  std::vector<std::uint8_t> known;
};

constexpr int wide = 3;       // cells to either side; relief is what is smaller
constexpr double fewest = 3;  // points of a cell
constexpr double most_high =
    0.04;  // of the part's radius: how far from the profile relief may be, on a part that is smooth elsewhere

std::size_t at(int row, int column, int columns) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

/// Sums over squares of (2 half + 1)^2 cells; columns wrap.
std::vector<double> box_sums(const std::vector<double>& cells, int rows, int columns, int half) {
  std::vector<double> across(cells.size()), result(cells.size());
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      for (int k = -half; k <= half; ++k)
        across[at(r, c, columns)] += cells[at(r, (c + k + columns) % columns, columns)];
  for (int r = 0; r < rows; ++r)
    for (int k = std::max(0, r - half); k <= std::min(rows - 1, r + half); ++k)
      for (int c = 0; c < columns; ++c) result[at(r, c, columns)] += across[at(k, c, columns)];
  return result;
}

Relief relief_of(const RoundViews& round, std::size_t v, const PointCloud& cloud, double radius, double cell,
                 int columns) {
  const RadiusProfile& profile = round.profile;
  const double width = std::max(round.width, most_high * radius);
  Relief relief{static_cast<int>(std::ceil(double(profile.radius.size()) * profile.bin / cell)), columns, {}, {}};
  const std::size_t count = at(relief.rows, 0, columns);
  std::vector<double> sums(count), weights(count);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    const CylinderPlace c = place_about(round.frames[v], round.depth * cloud.points[i]);
    const auto here = profile.at(c.along);
    if (!here) continue;
    const double e = c.radius - here->first, w = std::exp(-e * e / (2 * width * width));
    const int row = static_cast<int>((c.along - profile.start) / cell),
              column = static_cast<int>((c.angle + pi) / (2 * pi) * columns) % columns;
    if (row >= relief.rows) continue;
    sums[at(row, column, columns)] += w * e, weights[at(row, column, columns)] += w;
  }
  const auto around = box_sums(sums, relief.rows, columns, wide),
             around_weights = box_sums(weights, relief.rows, columns, wide);
  relief.height.resize(count), relief.known.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    relief.known[k] = weights[k] >= fewest;
    if (relief.known[k]) relief.height[k] = static_cast<float>(sums[k] / weights[k] - around[k] / around_weights[k]);
  }
  return relief;
}

/// What all views show at the same place of their own frames stands still, or is the sensor's: its mean is taken off.
void take_off_what_stands(std::vector<Relief>& reliefs) {
  for (std::size_t k = 0; k < reliefs[0].height.size(); ++k) {
    float sum = 0;
    int count = 0;
    for (const Relief& r : reliefs) sum += r.height[k], count += r.known[k];
    for (Relief& r : reliefs)
      if (r.known[k]) r.height[k] -= sum / float(count);
  }
}

struct Shift {
  int rows = 0, columns = 0;  ///< the first view at (r + rows, c + columns) shows what the second does at (r, c)
  double correlation = 0;
  double significance = 0;  ///< the correlation times the root of the number of cells
};

Shift alike_at(const Relief& a, const Relief& b, int rows, int columns) {
  double ab = 0, aa = 0, bb = 0;
  int n = 0;
  for (int r = std::max(0, -rows); r < std::min(b.rows, a.rows - rows); ++r)
    for (int c = 0; c < b.columns; ++c) {
      const std::size_t i = at(r + rows, (c + columns) % a.columns, a.columns), j = at(r, c, b.columns);
      if (!a.known[i] || !b.known[j]) continue;
      const double x = a.height[i], y = b.height[j];
      ab += x * y, aa += x * x, bb += y * y, ++n;
    }
  Shift s{rows, columns};
  if (aa > 0 && bb > 0) s.correlation = ab / std::sqrt(aa * bb), s.significance = s.correlation * std::sqrt(double(n));
  return s;
}

/// Where two reliefs are most alike, if nowhere else nearly so.
std::optional<Shift> best_shift(const Relief& a, const Relief& b, Context& context) {
  constexpr int most_rows = 6;      // of cells; what the axes leave open along them
  constexpr double clear = 1.3;     // times as significant as any other place
  constexpr double over_usual = 8;  // and this many times as the median of all
  constexpr int same_place = 6;     // columns
  const int columns = a.columns;
  std::vector<Shift> shifts(std::size_t(columns) * (2 * most_rows + 1));
  parallel_for(
      shifts.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
          shifts[k] = alike_at(a, b, static_cast<int>(k) / columns - most_rows, static_cast<int>(k) % columns);
      },
      16);
  Shift best, second;
  std::vector<double> sizes;
  for (const Shift& s : shifts) {
    sizes.push_back(std::abs(s.significance));
    if (s.significance > best.significance) best = s;
  }
  for (const Shift& s : shifts) {
    const int apart = std::abs(s.columns - best.columns);
    if (std::min(apart, columns - apart) > same_place && s.significance > second.significance) second = s;
  }
  const double usual = median(std::move(sizes));
  context.say("relief alike after " + print_number(best.columns * 360.0 / columns) + " degrees, correlation " +
              print_number(best.correlation) + ", significance " + print_number(best.significance) + "; elsewhere " +
              print_number(second.significance) + ", usually " + print_number(usual));
  if (!(best.significance > 0) || best.significance < clear * second.significance ||
      best.significance < over_usual * usual)
    return {};
  return best;
}

/// The motion that lays the axis of one view onto that of another, turned and slid.
Pose moved_along(const AxisFrame& to, const AxisFrame& from, double angle, double slide) {
  Mat3 a, b;
  a << to.across, to.beside, to.line.axis;
  b << from.across, from.beside, from.line.axis;
  const Mat3 rotation = a * rotation_of(Vec3(0, 0, angle)) * b.transpose();
  return {rotation, to.line.point + slide * to.line.axis - rotation * from.line.point};
}

}  // namespace

std::optional<std::vector<Pose>> poses_by_relief(const std::vector<RegisterView>& views, const RoundViews& round,
                                                 double cell, Context& context) {
  std::vector<double> radii;
  for (const double r : round.profile.radius)
    if (r >= 0) radii.push_back(r);
  const double radius = median(std::move(radii));
  const int columns = static_cast<int>(2 * pi * radius / cell);
  if (columns < 8 * wide) return {};
  std::vector<Relief> reliefs(views.size());
  parallel_for(
      views.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
          reliefs[v] = relief_of(round, v, views[v].cloud, radius, cell, columns);
      },
      1);
  take_off_what_stands(reliefs);
  std::vector<Pose> poses{Pose{}};
  for (std::size_t v = 0; v + 1 < views.size(); ++v) {
    const auto shift = best_shift(reliefs[v], reliefs[v + 1], context);
    if (!shift) return {};
    poses.push_back(poses.back() * moved_along(round.frames[v], round.frames[v + 1], 2 * pi * shift->columns / columns,
                                               cell * shift->rows));
  }
  return poses;
}

}  // namespace partscribe::scan
