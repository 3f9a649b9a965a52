/// Closed meshes and noisy points of them, for claims about the verifier.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "core/number.h"
#include "core/random.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/point_cloud.h"
#include "verify/compare/samples.h"
#include "verify/verify.h"

namespace partscribe::testing {

using namespace verify;

/// A solid of revolution about z through (radius, z) corners from axis to axis, counter-clockwise seen with z up:
/// bottom first. The first and last corner lie on the axis.
inline TriangleMesh turned(const std::vector<Vec2>& profile, int sectors) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> first;
  for (const auto& p : profile) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    const int count = p.x() > 0 ? sectors : 1;
    for (int j = 0; j < count; ++j) {
      const double a = 2 * pi * j / sectors;
      mesh.vertices.emplace_back(p.x() * std::cos(a), p.x() * std::sin(a), p.y());
    }
  }
  auto id = [&](std::size_t i, int j) { return first[i] + (profile[i].x() > 0 ? std::uint32_t(j % sectors) : 0u); };
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    for (int j = 0; j < sectors; ++j) {
      if (profile[i].x() > 0) mesh.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      if (profile[i + 1].x() > 0) mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i + 1, j)});
    }
  return mesh;
}

inline TriangleMesh sphere(double radius, int rings = 90) {
  std::vector<Vec2> profile;
  for (int i = 0; i <= rings; ++i) {
    const double t = pi * i / rings;
    profile.emplace_back(i == 0 || i == rings ? 0 : radius * std::sin(t), -radius * std::cos(t));
  }
  return turned(profile, 2 * rings);
}

/// Heights over a grid make a block: its bottom is z = 0. Steps are one cell wide, so keep the grid fine.
inline TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A square plate of edge 2 `half` and the given thickness with a round hole through it, centred at (x, y).
inline TriangleMesh holed_plate(double half, double thickness, double radius, double x, double y, int sectors = 128) {
  TriangleMesh mesh;
  // Rings: hole and outline, each at top and bottom; the outline has a vertex on every ray from the hole's centre
  // through the square's border, and the corners are among them.
  std::vector<double> angles;
  for (int j = 0; j < sectors; ++j) angles.push_back(2 * pi * j / sectors);
  for (const double cx : {-half, half})
    for (const double cy : {-half, half}) {
      double a = std::atan2(cy - y, cx - x);
      if (a < 0) a += 2 * pi;
      angles.push_back(a);
    }
  std::sort(angles.begin(), angles.end());
  angles.erase(std::unique(angles.begin(), angles.end(), [](double a, double b) { return std::abs(a - b) < 1e-9; }),
               angles.end());
  const auto n = static_cast<std::uint32_t>(angles.size());
  for (const double z : {0.0, thickness})
    for (const bool outer : {false, true})
      for (const double a : angles) {
        const Vec2 d(std::cos(a), std::sin(a));
        double t = radius;
        if (outer) {
          const double tx = d.x() > 1e-12 ? (half - x) / d.x() : d.x() < -1e-12 ? (-half - x) / d.x() : 1e9;
          const double ty = d.y() > 1e-12 ? (half - y) / d.y() : d.y() < -1e-12 ? (-half - y) / d.y() : 1e9;
          t = std::min(tx, ty);
        }
        mesh.vertices.emplace_back(x + t * d.x(), y + t * d.y(), z);
      }
  auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n, bi = 0, bo = n, ti = 2 * n, to = 3 * n;
    quad(bi + j, bi + k, bo + k, bo + j);  // bottom, looking down
    quad(ti + j, to + j, to + k, ti + k);  // top
    quad(bo + j, bo + k, to + k, to + j);  // outside
    quad(bi + k, bi + j, ti + j, ti + k);  // hole
  }
  return mesh;
}

/// A hole in the middle of a cell, or as far aside; radius 0: none.
struct StripHole {
  double radius = 0, x = 0, y = 0;
};

/// A row along x of square cells of edge 2 `half`, the first about the origin; bottom in z = 0.
inline TriangleMesh holed_strip(const std::vector<StripHole>& cells, double half, double thickness, int sectors = 64) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(sectors);
  auto exact = [](double v) { return std::round(v * 1e6) / 1e6; };  // so that neighbours share their corners
  auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    if (c != d) mesh.triangles.push_back({a, c, d});
  };
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const StripHole& hole = cells[i];
    const double middle = 2 * half * static_cast<double>(i);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const double z : {0.0, thickness})
      for (const bool outer : {false, true})
        for (std::uint32_t j = 0; j < n; ++j) {
          const double a = 2 * pi * j / n;
          const Vec2 d(std::cos(a), std::sin(a));
          const double t = outer ? half / std::max(std::abs(d.x()), std::abs(d.y())) : hole.radius;
          mesh.vertices.emplace_back(middle + exact(t * d.x() + (outer ? 0 : hole.x)),
                                     exact(t * d.y() + (outer ? 0 : hole.y)), z);
        }
    const std::uint32_t bi = first, bo = first + n, ti = first + 2 * n, to = first + 3 * n;
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t k = (j + 1) % n;
      const double across = std::cos(2 * pi * (j + 0.5) / n);
      const bool inner = (across > std::sqrt(0.5) && i + 1 < cells.size()) || (across < -std::sqrt(0.5) && i > 0);
      if (hole.radius > 0) {
        quad(bi + j, bi + k, bo + k, bo + j), quad(ti + j, to + j, to + k, ti + k);
        quad(bi + k, bi + j, ti + j, ti + k);
      } else {
        quad(bi, bo + k, bo + j, bo + j), quad(ti, to + j, to + k, to + k);
      }
      if (!inner) quad(bo + j, bo + k, to + k, to + j);
    }
  }
  return mesh;
}

/// A square block of edge `edge` whose vertical edge at the origin is rounded.
inline TriangleMesh rounded_block(double edge, double radius, double height, int steps = 32) {
  std::vector<Vec2> outline;
  for (int i = 0; i <= steps; ++i) {
    const double a = pi + pi / 2 * i / steps;
    outline.emplace_back(radius + radius * std::cos(a), radius + radius * std::sin(a));
  }
  outline.emplace_back(edge, 0), outline.emplace_back(edge, edge), outline.emplace_back(0, edge);
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double z : {0.0, height})
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  const std::uint32_t far = n - 2;  // the corner across: the caps are fans about it
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t k = (j + 1) % n;
    mesh.triangles.push_back({j, k, n + k}), mesh.triangles.push_back({j, n + k, n + j});
    if (j != far && k != far) mesh.triangles.push_back({far, k, j}), mesh.triangles.push_back({n + far, n + j, n + k});
  }
  return mesh;
}

inline TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto shift = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return a;
}

inline TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  for (auto& v : mesh.vertices) v += by;
  return mesh;
}

inline TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (auto& v : mesh.vertices) v *= factor;
  return mesh;
}

inline TriangleMesh mirrored(TriangleMesh mesh) {
  for (auto& v : mesh.vertices) v.x() = -v.x();
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// `count` even points with noise along the normal; no rays, no normals, no views.
inline Scan scanned(const TriangleMesh& mesh, std::size_t count, double sigma, std::uint64_t seed = 1) {
  Scan scan;
  Random random(seed);
  for (const auto& s : even_samples(mesh, count))
    scan.cloud.points.push_back(s.point + sigma * random.normal() * triangle_normal(mesh, s.triangle));
  scan.views.push_back({});
  return scan;
}

/// Parallel rays along `direction` on a square grid; every first hit with noise along the ray.
inline void add_view(Scan& scan, const TriangleMesh& mesh, const Vec3& direction, double pitch, double sigma,
                     std::uint64_t seed) {
  const MeshDistance surface(mesh);
  const Mat3 frame = rotation_onto_axis(direction);
  const double reach = mesh.bounds().diagonal();
  const Vec3 middle = mesh.bounds().center();
  Random random(seed);
  const auto view = static_cast<std::int32_t>(scan.views.size());
  scan.views.push_back({});
  for (double x = -0.6 * reach; x < 0.6 * reach; x += pitch)
    for (double y = -0.6 * reach; y < 0.6 * reach; y += pitch) {
      const Vec3 from = middle + frame * Vec3(x + 0.01234, y + 0.00567, -reach);
      const auto hit = surface.first_hit(from, direction, 3 * reach);
      if (!hit) continue;
      if (std::abs(triangle_normal(mesh, hit->triangle).dot(direction)) < 0.2) continue;  // sensors lose steep surface
      scan.cloud.points.push_back(from + (hit->distance + sigma * random.normal()) * direction);
      scan.cloud.rays.push_back(direction);
      scan.cloud.view.push_back(view);
    }
}

/// Writes the mesh as binary STL and verifies it against the scan.
inline Verdict verdict_on(const TriangleMesh& mesh, const Scan& scan, const VerifyOptions& options,
                          const std::optional<Model>& model = {}, int threads = 2) {
  const TemporaryDirectory folder;
  const Path file = folder.path() / "part.stl";
  ensure(write_file(file, write_stl(mesh)).ok(), "the test's own file cannot be written");
  Context context;
  context.threads = threads;
  auto verdict = verify_artifacts({file}, scan, model, options, context);
  ensure(verdict.ok(), "the test's own mesh cannot be verified");
  return *verdict;
}

inline std::string all_reasons(const Verdict& verdict) {
  std::string text;
  for (const auto& a : verdict.artifacts)
    for (const auto& r : a.reasons) text += r + "\n";
  return text;
}

}  // namespace partscribe::testing
