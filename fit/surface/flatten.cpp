#include "fit/surface/flatten.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/number.h"
#include "geometry/mesh/facing.h"

namespace partscribe::fit {
namespace {

constexpr double steepest = 0.42;      // cosine of the angle between a triangle and the plane
constexpr double most_turned = 0.002;  // share of the area that may be steeper
constexpr double most_over = 0.01;     // share of the area that may turn over; noise folds single triangles

using Sparse = Eigen::SparseMatrix<double>;
using Entries = std::vector<Eigen::Triplet<double>>;

/// The mesh with a fan of triangles in every border loop but the longest: a disc.
TriangleMesh without_holes(const TriangleMesh& mesh, const std::vector<std::vector<std::uint32_t>>& loops,
                           std::size_t outline) {
  TriangleMesh disc = mesh;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (l == outline) continue;
    Vec3 middle = Vec3::Zero();
    for (const auto v : loops[l]) middle += mesh.vertices[v] / double(loops[l].size());
    const auto center = static_cast<std::uint32_t>(disc.vertices.size());
    disc.vertices.push_back(middle);
    for (std::size_t i = 0; i < loops[l].size(); ++i)
      disc.triangles.push_back({loops[l][(i + 1) % loops[l].size()], loops[l][i], center});
  }
  return disc;
}

/// Convex combinations of neighbours with mean-value weights [Floater 2003], the outline on a circle: no triangle turns
/// over.
std::optional<std::vector<Vec2>> on_disc(const TriangleMesh& disc, const std::vector<std::uint32_t>& outline) {
  const std::size_t n = disc.vertices.size();
  std::vector<Vec2> result(n, Vec2::Zero());
  std::vector<char> fixed(n, 0);
  std::vector<double> along = {0};
  for (std::size_t i = 0; i < outline.size(); ++i)
    along.push_back(along.back() +
                    (disc.vertices[outline[(i + 1) % outline.size()]] - disc.vertices[outline[i]]).norm());
  const double radius = std::sqrt(area(disc) / pi);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const double angle = 2 * pi * along[i] / along.back();
    result[outline[i]] = radius * Vec2(std::cos(angle), std::sin(angle));
    fixed[outline[i]] = 1;
  }
  std::vector<int> row(n, -1);
  int open = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (!fixed[i]) row[i] = open++;
  if (open == 0) return result;
  Entries entries;
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(open, 2);
  for (const auto& t : disc.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t i = t[k];
      if (fixed[i]) continue;
      const Vec3 a = disc.vertices[t[(k + 1) % 3]] - disc.vertices[i],
                 b = disc.vertices[t[(k + 2) % 3]] - disc.vertices[i];
      const double half = std::tan(0.5 * std::atan2(a.cross(b).norm(), a.dot(b)));
      for (const auto& [j, length] : {std::pair(t[(k + 1) % 3], a.norm()), std::pair(t[(k + 2) % 3], b.norm())}) {
        const double weight = std::max(half, 1e-6) / std::max(length, 1e-12);
        entries.emplace_back(row[i], row[i], weight);
        if (fixed[j])
          right.row(row[i]) += weight * result[j].transpose();
        else
          entries.emplace_back(row[i], row[j], -weight);
      }
    }
  Sparse matrix(open, open);
  matrix.setFromTriplets(entries.begin(), entries.end());
  // Not symmetric: by its normal equations, which are small and well conditioned enough for a start.
  const Sparse square = Sparse(matrix.transpose()) * matrix;
  const Eigen::SimplicialLDLT<Sparse> factor(square);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixX2d at = factor.solve(matrix.transpose() * right);
  if (!at.allFinite()) return std::nullopt;
  for (std::size_t i = 0; i < n; ++i)
    if (row[i] >= 0) result[i] = at.row(row[i]).transpose();
  return result;
}

/// Share of the area whose triangles are turned over.
double turned_share(const TriangleMesh& mesh, const std::vector<Vec2>& places) {
  double all = 0, over = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& c = mesh.triangles[t];
    const Vec2 p = places[c[1]] - places[c[0]], q = places[c[2]] - places[c[0]];
    const double size =
        0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    all += size;
    if (p.x() * q.y() - p.y() * q.x() <= 0) over += size;
  }
  return all > 0 ? over / all : 1;
}

/// As rigid as possible [Liu et al. 2008]: every triangle is turned as it lies now, then all are joined by least
/// squares; some times over. The last layout in which hardly any triangle of the part that counts is turned over.
std::optional<std::vector<Vec2>> made_rigid(const TriangleMesh& mesh, const TriangleMesh& counts,
                                            std::vector<Vec2> places) {
  const int n = static_cast<int>(mesh.vertices.size());
  struct Flat {
    Vec2 corner[3];
    double weight[3];  // of the edge opposite to each corner: the cotangent of its angle
  };
  std::vector<Flat> flat(mesh.triangles.size());
  Entries entries;
  for (std::size_t t = 0; t < flat.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0), ab = mesh.corner(t, 1) - a, ac = mesh.corner(t, 2) - a;
    const double length = std::max(ab.norm(), 1e-12);
    flat[t].corner[0] = Vec2::Zero(), flat[t].corner[1] = Vec2(length, 0);
    flat[t].corner[2] = Vec2(ac.dot(ab) / length, ab.cross(ac).norm() / length);
    for (int k = 0; k < 3; ++k) {
      const Vec2 p = flat[t].corner[(k + 1) % 3] - flat[t].corner[k],
                 q = flat[t].corner[(k + 2) % 3] - flat[t].corner[k];
      // Obtuse angles have negative weights, with which an edge may collapse.
      flat[t].weight[k] =
          std::max(p.dot(q) / std::max(p.x() * q.y() - p.y() * q.x(), 1e-9 * p.norm() * q.norm()), 0.02);
      const int i = static_cast<int>(mesh.triangles[t][std::size_t((k + 1) % 3)]),
                j = static_cast<int>(mesh.triangles[t][std::size_t((k + 2) % 3)]);
      entries.emplace_back(i, i, flat[t].weight[k]), entries.emplace_back(j, j, flat[t].weight[k]);
      entries.emplace_back(i, j, -flat[t].weight[k]), entries.emplace_back(j, i, -flat[t].weight[k]);
    }
  }
  entries.emplace_back(0, 0, 1.0);  // one vertex stays
  Sparse matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Sparse> factor(matrix);
  if (factor.info() != Eigen::Success) return std::nullopt;
  std::optional<std::vector<Vec2>> open;
  for (int round = 0; round < 40; ++round) {
    if (turned_share(counts, places) <= most_over) open = places;
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(n, 2);
    for (std::size_t t = 0; t < flat.size(); ++t) {
      // The rotation that fits best: as a complex number, the weighted sum of now times conjugate of flat.
      double c = 0, s = 0;
      for (int k = 0; k < 3; ++k) {
        const std::size_t a = std::size_t((k + 1) % 3), b = std::size_t((k + 2) % 3);
        const Vec2 now = places[mesh.triangles[t][b]] - places[mesh.triangles[t][a]],
                   was = flat[t].corner[b] - flat[t].corner[a];
        c += flat[t].weight[k] * now.dot(was), s += flat[t].weight[k] * (was.x() * now.y() - was.y() * now.x());
      }
      const double size = std::max(std::hypot(c, s), 1e-300);
      for (int k = 0; k < 3; ++k) {
        const std::size_t a = std::size_t((k + 1) % 3), b = std::size_t((k + 2) % 3);
        const Vec2 was = flat[t].corner[b] - flat[t].corner[a];
        const Vec2 turned = flat[t].weight[k] / size * Vec2(c * was.x() - s * was.y(), s * was.x() + c * was.y());
        right.row(mesh.triangles[t][b]) += turned.transpose(), right.row(mesh.triangles[t][a]) -= turned.transpose();
      }
    }
    right.row(0) += places[0].transpose();
    const Eigen::MatrixX2d next = factor.solve(right);
    if (!next.allFinite()) return std::nullopt;
    for (int i = 0; i < n; ++i) places[std::size_t(i)] = next.row(i).transpose();
  }
  if (turned_share(counts, places) <= most_over) open = std::move(places);
  return open;
}

/// Along their longest direction, from their middle.
void straighten(std::vector<Vec2>& places) {
  Vec2 mean = Vec2::Zero();
  for (const Vec2& p : places) mean += p / double(places.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Vec2& p : places) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  Vec2 along = axes.eigenvectors().col(1);
  if (along.x() < 0 || (along.x() == 0 && along.y() < 0)) along = -along;
  for (Vec2& p : places) {
    const Vec2 d = p - mean;
    p = {along.dot(d), along.x() * d.y() - along.y() * d.x()};
  }
}

/// By how the mesh is seen from one direction; nothing where it is steep.
std::optional<std::vector<Vec2>> projected(const TriangleMesh& mesh) {
  const Facing seen = facing(mesh, steepest);
  if (seen.turned_away > most_turned) return std::nullopt;
  const Mat3 turn = rotation_onto_axis(seen.direction);
  std::vector<Vec2> result;
  for (const Vec3& p : mesh.vertices) result.emplace_back(turn.col(0).dot(p), turn.col(1).dot(p));
  return result;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> border_loops(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges[{t[k], t[(k + 1) % 3]}] += 1;
  std::map<std::uint32_t, std::uint32_t> next;
  for (const auto& [edge, count] : edges)
    if (!edges.count({edge.second, edge.first})) next[edge.first] = edge.second;
  std::vector<std::vector<std::uint32_t>> loops;
  while (!next.empty()) {
    auto& loop = loops.emplace_back();
    for (auto at = next.begin(); at != next.end(); at = next.find(loop.back())) {
      if (loop.empty()) loop.push_back(at->first);
      const std::uint32_t to = at->second;
      next.erase(at);
      if (to == loop.front()) break;
      loop.push_back(to);
    }
  }
  return loops;
}

std::optional<std::vector<Vec2>> flattened(const TriangleMesh& mesh) {
  auto places = projected(mesh);
  if (!places) {
    const auto loops = border_loops(mesh);
    std::size_t outline = 0;
    double longest = -1;
    for (std::size_t l = 0; l < loops.size(); ++l) {
      double length = 0;
      for (std::size_t i = 0; i < loops[l].size(); ++i)
        length += (mesh.vertices[loops[l][(i + 1) % loops[l].size()]] - mesh.vertices[loops[l][i]]).norm();
      if (length > longest) longest = length, outline = l;
    }
    if (loops.empty()) return std::nullopt;
    const TriangleMesh disc = without_holes(mesh, loops, outline);
    const auto start = on_disc(disc, loops[outline]);
    if (!start) return std::nullopt;
    places = made_rigid(disc, mesh, *start);
    if (!places) return std::nullopt;
    places->resize(mesh.vertices.size());
  }
  straighten(*places);
  return places;
}

}  // namespace partscribe::fit
