/// Claims about the picture of faces, made of faces by hand.
#include "cli/pictures/face_picture.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "testing/measured.h"
#include "testing/meshes.h"

namespace partscribe::testing {

namespace {

/// Each side of a box is a face of two triangles; the last has none.
Faces sides_of(const TriangleMesh& mesh) {
  Faces faces;
  faces.of_mesh = true;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); t += 2) {
    Face face = plane_face(mesh.corner(t, 0), triangle_normal(mesh, t), 1);
    face.members = {t, t + 1};
    const bool last = t + 2 >= mesh.triangles.size();
    for (int k = 0; k < 2; ++k)
      faces.face_of.push_back(last ? no_face : static_cast<std::uint32_t>(faces.faces.size()));
    if (!last) faces.faces.push_back(face);
  }
  return faces;
}

std::size_t colored(const Raster& picture) {
  return static_cast<std::size_t>(
      std::count_if(picture.pixels.begin(), picture.pixels.end(), [](const Color& c) { return !(c == Color()); }));
}

double hue_like(const Color& a, const Color& b) {
  return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
}

}  // namespace

TEST_CASE("face picture: neighbours in number have colours that differ") {
  Faces faces;
  faces.faces.assign(40, plane_face({0, 0, 0}, {0, 0, 1}, 1));
  for (std::size_t f = 0; f < 40; ++f)
    for (std::size_t other = f + 1; other < std::min<std::size_t>(40, f + 6); ++other)
      CHECK(hue_like(face_color(faces, f), face_color(faces, other)) > 40);
}

TEST_CASE("face picture: shows a mesh with its numbers, the same whatever the number of threads") {
  Scan scan;
  scan.mesh = box({0, 0, 0}, {30, 20, 10});
  Faces faces = sides_of(scan.mesh);
  Context one, two;
  one.threads = 1, two.threads = 2;
  const Raster picture = draw_faces(scan, faces, one);
  CHECK(picture.pixels == draw_faces(scan, faces, two).pixels);
  CHECK(colored(picture) > picture.pixels.size() / 10);
  // Without its number a face looks otherwise.
  Faces renumbered = faces;
  renumbered.faces.insert(renumbered.faces.begin(), 100, Face());
  for (auto& f : renumbered.face_of) f += f == no_face ? 0 : 100;
  CHECK_FALSE(picture.pixels == draw_faces(scan, renumbered, one).pixels);
}

TEST_CASE("face picture: points of a cloud are drawn in the colours of their faces, rejected ones not at all") {
  Scan scan;
  Faces faces;
  Face face = plane_face({0, 0, 0}, {0, 0, 1}, 2500);
  for (int x = 0; x < 100; ++x)
    for (int y = 0; y < 100; ++y) {
      face.members.push_back(static_cast<std::uint32_t>(scan.cloud.size()));
      scan.cloud.points.emplace_back(0.5 * x, 0.5 * y, 0);
      scan.cloud.normals.emplace_back(0, 0, 1);
      scan.cloud.rejected.push_back(0);
      faces.face_of.push_back(0);
    }
  faces.faces = {face};
  Context context;
  const Raster picture = draw_faces(scan, faces, context);
  std::set<std::array<int, 3>> colors;
  for (const auto& c : picture.pixels) colors.insert({c.red, c.green, c.blue});
  CHECK(colors.size() > 3);
  Scan with_outlier = scan;
  with_outlier.cloud.points.emplace_back(500, 500, 500);
  with_outlier.cloud.normals.emplace_back(0, 0, 1);
  with_outlier.cloud.rejected.push_back(1);
  faces.face_of.push_back(no_face);
  CHECK(draw_faces(with_outlier, faces, context).pixels == picture.pixels);
}

}  // namespace partscribe::testing
