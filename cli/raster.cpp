#include "cli/raster.h"

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/ensure.h"

namespace partscribe {
namespace {

/// Column, row and depth of a world point.
Vec3 projected(const Raster& raster, const Camera& camera, const Vec3& point) {
  const Vec3 p = camera.view_from_world * (point - camera.center);
  return {0.5 * raster.width + p.x() * camera.pixels_per_mm, 0.5 * raster.height - p.y() * camera.pixels_per_mm, p.z()};
}

void put(Raster& raster, int column, int row, double depth, Color color) {
  if (column < 0 || row < 0 || column >= raster.width || row >= raster.height) return;
  const auto k = static_cast<std::size_t>(row) * raster.width + column;
  if (static_cast<float>(depth) <= raster.depth[k]) return;
  raster.depth[k] = static_cast<float>(depth);
  raster.pixels[k] = color;
}

/// An edge of the mesh with the triangles beside it.
struct Edge {
  std::uint64_t key;
  std::uint32_t triangle;
};

std::vector<Edge> sorted_edges(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b) << 32 | std::max(a, b), t});
    }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.key != b.key ? a.key < b.key : a.triangle < b.triangle; });
  return edges;
}

/// Normals at each triangle's corners: the area-weighted mean over the triangles of that vertex that bend away by
/// less than 30 degrees.
std::vector<std::array<Vec3, 3>> corner_normals(const TriangleMesh& mesh, const std::vector<Vec3>& normals) {
  std::vector<std::uint32_t> first(mesh.vertices.size() + 1, 0), around;
  for (const auto& triangle : mesh.triangles)
    for (const auto v : triangle) ++first[v + 1];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) first[v + 1] += first[v];
  around.resize(first.back());
  auto next = first;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const auto v : mesh.triangles[t]) around[next[v]++] = t;
  constexpr double cos_smooth = 0.8660254;
  std::vector<std::array<Vec3, 3>> result(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto v = mesh.triangles[t][k];
      Vec3 sum = Vec3::Zero();
      for (auto i = first[v]; i < first[v + 1]; ++i) {
        const auto u = around[i];
        if (normals[u].dot(normals[t]) < cos_smooth) continue;
        sum += (mesh.corner(u, 1) - mesh.corner(u, 0)).cross(mesh.corner(u, 2) - mesh.corner(u, 0));
      }
      result[t][k] = sum.norm() > 0 ? Vec3(sum.normalized()) : normals[t];
    }
  return result;
}

void draw_triangle(Raster& raster, const Camera& camera, const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& n,
                   Color color) {
  const double area = (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (p[1].y() - p[0].y());
  if (area == 0) return;
  auto bound = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit))); };
  const int left = bound(std::floor(std::min({p[0].x(), p[1].x(), p[2].x()})), raster.width - 1);
  const int right = bound(std::ceil(std::max({p[0].x(), p[1].x(), p[2].x()})), raster.width - 1);
  const int top = bound(std::floor(std::min({p[0].y(), p[1].y(), p[2].y()})), raster.height - 1);
  const int bottom = bound(std::ceil(std::max({p[0].y(), p[1].y(), p[2].y()})), raster.height - 1);
  for (int row = top; row <= bottom; ++row)
    for (int column = left; column <= right; ++column) {
      const double x = column + 0.5, y = row + 0.5;
      const double w1 = ((x - p[0].x()) * (p[2].y() - p[0].y()) - (p[2].x() - p[0].x()) * (y - p[0].y())) / area;
      const double w2 = ((p[1].x() - p[0].x()) * (y - p[0].y()) - (x - p[0].x()) * (p[1].y() - p[0].y())) / area;
      const double w0 = 1 - w1 - w2;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const Vec3 normal = w0 * n[0] + w1 * n[1] + w2 * n[2];
      put(raster, column, row, w0 * p[0].z() + w1 * p[1].z() + w2 * p[2].z(),
          shaded(color, camera, normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(0, 0, 1)));
    }
}

void draw_line(Raster& raster, const Vec3& from, const Vec3& to, double bias, Color color) {
  const double length = std::max(std::abs(to.x() - from.x()), std::abs(to.y() - from.y()));
  const int steps = static_cast<int>(std::min(length + 1, 20000.0));
  for (int i = 0; i <= steps; ++i) {
    const Vec3 p = from + (to - from) * (static_cast<double>(i) / std::max(steps, 1));
    const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
    // Two pixels wide, because the picture is halved afterwards.
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}})
      put(raster, column + dx, row + dy, p.z() + bias, color);
  }
}

void append_number(std::string& text, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) text += static_cast<char>(value >> shift);
}

void append_chunk(std::string& png, const std::string& type, const std::string& data) {
  append_number(png, static_cast<std::uint32_t>(data.size()));
  const std::string body = type + data;
  png += body;
  append_number(png, static_cast<std::uint32_t>(
                         ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

}  // namespace

Raster::Raster(int width_px, int height_px, Color background)
    : width(width_px),
      height(height_px),
      pixels(static_cast<std::size_t>(width_px) * height_px, background),
      depth(pixels.size(), -std::numeric_limits<float>::infinity()) {}

Camera camera_for(const std::vector<Vec3>& points, const Vec3& to_eye, const Vec3& up, int width_px, int height_px) {
  Camera camera;
  if (points.empty()) return camera;
  const Vec3 z = to_eye.normalized();
  Vec3 x = up.cross(z);
  if (x.norm() < 1e-9) x = z.unitOrthogonal();
  x.normalize();
  camera.view_from_world.row(0) = x;
  camera.view_from_world.row(1) = z.cross(x);
  camera.view_from_world.row(2) = z;
  Box3 seen;
  for (const auto& point : points) seen.add(camera.view_from_world * point);
  camera.center = camera.view_from_world.transpose() * seen.center();
  const Vec3 size = seen.size().cwiseMax(1e-9);
  constexpr double margin = 0.92;
  camera.pixels_per_mm = margin * std::min(width_px / size.x(), height_px / size.y());
  return camera;
}

Color shaded(Color color, const Camera& camera, const Vec3& normal) {
  const Vec3 n = camera.view_from_world * normal;
  static const Vec3 light = Vec3(-0.45, 0.65, 0.9).normalized();
  const Vec3 facing = n.z() < 0 ? Vec3(-n) : n;
  const double brightness = 0.32 + 0.68 * std::max(0.0, facing.dot(light));
  auto lit = [&](std::uint8_t c) { return static_cast<std::uint8_t>(std::min(255.0, c * brightness + 0.5)); };
  return {lit(color.red), lit(color.green), lit(color.blue)};
}

void draw_mesh(Raster& raster, const Camera& camera, const TriangleMesh& source, Color color) {
  const TriangleMesh mesh = welded(source, 0);
  std::vector<Vec3> normals(mesh.triangles.size()), places(mesh.vertices.size());
  for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = triangle_normal(mesh, t);
  for (std::size_t v = 0; v < places.size(); ++v) places[v] = projected(raster, camera, mesh.vertices[v]);
  const auto corners = corner_normals(mesh, normals);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    draw_triangle(raster, camera, {places[a], places[b], places[c]}, corners[t], color);
  }
  const auto edges = sorted_edges(mesh);
  const double bias = 1.5 / camera.pixels_per_mm;
  constexpr double cos_crease = 0.8660254;
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    for (end = i; end < edges.size() && edges[end].key == edges[i].key;) ++end;
    const bool smooth =
        end - i == 2 && std::abs(normals[edges[i].triangle].dot(normals[edges[i + 1].triangle])) > cos_crease;
    if (smooth) continue;
    draw_line(raster, places[edges[i].key >> 32], places[edges[i].key & 0xffffffffu], bias, {38, 48, 60});
  }
}

void draw_points(Raster& raster, const Camera& camera, const std::vector<Vec3>& points,
                 const std::vector<Color>& colors, double radius_px) {
  ensure(colors.size() == points.size(), "one colour per point");
  const int reach = static_cast<int>(std::ceil(radius_px));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = projected(raster, camera, points[i]);
    if (!(std::abs(p.x()) < 1e6 && std::abs(p.y()) < 1e6)) continue;
    const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx)
        if (dx * dx + dy * dy <= radius_px * radius_px) put(raster, column + dx, row + dy, p.z(), colors[i]);
  }
}

Raster halved(const Raster& raster) {
  Raster half(raster.width / 2, raster.height / 2, {});
  for (int row = 0; row < half.height; ++row)
    for (int column = 0; column < half.width; ++column) {
      int red = 2, green = 2, blue = 2;
      for (int k = 0; k < 4; ++k) {
        const auto& c = raster.pixels[static_cast<std::size_t>(2 * row + k / 2) * raster.width + 2 * column + k % 2];
        red += c.red, green += c.green, blue += c.blue;
      }
      half.pixels[static_cast<std::size_t>(row) * half.width + column] = {static_cast<std::uint8_t>(red / 4),
                                                                          static_cast<std::uint8_t>(green / 4),
                                                                          static_cast<std::uint8_t>(blue / 4)};
    }
  return half;
}

std::string write_png(const Raster& raster) {
  std::string rows;
  rows.reserve(raster.pixels.size() * 3 + raster.height);
  for (int row = 0; row < raster.height; ++row) {
    rows += '\1';  // filter "Sub": the difference to the pixel on the left
    Color left{0, 0, 0};
    for (int column = 0; column < raster.width; ++column) {
      const Color& c = raster.pixels[static_cast<std::size_t>(row) * raster.width + column];
      rows += static_cast<char>(c.red - left.red);
      rows += static_cast<char>(c.green - left.green);
      rows += static_cast<char>(c.blue - left.blue);
      left = c;
    }
  }
  uLongf size = ::compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  ensure(::compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                     static_cast<uLong>(rows.size()), 9) == Z_OK,
         "zlib packs a picture");
  packed.resize(size);
  std::string header;
  append_number(header, static_cast<std::uint32_t>(raster.width));
  append_number(header, static_cast<std::uint32_t>(raster.height));
  header += std::string("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB, deflate, adaptive filters, not interlaced
  std::string png = "\x89PNG\r\n\x1a\n";
  append_chunk(png, "IHDR", header);
  append_chunk(png, "IDAT", packed);
  append_chunk(png, "IEND", "");
  return png;
}

}  // namespace partscribe
