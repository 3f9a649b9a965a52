#include "fit/sketch/common_outlines.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "core/random.h"
#include "fit/sketch/round_holes.h"

using namespace partscribe::fit;

namespace {

constexpr double noise = 0.3, band = 0.75, turn = 0.4;

Vec2 turned(const Vec2& p) {
  return {std::cos(turn) * p.x() - std::sin(turn) * p.y(), std::sin(turn) * p.x() + std::cos(turn) * p.y()};
}

/// Walls and end faces of a plate that stands turned, with outliers among them.
struct Plate {
  OutlineData data;
  Random random{11};

  Plate() { data.band = band, data.spacing = 1; }
  void wall(const Vec2& from, const Vec2& to, int count) {
    const Vec2 along = (to - from).normalized(), out(along.y(), -along.x());
    for (int i = 0; i < count; ++i)
      data.walls.push_back(
          {turned(from + random.uniform() * (to - from) + noise * random.normal() * out), turned(out)});
  }
  void arc(const Vec2& center, double radius, double from, double to, int count) {
    for (int i = 0; i < count; ++i) {
      const double a = random.uniform(from, to);
      const Vec2 out(std::cos(a), std::sin(a));
      data.walls.push_back({turned(center + (radius + noise * random.normal()) * out), turned(out)});
    }
  }
  void face(const Vec2& low, const Vec2& high, int count, const std::function<bool(const Vec2&)>& inside) {
    for (int i = 0; i < count;) {
      const Vec2 p(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()));
      if (inside(p)) data.ends.push_back(turned(p)), ++i;
    }
  }
  void outliers(const Vec2& low, const Vec2& high, int count) {
    for (int i = 0; i < count; ++i) {
      const double a = random.uniform(0, 2 * pi);
      data.walls.push_back(
          {turned({random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y())}), {std::cos(a), std::sin(a)}});
    }
  }
};

}  // namespace

TEST_CASE(
    "common outlines: an outlier of the end faces, however far off, is none of the cells in which no end face was") {
  Plate plate;
  plate.wall({0, 0}, {30, 0}, 100);
  plate.face({0, 0}, {30, 20}, 1500, [](const Vec2&) { return true; });
  const double alone = common_outlines(plate.data).front().cost;
  plate.data.ends[1] = {4000, 9000};  // not of those that the bounds are taken of
  CHECK(common_outlines(plate.data).front().cost == Approx(alone).epsilon(0.05));
}

TEST_CASE("common outlines: a slot of which one end and one wall were hidden") {
  Plate plate;
  const double r = 10, l = 30;
  plate.wall({0, -r}, {l, -r}, 120);
  plate.arc({0, 0}, r, pi / 2, 1.5 * pi, 80);
  plate.face({-r, -r}, {l + r, r}, 1500,
             [&](const Vec2& p) { return (p - Vec2(std::clamp(p.x(), 0.0, l), 0)).norm() < r; });
  plate.outliers({-20, -20}, {50, 20}, 60);
  const auto outlines = common_outlines(plate.data);
  REQUIRE_FALSE(outlines.empty());
  const CommonOutline& slot = outlines[0];
  CHECK(slot.form == OutlineForm::slot);
  CHECK(slot.radius() == Approx(r).margin(0.3));
  CHECK((slot.high - slot.low).maxCoeff() == Approx(l + 2 * r).margin(2));  // the faces alone tell
  const LoopPieces loop = slot.loop();
  REQUIRE(loop.segments.size() == 4);  // two lines, two half circles
  for (std::size_t i = 0; i < 4; ++i) CHECK((loop.segments[i].end - loop.segments[(i + 1) % 4].start).norm() < 1e-9);
}

TEST_CASE("common outlines: normals that point outward tell on which side of its step an L is solid") {
  Plate plate;
  plate.wall({72, 17}, {22, 17}, 600);
  plate.wall({22, 17}, {22, 42}, 40);
  plate.wall({22, 42}, {0, 42}, 260);
  plate.face({0, 0}, {72, 17}, 60, [](const Vec2&) { return true; });
  plate.outliers({-5, -5}, {77, 47}, 60);
  const auto ell = [&] {
    for (const CommonOutline& o : common_outlines(plate.data))
      if (o.form == OutlineForm::ell) return o;
    return CommonOutline{};
  };
  const Vec2 below = turned({47, 13}), beyond = turned({47, 21});
  const auto solid_below = [&](const CommonOutline& o) { return o.distance(below) < 0 && o.distance(beyond) > 0; };
  plate.data.outward = true;
  CHECK(solid_below(ell()));
  // Turned round they tell the other side; of unknown sign they tell none.
  for (PlanePoint& w : plate.data.walls) w.normal = -w.normal;
  CHECK_FALSE(solid_below(ell()));
  plate.data.outward = false;
  const double unknown = ell().cost;
  for (PlanePoint& w : plate.data.walls) w.normal = -w.normal;
  CHECK(ell().cost == Approx(unknown));
}

TEST_CASE("common outlines: the walls of two holes say where a link ends that was hidden") {
  Plate plate;
  const double r = 17, l = 42, eye = 9;
  const auto inside = [&](const Vec2& p) {
    const bool in_hole = p.norm() < eye || (p - Vec2(l, 0)).norm() < eye;
    return !in_hole && (p - Vec2(std::clamp(p.x(), 0.0, l), 0)).norm() < r && p.x() > -2;
  };
  plate.wall({5, -r}, {l, -r}, 300), plate.arc({l, 0}, r, -pi / 2, 0.3, 200);
  plate.arc({0, 0}, eye, 1.6, 2.8, 25), plate.arc({l, 0}, eye, 1.6, 2.8, 60);
  plate.face({-r, -r}, {l + r, r}, 420, inside);
  plate.outliers({-30, -30}, {70, 30}, 60);
  const auto outlines = common_outlines(plate.data);
  REQUIRE_FALSE(outlines.empty());
  const CommonOutline& link = outlines[0];
  CHECK(link.form == OutlineForm::link);
  CHECK(link.eye == Approx(eye).margin(0.4));
  CHECK(link.radius() == Approx(r).margin(0.4));
  CHECK((link.end_centres()[0] - link.end_centres()[1]).norm() == Approx(l).margin(0.8));
  CHECK(link.distance(turned({0, 0})) == Approx(eye).margin(0.5));  // a hole is outside
}

TEST_CASE("common outlines: four equal rounds of which two were seen") {
  Plate plate;
  const double x = 60, y = 40, r = 8;
  plate.wall({r, 0}, {x - r, 0}, 150), plate.wall({x, r}, {x, y - r}, 100);
  plate.arc({r, r}, r, pi, 1.5 * pi, 40), plate.arc({x - r, r}, r, 1.5 * pi, 2 * pi, 40);
  plate.face({0, 0}, {x, y}, 1500, [&](const Vec2& p) {
    const Vec2 q = (p - Vec2(x / 2, y / 2)).cwiseAbs() - Vec2(x / 2 - r, y / 2 - r);
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) < r;
  });
  plate.outliers({-10, -10}, {70, 50}, 60);
  const auto outlines = common_outlines(plate.data);
  REQUIRE_FALSE(outlines.empty());
  CHECK(outlines[0].form == OutlineForm::rounded);
  CHECK(outlines[0].radius() == Approx(r).margin(0.8));
  CHECK((outlines[0].high - outlines[0].low).maxCoeff() == Approx(x).margin(0.8));
  CHECK((outlines[0].high - outlines[0].low).minCoeff() == Approx(y).margin(2));  // one of its walls was hidden
  CHECK(outlines[0].loop().segments.size() == 8);
}

TEST_CASE("common outlines: an L is told from its rectangle") {
  Plate plate;
  plate.wall({0, 0}, {50, 0}, 120), plate.wall({20, 15}, {20, 40}, 60), plate.wall({0, 40}, {0, 0}, 100);
  plate.face({0, 0}, {50, 40}, 1200, [](const Vec2& p) { return p.x() < 20 || p.y() < 15; });
  plate.outliers({-10, -10}, {60, 50}, 60);
  const auto outlines = common_outlines(plate.data);
  REQUIRE_FALSE(outlines.empty());
  CHECK(outlines[0].form == OutlineForm::ell);
  CHECK(outlines[0].area() == Approx(20 * 40 + 30 * 15).epsilon(0.12));
  CHECK(outlines[0].loop().segments.size() == 6);
  CHECK(outlines[0].distance(turned({35, 27})) > 5);
  CHECK(outlines[0].distance(turned({10, 20})) < -5);
}

TEST_CASE("common outlines: nothing comes of nothing") {
  CHECK(common_outlines({}).empty());
  Plate plate;
  plate.wall({0, 0}, {50, 0}, 120);
  CHECK(common_outlines(plate.data).empty());  // no end face
  OutlineData line;
  line.band = 0.1;
  for (int i = 0; i < 50; ++i) line.walls.push_back({{double(i), 0}, {0, 1}}), line.ends.emplace_back(double(i), 0);
  CHECK(common_outlines(line).empty());
}

TEST_CASE("round holes: sixty degrees of wall, and the faces that end around it") {
  Plate plate;
  const Vec2 centre(20, 14);
  const double r = 6;
  plate.face({0, 0}, {50, 30}, 1500, [&](const Vec2& p) { return (p - centre).norm() > r; });
  std::vector<Vec2> between;
  for (int i = 0; i < 24; ++i) {
    const double a = plate.random.uniform(0, pi / 3);
    between.push_back(turned(centre + (r + noise * plate.random.normal()) * Vec2(std::cos(a), std::sin(a))));
  }
  for (int i = 0; i < 20; ++i) between.push_back(turned({plate.random.uniform(0, 50), plate.random.uniform(0, 30)}));
  const auto holes = hardly_seen_holes(between, plate.data.ends, band, 50);
  REQUIRE(holes.size() == 1);
  CHECK((holes[0].center - turned(centre)).norm() < 0.7);
  CHECK(holes[0].radius == Approx(r).margin(0.5));

  const auto about = holes_about({turned(centre)}, 12, between, plate.data.ends, band);
  REQUIRE(about.size() == 1);
  CHECK(about[0].radius == Approx(r).margin(0.4));
}

TEST_CASE("round holes: beside a shadow in the end faces their walls say how large they are") {
  Plate plate;
  const Vec2 centre(25, 22), shadow(33, 31);
  const double r = 7;
  plate.face({0, 0}, {80, 44}, 1500,
             [&](const Vec2& p) { return (p - centre).norm() > r && (p - shadow).norm() > 14; });
  std::vector<Vec2> between;
  for (int i = 0; i < 70; ++i) {
    const double a = plate.random.uniform(0.75 * pi, 1.25 * pi);
    between.push_back(turned(centre + (r + noise * plate.random.normal()) * Vec2(std::cos(a), std::sin(a))));
  }
  for (int i = 0; i < 20; ++i) between.push_back(turned({plate.random.uniform(0, 80), plate.random.uniform(0, 44)}));
  const auto by_walls = hardly_seen_holes(between, plate.data.ends, band, 80, true);
  REQUIRE(by_walls.size() == 1);
  CHECK(by_walls[0].radius == Approx(r).margin(1.2));
  CHECK((by_walls[0].center - turned(centre)).norm() < 1.5);
}

TEST_CASE("round holes: none where the face goes on") {
  Plate plate;
  plate.face({0, 0}, {50, 30}, 1500, [](const Vec2&) { return true; });
  std::vector<Vec2> between;
  for (int i = 0; i < 24; ++i) {
    const double a = plate.random.uniform(0, pi / 3);
    between.push_back(turned(Vec2(20, 14) + 6 * Vec2(std::cos(a), std::sin(a))));
  }
  CHECK(hardly_seen_holes(between, plate.data.ends, band, 50).empty());
  CHECK(holes_about({turned({20, 14})}, 12, between, plate.data.ends, band).empty());
}

TEST_CASE("common outlines: a plate of which no wall was seen is found wherever it stands") {
  Plate plate;
  plate.face({0, 0}, {50, 30}, 1500, [](const Vec2& p) { return p.x() + p.y() < 55; });
  plate.outliers({-10, -10}, {60, 40}, 60);
  const double here = common_outlines(plate.data)[0].cost;
  OutlineData there = plate.data;
  const Vec2 far(600, -400);
  for (auto& w : there.walls) w.position += far;
  for (auto& e : there.ends) e += far;
  CHECK(common_outlines(there)[0].cost == Approx(here).epsilon(0.005));
}
