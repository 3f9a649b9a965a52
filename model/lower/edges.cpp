#include "model/lower/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"
#include "model/distance/distance.h"
#include "model/lower/solids.h"
#include "model/overloaded.h"

namespace partscribe::model {
namespace {

using Axis = std::size_t;
using Vector = std::array<Expr, 3>;

/// A turn that takes axes onto axes, and a shift that may hold parameters.
struct Stand {
  Mat3 turn = Mat3::Identity();
  Vector shift{0, 0, 0};

  Vector operator()(const Vector& p) const {
    Vector result = shift;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) {
        const double entry = turn(row, column);
        const Expr& e = p[Axis(column)];
        if (entry > 0.5) result[Axis(row)] = result[Axis(row)] + e;
        if (entry < -0.5) result[Axis(row)] = result[Axis(row)] - e;
      }
    return result;
  }
};

/// Nothing if an axis does not end up along an axis.
std::optional<Stand> stand_of(const Stand& outer, const Frame& f, const Values& values) {
  Mat3 turn = evaluate(f, values).rotation;
  for (double& entry : turn.reshaped()) {
    const double whole = std::round(entry);
    if (std::abs(entry - whole) > 1e-9) return {};
    entry = whole;
  }
  return Stand{outer.turn * turn, outer({f.x, f.y, f.z})};
}

/// A range along an axis.
struct Range {
  Expr low, high;
};

/// A face in the frame of the object: a plane across an axis, or a cylinder along one.
struct Face {
  bool round = false;
  Axis axis = 0;
  Vector point{0, 0, 0};                         ///< on the plane, or on the cylinder's axis
  Expr radius = 0;                               ///< of a cylinder
  std::array<std::optional<Range>, 3> ranges{};  ///< along each axis, where it ends there and that is known
};

Axis axis_of(const Stand& stand, Axis axis) {
  for (Axis row = 0; row < 3; ++row)
    if (std::abs(stand.turn(Eigen::Index(row), Eigen::Index(axis))) > 0.5) return row;
  ensure(false, "a turn takes every axis onto one");
  return 0;
}

Face placed(const Face& local, const Stand& stand) {
  Face f = local;
  f.axis = axis_of(stand, local.axis);
  f.point = stand(local.point);
  for (Axis a = 0; a < 3; ++a) {
    const auto& range = local.ranges[a];
    const Axis to = axis_of(stand, a);
    f.ranges[to].reset();
    if (!range) continue;
    Vector low{0, 0, 0}, high{0, 0, 0};
    low[a] = range->low, high[a] = range->high;
    const Expr first = stand(low)[to], last = stand(high)[to];
    const bool forward = stand.turn(Eigen::Index(to), Eigen::Index(a)) > 0;
    f.ranges[to] = forward ? Range{first, last} : Range{last, first};
  }
  return f;
}

// ---- faces of single shapes, in their own frames --------------------------------------------------------------------

Face plane(Axis axis, const Expr& at, std::array<std::optional<Range>, 3> ranges = {}) {
  Face f;
  f.axis = axis, f.point[axis] = at, f.ranges = std::move(ranges);
  return f;
}

Face cylinder(const Expr& x, const Expr& y, const Expr& radius, const Range& along_z) {
  Face f;
  f.round = true, f.axis = 2, f.point = {x, y, 0}, f.radius = radius, f.ranges[2] = along_z;
  return f;
}

using Named = std::vector<std::pair<std::string, Face>>;

Named faces_of(const Box& s) {
  const std::array<Expr, 3> size{s.size_x, s.size_y, s.size_z};
  const char* names[3][2] = {{"left", "right"}, {"front", "back"}, {"bottom", "top"}};
  Named faces;
  for (Axis a = 0; a < 3; ++a)
    for (const bool far : {false, true}) {
      Face f = plane(a, far ? size[a] : Expr(0));
      for (Axis b = 0; b < 3; ++b)
        if (b != a) f.ranges[b] = Range{0, size[b]};
      faces.emplace_back(names[a][far], f);
    }
  return faces;
}

Named faces_of(const Cylinder& s) {
  return {{"bottom", plane(2, 0)}, {"top", plane(2, s.height)}, {"side", cylinder(0, 0, s.radius, {0, s.height})}};
}

Named faces_of(const Extrude& s) {
  Named faces = {{"bottom", plane(2, -s.below)}, {"top", plane(2, s.height)}};
  if (!(s.draft == Expr(0))) return faces;  // its walls stand along no axis
  const Range along_z{-s.below, s.height};
  for (const Loop& loop : s.sketch.loops)
    for (std::size_t i = 0; i < loop.elements.size(); ++i) {
      const auto& next = loop.elements[(i + 1) % loop.elements.size()];
      if (const auto* a = std::get_if<SketchArc>(&loop.elements[i]); a && loop.elements.size() == 1)
        faces.emplace_back(a->name, cylinder(a->center_x, a->center_y, a->radius, along_z));
      const auto *p = std::get_if<SketchPoint>(&loop.elements[i]), *q = std::get_if<SketchPoint>(&next);
      if (!p || !q) continue;
      // An edge along an axis says so by a number that both ends have in common.
      for (const Axis across : {Axis(0), Axis(1)}) {
        const Expr &here = across == 0 ? p->x : p->y, &there = across == 0 ? q->x : q->y;
        if (!(here == there)) continue;
        Face f = plane(across, here);
        f.ranges[1 - across] = across == 0 ? Range{p->y, q->y} : Range{p->x, q->x};
        f.ranges[2] = along_z;
        faces.emplace_back(p->edge, f);
      }
    }
  return faces;
}

Named faces_of(const Revolve& s) {
  Named faces;
  if (!(s.angle == Expr(2 * pi))) return faces;
  for (const Loop& loop : s.sketch.loops)
    for (std::size_t i = 0; i < loop.elements.size(); ++i) {
      const auto* p = std::get_if<SketchPoint>(&loop.elements[i]);
      const auto* q = std::get_if<SketchPoint>(&loop.elements[(i + 1) % loop.elements.size()]);
      if (!p || !q) continue;
      if (p->y == q->y) faces.emplace_back(p->edge, plane(2, p->y));
      if (p->x == q->x) faces.emplace_back(p->edge, cylinder(0, 0, p->x, {p->y, q->y}));
    }
  return faces;
}

template <class S>
Named faces_of(const S& s) {
  if constexpr (SaidSimpler<S>) return faces_of(solid_of(s));
  return {};
}

// ---- finding a face by its name -------------------------------------------------------------------------------------

class Finder {
 public:
  Finder(const Model& model, const Values& values) : model_(model), values_(values) {}

  /// All faces of that name.
  std::vector<Face> find(const std::string& name) {
    found_.clear();
    search(model_.objects.back(), Stand{}, name);
    return found_;
  }

 private:
  void search(const Object& o, const Stand& outer, const std::string& name) {
    const auto stand = stand_of(outer, o.frame, values_);
    if (!stand) return;
    const std::string feature = o.feature.empty() ? o.name : o.feature;
    std::visit(Overloaded{[&](const Union& s) { search_all(s.objects, *stand, name); },
                          [&](const Difference& s) { search_all(s.objects, *stand, name); },
                          [&](const Intersection& s) { search_all(s.objects, *stand, name); },
                          [&](const EdgeFillet& s) { search_all({s.object}, *stand, name); },
                          [&](const EdgeChamfer& s) { search_all({s.object}, *stand, name); },
                          [&](const auto& s) {
                            for (const auto& [face, local] : faces_of(s))
                              if (feature + " " + face == name || (model_.objects.size() == 1 && face == name))
                                found_.push_back(placed(local, *stand));
                          }},
               o.shape);
  }
  void search_all(const std::vector<std::string>& names, const Stand& stand, const std::string& name) {
    for (const auto& operand : names)
      for (const Object& o : model_.objects)
        if (o.name == operand) search(o, stand, name);
  }

  const Model& model_;
  const Values& values_;
  std::vector<Face> found_;
};

// ---- the tool -------------------------------------------------------------------------------------------------------

/// The corner that is filled or cut, from the edge at the origin: u along the first face, v along the second.
struct Profile {
  Expr along_first, along_second;
  bool round;
};

/// A loop of the profile with u and v running along given directions of a sketch from a given place, counter-clockwise.
Loop outline(const Profile& p, const Expr& x, const Expr& y, bool u_is_x, double u_sign, double v_sign,
             const Expr& beyond_u, const Expr& beyond_v, const char* role) {
  auto at = [&](const Expr& u, const Expr& v) {
    const Expr du = u_sign > 0 ? u : -u, dv = v_sign > 0 ? v : -v;
    return std::pair{x + (u_is_x ? du : dv), y + (u_is_x ? dv : du)};
  };
  auto point = [&](const Expr& u, const Expr& v, const char* edge) -> SketchElement {
    const auto [px, py] = at(u, v);
    return SketchPoint{px, py, edge};
  };
  // Which way round this runs in the sketch.
  const bool turned_over = (u_sign * v_sign > 0) != u_is_x;
  Loop loop{role, {}};
  auto& e = loop.elements;
  std::vector<SketchElement> slope;
  if (p.round) {
    const auto [cx, cy] = at(p.along_first, p.along_second);
    auto angle = [&](double u, double v) {
      const double du = u_sign * u, dv = v_sign * v;
      return u_is_x ? std::atan2(dv, du) : std::atan2(du, dv);
    };
    // From the point on the first face to that on the second: a quarter of a turn about the centre.
    double from = angle(0, -1), to = angle(-1, 0);
    if (to - from > pi) to -= 2 * pi;
    if (from - to > pi) to += 2 * pi;
    slope = {SketchArc{cx, cy, p.along_first, from, to, role, ""}};
  } else {
    slope = {point(p.along_first, 0, role), point(0, p.along_second, "")};
  }
  e.push_back(point(-beyond_u, -beyond_v, ""));
  e.push_back(point(p.along_first, -beyond_v, ""));
  e.insert(e.end(), slope.begin(), slope.end());
  e.push_back(point(-beyond_u, p.along_second, ""));
  if (turned_over) {
    std::reverse(e.begin(), e.end());
    for (auto& element : e) {
      if (auto* a = std::get_if<SketchArc>(&element)) std::swap(a->from, a->to);
      if (auto* q = std::get_if<SketchPoint>(&element)) q->edge.clear();
    }
    // From the second face to the first now, after the point beyond the edge and that above the second face.
    if (!p.round) std::get<SketchPoint>(e[1]).edge = role;
  }
  return loop;
}

class Maker {
 public:
  Maker(const Model& model, const Values& values)
      : model_(model), values_(values), part_(in_own_frame(model), values) {}

  std::variant<EdgeTool, std::string> make(const std::string& first, const std::string& second, const Profile& profile,
                                           const Expr& overshoot, const char* role) {
    Finder finder(model_, values_);
    std::array<Face, 2> faces;
    const std::string* names[2] = {&first, &second};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto found = finder.find(*names[i]);
      if (found.size() != 1)
        return "expected one plane or cylinder along the axes called '" + *names[i] + "', found " +
               print_number(double(found.size()));
      faces[i] = found[0];
    }
    if (faces[0].round && faces[1].round) return std::string("an edge between two cylinders cannot be worked on");
    if (faces[0].round || faces[1].round) {
      const bool first_round = faces[0].round;
      Profile p = profile;
      if (first_round) std::swap(p.along_first, p.along_second);
      return circle(first_round ? faces[1] : faces[0], first_round ? faces[0] : faces[1], p, overshoot, role);
    }
    return line(faces[0], faces[1], profile, overshoot, role);
  }

 private:
  static Model in_own_frame(Model m) {
    m.as_scanned = false;
    return m;
  }
  double value(const Expr& e) const { return evaluate(e, values_); }
  Vec3 value(const Vector& v) const { return {value(v[0]), value(v[1]), value(v[2])}; }

  /// Which of the four corners at an edge hold material; a and b are the directions between them.
  struct Corner {
    double a = 0, b = 0;  // signs of the one corner that differs from the other three
    bool convex = false;  // it is the only one with material
  };
  std::optional<Corner> corner_at(const Vec3& p, const Vec3& a, const Vec3& b) const {
    std::array<std::pair<double, double>, 4> signs{{{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
    std::vector<std::size_t> with, without;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool inside = part_(p + small * (signs[i].first * a + signs[i].second * b)).distance < 0;
      (inside ? with : without).push_back(i);
    }
    if (with.size() == 1) return Corner{signs[with[0]].first, signs[with[0]].second, true};
    if (without.size() == 1) return Corner{signs[without[0]].first, signs[without[0]].second, false};
    return {};
  }

  std::variant<EdgeTool, std::string> line(const Face& first, const Face& second, const Profile& profile,
                                           const Expr& overshoot, const char* role) const {
    if (first.axis == second.axis) return std::string("the two faces are parallel");
    const Axis k1 = first.axis, k2 = second.axis, k3 = 3 - k1 - k2;
    // The edge ends where the first of its faces ends.
    std::optional<Range> range;
    for (const Face* f : {&first, &second}) {
      const auto& r = f->ranges[k3];
      if (!r) continue;
      const bool forward = value(r->low) <= value(r->high);
      const Expr low = forward ? r->low : r->high, high = forward ? r->high : r->low;
      if (!range) range = Range{low, high};
      if (value(low) > value(range->low)) range->low = low;
      if (value(high) < value(range->high)) range->high = high;
    }
    if (!range || !(value(range->high) - value(range->low) > small))
      return std::string("the two faces have no edge in common");
    Vector start{0, 0, 0};
    start[k1] = first.point[k1], start[k2] = second.point[k2], start[k3] = range->low;
    Vec3 middle = value(start);
    middle[Eigen::Index(k3)] = (value(range->low) + value(range->high)) / 2;
    // Along the first face the edge's neighbourhood runs along the normal of the second.
    const auto corner = corner_at(middle, Vec3::Unit(Eigen::Index(k2)), Vec3::Unit(Eigen::Index(k1)));
    if (!corner) return std::string("the two faces do not meet in an edge");
    // A cut reaches out where it leaves the part, and stops where material begins.
    auto open = [&](const Expr& end, double sign) {
      if (!corner->convex) return false;
      Vec3 beyond = middle;
      beyond[Eigen::Index(k3)] = value(end) + sign * small;
      const Vec3 inward =
          3 * small * (corner->a * Vec3::Unit(Eigen::Index(k2)) + corner->b * Vec3::Unit(Eigen::Index(k1)));
      return part_(beyond - inward).distance > 0 && part_(beyond + inward).distance > 0;
    };
    const Expr low_end = open(range->low, -1) ? range->low - overshoot : range->low;
    const Expr high_end = open(range->high, 1) ? range->high + overshoot : range->high;
    start[k3] = low_end;
    // The sketch's axes are k1 and k2 in the order that leaves the third pointing along k3.
    const bool cyclic = (k1 + 1) % 3 == k2;
    const Axis kx = cyclic ? k1 : k2;
    // u runs along k2, the direction of the first face.
    Extrude body{{{outline(profile, 0, 0, kx == k2, corner->a, corner->b, overshoot, overshoot, role)}},
                 high_end - low_end};
    Frame frame{start[0], start[1], start[2], 0, 0, 0};
    if (kx == 1) frame.rx = pi / 2, frame.rz = pi / 2;  // x, y, z onto y, z, x
    if (kx == 2) frame.ry = -pi / 2, frame.rz = -pi / 2;
    return EdgeTool{{body, frame}, corner->convex};
  }

  std::variant<EdgeTool, std::string> circle(const Face& flat, const Face& round, const Profile& profile,
                                             const Expr& overshoot, const char* role) const {
    if (flat.axis != round.axis) return std::string("the plane does not cross the cylinder at a right angle");
    const Axis k = flat.axis;
    Vector center = round.point;
    center[k] = flat.point[k];
    const double radius = value(round.radius);
    // Any place on the circle will do, but one where another cut breaks it tells nothing: most of them decide.
    std::array<int, 8> votes{};
    constexpr int places = 16;
    const Vec3 axis = Vec3::Unit(Eigen::Index(k)), x = Vec3::Unit(Eigen::Index((k + 1) % 3)),
               y = Vec3::Unit(Eigen::Index((k + 2) % 3));
    for (int i = 0; i < places; ++i) {
      const double turn = 2 * pi * (i + 0.3) / places;
      const Vec3 out = std::cos(turn) * x + std::sin(turn) * y;
      if (const auto c = corner_at(value(center) + radius * out, out, axis))
        ++votes[std::size_t((c->a > 0) + 2 * (c->b > 0) + 4 * c->convex)];
    }
    const auto most = std::max_element(votes.begin(), votes.end());
    if (*most <= places / 2) return std::string("the plane and the cylinder do not meet in a full circle");
    const auto bits = std::size_t(most - votes.begin());
    const double radial = bits & 1 ? 1 : -1, axial = bits & 2 ? 1 : -1;
    // Turned profiles keep off the axis.
    const Expr beyond_u = radial > 0 && value(overshoot) >= radius ? round.radius / Expr(2) : overshoot;
    Revolve body{{{outline(profile, round.radius, 0, true, radial, axial, beyond_u, overshoot, role)}}};
    Frame frame{center[0], center[1], center[2], 0, 0, 0};
    if (k == 0) frame.ry = pi / 2;
    if (k == 1) frame.rx = -pi / 2;
    return EdgeTool{{body, frame}, bits >= 4};
  }

  static constexpr double small = 1e-4;  // mm, beside an edge

  const Model& model_;
  const Values& values_;
  ModelDistance part_;
};

}  // namespace

std::variant<EdgeTool, std::string> edge_tool(const Model& model, const Values& values, const EdgeFillet& edge) {
  return Maker(model, values)
      .make(edge.face_1, edge.face_2, {edge.radius, edge.radius, true}, edge.overshoot, "fillet");
}

std::variant<EdgeTool, std::string> edge_tool(const Model& model, const Values& values, const EdgeChamfer& edge) {
  return Maker(model, values)
      .make(edge.face_1, edge.face_2, {edge.leg_1, edge.leg_2, false}, edge.overshoot, "chamfer");
}

}  // namespace partscribe::model
