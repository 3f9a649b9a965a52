#include "cli/report/report_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "geometry/mesh/decimate.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/points/kd_tree.h"
#include "verify/compare/samples.h"

namespace partscribe::cli {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr double cos_smooth = 0.8660254;  // 30 degrees

/// A mesh of bearable size, and how far it may lie from `mesh`.
TriangleMesh thinned(const TriangleMesh& mesh, const SurfaceOptions& options, double& error, Context& context) {
  TriangleMesh thin = welded(mesh, 0);
  error = 0;
  if (thin.vertices.size() <= options.most_vertices / 2) return thin;
  const auto shape = topology(thin);
  if (shape.nonmanifold_edges == 0 && shape.inconsistent_edges == 0) {
    DecimateOptions how;
    how.max_error = options.max_error;
    how.target_triangles = options.most_vertices;
    thin = decimated(thin, how, context);
    error = options.max_error;
  }
  // Vertices on a common grid: crude, but it takes any mesh.
  const double size = thin.bounds().diagonal();
  for (double cell = size / 1000; thin.vertices.size() > options.most_vertices * 3 / 4; cell *= 1.25) {
    thin = welded(mesh, cell);
    error = 0.5 * std::sqrt(3.0) * cell;
  }
  return thin;
}

/// Splits vertices so that each has one normal: triangles around a vertex that bend by less than 30 degrees share it.
void split_creases(const TriangleMesh& mesh, DeviationSurface& surface) {
  const auto normals = triangle_normals(mesh);
  std::vector<std::uint32_t> first(mesh.vertices.size() + 1, 0);
  for (const auto& triangle : mesh.triangles)
    for (const auto v : triangle) ++first[v + 1];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) first[v + 1] += first[v];
  std::vector<std::array<std::uint32_t, 2>> around(first.back());  // triangle and corner
  auto next = first;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) around[next[mesh.triangles[t][k]]++] = {t, k};
  surface.triangles.assign(mesh.triangles.size(), {0, 0, 0});
  std::vector<std::uint32_t> group;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::uint32_t begin = first[v], count = first[v + 1] - begin;
    group.assign(count, count);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (group[i] < count) continue;
      // Flood over smooth neighbours: chains of small bends stay together.
      std::vector<std::uint32_t> stack = {i};
      group[i] = i;
      Vec3 sum = Vec3::Zero();
      const auto vertex = static_cast<std::uint32_t>(surface.points.size());
      while (!stack.empty()) {
        const auto j = stack.back();
        stack.pop_back();
        const auto [t, k] = around[begin + j];
        surface.triangles[t][k] = vertex;
        const Vec3 a = (mesh.corner(t, (k + 1) % 3) - mesh.vertices[v]),
                   b = (mesh.corner(t, (k + 2) % 3) - mesh.vertices[v]);
        sum += std::atan2(a.cross(b).norm(), a.dot(b)) * normals[t];
        for (std::uint32_t o = 0; o < count; ++o)
          if (group[o] == count && normals[around[begin + o][0]].dot(normals[t]) > cos_smooth)
            group[o] = i, stack.push_back(o);
      }
      surface.points.push_back(mesh.vertices[v]);
      surface.normals.push_back(sum.norm() > 0 ? Vec3(sum.normalized()) : normals[around[begin + i][0]]);
    }
  }
}

/// Leaves loops and what connects them: stray creases on a free form end in the middle of nowhere.
void drop_loose_ends(std::vector<std::array<std::uint32_t, 2>>& edges, std::size_t vertices) {
  std::vector<std::uint32_t> uses(vertices, 0);
  for (const auto& edge : edges) ++uses[edge[0]], ++uses[edge[1]];
  for (std::size_t before = edges.size() + 1; edges.size() < before;) {
    before = edges.size();
    std::erase_if(edges, [&](const auto& edge) {
      if (uses[edge[0]] > 1 && uses[edge[1]] > 1) return false;
      --uses[edge[0]], --uses[edge[1]];
      return true;
    });
  }
}

/// How far a triangle reaches across its longest side.
double width_of(const TriangleMesh& mesh, std::size_t t) {
  const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
  const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  return longest > 0 ? (b - a).cross(c - a).norm() / longest : 0;
}

/// Creases and borders of `mesh`, whose vertices may be off by `error`; indices of its vertices.
std::vector<std::array<std::uint32_t, 2>> drawn_edges(const TriangleMesh& mesh, double error) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  const auto normals = triangle_normals(mesh);
  // How a triangle leans that is narrower than its vertices are off says nothing.
  const auto leans = [&](const EdgeUse& use) { return error == 0 || width_of(mesh, use.triangle) > 2 * error; };
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() != 2 || (normals[around[0].triangle].dot(normals[around[1].triangle]) <= cos_smooth &&
                               leans(around[0]) && leans(around[1])))
      edges.push_back({around[0].low(), around[0].high()});
  });
  drop_loose_ends(edges, mesh.vertices.size());
  return edges;
}

/// Halves every edge longer than `longest` until none is left; false if that takes more than `most` vertices. Both
/// sides of a crease are cut at equal places, because only the ends of an edge decide.
bool refine(DeviationSurface& surface, double longest, std::size_t most) {
  for (;;) {
    const auto uses = edge_uses(surface.triangles);
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < uses.size(); ++i) {
      if (i && uses[i].key == uses[i - 1].key) continue;
      if ((surface.points[uses[i].low()] - surface.points[uses[i].high()]).norm() > longest)
        keys.push_back(uses[i].key);
    }
    if (keys.empty()) return true;
    const auto begin = static_cast<std::uint32_t>(surface.points.size());
    if (begin + keys.size() > most) return false;
    for (const auto key : keys) {
      const auto a = key >> 32, b = key & 0xffffffffu;
      const Vec3 normal = surface.normals[a] + surface.normals[b];
      surface.points.push_back(0.5 * (surface.points[a] + surface.points[b]));
      surface.normals.push_back(normal.norm() > 0 ? Vec3(normal.normalized()) : surface.normals[a]);
    }
    constexpr std::uint32_t none = ~0u;
    auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto key = edge_key(a, b);
      const auto found = std::lower_bound(keys.begin(), keys.end(), key);
      return found != keys.end() && *found == key ? begin + static_cast<std::uint32_t>(found - keys.begin()) : none;
    };
    std::vector<Triangle> cut;
    cut.reserve(surface.triangles.size() * 2);
    for (const auto& t : surface.triangles) {
      std::array<std::uint32_t, 3> m = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
      const auto count = 3 - std::count(m.begin(), m.end(), none);
      if (count == 0) {
        cut.push_back(t);
      } else if (count == 3) {
        cut.insert(cut.end(), {{t[0], m[0], m[2]}, {m[0], t[1], m[1]}, {m[2], m[1], t[2]}, {m[0], m[1], m[2]}});
      } else {
        std::size_t k = 0;  // turn so that the first edge is cut, and with two cuts the last is not
        while (m[k] == none || (count == 2 && m[(k + 2) % 3] != none)) ++k;
        const auto a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = m[k], bc = m[(k + 1) % 3];
        if (count == 1) {
          cut.insert(cut.end(), {{a, ab, c}, {ab, b, c}});
        } else {
          cut.push_back({ab, b, bc});
          const bool first = (surface.points[a] - surface.points[bc]).squaredNorm() <=
                             (surface.points[ab] - surface.points[c]).squaredNorm();
          if (first)
            cut.insert(cut.end(), {{a, ab, bc}, {a, bc, c}});
          else
            cut.insert(cut.end(), {{a, ab, c}, {ab, bc, c}});
        }
      }
    }
    surface.triangles = std::move(cut);
  }
}

/// One feature per vertex: those on a border between features are doubled.
void split_features(DeviationSurface& surface, const std::vector<std::int32_t>& of_triangle) {
  constexpr std::int32_t free = -2;
  surface.feature.assign(surface.points.size(), free);
  std::vector<std::array<std::int64_t, 3>> copies;  // vertex, feature, its double
  std::vector<std::uint32_t> chain(surface.points.size(), ~0u), next;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (auto& corner : surface.triangles[t]) {
      const auto feature = of_triangle[t];
      if (surface.feature[corner] == free) surface.feature[corner] = feature;
      if (surface.feature[corner] == feature) continue;
      auto link = chain[corner];
      while (link != ~0u && copies[link][1] != feature) link = next[link];
      if (link == ~0u) {
        link = static_cast<std::uint32_t>(copies.size());
        copies.push_back({corner, feature, static_cast<std::int64_t>(surface.points.size())});
        next.push_back(chain[corner]);
        chain[corner] = link;
        surface.points.push_back(Vec3(surface.points[corner]));
        surface.normals.push_back(Vec3(surface.normals[corner]));
        surface.feature.push_back(feature);
      }
      corner = static_cast<std::uint32_t>(copies[link][2]);
    }
}

/// Mean deviation of the scanned points nearby on the same feature, and what the verifier said of the place.
void measure(DeviationSurface& surface, const ArtifactVerdict& artifact, const PointCloud& cloud,
             const std::vector<float>& deviations, Context& context) {
  const std::size_t count = surface.points.size();
  surface.deviation.assign(count, 0);
  surface.support.assign(count, 0);
  const auto features = features_of(cloud, artifact);
  std::vector<Vec3> judged;
  std::vector<float> value;
  std::vector<std::int32_t> feature;
  for (std::size_t i = 0; i < deviations.size(); ++i)
    if (std::isfinite(deviations[i])) {
      judged.push_back(cloud.points[i]);
      value.push_back(deviations[i]);
      feature.push_back(features[i]);
    }
  const auto samples = even_samples(artifact.mesh, artifact.sample_support.size());
  std::vector<Vec3> places;
  for (const auto& sample : samples) places.push_back(sample.point);
  const KdTree points(judged), sampled(places);
  parallel_for(count, context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t v = begin; v < end; ++v) {
      if (!judged.empty()) {
        points.nearest(surface.points[v], 12, near);
        double sum = 0, weight = 0;
        for (const bool same : {true, false}) {
          for (const auto& n : near) {
            if (same && feature[n.index] != surface.feature[v]) continue;
            const double w = 1 / (n.sq_distance + 0.25 * near.back().sq_distance + 1e-12);
            sum += w * value[n.index], weight += w;
          }
          if (weight > 0) break;
        }
        surface.deviation[v] = weight > 0 ? static_cast<float>(sum / weight) : 0.0f;
      }
      if (places.empty()) continue;
      sampled.nearest(surface.points[v], 6, near);
      auto chosen = near.front().index;
      for (const auto& n : near)
        if (triangle_normal(artifact.mesh, samples[n.index].triangle).dot(surface.normals[v]) > 0.5) {
          chosen = n.index;
          break;
        }
      surface.support[v] = artifact.sample_support[chosen];
      if (surface.support[v] == 1) surface.deviation[v] = 0;
    }
  });
}

}  // namespace

std::vector<std::int32_t> features_of(const PointCloud& cloud, const ArtifactVerdict& artifact) {
  std::vector<std::int32_t> features(cloud.size(), -1);
  std::size_t next = 0;
  for (std::size_t i = 0; i < cloud.size() && next < artifact.point_object.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i]) features[i] = artifact.point_object[next++];
  return features;
}

DeviationSurface deviation_surface(const ArtifactVerdict& artifact, const PointCloud& cloud,
                                   const std::vector<float>& deviations, const SurfaceOptions& options,
                                   Context& context) {
  DeviationSurface coarse;
  if (artifact.mesh.empty()) return coarse;
  const TriangleMesh mesh = thinned(artifact.mesh, options, coarse.error, context);
  split_creases(mesh, coarse);
  // Small triangles first; long ones are wanted where they do not fit.
  const double total = area(mesh), wanted = static_cast<double>(options.most_vertices);
  DeviationSurface surface;
  const std::size_t most = options.most_vertices;
  for (double longest = std::sqrt(2 * total / wanted);; longest *= 1.2) {
    surface = coarse;
    if (refine(surface, longest, most) || longest > mesh.bounds().diagonal()) break;
  }
  std::vector<std::int32_t> of_triangle(surface.triangles.size(), -1);
  if (artifact.triangle_object.size() == artifact.mesh.triangles.size()) {
    const MeshDistance whole(artifact.mesh);
    parallel_for(of_triangle.size(), context.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const auto& [a, b, c] = surface.triangles[t];
        const Vec3 middle = (surface.points[a] + surface.points[b] + surface.points[c]) / 3;
        of_triangle[t] = artifact.triangle_object[whole.closest(middle).triangle];
      }
    });
  }
  split_features(surface, of_triangle);
  // Lines keep vertices of their own: they must not bend with the cuts of one side.
  const auto edges = drawn_edges(mesh, coarse.error);
  std::vector<std::uint32_t> end_of(mesh.vertices.size(), ~0u);
  for (const auto& edge : edges) {
    std::array<std::uint32_t, 2> ends{};
    for (std::size_t k = 0; k < 2; ++k) {
      auto& vertex = end_of[edge[k]];
      if (vertex == ~0u) {
        vertex = static_cast<std::uint32_t>(surface.points.size());
        surface.points.push_back(mesh.vertices[edge[k]]);
        surface.normals.push_back(Vec3(0, 0, 1));
        surface.feature.push_back(-1);
      }
      ends[k] = vertex;
    }
    surface.edges.push_back(ends);
  }
  if (surface.points.size() > 65535) {  // many creases: their doubled vertices do not fit
    SurfaceOptions fewer = options;
    fewer.most_vertices = options.most_vertices / 2;
    return deviation_surface(artifact, cloud, deviations, fewer, context);
  }
  measure(surface, artifact, cloud, deviations, context);
  return surface;
}

}  // namespace partscribe::cli
