#include "bench/triangles/deviation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace bench {
namespace {

double farthest(const MeshDistance& mesh, std::span<const Vec3> places, int threads) {
  double most = 0;
  for (const MeshHit& hit : mesh.closest(places, threads)) most = std::max(most, hit.distance);
  return most;
}

}  // namespace

std::vector<Vec3> places_on(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> places = mesh.vertices;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  const auto steps = [&](double length) { return std::max(1, static_cast<int>(std::ceil(length / spacing))); };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    // Rows from the corner across to the longest side, in which places are as far apart as the rows: of slivers no more
    // than their area asks for.
    int longest = 0;
    double length[3];
    for (int k = 0; k < 3; ++k) {
      length[k] = (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm();
      if (length[k] > length[longest]) longest = k;
    }
    const Vec3 a = mesh.corner(t, longest), b = mesh.corner(t, (longest + 1) % 3),
               c = mesh.corner(t, (longest + 2) % 3);
    const double height = length[longest] > 0 ? (b - a).cross(c - a).norm() / length[longest] : 0;
    const int rows = steps(height);
    for (int i = 1; i < rows; ++i) {
      const Vec3 left = c + (a - c) * i / rows, right = c + (b - c) * i / rows;
      const int columns = steps((right - left).norm());
      for (int j = 1; j < columns; ++j) places.push_back(left + (right - left) * j / columns);
    }
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = mesh.triangles[t][k], to = mesh.triangles[t][(k + 1) % 3];
      edges.emplace_back(std::min(from, to), std::max(from, to));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [from, to] : edges) {
    const Vec3 along = mesh.vertices[to] - mesh.vertices[from];
    const int n = steps(along.norm());
    for (int i = 1; i < n; ++i) places.push_back(mesh.vertices[from] + along * i / n);
  }
  return places;
}

DeviationFrom::DeviationFrom(const TriangleMesh& data, double spacing, int threads)
    : data_(data, threads), places_(places_on(data, spacing)), spacing_(spacing), threads_(threads) {}

Deviation DeviationFrom::of(const TriangleMesh& mesh) const {
  const MeshDistance surface(mesh, threads_);
  return {farthest(surface, places_, threads_), farthest(data_, places_on(mesh, spacing_), threads_)};
}

bool DeviationFrom::within(const TriangleMesh& mesh, double bound) const {
  const MeshDistance surface(mesh, threads_);
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < places_.size(); i += 41) some.push_back(places_[i]);
  if (farthest(data_, mesh.vertices, threads_) > bound || farthest(surface, some, threads_) > bound) return false;
  return farthest(data_, places_on(mesh, spacing_), threads_) <= bound && farthest(surface, places_, threads_) <= bound;
}

}  // namespace bench
