/// The type of a primitive defines the distance: planar patches and triangles of a surface that grows view by view.
#include "scan/register/as_published/primitives.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

struct TwoViews {
  Case scan;
  std::vector<ViewSurface> surfaces;
};
TwoViews views_of_part(const Surface& part) {
  SimulateOptions scanner;
  scanner.resolution = 200, scanner.sigma = 0.005;
  TwoViews result{scan_in_poses(part, eight_poses(0.7, 0.6), scanner, 0, 0), {}};
  Context context;
  result.surfaces = view_surfaces(result.scan.views, 500, context, false);
  return result;
}

}  // namespace

TEST_CASE("primitives: the closest point on planar patches is the foot on the face, and ends where the face does") {
  const TwoViews views = views_of_part(cut_block());
  const auto model = model_of_patches({});
  CHECK(model->primitives() == 0);
  model->add(views.surfaces[0], views.scan.truth[0]);
  const std::size_t first = model->primitives();
  CHECK(first > 10);
  for (const ReferencePoint& point : reference_points(views.surfaces[0], {})) {
    const Vec3 p = views.scan.truth[0] * point.place, n = views.scan.truth[0].rotation * point.normal;
    const ClosestPoint x = model->closest(p + 0.7 * n);
    CHECK((x.place - p).norm() < 0.02);
    CHECK(x.normal.dot(n) > 0.9999);
    // Far beside the part no patch reaches.
    const Vec3 beside = p + 60 * n.unitOrthogonal();
    CHECK((model->closest(beside).place - beside).norm() > 30);
    CHECK((model->closest(beside).place).norm() < 30);
  }
  model->add(views.surfaces[1], views.scan.truth[1]);
  CHECK(model->primitives() > first);
}

TEST_CASE("primitives: patches are planes of the part, and small ones beside creases are left out") {
  const TwoViews views = views_of_part(cut_block());
  const auto patches = planar_patches(views.surfaces[0], {});
  REQUIRE(patches.size() > 10);
  std::size_t members = 0;
  for (const Patch& patch : patches) {
    members += patch.members.size();
    CHECK(patch.members.size() >= 12);
    for (const auto i : patch.members)
      CHECK(std::abs(patch.normal.dot(views.surfaces[0].points[i] - patch.center)) < 0.1);
  }
  CHECK(members < views.surfaces[0].points.size());
  CHECK(2 * members > views.surfaces[0].points.size());
}

TEST_CASE("primitives: points of free form are centres of fewer than a hundred triangles, and lie on the surface") {
  const Surface part = ball(20);
  const TwoViews views = views_of_part(part);
  const PaperOptions options = free_form_options();
  const TriangleMesh coarse = coarse_surface(views.surfaces[0], options.most_triangles);
  CHECK(coarse.triangles.size() < 100);
  CHECK(coarse.triangles.size() > 60);
  const auto points = reference_points(views.surfaces[0], options);
  REQUIRE(points.size() == coarse.triangles.size());
  for (const ReferencePoint& p : points) CHECK(std::abs((views.scan.truth[0] * p.place).norm() - 20) < 0.05);
  // Without the step back onto the surface all of them would lie inside.
  double inside = 0;
  for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
    const Vec3 center = (coarse.corner(t, 0) + coarse.corner(t, 1) + coarse.corner(t, 2)) / 3;
    inside += (20 - (views.scan.truth[0] * center).norm()) / double(coarse.triangles.size());
  }
  CHECK(inside > 0.2);
}

TEST_CASE("primitives: the triangulated surface grows by what a view adds, and by nothing else") {
  const TwoViews views = views_of_part(cut_block());
  const auto model = model_of_triangles(free_form_options());
  model->add(views.surfaces[0], views.scan.truth[0]);
  const std::size_t first = model->primitives();
  CHECK(first > 1000);
  model->add(views.surfaces[0], views.scan.truth[0]);
  CHECK(model->primitives() == first);
  model->add(views.surfaces[1], views.scan.truth[1]);
  const std::size_t both = model->primitives();
  CHECK(both > first);
  CHECK(both < 2 * first);  // what the views share is there once
  // What either view shows lies on it, but for points beside creases, where there are no triangles.
  int on = 0, off = 0;
  for (const std::size_t v : {0, 1})
    for (const ReferencePoint& point : reference_points(views.surfaces[v], free_form_options())) {
      const Vec3 p = views.scan.truth[v] * point.place;
      const ClosestPoint x = model->closest(p);
      ++((x.place - p).norm() < 0.1 && x.normal.dot(views.scan.truth[v].rotation * point.normal) > 0.99 ? on : off);
    }
  INFO(on << " on it, " << off << " off");
  CHECK(on > 100);
  CHECK(off < 0.1 * on);
}
