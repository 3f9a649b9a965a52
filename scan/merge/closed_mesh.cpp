#include "scan/merge/closed_mesh.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/ensure.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/self_intersection.h"

namespace partscribe::scan {
namespace {

constexpr std::size_t fewest_points = 20;

using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;  // smaller corner first
MeshEdge edge_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

TriangleMesh icosahedron() {
  const double g = 0.5 * (1 + std::sqrt(5.0));
  TriangleMesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

/// The corner of a triangle before its longest edge; of equal ones the same for both triangles of an edge.
std::size_t longest_edge_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const auto key = [&](std::size_t k) {
    const MeshEdge e = edge_of(t[k], t[(k + 1) % 3]);
    return std::make_pair((mesh.vertices[e.first] - mesh.vertices[e.second]).squaredNorm(), e);
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (key(k) > key(best)) best = k;
  return best;
}

/// All triangles that are marked in four, others into two or three where an edge of theirs was divided; then their
/// longest edge is divided as well, so that angles stay bounded (Rivara 1984). What was closed stays closed.
TriangleMesh divided(const TriangleMesh& mesh, const std::vector<std::uint8_t>& marked) {
  std::map<MeshEdge, std::uint32_t> middles;
  TriangleMesh result;
  result.vertices = mesh.vertices;
  const auto divide = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, fresh] = middles.try_emplace(edge_of(a, b), static_cast<std::uint32_t>(result.vertices.size()));
    if (fresh) result.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    return fresh;
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    if (marked[i])
      for (std::size_t k = 0; k < 3; ++k) divide(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
  for (bool more = true; more;) {
    more = false;
    for (const auto& t : mesh.triangles) {
      bool any = false;
      for (std::size_t k = 0; k < 3; ++k) any = any || middles.contains(edge_of(t[k], t[(k + 1) % 3]));
      const std::size_t k = longest_edge_of(mesh, t);
      if (any && divide(t[k], t[(k + 1) % 3])) more = true;
    }
  }
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto found = middles.find(edge_of(a, b));
    return found == middles.end() ? ~0u : found->second;
  };
  for (const auto& t : mesh.triangles) {
    const std::size_t k = longest_edge_of(mesh, t);
    const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    if (ab == ~0u) {
      result.triangles.push_back(t);
      continue;
    }
    if (bc == ~0u) {
      result.triangles.push_back({ab, b, c});
    } else {
      result.triangles.push_back({ab, b, bc});
      result.triangles.push_back({ab, bc, c});
    }
    if (ca == ~0u) {
      result.triangles.push_back({a, ab, c});
    } else {
      result.triangles.push_back({a, ab, ca});
      result.triangles.push_back({ca, ab, c});
    }
  }
  return result;
}

/// What pulls at the surface: each point at one place of a triangle, by the shares of its corners.
struct Pull {
  std::array<std::uint32_t, 3> corners;
  Vec3 shares;
  Vec3 target;
};

/// Shares of a place inside of a triangle.
Vec3 shares_at(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& place) {
  const Vec3 u = b - a, v = c - a, w = place - a;
  const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm(), wu = w.dot(u), wv = w.dot(v);
  const double area = uu * vv - uv * uv;
  if (!(area > 0)) return {1, 0, 0};
  const double s = std::clamp((vv * wu - uv * wv) / area, 0.0, 1.0);
  const double t = std::clamp((uu * wv - uv * wu) / area, 0.0, 1.0 - s);
  return {1 - s - t, s, t};
}

std::vector<std::vector<std::uint32_t>> neighbours_of(const TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> result(mesh.vertices.size());
  for (const auto& t : mesh.triangles)  // each edge is run through in this direction once
    for (std::size_t k = 0; k < 3; ++k) result[t[k]].push_back(t[(k + 1) % 3]);
  return result;
}

/// The sum of squared distances of pulls and `stiffness` times that of each corner from the mean of its neighbours,
/// made least by conjugate gradients; both are means over the corners.
class Elastic {
 public:
  Elastic(const TriangleMesh& mesh, const std::vector<Pull>& pulls, double stiffness)
      : pulls_(pulls),
        near_(neighbours_of(mesh)),
        weight_(static_cast<double>(mesh.vertices.size()) / static_cast<double>(pulls.size())),
        stiffness_(stiffness) {}

  std::vector<Vec3> solved(std::vector<Vec3> x) const {
    constexpr int most_steps = 150;
    constexpr double enough = 1e-4;
    std::vector<Vec3> pull(x.size(), Vec3::Zero());
    std::vector<double> diagonal(x.size(), 0);
    for (const Pull& p : pulls_)
      for (int k = 0; k < 3; ++k) {
        pull[p.corners[std::size_t(k)]] += weight_ * p.shares[k] * p.target;
        diagonal[p.corners[std::size_t(k)]] += weight_ * p.shares[k] * p.shares[k];
      }
    for (std::size_t v = 0; v < x.size(); ++v) {
      diagonal[v] += stiffness_;
      for (const std::uint32_t n : near_[v]) {
        const auto valence = static_cast<double>(near_[n].size());
        diagonal[v] += stiffness_ / (valence * valence);
      }
    }
    std::vector<Vec3> r = product(x), z(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) r[v] = pull[v] - r[v], z[v] = r[v] / diagonal[v];
    std::vector<Vec3> d = z;
    // The three coordinates are one vector: they share the matrix.
    double rz = dot(r, z);
    const double stop = enough * enough * dot(pull, pull) * 1e-4;
    for (int step = 0; step < most_steps && dot(r, r) > stop; ++step) {
      const std::vector<Vec3> ad = product(d);
      const double along = rz / dot(d, ad);
      for (std::size_t v = 0; v < x.size(); ++v) x[v] += along * d[v], r[v] -= along * ad[v], z[v] = r[v] / diagonal[v];
      const double next = dot(r, z);
      for (std::size_t v = 0; v < x.size(); ++v) d[v] = z[v] + next / rz * d[v];
      rz = next;
    }
    return x;
  }

 private:
  static double dot(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double sum = 0;
    for (std::size_t v = 0; v < a.size(); ++v) sum += a[v].dot(b[v]);
    return sum;
  }
  std::vector<Vec3> product(const std::vector<Vec3>& x) const {
    std::vector<Vec3> result(x.size(), Vec3::Zero());
    for (const Pull& p : pulls_) {
      const auto& c = p.corners;
      const Vec3 place = weight_ * (p.shares[0] * x[c[0]] + p.shares[1] * x[c[1]] + p.shares[2] * x[c[2]]);
      for (std::size_t k = 0; k < 3; ++k) result[c[k]] += p.shares[int(k)] * place;
    }
    for (std::size_t v = 0; v < x.size(); ++v) {
      Vec3 bend = x[v];
      const double share = 1 / static_cast<double>(near_[v].size());
      for (const std::uint32_t n : near_[v]) bend -= share * x[n];
      bend *= stiffness_;
      result[v] += bend;
      for (const std::uint32_t n : near_[v]) result[n] -= share * bend;
    }
    return result;
  }
  const std::vector<Pull>& pulls_;
  std::vector<std::vector<std::uint32_t>> near_;
  double weight_, stiffness_;
};

std::vector<MeshHit> nearest_places(const TriangleMesh& mesh, const std::vector<Vec3>& points, int threads) {
  return MeshDistance(mesh, threads).closest(points, threads);
}

/// Drawn towards the points once.
void draw(TriangleMesh& mesh, const std::vector<Vec3>& points, double stiffness, int threads) {
  const auto hits = nearest_places(mesh, points, threads);
  std::vector<Pull> pulls;
  pulls.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t t = hits[i].triangle;
    pulls.push_back({mesh.triangles[t],
                     shares_at(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), hits[i].point), points[i]});
  }
  mesh.vertices = Elastic(mesh, pulls, stiffness).solved(mesh.vertices);
}

/// Divided twice in four and stretched to the ellipsoid about the points; empty where they lie in a plane.
TriangleMesh start_around(const std::vector<Vec3>& points) {
  constexpr double wider = 1.05;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& p : points) scatter += (p - mean) * (p - mean).transpose();
  Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  Box3 box;
  for (const Vec3& p : points) box.add(axes.transpose() * p);
  const Vec3 half = 0.5 * box.size();
  if (!(half.minCoeff() > 1e-6 * half.maxCoeff())) return {};
  TriangleMesh mesh = icosahedron();
  for (int times = 0; times < 2; ++times) mesh = divided(mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 1));
  for (Vec3& v : mesh.vertices) v = axes * Vec3(box.center() + wider * half.cwiseProduct(v.normalized()));
  return mesh;
}

}  // namespace

Result<ClosedMesh> closed_mesh_around(const std::vector<Vec3>& points, const ClosedMeshOptions& options,
                                      Context& context) {
  ensure(options.tolerance > 0 && options.least_stiffness > 0, "a tolerance and a stiffness above zero");
  constexpr int draws = 8;          // of each size of triangles
  constexpr double softer = 0.4;    // from one draw to the next
  constexpr double stiff = 1;       // to begin with
  constexpr double restart = 0.03;  // of triangles that were divided: what is there already is nearly right
  if (points.size() < fewest_points)
    return bad_input("expected at least " + std::to_string(fewest_points) + " points all around a body, found " +
                     std::to_string(points.size()));
  ClosedMesh result;
  result.mesh = start_around(points);
  if (result.mesh.empty())
    return bad_input("expected points all around a body, found " + std::to_string(points.size()) + " in a plane");
  result.start_count = result.mesh.triangles.size();
  for (bool first = true;; first = false) {
    double stiffness = first ? stiff : std::max(restart, options.least_stiffness);
    for (int k = 0; k < draws; ++k, stiffness = std::max(options.least_stiffness, softer * stiffness))
      draw(result.mesh, points, stiffness, context.threads);
    const auto hits = nearest_places(result.mesh, points, context.threads);
    std::vector<std::uint8_t> marked(result.mesh.triangles.size(), 0);
    double sum = 0;
    std::size_t off = 0;
    result.worst = 0;
    for (const MeshHit& hit : hits) {
      result.worst = std::max(result.worst, hit.distance), sum += hit.distance * hit.distance;
      if (hit.distance > options.tolerance) marked[hit.triangle] = 1, ++off;
    }
    result.rms = std::sqrt(sum / static_cast<double>(points.size()));
    result.within = 1 - static_cast<double>(off) / static_cast<double>(points.size());
    std::size_t count = 0;
    for (std::size_t t = 0; t < marked.size(); ++t) {
      const std::size_t k = marked[t] ? longest_edge_of(result.mesh, result.mesh.triangles[t]) : 0;
      if (marked[t] &&
          (result.mesh.corner(t, int(k)) - result.mesh.corner(t, int((k + 1) % 3))).norm() <= options.tolerance)
        marked[t] = 0;
      count += marked[t];
    }
    if (count == 0 || result.mesh.triangles.size() + 3 * count > options.most_triangles || context.cancelled) break;
    result.mesh = divided(result.mesh, marked);
  }
  result.crossings = self_intersections(result.mesh).size();
  return result;
}

}  // namespace partscribe::scan
