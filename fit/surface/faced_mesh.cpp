#include "fit/surface/faced_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "geometry/mesh/decimate.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/segment/faces.h"
#include "model/tri_faces.h"

namespace partscribe::fit {
namespace {

using Labels = std::vector<std::uint32_t>;  // of each triangle: its face

/// Vertices at which several faces meet.
std::vector<std::uint8_t> border_vertices(const TriangleMesh& mesh, const Labels& label) {
  std::vector<std::uint32_t> first(mesh.vertices.size(), no_face);
  std::vector<std::uint8_t> border(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < label.size(); ++t)
    for (const auto v : mesh.triangles[t]) {
      if (first[v] == no_face) first[v] = label[t];
      if (first[v] != label[t]) border[v] = 1;
    }
  return border;
}

/// The faces of a mesh that was simplified between their borders: what these enclose belongs to the face that most of
/// it lies on. Nothing if the borders are no longer there.
std::optional<Labels> labels_of(const TriangleMesh& small, const TriangleMesh& source, const Labels& label) {
  using Key = std::array<double, 3>;
  const auto key = [](const Vec3& p) { return Key{p.x(), p.y(), p.z()}; };
  std::map<Key, std::uint32_t> numbers;
  for (std::uint32_t v = 0; v < small.vertices.size(); ++v) numbers[key(small.vertices[v])] = v;
  std::set<std::uint64_t> borders;
  bool kept = true;
  for_each_edge(edge_uses(source.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() != 2 || label[around[0].triangle] == label[around[1].triangle]) return;
    const auto a = numbers.find(key(source.vertices[around[0].low()]));
    const auto b = numbers.find(key(source.vertices[around[0].high()]));
    if (a == numbers.end() || b == numbers.end())
      kept = false;
    else
      borders.insert(edge_key(a->second, b->second));
  });
  if (!kept) return std::nullopt;
  DisjointSets regions(small.triangles.size());
  std::size_t found = 0;
  for_each_edge(edge_uses(small.triangles), [&](std::span<const EdgeUse> around) {
    if (borders.contains(around[0].key)) {
      ++found;
      return;
    }
    for (std::size_t i = 1; i < around.size(); ++i) regions.unite(around[0].triangle, around[i].triangle);
  });
  if (found != borders.size()) return std::nullopt;
  const MeshDistance nearest(source);
  std::map<std::uint32_t, std::map<std::uint32_t, double>> votes;  // area by region and face
  for (std::uint32_t t = 0; t < small.triangles.size(); ++t) {
    const Vec3 a = small.corner(t, 0), b = small.corner(t, 1), c = small.corner(t, 2);
    const auto hit = nearest.closest((a + b + c) / 3);
    votes[regions.root(t)][label[hit.triangle]] += (b - a).cross(c - a).norm();
  }
  Labels result(small.triangles.size());
  for (std::uint32_t t = 0; t < result.size(); ++t) {
    const auto& of_region = votes[regions.root(t)];
    result[t] = std::max_element(of_region.begin(), of_region.end(), [](const auto& x, const auto& y) {
                  return x.second < y.second;
                })->first;
  }
  return result;
}

}  // namespace

std::optional<FacedMesh> faced_mesh(const TriangleMesh& source, double tolerance, double max_error, Context& context) {
  if (!topology(source).closed()) return std::nullopt;
  FaceOptions options;
  options.tolerance = tolerance;
  const Faces found = faces_of_mesh(source, options, context);
  if (!mostly_known(found, source)) return std::nullopt;

  const auto rest = static_cast<std::uint32_t>(found.faces.size());
  Labels label = found.face_of;
  for (auto& l : label)
    if (l == no_face) l = rest;
  FacedMesh result;
  result.mesh = source;
  DecimateOptions fewer;
  fewer.max_error = max_error, fewer.frozen = border_vertices(source, label);
  const TriangleMesh small = decimated(source, fewer, context);
  if (auto labels = labels_of(small, source, label)) result.mesh = small, label = std::move(*labels);

  std::vector<std::uint32_t> order(label.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return label[a] < label[b]; });
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::size_t> count(found.faces.size() + 1, 0);
  for (const auto t : order) triangles.push_back(result.mesh.triangles[t]), ++count[label[t]];
  result.mesh.triangles = std::move(triangles);
  for (std::uint32_t f = 0; f <= rest; ++f) {
    if (count[f] == 0) continue;
    const Face face = f < rest ? found.faces[f] : Face{};
    std::string kind = name_of(face.kind);
    std::replace(kind.begin(), kind.end(), '_', ' ');
    result.faces.push_back(tri_face(face, kind + " " + std::to_string(f + 1), count[f]));
  }
  return result;
}

}  // namespace partscribe::fit
