#include "testing/golden_models.h"

#include <cmath>

#include "core/number.h"
#include "testing/surface_sets.h"

namespace partscribe::testing {
namespace {

Expr p(const char* name) { return Expr::of(name); }
Expr deg(double angle) { return radians(angle); }

Model model(const std::string& name, const std::string& object, const std::string& note) {
  Model m;
  m.name = name;
  m.tolerance = 0.1;
  m.provenance.sources = {{name + ".ply", std::string(64, '0')}};
  m.provenance.points = 21300;
  m.provenance.version = "0.1.0";
  m.objects.reserve(8);
  Object part;
  part.name = object;
  part.note = note;
  m.objects.push_back(part);
  return m;
}

void length(Model& m, const std::string& name, double value, double fitted, double sigma, const std::string& note) {
  Parameter q;
  q.name = name;
  q.value = value;
  q.fitted = fitted;
  q.sigma = sigma;
  q.sigma_noise = sigma / 2;
  q.sigma_systematic = sigma * std::sqrt(0.75);
  q.points = 4120;
  q.note = note;
  if (value != fitted) {
    q.nominal = NominalEvidence{value, sigma > 0 ? (value - fitted) / sigma : 0, true, "0.5 mm grid"};
  }
  m.parameters.push_back(q);
}

void angle(Model& m, const std::string& name, double value_deg, const std::string& note) {
  Parameter q;
  q.name = name;
  q.quantity = Quantity::angle;
  q.value = radians(value_deg);
  q.fitted = radians(value_deg + 0.013);
  q.sigma = radians(0.02);
  q.points = 1200;
  q.note = note;
  m.parameters.push_back(q);
}

/// Puts an object before the part.
Object& step(Model& m, const std::string& name, Shape shape, const std::string& note) {
  Object o;
  o.name = name;
  o.shape = std::move(shape);
  o.note = note;
  o.evidence = {3100, 0.021, 0.043, 0.87, 3};
  return *m.objects.insert(m.objects.end() - 1, o);
}

void finish(Model& m, Shape shape) {
  m.objects.back().shape = std::move(shape);
  m.objects.back().evidence = {21250, 0.024, 0.051, 0.93, 6};
}

/// A model that stands somewhere else in the scan.
void place(Model& m) { m.scan_from_part = {12.5, -3.25, 40, deg(30), deg(-20), deg(75)}; }

Model sphere() {
  Model m = model("sphere", "ball", "a ball");
  length(m, "radius", 25, 24.9962, 0.0021, "radius of the ball");
  finish(m, Sphere{p("radius")});
  m.scan_from_part = {10, 20, -5, 0, 0, 0};
  return m;
}

Model box() {
  Model m = model("box", "block", "a rectangular block");
  length(m, "width", 60, 60.012, 0.008, "size along x");
  length(m, "depth", 40, 39.991, 0.007, "size along y");
  length(m, "height", 25.3, 25.3, 0.006, "size along z");
  finish(m, Box{p("width"), p("depth"), p("height")});
  place(m);
  return m;
}

Model wedge() {
  Model m = model("wedge", "ramp", "a block with one sloped face");
  length(m, "length", 50, 50.004, 0.009, "size along x at the foot");
  length(m, "depth", 30, 30.002, 0.009, "size along y");
  length(m, "height", 20, 19.997, 0.009, "size along z");
  length(m, "top_length", 15, 15.011, 0.012, "size along x at the far side");
  finish(m, Wedge{p("length"), p("depth"), p("height"), p("top_length")});
  place(m);
  return m;
}

Model cylinder() {
  Model m = model("cylinder", "bar", "a round bar");
  length(m, "radius", 12, 11.9987, 0.0014, "radius of the bar");
  length(m, "length", 80, 80.021, 0.015, "length of the bar");
  finish(m, Cylinder{p("radius"), p("length")});
  place(m);
  return m;
}

Model cone() {
  Model m = model("cone", "frustum", "a frustum");
  length(m, "foot_radius", 20, 20.003, 0.004, "radius at the foot");
  length(m, "tip_radius", 5, 4.998, 0.005, "radius at the tip");
  length(m, "height", 35, 35.006, 0.01, "height of the frustum");
  finish(m, Cone{p("foot_radius"), p("tip_radius"), p("height")});
  m.objects.back().frame.rx = deg(90);
  return m;
}

Model torus() {
  Model m = model("torus", "ring", "a ring");
  length(m, "ring_radius", 30, 30.001, 0.003, "radius of the centre circle");
  length(m, "tube_radius", 8, 7.9991, 0.002, "radius of the tube");
  finish(m, Torus{p("ring_radius"), p("tube_radius")});
  place(m);
  return m;
}

Model ellipsoid() {
  Model m = model("ellipsoid", "egg", "an egg with three axes");
  length(m, "half_length", 30, 30.01, 0.006, "half axis along x");
  length(m, "half_width", 20, 20.01, 0.006, "half axis along y");
  length(m, "half_height", 12, 12.01, 0.006, "half axis along z");
  finish(m, Ellipsoid{p("half_length"), p("half_width"), p("half_height")});
  place(m);
  return m;
}

Model superellipsoid() {
  Model m = model("superellipsoid", "soap", "a rounded, tapered block");
  length(m, "half_length", 30, 30.01, 0.006, "half size along x");
  length(m, "half_width", 20, 20.01, 0.006, "half size along y");
  length(m, "half_height", 15, 15.01, 0.006, "half size along z");
  Parameter e;
  e.quantity = Quantity::ratio;
  e.name = "squareness";
  e.value = e.fitted = 0.4;
  e.sigma = 0.003;
  e.points = 9000;
  e.note = "0: square edges, 1: round";
  m.parameters.push_back(e);
  finish(m, Superellipsoid{p("half_length"), p("half_width"), p("half_height"), p("squareness"), 0.7, -0.2, 0.15});
  place(m);
  return m;
}

Model supertoroid() {
  Model m = model("supertoroid", "gasket", "a rounded square ring");
  length(m, "ring_radius", 30, 30.004, 0.005, "radius of the ring's centre line");
  length(m, "tube_half_width", 8, 7.997, 0.005, "half width of the tube");
  length(m, "tube_half_height", 5, 5.002, 0.005, "half height of the tube");
  Parameter e;
  e.quantity = Quantity::ratio;
  e.name = "squareness";
  e.value = e.fitted = 0.6;
  e.sigma = 0.003;
  e.points = 9000;
  e.note = "of the ring: 0.1 square, 1 round";
  m.parameters.push_back(e);
  finish(m, Supertoroid{p("ring_radius"), p("tube_half_width"), p("tube_half_height"), 0.8, p("squareness")});
  place(m);
  return m;
}

Model fillet() {
  Model m = model("fillet", "fillet_strip", "what rounds an inner corner");
  length(m, "width", 14, 14.003, 0.005, "first leg");
  length(m, "height", 10, 9.998, 0.005, "second leg");
  length(m, "length", 50, 50.01, 0.006, "length of the strip");
  finish(m, Fillet{p("width"), p("height"), p("length")});
  place(m);
  return m;
}

Model half_spaces() {
  Model m = model("half_spaces", "cut_block", "a block with a cut corner");
  length(m, "half_width", 20, 20.003, 0.004, "distance of the sides from the middle");
  length(m, "height", 30, 29.995, 0.006, "distance of the top from the bottom");
  length(m, "corner_distance", 32.5, 32.4988, 0.008, "distance of the cut corner from the origin");
  const double a = 2.0 / 3, b = 1.0 / 3;
  finish(m, HalfSpaces{{{1, 0, 0, p("half_width"), "right"},
                        {-1, 0, 0, p("half_width"), "left"},
                        {0, 1, 0, p("half_width"), "back"},
                        {0, -1, 0, p("half_width"), "front"},
                        {0, 0, 1, p("height"), "top"},
                        {0, 0, -1, 0, "bottom"},
                        {a, b, a, p("corner_distance"), "cut corner"}}});
  place(m);
  return m;
}

Model pin() {
  Model m = model("pin", "pin", "a headed pin, turned");
  length(m, "shank_radius", 9, 8.9987, 0.0004, "radius of the shank");
  length(m, "shank_length", 60, 60.004, 0.006, "length of the shank below the head");
  length(m, "head_radius", 15, 14.9931, 0.0012, "radius of the head");
  length(m, "head_height", 10, 10.002, 0.004, "height of the head");
  length(m, "fillet_radius", 2, 1.994, 0.009, "radius of the rounded upper edge of the head");
  length(m, "chamfer", 1.5, 1.48, 0.015, "size of the bevel at the foot of the shank");
  const Expr top = p("shank_length") + p("head_height");
  Loop outline{"profile",
               {SketchPoint{0, 0, "foot"}, SketchPoint{p("shank_radius") - p("chamfer"), 0, "bevel"},
                SketchPoint{p("shank_radius"), p("chamfer"), "shank"},
                SketchPoint{p("shank_radius"), p("shank_length"), "shoulder"},
                SketchPoint{p("head_radius"), p("shank_length"), "head"},
                SketchArc{p("head_radius") - p("fillet_radius"), top - p("fillet_radius"), p("fillet_radius"), 0,
                          deg(90), "fillet", "top"},
                SketchPoint{0, top, "axis"}}};
  finish(m, Revolve{Sketch{{outline}}});
  place(m);
  return m;
}

Model tie_bar() {
  Model m = model("tie_bar", "tie_bar", "a link with two eyes");
  length(m, "eye_distance", 80, 80.008, 0.004, "distance between the axes of the eyes");
  length(m, "end_radius", 15, 14.997, 0.003, "radius of the rounded ends");
  length(m, "bore_radius", 8, 8.0021, 0.0011, "radius of both bores");
  length(m, "thickness", 12, 12.003, 0.005, "thickness of the bar");
  Loop outline{"outline",
               {SketchArc{0, 0, p("end_radius"), deg(90), deg(270), "left end", "front"},
                SketchArc{p("eye_distance"), 0, p("end_radius"), deg(-90), deg(90), "right end", "back"}}};
  Loop left{"left bore", {SketchArc{0, 0, p("bore_radius"), deg(360), 0, "left bore", ""}}};
  Loop right{"right bore", {SketchArc{p("eye_distance"), 0, p("bore_radius"), deg(360), 0, "right bore", ""}}};
  finish(m, Extrude{Sketch{{outline, left, right}}, p("thickness")});
  place(m);
  return m;
}

Model tri_surface() {
  Model m = model("tri_surface", "octahedron", "an octahedron");
  m.fallback = true;
  TriSurface s;
  s.vertices = {{10, 0, 0}, {-10, 0, 0}, {0, 12, 0}, {0, -12, 0}, {0, 0, 14.5}, {0, 0, -9.25}};
  s.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  finish(m, s);
  return m;
}

/// A ring whose triangles say what surfaces they stand for.
Model washer() {
  Model m = model("washer", "washer", "a ring of four faces");
  m.fallback = true;
  TriSurface s;
  const int sides = 72;
  const double outer = 12, inner = 6.5, height = 8;
  const auto rounded = [](double v) { return snapped(v, 1e-7); };
  for (int i = 0; i < sides; ++i)
    for (const double radius : {outer, inner})
      for (const double z : {0.0, height})
        s.vertices.push_back(
            {rounded(radius * std::cos(2 * pi * i / sides)), rounded(radius * std::sin(2 * pi * i / sides)), z});
  const auto corner = [&](int side, int ring, int top) {
    return static_cast<std::uint32_t>(4 * (side % sides) + 2 * ring + top);
  };
  const auto quads = [&](const TriFace& face, auto&& corners) {
    for (int i = 0; i < sides; ++i) {
      const std::array<std::uint32_t, 4> q = corners(i);
      s.triangles.push_back({q[0], q[1], q[2]});
      s.triangles.push_back({q[0], q[2], q[3]});
    }
    s.faces.push_back(face);
  };
  const int all = 2 * sides;
  quads({"top", "plane", all, false, {0, 0, height}, {0, 0, 1}, {}}, [&](int i) -> std::array<std::uint32_t, 4> {
    return {corner(i, 0, 1), corner(i + 1, 0, 1), corner(i + 1, 1, 1), corner(i, 1, 1)};
  });
  quads({"bottom", "plane", all, false, {0, 0, 0}, {0, 0, -1}, {}}, [&](int i) -> std::array<std::uint32_t, 4> {
    return {corner(i, 1, 0), corner(i + 1, 1, 0), corner(i + 1, 0, 0), corner(i, 0, 0)};
  });
  quads({"rim", "cylinder", all, false, {0, 0, 4}, {0, 0, 1}, {outer}}, [&](int i) -> std::array<std::uint32_t, 4> {
    return {corner(i, 0, 0), corner(i + 1, 0, 0), corner(i + 1, 0, 1), corner(i, 0, 1)};
  });
  quads({"bore", "cylinder", all, true, {0, 0, 4}, {0, 0, 1}, {inner}}, [&](int i) -> std::array<std::uint32_t, 4> {
    return {corner(i, 1, 1), corner(i + 1, 1, 1), corner(i + 1, 1, 0), corner(i, 1, 0)};
  });
  finish(m, s);
  return m;
}

Model cowl_part() {
  Model m = model("cowl", "cowl", "a cowl with a hole");
  m.fallback = true;
  m.tolerance = 0.5;
  length(m, "sheet_thickness", 2, 2, 0, "of the solid made from the sheet");
  SurfaceSet s = cowl();
  s.thickness = p("sheet_thickness");
  finish(m, s);
  return m;
}

Model cushion_part() {
  Model m = model("cushion", "cushion", "a body of six surfaces");
  m.fallback = true;
  m.tolerance = 0.5;
  finish(m, cushion());
  return m;
}

Model sheet() {
  Model m = model("sheet", "bent_sheet", "a bent sheet");
  m.fallback = true;
  length(m, "sheet_thickness", 2, 2, 0, "of the solid made from the sheet");
  TriSurface s;
  s.closed = false;
  s.thickness = p("sheet_thickness");
  const int columns = 5, rows = 3;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i)
      s.vertices.push_back({10.0 * i, 12.0 * j, 0.25 * (i - 2) * (i - 2) * 4 + 0.5 * j});
  }
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const std::uint32_t a = static_cast<std::uint32_t>(j * columns + i), b = a + 1, c = a + columns, d = c + 1;
      s.triangles.push_back({a, b, d});
      s.triangles.push_back({a, d, c});
    }
  }
  finish(m, s);
  return m;
}

Model nurbs_vase() {
  Model m = model("nurbs_vase", "vase", "a turned vase with a free wall");
  length(m, "foot_radius", 20, 20.002, 0.004, "radius of the foot");
  length(m, "height", 70, 70.01, 0.008, "height of the vase");
  SketchNurbs wall;
  wall.degree = 3;
  wall.knots = {0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1};
  wall.weights = {1, 1, 1.2, 0.9, 1, 1};
  wall.control = {{p("foot_radius"), 0}, {31.5, 12}, {27.25, 30}, {9.5, 44}, {12.75, 60}, {17, p("height")}};
  wall.name = "wall";
  wall.edge = "rim";
  finish(m, Revolve{Sketch{{Loop{"profile", {SketchPoint{0, 0, "foot"}, wall, SketchPoint{0, p("height"), "axis"}}}}}});
  place(m);
  return m;
}

Model bracket() {
  Model m = model("bracket", "bracket", "an angle bracket with bores");
  length(m, "width", 40, 40.004, 0.006, "width of both plates");
  length(m, "length", 60, 60.011, 0.008, "length of the foot");
  length(m, "height", 50, 49.996, 0.007, "height of the wall");
  length(m, "thickness", 8, 8.002, 0.004, "thickness of both plates");
  length(m, "bore_radius", 4.5, 4.4987, 0.0015, "radius of the bores in the foot");
  length(m, "bore_distance", 22, 22.003, 0.003, "distance between the bores in the foot");
  length(m, "eye_radius", 9, 9.0032, 0.0021, "radius of the eye in the wall");
  length(m, "overshoot", 1, 1, 0, "by which a cut reaches out of the part");
  step(m, "foot", Box{p("length"), p("width"), p("thickness")}, "the plate that lies");
  step(m, "wall", Box{p("thickness"), p("width"), p("height")}, "the plate that stands");
  step(m, "body", Union{{"foot", "wall"}}, "both plates");
  const Expr through = p("thickness") + 2 * p("overshoot");
  step(m, "bore_1", Cylinder{p("bore_radius"), through}, "front bore in the foot").frame = {
      p("length") * 2 / 3, (p("width") - p("bore_distance")) / 2, -p("overshoot"), 0, 0, 0};
  step(m, "bore_2", Cylinder{p("bore_radius"), through}, "back bore in the foot").frame = {
      p("length") * 2 / 3, (p("width") + p("bore_distance")) / 2, -p("overshoot"), 0, 0, 0};
  step(m, "eye", Cylinder{p("eye_radius"), through}, "eye in the wall").frame = {
      -p("overshoot"), p("width") / 2, p("height") * 0.6, 0, deg(90), 0};
  finish(m, Difference{{"body", "bore_1", "bore_2", "eye"}});
  place(m);
  return m;
}

Model lens() {
  Model m = model("lens", "lens", "what two balls have in common, cut by a slanted groove");
  m.tolerance = 0.5;
  length(m, "front_radius", 40, 40.01, 0.01, "radius of the front");
  length(m, "back_radius", 55, 55.02, 0.02, "radius of the back");
  length(m, "center_thickness", 10, 10.001, 0.004, "thickness in the middle");
  angle(m, "tilt", 7.5, "of the groove");
  step(m, "front", Sphere{p("front_radius")}, "front ball").frame.z = p("center_thickness") - p("front_radius");
  step(m, "back", Sphere{p("back_radius")}, "back ball").frame.z = p("back_radius");
  step(m, "blank", Intersection{{"front", "back"}}, "what both balls share");
  step(m, "groove", Box{60, 2, 4}, "slanted groove").frame = {-30, -1, p("center_thickness") - 2, 0, 0, 2 * p("tilt")};
  finish(m, Difference{{"blank", "groove"}});
  return m;
}

void count(Model& m, const std::string& name, double value, const std::string& note) {
  Parameter q;
  q.name = name;
  q.quantity = Quantity::count;
  q.value = q.fitted = value;
  q.note = note;
  m.parameters.push_back(q);
}

/// A parameter that follows from earlier ones.
void formula(Model& m, const std::string& name, const Expr& e, const std::string& note,
             Quantity quantity = Quantity::length) {
  Parameter q;
  q.name = name;
  q.quantity = quantity;
  q.formula = e;
  q.note = note;
  m.parameters.push_back(q);
}

Loop rectangle(const std::string& name, const Expr& half_x, const Expr& half_y, bool backwards = false) {
  Loop loop{name,
            {SketchPoint{-half_x, -half_y, "front"}, SketchPoint{half_x, -half_y, "right"},
             SketchPoint{half_x, half_y, "back"}, SketchPoint{-half_x, half_y, "left"}}};
  if (!backwards) return loop;
  return {name,
          {SketchPoint{-half_x, -half_y, "left"}, SketchPoint{-half_x, half_y, "back"},
           SketchPoint{half_x, half_y, "right"}, SketchPoint{half_x, -half_y, "front"}}};
}

Model drilled_plate() {
  Model m = model("drilled_plate", "plate", "a plate with a bore and a grid of counterbored holes");
  length(m, "length", 120, 120.02, 0.01, "size along x");
  length(m, "width", 80, 79.99, 0.01, "size along y");
  length(m, "thickness", 20, 20.004, 0.005, "size along z");
  length(m, "bore_d", 40, 40.006, 0.004, "diameter of the bore in the middle");
  length(m, "hole_d", 9, 8.997, 0.003, "diameter of the holes");
  length(m, "head_d", 15, 15.003, 0.004, "diameter of the counterbores");
  length(m, "head_depth", 8.6, 8.6, 0.004, "depth of the counterbores");
  length(m, "pitch_x", 90, 90.004, 0.003, "distance of the holes along x");
  length(m, "pitch_y", 50, 49.998, 0.003, "distance of the holes along y");
  step(m, "slab", Box{p("length"), p("width"), p("thickness")}, "the plate").frame = {
      -p("length") / 2, -p("width") / 2, 0, 0, 0, 0};
  step(m, "bore", Hole{p("bore_d"), p("thickness")}, "bore in the middle").frame.z = p("thickness");
  step(m, "hole", Hole{p("hole_d"), p("thickness"), true, 0, p("head_d"), p("head_depth")}, "hole for a screw")
      .frame = {-p("pitch_x") / 2, -p("pitch_y") / 2, p("thickness"), 0, 0, 0};
  step(m, "row", LinearPattern{"hole", 2, p("pitch_x"), 0, 0}, "holes along x");
  step(m, "holes", LinearPattern{"row", 2, 0, p("pitch_y"), 0}, "all four holes");
  finish(m, Difference{{"slab", "bore", "holes"}});
  place(m);
  return m;
}

Model flange() {
  Model m = model("flange", "flange", "a flange with a hub and a circle of countersunk holes");
  length(m, "flange_d", 100, 100.01, 0.006, "diameter of the flange");
  length(m, "thickness", 12, 12.003, 0.005, "thickness of the flange");
  length(m, "hub_d", 50, 49.996, 0.006, "diameter of the hub");
  length(m, "hub_height", 18, 18.002, 0.007, "how far the hub stands out");
  length(m, "bore_d", 30, 30.002, 0.003, "diameter of the bore");
  length(m, "bolt_circle_d", 76, 76.005, 0.004, "diameter of the bolt circle");
  length(m, "bolt_d", 6.6, 6.598, 0.002, "diameter of the bolt holes");
  length(m, "sink_d", 13, 13.004, 0.004, "diameter of the countersinks");
  count(m, "bolts", 6, "number of bolt holes");
  formula(m, "bolt_circle_r", p("bolt_circle_d") / 2, "radius of the bolt circle");
  formula(m, "bolt_step", 2 * Expr(pi) / p("bolts"), "from each bolt hole to the next", Quantity::angle);
  step(m, "disc", Cylinder{p("flange_d") / 2, p("thickness")}, "the flange");
  step(m, "hub",
       Boss{Sketch{{Loop{"hub", {SketchArc{0, 0, p("hub_d") / 2, 0, deg(360), "hub", ""}}}}}, p("hub_height"), 2},
       "the hub")
      .frame.z = p("thickness");
  step(m, "body", Union{{"disc", "hub"}}, "flange and hub");
  step(m, "bore", Hole{p("bore_d"), p("thickness") + p("hub_height")}, "bore for the shaft").frame.z =
      p("thickness") + p("hub_height");
  step(m, "bolt_hole", Hole{p("bolt_d"), p("thickness"), true, 0, 0, 0, p("sink_d")}, "bolt hole").frame = {
      p("bolt_circle_r"), 0, p("thickness"), 0, 0, 0};
  step(m, "bolt_holes", CircularPattern{"bolt_hole", p("bolts"), p("bolt_step")}, "all bolt holes");
  finish(m, Difference{{"body", "bore", "bolt_holes"}});
  place(m);
  return m;
}

Model tray() {
  Model m = model("tray", "tray", "a block with a pocket around an island, two lugs, slots and a blind hole");
  length(m, "length", 90, 90.01, 0.01, "size along x");
  length(m, "width", 60, 60.01, 0.01, "size along y");
  length(m, "height", 20, 20.002, 0.006, "size along z");
  length(m, "wall", 6, 6.004, 0.004, "thickness of the wall");
  length(m, "depth", 12, 12.003, 0.004, "depth of the pocket");
  length(m, "island_d", 24, 23.996, 0.005, "diameter of the island");
  length(m, "drill_d", 10, 10.002, 0.004, "diameter of the blind hole");
  length(m, "slot_length", 14, 14.003, 0.005, "length of the slots");
  length(m, "slot_width", 6, 6.002, 0.004, "width of the slots");
  const Expr half_x = p("length") / 2, half_y = p("width") / 2;
  step(m, "block", Extrude{Sketch{{rectangle("block", half_x, half_y)}}, p("height")}, "the block");
  step(m, "pocket",
       Pocket{Sketch{{rectangle("wall", half_x - p("wall"), half_y - p("wall")),
                      Loop{"island", {SketchArc{0, 0, p("island_d") / 2, deg(360), 0, "island", ""}}}}},
              p("depth")},
       "the pocket")
      .frame.z = p("height");
  step(m, "drill", Hole{p("drill_d"), 9, false, deg(118)}, "blind hole in the island").frame.z = p("height");
  Loop corner{"lug",
              {SketchPoint{half_x - 2, -10, "front"}, SketchArc{half_x + 10, 0, 10, deg(-90), deg(90), "end", "back"},
               SketchPoint{half_x - 2, 10, ""}}};
  step(m, "lug", Extrude{Sketch{{corner}}, 8}, "lug on the right");
  step(m, "lugs", Mirror{"lug", "x", 0, true}, "both lugs");
  step(m, "slot", Slot{p("slot_length"), p("slot_width"), 8}, "slot in the right lug").frame = {half_x + 10, 0, 8, 0, 0,
                                                                                                deg(90)};
  step(m, "slots", Mirror{"slot", "x", 0, true}, "both slots");
  step(m, "body", Union{{"block", "lugs"}}, "block and lugs");
  finish(m, Difference{{"body", "pocket", "drill", "slots"}});
  place(m);
  return m;
}

Model clamp() {
  Model m =
      model("clamp", "clamp", "an angle with a filled inner edge, a rounded and a chamfered outer one, and a bore");
  length(m, "length", 50, 50.01, 0.008, "length of the foot");
  length(m, "width", 30, 29.994, 0.006, "width of foot and wall");
  length(m, "height", 36, 36.004, 0.007, "height of the wall");
  length(m, "thickness", 9, 9.003, 0.004, "thickness of foot and wall");
  length(m, "inner_r", 6, 6.004, 0.01, "radius of the inner edge");
  length(m, "outer_r", 5, 4.996, 0.01, "radius of the wall's upper edge");
  length(m, "chamfer", 1.5, 1.503, 0.01, "legs of the chamfers");
  length(m, "bore_d", 11, 11.003, 0.004, "diameter of the bore");
  step(m, "foot", Box{p("length"), p("width"), p("thickness")}, "the foot");
  step(m, "wall", Box{p("thickness"), p("width"), p("height")}, "the wall");
  step(m, "angle", Union{{"foot", "wall"}}, "foot and wall");
  step(m, "inner_edge", EdgeFillet{"angle", "foot top", "wall right", p("inner_r")}, "with the inner edge filled");
  step(m, "outer_edge", EdgeFillet{"inner_edge", "wall top", "wall left", p("outer_r")}, "with the upper edge rounded");
  step(m, "front_edge", EdgeChamfer{"outer_edge", "foot top", "foot right", p("chamfer"), p("chamfer")},
       "with the front edge chamfered");
  step(m, "bore", Hole{p("bore_d"), p("thickness")}, "the bore").frame = {
      (p("length") + p("thickness") + p("inner_r")) / 2, p("width") / 2, p("thickness"), 0, 0, 0};
  step(m, "drilled", Difference{{"front_edge", "bore"}}, "with the bore");
  finish(m, EdgeChamfer{"drilled", "foot top", "bore wall", p("chamfer"), p("chamfer")});
  place(m);
  return m;
}

Model elbow() {
  Model m = model("elbow", "elbow", "a quarter of a tube between two flats");
  length(m, "bend_radius", 40, 40.01, 0.008, "radius of the tube's centre line");
  length(m, "outer_d", 24, 24.003, 0.004, "diameter of the tube");
  length(m, "inner_d", 18, 17.998, 0.004, "diameter of the bore");
  angle(m, "bend", 75, "how far the tube turns");
  finish(m, Revolve{
                Sketch{{Loop{"outside", {SketchArc{p("bend_radius"), 0, p("outer_d") / 2, 0, deg(360), "outside", ""}}},
                        Loop{"bore", {SketchArc{p("bend_radius"), 0, p("inner_d") / 2, deg(360), 0, "bore", ""}}}}},
                p("bend")});
  place(m);
  return m;
}

/// A rectangle about the origin whose corners are rounded about (x, y) and its images.
Loop rounded(const std::string& name, const Expr& x, const Expr& y, const Expr& radius) {
  return {name,
          {SketchArc{-x, -y, radius, deg(180), deg(270), "corner 1", "front"},
           SketchArc{x, -y, radius, deg(270), deg(360), "corner 2", "right"},
           SketchArc{x, y, radius, 0, deg(90), "corner 3", "back"},
           SketchArc{-x, y, radius, deg(90), deg(180), "corner 4", "left"}}};
}

Model cover() {
  Model m = model("cover", "cover", "a moulded cover with leaning walls, a dome for a screw and its hole");
  length(m, "length", 80, 80.01, 0.01, "size along x at the foot");
  length(m, "width", 50, 49.995, 0.01, "size along y at the foot");
  length(m, "height", 18, 18.002, 0.006, "size along z");
  length(m, "corner_r", 9, 9.004, 0.006, "radius of the corners at the foot");
  length(m, "wall", 3, 3.003, 0.004, "thickness of the wall at the foot");
  length(m, "floor", 2.5, 2.502, 0.004, "thickness under the top");
  length(m, "dome_d", 22, 22.006, 0.005, "diameter of the dome where it stands on the top");
  length(m, "hole_d", 6.4, 6.402, 0.003, "diameter of the hole");
  angle(m, "draft", 4, "by which the walls lean");
  const Expr x = p("length") / 2 - p("corner_r"), y = p("width") / 2 - p("corner_r");
  step(m, "outside", Extrude{Sketch{{rounded("outside", x, y, p("corner_r"))}}, p("height"), 0, p("draft")},
       "the outside");
  step(m, "dome",
       Boss{Sketch{{Loop{"dome", {SketchArc{0, 0, p("dome_d") / 2, 0, deg(360), "dome", ""}}}}}, 7, 2, 2 * p("draft")},
       "dome for the screw")
      .frame.z = p("height");
  step(m, "body", Union{{"outside", "dome"}}, "outside and dome");
  step(m, "inside",
       Pocket{Sketch{{rounded("inside", x, y, p("corner_r") - p("wall")),
                      Loop{"post", {SketchArc{-25, 0, 5, deg(360), 0, "post", ""}}}}},
              p("height") - p("floor"), false, 1, p("draft")},
       "the inside, around a post")
      .frame.rx = deg(180);
  step(m, "hole", Hole{p("hole_d"), p("floor") + 7}, "hole for the screw").frame.z = p("height") + 7;
  finish(m, Difference{{"body", "inside", "hole"}});
  place(m);
  return m;
}

Model handle() {
  Model m = model("handle", "handle", "a rounded, bent handle");
  length(m, "half_width", 8, 8.004, 0.005, "half size along x");
  length(m, "half_depth", 11, 10.997, 0.005, "half size along y");
  length(m, "half_length", 40, 40.01, 0.008, "half size along z, before it is bent");
  angle(m, "bend", 55, "by which the axis turns from the middle to each end");
  finish(m, Superellipsoid{p("half_width"), p("half_depth"), p("half_length"), 0.6, 0.8, 0.15, 0.1, p("bend")});
  place(m);
  return m;
}

/// A block whose top is free form, with a hole in it.
Model saddle() {
  Model m = model("saddle", "saddle", "a block with a free-form top");
  length(m, "length", 60, 60.004, 0.004, "size along x");
  length(m, "width", 40, 39.998, 0.004, "size along y");
  length(m, "height", 26, 26.01, 0.01, "of the block before its top was cut");
  length(m, "hole_d", 8, 8.003, 0.003, "diameter of the hole");
  step(m, "block", Box{p("length"), p("width"), p("height")}, "the block");
  step(m, "top", wave(), "what is cut from its top");
  step(m, "hole", Hole{p("hole_d"), p("height")}, "through hole").frame = {
      p("length") / 2, p("width") / 2, p("height"), 0, 0, 0};
  finish(m, Difference{{"block", "top", "hole"}});
  place(m);
  return m;
}

}  // namespace

std::vector<Model> golden_models() {
  return {sphere(),         box(),         wedge(),   cylinder(),    cone(),          torus(),     ellipsoid(),
          superellipsoid(), supertoroid(), fillet(),  half_spaces(), pin(),           tie_bar(),   tri_surface(),
          sheet(),          nurbs_vase(),  bracket(), lens(),        drilled_plate(), flange(),    tray(),
          clamp(),          elbow(),       cover(),   handle(),      washer(),        cowl_part(), cushion_part(),
          saddle()};
}

}  // namespace partscribe::testing
