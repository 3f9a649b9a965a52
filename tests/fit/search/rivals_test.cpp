/// What else the data allow, and what is said of it.
#include "fit/search/rivals.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "core/number.h"
#include "core/random.h"
#include "fit/build.h"
#include "testing/models.h"
#include "testing/sampled.h"

namespace partscribe::testing {

using namespace fit;
using partscribe::testing::model_with, partscribe::testing::reasons;

TEST_CASE("rivals: a cone that noise hides is a cylinder, and the model says that the data cannot tell") {
  Scan scan = sampled(model_with(Cone{10.02, 10, 30}), {.points = 3000, .noise = 0.1, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.5}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cylinder");
  CHECK(reasons(**model).find("the data cannot tell it from a cone: half angle") != std::string::npos);
}

TEST_CASE("rivals: a cone that the data show is not called undecided") {
  Scan scan = sampled(model_with(Cone{12, 10, 30}), {.points = 3000, .noise = 0.05, .reach = 20, .seed = 4});
  Context context;
  const auto model = build_model(scan, {.tolerance = 0.25}, context);
  REQUIRE(model);
  INFO(reasons(**model));
  CHECK(kind_of((*model)->objects.back().shape) == "cone");
  CHECK(reasons(**model).find("cannot tell") == std::string::npos);
}

TEST_CASE(
    "rivals: a cone with its tip far beyond the data is a cylinder, an ellipsoid of equal axes a ball, as far as "
    "sigmas tell") {
  const auto with = [](Shape shape, std::vector<std::array<double, 2>> sizes) {
    Candidate c;
    c.shape = std::move(shape);
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      Parameter p;
      p.name = "size_" + std::to_string(k), p.value = p.fitted = sizes[k][0], p.sigma = sizes[k][1];
      c.parameters.push_back(p);
    }
    return simpler_kind(c);
  };
  const Cone tip{Expr::of("size_0"), 0, Expr::of("size_1")};
  CHECK(with(tip, {{12, 0.4}, {1500, 900}}) == "cylinder");
  CHECK(with(tip, {{12, 0.4}, {60, 3}}).empty());
  const Ellipsoid body{Expr::of("size_0"), Expr::of("size_1"), Expr::of("size_2")};
  CHECK(with(body, {{28.4, 1}, {28.3, 0.5}, {27.2, 1}}) == "sphere");
  CHECK(with(body, {{28.4, 0.2}, {28.3, 0.1}, {27.2, 0.2}}).empty());
  CHECK(with(body, {{28.4, 0}, {28.4, 0}, {28.4, 0}}).empty());
}

TEST_CASE("rivals: a round body whose radius may be anything is none") {
  const auto with = [](double radius, double sigma) {
    Candidate c;
    c.shape = Ellipsoid{30, 20, Expr::of("radius_z")};
    Parameter p;
    p.name = "radius_z", p.value = p.fitted = radius, p.sigma = sigma;
    c.parameters = {p};
    return unknown_radius(c);
  };
  CHECK(with(230, 4800) == "its radius 200 +- 4800 mm is not known");
  CHECK(with(230, 40).empty());
}

TEST_CASE("rivals: a plate with a wall that may as well be of no thickness is none") {
  const auto with = [](double edge, double sigma, bool slanted, std::size_t points = 250) {
    Loop outline;
    outline.name = "outline";
    const Expr y = Expr::of("edge_y");
    outline.elements = {SketchPoint{0, 0, ""}, SketchPoint{56, 0, ""}, SketchPoint{56, 36, ""},
                        SketchPoint{30, 36, ""}};
    if (!slanted) outline.elements.push_back(SketchPoint{30, y, ""});
    outline.elements.push_back(SketchPoint{0, y, ""});
    Candidate c;
    c.shape = Extrude{{{outline}}, 32};
    Parameter p;
    p.name = "edge_y", p.value = p.fitted = edge, p.sigma = sigma, p.points = points;
    c.parameters = {p};
    return unknown_wall(c);
  };
  CHECK(with(0.86, 1.1, false) == "a wall of 0.9 +- 1.1 mm may be none");
  CHECK(with(0.86, 0.2, false).empty());
  CHECK(with(0.86, 1.1, true).empty());   // a corner beside another, no wall
  CHECK(with(20, 25, false, 3).empty());  // a side that was not seen
}

TEST_CASE("rivals: a rod with a fin that may as well be of no thickness is none") {
  // The outline of a rod, a fin along its tangent: between two arcs no side has corners at both ends.
  const auto with = [](double thickness) {
    Loop outline;
    outline.name = "outline";
    const Expr y = Expr::of("width");
    outline.elements = {SketchPoint{20, 0, ""}, SketchPoint{20, y, ""}, SketchArc{5, y + 10, 10, -pi / 2, pi / 2, ""},
                        SketchArc{5, 10, 10, pi / 2, 1.5 * pi, ""}};
    Candidate c;
    c.shape = Extrude{{{outline}}, 32};
    Parameter p;
    p.name = "width", p.value = p.fitted = thickness, p.sigma = 0.1, p.points = 250;
    c.parameters = {p};
    return unknown_wall(c);
  };
  CHECK(with(0.03) == "a wall of 0.03 +- 0.1 mm may be none");
  CHECK(with(0.3).empty());
}

TEST_CASE("rivals: those that may be the truth are named however many others there are") {
  std::vector<Rival> all;
  for (int i = 0; i < 20; ++i)
    all.push_back({"extrusion " + std::to_string(i), true, 0.1, 100, "describes the part in 8 nats more"});
  all.push_back({"fillet", false, 0.1, 90, "the data cannot tell: its concave side was hardly seen"});
  const auto named = worth_naming(all);
  REQUIRE(named.size() == 12);
  CHECK(named[10].procedure == "extrusion 10");
  CHECK(named[11].procedure == "fillet");
  // One of each procedure comes before a second of the same.
  all.assign(20, {"cylinder", true, 0.1, 100, "fits as well, takes 0 nats more to describe"});
  all.push_back({"fillet", false, 0.1, 90, "the data cannot tell: its concave side was hardly seen"});
  const auto kinds = worth_naming(all);
  REQUIRE(kinds.size() == 12);
  CHECK(kinds[10].procedure == "cylinder");
  CHECK(kinds[11].procedure == "fillet");
}

TEST_CASE("rivals: a flat body on one bent sheet names the cylinder, on a flat sheet it does not") {
  const auto sheet = [](double radius) {
    FitInput input;
    Random random(5);
    for (int i = 0; i < 3000; ++i) {
      const double x = random.uniform(-10, 10), y = random.uniform(-20, 20), noise = 0.1 * random.normal();
      input.cloud.points.emplace_back(x, y, noise + (radius > 0 ? radius - std::sqrt(radius * radius - x * x) : 0));
      input.cloud.normals.push_back(radius > 0 ? Vec3(-x, 0, std::sqrt(radius * radius - x * x)).normalized()
                                               : Vec3(0, 0, 1));
    }
    input.bounds = input.cloud.bounds();
    return input;
  };
  Candidate box;
  box.shape = Box{20, 40, 10};
  const std::string bent = bent_sheet(box, sheet(40));
  CHECK(bent.find("the data cannot tell it from 2") == 0);
  const auto at = bent.find("cylinder of radius ");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(bent.substr(at + 19)) == Approx(40).margin(1.5));
  CHECK(bent_sheet(box, sheet(0)).empty());
  box.shape = Sphere{20};
  CHECK(bent_sheet(box, sheet(40)).empty());
}

}  // namespace partscribe::testing
