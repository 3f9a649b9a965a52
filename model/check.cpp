#include "model/check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/number.h"
#include "geometry/mesh/convex.h"
#include "geometry/surfaces/edge_curve.h"
#include "model/draft.h"
#include "model/lower/edges.h"
#include "model/lower/lower.h"
#include "model/lower/solids.h"
#include "model/overloaded.h"
#include "model/sketch.h"
#include "model/sketch_relations.h"
#include "model/surface_patches.h"
#include "model/tri_faces.h"

namespace partscribe::model {
namespace {

/// More copies of an object than this are a mistake.
constexpr double most_copies = 10000;

bool is_identifier(const std::string& name) {
  if (name.empty() || !(name[0] >= 'a' && name[0] <= 'z')) return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

/// Words that mean something in one of the languages we write.
const std::set<std::string>& reserved_words() {
  static const std::set<std::string> words = {
      "module",      "function",     "include", "use",       "if",     "else",      "for",        "let",
      "each",        "true",         "false",   "undef",     "cube",   "sphere",    "cylinder",   "union",
      "difference",  "intersection", "hull",    "part",      "set",    "unset",     "quit",       "while",
      "return",      "seq",          "and",     "or",        "not",    "procedure", "const",      "as_scanned",
      "as_designed", "translate",    "rotate",  "mirror",    "circle", "square",    "polygon",    "render",
      "echo",        "assert",       "import",  "scale",     "box",    "group",     "surface",    "profile",
      "instance",    "show",         "linear",  "quadratic", "cubic",  "origin",    "chord_error"};
  return words;
}

std::string quoted(const std::string& text) { return "'" + text + "'"; }

bool segments_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  auto side = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
  };
  // Neighbours share an end up to rounding (a full circle's first and last chord do): that is no crossing.
  if ((a - d).norm() <= sketch_join || (b - c).norm() <= sketch_join) return false;
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

/// True if the first segment starts inside the second: where a corner lies on another edge, the sketch meets itself.
bool starts_inside(const Vec2& a, const Vec2& c, const Vec2& d) {
  const double length = (d - c).norm(), along = (a - c).dot(d - c) / std::max(length, sketch_join);
  if (along < sketch_join || along > length - sketch_join || (a - c).norm() <= sketch_join ||
      (a - d).norm() <= sketch_join)
    return false;
  return (a - c - along / length * (d - c)).norm() <= sketch_join;
}

/// True if two segments lie on one line and share more than an end.
bool segments_overlap(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double length = (b - a).norm();
  if (!(length > sketch_join)) return false;
  const Vec2 along = (b - a) / length, across(-along.y(), along.x());
  if (std::abs(across.dot(c - a)) > sketch_join || std::abs(across.dot(d - a)) > sketch_join) return false;
  const double from = along.dot(c - a), to = along.dot(d - a);
  return std::min(length, std::max(from, to)) - std::max(0.0, std::min(from, to)) > sketch_join;
}

std::string place_of(const Vec2& p) {
  return "(" + print_number(snapped(p.x(), 1e-3)) + ", " + print_number(snapped(p.y(), 1e-3)) + ")";
}

}  // namespace

struct Check {
  Model model;
  std::vector<std::string> complaints;
  Values values, fitted;

  void complain(std::string line) { complaints.push_back(std::move(line)); }

  void check_name(const std::string& what, const std::string& name, std::set<std::string>& taken) {
    if (!is_identifier(name))
      complain(what + " " + quoted(name) +
               ": expected a name of lower-case letters, digits and _, starting with a letter");
    else if (reserved_words().count(name))
      complain(what + " " + quoted(name) + ": this word is reserved");
    else if (!taken.insert(name).second)
      complain(what + " " + quoted(name) + ": the name is used twice");
  }

  /// True if every parameter in it is known and the value is finite.
  bool check_expr(const std::string& where, const Expr& e) {
    bool known = true;
    visit_parameters(e, [&](const std::string& name) {
      if (!values.count(name)) {
        complain(where + ": unknown parameter " + quoted(name));
        known = false;
      }
    });
    if (!known) return false;
    if (!std::isfinite(evaluate(e, values))) {
      complain(where + ": the expression has no finite value");
      return false;
    }
    return true;
  }

  void check_domain(const std::string& where, double v, Domain domain) {
    auto want = [&](bool good, const char* expected) {
      if (!good) complain(where + ": expected " + expected + ", found " + print_number(v));
    };
    switch (domain) {
      case Domain::length:
        return want(v > 0, "a length above 0");
      case Domain::length_or_zero:
        return want(v >= 0, "a length of at least 0");
      case Domain::exponent:
        return want(v >= 0.1 - 1e-12 && v <= 2 + 1e-12, "an exponent of 0.1 to 2");
      case Domain::taper:
        return want(std::abs(v) <= 0.95 + 1e-12, "a taper of -0.95 to 0.95");
      case Domain::component:
        return want(std::abs(v) <= 1 + 1e-9, "a component of a unit vector");
      case Domain::count:
        return want(v >= 1 - 1e-9 && v <= most_copies && std::abs(v - std::round(v)) < 1e-9,
                    "a whole number of 1 to 10000");
      case Domain::turn:
        return want(v > 0 && v <= 2 * pi + 1e-9, "an angle above 0, a full turn at most");
      case Domain::coordinate:
      case Domain::angle:
        return;
    }
  }

  /// Everything lies inside the first loop, and which way a loop runs says whether material is inside it or outside.
  void check_nesting(const std::string& where, const EvaluatedSketch& sketch, const Outline2& outline) {
    const auto around = loops_around(outline, sketch.loops.size());
    for (std::size_t l = 0; l < sketch.loops.size(); ++l) {
      const std::string loop = ": loop " + quoted(sketch.loops[l].name);
      const bool in_hole = around[l].size() % 2 == 1;
      if (l > 0 && (around[l].empty() || around[l].front() != 0))
        return complain(where + loop + " lies outside the outer loop");
      const bool counter_clockwise = signed_area(outline, static_cast<int>(l)) > 0;
      if (l == 0 && !counter_clockwise)
        complain(where + ": the outer loop must run counter-clockwise");
      else if (in_hole && counter_clockwise)
        complain(where + loop + " is a hole and must run clockwise");
      else if (!in_hole && !counter_clockwise)
        complain(where + loop + " is an island in a hole and must run counter-clockwise");
    }
  }

  void check_sketch(const std::string& where, const EvaluatedSketch& sketch, bool profile) {
    if (sketch.loops.empty()) return complain(where + ": a sketch needs a loop");
    for (const auto& loop : sketch.loops) {
      if (loop.elements.empty()) return complain(where + ": loop " + quoted(loop.name) + " is empty");
      for (const auto& element : loop.elements) {
        const auto* n = std::get_if<SketchNurbsOf<double>>(&element);
        if (!n) continue;
        const std::size_t count = n->control.size(), degree = static_cast<std::size_t>(std::max(n->degree, 0));
        if (n->degree < 1 || n->degree > 9 || count < degree + 1)
          return complain(where + ": a curve of degree " + print_number(n->degree) + " cannot have " +
                          print_number(double(count)) + " control points");
        if (n->knots.size() != count + degree + 1)
          return complain(where + ": expected " + print_number(double(count + degree + 1)) + " knots, found " +
                          print_number(double(n->knots.size())));
        if (!std::is_sorted(n->knots.begin(), n->knots.end()) || n->knots.front() != n->knots[degree] ||
            n->knots.back() != n->knots[count] || n->knots.front() >= n->knots.back())
          return complain(where + ": knots must rise and be clamped at both ends");
        if (!n->weights.empty() &&
            (n->weights.size() != count || *std::min_element(n->weights.begin(), n->weights.end()) <= 0))
          return complain(where + ": expected one weight above 0 per control point");
      }
    }
    const Outline2 outline = outline_of(sketch);
    const std::size_t before = complaints.size();
    check_outline(where, sketch, outline, profile);
    if (complaints.size() > before) return;
    for (const auto& relation : sketch.relations)
      if (const auto fault = fault_of(relation, outline)) complain(where + ": " + *fault);
  }

  /// Loops are simple, apart from each other and nested in the right way.
  void check_outline(const std::string& where, const EvaluatedSketch& sketch, const Outline2& outline, bool profile) {
    // One list of chords for all loops: no two may cross.
    struct Chord {
      Vec2 a, b;
    };
    std::vector<Chord> chords;
    Vec2 low = Vec2::Constant(1e300), high = -low;
    for (const auto& c : outline.curves)
      for (const auto& p : {start_of(c.curve), end_of(c.curve)}) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (const auto& c : outline.curves)
      if (const auto* a = std::get_if<Arc2>(&c.curve)) {
        if (!(a->radius > 0)) return;  // already reported
        low = low.cwiseMin(a->center - Vec2::Constant(a->radius)),
        high = high.cwiseMax(a->center + Vec2::Constant(a->radius));
        if (std::abs(a->to - a->from) > 2 * pi + 1e-9) return complain(where + ": an arc turns more than once");
      }
    const double chord_error = std::max((high - low).norm() * 1e-4, 1e-9);
    for (const auto& c : outline.curves) {
      const auto points = polyline(c.curve, chord_error);
      for (std::size_t i = 0; i + 1 < points.size(); ++i) chords.push_back({points[i], points[i + 1]});
    }
    for (std::size_t i = 0; i < chords.size(); ++i)
      for (std::size_t k = i + 1; k < chords.size(); ++k)
        if (segments_cross(chords[i].a, chords[i].b, chords[k].a, chords[k].b))
          return complain(where + ": the sketch crosses itself near " + place_of(chords[i].a));
    for (std::size_t l = 0; l < sketch.loops.size(); ++l)
      if (std::abs(signed_area(outline, static_cast<int>(l))) < 1e-12)
        return complain(where + ": loop " + quoted(sketch.loops[l].name) + " encloses nothing");
    for (std::size_t i = 0; i < chords.size(); ++i)
      for (std::size_t k = i + 1; k < chords.size(); ++k)
        if (segments_overlap(chords[i].a, chords[i].b, chords[k].a, chords[k].b))
          return complain(where + ": the sketch runs along itself near " + place_of(chords[i].a));
    for (std::size_t i = 0; i < chords.size(); ++i)
      for (std::size_t k = 0; k < chords.size(); ++k)
        if (k != i && starts_inside(chords[i].a, chords[k].a, chords[k].b))
          return complain(where + ": the sketch touches itself near " + place_of(chords[i].a));
    check_nesting(where, sketch, outline);
    if (profile)
      for (const auto& chord : chords)
        if (chord.a.x() < -1e-7) return complain(where + ": the profile crosses the axis");
  }

  /// Pieces that meet at an end of the body have met there for good: between the ends all is well where it is at both.
  void check_extrusion(const std::string& where, const ExtrudeOf<double>& s) {
    const std::size_t before = complaints.size();
    check_sketch(where, s.sketch, false);
    if (s.draft == 0 || complaints.size() > before) return;
    if (!(std::abs(s.draft) < pi / 2 - 1e-6))
      return complain(where + ": expected a draft of less than a quarter of a turn, found " + print_degrees(s.draft) +
                      " degrees");
    const Outline2 outline = outline_of(s.sketch);
    const double at_bottom = -s.below * std::tan(s.draft), at_top = s.height * std::tan(s.draft);
    if (const auto fault = fault_of_draft(outline, at_bottom, at_top)) return complain(where + ": " + *fault);
    for (const bool top : {false, true}) {
      check_outline(where + ": with this draft, at the " + (top ? "top" : "bottom"), s.sketch,
                    moved_inwards(outline, top ? at_top : at_bottom), false);
      if (complaints.size() > before) return;
    }
  }

  /// Towards the bend the body has to end before the centre of the arc, and its two ends must not meet.
  void check_bend(const std::string& where, const SuperellipsoidOf<double>& s) {
    if (s.bend == 0) return;
    if (!(std::abs(s.bend) < pi))
      return complain(where + ": expected a bend of less than half a turn, found " + print_degrees(s.bend) +
                      " degrees");
    const double half = s.a1 * (1 + std::abs(s.taper_x)), radius = s.a3 / std::abs(s.bend);
    if (!(half < radius))
      complain(where + ": expected a bend with a radius above the half width " + print_number(snapped(half, 1e-3)) +
               ", found " + print_number(snapped(radius, 1e-3)));
  }

  void check_half_spaces(const std::string& where, const HalfSpacesOf<double>& s) {
    std::vector<Plane3> planes;
    for (const auto& p : s.planes) {
      const Vec3 n(p.normal_x, p.normal_y, p.normal_z);
      if (std::abs(n.norm() - 1) > 1e-6)
        return complain(where + ": the normal of face " + quoted(p.name) + " is no unit vector");
      planes.push_back({n.normalized(), p.offset});
    }
    if (!convex_polyhedron(planes)) complain(where + ": the half-spaces leave no bounded body");
  }

  void check_triangles(const std::string& where, const TriSurfaceOf<double>& s) {
    TriangleMesh mesh{std::vector<Vec3>(s.vertices.size()), s.triangles};
    for (std::size_t i = 0; i < s.vertices.size(); ++i) mesh.vertices[i] = Vec3(s.vertices[i].data());
    if (mesh.triangles.empty()) return complain(where + ": a triangulation needs a triangle");
    for (const auto& t3 : mesh.triangles)
      for (const auto v : t3)
        if (v >= mesh.vertices.size())
          return complain(where + ": a triangle names vertex " + print_number(v) + ", there are " +
                          print_number(double(mesh.vertices.size())));
    const auto topo = topology(mesh);
    if (topo.nonmanifold_edges > 0 || topo.inconsistent_edges > 0)
      complain(where + ": " + print_number(double(topo.nonmanifold_edges + topo.inconsistent_edges)) +
               " edges are not manifold");
    if (s.closed && topo.boundary_edges > 0)
      complain(where + ": called closed, but has " + print_number(double(topo.boundary_edges)) + " open edges");
    if (s.closed && topo.closed() && volume(mesh) <= 0) complain(where + ": the triangles face inward");
    if (!s.faces.empty()) check_faces(where, s, mesh);
  }

  void check_faces(const std::string& where, const TriSurfaceOf<double>& s, const TriangleMesh& mesh) {
    if (!s.closed) return complain(where + ": only a closed triangulation may have faces");
    std::size_t count = 0;
    for (const auto& face : s.faces) {
      const std::string which = where + ": face " + quoted(face.name);
      const bool free_form = face.surface.empty();
      const auto surface = surface_of(face);
      if (!surface && !free_form)
        return complain(which + ": expected plane, cylinder, cone, sphere or torus with the numbers of its kind");
      if (face.triangles < 1) return complain(which + " has no triangles");
      count += static_cast<std::size_t>(face.triangles);
      if (!surface) continue;
      const Primitive& p = *surface;
      if (!p.point.allFinite() || !p.axis.allFinite() || std::abs(p.axis.norm() - 1) > 1e-6)
        complain(which + ": its axis is no unit vector");
      const bool round = p.kind != PrimitiveKind::plane;
      if (round && !(p.radius > 0)) complain(which + ": its radius must be above 0");
      if (p.kind == PrimitiveKind::torus && !(p.tube > 0)) complain(which + ": the radius of its tube must be above 0");
      if (p.kind == PrimitiveKind::cone && !(p.half_angle > 0 && p.half_angle < pi / 2))
        complain(which + ": the half angle of a cone must lie between 0 and a right angle");
    }
    if (count != mesh.triangles.size())
      complain(where + ": its faces have " + print_number(double(count)) + " triangles, there are " +
               print_number(double(mesh.triangles.size())));
  }

  void check_surfaces(const std::string& where, const SurfaceSetOf<double>& s) {
    if (s.patches.empty()) return complain(where + ": a surface set needs a patch");
    std::set<std::string> names;
    std::map<int, std::vector<const PatchTrim*>> edges;
    for (const auto& patch : s.patches) {
      const std::string which = where + ": patch " + quoted(patch.name);
      if (!names.insert(patch.name).second) complain(which + " is there twice");
      if (const auto wrong = complaint_about(patch)) return complain(which + *wrong);
      for (const auto& trim : patch.trims) edges[trim.edge].push_back(&trim);
    }
    for (const auto& [number, uses] : edges) {
      if (uses.size() > 2)
        complain(where + ": edge " + std::to_string(number) + " has " + std::to_string(uses.size()) +
                 " sides, expected two at most");
      if (s.closed && uses.size() == 1)
        complain(where + ": called closed, but edge " + std::to_string(number) + " has one side only");
    }
    check_edges(where, s);
  }

  /// Where two patches have an edge in common they have to meet.
  void check_edges(const std::string& where, const SurfaceSetOf<double>& s) {
    const auto surfaces = trimmed_surfaces(s.patches);
    for (const auto& [number, sides] : edge_sides(surfaces)) {
      const double gap = edge_gap(sides, 16);
      if (gap > model.tolerance)
        complain(where + ": edge " + std::to_string(number) + ": its two sides are " +
                 print_number(snapped(gap, 1e-4)) + " mm apart");
    }
  }

  void check_swept(const std::string& where, const SweptSurfaceOf<double>& s) {
    if (const auto wrong = complaint_about_whole(s.surface)) return complain(where + ": surface" + *wrong);
    if (s.direction.size() != 3 || !std::ranges::all_of(s.direction, [](double x) { return std::isfinite(x); }) ||
        !(Vec3(s.direction.data()).norm() > 0))
      return complain(where + ": expected a direction of three numbers, not all of them 0");
    constexpr double least = 0.02;  // cosine
    if (std::abs(leaving_cosine(s.surface, Vec3(s.direction.data()))) < least)
      complain(where + ": the surface must not run along the direction in which it moves, nor turn back");
  }

  void check_hole(const std::string& where, const HoleOf<double>& s) {
    auto want = [&](bool good, const char* rule) {
      if (!good) complain(where + ": " + rule);
    };
    want(s.through ? s.tip_angle == 0 : s.tip_angle >= 0 && s.tip_angle < pi,
         s.through ? "a hole that goes through has no tip" : "the tip angle of a hole must lie below half a turn");
    const bool head = s.head_diameter > 0, sink = s.sink_diameter > 0;
    want(head == (s.head_depth > 0), "a counterbore needs a diameter and a depth");
    if (head) want(s.head_diameter > s.diameter, "a counterbore must be wider than its hole");
    if (head) want(s.head_depth < s.depth, "a counterbore must be less deep than its hole");
    if (!sink) return;
    want(s.sink_angle > 0 && s.sink_angle < pi, "the angle of a countersink must lie between 0 and half a turn");
    want(s.sink_diameter > s.diameter, "a countersink must be wider than its hole");
    if (head) want(s.sink_diameter < s.head_diameter, "a countersink in a counterbore must be narrower than it");
    const double sink_depth = (s.sink_diameter - s.diameter) / 2 / std::tan(s.sink_angle / 2);
    want(s.head_depth + sink_depth < s.depth, "a countersink must be less deep than its hole");
  }

  void check_names(const std::string& where, const std::vector<std::string>& names, std::size_t least,
                   const std::set<std::string>& earlier) {
    if (names.size() < least) complain(where + ": expected at least " + print_number(double(least)) + " objects");
    for (const auto& name : names)
      if (!earlier.count(name)) complain(where + ": " + quoted(name) + " is not an earlier object");
  }

  /// What the domains of a shape's numbers do not say by themselves.
  void check_shape(const std::string& where, const EvaluatedShape& shape, const std::set<std::string>& earlier) {
    std::visit(Overloaded{
                   [](const BoxOf<double>&) {},
                   [](const WedgeOf<double>&) {},
                   [](const CylinderOf<double>&) {},
                   [](const SphereOf<double>&) {},
                   [](const EllipsoidOf<double>&) {},
                   [](const FilletOf<double>&) {},
                   [&](const ConeOf<double>& s) {
                     if (s.bottom_radius <= 0 && s.top_radius <= 0)
                       complain(where + ": one radius of a cone must be above 0");
                   },
                   [&](const SuperellipsoidOf<double>& s) { check_bend(where, s); },
                   [&](const TorusOf<double>& s) {
                     if (s.minor_radius >= s.major_radius)
                       complain(where + ": the tube's radius must be below the ring's");
                   },
                   [&](const SupertoroidOf<double>& s) {
                     if (s.minor_radius >= s.major_radius)
                       complain(where + ": the tube's half width must be below the ring's radius");
                   },
                   [&](const HalfSpacesOf<double>& s) { check_half_spaces(where, s); },
                   [&](const ExtrudeOf<double>& s) { check_extrusion(where, s); },
                   [&](const RevolveOf<double>& s) { check_sketch(where, s.sketch, true); },
                   [&](const TriSurfaceOf<double>& s) { check_triangles(where, s); },
                   [&](const SurfaceSetOf<double>& s) { check_surfaces(where, s); },
                   [&](const UnionOf<double>& s) { check_names(where, s.objects, 1, earlier); },
                   [&](const DifferenceOf<double>& s) { check_names(where, s.objects, 2, earlier); },
                   [&](const IntersectionOf<double>& s) { check_names(where, s.objects, 1, earlier); },
                   [&](const HoleOf<double>& s) { check_hole(where, s); },
                   [&](const SlotOf<double>& s) {
                     if (s.length <= s.width) complain(where + ": the length of a slot must be above its width");
                   },
                   [&](const PocketOf<double>& s) { check_extrusion(where, solid_of(s)); },
                   [&](const BossOf<double>& s) { check_extrusion(where, solid_of(s)); },
                   [&](const SweptSurfaceOf<double>& s) { check_swept(where, s); },
                   [&](const LinearPatternOf<double>& s) {
                     check_names(where, {s.object}, 1, earlier);
                     if (s.count > 1.5 && s.step_x == 0 && s.step_y == 0 && s.step_z == 0)
                       complain(where + ": the step of a pattern must not be 0");
                   },
                   [&](const CircularPatternOf<double>& s) {
                     check_names(where, {s.object}, 1, earlier);
                     if (s.count > 1.5 && s.step == 0) complain(where + ": the step of a pattern must not be 0");
                   },
                   [&](const EdgeFilletOf<double>& s) { check_names(where, {s.object}, 1, earlier); },
                   [&](const EdgeChamferOf<double>& s) { check_names(where, {s.object}, 1, earlier); },
                   [&](const MirrorOf<double>& s) {
                     check_names(where, {s.object}, 1, earlier);
                     if (s.axis != "x" && s.axis != "y" && s.axis != "z")
                       complain(where + ": expected axis x, y or z, found " + quoted(s.axis));
                   },
               },
               shape);
  }

  /// The edge of a fillet or chamfer has to be one. Asked only while all earlier objects are sound.
  void check_edge(const std::string& where, const Object& object) {
    auto fault = [&](const auto& s) {
      Model part = model;
      const auto last =
          std::find_if(part.objects.begin(), part.objects.end(), [&](const Object& o) { return o.name == s.object; });
      part.objects.erase(last + 1, part.objects.end());
      const auto made = edge_tool(lowered(part, Kinds{}), values, s);
      if (const auto* text = std::get_if<std::string>(&made)) complain(where + ": " + *text);
    };
    if (const auto* s = std::get_if<EdgeFillet>(&object.shape)) fault(*s);
    if (const auto* s = std::get_if<EdgeChamfer>(&object.shape)) fault(*s);
  }

  std::variant<CheckedModel, Complaints> run() {
    std::set<std::string> names;
    if (!is_identifier(model.name)) complain("model " + quoted(model.name) + ": expected a lower_snake_case name");
    if (!(model.tolerance > 0) || !std::isfinite(model.tolerance)) complain("tolerance: expected a length above 0");
    for (auto& p : model.parameters) {
      check_name("parameter", p.name, names);
      if (p.formula && check_expr("parameter " + quoted(p.name) + ": formula", *p.formula)) {
        p.value = evaluate(*p.formula, values);
        p.fitted = evaluate(*p.formula, fitted);
      }
      if (p.quantity == Quantity::count) check_domain("parameter " + quoted(p.name), p.value, Domain::count);
      for (const double v : {p.value, p.fitted, p.sigma, p.sigma_noise, p.sigma_systematic})
        if (!std::isfinite(v)) complain("parameter " + quoted(p.name) + ": a number is not finite");
      values[p.name] = p.value, fitted[p.name] = p.fitted;
    }
    if (model.objects.empty()) complain("objects: a model needs at least one");
    std::set<std::string> earlier;
    for (const auto& object : model.objects) {
      const std::string where = "object " + quoted(object.name);
      check_name("object", object.name, names);
      bool good = true;
      visit_expressions(object.shape, [&](const Expr& e, Domain domain) {
        if (!check_expr(where, e))
          good = false;
        else
          check_domain(where, evaluate(e, values), domain);
      });
      visit_expressions(std::as_const(object.frame), [&](const Expr& e) { check_expr(where + " frame", e); });
      if (good) check_shape(where, evaluate(object.shape, values), earlier);
      if (complaints.empty()) check_edge(where, object);
      earlier.insert(object.name);
    }
    visit_expressions(std::as_const(model.scan_from_part), [&](const Expr& e) { check_expr("scan_from_part", e); });
    if (!complaints.empty()) return Complaints{std::move(complaints)};
    return CheckedModel(std::move(model));
  }
};

std::variant<CheckedModel, Complaints> check(Model model) { return Check{std::move(model), {}, {}}.run(); }

Result<CheckedModel> checked(Model model, const std::string& where) {
  auto outcome = check(std::move(model));
  if (auto* good = std::get_if<CheckedModel>(&outcome)) return std::move(*good);
  const auto& lines = std::get<Complaints>(outcome).lines;
  std::string text = where + ": " + lines.front();
  if (lines.size() > 1) text += " (and " + print_number(double(lines.size() - 1)) + " more)";
  return bad_input(text);
}

}  // namespace partscribe::model
