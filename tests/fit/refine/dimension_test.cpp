/// Fitted parts get the sizes of a drawing, and stay what they are.
#include "fit/refine/dimension.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "fit/refine/refine.h"
#include "fit/sketch/length_parameter.h"

using namespace partscribe::fit;

namespace {

Parameter measured(const std::string& name, double value, double sigma, const std::string& note = "") {
  Parameter p = length_parameter(name, value, note);
  p.sigma = p.sigma_noise = sigma, p.points = 100;
  return p;
}

const Parameter& named(const Candidate& c, const std::string& name) {
  const auto found = std::ranges::find(c.parameters, name, &Parameter::name);
  INFO(name);
  REQUIRE(found != c.parameters.end());
  return *found;
}

/// A bar with two round ends about holes.
Candidate bar() {
  const Expr end = Expr::of("end_radius"), far = Expr::of("end_center_x");
  Loop outline{"outline",
               {SketchArc{far, 0, end, -pi / 2, pi / 2, "end", "back"},
                SketchArc{0, 0, end, pi / 2, 3 * pi / 2, "end", "front"}}};
  Loop one{"hole 1", {SketchArc{0, 0, Expr::of("hole_radius"), 2 * pi, 0, "", ""}}};
  Loop two{"hole 2", {SketchArc{far, 0, Expr::of("hole_2_radius"), 2 * pi, 0, "", ""}}};
  Candidate c;
  c.procedure = "extrusion", c.object_name = "plate";
  c.shape = Extrude{{{outline, one, two}}, Expr::of("height")};
  c.parameters = {measured("end_radius", 15, 0.01), measured("end_center_x", 80, 0.01),
                  measured("hole_radius", 8, 0.01, "radius of hole 1"),
                  measured("hole_2_radius", 8.02, 0.01, "radius of hole 2"), measured("height", 12, 0.01)};
  return c;
}

/// A rod with two grooves.
Candidate grooved(double second_radius) {
  const Expr body = Expr::of("body_radius");
  const auto groove = [&](const std::string& number) {
    return SketchArc{Expr::of("groove_center_" + number + "r"),
                     Expr::of("groove_" + number + "z"),
                     Expr::of("groove_" + number + "radius"),
                     -2,
                     2,
                     "groove",
                     "body"};
  };
  Candidate c;
  c.procedure = "surface of revolution", c.object_name = "turned_body";
  Loop loop{
      "profile",
      {SketchPoint{0, 0, "bottom face"}, SketchPoint{body, 0, "body"}, groove(""), groove("2_"),
       SketchPoint{body, Expr::of("total_length"), "top face"}, SketchPoint{0, Expr::of("total_length"), "axis"}}};
  c.shape = Revolve{{{loop}}};
  c.parameters = {measured("body_radius", 8.5, 0.001),
                  measured("groove_radius", 2, 0.005, "radius of the groove"),
                  measured("groove_center_r", 9.5, 0.005),
                  measured("groove_z", 40, 0.005),
                  measured("groove_2_radius", second_radius, 0.005, "radius of the groove"),
                  measured("groove_center_2_r", 7.5 + second_radius, 0.005),
                  measured("groove_2_z", 80, 0.005),
                  measured("total_length", 130, 0.01)};
  return c;
}

}  // namespace

TEST_CASE("dimension: a rod has a diameter, twice as large and twice as uncertain as its radius") {
  Candidate c;
  c.procedure = "cylinder", c.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
  c.parameters = {measured("radius", 6, 0.01, "radius of the cylinder"), measured("height", 20, 0.02)};
  c.held = {{"radius", 0.01}};
  dimension(c);
  const Parameter& d = named(c, "diameter");
  CHECK(d.value == 12.0);
  CHECK(d.sigma == Approx(0.02));
  CHECK(d.note == "diameter of the cylinder");
  CHECK(c.held.front().name == "diameter");
  CHECK(std::get<CylinderOf<double>>(evaluate(c.shape, values_of(c))).radius == 6.0);
}

TEST_CASE("dimension: a bar is told by width, centre distance, hole diameters and thickness") {
  Candidate c = bar();
  const Shape before = c.shape;
  const Values old = values_of(c);
  dimension(c);
  CHECK(named(c, "width").value == 30.0);
  CHECK(named(c, "center_distance").value == 80.0);
  CHECK(named(c, "hole_d").value == 16.0);
  CHECK(named(c, "thickness").value == 12.0);
  CHECK(std::get<ExtrudeOf<double>>(evaluate(c.shape, values_of(c))) ==
        std::get<ExtrudeOf<double>>(evaluate(before, old)));
}

TEST_CASE("related: holes that the data cannot tell apart share their diameter, others keep theirs") {
  Candidate c = bar();
  dimension(c);
  const auto fewer = related(c, 0.05);
  REQUIRE(fewer);
  CHECK(fewer->parameters.size() == c.parameters.size() - 1);
  CHECK(named(*fewer, "hole_d").value == Approx(16.02));
  CHECK(named(*fewer, "hole_d").note == "diameter of the holes");
  for (Parameter& p : c.parameters) p.sigma /= 10;
  CHECK_FALSE(related(c, 0.05));
}

TEST_CASE("related: a groove is told by the diameter at its bottom") {
  Candidate c = grooved(2.4);
  dimension(c);
  const auto apart = related(c, 0.05);
  REQUIRE(apart);
  CHECK(named(*apart, "groove_d").value == Approx(15));
  CHECK(named(*apart, "groove_2_d").value == Approx(15));
  const auto sketch = std::get<RevolveOf<double>>(evaluate(apart->shape, values_of(*apart))).sketch;
  CHECK(std::get<SketchArcOf<double>>(sketch.loops[0].elements[3]).center_x == Approx(9.9));

  Candidate equal = grooved(2.004);
  dimension(equal);
  const auto same = related(equal, 0.05);
  REQUIRE(same);
  CHECK(same->parameters.size() == equal.parameters.size() - 2);
  CHECK(named(*same, "groove_radius").value == Approx(2.002));
}
