/// Small models for tests: one of every shape.
#pragma once

#include <string>
#include <vector>

#include "core/number.h"
#include "model/model.h"
#include "testing/surface_sets.h"

namespace partscribe::testing {

using namespace model;

inline Parameter length(const std::string& name, double value) {
  Parameter p;
  p.name = name;
  p.value = p.fitted = value;
  return p;
}

inline Model model_with(Shape shape, std::vector<Parameter> parameters = {}) {
  Model m;
  m.parameters = std::move(parameters);
  m.objects.push_back({"body", std::move(shape), {}, {}, {}});
  return m;
}

/// Why each of a model's rivals was not taken, a line each.
inline std::string reasons(const Model& model) {
  std::string text;
  for (const auto& rival : model.rivals) text += rival.procedure + ": " + rival.reason + "\n";
  return text;
}

inline Loop polygon(const std::vector<std::pair<Expr, Expr>>& corners) {
  Loop loop;
  for (const auto& [x, y] : corners) loop.elements.push_back(SketchPoint{x, y, ""});
  return loop;
}

/// A turned pin with a rounded head: radii and lengths are parameters, the round hangs on two of them.
inline Model pin() {
  const auto p = [](const char* name) { return Expr::of(name); };
  Loop loop;
  loop.name = "profile";
  loop.elements = {SketchPoint{0, 0, "bottom"},
                   SketchArc{p("head_radius") - p("round_radius"), p("round_radius"), p("round_radius"), -pi / 2, 0,
                             "round", "head"},
                   SketchPoint{p("head_radius"), p("head_height"), "shoulder"},
                   SketchPoint{p("shank_radius"), p("head_height"), "shank"},
                   SketchPoint{p("shank_radius"), p("total_length"), "top"},
                   SketchPoint{0, p("total_length"), "axis"}};
  return model_with(Revolve{{{loop}}},
                    {length("head_radius", 20), length("round_radius", 10), length("head_height", 15),
                     length("shank_radius", 9), length("total_length", 65)});
}

/// A plate with round ends and a hole.
inline Model link() {
  const auto p = [](const char* name) { return Expr::of(name); };
  Loop outline;
  outline.name = "outline";
  outline.elements = {SketchArc{p("spacing"), 0, p("end_radius"), -pi / 2, pi / 2, "right end", ""},
                      SketchArc{0, 0, p("end_radius"), pi / 2, 3 * pi / 2, "left end", ""}};
  Loop hole;
  hole.name = "hole";
  hole.elements = {SketchArc{0, 0, p("hole_radius"), 2 * pi, 0, "hole", ""}};
  return model_with(Extrude{Sketch{{outline, hole}, {{"equal", "left end", "right end"}}}, p("height")},
                    {length("spacing", 40), length("end_radius", 12), length("hole_radius", 5), length("height", 8)});
}

inline std::vector<Model> one_of_each() {
  Model cut;
  cut.parameters = {length("size", 20), length("bore_radius", 4)};
  cut.objects = {{"block", Box{Expr::of("size"), Expr::of("size"), Expr::of("size")}, {}, {}, {}},
                 {"drill",
                  Cylinder{Expr::of("bore_radius"), Expr::of("size") + Expr(2)},
                  {Expr::of("size") / Expr(2), 10, -1, 0, 0, 0},
                  {},
                  {}},
                 {"drilled_block", Difference{{"block", "drill"}}, {}, {}, {}}};
  std::vector<HalfSpace> tetrahedron = {{-1, 0, 0, 0, "left"}, {0, -1, 0, 0, "front"}, {0, 0, -1, 0, "bottom"}};
  const double s = 1 / std::sqrt(3.0);
  tetrahedron.push_back({s, s, s, 10, "slope"});
  SketchNurbs bulge;
  bulge.knots = {0, 0, 0, 0, 1, 1, 1, 1};
  bulge.control = {{{10, 0}}, {{16, 8}}, {{4, 16}}, {{10, 24}}};
  Loop vase;
  vase.elements = {SketchPoint{0, 0, ""}, bulge, SketchPoint{0, 24, ""}};
  const auto repeated = [](Shape pattern) {
    Model m = model_with(Hole{6, 10, false, 2.0, 11, 4}, {});
    m.objects[0].name = "hole";
    m.objects[0].frame = {12, 3, 0, 0, 0, 0};
    m.objects.push_back({"holes", std::move(pattern), {}, {}, {}});
    return m;
  };
  const auto worked = [](Shape shape) {
    Model m = model_with(Box{20, 14, 8});
    m.objects.push_back({"worked", std::move(shape), {}, {}, {}});
    return m;
  };
  Loop pad = polygon({{0, 0}, {20, 0}, {20, 12}, {5, 12}});
  pad.name = "pad";
  // Two of its corners are rounded, two are mitred.
  const Loop lid{"lid",
                 {SketchPoint{0, 0, "front"}, SketchArc{24, 4, 4, -pi / 2, 0, "round", "right"},
                  SketchPoint{28, 16, "back"}, SketchArc{4, 12, 4, pi / 2, pi, "round 2", "left"}}};
  const Loop bore{"bore", {SketchArc{12, 8, 3, 2 * pi, 0, "bore", ""}}};
  return {model_with(Box{30, 20, 10}),
          model_with(Wedge{30, 20, 10, 12}),
          model_with(Wedge{30, 20, 10, 0}),
          model_with(Cylinder{8, 25}),
          model_with(Cone{12, 5, 20}),
          model_with(Cone{12, 0, 20}),
          model_with(Sphere{Expr::of("radius")}, {length("radius", 11)}),
          model_with(Ellipsoid{20, 12, 8}),
          model_with(Torus{20, 6}),
          model_with(Superellipsoid{15, 12, 20, 0.5, 0.8, 0.2, -0.1}),
          model_with(Superellipsoid{7, 9, 24, 0.5, 0.8, 0.2, -0.1, 1.1}),
          model_with(Supertoroid{20, 6, 5, 0.6, 0.7}),
          model_with(Fillet{12, 8, 25}),
          model_with(Fillet{9, 9, 25}),
          model_with(HalfSpaces{tetrahedron}),
          model_with(Revolve{{{vase}}}),
          model_with(TriSurface{
              {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, true, 0}),
          model_with(cowl()),
          model_with(cushion()),
          pin(),
          link(),
          model_with(Revolve{{{polygon({{6, 0}, {14, 0}, {14, 9}, {8, 9}})}}, 2.0}),
          model_with(Extrude{{{pad}}, 6, 2}),
          model_with(Extrude{{{lid, bore}}, 9, 2, 0.2}),
          model_with(Extrude{{{pad}}, 6, 2, -0.3}),
          model_with(Hole{8, 20}),
          model_with(Hole{8, 20, true, 0, 0, 0, 14, 1.4}),
          model_with(Hole{8, 20, true, 0, 14, 5, 11, pi / 2}),
          model_with(Slot{30, 8, 6, false}),
          model_with(Pocket{{{pad}}, 6}),
          model_with(Boss{{{pad}}, 9, 2}),
          model_with(Pocket{{{lid, bore}}, 7, false, 1, 0.1}),
          model_with(Boss{{{lid, bore}}, 9, 2, 0.1}),
          model_with(wave()),
          repeated(LinearPattern{"hole", 3, 10, 4, 0}),
          repeated(CircularPattern{"hole", 5, 2 * pi / 5}),
          repeated(Mirror{"hole", "y", -5, true}),
          worked(EdgeFillet{"body", "body top", "body right", 3}),
          worked(EdgeChamfer{"body", "body front", "body left", 3, 2}),
          cut};
}

}  // namespace partscribe::testing
