#include "geometry/points/thin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/ensure.h"
#include "core/large_memory.h"

namespace partscribe::geometry {
namespace {

using Cell = std::array<std::int64_t, 3>;

Cell cell_of(const Vec3& p, double spacing) {
  return {static_cast<std::int64_t>(std::floor(p.x() / spacing)),
          static_cast<std::int64_t>(std::floor(p.y() / spacing)),
          static_cast<std::int64_t>(std::floor(p.z() / spacing))};
}

int compared(const Vec3& a, const Vec3& b) {
  for (int k = 0; k < 3; ++k)
    if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
  return 0;
}

std::vector<std::uint32_t> usable(const std::vector<Vec3>& points, const std::vector<std::uint8_t>& rejected) {
  ensure(rejected.empty() || rejected.size() == points.size(), "one flag per point, or none at all");
  std::vector<std::uint32_t> result;
  result.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((rejected.empty() || !rejected[i]) && points[i].allFinite()) result.push_back(static_cast<std::uint32_t>(i));
  return result;
}

bool before(const std::vector<Vec3>& points, std::uint32_t a, std::uint32_t b) {
  const int c = compared(points[a], points[b]);
  return c != 0 ? c < 0 : a < b;
}

/// What of a coordinate fits into two digits, and whose it is.
struct Keyed {
  static constexpr int bits = 11;  // of a digit
  std::uint32_t key, index;
};

/// By counting digits, the last first: what is equal stays in order. `other` is as long.
void sort_by_key(std::span<Keyed> items, std::span<Keyed> other) {
  constexpr std::size_t values = std::size_t(1) << Keyed::bits;
  std::array<std::uint32_t, 2 * values> counts{};
  for (const Keyed& item : items) ++counts[item.key & (values - 1)], ++counts[values + (item.key >> Keyed::bits)];
  for (std::size_t first : {std::size_t(0), values}) {
    std::uint32_t sum = 0;
    for (std::size_t v = 0; v < values; ++v) sum += std::exchange(counts[first + v], sum);
  }
  for (const Keyed& item : items) other[counts[item.key & (values - 1)]++] = item;
  for (const Keyed& item : other) items[counts[values + (item.key >> Keyed::bits)]++] = item;
}

/// Sorts by the coordinates from `axis` on; the ones before are equal.
void sort_items(const std::vector<Vec3>& points, std::span<Keyed> items, std::span<Keyed> other, Eigen::Index axis) {
  const auto by_comparing = [&] {
    const auto in_order = [&](const Keyed& a, const Keyed& b) { return before(points, a.index, b.index); };
    // All points of a column of an image have one x, and mostly they are in order.
    if (!std::is_sorted(items.begin(), items.end(), in_order)) std::sort(items.begin(), items.end(), in_order);
  };
  if (items.size() < 2000) return by_comparing();
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Keyed& item : items)
    low = std::min(low, points[item.index][axis]), high = std::max(high, points[item.index][axis]);
  if (low == high && axis < 2) return sort_items(points, items, other, axis + 1);
  const double scale = ((1 << 2 * Keyed::bits) - 1) / (high - low);
  if (!(scale > 0 && std::isfinite(scale))) return by_comparing();
  for (Keyed& item : items) {
    const double place = (points[item.index][axis] - low) * scale;
    item.key = place > 0 ? static_cast<std::uint32_t>(place) : 0;
  }
  sort_by_key(items, other);
  for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end) {
    while (end < items.size() && items[end].key == items[begin].key) ++end;
    if (end - begin > 1) sort_items(points, items.subspan(begin, end - begin), other.subspan(begin, end - begin), axis);
  }
}

void sort_by_coordinates(const std::vector<Vec3>& points, std::vector<std::uint32_t>& order) {
  LargeVector<Keyed> items(order.size()), other(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) items[k] = {0, order[k]};
  sort_items(points, items, other, 0);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = items[k].index;
}

/// How many cubes of edge `spacing` hold a point; stops counting above `limit`.
std::size_t occupied(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& kept, double spacing,
                     std::size_t limit, std::vector<std::uint64_t>& table) {
  std::fill(table.begin(), table.end(), 0);
  const std::size_t mask = table.size() - 1;
  std::size_t count = 0;
  for (const std::uint32_t i : kept) {
    const Cell cell = cell_of(points[i], spacing);
    std::uint64_t key = 0x9e3779b97f4a7c15ull;
    for (const std::int64_t c : cell) {
      key ^= static_cast<std::uint64_t>(c);
      key *= 0xbf58476d1ce4e5b9ull;
      key ^= key >> 29;
    }
    if (key == 0) key = 1;
    // Two cubes with one 64-bit key are counted once: the count may be low by a point in 10^13.
    std::size_t slot = key & mask;
    while (table[slot] != 0 && table[slot] != key) slot = (slot + 1) & mask;
    if (table[slot] == 0) {
      table[slot] = key;
      if (++count > limit) return count;
    }
  }
  return count;
}

}  // namespace

std::vector<std::uint32_t> coordinate_order(const std::vector<Vec3>& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  sort_by_coordinates(points, order);
  return order;
}

std::vector<std::uint32_t> thinned(const std::vector<Vec3>& points, const std::vector<std::uint8_t>& rejected,
                                   double spacing) {
  ensure(spacing >= 0, "a spacing is not negative");
  std::vector<std::uint32_t> kept = usable(points, rejected);
  sort_by_coordinates(points, kept);
  if (spacing == 0) return kept;
  struct Entry {
    Cell cell;
    std::uint32_t index;
  };
  std::vector<Entry> entries;
  entries.reserve(kept.size());
  for (const std::uint32_t i : kept) entries.push_back({cell_of(points[i], spacing), i});
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.cell < b.cell; });
  std::vector<std::uint32_t> result;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    Vec3 sum = Vec3::Zero();
    for (end = begin; end < entries.size() && entries[end].cell == entries[begin].cell; ++end)
      sum += points[entries[end].index];
    const Vec3 centroid = sum / static_cast<double>(end - begin);
    std::size_t best = begin;
    double best_distance = (points[entries[begin].index] - centroid).squaredNorm();
    for (std::size_t e = begin + 1; e < end; ++e) {
      const double distance = (points[entries[e].index] - centroid).squaredNorm();
      if (distance < best_distance) best = e, best_distance = distance;
    }
    result.push_back(entries[best].index);
  }
  return result;
}

double spacing_for_count(const std::vector<Vec3>& points, std::size_t target) {
  return spacing_for_count(points, {}, target);
}

double spacing_for_count(const std::vector<Vec3>& points, const std::vector<std::uint8_t>& rejected,
                         std::size_t target) {
  const std::vector<std::uint32_t> kept = usable(points, rejected);
  target = std::max<std::size_t>(target, 1);
  if (kept.size() <= target) return 0;
  Box3 box;
  for (const std::uint32_t i : kept) box.add(points[i]);
  const double size = std::max(box.diagonal(), 1e-9);
  std::size_t slots = 1024;
  while (slots < 2 * (target + 1)) slots *= 2;
  std::vector<std::uint64_t> table(slots);
  double low = std::log(size * 1e-7), high = std::log(size * 4);
  for (int step = 0; step < 16; ++step) {
    const double middle = 0.5 * (low + high);
    (occupied(points, kept, std::exp(middle), target, table) > target ? low : high) = middle;
  }
  return std::exp(high);
}

}  // namespace partscribe::geometry
