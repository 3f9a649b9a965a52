#include "fit/propose/drill.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/number.h"
#include "fit/refine/refine.h"
#include "fit/sketch/length_parameter.h"
#include "geometry/segment/round_pieces.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

constexpr double sigmas = 4;   // within which two numbers of holes are the same
constexpr double fine = 0.05;  // of the tolerance: what is closer is the same, however certain
constexpr std::array<const char*, 3> letters = {"x", "y", "z"};

/// A hole in the body's frame, along one of its axes.
struct Placed {
  const DrilledHole* hole;
  int axis = 2;       // of the body that it runs along
  double sense = 1;   // +1: it opens in the direction of that axis
  Vec3 place;         // of its axis; the coordinate along it means nothing
  double mouth, end;  // where the body begins and ends, along `sense` times the axis

  double across(int k) const { return place[(axis + 1 + k) % 3]; }
};

/// A plain hole through everything has no upper side.
bool plain(const DrilledHole& hole) {
  return hole.form.through && !(hole.form.head_diameter > 0) && !(hole.form.sink_diameter > 0);
}

/// The turn that points z along an axis of the body.
Frame turned_to(int axis, double sense) {
  Frame frame;
  if (axis == 0) frame.ry = sense * pi / 2;
  if (axis == 1) frame.rx = -sense * pi / 2;
  if (axis == 2 && sense < 0) frame.rx = pi;
  return frame;
}

bool turned_about_z(const Shape& shape) {
  const auto* turned = std::get_if<Revolve>(&shape);
  return turned ? turned->angle.is_number() && turned->angle.number >= 2 * pi - 1e-9
                : std::holds_alternative<Cylinder>(shape) || std::holds_alternative<Cone>(shape);
}

class Drilling {
 public:
  Drilling(const Candidate& body, const std::vector<DrilledHole>& holes, const DrillOptions& options)
      : part_(body),
        tolerance_(options.tolerance),
        alike_(std::max(options.alike, fine * tolerance_)),
        end_(options.end) {
    part_.steps = {{body.object_name, body.shape, {}, {}, "the body before it is drilled"}};
    if (std::holds_alternative<Box>(body.shape))
      centre_box(holes);
    else
      known_by(body.shape);
    part_.procedure = "body with holes", part_.object_name = "drilled_" + part_.steps[0].name;
    part_.otherwise.reset();
    cut_.objects = {part_.steps[0].name};
    values_ = values_of(part_);
    Model alone;
    alone.parameters = part_.parameters, alone.objects = part_.steps, alone.as_scanned = false;
    distance_.emplace(alone);
  }

  /// False if a hole cannot be told by this body.
  bool drill(const std::vector<DrilledHole>& holes) {
    face_first(holes);
    std::vector<Placed> placed;
    for (const DrilledHole& hole : holes) {
      const auto p = placed_in_body(hole);
      if (!p) return false;
      placed.push_back(*p);
    }
    std::vector<std::vector<Placed>> groups;
    while (!placed.empty()) {
      const Placed first = placed.front();
      std::vector<Placed> group;
      std::erase_if(placed, [&](const Placed& p) {
        if (!alike(first, p)) return false;
        group.push_back(p);
        return true;
      });
      groups.push_back(std::move(group));
    }
    std::ranges::stable_sort(groups, [](const auto& a, const auto& b) { return a.size() > b.size(); });
    for (const auto& group : groups) cut(group, role_of(group, groups));
    return true;
  }

  Candidate done() {
    part_.shape = std::move(cut_);
    return std::move(part_);
  }

 private:
  Candidate part_;
  double tolerance_, alike_, end_;
  Values values_;
  std::optional<ModelDistance> distance_;
  Difference cut_;
  std::array<std::vector<Expr>, 3> edges_, middles_;  // coordinates along each axis that the body's own numbers give

  const Shape& body() const { return part_.steps[0].shape; }

  /// A low box is a plate and lies flat. Of others z is the axis that most holes run along, of several the shortest
  /// side. Holes open upwards. The origin stands in the middle of the base.
  void centre_box(const std::vector<DrilledHole>& holes) {
    Object& step = part_.steps[0];
    Box& box = std::get<Box>(step.shape);
    Pose& pose = part_.scan_from_part;
    const Values values = values_of(part_);
    const std::array<Expr, 3> sides = {box.size_x, box.size_y, box.size_z};
    Vec3 size, along = Vec3::Zero(), open = Vec3::Zero();
    for (int k = 0; k < 3; ++k) size[k] = evaluate(sides[static_cast<std::size_t>(k)], values);
    for (const DrilledHole& hole : holes) {
      const Vec3 out = pose.rotation.transpose() * hole.out;
      int k = 0;
      out.cwiseAbs().maxCoeff(&k);
      along[k] += 1, open[k] += plain(hole) ? 0 : out[k];
    }
    std::array<int, 3> axes = {0, 1, 2};  // old ones, as x, y, z
    std::ranges::sort(axes, [&](int a, int b) { return size[a] > size[b]; });
    const bool plate = size[axes[2]] < height_of_plate * size[axes[1]];
    if (!plate) std::ranges::stable_sort(axes, [&](int a, int b) { return along[a] < along[b]; });
    if (size[axes[0]] < size[axes[1]]) std::swap(axes[0], axes[1]);
    const auto side = [&](int k) { return sides[static_cast<std::size_t>(axes[static_cast<std::size_t>(k)])]; };
    const Vec3 middle = pose * (size / 2), x = pose.rotation.col(axes[0]),
               z = (open[axes[2]] < 0 ? -1 : 1) * pose.rotation.col(axes[2]);
    pose.rotation << x, z.cross(x), z;
    pose.translation = middle - size[axes[2]] / 2 * z;
    box = {side(0), side(1), side(2)};
    if (plate) step.name = "plate";
    name_sides(box, {"length", "width", plate ? "thickness" : "height"});
    step.frame.x = -(box.size_x / Expr(2)), step.frame.y = -(box.size_y / Expr(2));
    const std::array<Expr, 2> half = {box.size_x / Expr(2), box.size_y / Expr(2)};
    for (const std::size_t axis : {0, 1}) edges_[axis] = {half[axis], -half[axis]};
    edges_[2] = {box.size_z}, middles_[2] = {box.size_z / Expr(2)};
  }

  /// In this order, before all other numbers. Sides that share a number keep their names.
  void name_sides(Box& box, const std::array<std::string, 3>& names) {
    std::vector<Parameter> named;
    for (Expr* side : {&box.size_x, &box.size_y, &box.size_z}) {
      const auto p = std::ranges::find(part_.parameters, side->parameter, &Parameter::name);
      if (!side->is_parameter() || p == part_.parameters.end()) return;
      const bool again = std::ranges::any_of(named, [&](const Parameter& n) { return n.name == p->name; });
      if (again) return;
      named.push_back(*p);
    }
    if (part_.parameters.size() != named.size()) return;
    for (HeldParameter& held : part_.held)
      for (std::size_t k = 0; k < 3; ++k)
        if (held.name == named[k].name) {
          held.name = names[k];
          break;
        }
    for (std::size_t k = 0; k < 3; ++k)
      named[k].name = names[k], named[k].note = names[k] + " of the " + part_.steps[0].name;
    box = {Expr::of(names[0]), Expr::of(names[1]), Expr::of(names[2])};
    part_.parameters = std::move(named);
  }

  /// A sketch's numbers by its two coordinates, of which the first runs across a turned body; a height along z.
  void known_by(const Shape& shape) {
    const auto* plate = std::get_if<Extrude>(&shape);
    const auto* turned = std::get_if<Revolve>(&shape);
    if (!plate && !turned) {
      visit_expressions(shape, [&](const Expr& e, Domain domain) {
        if (domain == Domain::length) know({0, 1, 2}, e, false);
      });
      return;
    }
    const auto know_place = [&](const Expr& x, const Expr& y) {
      if (turned)
        know({0, 1}, x, true), know({2}, y, true);
      else
        know({0}, x, true), know({1}, y, true);
    };
    for (const Loop& loop : (plate ? plate->sketch : turned->sketch).loops)
      for (const SketchElement& element : loop.elements) {
        if (const auto* point = std::get_if<SketchPoint>(&element)) know_place(point->x, point->y);
        if (const auto* arc = std::get_if<SketchArc>(&element)) know_place(arc->center_x, arc->center_y);
      }
    if (plate) know({2}, plate->height, false);
  }

  void know(std::initializer_list<std::size_t> axes, const Expr& e, bool as_middle) {
    if (e.is_number()) return;
    for (const std::size_t axis : axes) {
      edges_[axis].push_back(e), edges_[axis].push_back(-e);
      if (as_middle) middles_[axis].push_back(e);
      middles_[axis].push_back(e / Expr(2)), middles_[axis].push_back(-(e / Expr(2)));
    }
  }

  /// A body that may be turned about its axis is turned until the first hole beside the axis lies on x.
  void face_first(const std::vector<DrilledHole>& holes) {
    if (!turned_about_z(body())) return;
    const Pose part_from_scan = part_.scan_from_part.inverse();
    for (const DrilledHole& hole : holes) {
      const Vec3 out = part_from_scan.rotation * hole.out, mouth = part_from_scan * hole.mouth;
      const Vec2 beside = std::abs(out.z()) < 0.5 ? out.head<2>() : mouth.head<2>();
      if (beside.norm() <= tolerance_) continue;
      part_.scan_from_part.rotation =
          part_.scan_from_part.rotation * rotation_of(Vec3(0, 0, std::atan2(beside.y(), beside.x())));
      return;
    }
  }

  std::optional<Placed> placed_in_body(const DrilledHole& hole) const {
    const Pose part_from_scan = part_.scan_from_part.inverse();
    const Vec3 out = part_from_scan.rotation * hole.out;
    Placed p{&hole, 0, 1, part_from_scan * hole.point, 0, 0};
    out.cwiseAbs().maxCoeff(&p.axis);
    p.sense = out[p.axis] > 0 ? 1 : -1;
    const Vec3 along = p.sense * Vec3::Unit(p.axis);
    const double aslant = (out - along).norm();
    if (aslant > sigmas * hole.sigma_axis && aslant * hole.form.depth > tolerance_) return std::nullopt;
    const double mouth = p.sense * (part_from_scan * hole.mouth)[p.axis];
    Vec3 middle = p.place;
    middle[p.axis] = p.sense * (mouth - 0.5 * hole.form.depth);
    if (!((*distance_)(middle).distance < 0)) return std::nullopt;
    // Where the body ends, in the middle of the hole and around it.
    const double radius = 0.5 * std::max({hole.form.diameter, hole.form.head_diameter, hole.form.sink_diameter});
    const Vec3 x = along.unitOrthogonal(), y = along.cross(x);
    p.mouth = -1e300, p.end = 1e300;
    for (int k = 0; k <= 8; ++k) {
      const double turn = k * pi / 4;
      const Vec3 start = middle + (k < 8 ? radius : 0) * (std::cos(turn) * x + std::sin(turn) * y);
      if (!((*distance_)(start).distance < 0)) continue;
      const double at = p.sense * start[p.axis];
      p.mouth = std::max(p.mouth, at + way_out(start, along)), p.end = std::min(p.end, at - way_out(start, -along));
    }
    if (hole.form.through) {
      if (plain(hole) && p.sense < 0) p.sense = 1, std::swap(p.mouth, p.end), p.mouth = -p.mouth, p.end = -p.end;
    } else {
      p.end = mouth - hole.form.depth;
    }
    return p;
  }

  /// mm from inside of the body to its surface.
  double way_out(const Vec3& from, const Vec3& along) const {
    double way = 0;
    for (int step = 0; step < 200; ++step) {
      const double d = (*distance_)(from + way * along).distance;
      if (d > -1e-6 * tolerance_) break;
      way -= d;
    }
    return way;
  }

  /// Of equal sizes, along one axis, through the same faces.
  bool alike(const Placed& a, const Placed& b) const {
    const HoleOf<double>&f = a.hole->form, &g = b.hole->form;
    if (a.axis != b.axis || a.sense != b.sense || f.through != g.through) return false;
    const bool ends = std::abs(a.end - b.end) <= tolerance_ || !a.hole->floor_seen || !b.hole->floor_seen;
    if (std::abs(a.mouth - b.mouth) > tolerance_ || !ends) return false;
    return about_equal(f.diameter, a.hole->sigma, g.diameter, b.hole->sigma, alike_) &&
           (f.head_diameter > 0) == (g.head_diameter > 0) && (f.sink_diameter > 0) == (g.sink_diameter > 0) &&
           std::abs(f.head_diameter - g.head_diameter) < tolerance_ &&
           std::abs(f.sink_diameter - g.sink_diameter) < tolerance_;
  }

  std::string unused(const std::string& name) const {
    const auto taken = [&](const std::string& n) {
      return n == part_.object_name ||
             std::ranges::any_of(part_.parameters, [&](const Parameter& p) { return p.name == n; }) ||
             std::ranges::any_of(part_.steps, [&](const Object& o) { return o.name == n; });
    };
    if (!taken(name)) return name;
    for (int k = 2;; ++k)
      if (const std::string n = name + "_" + std::to_string(k); !taken(n)) return n;
  }

  Expr parameter(const std::string& name, double value, const std::string& note, Quantity quantity = Quantity::length) {
    Parameter p = length_parameter(unused(name), value, note);
    p.quantity = quantity;
    part_.parameters.push_back(p);
    return Expr::of(p.name);
  }

  /// mm: within which two places are the same.
  double within_of(double sigma) const { return std::max(sigmas * sigma, alike_); }

  /// A coordinate by the body's own numbers, if they have it.
  std::optional<Expr> by_body(double at, double within, const std::vector<Expr>& known) const {
    if (std::abs(at) <= within) return Expr(0);
    const auto found =
        std::ranges::find_if(known, [&](const Expr& e) { return std::abs(evaluate(e, values_) - at) <= within; });
    return found == known.end() ? std::nullopt : std::optional(*found);
  }

  Expr edge(int axis, double at, const std::string& name) {
    if (const auto known = by_body(at, tolerance_, edges_[std::size_t(axis)])) return *known;
    return parameter(name, at, "where it opens");
  }

  Expr coordinate(int axis, double at, double sigma, const std::string& name, const std::string& note) {
    if (const auto known = by_body(at, within_of(sigma), middles_[std::size_t(axis)])) return *known;
    const Expr place = parameter(name, at, note);
    values_[place.parameter] = at, middles_[std::size_t(axis)].push_back(place);  // later holes may stand there too
    return place;
  }

  /// The step of one hole, its mouth at z = 0.
  Hole hole_of(const std::vector<Placed>& group, const std::string& role, const Expr& depth) {
    const auto mean = [&](double HoleOf<double>::*size) {
      double sum = 0;
      for (const Placed& p : group) sum += p.hole->form.*size;
      return sum / double(group.size());
    };
    const HoleOf<double>& form = group.front().hole->form;
    Hole hole;
    hole.diameter =
        parameter(role + "_d", mean(&HoleOf<double>::diameter), "diameter of the " + said(role, group.size()));
    hole.depth = depth, hole.through = form.through;
    if (form.tip_angle > 0)
      hole.tip_angle =
          parameter(role + "_tip_angle", mean(&HoleOf<double>::tip_angle), "of the drill", Quantity::angle);
    if (form.head_diameter > 0) {
      hole.head_diameter = parameter("head_d", mean(&HoleOf<double>::head_diameter), "diameter of the counterbore");
      hole.head_depth = parameter("head_depth", mean(&HoleOf<double>::head_depth), "depth of the counterbore");
    }
    if (form.sink_diameter > 0) {
      hole.sink_diameter =
          parameter("sink_d", mean(&HoleOf<double>::sink_diameter), "diameter of the countersink at the face");
      hole.sink_angle =
          parameter("sink_angle", mean(&HoleOf<double>::sink_angle), "whole angle of the countersink", Quantity::angle);
    }
    return hole;
  }

  /// "hole_2" as "holes_2".
  static std::string several(const std::string& name) {
    const auto number = name.find_last_not_of("0123456789");
    if (number + 1 == name.size() || name[number] != '_') return name + "s";
    return name.substr(0, number) + "s" + name.substr(number);
  }

  /// A name in words.
  static std::string said(const std::string& name, std::size_t count) {
    std::string text = count > 1 ? several(name) : name;
    std::ranges::replace(text, '_', ' ');
    return text;
  }

  /// What a group is for: screws, where it has heads; a bore, if it is one hole, on the axis or wider than all others.
  std::string role_of(const std::vector<Placed>& group, const std::vector<std::vector<Placed>>& groups) const {
    const HoleOf<double>& form = group.front().hole->form;
    if (form.head_diameter > 0 || form.sink_diameter > 0) return "screw_hole";
    const Placed& first = group.front();
    const bool on_axis = first.axis == 2 && first.place.head<2>().norm() < tolerance_;
    const bool widest = groups.size() > 1 && std::ranges::all_of(groups, [&](const auto& other) {
                          return &other == &group || other.front().hole->form.diameter < form.diameter;
                        });
    return group.size() == 1 && (on_axis || widest) ? "bore" : "hole";
  }

  void cut(const std::vector<Placed>& group, const std::string& wanted) {
    const HoleOf<double>& form = group.front().hole->form;
    const Placed& first = group.front();
    const std::string role = unused(wanted);
    double mouth_at = 0, end_at = 0;
    // Of floors that were not seen the deepest is the best guess.
    std::vector<double> floors, guesses;
    for (const Placed& p : group) {
      mouth_at += p.mouth / double(group.size());
      (p.hole->floor_seen ? floors : guesses).push_back(p.end);
    }
    if (floors.empty()) floors = {*std::ranges::min_element(guesses)};
    for (const double end : floors) end_at += end / double(floors.size());
    const Expr mouth = edge(first.axis, first.sense * mouth_at, role + "_face");
    Expr depth;
    if (form.through) {
      const Expr end = edge(first.axis, first.sense * end_at, role + "_end");
      depth = first.sense > 0 ? mouth - end : end - mouth;
    } else {
      depth = parameter(role + "_depth", mouth_at - end_at, "depth of the " + said(role, group.size()));
      if (std::ranges::none_of(group, [](const Placed& p) { return p.hole->floor_seen; }))
        part_.held.push_back({depth.parameter, end_});
    }
    const Hole hole = hole_of(group, role, depth);
    // A square of four may be either: what the body is itself.
    const bool turned = turned_about_z(body());
    if ((turned && circle(group, hole, role, mouth)) || grid(group, hole, role, mouth) ||
        (!turned && circle(group, hole, role, mouth)))
      return;
    for (const Placed& p : group) {
      const std::string name = unused(role);
      std::array<Expr, 2> at;
      for (int k = 0; k < 2; ++k)
        at[static_cast<std::size_t>(k)] =
            coordinate((p.axis + 1 + k) % 3, p.across(k), p.hole->sigma,
                       name + "_" + letters[static_cast<std::size_t>((p.axis + 1 + k) % 3)], "place of its axis");
      step(name, hole, frame_at(p, at, mouth), "the " + said(name, 1));
      cut_.objects.push_back(name);
    }
  }

  Frame frame_at(const Placed& p, const std::array<Expr, 2>& across, const Expr& along) const {
    Frame frame = turned_to(p.axis, p.sense);
    std::array<Expr*, 3> at = {&frame.x, &frame.y, &frame.z};
    *at[static_cast<std::size_t>(p.axis)] = along;
    for (int k = 0; k < 2; ++k)
      *at[static_cast<std::size_t>((p.axis + 1 + k) % 3)] = across[static_cast<std::size_t>(k)];
    return frame;
  }

  void step(const std::string& name, Shape shape, Frame frame, const std::string& note) {
    part_.steps.push_back({name, std::move(shape), std::move(frame), {}, note});
  }

  /// Equally spaced on a circle.
  bool circle(const std::vector<Placed>& group, const Hole& hole, const std::string& role, const Expr& mouth) {
    const auto n = group.size();
    if (n < 3) return false;
    const Placed& first = group.front();
    Vec3 middle = Vec3::Zero();
    double sigma = 0, radius = 0;
    for (const Placed& p : group) middle += p.place / double(n), sigma = std::max(sigma, p.hole->sigma);
    middle[first.axis] = 0;
    const double within = within_of(sigma);
    // The frame of the circle, as the pattern's own turn gives it.
    const Mat3 turn = evaluate(turned_to(first.axis, first.sense), {}).rotation;
    std::vector<std::pair<double, std::size_t>> turns;
    std::vector<double> radii;
    for (std::size_t i = 0; i < n; ++i) {
      Vec3 d = group[i].place - middle;
      d[first.axis] = 0;
      const Vec3 q = turn.transpose() * d;
      radii.push_back(q.head<2>().norm()), turns.emplace_back(std::atan2(q.y(), q.x()), i);
    }
    for (const double r : radii) radius += r / double(n);
    std::ranges::sort(turns);
    double start = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double off = turns[i].first - turns[0].first - 2 * pi * double(i) / double(n);
      if (std::abs(radii[i] - radius) > within || std::abs(off) * radius > 2 * within) return false;
      start += (turns[i].first - 2 * pi * double(i) / double(n)) / double(n);
    }
    // A turn by whole steps changes nothing: the least one.
    start -= std::round(start * double(n) / (2 * pi)) * 2 * pi / double(n);
    std::array<Expr, 2> centre;
    for (int k = 0; k < 2; ++k) {
      const int axis = (first.axis + 1 + k) % 3;
      centre[static_cast<std::size_t>(k)] =
          coordinate(axis, middle[axis], sigma, std::string("bolt_circle_") + letters[static_cast<std::size_t>(axis)],
                     "centre of the bolt circle");
    }
    const Expr diameter = parameter("bolt_circle_d", 2 * radius, "diameter of the bolt circle");
    const Expr count = parameter(several(role), double(n), "number of " + said(role, group.size()), Quantity::count);
    Frame of_hole;
    of_hole.x = diameter / Expr(2);
    if (std::abs(start) * radius > within) {
      // Holes on both sides of an axis, or turned by an angle of their own.
      const bool between = std::abs(std::abs(start) - pi / double(n)) * radius <= within;
      const Expr angle =
          between ? Expr(pi) / count
                  : parameter("bolt_circle_angle", start, "from the axis to the first hole", Quantity::angle);
      of_hole.y = of_hole.x * Expr::call(Expr::Kind::sin, {angle});
      of_hole.x = of_hole.x * Expr::call(Expr::Kind::cos, {angle});
    }
    step(role, hole, of_hole, "one " + said(role, 1));
    const std::string pattern = unused("bolt_holes");
    step(pattern, CircularPattern{role, count, Expr(2 * pi) / count}, frame_at(first, centre, mouth), "all of them");
    cut_.objects.push_back(pattern);
    return true;
  }

  /// Rows and columns along the body's axes, every place taken.
  bool grid(const std::vector<Placed>& group, const Hole& hole, const std::string& role, const Expr& mouth) {
    if (group.size() < 2) return false;
    const Placed& first = group.front();
    double sigma = 0;
    for (const Placed& p : group) sigma = std::max(sigma, p.hole->sigma);
    const double within = within_of(sigma);
    std::array<std::vector<double>, 2> lines;  // places of columns and rows
    for (int k = 0; k < 2; ++k) {
      auto& places = lines[static_cast<std::size_t>(k)];
      std::vector<double> all;
      for (const Placed& p : group) all.push_back(p.across(k));
      std::ranges::sort(all);
      std::size_t from = 0;
      for (std::size_t i = 1; i <= all.size(); ++i) {
        if (i < all.size() && all[i] - all[i - 1] <= 2 * within) continue;
        double sum = 0;
        for (std::size_t j = from; j < i; ++j) sum += all[j];
        places.push_back(sum / double(i - from)), from = i;
      }
    }
    if (lines[0].size() * lines[1].size() != group.size()) return false;
    for (const auto& places : lines)
      for (std::size_t i = 2; i < places.size(); ++i)
        if (std::abs(places[i] - places[i - 1] - places[1] + places[0]) > 2 * within) return false;
    std::array<Expr, 2> start, pitch;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& places = lines[k];
      const int axis = (first.axis + 1 + int(k)) % 3;
      const std::string letter = letters[std::size_t(axis)];
      const double centre = 0.5 * (places.front() + places.back());
      const Expr at =
          coordinate(axis, centre, sigma, several(role) + "_" + letter, "middle of the " + said(role, group.size()));
      start[k] = at;
      if (places.size() < 2) continue;
      pitch[k] = parameter("pitch_" + letter, (places.back() - places.front()) / double(places.size() - 1),
                           "from hole to hole along " + letter);
      const Expr steps = double(places.size() - 1);
      start[k] = at - (places.size() == 2 ? pitch[k] : steps * pitch[k]) / Expr(2);
    }
    std::string name = role;
    step(name, hole, frame_at(first, start, mouth), "one " + said(role, 1));
    for (std::size_t k = 0; k < 2; ++k) {
      if (lines[k].size() < 2) continue;
      const auto axis = (static_cast<std::size_t>(first.axis) + 1 + k) % 3;
      LinearPattern row;
      row.object = name, row.count = Expr(double(lines[k].size()));
      std::array<Expr*, 3> steps = {&row.step_x, &row.step_y, &row.step_z};
      *steps[axis] = pitch[k];
      name = unused(lines[1 - k].size() > 1 && k == 0 ? role + "_row" : several(role));
      step(name, row, {}, "along " + std::string(letters[axis]));
    }
    cut_.objects.push_back(name);
    return true;
  }
};

}  // namespace

bool in_sketch(const Candidate& body, const std::vector<DrilledHole>& holes) {
  constexpr double along = 0.99;  // cosine
  const Vec3 z = body.scan_from_part.rotation.col(2);
  return std::holds_alternative<Extrude>(body.shape) && std::ranges::all_of(holes, [&](const DrilledHole& hole) {
           return plain(hole) && std::abs(hole.out.dot(z)) > along;
         });
}

std::optional<Candidate> with_holes(const Candidate& body, const std::vector<DrilledHole>& holes,
                                    const DrillOptions& options) {
  Drilling drilling(body, holes, options);
  if (!drilling.drill(holes)) return std::nullopt;
  return drilling.done();
}

}  // namespace partscribe::fit
