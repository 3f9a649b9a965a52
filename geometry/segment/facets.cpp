#include "geometry/segment/facets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/mesh/mesh_facets.h"

namespace partscribe::geometry {
namespace {

constexpr double same_plane = 0.99;  // cosine; flatness decides, this keeps folds apart
constexpr std::uint32_t none = ~0u;
constexpr std::size_t most_corners = 256;  // that a width is taken from

double width_across(const TriangleMesh& mesh, const Facet& facet, const Vec3& place, const Vec3& direction) {
  double width = 0;
  const std::size_t step = facet.vertices.size() / most_corners + 1;
  for (std::size_t i = 0; i < facet.vertices.size(); i += step) {
    const Vec3 d = mesh.vertices[facet.vertices[i]] - place;
    width = std::max(width, (d - d.dot(direction) * direction).squaredNorm());
  }
  return std::sqrt(width);
}

}  // namespace

Facets flat_pieces(const TriangleMesh& mesh, double flatness) {
  Facets result;
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  const auto uses = edge_uses(mesh.triangles);
  std::vector<std::array<std::uint32_t, 3>> beside(count, {none, none, none});
  std::vector<std::uint8_t> filled(count, 0);
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (uses[i].key != uses[i + 1].key) continue;
    const auto a = uses[i].triangle, b = uses[i + 1].triangle;
    if (filled[a] < 3) beside[a][filled[a]++] = b;
    if (filled[b] < 3) beside[b][filled[b]++] = a;
  }
  std::vector<Vec3> normals(count);
  std::vector<double> areas(count), heights(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const Vec3 cross = (b - a).cross(c - a);
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    areas[t] = 0.5 * cross.norm();
    normals[t] = cross.norm() > 0 ? Vec3(cross.normalized()) : Vec3::Zero();
    heights[t] = longest > 0 ? 2 * areas[t] / longest : 0;
  }
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return areas[a] != areas[b] ? areas[a] > areas[b] : a < b; });
  result.facet_of.assign(count, none);
  for (const auto seed : order) {
    if (result.facet_of[seed] != none) continue;
    const auto number = static_cast<std::uint32_t>(result.facets.size());
    Facet facet;
    facet.normal = normals[seed];
    const Vec3 place = mesh.corner(seed, 0);
    facet.triangles = {seed};
    result.facet_of[seed] = number;
    for (std::size_t i = 0; i < facet.triangles.size(); ++i)
      for (const auto t : beside[facet.triangles[i]]) {
        if (t == none || result.facet_of[t] != none) continue;
        // The normal of a sliver says nothing.
        if (heights[t] > 3 * flatness && normals[t].dot(facet.normal) < same_plane) continue;
        bool flat = true;
        for (int k = 0; k < 3 && flat; ++k) flat = std::abs(facet.normal.dot(mesh.corner(t, k) - place)) <= flatness;
        if (!flat) continue;
        result.facet_of[t] = number;
        facet.triangles.push_back(t);
      }
    std::sort(facet.triangles.begin(), facet.triangles.end());
    for (const auto t : facet.triangles) {
      facet.area += areas[t];
      facet.middle += areas[t] / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
      for (const auto v : mesh.triangles[t]) facet.vertices.push_back(v);
    }
    std::sort(facet.vertices.begin(), facet.vertices.end());
    facet.vertices.erase(std::unique(facet.vertices.begin(), facet.vertices.end()), facet.vertices.end());
    facet.middle = facet.area > 0 ? Vec3(facet.middle / facet.area) : place;
    result.facets.push_back(std::move(facet));
  }

  struct Shared {
    std::uint32_t first, second, from, to;  // the edge as the first facet runs along it
    double length;
  };
  std::vector<Shared> shared;
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (uses[i].key != uses[i + 1].key) continue;
    const auto a = result.facet_of[uses[i].triangle], b = result.facet_of[uses[i + 1].triangle];
    if (a == b) continue;
    const EdgeUse& use = uses[a < b ? i : i + 1];
    shared.push_back({std::min(a, b), std::max(a, b), use.from(), use.to(),
                      (mesh.vertices[use.to()] - mesh.vertices[use.from()]).norm()});
  }
  std::sort(shared.begin(), shared.end(), [](const Shared& a, const Shared& b) {
    if (a.first != b.first) return a.first < b.first;
    if (a.second != b.second) return a.second < b.second;
    return a.length != b.length ? a.length > b.length : a.from < b.from;
  });
  for (std::size_t i = 0; i < shared.size();) {
    FacetLink link;
    link.first = shared[i].first, link.second = shared[i].second;
    const Facet &f = result.facets[link.first], &g = result.facets[link.second];
    const Vec3 place = mesh.vertices[shared[i].from];
    const Vec3 along =
        shared[i].length > 0 ? Vec3((mesh.vertices[shared[i].to] - place) / shared[i].length) : Vec3::Zero();
    link.angle = std::atan2(f.normal.cross(g.normal).norm(), f.normal.dot(g.normal));
    link.convex = f.normal.cross(g.normal).dot(along) > 0;
    link.first_width = width_across(mesh, f, place, along);
    link.second_width = width_across(mesh, g, place, along);
    const std::size_t begin = i;
    for (; i < shared.size() && shared[i].first == shared[begin].first && shared[i].second == shared[begin].second; ++i)
      link.length += shared[i].length;
    result.links.push_back(link);
  }
  return result;
}

}  // namespace partscribe::geometry
