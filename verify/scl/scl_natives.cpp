/// The table of functions that Alpha_1 brings along.
#include "verify/scl/scl_natives.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "verify/scl/scl_arguments.h"
#include "verify/scl/scl_lexer.h"

namespace partscribe::verify {
namespace {

using Called = Result<SclValue>;
using Native = std::function<Called(const SclValues&, SclCallContext&)>;

Called wrapped(const SclArguments& a, const std::function<SclMade()>& make) {
  if (!a.ok()) return a.error();
  auto result = make();
  if (!result.ok()) return result.error();
  return SclValue(*result);
}

SclTransform turned(int axis, double angle_deg) {
  SclTransform t;
  // Exact quarter turns stay exact.
  const double quarters = angle_deg / 90.0;
  double c = std::cos(radians(angle_deg)), s = std::sin(radians(angle_deg));
  if (quarters == std::round(quarters)) c = std::round(c), s = std::round(s);
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  t.linear(j, j) = c, t.linear(j, k) = -s, t.linear(k, j) = s, t.linear(k, k) = c;
  return t;
}

SclTransform shifted(int axis, double by) {
  SclTransform t;
  t.translation[axis] = by;
  return t;
}

/// `budget`: how many members may still be moved; arrays that hold each other grow without bound.
Called transformed(const SclValue& object, const SclTransform& t, int& budget, int depth = 0) {
  if (depth > 50) return bad_input("expected arrays at most 50 deep");
  if (--budget < 0) return bad_input("expected at most 1000000 members to transform");
  if (const auto* p = object.as<SclPoint>()) {
    const Vec3 at = t * p->at;
    return SclValue(SclPoint{at, p->dimension == 2 && at.z() == 0 ? 2 : 3});
  }
  if (const auto* v = object.as<SclVector>()) return SclValue(SclVector{t.linear * v->along});
  if (const auto* a = object.as<SclArray>()) {
    auto moved = std::make_shared<SclValues>();
    for (const auto& member : **a) {
      auto m = transformed(member, t, budget, depth + 1);
      if (!m.ok()) return m;
      moved->push_back(*m);
    }
    return SclValue(SclArray(moved));
  }
  if (const auto* g = object.as<SclGeometryPtr>()) {
    auto moved = scl_transformed(*g, t);
    if (!moved.ok()) return moved.error();
    return SclValue(*moved);
  }
  return bad_input("argument 1: expected an object to transform, found " + description_of(object));
}

Called transform_call(const SclValues& values, SclCallContext&) {
  SclTransform t;
  if (const auto* one = values[1].as<SclTransform>()) {
    t = *one;
  } else if (const auto* several = values[1].as<SclArray>()) {
    if ((*several)->size() != 1)
      return bad_input(
          "argument 2: expected one transformation (the order of several in an array is not documented; nest the "
          "calls)");
    const auto* only = (**several)[0].as<SclTransform>();
    if (!only) return bad_input("argument 2: expected a transformation, found " + description_of((**several)[0]));
    t = *only;
  } else {
    return bad_input("argument 2: expected a transformation, found " + description_of(values[1]));
  }
  int budget = 1'000'000;
  return transformed(values[0], t, budget);
}

SclDirection direction(SclArguments& a) {
  SclDirection d;
  d.order = a.whole();
  const std::string end = a.text();
  if (end == "ec_open")
    d.end = SclEnd::open;
  else if (end == "ec_floating")
    d.end = SclEnd::floating;
  else if (end == "ec_periodic")
    d.end = SclEnd::periodic;
  else
    a.expected("\"ec_open\", \"ec_floating\" or \"ec_periodic\"");
  const SclValue& knots = a.any();
  if (const auto* name = knots.as<std::string>()) {
    if (*name == "kv_bezier")
      d.bezier = true;
    else if (*name != "kv_uniform")
      a.expected("\"kv_uniform\", \"kv_bezier\" or an array of knots");
  } else if (const auto* values = knots.as<SclArray>()) {
    for (const auto& v : **values) {
      double n = 0;
      if (!number_of(v, n)) a.expected("numbers only in the knot vector");
      d.knots.push_back(n);
    }
    if (d.knots.empty()) a.expected("knots in the array");
  } else {
    a.expected("\"kv_uniform\", \"kv_bezier\" or an array of knots");
  }
  return d;
}

Called surface_call(const SclValues& values, SclCallContext&) {
  SclArguments a(values);
  const SclDirection u = direction(a), v = direction(a);
  const auto mesh = a.point_rows();
  return wrapped(a, [&] { return scl_surface(u, v, mesh); });
}

Called rational_surface_call(const SclValues& values, SclCallContext&) {
  SclArguments a(values);
  SclDirection u, v;
  u.order = a.whole(), u.knots = a.numbers();
  v.order = a.whole(), v.knots = a.numbers();
  const auto mesh = a.point_rows();
  std::vector<std::vector<double>> weights;
  for (const auto& row : a.array("rows of weights")) {
    auto& numbers = weights.emplace_back();
    const auto* entries = row.as<SclArray>();
    if (!entries) a.expected("rows of weights");
    for (std::size_t i = 0; entries && i < (*entries)->size(); ++i) {
      double weight = 0;
      if (!number_of((**entries)[i], weight)) a.expected("numbers only among the weights");
      numbers.push_back(weight);
    }
  }
  return wrapped(a, [&] { return scl_surface(u, v, mesh, weights); });
}

Called trim_call(const SclValues& values, SclCallContext&) {
  SclArguments a(values);
  const auto surface = a.geometry({SclGeometryKind::surface}, "a surface");
  std::vector<std::vector<SclGeometryPtr>> loops;
  for (const auto& loop : a.array("an array of loops")) {
    auto& curves = loops.emplace_back();
    const auto* entries = loop.as<SclArray>();
    if (!entries) a.expected("arrays of curves as loops");
    for (std::size_t i = 0; entries && i < (*entries)->size(); ++i) {
      const auto* curve = (**entries)[i].as<SclGeometryPtr>();
      if (!curve)
        a.expected("curves only in a loop");
      else
        curves.push_back(*curve);
    }
  }
  return wrapped(a, [&] { return scl_trimmed(surface, loops); });
}

Called refine_call(const SclValues& values, SclCallContext&) {
  SclArguments a(values);
  const auto surface = a.geometry({SclGeometryKind::surface}, "a surface");
  const std::string way = a.text();
  if (way != "row" && way != "col") a.expected("\"row\" or \"col\"");
  const auto knots = a.numbers();
  if (!a.truth()) a.expected("true (replacing the whole knot vector is not documented)");
  return wrapped(a, [&] { return scl_refined(surface, way == "row", knots); });
}

Called profile_call(const SclValues& values, SclCallContext&) {
  std::vector<SclCorner> corners;
  SclArguments a(values);
  for (const auto& v : values) {
    const SclValue& taken = a.any();
    if (const auto* p = v.as<SclPoint>())
      corners.push_back({p->at, nullptr});
    else if (const auto* g = v.as<SclGeometryPtr>();
             g && (kind_of(**g) == SclGeometryKind::arc || kind_of(**g) == SclGeometryKind::curve ||
                   kind_of(**g) == SclGeometryKind::line))
      corners.push_back({Vec3::Zero(), *g});
    else
      a.expected("a point, line, arc or curve");
    static_cast<void>(taken);
  }
  return wrapped(a, [&] { return scl_profile(corners); });
}

std::vector<SclGeometryPtr> profiles(SclArguments& a) {
  auto result = a.geometries("a profile or an array of profiles");
  for (const auto& p : result)
    if (kind_of(*p) != SclGeometryKind::profile) a.expected("a profile or an array of profiles");
  return result;
}

Called combine_call(const SclValues& values, SclCallContext& context) {
  SclArguments a(values);
  const std::string name = a.text();
  SclOperation operation = SclOperation::unite;
  if (name == "difference")
    operation = SclOperation::subtract;
  else if (name == "intersection")
    operation = SclOperation::intersect;
  else if (name != "union")
    a.expected("\"union\", \"difference\" or \"intersection\"");
  if (values.size() == 2) {  // an array of any number
    const auto all = a.geometries("an array of shells");
    return wrapped(a, [&]() -> SclMade {
      if (all.empty()) return bad_input("expected at least one shell to combine");
      SclMade made = all[0];
      for (std::size_t i = 1; i < all.size() && made.ok(); ++i)
        made = scl_combined(operation, *made, all[i], context.stop);
      return made;
    });
  }
  const auto first = a.geometry(), second = a.geometry();
  return wrapped(a, [&] { return scl_combined(operation, first, second, context.stop); });
}

Called dump_call(const SclValues& values, SclCallContext& context) {
  SclArguments a(values);
  auto objects = a.geometries("an array of objects");
  a.text();
  if (!a.ok()) return a.error();
  context.outputs.dumped = std::move(objects);
  context.outputs.has_dump = true;
  return SclValue();
}

Called show_call(const SclValues& values, SclCallContext& context) {
  SclArguments a(values);
  std::vector<SclGeometryPtr> objects;
  while (a.more())
    for (auto& g : a.geometries("objects")) objects.push_back(std::move(g));
  if (!a.ok()) return a.error();
  context.outputs.shown = std::move(objects);
  context.outputs.has_show = true;
  return SclValue();
}

Called coordinate(const SclValues& values, int axis) {
  const auto* p = values[0].as<SclPoint>();
  if (!p || axis >= p->dimension)
    return bad_input(std::string("argument 1: expected a point with this coordinate, found ") +
                     description_of(values[0]));
  return SclValue(p->at[axis]);
}

struct Entry {
  std::size_t fewest, most;
  Native call;
};

constexpr std::size_t many = 1'000'000;

/// Every function there is, by its name in lower case.
const std::map<std::string, Entry>& natives() {
  static const std::map<std::string, Entry> table = {
      // points and vectors
      {"pt",
       {2, 3,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double x = a.number(), y = a.number(), z = v.size() == 3 ? a.number() : 0;
          if (!a.ok()) return a.error();
          return SclValue(SclPoint{Vec3(x, y, z), static_cast<int>(v.size())});
        }}},
      {"vec",
       {2, 3,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double x = a.number(), y = a.number(), z = v.size() == 3 ? a.number() : 0;
          if (!a.ok()) return a.error();
          return SclValue(SclVector{Vec3(x, y, z)});
        }}},
      {"ptx", {1, 1, [](const SclValues& v, SclCallContext&) { return coordinate(v, 0); }}},
      {"pty", {1, 1, [](const SclValues& v, SclCallContext&) { return coordinate(v, 1); }}},
      {"ptz", {1, 1, [](const SclValues& v, SclCallContext&) { return coordinate(v, 2); }}},
      {"e2",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const Vec3 p = a.point();
          if (!a.ok()) return a.error();
          return SclValue(SclPoint{Vec3(p.x(), p.y(), 0), 2});
        }}},
      {"e3",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const Vec3 p = a.point();
          if (!a.ok()) return a.error();
          return SclValue(SclPoint{p, 3});
        }}},
      // curves and profiles
      {"linethru2pts",
       {2, 2,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 p = a.point(), q = a.point();
          return wrapped(a, [&] { return scl_line(p, q); });
        }}},
      {"arcthru3pts",
       {3, 3,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 p = a.point(), q = a.point(), r = a.point();
          return wrapped(a, [&] { return scl_arc_through(p, q, r); });
        }}},
      {"arcendcenterend",
       {3, 3,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 p = a.point(), c = a.point(), q = a.point();
          return wrapped(a, [&] { return scl_arc_about(p, c, q); });
        }}},
      {"crvfromarc",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto arc = a.geometry({SclGeometryKind::arc}, "an arc");
          return wrapped(a, [&] { return scl_curve_of(arc); });
        }}},
      {"crvfromcircle",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto circle = a.geometry({SclGeometryKind::circle}, "a circle");
          return wrapped(a, [&] { return scl_curve_of(circle); });
        }}},
      {"profile", {1, many, profile_call}},
      // surfaces
      {"surface", {7, 7, surface_call}},
      {"srefine", {4, 4, refine_call}},
      // primitives
      {"box",
       {4, 4,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 o = a.point(), x = a.vector(), y = a.vector(), z = a.vector();
          return wrapped(a, [&] { return scl_box(o, x, y, z); });
        }}},
      {"rightanglewedge",
       {4, 4,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 o = a.point(), x = a.vector(), y = a.vector(), z = a.vector();
          return wrapped(a, [&] { return scl_wedge(o, x, y, z); });
        }}},
      {"rightcircylinder",
       {3, 3,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const Vec3 base = a.point(), axis = a.vector();
          const double radius = a.number();
          return wrapped(a, [&] { return scl_cylinder(base, axis, radius); });
        }}},
      {"makegeom",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto g = a.geometry({SclGeometryKind::primitive, SclGeometryKind::shell}, "a primitive");
          return wrapped(a, [&] { return scl_shell_of(g); });
        }}},
      // transformations
      {"objtransform", {2, 2, transform_call}},
      {"instance", {2, 2, transform_call}},
      {"tx",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(shifted(0, d));
        }}},
      {"ty",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(shifted(1, d));
        }}},
      {"tz",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(shifted(2, d));
        }}},
      {"rx",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(turned(0, d));
        }}},
      {"ry",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(turned(1, d));
        }}},
      {"rz",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          const double d = a.number();
          if (!a.ok()) return a.error();
          return SclValue(turned(2, d));
        }}},
      {"sg",
       {1, 1,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          SclTransform t;
          t.linear *= a.number();
          if (!a.ok()) return a.error();
          return SclValue(t);
        }}},
      {"sxyz",
       {3, 3,
        [](const SclValues& v, SclCallContext&) -> Called {
          SclArguments a(v);
          SclTransform t;
          for (int i = 0; i < 3; ++i) t.linear(i, i) = a.number();
          if (!a.ok()) return a.error();
          return SclValue(t);
        }}},
      {"group",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          auto members = a.geometries("an array of objects");
          return wrapped(a, [&] { return scl_group(members); });
        }}},
      {"reverseobj",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          // Shells always face outward here, so reversing one changes nothing that can be measured.
          SclArguments a(v);
          const auto g = a.geometry({SclGeometryKind::shell, SclGeometryKind::surface}, "a shell or surface");
          return wrapped(a, [&] { return SclMade(g); });
        }}},
      // attributes and files
      {"setattr",
       {3, 3,
        [](const SclValues& v, SclCallContext& c) -> Called {
          SclArguments a(v);
          const auto g = a.geometry();
          const std::string name = a.text();
          if (!a.ok()) return a.error();
          c.outputs.attributes[g][name] = v[2];
          return v[0];
        }}},
      {"getattr",
       {2, 2,
        [](const SclValues& v, SclCallContext& c) -> Called {
          SclArguments a(v);
          const auto g = a.geometry();
          const std::string name = a.text();
          if (!a.ok()) return a.error();
          const auto& of_object = c.outputs.attributes[g];
          const auto found = of_object.find(name);
          if (found == of_object.end()) return bad_input("the object has no attribute \"" + name + "\"");
          return found->second;
        }}},
      {"setcolor",
       {2, 2,
        [](const SclValues& v, SclCallContext& c) -> Called {
          SclArguments a(v);
          const auto g = a.geometry();
          a.text();
          if (!a.ok()) return a.error();
          c.outputs.attributes[g]["color"] = v[1];
          return v[0];
        }}},
      {"dumpgeomfile", {2, 2, dump_call}},
      {"dumpa1file", {2, 2, dump_call}},
      {"savemodel", {2, 2, dump_call}},
      {"show", {1, many, show_call}},
      // behind the prelude: what they do is known, what Alpha_1 calls them is not
      {"combineshells", {2, 3, combine_call}},
      {"surfrev",
       {1, 2,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto p = profiles(a);
          const double turn = v.size() == 2 ? radians(a.number()) : 2 * pi;
          return wrapped(a, [&] { return scl_revolved(p, turn); });
        }}},
      {"extrudeprofiles",
       {2, 2,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto p = profiles(a);
          const double height = a.number();
          return wrapped(a, [&] { return scl_extruded(p, height); });
        }}},
      {"extrudeprofileswithdraft",
       {4, 4,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto p = profiles(a);
          const double below = a.number(), height = a.number(), draft = radians(a.number());
          return wrapped(a, [&] { return scl_drafted(p, below, height, draft); });
        }}},
      {"sweepsurface",
       {2, 2,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto surface = a.geometry({SclGeometryKind::surface}, "a surface");
          const Vec3 direction = a.vector();
          return wrapped(a, [&] { return scl_swept(surface, direction); });
        }}},
      {"nurbssrf", {6, 6, rational_surface_call}},
      {"trimsurface", {2, 2, trim_call}},
      {"nurbscrv",
       {3, 4,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const int order = a.whole();
          const auto knots = a.numbers();
          const auto points = a.points_of(a.any());
          const auto weights = v.size() == 4 ? a.numbers() : std::vector<double>();
          return wrapped(a, [&] { return scl_nurbs_curve(order, knots, points, weights); });
        }}},
      {"shellofsurfaces",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto surfaces = a.geometries("an array of surfaces");
          return wrapped(a, [&] { return scl_sewn(surfaces); });
        }}},
      {"shelloffacets",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          const auto facets = a.point_rows();
          return wrapped(a, [&] { return scl_facets(facets); });
        }}},
      {"shellofhalfspaces",
       {1, 1,
        [](const SclValues& v, SclCallContext&) {
          SclArguments a(v);
          std::vector<std::array<double, 4>> planes;
          for (const auto& row : a.array("an array of half-spaces")) {
            const auto* four = row.as<SclArray>();
            std::array<double, 4> plane{};
            bool good = four && (*four)->size() == 4;
            for (std::size_t i = 0; good && i < 4; ++i) good = number_of((**four)[i], plane[i]);
            if (!good) a.expected("four numbers for every half-space");
            planes.push_back(plane);
          }
          return wrapped(a, [&] { return scl_half_spaces(planes); });
        }}},
  };
  return table;
}

}  // namespace

bool is_scl_native(const std::string& name) { return natives().contains(name); }

std::string why_not_native(const std::string& name) {
  if (name == "circtubeconstantwidth") return "the manual does not tell whether its width is a radius or a diameter";
  if (name == "boxfromanchor" || name == "outlinecrv" || name == "roundpolyline" || name == "reflect" ||
      name == "bboxobj" || name == "krefinesrf" || name == "surfaceopen" || name == "ptl" || name == "restoremodel")
    return "this interpreter does not know it";
  return {};
}

Result<SclValue> call_scl_native(const std::string& name, const SclValues& arguments, SclCallContext& context) {
  const auto found = natives().find(name);
  ensure(found != natives().end(), "only functions that exist are called");
  const auto& entry = found->second;
  if (arguments.size() < entry.fewest || arguments.size() > entry.most) {
    std::string wanted = std::to_string(entry.fewest);
    if (entry.most == many)
      wanted = "at least " + wanted;
    else if (entry.most != entry.fewest)
      wanted += " or " + std::to_string(entry.most);
    return bad_input("expected " + wanted + (wanted == "1" ? " argument" : " arguments") + ", found " +
                     std::to_string(arguments.size()));
  }
  return entry.call(arguments, context);
}

std::optional<SclValue> scl_predefined(const std::string& name) {
  const std::string word = lower_case(name);
  static const std::map<std::string, std::int64_t> orders = {
      {"linear", 2}, {"quadratic", 3}, {"cubic", 4}, {"quartic", 5}, {"quintic", 6}};
  if (const auto found = orders.find(word); found != orders.end()) return SclValue(found->second);
  if (word == "origin") return SclValue(SclPoint{Vec3(0, 0, 0), 3});
  if (word == "xaxis") return SclValue(SclVector{Vec3(1, 0, 0)});
  if (word == "yaxis") return SclValue(SclVector{Vec3(0, 1, 0)});
  if (word == "zaxis") return SclValue(SclVector{Vec3(0, 0, 1)});
  if (word == "unitsphere") {
    auto sphere = scl_unit_sphere();
    if (sphere.ok()) return SclValue(*sphere);
  }
  return {};
}

}  // namespace partscribe::verify
