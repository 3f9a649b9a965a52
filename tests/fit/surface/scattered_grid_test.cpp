/// Scattered points of known surfaces as grids, and the published fit of what comes out.
#include "fit/surface/scattered_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::fit;

namespace {

double swell(double x, double y) { return 4 * std::sin(x / 7) * std::cos(y / 11) + 0.1 * x; }

/// Over 80 x 60 mm.
std::vector<Vec3> scattered_swell(int count, double noise, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0, 80), y = random.uniform(0, 60);
    points.emplace_back(x, y, swell(x, y) + noise * random.normal());
  }
  return points;
}

/// 6 mm inside of the outline, along which triangles are thin.
double rms_off_swell(const PlaceGrid& grid) {
  double sum = 0;
  int count = 0;
  for (const Vec3& p : grid.places)
    if (p.x() > 6 && p.x() < 74 && p.y() > 6 && p.y() < 54) sum += std::pow(p.z() - swell(p.x(), p.y()), 2), ++count;
  return std::sqrt(sum / count);
}

}  // namespace

TEST_CASE("scattered grid: of a plane the rows are level, their columns equal steps, and all places on the plane") {
  Random random(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i) {
    const double x = random.uniform(-10, 30), y = random.uniform(5, 25);
    points.emplace_back(x, y, 0.3 * x - 0.7 * y + 2);
  }
  const Pose world_from_plane{rotation_of(Vec3(0.4, 0.9, -0.3)), Vec3(100, -40, 7)};
  for (Vec3& p : points) p = world_from_plane * p;
  const auto found = grid_of_scattered(points, world_from_plane, {.columns = 21, .rows = 11});
  REQUIRE(found);
  REQUIRE(found->places.size() == 21 * 11);
  const auto local = [&](int c, int r) { return world_from_plane.inverse() * found->at(c, r); };
  for (int r = 0; r < 11; ++r)
    for (int c = 0; c < 21; ++c) {
      const Vec3 p = local(c, r);
      CHECK(p.z() == Approx(0.3 * p.x() - 0.7 * p.y() + 2).margin(1e-9));
      CHECK(p.y() == Approx(local(0, r).y()).margin(1e-9));
      if (c > 0) CHECK(p.x() - local(c - 1, r).x() == Approx(local(1, r).x() - local(0, r).x()).margin(1e-9));
      if (r > 0) CHECK(p.y() - local(c, r - 1).y() == Approx(local(0, 1).y() - local(0, 0).y()).margin(1e-9));
    }
  CHECK(local(0, 5).x() < -8);
  CHECK(local(20, 5).x() > 28);
}

TEST_CASE("scattered grid: contours of triangles are a quarter as far off with four times as many points") {
  double last = 0;
  for (const int count : {1000, 4000, 16000}) {
    const auto grid = grid_of_scattered(scattered_swell(count, 0, 2), {}, {.columns = 50, .rows = 40});
    REQUIRE(grid);
    const double off = rms_off_swell(*grid);
    INFO(count << " points: " << off);
    if (last > 0) CHECK(off < 0.35 * last);
    last = off;
  }
  CHECK(last < 0.01);
}

TEST_CASE("scattered grid: the published surface follows scattered points within the tolerance") {
  const auto points = scattered_swell(8000, 0.02, 3);
  const auto grid = grid_of_scattered(points, {}, {.columns = 60, .rows = 45});
  REQUIRE(grid);
  const auto fit = refined_surface(*grid, equal_spans(6), equal_spans(6), Parameters::uniform, 0.15);
  CHECK(fit.worst <= 0.15);
  double worst = 0, sum = 0;
  int inside = 0;
  for (const Vec3& p : points) {
    if (p.x() < 1.5 || p.x() > 78.5 || p.y() < 1.5 || p.y() > 58.5) continue;  // beyond the first row and its ends
    const auto foot = foot_near(fit.surface, p, p.x() / 80, p.y() / 60);
    worst = std::max(worst, foot.distance), sum += foot.distance * foot.distance, ++inside;
  }
  CHECK(worst < 0.15);
  CHECK(std::sqrt(sum / inside) < 0.04);
  // Few control points for many places, and what they say is nearer to the truth than the points are.
  CHECK(fit.surface.points.size() < points.size() / 10);
}

TEST_CASE(
    "scattered grid: rows end where the outline does, bays and windows of it are spanned unless edges are short") {
  Random random(4);
  std::vector<Vec3> disc, bay;
  while (disc.size() < 6000) {
    const double x = random.uniform(-20, 20), y = random.uniform(-20, 20);
    if (std::hypot(x, y) < 20) disc.emplace_back(x, y, 0.05 * x * y);
    // Two bars with nothing between them, joined at the left; a window in the upper one.
    const bool window = y > 5 && y < 15 && x > 0 && x < 10;
    if ((std::abs(y) > 5 || x < -10) && !window) bay.emplace_back(x, y, 0.01 * x * x);
  }
  const auto of_disc = grid_of_scattered(disc, {}, {.columns = 30, .rows = 30});
  REQUIRE(of_disc);
  for (int r = 0; r < 30; ++r) {
    const double y = of_disc->at(0, r).y(), half = std::sqrt(400 - y * y);
    CHECK(of_disc->at(0, r).x() == Approx(-half).margin(1.2));
    CHECK(of_disc->at(29, r).x() == Approx(half).margin(1.2));
  }
  const auto spanned = grid_of_scattered(bay, {}, {.columns = 41, .rows = 41});
  const auto short_edges = grid_of_scattered(bay, {}, {.columns = 41, .rows = 41, .longest_edge = 3});
  REQUIRE(spanned);
  REQUIRE(short_edges);
  CHECK(spanned->at(40, 20).x() > 19);
  CHECK(short_edges->at(40, 20).x() == Approx(-10).margin(0.6));
  CHECK(short_edges->at(40, 30).x() > 19);  // beyond the window
  const Vec3 across = short_edges->at(25, 30);
  REQUIRE(across.x() == Approx(5).margin(0.3));
  CHECK(across.z() == Approx(0.01 * 0.5 * (0 + 100)).margin(0.06));  // straight from one side to the other
}

TEST_CASE("scattered grid: the order of the points makes no difference") {
  auto points = scattered_swell(500, 0.1, 5);
  const auto one = grid_of_scattered(points, {}, {});
  std::reverse(points.begin(), points.end());
  const auto other = grid_of_scattered(points, {}, {});
  REQUIRE(one);
  REQUIRE(other);
  for (std::size_t i = 0; i < one->places.size(); ++i) CHECK((one->places[i] - other->places[i]).norm() < 1e-9);
}

TEST_CASE("scattered grid: bad_points say what was expected") {
  std::vector<Vec3> line;
  for (int i = 0; i < 20; ++i) line.emplace_back(i, 2 * i, 0.1 * i * i);
  CHECK(grid_of_scattered(line, {}, {}).error().message ==
        "expected scattered points that span a plane, found 20 that are on one line");
  const auto thin = grid_of_scattered(scattered_swell(50, 0, 6), {}, {.longest_edge = 0.01});
  REQUIRE(!thin);
  CHECK(thin.error().message.find("found none at row 1 of 40") != std::string::npos);
}
