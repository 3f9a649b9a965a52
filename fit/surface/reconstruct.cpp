#include "fit/surface/reconstruct.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/ensure.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/mesh/mesh_repair.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::fit {
namespace {

constexpr std::uint32_t none = ~0u;

bool has_rays(const PointCloud& cloud) { return cloud.rays.size() == cloud.size(); }

/// Points of one small cube and of one direction, averaged: noise falls, edges stay.
struct Surfels {
  std::vector<Vec3> points, normals;
  std::vector<double> weights;
};

/// The side that the surface at a point faces. None was seen more than 82 degrees aside: what has such a normal is a
/// strip of a few rows, seen through a gap, whose normals lie within it. Of that only the ray is known.
Vec3 facing(const PointCloud& cloud, std::uint32_t i) {
  constexpr double grazing = 0.14;
  const Vec3& n = cloud.normals[i];
  return has_rays(cloud) && std::abs(n.dot(cloud.rays[i])) < grazing * n.norm() * cloud.rays[i].norm()
             ? Vec3(-cloud.rays[i])
             : n;
}

Surfels averaged(const PointCloud& cloud, double edge) {
  struct Entry {
    std::array<std::int64_t, 4> key;
    std::uint32_t order, index;
  };
  std::vector<Entry> entries;
  std::uint32_t order = 0;
  for (const std::uint32_t i : thinned(cloud.points, cloud.rejected, 0)) {
    const Vec3 n = facing(cloud, i);
    if (!(n.squaredNorm() > 0.25)) continue;
    Eigen::Index axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const Vec3 cell = cloud.points[i] / edge;
    entries.push_back(
        {{static_cast<std::int64_t>(std::floor(cell.x())), static_cast<std::int64_t>(std::floor(cell.y())),
          static_cast<std::int64_t>(std::floor(cell.z())), 2 * axis + (n[axis] < 0)},
         order++,
         i});
  }
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.key != b.key ? a.key < b.key : a.order < b.order; });
  Surfels surfels;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
    for (end = begin; end < entries.size() && entries[end].key == entries[begin].key; ++end) {
      point += cloud.points[entries[end].index];
      normal += facing(cloud, entries[end].index).normalized();
    }
    const auto count = static_cast<double>(end - begin);
    if (!(normal.norm() > 0.5 * count)) continue;
    surfels.points.push_back(point / count);
    surfels.normals.push_back(normal.normalized());
    surfels.weights.push_back(count);
  }
  return surfels;
}

/// Without those that no others continue: outliers that the filter left, each of which would put up a wall of its own.
/// Where one view alone saw a place the next surfels are farther, and have to agree better.
Surfels continued(Surfels surfels, double cell, double sigma, bool rays, Context& context) {
  struct Rule {
    double reach, bent, along;  // cells; height over distance; cosine between normals
    std::size_t least;
  };
  // Fewer are enough where turned normals may be wrong.
  const Rule near_by{2, 0.3, 0.3, rays ? 4u : 2u}, farther{4, 0.1, 0.9, 5};
  const KdTree tree(surfels.points);
  std::vector<std::uint8_t> keep(surfels.points.size());
  parallel_for(keep.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    const auto supported = [&](std::size_t i, const Rule& rule) {
      tree.within(surfels.points[i], rule.reach * cell, near);
      std::size_t support = 0;
      for (const Neighbour& m : near) {
        if (m.index == i || surfels.normals[i].dot(surfels.normals[m.index]) < rule.along) continue;
        const double height = surfels.normals[i].dot(surfels.points[m.index] - surfels.points[i]);
        support += std::abs(height) < rule.bent * std::sqrt(m.sq_distance) + 2 * sigma;
      }
      return support >= rule.least;
    };
    for (std::size_t i = begin; i < end; ++i) keep[i] = supported(i, near_by) || supported(i, farther);
  });
  std::size_t at = 0;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i]) {
      surfels.points[at] = surfels.points[i], surfels.normals[at] = surfels.normals[i];
      surfels.weights[at++] = surfels.weights[i];
    }
  surfels.points.resize(at), surfels.normals.resize(at), surfels.weights.resize(at);
  return surfels;
}

struct Grid {
  Vec3 origin = Vec3::Zero();
  double cell = 1;
  std::array<int, 3> n = {0, 0, 0};
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(x);
  }
  std::size_t size() const { return index(0, 0, n[2]); }
  Vec3 at(int x, int y, int z) const { return origin + cell * Vec3(x, y, z); }
};

/// What fixes the value of a node: nothing; anything else; points right before it or behind it.
enum Known : std::uint8_t { unknown = 0, fixed = 1, at_points = 2 };

/// Values on grid nodes; `known` ones are fixed.
struct Field {
  std::array<int, 3> n;
  std::vector<float> value;
  std::vector<std::uint8_t> known;
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(x);
  }
};

/// Gauss-Seidel sweeps of Laplace's equation on the unknown nodes, forward and backward in turn.
void relax(Field& f, int sweeps) {
  const std::size_t sx = 1, sy = static_cast<std::size_t>(f.n[0]), sz = sy * static_cast<std::size_t>(f.n[1]);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const bool back = sweep % 2 != 0;
    for (int zz = 1; zz + 1 < f.n[2]; ++zz)
      for (int yy = 1; yy + 1 < f.n[1]; ++yy) {
        const int z = back ? f.n[2] - 1 - zz : zz, y = back ? f.n[1] - 1 - yy : yy;
        const std::size_t row = f.index(0, y, z);
        for (int xx = 1; xx + 1 < f.n[0]; ++xx) {
          const std::size_t i = row + static_cast<std::size_t>(back ? f.n[0] - 1 - xx : xx);
          if (f.known[i]) continue;
          f.value[i] = (f.value[i - sx] + f.value[i + sx] + f.value[i - sy] + f.value[i + sy] + f.value[i - sz] +
                        f.value[i + sz]) /
                       6;
        }
      }
  }
}

/// The harmonic continuation of the known values, coarse grids first.
void continue_field(Field& f) {
  if (std::max({f.n[0], f.n[1], f.n[2]}) <= 8) {
    relax(f, 60);
    return;
  }
  Field coarse;
  for (int k = 0; k < 3; ++k) coarse.n[k] = (f.n[k] + 1) / 2 + 1;
  const std::size_t size = coarse.index(0, 0, coarse.n[2]);
  coarse.value.assign(size, 0);
  coarse.known.assign(size, 0);
  std::vector<std::uint8_t> count(size, 0);
  for (int z = 0; z < f.n[2]; ++z)
    for (int y = 0; y < f.n[1]; ++y)
      for (int x = 0; x < f.n[0]; ++x) {
        const std::size_t i = f.index(x, y, z);
        if (!f.known[i]) continue;
        const std::size_t c = coarse.index((x + 1) / 2, (y + 1) / 2, (z + 1) / 2);
        coarse.value[c] += f.value[i];
        ++count[c];
      }
  for (std::size_t c = 0; c < size; ++c)
    if (count[c] > 0) coarse.known[c] = fixed, coarse.value[c] /= static_cast<float>(count[c]);
  for (int z = 0; z < coarse.n[2]; ++z)
    for (int y = 0; y < coarse.n[1]; ++y)
      for (int x = 0; x < coarse.n[0]; ++x)
        if (x == 0 || y == 0 || z == 0 || x + 1 == coarse.n[0] || y + 1 == coarse.n[1] || z + 1 == coarse.n[2]) {
          const std::size_t c = coarse.index(x, y, z);
          if (!coarse.known[c]) coarse.known[c] = fixed, coarse.value[c] = 2;
        }
  continue_field(coarse);
  for (int z = 0; z < f.n[2]; ++z)
    for (int y = 0; y < f.n[1]; ++y)
      for (int x = 0; x < f.n[0]; ++x) {
        const std::size_t i = f.index(x, y, z);
        if (!f.known[i]) f.value[i] = coarse.value[coarse.index((x + 1) / 2, (y + 1) / 2, (z + 1) / 2)];
      }
  relax(f, 10);
}

class Contour {
 public:
  Contour(const PointCloud& cloud, double cell, double sigma, Context& context)
      : context_(context),
        cloud_(cloud),
        surfels_(continued(averaged(cloud, 0.6 * cell), cell, sigma, has_rays(cloud), context)),
        tree_(surfels_.points) {
    Box3 box;
    for (const Vec3& p : surfels_.points) box.add(p);
    grid_.cell = cell;
    // An odd fraction of a cell, because faces of parts love round coordinates and nodes should not lie on them.
    if (!box.empty()) {
      grid_.origin = box.low - Vec3(4.37, 4.41, 4.33) * cell;
      for (int k = 0; k < 3; ++k) grid_.n[k] = static_cast<int>(std::ceil(box.size()[k] / cell)) + 10;
    }
  }

  bool usable() const { return surfels_.points.size() >= 12; }

  TriangleMesh run() {
    fill_field();
    context_.report("reconstruct", 0.4);
    place_vertices();
    context_.report("reconstruct", 0.7);
    connect();
    untangle();
    return std::move(mesh_);
  }

  /// For every triangle of `mesh`: are there data within `cells` cells that face the same way, give or take `along`?
  std::vector<std::uint8_t> supported(const TriangleMesh& mesh, double cells, double along) const {
    std::vector<std::uint8_t> result(mesh.triangles.size());
    const double reach = cells * grid_.cell;
    parallel_for(result.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
        const Neighbour near = tree_.nearest_one(middle);
        result[t] =
            near.sq_distance <= reach * reach && triangle_normal(mesh, t).dot(surfels_.normals[near.index]) >= along;
      }
    });
    return result;
  }

 private:
  /// Signed distance by the planes of the nearest surfels that face the way the nearest one does.
  double distance(const Vec3& x, std::vector<Neighbour>& near) const {
    tree_.nearest(x, 12, near);
    const Vec3& first = surfels_.normals[near[0].index];
    const double scale = 1 / (2 * 0.5 * grid_.cell * grid_.cell);
    double sum = 0, total = 0;
    for (const Neighbour& m : near) {
      const Vec3& n = surfels_.normals[m.index];
      if (n.dot(first) < -0.3) continue;
      const double w = surfels_.weights[m.index] * std::exp(-(m.sq_distance - near[0].sq_distance) * scale);
      sum += w * n.dot(x - surfels_.points[m.index]);
      total += w;
    }
    return sum / total;
  }

  void fill_field() {
    field_.n = grid_.n;
    field_.value.assign(grid_.size(), 2);
    field_.known.assign(grid_.size(), 0);
    for (const Vec3& p : surfels_.points) {
      std::array<int, 3> c;
      for (int k = 0; k < 3; ++k) c[k] = static_cast<int>(std::floor((p[k] - grid_.origin[k]) / grid_.cell));
      for (int z = c[2] - 1; z <= c[2] + 2; ++z)
        for (int y = c[1] - 1; y <= c[1] + 2; ++y)
          for (int x = c[0] - 1; x <= c[0] + 2; ++x) field_.known[grid_.index(x, y, z)] = fixed;
    }
    const auto plane = static_cast<std::size_t>(grid_.n[0]) * static_cast<std::size_t>(grid_.n[1]);
    parallel_for(
        static_cast<std::size_t>(grid_.n[2]), context_.threads,
        [&](std::size_t begin, std::size_t end) {
          constexpr double beside = 0.75;  // cells along the surface
          std::vector<Neighbour> near;
          for (std::size_t i = begin * plane; i < end * plane; ++i) {
            if (!field_.known[i]) continue;
            const auto x = static_cast<int>(i % static_cast<std::size_t>(grid_.n[0]));
            const auto y =
                static_cast<int>(i / static_cast<std::size_t>(grid_.n[0]) % static_cast<std::size_t>(grid_.n[1]));
            const auto z = static_cast<int>(i / plane);
            const Vec3 node = grid_.at(x, y, z);
            field_.value[i] = static_cast<float>(std::clamp(distance(node, near) / grid_.cell, -2.0, 2.0));
            const Vec3 offset = node - surfels_.points[near[0].index];
            const double aside = offset.cross(surfels_.normals[near[0].index]).norm();
            field_.known[i] = aside > beside * grid_.cell ? fixed : at_points;
          }
        },
        2);
    carve();
    for (int z = 0; z < grid_.n[2]; ++z)
      for (int y = 0; y < grid_.n[1]; ++y)
        for (int x = 0; x < grid_.n[0]; ++x)
          if (x == 0 || y == 0 || z == 0 || x + 1 == grid_.n[0] || y + 1 == grid_.n[1] || z + 1 == grid_.n[2]) {
            field_.known[grid_.index(x, y, z)] = fixed;
            field_.value[grid_.index(x, y, z)] = 2;
          }
    continue_field(field_);
  }

  /// Negative outside the grid.
  std::array<int, 3> nearest_node(const Vec3& p) const {
    const Vec3 at = (p - grid_.origin) / grid_.cell;
    std::array<int, 3> c;
    for (int k = 0; k < 3; ++k) {
      if (!(at[k] >= 0 && at[k] < grid_.n[k] - 1)) return {-1, -1, -1};
      c[k] = static_cast<int>(at[k] + 0.5);
    }
    return c;
  }

  /// What the sensors looked through is outside [Curless & Levoy 1996], where no points are, beyond the rim of a face,
  /// and where points next to it say otherwise by less than a cell. A ray that would have to pass deep through the part
  /// belongs to an outlier.
  void carve() {
    if (!has_rays(cloud_)) return;
    constexpr double start = 2, step = 0.45, touched = 0.35;  // cells
    constexpr float deep = -0.9F, just_outside = 0.2F, outside = 1;
    constexpr std::uint8_t contradiction = 2;  // rays; one is enough where no points are
    std::vector<std::uint8_t> looked_through(grid_.size(), 0);
    parallel_for(cloud_.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      std::vector<std::size_t> passed;
      for (std::size_t i = begin; i < end; ++i) {
        if ((!cloud_.rejected.empty() && cloud_.rejected[i]) || !cloud_.points[i].allFinite()) continue;
        if (!(cloud_.rays[i].squaredNorm() > 0.25)) continue;  // joined from a file without rays
        passed.clear();
        bool possible = true;
        for (double t = start; possible; t += step) {
          const Vec3 at = cloud_.points[i] - cloud_.rays[i] * (t * grid_.cell);
          const std::array<int, 3> c = nearest_node(at);
          if (c[0] < 0) break;
          const std::size_t node = grid_.index(c[0], c[1], c[2]);
          if (!passed.empty() && passed.back() == node) continue;
          if (field_.known[node] == at_points) {
            possible = field_.value[node] > deep;
            if ((at - grid_.at(c[0], c[1], c[2])).norm() > touched * grid_.cell) continue;
          }
          passed.push_back(node);
        }
        if (!possible) continue;
        for (const std::size_t node : passed) {
          const std::atomic_ref<std::uint8_t> count(looked_through[node]);
          if (count.load(std::memory_order_relaxed) < contradiction) count.fetch_add(1, std::memory_order_relaxed);
        }
      }
    });
    for (std::size_t node = 0; node < looked_through.size(); ++node) {
      if (field_.known[node]) {
        const bool rim = field_.known[node] == fixed;
        if (field_.value[node] < 0 && looked_through[node] >= (rim ? 1 : contradiction))
          field_.value[node] = rim ? outside : just_outside;
      } else if (looked_through[node] > 0) {
        field_.known[node] = fixed, field_.value[node] = 2;
      }
    }
  }

  bool inside(std::size_t i) const { return field_.value[i] < 0; }

  /// The meeting point of the planes around the mean crossing of one cell.
  Vec3 vertex(int x, int y, int z, Vec3& mean, std::vector<Neighbour>& near) const {
    mean.setZero();
    double crossings = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 4; ++side) {
        std::array<int, 3> a = {x, y, z};
        a[(axis + 1) % 3] += side & 1;
        a[(axis + 2) % 3] += side >> 1;
        std::array<int, 3> b = a;
        ++b[axis];
        const double va = field_.value[grid_.index(a[0], a[1], a[2])], vb = field_.value[grid_.index(b[0], b[1], b[2])];
        if ((va < 0) == (vb < 0)) continue;
        const double t = va / (va - vb);
        mean += grid_.at(a[0], a[1], a[2]) * (1 - t) + grid_.at(b[0], b[1], b[2]) * t;
        ++crossings;
      }
    mean /= crossings;
    const double h = grid_.cell;
    const Vec3 center = grid_.at(x, y, z) + Vec3::Constant(0.5 * h);
    auto clamped = [&](const Vec3& p) {
      return Vec3(p.cwiseMax(center - Vec3::Constant(0.8 * h)).cwiseMin(center + Vec3::Constant(0.8 * h)));
    };
    tree_.nearest(mean, 24, near);
    while (!near.empty() && near.back().sq_distance > 1.5 * 1.5 * h * h) near.pop_back();
    if (near.size() < 3) return mean;
    const Vec3 first = surfels_.normals[near[0].index];
    std::vector<double> weights(near.size(), 0);
    Vec3 normal = Vec3::Zero();
    double total = 0;
    for (std::size_t k = 0; k < near.size(); ++k) {
      const std::uint32_t i = near[k].index;
      if (surfels_.normals[i].dot(first) < -0.3) continue;
      weights[k] = surfels_.weights[i] * std::exp(-near[k].sq_distance / (2 * 0.36 * h * h));
      normal += weights[k] * surfels_.normals[i];
      total += weights[k];
    }
    normal.normalize();
    double bent = 0;
    for (std::size_t k = 0; k < near.size(); ++k)
      if (surfels_.normals[near[k].index].dot(normal) < 0.9) bent += weights[k];
    if (bent < 0.08 * total) {
      // Smooth: the mean of two normals is exact on circles, where bare planes would push the vertex outward.
      double off = 0, used = 0;
      for (std::size_t k = 0; k < near.size(); ++k) {
        const Vec3 n = surfels_.normals[near[k].index] + normal;
        if (weights[k] == 0 || n.squaredNorm() < 1) continue;
        off += weights[k] * 0.5 * n.dot(mean - surfels_.points[near[k].index]);
        used += weights[k];
      }
      return clamped(mean - normal * (off / used));
    }
    // A feature: truncated least squares; planes that fit badly (normals blurred by the edge) lose their weight.
    Vec3 at = mean;
    for (int round = 0; round < 4; ++round) {
      Mat3 a = Mat3::Zero();
      Vec3 b = Vec3::Zero();
      for (std::size_t k = 0; k < near.size(); ++k) {
        const std::uint32_t i = near[k].index;
        const double off = surfels_.normals[i].dot(surfels_.points[i] - at);
        const double relative = off / (0.12 * h);
        const double w = weights[k] * (round == 0 ? 1 : 1 / (1 + relative * relative));
        a += w * surfels_.normals[i] * surfels_.normals[i].transpose();
        b += w * surfels_.normals[i] * surfels_.normals[i].dot(surfels_.points[i] - mean);
      }
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(a);
      Vec3 shift = Vec3::Zero();
      for (int k = 0; k < 3; ++k)
        if (eigen.eigenvalues()[k] > 0.06 * eigen.eigenvalues()[2])
          shift += eigen.eigenvectors().col(k) * (eigen.eigenvectors().col(k).dot(b) / eigen.eigenvalues()[k]);
      at = mean + shift;
    }
    return clamped(at);
  }

  void place_vertices() {
    vertex_of_.assign(grid_.size(), none);
    std::vector<std::array<int, 3>> cells;
    for (int z = 0; z + 1 < grid_.n[2]; ++z)
      for (int y = 0; y + 1 < grid_.n[1]; ++y)
        for (int x = 0; x + 1 < grid_.n[0]; ++x) {
          const bool first = inside(grid_.index(x, y, z));
          bool mixed = false;
          for (int k = 1; k < 8 && !mixed; ++k)
            mixed = inside(grid_.index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))) != first;
          if (!mixed) continue;
          vertex_of_[grid_.index(x, y, z)] = static_cast<std::uint32_t>(cells.size());
          cells.push_back({x, y, z});
        }
    mesh_.vertices.resize(cells.size());
    means_.resize(cells.size());
    parallel_for(cells.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      std::vector<Neighbour> near;
      for (std::size_t i = begin; i < end; ++i)
        mesh_.vertices[i] = vertex(cells[i][0], cells[i][1], cells[i][2], means_[i], near);
    });
  }

  double off_surface(const Vec3& p) const {
    const std::uint32_t i = tree_.nearest_one(p).index;
    return std::abs(surfels_.normals[i].dot(p - surfels_.points[i]));
  }

  void connect() {
    std::vector<std::array<std::uint32_t, 4>> quads;
    for (int z = 1; z + 1 < grid_.n[2]; ++z)
      for (int y = 1; y + 1 < grid_.n[1]; ++y)
        for (int x = 1; x + 1 < grid_.n[0]; ++x)
          for (int axis = 0; axis < 3; ++axis) {
            std::array<int, 3> end = {x, y, z};
            ++end[axis];
            const bool in = inside(grid_.index(x, y, z));
            if (in == inside(grid_.index(end[0], end[1], end[2]))) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            std::array<std::uint32_t, 4> quad;
            for (int k = 0; k < 4; ++k) {
              std::array<int, 3> c = {x, y, z};
              // Counter-clockwise about the axis.
              c[u] -= k == 0 || k == 3;
              c[v] -= k == 0 || k == 1;
              quad[static_cast<std::size_t>(k)] = vertex_of_[grid_.index(c[0], c[1], c[2])];
            }
            if (!in) std::swap(quad[1], quad[3]);
            quads.push_back(quad);
          }
    std::vector<std::uint8_t> other(quads.size(), 0);
    parallel_for(quads.size(), context_.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t q = begin; q < end; ++q) {
        const auto& v = quads[q];
        const Vec3 p[4] = {mesh_.vertices[v[0]], mesh_.vertices[v[1]], mesh_.vertices[v[2]], mesh_.vertices[v[3]]};
        // Flat quads take the diagonal that folds less; bent ones the diagonal that lies on the surface.
        auto fold = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
          return (b - a).cross(c - a).normalized().dot((c - a).cross(d - a).normalized());
        };
        const double fold02 = fold(p[0], p[1], p[2], p[3]), fold13 = fold(p[1], p[2], p[3], p[0]);
        if (std::min(fold02, fold13) > 0.98)
          other[q] = (p[0] - p[2]).squaredNorm() > (p[1] - p[3]).squaredNorm();
        else if (fold02 < -0.2 || fold13 < -0.2)
          other[q] = fold13 > fold02;
        else
          other[q] = off_surface(0.5 * (p[0] + p[2])) > off_surface(0.5 * (p[1] + p[3]));
      }
    });
    for (std::size_t q = 0; q < quads.size(); ++q) {
      const auto& v = quads[q];
      if (other[q]) {
        mesh_.triangles.push_back({v[1], v[2], v[3]});
        mesh_.triangles.push_back({v[1], v[3], v[0]});
      } else {
        mesh_.triangles.push_back({v[0], v[1], v[2]});
        mesh_.triangles.push_back({v[0], v[2], v[3]});
      }
    }
  }

  /// Vertices that went too far for their feature, so that triangles cross, are drawn back towards their cells' means.
  void untangle() {
    for (const double share : {0.5, 0.0, 0.0}) {
      const auto pairs = self_intersections(mesh_, mesh_.triangles.size());
      if (pairs.empty()) return;
      std::vector<std::uint8_t> involved(mesh_.vertices.size(), 0);
      for (const auto& [a, b] : pairs)
        for (const std::uint32_t t : {a, b})
          for (const std::uint32_t v : mesh_.triangles[t]) involved[v] = 1;
      for (std::size_t v = 0; v < involved.size(); ++v)
        if (involved[v]) mesh_.vertices[v] = share * mesh_.vertices[v] + (1 - share) * means_[v];
    }
  }

  Context& context_;
  const PointCloud& cloud_;
  Surfels surfels_;
  KdTree tree_;
  Grid grid_;
  Field field_;
  std::vector<std::uint32_t> vertex_of_;
  std::vector<Vec3> means_;  // of the crossings of each vertex's cell
  TriangleMesh mesh_;
};

/// How thick the thinnest walls are that are seen from both sides: a low quantile of the distances between points that
/// look away from each other. `reach`, mm: nothing thicker matters. Infinite without such walls.
double thinnest_walls(const Surfels& surfels, double reach, Context& context) {
  constexpr double facing_away = -0.7, least = 0.005;  // cosine; share of the points
  if (surfels.points.empty()) return std::numeric_limits<double>::infinity();
  const KdTree tree(surfels.points);
  std::vector<double> thickness(surfels.points.size(), std::numeric_limits<double>::infinity());
  parallel_for(thickness.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      tree.within(surfels.points[i], reach, near);
      for (const Neighbour& m : near) {
        if (surfels.normals[m.index].dot(surfels.normals[i]) > facing_away) continue;
        const double depth = surfels.normals[i].dot(surfels.points[i] - surfels.points[m.index]);
        if (depth > 0.7 * std::sqrt(m.sq_distance)) thickness[i] = std::min(thickness[i], depth);
      }
    }
  });
  const auto at = static_cast<std::ptrdiff_t>(least * static_cast<double>(thickness.size()));
  std::nth_element(thickness.begin(), thickness.begin() + at, thickness.end());
  return thickness[static_cast<std::size_t>(at)];
}

/// Where triangles still cross (touching walls, filled holes), their vertices go to the mean of their neighbours.
void smooth_crossings(TriangleMesh& mesh) {
  for (int round = 0; round < 8; ++round) {
    const auto pairs = self_intersections(mesh, mesh.triangles.size());
    if (pairs.empty()) return;
    std::vector<std::uint8_t> involved(mesh.vertices.size(), 0);
    for (const auto& [a, b] : pairs)
      for (const std::uint32_t t : {a, b})
        for (const std::uint32_t v : mesh.triangles[t]) involved[v] = 1;
    std::vector<Vec3> sum(mesh.vertices.size(), Vec3::Zero());
    std::vector<double> count(mesh.vertices.size(), 0);
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        if (!involved[t[k]]) continue;
        sum[t[k]] += mesh.vertices[t[(k + 1) % 3]] + mesh.vertices[t[(k + 2) % 3]];
        count[t[k]] += 2;
      }
    for (std::size_t v = 0; v < involved.size(); ++v)
      if (involved[v]) mesh.vertices[v] = 0.3 * mesh.vertices[v] + 0.7 * sum[v] / count[v];
  }
}

}  // namespace

Reconstruction reconstruct(const PointCloud& cloud, const SamplingSummary& sampling, const ReconstructOptions& options,
                           Context& context) {
  ensure(cloud.normals.size() == cloud.size(), "reconstruction needs normals");
  Reconstruction result;
  Box3 box;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if ((cloud.rejected.empty() || !cloud.rejected[i]) && cloud.points[i].allFinite()) box.add(cloud.points[i]);
  if (box.empty() || !(box.diagonal() > 0)) return result;
  double cell = options.cell;
  if (cell <= 0) {
    cell = std::max({2.5 * sampling.spacing, 3 * sampling.sigma, box.diagonal() / 220});
    // A wall shows if a node lies inside it.
    const double wall = thinnest_walls(averaged(cloud, 0.5 * cell), 2 * cell, context);
    cell = std::max(std::min(cell, wall / 1.8), std::max(1.2 * sampling.spacing, 3 * sampling.sigma));
  }
  auto nodes = [&](double h) { return (box.size() / h + Vec3::Constant(10)).prod(); };
  while (nodes(cell) > static_cast<double>(options.max_nodes)) cell *= 1.1;
  result.cell = cell;
  Contour contour(cloud, cell, sampling.sigma, context);
  if (!contour.usable()) return result;
  TriangleMesh mesh = contour.run();
  if (mesh.empty()) return result;

  // Removes pieces that exist only by continuation, and specks.
  auto has_data = contour.supported(mesh, 2.6, -1);
  const MeshPieces pieces = pieces_of(mesh);
  const auto& whole = pieces.area;
  std::vector<double> seen(whole.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (has_data[t])
      seen[pieces.of[t]] +=
          0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  const double largest = *std::max_element(seen.begin(), seen.end());
  double all = 0, all_seen = 0;
  std::vector<std::uint8_t> keep(whole.size(), 0);
  for (std::size_t p = 0; p < whole.size(); ++p) {
    if (whole[p] <= 0) continue;
    keep[p] = seen[p] >= 0.01 * largest && seen[p] >= 0.2 * whole[p];
    if (keep[p])
      all += whole[p], all_seen += seen[p];
    else
      ++result.dropped_pieces;
  }
  result.unseen_share = all > 0 ? 1 - all_seen / all : 0;
  // Rays tell a hollow part from a sheet.
  const double most_unseen = has_rays(cloud) ? options.unseen_share_with_rays : options.unseen_share;
  const bool sheet = result.unseen_share > most_unseen;
  // A sheet ends where its data end: the continuation must not curl round its border.
  if (sheet) has_data = contour.supported(mesh, 1.25, 0.3);
  std::size_t at = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (keep[pieces.of[t]] && (!sheet || has_data[t])) mesh.triangles[at++] = mesh.triangles[t];
  mesh.triangles.resize(at);
  RepairOptions repair_options;
  repair_options.separation = 0.05 * cell;
  if (sheet) repair_options.flat_hole = 0, repair_options.small_hole = 0.1;
  RepairReport repaired = repair(mesh, repair_options);
  result.mesh = std::move(repaired.mesh);
  smooth_crossings(result.mesh);
  result.closed = repaired.closed;
  result.dropped_pieces += repaired.dropped_components;
  context.report("reconstruct", 1);
  return result;
}

}  // namespace partscribe::fit
