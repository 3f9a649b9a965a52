/// Views are brought together by reference points that several of them show.
#include "scan/register/fiducials.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "scan/register/register_pair.h"

using namespace partscribe::scan;

namespace {

const std::vector<Vec3> places{{0, 0, 0}, {60, 5, 0}, {10, 50, 4}, {-20, 30, 25}, {15, -30, 40}, {70, 60, 20}};

struct FiducialScene {
  std::vector<RegisterView> views;
  std::vector<Pose> truth;
  std::vector<Fiducial> fiducials;
};

/// View 1 shares nothing with view 0, only with view 2, which shares four points with either.
FiducialScene three_views(double noise) {
  FiducialScene scene;
  scene.truth = {
      {}, {rotation_of(Vec3(0.2, 1.1, -0.4)), Vec3(100, 20, -30)}, {rotation_of(Vec3(-2, 0.3, 0.5)), Vec3(7, 8, 9)}};
  const std::vector<std::vector<std::size_t>> shown{{0, 1, 2}, {3, 4, 5}, {0, 1, 2, 3, 4, 5}};
  Random random(6);
  for (std::size_t v = 0; v < 3; ++v) {
    scene.views.emplace_back().name = "view_" + std::to_string(v) + ".ply";
    for (const std::size_t k : shown[v])
      scene.fiducials.push_back(
          {v, "m" + std::to_string(k),
           scene.truth[v].inverse() * places[k] + noise * Vec3(random.normal(), random.normal(), random.normal())});
  }
  return scene;
}

std::vector<View> named(const std::vector<std::string>& files) {
  std::vector<View> views(files.size());
  for (std::size_t v = 0; v < files.size(); ++v) views[v].file = files[v];
  return views;
}

}  // namespace

TEST_CASE("fiducials: points that several views show give their poses, from view to view") {
  const FiducialScene scene = three_views(0);
  const auto found = register_by_fiducials(scene.views, scene.fiducials);
  REQUIRE(found.ok());
  CHECK(found->views[0].status == ViewStatus::reference);
  for (const std::size_t v : {1, 2}) {
    CHECK(found->views[v].status == ViewStatus::registered);
    CHECK((found->views[v].world_from_view.rotation - scene.truth[v].rotation).norm() < 1e-12);
    CHECK((found->views[v].world_from_view.translation - scene.truth[v].translation).norm() < 1e-10);
    CHECK(found->views[v].residual_median < 1e-10);
  }
}

TEST_CASE("fiducials: what noise leaves of the points says how sure a pose is") {
  const FiducialScene scene = three_views(0.05);
  const auto found = register_by_fiducials(scene.views, scene.fiducials);
  REQUIRE(found.ok());
  for (const std::size_t v : {1, 2}) {
    const Pose off = found->views[v].world_from_view * scene.truth[v].inverse();
    const double angle = rotation_vector(off.rotation).norm();
    const double sigma = std::sqrt(found->views[v].covariance.topLeftCorner<3, 3>().trace());
    INFO("view " << v << ", " << angle << " of " << sigma);
    CHECK(angle > 0);
    CHECK(angle < 5 * sigma);
    CHECK(sigma < 0.01);
  }
}

TEST_CASE("fiducials: a view with two of them, or with three on a line, is refused, and that is said") {
  FiducialScene scene = three_views(0);
  std::erase_if(scene.fiducials, [](const Fiducial& f) { return f.view == 1 && f.name == "m5"; });
  auto found = register_by_fiducials(scene.views, scene.fiducials);
  REQUIRE(found.ok());
  CHECK(found->views[1].status == ViewStatus::refused);
  CHECK(found->views[1].reason.find("found 2") != std::string::npos);
  CHECK(found->warnings.size() == 1);

  scene.fiducials.clear();
  for (const std::size_t v : {0, 1})
    for (int k = 0; k < 3; ++k) scene.fiducials.push_back({v, std::to_string(k), Vec3(k, 2 * k, 0)});
  found = register_by_fiducials(scene.views, scene.fiducials);
  REQUIRE(found.ok());
  CHECK(found->views[1].status == ViewStatus::refused);

  scene.fiducials.resize(2);
  CHECK(!register_by_fiducials(scene.views, scene.fiducials).ok());
}

TEST_CASE("fiducials: a table is read with its heading, in the unit of the views") {
  const auto views = named({"a.png", "scan/b.png"});
  const auto read = parse_fiducials(
      "file,name,x,y,z\r\n# by hand\n\na.png, left ball,1,2,3\nb.png,\"left ball\",-1e1,0.5,0\n", views, 10);
  REQUIRE(read.ok());
  REQUIRE(read->size() == 2);
  CHECK((*read)[0].view == 0);
  CHECK((*read)[1].view == 1);
  CHECK((*read)[0].name == "left ball");
  CHECK((*read)[1].name == "left ball");
  CHECK((*read)[0].place == Vec3(10, 20, 30));
  CHECK((*read)[1].place == Vec3(-100, 5, 0));
}

TEST_CASE("fiducials: bad_tables say the line and what was expected") {
  const auto views = named({"a.png", "x/b.png", "y/b.png"});
  const auto message = [&](const std::string& text) {
    const auto read = parse_fiducials(text, views, 1);
    REQUIRE(!read.ok());
    return read.error().message;
  };
  CHECK(message("a.png,m,1,2\n") == "line 1: expected view file, name, x, y, z, found 4 cells");
  CHECK(message("a.png,m,1,2,3\na.png,n,1,x,3\n").find("line 2: expected three numbers") == 0);
  CHECK(message("c.png,m,1,2,3\n").find("'c.png', which no view has") != std::string::npos);
  CHECK(message("b.png,m,1,2,3\n").find("'b.png', which 2 views have") != std::string::npos);
  CHECK(message("a.png,m,1,2,3\na.png,m,1,2,3\n").find("line 2: expected each point once in a view") == 0);
}
