#include "bench/triangles/contour.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/ensure.h"

namespace bench {
namespace {

using Solid = std::function<double(const Vec3&)>;

/// Where the surface crosses the way from `in` to `out`.
Vec3 crossing(const Solid& solid, Vec3 in, Vec3 out) {
  for (int step = 0; step < 46; ++step) {
    const Vec3 middle = 0.5 * (in + out);
    (solid(middle) < 0 ? in : out) = middle;
  }
  return 0.5 * (in + out);
}

Vec3 gradient(const Solid& solid, const Vec3& at, double step) {
  Vec3 g;
  for (int k = 0; k < 3; ++k) g[k] = solid(at + step * Vec3::Unit(k)) - solid(at - step * Vec3::Unit(k));
  return g.normalized();
}

/// The planes of one cell: sums of n n^T, n (n.p) and p, with p from the cell's middle.
struct CellPlanes {
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero(), sum = Vec3::Zero();
  int count = 0;
};

/// Directions in which the planes hardly differ keep the mean of the crossings: on a round surface they all do but one.
Vec3 meeting(const CellPlanes& planes, double pitch) {
  const Vec3 mean = planes.sum / planes.count;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(planes.a);
  const Vec3 values = solver.eigenvalues();
  const Mat3 vectors = solver.eigenvectors();
  const Vec3 rest = planes.b - planes.a * mean;
  Vec3 place = mean;
  for (int k = 0; k < 3; ++k)
    if (values[k] > 0.02 * values.maxCoeff()) place += vectors.col(k) * (vectors.col(k).dot(rest) / values[k]);
  const Vec3 kept = place.cwiseMax(Vec3::Constant(-0.5 * pitch)).cwiseMin(Vec3::Constant(0.5 * pitch));
  return (kept - place).norm() > 0 ? kept : place;
}

}  // namespace

TriangleMesh contoured(const Solid& solid, const Box3& box, double pitch) {
  int n[3];
  for (int k = 0; k < 3; ++k) n[k] = int(std::ceil(box.size()[k] / pitch));
  const auto at = [&](int x, int y, int z) { return Vec3(box.low + pitch * Vec3(x, y, z)); };
  const auto corner = [&](int x, int y, int z) {
    return (std::size_t(z) * std::size_t(n[1] + 1) + std::size_t(y)) * std::size_t(n[0] + 1) + std::size_t(x);
  };
  std::vector<double> value(corner(0, 0, n[2] + 1));
  for (int z = 0; z <= n[2]; ++z)
    for (int y = 0; y <= n[1]; ++y)
      for (int x = 0; x <= n[0]; ++x) value[corner(x, y, z)] = solid(at(x, y, z));

  // A cell goes by its lowest corner. Each crossed edge makes a square of the four cells around it.
  constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> vertex(value.size(), none);
  std::vector<CellPlanes> planes;
  std::vector<Vec3> middles;
  struct Square {
    std::array<std::uint32_t, 4> cells;
  };
  std::vector<Square> squares;
  const int one[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int z = 0; z <= n[2]; ++z)
    for (int y = 0; y <= n[1]; ++y)
      for (int x = 0; x <= n[0]; ++x)
        for (int k = 0; k < 3; ++k) {
          const int here[3] = {x, y, z};
          if (here[k] == n[k]) continue;
          const std::size_t c0 = corner(x, y, z), c1 = corner(x + one[k][0], y + one[k][1], z + one[k][2]);
          const bool in0 = value[c0] < 0, in1 = value[c1] < 0;
          if (in0 == in1) continue;
          const int u = (k + 1) % 3, v = (k + 2) % 3;
          ensure(here[u] > 0 && here[v] > 0 && here[u] < n[u] && here[v] < n[v],
                 "the solid reaches the border of its box");
          const Vec3 from = at(x, y, z), to = from + pitch * Vec3::Unit(k);
          const Vec3 place = in0 ? crossing(solid, from, to) : crossing(solid, to, from);
          const Vec3 normal = gradient(solid, place, 1e-4 * pitch);
          Square square;
          for (int i = 0; i < 4; ++i) {
            // Around the edge, counter-clockwise seen from its end.
            int cell[3] = {x, y, z};
            cell[u] -= i == 1 || i == 2 ? 0 : 1;
            cell[v] -= i == 2 || i == 3 ? 0 : 1;
            std::uint32_t& index = vertex[corner(cell[0], cell[1], cell[2])];
            if (index == none) {
              index = static_cast<std::uint32_t>(planes.size());
              planes.emplace_back();
              middles.push_back(at(cell[0], cell[1], cell[2]) + Vec3::Constant(0.5 * pitch));
            }
            const Vec3 p = place - middles[index];
            planes[index].a += normal * normal.transpose();
            planes[index].b += normal * normal.dot(p);
            planes[index].sum += p, planes[index].count += 1;
            square.cells[std::size_t(i)] = index;
          }
          if (!in0) std::swap(square.cells[1], square.cells[3]);
          squares.push_back(square);
        }

  TriangleMesh mesh;
  for (std::size_t i = 0; i < planes.size(); ++i) mesh.vertices.push_back(middles[i] + meeting(planes[i], pitch));
  for (const Square& s : squares) {
    // The diagonal that lies nearer to the surface: a sharp edge must not be cut.
    const auto off = [&](std::size_t i, std::size_t j) {
      return std::abs(solid(0.5 * (mesh.vertices[s.cells[i]] + mesh.vertices[s.cells[j]])));
    };
    const std::size_t first = off(0, 2) <= off(1, 3) ? 0 : 1;
    for (const std::size_t i : {first, first + 2})
      mesh.triangles.push_back({s.cells[i], s.cells[(i + 1) % 4], s.cells[(i + 2) % 4]});
  }
  return welded(mesh, 0);
}

}  // namespace bench
