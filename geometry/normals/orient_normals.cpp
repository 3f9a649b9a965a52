#include "geometry/normals/orient_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "geometry/points/bulk_box.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::geometry {
namespace {

/// Which cells of a grid hold points: what stands in the way of a straight line. A single one is an outlier, of a
/// surface a cell holds some four.
class Cells {
 public:
  /// Points outside of `box` stand in nobody's way.
  Cells(const std::vector<Vec3>& points, const Box3& box, double edge) : edge_(edge) {
    low_ = box.low - Vec3::Constant(edge);
    for (int k = 0; k < 3; ++k) n_[k] = static_cast<int>(box.size()[k] / edge) + 3;
    std::vector<std::uint8_t> held(
        static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]), 0);
    for (const Vec3& p : points)
      if (const auto cell = cell_of(in_cells(p))) held[*cell] += held[*cell] < few;
    measure_room(held);
  }

  double edge() const { return edge_; }

  /// Where `p` is, counted in cells; and so a direction.
  Vec3 in_cells(const Vec3& p) const { return (p - low_) / edge_; }

  /// Does nothing stand in the way out from `p` (in cells)?
  bool escapes(Vec3 p, const Vec3& direction) const {
    constexpr double step = 0.75;
    for (std::optional<std::size_t> cell; (cell = cell_of(p));) {
      const int room = room_[*cell];
      if (room == 0) return false;
      p += (room < 3 ? step : step * std::floor((room - 1) / step)) * direction;  // what lies between is empty
    }
    return true;
  }

 private:
  /// Fills `room_`: forth and back through the grid, from the cells before.
  void measure_room(const std::vector<std::uint8_t>& held) {
    room_.resize(held.size());
    for (std::size_t cell = 0; cell < held.size(); ++cell) room_[cell] = held[cell] == few ? 0 : most_room;
    const auto pass = [&](int sense) {
      for (int z = sense > 0 ? 0 : n_[2] - 1; z >= 0 && z < n_[2]; z += sense)
        for (int y = sense > 0 ? 0 : n_[1] - 1; y >= 0 && y < n_[1]; y += sense)
          for (int x = sense > 0 ? 0 : n_[0] - 1; x >= 0 && x < n_[0]; x += sense) {
            std::uint8_t& room = room_[index_of(x, y, z)];
            const auto look = [&](int i, int j, int k) {
              if (i >= 0 && i < n_[0] && j >= 0 && j < n_[1] && k >= 0 && k < n_[2])
                room = std::min<std::uint8_t>(room, room_[index_of(i, j, k)] + 1);
            };
            for (int dy = -1; dy <= 1; ++dy)
              for (int dx = -1; dx <= 1; ++dx) look(x + dx, y + dy, z - sense);
            for (int dx = -1; dx <= 1; ++dx) look(x + dx, y - sense, z);
            look(x - sense, y, z);
          }
    };
    pass(1), pass(-1);
  }

  std::size_t index_of(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(n_[0]) +
           static_cast<std::size_t>(x);
  }

  std::optional<std::size_t> cell_of(const Vec3& p) const {
    if (!(p.x() >= 0 && p.y() >= 0 && p.z() >= 0 && p.x() < n_[0] && p.y() < n_[1] && p.z() < n_[2]))
      return std::nullopt;
    return index_of(static_cast<int>(p.x()), static_cast<int>(p.y()), static_cast<int>(p.z()));
  }

  static constexpr std::uint8_t few = 2, most_room = 250;
  double edge_;
  Vec3 low_;
  int n_[3];
  std::vector<std::uint8_t> room_;  // cells to the nearest that is full, along x, y or z, whatever is most
};

/// Directions evenly all around.
std::vector<Vec3> all_around(int count) {
  std::vector<Vec3> result;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, turn = pi * (1 + std::sqrt(5.0)) * i, r = std::sqrt(1 - z * z);
    result.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
  }
  return result;
}

/// Of every point: on which side of it more lines lead out, from -1 (of many none on the normal's) to 1 [Takayama et
/// al. 2014]. From the wall of a deep hole hardly a line does, but from inside the part none. A surface right before a
/// point closes that side: beyond a thin wall all is open. What meets it in a corner does not.
std::vector<float> open_sides(const std::vector<Vec3>& points, const std::vector<Vec3>& normals, const KdTree& tree,
                              double spacing, std::size_t turns, int threads) {
  constexpr double least_cosine = 0.3;
  constexpr double away = 2, over = 0.4;               // of the cells' edge: beyond the own ones; above the own surface
  constexpr double facing = 0.7;                       // cosine between the normals of a thin wall's two sides
  const float chance = 2 / static_cast<float>(turns);  // lines that find a way out by chance
  constexpr double left_out = 0.005, more = 0.05;      // of the points; of the box of the others, on either side
  // points that are looked at for what stands before one: some 54 of an even surface are as near
  constexpr std::size_t around = 64;
  Box3 box = bulk_box(points, left_out);
  const Vec3 margin = more * box.size();
  box.low -= margin, box.high += margin;
  const Cells cells(points, box, std::max({1.5 * spacing, box.diagonal() / 400, std::numeric_limits<double>::min()}));
  const auto directions = all_around(128);
  std::vector<float> result(points.size(), 0);
  tree.nearest_of_each(around, threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    const Vec3 n = normals[i].normalized();
    bool closed[2] = {false, false};
    for (const Neighbour& m : near) {
      if (m.sq_distance > away * away * cells.edge() * cells.edge()) break;
      const double height = n.dot(points[m.index] - points[i]);
      if (std::abs(height) > over * cells.edge() && 2 * height * height > m.sq_distance &&
          std::abs(n.dot(normals[m.index])) > facing)
        closed[height < 0] = true;
    }
    const Vec3 here = cells.in_cells(points[i]), outside = here + away * n, inside = here - away * n;
    int open[2] = {0, 0};
    for (std::size_t k = i % turns; k < directions.size(); k += turns) {
      const Vec3& d = directions[k];
      const double along = d.dot(n);
      if (std::abs(along) < least_cosine || closed[along < 0]) continue;
      open[along < 0] += cells.escapes(along < 0 ? inside : outside, d);
    }
    result[i] = static_cast<float>(open[0] - open[1]) / (static_cast<float>(open[0] + open[1]) + chance);
  });
  return result;
}

struct Link {
  double cost;
  std::uint32_t a, b;
};

/// The point of a piece that lies farthest along +x, -x, +y, -y, +z or -z.
std::uint32_t outermost(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& piece, int direction) {
  std::uint32_t best = piece.front();
  const int axis = direction / 2;
  const double sign = direction % 2 ? -1 : 1;
  for (const std::uint32_t i : piece)
    if (sign * points[i][axis] > sign * points[best][axis]) best = i;
  return best;
}

}  // namespace

std::size_t orient_normals(PointCloud& cloud, int neighbours, Context& context, int turns) {
  std::vector<std::uint32_t> source;
  for (const std::uint32_t i : thinned(cloud.points, cloud.rejected, 0))
    if (cloud.normals[i].squaredNorm() > 0.25) source.push_back(i);
  std::vector<Vec3> points, normals;
  for (const std::uint32_t i : source) points.push_back(cloud.points[i]), normals.push_back(cloud.normals[i]);
  const std::size_t n = points.size();
  if (n == 0) return 0;
  const KdTree tree(points);
  const auto k = static_cast<std::size_t>(std::max(neighbours, 3));
  std::vector<std::uint32_t> near_of(n * k, ~0u);
  std::vector<double> reach(n, 0);
  tree.nearest_of_each(k, context.threads, [&](std::uint32_t i, std::span<const Neighbour> near) {
    for (std::size_t m = 0; m < near.size(); ++m) near_of[i * k + m] = near[m].index;
    reach[i] = std::sqrt(near[std::min<std::size_t>(near.size() - 1, 6)].sq_distance);
  });
  std::vector<Link> links;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::size_t m = 0; m < k; ++m) {
      const std::uint32_t j = near_of[i * k + m];
      if (j == ~0u || j == i) continue;
      const auto back = near_of.begin() + static_cast<std::ptrdiff_t>(j * k);
      if (j < i && std::find(back, back + static_cast<std::ptrdiff_t>(k), i) != back + static_cast<std::ptrdiff_t>(k))
        continue;  // it is there already
      const Vec3 d = points[j] - points[i];
      const double length = d.norm();
      // Normals that agree, and a step that stays in both tangent planes: across a thin wall the step is steep.
      const double steep = length > 0 ? std::max(std::abs(normals[i].dot(d)), std::abs(normals[j].dot(d))) / length : 0;
      links.push_back({1 - std::abs(normals[i].dot(normals[j])) + steep * steep, std::min(i, j), std::max(i, j)});
    }
  std::sort(links.begin(), links.end(), [](const Link& x, const Link& y) {
    if (x.cost != y.cost) return x.cost < y.cost;
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  std::nth_element(reach.begin(), reach.begin() + static_cast<std::ptrdiff_t>(n / 2), reach.end());
  const auto open_side =
      open_sides(points, normals, tree, reach[n / 2], static_cast<std::size_t>(turns), context.threads);
  // Kruskal. A piece has one sense, and knows whether its normals are on the open side. Where two that know it meet at
  // an edge each keeps its own; else the smaller is turned as the link between them says.
  constexpr double edge_cost = 0.1, known = 0.1, sure = 0.2;  // of a link; means over the points of a piece
  constexpr std::size_t some = 8,
                        many = 100;  // points of a piece that is asked at an edge; also where nothing tells of one
  struct Piece {
    std::vector<std::uint32_t> members;
    double open = 0;  // the sum over the members
    bool knows(std::size_t least, double share) const {
      return members.size() > least && std::abs(open) > share * static_cast<double>(members.size());
    }
  };
  std::vector<Piece> piece(n);
  for (std::uint32_t i = 0; i < n; ++i) piece[i] = {{i}, open_side[i]};
  const auto turn = [&](Piece& p) {
    for (const std::uint32_t i : p.members) normals[i] = -normals[i];
    p.open = -p.open;
  };
  DisjointSets sets(n);
  for (const Link& link : links) {
    const std::uint32_t a = sets.root(link.a), b = sets.root(link.b);
    if (!sets.unite(a, b)) continue;
    const bool a_larger = piece[a].members.size() >= piece[b].members.size();
    Piece &large = piece[a_larger ? a : b], &small = piece[a_larger ? b : a];
    // Two normals mirrored in the bisecting plane of the step between them agree: exact on circles and edges.
    const Vec3 d = points[link.b] - points[link.a];
    Vec3 carried = normals[link.a];
    if (d.squaredNorm() > 0 && std::abs(carried.dot(normals[link.b])) < 0.7)
      carried -= 2 * d * (d.dot(carried) / d.squaredNorm());
    const bool edge = link.cost > edge_cost;
    const auto knows = [&](const Piece& p) { return edge ? p.knows(some, known) : p.knows(many, sure); };
    const bool by_themselves = knows(large) && knows(small);
    if (by_themselves ? large.open * small.open < 0 : carried.dot(normals[link.b]) < 0) turn(small);
    large.members.insert(large.members.end(), small.members.begin(), small.members.end());
    large.open += small.open;
    small = {};
    if (&large != &piece[std::min(a, b)]) std::swap(large, small);  // where the set has its root
  }
  std::size_t pieces = 0;
  for (Piece& p : piece) {
    if (p.members.empty()) continue;
    ++pieces;
    double vote = p.open;
    if (!p.knows(some, known)) {
      // At the outermost points of a closed piece the normal looks outward; six directions vote.
      std::sort(p.members.begin(), p.members.end());
      vote = 0;
      for (int direction = 0; direction < 6; ++direction) {
        const std::uint32_t i = outermost(points, p.members, direction);
        vote += (direction % 2 ? -1 : 1) * normals[i][direction / 2];
      }
    }
    if (vote < 0) turn(p);
  }
  for (std::size_t i = 0; i < n; ++i) cloud.normals[source[i]] = normals[i];
  return pieces;
}

}  // namespace partscribe::geometry
