#include "cli/report/report_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

namespace partscribe::cli {
namespace {

constexpr int levels = 20;

/// Interleaves the low `levels` bits of three numbers.
std::uint64_t interleaved(const std::array<std::uint32_t, 3>& cell) {
  std::uint64_t key = 0;
  for (int bit = levels - 1; bit >= 0; --bit)
    for (const auto c : cell) key = key << 1 | (c >> bit & 1u);
  return key;
}

struct Keyed {
  std::uint64_t key;
  std::uint32_t index;
};

/// Points first..last-1 of the sorted list: a cell of the octree.
struct Cell {
  std::size_t first, last;
  int level;
  double score;
  std::uint32_t stands;  ///< place in the sorted list of the point shown
  float worst;           ///< largest difference of a value to that of the point shown
  bool operator<(const Cell& other) const { return score != other.score ? score < other.score : first > other.first; }
};

}  // namespace

ShownPoints shown_points(const std::vector<Vec3>& points, const std::vector<float>& values, double scale,
                         std::size_t most) {
  ShownPoints shown;
  Box3 box;
  std::vector<Keyed> sorted;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (std::isfinite(values[i])) box.add(points[i]), sorted.push_back({0, i});
  shown.of = sorted.size();
  if (sorted.empty() || most == 0) return shown;
  const double edge = std::max(box.size().maxCoeff(), 1e-9) * (1 + 1e-9), cells = static_cast<double>(1u << levels);
  for (auto& s : sorted) {
    std::array<std::uint32_t, 3> cell{};
    for (int axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::uint32_t>((points[s.index][axis] - box.low[axis]) / edge * cells);
    s.key = interleaved(cell);
  }
  // Equal keys are ordered by what the points are, not by where they stood in the file.
  std::sort(sorted.begin(), sorted.end(), [&](const Keyed& a, const Keyed& b) {
    if (a.key != b.key) return a.key < b.key;
    const Vec3 &p = points[a.index], &q = points[b.index];
    return std::array{p.x(), p.y(), p.z(), static_cast<double>(values[a.index])} <
           std::array{q.x(), q.y(), q.z(), static_cast<double>(values[b.index])};
  });
  auto value = [&](std::size_t k) { return values[sorted[k].index]; };

  auto cell_of = [&](std::size_t first, std::size_t last, int level) {
    float low = value(first), high = low;
    for (std::size_t k = first; k < last; ++k) low = std::min(low, value(k)), high = std::max(high, value(k));
    const float middle = 0.5f * (low + high);
    Cell cell{first, last, level, 0, static_cast<std::uint32_t>(first), 0};
    float nearest = std::abs(value(first) - middle);
    for (std::size_t k = first; k < last; ++k)
      if (const float gap = std::abs(value(k) - middle); gap < nearest)
        nearest = gap, cell.stands = static_cast<std::uint32_t>(k);
    for (std::size_t k = first; k < last; ++k)
      cell.worst = std::max(cell.worst, std::abs(value(k) - value(cell.stands)));
    // A cell of a sixtieth of the part weighs as much as a difference of a fifth of the scale within it.
    const double size = std::ldexp(1.0, -level);
    cell.score = last - first < 2 || level >= levels ? -1 : (high - low) / scale + 12 * size;
    return cell;
  };
  std::priority_queue<Cell> queue;
  queue.push(cell_of(0, sorted.size(), 0));
  const auto [lowest, highest] = std::minmax_element(
      sorted.begin(), sorted.end(), [&](const Keyed& a, const Keyed& b) { return values[a.index] < values[b.index]; });
  const std::size_t room = most > 2 ? most - 2 : most;
  while (queue.size() + 7 <= room && queue.top().score >= 0) {
    const Cell cell = queue.top();
    queue.pop();
    const int shift = 3 * (levels - 1 - cell.level);
    for (std::size_t first = cell.first, last = first; first < cell.last; first = last) {
      const auto octant = sorted[first].key >> shift;
      while (last < cell.last && sorted[last].key >> shift == octant) ++last;
      queue.push(cell_of(first, last, cell.level + 1));
    }
  }
  for (; !queue.empty(); queue.pop()) {
    const Cell& cell = queue.top();
    const Vec3& place = points[sorted[cell.stands].index];
    shown.index.push_back(sorted[cell.stands].index);
    shown.value_error = std::max(shown.value_error, static_cast<double>(cell.worst));
    for (std::size_t k = cell.first; k < cell.last; ++k)
      shown.distance = std::max(shown.distance, (points[sorted[k].index] - place).norm());
  }
  if (most > 2) shown.index.insert(shown.index.end(), {lowest->index, highest->index});
  std::sort(shown.index.begin(), shown.index.end());
  shown.index.erase(std::unique(shown.index.begin(), shown.index.end()), shown.index.end());
  return shown;
}

}  // namespace partscribe::cli
