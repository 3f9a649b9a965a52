#include "geometry/points/repeated_places.h"

#include <algorithm>

#include "geometry/points/thin.h"

namespace partscribe::geometry {

RepeatedPlaces repeated_places(const std::vector<Vec3>& points, bool image) {
  constexpr std::size_t many = 30, times = 10;  // least repeats, and how far above the usual
  struct Run {
    std::size_t begin, end;
    std::size_t size() const { return end - begin; }
  };
  RepeatedPlaces result;
  const auto order = coordinate_order(points);
  std::vector<Run> runs;  // of one place each
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && points[order[end]] == points[order[begin]]) ++end;
    runs.push_back({begin, end});
  }
  if (runs.empty()) return result;
  const auto place = [&](const Run& run) -> const Vec3& { return points[order[run.begin]]; };
  const auto at_zero = [&](const Run& run) { return place(run) == Vec3::Zero(); };
  std::vector<std::size_t> sizes;
  for (const Run& run : runs) sizes.push_back(run.size());
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const std::size_t limit = std::max(many, times * *middle);
  std::size_t most_usual = 1;
  for (const Run& run : runs)
    if (run.size() <= limit && !at_zero(run)) most_usual = std::max(most_usual, run.size());
  const auto leave_out = [&](std::size_t begin, std::size_t end) {
    if (result.kept.empty()) result.kept.assign(points.size(), 1);
    for (std::size_t k = begin; k < end; ++k) result.kept[order[k]] = 0;
  };
  for (const Run& run : runs) {
    if (at_zero(run) && (image || run.size() > most_usual)) {
      result.zeros = run.size();
      leave_out(run.begin, run.end);
    } else if (run.size() > limit) {
      ++result.places, result.copies += run.size() - 1;
      leave_out(run.begin + 1, run.end);
    }
  }
  return result;
}

}  // namespace partscribe::geometry
