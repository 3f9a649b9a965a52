/// Bodies of Gregory patches in IGES and STEP: read again by the real program they are where the patches are.
#include "codegen/exchange/iges.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

#include "codegen/emit.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/surfaces/curve_network.h"
#include "model/surface_patches.h"
#include "testing/program.h"
#include "verify/evaluate/evaluate.h"

using namespace partscribe::codegen;
using namespace partscribe::testing;

namespace {

/// A body over the six faces of a cube, no two of whose nodes are alike.
CurveNetwork six_sided_network() {
  std::vector<Vec3> nodes, normals;
  for (int k = 0; k < 8; ++k) {
    nodes.emplace_back(k & 1 ? 15 : -13, k & 2 ? 11 : -12, k & 4 ? 10 + k : -9);
    normals.push_back(Vec3(nodes.back() + Vec3(k, -2, 1)).normalized());
  }
  return network_through(nodes, normals,
                         {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

/// The degrees of the B-spline surfaces (entity 128) of an IGES file: parameters 3 and 4 of each.
std::vector<int> degrees_in(const std::string& text) {
  std::vector<int> degrees;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() < 80 || line[72] != 'P' || !line.starts_with("128,")) continue;
    std::istringstream numbers(line.substr(4));
    std::string number;
    for (int k = 0; k < 4 && std::getline(numbers, number, ','); ++k)
      if (k >= 2) degrees.push_back(std::stoi(number));
  }
  return degrees;
}

}  // namespace

TEST_CASE("iges: Gregory patches are NURBS there, and close the body that they are") {
  const CurveNetwork network = six_sided_network();
  const auto patches = gregory_patches(network);
  REQUIRE(patches.ok());
  SurfaceSet set;
  set.closed = true;
  const auto faces = trimmed_faces(network, *patches);
  for (std::size_t f = 0; f < faces.size(); ++f)
    set.patches.push_back(trimmed_patch(faces[f], "face_" + std::to_string(f + 1)));
  Model model;
  model.name = "gregory", model.tolerance = 0.1, model.as_scanned = false;
  model.objects.push_back({"body", set, {}, {}, {}});
  const auto right = checked(model, model.name);
  INFO((right.ok() ? "" : right.error().message));
  REQUIRE(right.ok());

  for (const std::string backend : {"iges", "step"}) {
    INFO(backend);
    Context context;
    const auto artifact = emit(*right, backend, {}, context);
    INFO((artifact.ok() ? "" : artifact.error().message));
    REQUIRE(artifact.ok());
    TemporaryDirectory folder;
    for (const auto& file : artifact->files) REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
    const auto read =
        partscribe::verify::evaluate_artifact(folder.path() / artifact->files[0].name, {model.tolerance}, context);
    INFO((read.ok() ? "" : read.error().message));
    REQUIRE(read.ok());
    CHECK(read->solid);
    CHECK(topology(read->mesh).closed());
    const MeshDistance distance(read->mesh);
    double worst = 0;
    for (const GregoryPatch& patch : *patches)
      for (int i = 0; i <= 20; ++i)
        for (int j = 0; j <= 20; ++j) worst = std::max(worst, distance.closest(patch.at(i / 20.0, j / 20.0)).distance);
    CHECK(worst < 0.2 * model.tolerance);
    const SurfaceTriangles fine = triangulated(faces, 0.01);
    CHECK(volume(read->mesh) == Approx(volume(fine.mesh)).epsilon(1e-3));
    if (backend != "iges") continue;
    const auto degrees = degrees_in(artifact->files[0].bytes);
    REQUIRE(degrees.size() == 12);
    for (const int degree : degrees) CHECK(degree == 7);
  }
}

TEST_CASE("iges: surfaces that do not touch each other are there side by side") {
  // Two faces of a cube that lie opposite each other, and two whole cubes.
  const auto network = six_sided_network();
  const auto patches = gregory_patches(network);
  REQUIRE(patches.ok());
  const auto faces = trimmed_faces(network, *patches);
  const auto moved_off = [](TrimmedSurface face, int edges) {
    for (Vec3& p : face.surface.points) p.x() += 60;
    for (auto& loop : face.loops)
      for (auto& trim : loop) trim.edge += edges;
    return face;
  };
  for (const bool closed : {false, true}) {
    SurfaceSet set;
    set.closed = closed;
    if (!closed) set.thickness = 1;
    std::vector<TrimmedSurface> all = {faces[0], faces[1]};
    if (closed) all = faces;
    if (closed)
      for (const auto& face : faces) all.push_back(moved_off(face, 100));
    for (const auto& face : all)
      set.patches.push_back(trimmed_patch(face, "face_" + std::to_string(set.patches.size())));
    Model model;
    model.name = "apart", model.tolerance = 0.1, model.as_scanned = false;
    model.objects.push_back({closed ? "body" : "sheet", set, {}, {}, {}});
    const auto right = checked(model, model.name);
    INFO((right.ok() ? "" : right.error().message));
    REQUIRE(right.ok());
    for (const std::string backend : {"iges", "step"}) {
      INFO(backend);
      Context context;
      const auto artifact = emit(*right, backend, {}, context);
      INFO((artifact.ok() ? "" : artifact.error().message));
      REQUIRE(artifact.ok());
      TemporaryDirectory folder;
      for (const auto& file : artifact->files) REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
      const auto read =
          partscribe::verify::evaluate_artifact(folder.path() / artifact->files[0].name, {model.tolerance}, context);
      INFO((read.ok() ? "" : read.error().message));
      REQUIRE(read.ok());
      CHECK(topology(read->mesh).components == 2);
      CHECK(area(read->mesh) == Approx(area(triangulated(all, 0.01).mesh)).epsilon(2e-3));
      if (closed) CHECK(volume(read->mesh) == Approx(volume(triangulated(all, 0.01).mesh)).epsilon(2e-3));
    }
  }
}
