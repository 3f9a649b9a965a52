#include "geometry/images/enclosed_by_edges.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/ensure.h"
#include "geometry/vec.h"

namespace partscribe::geometry {
namespace {

/// Marks over the pixels of an image.
struct Marks {
  int width = 0, height = 0;
  std::vector<std::uint8_t> on;

  bool has(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  bool at(int x, int y) const { return has(x, y) && on[index(x, y)]; }
};

struct Pixel {
  int x = 0, y = 0;
  bool operator==(const Pixel&) const = default;
};

Vec2 place(const Pixel& p) { return {p.x, p.y}; }

/// Pixels that are connected to the first one, nearest first, and how many steps away they are.
struct Connected {
  std::vector<Pixel> pixels;
  std::vector<int> steps;
};

Connected connected_to(const Marks& marks, const Pixel& first, int most_steps) {
  Connected result{{first}, {0}};
  for (std::size_t k = 0; k < result.pixels.size() && result.steps[k] < most_steps; ++k)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const Pixel next{result.pixels[k].x + dx, result.pixels[k].y + dy};
        if (!marks.at(next.x, next.y) || std::ranges::find(result.pixels, next) != result.pixels.end()) continue;
        result.pixels.push_back(next), result.steps.push_back(result.steps[k] + 1);
      }
  return result;
}

/// Where a line of pixels leads that ends at `p`; nothing where it goes on, or is too short to lead anywhere. Of an end
/// all that is near lies to one side, half of its length away on average.
std::optional<Vec2> direction_of_end(const Marks& marks, const Pixel& p, int run) {
  const Connected near = connected_to(marks, p, run);
  if (near.steps.back() < run) return std::nullopt;
  Vec2 mean = Vec2::Zero();
  for (const Pixel& q : near.pixels) mean += place(q) / double(near.pixels.size());
  const Vec2 ahead = place(p) - mean;
  if (ahead.norm() < 0.35 * run) return std::nullopt;
  // The outermost of the pixels at this end.
  for (std::size_t k = 1; k < near.pixels.size() && near.steps[k] <= 2; ++k)
    if (ahead.dot(place(near.pixels[k]) - place(p)) > 1e-9) return std::nullopt;
  return ahead.normalized();
}

/// The nearest pixel of a line ahead of an end that is no part of the end itself.
std::optional<Pixel> met_ahead(const Marks& marks, const Pixel& end, const Vec2& direction,
                               const EdgeLinkOptions& options) {
  const Connected own = connected_to(marks, end, options.reach);
  std::optional<Pixel> best;
  double least = options.reach;
  for (int y = end.y - options.reach; y <= end.y + options.reach; ++y)
    for (int x = end.x - options.reach; x <= end.x + options.reach; ++x) {
      if (!marks.at(x, y)) continue;
      const Vec2 to = place({x, y}) - place(end);
      const double length = to.norm();
      if (length < 1.5 || to.dot(direction) < std::cos(options.most_turn) * length) continue;
      if (length > least || (best && length == least)) continue;
      if (std::ranges::find(own.pixels, Pixel{x, y}) != own.pixels.end()) continue;
      best = Pixel{x, y}, least = length;
    }
  return best;
}

void draw(Marks& marks, const Pixel& from, const Pixel& to) {
  const int count = std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
  for (int k = 0; k <= count; ++k) {
    const Vec2 p = place(from) + (place(to) - place(from)) * k / std::max(count, 1);
    marks.on[marks.index(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())))] = 1;
  }
}

/// What a flood from the margin reaches, from a pixel to its four neighbours.
Marks flooded(const Marks& wall) {
  Marks result{wall.width, wall.height, std::vector<std::uint8_t>(wall.on.size(), 0)};
  std::vector<Pixel> open;
  const auto reach = [&](int x, int y) {
    if (!wall.has(x, y) || wall.at(x, y) || result.at(x, y)) return;
    result.on[result.index(x, y)] = 1;
    open.push_back({x, y});
  };
  for (int x = 0; x < wall.width; ++x) reach(x, 0), reach(x, wall.height - 1);
  for (int y = 0; y < wall.height; ++y) reach(0, y), reach(wall.width - 1, y);
  while (!open.empty()) {
    const Pixel p = open.back();
    open.pop_back();
    reach(p.x + 1, p.y), reach(p.x - 1, p.y), reach(p.x, p.y + 1), reach(p.x, p.y - 1);
  }
  return result;
}

Marks linked(const std::vector<RangeEdge>& edges, int width, int height, const EdgeLinkOptions& options) {
  ensure(edges.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "one edge per pixel");
  Marks steps{width, height, std::vector<std::uint8_t>(edges.size(), 0)};
  for (std::size_t i = 0; i < edges.size(); ++i) steps.on[i] = edges[i] == RangeEdge::step;
  Marks result = steps;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!steps.at(x, y)) continue;
      const auto direction = direction_of_end(steps, {x, y}, options.run);
      if (!direction) continue;
      if (const auto met = met_ahead(steps, {x, y}, *direction, options)) draw(result, {x, y}, *met);
    }
  return result;
}

}  // namespace

std::vector<std::uint8_t> linked_steps(const std::vector<RangeEdge>& edges, int width, int height,
                                       const EdgeLinkOptions& options) {
  return linked(edges, width, height, options).on;
}

std::vector<std::uint8_t> outside_of_edges(const std::vector<RangeEdge>& edges, const std::vector<double>& depth,
                                           int width, int height, const EdgeLinkOptions& options) {
  ensure(depth.size() == edges.size(), "one depth per pixel");
  const Marks wall = linked(edges, width, height, options);
  const Marks reached = flooded(wall);
  std::vector<std::uint8_t> result = reached.on;
  constexpr int beside = 3;  // pixels; a step is up to two wide
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = wall.index(x, y);
      if (!wall.on[i]) continue;
      double sum[2] = {}, count[2] = {};
      bool touched = false;
      for (int dy = -beside; dy <= beside; ++dy)
        for (int dx = -beside; dx <= beside; ++dx) {
          if (!wall.has(x + dx, y + dy)) continue;
          const std::size_t j = wall.index(x + dx, y + dy);
          touched = touched || (reached.on[j] && std::max(std::abs(dx), std::abs(dy)) <= 1);
          if (wall.on[j] || std::isnan(depth[j])) continue;
          const double weight = 1.0 / (dx * dx + dy * dy);
          sum[reached.on[j]] += weight * depth[j], count[reached.on[j]] += weight;
        }
      if (!touched) continue;
      // A line with the margin on both sides encloses nothing.
      if (count[0] == 0 || std::isnan(depth[i]))
        result[i] = 1;
      else
        result[i] = count[1] > 0 && std::abs(depth[i] - sum[1] / count[1]) < std::abs(depth[i] - sum[0] / count[0]);
    }
  return result;
}

}  // namespace partscribe::geometry
