#include "verify/mutate/mutate_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"

namespace partscribe::verify {
namespace {

using Kind = Mutation::Kind;

bool open_sheet(const Model& model) { return is_sheet(model.objects.back().shape); }

Pose part_from_surface(const Model& model) {
  return model.as_scanned ? evaluate(model.scan_from_part, values_of(model)).inverse() : Pose{};
}

/// A circle on the surface that is nearly flat, with room above it and material below.
struct FlatSpot {
  Vec3 at, normal;
};

/// Up to two of them, far from each other.
std::vector<FlatSpot> spots(const Gauge& gauge, double radius, double height, double depth) {
  const ModelDistance& distance = gauge.distance();
  std::vector<FlatSpot> found;
  for (const auto& p : gauge.points()) {
    if (distance(p.point + height * p.normal).distance < 0.6 * height) continue;
    if (distance(p.point - depth * p.normal).distance > -0.4 * depth) continue;
    const Vec3 u = p.normal.unitOrthogonal(), v = p.normal.cross(u);
    bool flat = true;
    for (int k = 0; k < 8 && flat; ++k) {
      const Vec3 rim = p.point + radius * (std::cos(k * pi / 4) * u + std::sin(k * pi / 4) * v);
      flat = std::abs(distance(rim).distance) < 0.25 * radius &&
             distance(rim + height * p.normal).distance > 0.5 * height && distance(rim - depth * p.normal).distance < 0;
    }
    if (flat) found.push_back({p.point, p.normal});
  }
  if (found.size() < 2) return found;
  const Vec3 first = found[0].at;
  std::iter_swap(found.begin() + 1,
                 std::max_element(found.begin() + 1, found.end(), [&](const FlatSpot& a, const FlatSpot& b) {
                   return (a.at - first).squaredNorm() < (b.at - first).squaredNorm();
                 }));
  found.resize(2);
  return found;
}

/// The part combined with one more object by S.
template <class S>
Model combined_with(const Model& model, const std::string& name, Shape shape, const Pose& part_from_object) {
  Model result = model;
  Object extra;
  extra.name = name;
  extra.shape = std::move(shape);
  extra.frame = frame_of(part_from_object);
  Object all;
  all.name = "damaged_part";
  all.shape = S{{model.objects.back().name, name}};
  result.objects.push_back(std::move(extra));
  result.objects.push_back(std::move(all));
  return result;
}

std::size_t index_of(const Model& model, const std::string& name) {
  std::size_t i = 0;
  while (model.objects[i].name != name) ++i;
  return i;
}

/// A cylinder that is cut away from something.
struct Bore {
  std::size_t object, cut;  // the cylinder, the difference
};

std::vector<Bore> bores_of(const Model& model) {
  std::vector<Bore> bores;
  for (std::size_t d = 0; d < model.objects.size(); ++d)
    if (const auto* cut = std::get_if<Difference>(&model.objects[d].shape))
      for (std::size_t i = 1; i < cut->objects.size(); ++i)
        if (const std::size_t o = index_of(model, cut->objects[i]);
            std::holds_alternative<Cylinder>(model.objects[o].shape))
          bores.push_back({o, d});
  return bores;
}

/// A round hole in the sketch of an extrusion that is the whole part.
struct RoundLoop {
  std::size_t loop;
  double x, y, radius;
};

std::vector<RoundLoop> round_loops(const Model& model) {
  std::vector<RoundLoop> result;
  const auto* extrude = std::get_if<Extrude>(&model.objects.back().shape);
  if (!extrude) return result;
  const Values values = values_of(model);
  const auto& loops = extrude->sketch.loops;
  for (std::size_t l = 1; l < loops.size(); ++l)
    if (const auto* arc = std::get_if<SketchArc>(&loops[l].elements[0]); arc && loops[l].elements.size() == 1)
      result.push_back(
          {l, evaluate(arc->center_x, values), evaluate(arc->center_y, values), evaluate(arc->radius, values)});
  return result;
}

// ---- holes ----------------------------------------------------------------------------------------------------------

void doubled_holes(const Model& model, std::vector<Edit>& edits) {
  const Values values = values_of(model);
  for (const Bore& bore : bores_of(model)) {
    Model m = model;
    Object copy = m.objects[bore.object];
    const double radius = evaluate(std::get<Cylinder>(copy.shape).radius, values);
    copy.frame = frame_of(evaluate(copy.frame, values) * shift({0.7 * radius, 0, 0}));
    copy.name += "_again";
    std::get<Difference>(m.objects[bore.cut].shape).objects.push_back(copy.name);
    m.objects.insert(m.objects.begin() + long(bore.object) + 1, copy);
    edits.push_back({Kind::hole_doubled, model.objects[bore.object].name + " twice", std::move(m)});
  }
  for (const RoundLoop& hole : round_loops(model)) {
    const auto& last = model.objects.back();
    const double height = evaluate(std::get<Extrude>(last.shape).height, values);
    const Pose there = evaluate(last.frame, values) * shift({hole.x + 0.7 * hole.radius, hole.y, -0.1 * height});
    edits.push_back({Kind::hole_doubled, quoted(std::get<Extrude>(last.shape).sketch.loops[hole.loop].name) + " twice",
                     combined_with<Difference>(model, "hole_again", Cylinder{hole.radius, 1.2 * height}, there)});
  }
}

void wrong_depths(const Model& model, std::vector<Edit>& edits) {
  const Values values = values_of(model);
  for (const Bore& bore : bores_of(model)) {
    const double height = evaluate(std::get<Cylinder>(model.objects[bore.object].shape).height, values);
    // From either end; a change that the part does not show is dropped by the caller.
    for (const double factor : {0.6, 3.0})
      for (const bool far_end : {false, true}) {
        Model m = model;
        Object& o = m.objects[bore.object];
        std::get<Cylinder>(o.shape).height = factor * height;
        if (far_end) o.frame = frame_of(evaluate(o.frame, values) * shift({0, 0, (1 - factor) * height}));
        edits.push_back({Kind::hole_depth,
                         o.name + (factor < 1 ? " less deep" : " deeper") + (far_end ? " at its foot" : " at its top"),
                         std::move(m)});
      }
  }
  for (const RoundLoop& hole : round_loops(model)) {
    Model m = model;
    auto& last = m.objects.back();
    auto& extrude = std::get<Extrude>(last.shape);
    const std::string name = extrude.sketch.loops[hole.loop].name;
    const double height = evaluate(extrude.height, values);
    extrude.sketch.loops.erase(extrude.sketch.loops.begin() + long(hole.loop));
    const Pose there = evaluate(last.frame, values) * shift({hole.x, hole.y, 0.4 * height});
    edits.push_back({Kind::hole_depth, quoted(name) + " blind",
                     combined_with<Difference>(m, "blind_hole", Cylinder{hole.radius, 0.8 * height}, there)});
  }
}

void own_diameters(const Model& model, std::vector<SizedEdit>& edits) {
  auto add = [&](const std::string& name, std::function<Expr*(Model&)> radius) {
    edits.push_back({Kind::hole_size, "radius of " + name + " alone", 2 * model.tolerance, true,
                     [&model, radius = std::move(radius)](double size) -> std::optional<Model> {
                       Model m = model;
                       Expr& r = *radius(m);
                       r = r + Expr(size);
                       return m;
                     }});
  };
  for (const Bore& bore : bores_of(model))
    add(model.objects[bore.object].name,
        [o = bore.object](Model& m) { return &std::get<Cylinder>(m.objects[o].shape).radius; });
  for (const RoundLoop& hole : round_loops(model))
    add(quoted(std::get<Extrude>(model.objects.back().shape).sketch.loops[hole.loop].name), [l = hole.loop](Model& m) {
      auto& loop = std::get<Extrude>(m.objects.back().shape).sketch.loops[l];
      return &std::get<SketchArc>(loop.elements[0]).radius;
    });
}

// ---- edges and walls ------------------------------------------------------------------------------------------------

/// The same solid as a sketch, where it has edges that can be rounded.
std::optional<Shape> as_sketched(const Shape& shape) {
  auto loop = [](std::vector<std::pair<Expr, Expr>> corners) {
    Loop l{"outline", {}};
    for (auto& [x, y] : corners) l.elements.push_back(SketchPoint{x, y, ""});
    return Sketch{{l}};
  };
  if (const auto* b = std::get_if<Box>(&shape))
    return Extrude{loop({{0, 0}, {b->size_x, 0}, {b->size_x, b->size_y}, {0, b->size_y}}), b->size_z};
  if (const auto* c = std::get_if<Cylinder>(&shape))
    return Revolve{loop({{0, 0}, {c->radius, 0}, {c->radius, c->height}, {0, c->height}})};
  if (const auto* c = std::get_if<Cone>(&shape); c && !(c->top_radius == Expr(0)) && !(c->bottom_radius == Expr(0)))
    return Revolve{loop({{0, 0}, {c->bottom_radius, 0}, {c->top_radius, c->height}, {0, c->height}})};
  if (sketch_of(shape)) return shape;
  return {};
}

struct Ends {
  Vec2 first, last;
  bool known = true;  // false: a spline, whose ends are its control points all the same but whose edge is no corner
};

Ends ends_of(const SketchElement& element, const Values& values) {
  if (const auto* p = std::get_if<SketchPoint>(&element)) {
    const Vec2 at(evaluate(p->x, values), evaluate(p->y, values));
    return {at, at};
  }
  if (const auto* a = std::get_if<SketchArc>(&element)) {
    const Vec2 center(evaluate(a->center_x, values), evaluate(a->center_y, values));
    const double r = evaluate(a->radius, values), from = evaluate(a->from, values), to = evaluate(a->to, values);
    return {center + r * Vec2(std::cos(from), std::sin(from)), center + r * Vec2(std::cos(to), std::sin(to))};
  }
  return {Vec2::Zero(), Vec2::Zero(), false};
}

void rounded_edges(const Model& model, std::vector<SizedEdit>& edits) {
  const Values values = values_of(model);
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const auto shape = as_sketched(model.objects[o].shape);
    if (!shape) continue;
    const bool turned = std::holds_alternative<Revolve>(*shape);
    const auto& loops = sketch_of(*shape)->loops;
    for (std::size_t l = 0; l < loops.size(); ++l) {
      const auto& elements = loops[l].elements;
      for (std::size_t e = 0; e < elements.size(); ++e) {
        const auto* corner = std::get_if<SketchPoint>(&elements[e]);
        const Ends before = ends_of(elements[(e + elements.size() - 1) % elements.size()], values);
        const Ends after = ends_of(elements[(e + 1) % elements.size()], values);
        if (!corner || !before.known || !after.known) continue;
        const Vec2 at = ends_of(elements[e], values).first;
        if (turned && std::abs(at.x()) < 1e-9) continue;
        const Vec2 in = (at - before.last).normalized(), out = (after.first - at).normalized();
        const double room = 0.9 * std::min((at - before.last).norm(), (after.first - at).norm());
        const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
        if (std::abs(turn) < radians(30)) continue;
        const SketchPoint point = *corner;
        // Large enough that the strip beyond T is wider than the neighbourhoods by which a sparse scan is judged.
        const double radius_wanted = std::min(20 * model.tolerance, 0.95 * room / std::tan(std::abs(turn) / 2));
        edits.push_back(
            {Kind::rounded, model.objects[o].name + ": corner " + print_number(double(e + 1)) + " of " + loops[l].name,
             radius_wanted, true,
             [&model, o, l, e, shape = *shape, point, at, in, out, room, turn](double size) -> std::optional<Model> {
               const double radius = std::abs(size), tangent = radius * std::tan(std::abs(turn) / 2);
               if (tangent > room) return {};
               const Vec2 left(-in.y(), in.x());
               const Vec2 start = at - tangent * in, center = start + std::copysign(radius, turn) * left;
               const double from = std::atan2(start.y() - center.y(), start.x() - center.x());
               Model m = model;
               m.objects[o].shape = shape;
               sketch_of(m.objects[o].shape)->loops[l].elements[e] =
                   SketchArc{center.x(), center.y(), radius, from, from + turn, "rounded", point.edge};
               return m;
             }});
      }
    }
  }
}

void tapered_walls(const Model& model, std::vector<SizedEdit>& edits) {
  const Values values = values_of(model);
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    auto add = [&](const std::string& what, std::function<void(Shape&, double)> apply) {
      edits.push_back({Kind::tapered, model.objects[o].name + what, 3 * model.tolerance, false,
                       [&model, o, apply = std::move(apply)](double size) -> std::optional<Model> {
                         Model m = model;
                         apply(m.objects[o].shape, size);
                         return m;
                       }});
    };
    const Shape& shape = model.objects[o].shape;
    if (std::holds_alternative<Cylinder>(shape))
      add(" conical", [](Shape& s, double size) {
        const auto c = std::get<Cylinder>(s);
        s = Cone{c.radius, c.radius + Expr(size), c.height};
      });
    if (std::holds_alternative<Box>(shape))
      add(" sloped", [](Shape& s, double size) {
        const auto b = std::get<Box>(s);
        s = Wedge{b.size_x, b.size_y, b.size_z, b.size_x + Expr(size)};
      });
    const Sketch* sketch = sketch_of(shape);
    if (!sketch) continue;
    for (std::size_t l = 0; l < sketch->loops.size(); ++l) {
      const auto& elements = sketch->loops[l].elements;
      for (std::size_t e = 0; e < elements.size(); ++e) {
        const std::size_t next = (e + 1) % elements.size();
        const auto *a = std::get_if<SketchPoint>(&elements[e]), *b = std::get_if<SketchPoint>(&elements[next]);
        if (!a || !b || evaluate(a->x, values) != evaluate(b->x, values) || evaluate(a->x, values) == 0) continue;
        add(": wall after corner " + print_number(double(e + 1)) + " of " + sketch->loops[l].name,
            [l, next](Shape& s, double size) {
              auto& x = std::get<SketchPoint>(sketch_of(s)->loops[l].elements[next]).x;
              x = x + Expr(size);
            });
      }
    }
  }
}

void reordered_elements(const Model& model, std::vector<Edit>& edits) {
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const Sketch* sketch = sketch_of(model.objects[o].shape);
    if (!sketch) continue;
    for (std::size_t l = 0; l < sketch->loops.size(); ++l)
      for (std::size_t e = 0; e + 1 < sketch->loops[l].elements.size(); ++e) {
        Model m = model;
        auto& elements = sketch_of(m.objects[o].shape)->loops[l].elements;
        std::swap(elements[e], elements[e + 1]);
        edits.push_back({Kind::reordered,
                         "elements " + print_number(double(e + 1)) + " and " + print_number(double(e + 2)) + " of " +
                             quoted(sketch->loops[l].name) + " swapped",
                         std::move(m)});
      }
  }
}

void wrong_combinations(const Model& model, std::vector<Edit>& edits) {
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const auto* names = operands_of(model.objects[o].shape);
    if (!names || names->size() < 2) continue;
    const auto objects = *names;
    auto instead = [&](Shape shape) {
      Model m = model;
      m.objects[o].shape = std::move(shape);
      edits.push_back({Kind::combined,
                       model.objects[o].name + " as " + std::string(kind_of(m.objects[o].shape)) + ", not " +
                           std::string(kind_of(model.objects[o].shape)),
                       std::move(m)});
    };
    if (!std::holds_alternative<Union>(model.objects[o].shape)) instead(Union{objects});
    if (!std::holds_alternative<Intersection>(model.objects[o].shape)) instead(Intersection{objects});
    if (!std::holds_alternative<Difference>(model.objects[o].shape)) instead(Difference{objects});
  }
}

}  // namespace

std::vector<Edit> additions(const Model& model, const Gauge& gauge) {
  std::vector<Edit> edits;
  reordered_elements(model, edits);
  if (open_sheet(model)) return edits;
  const double diagonal = gauge.box().diagonal(), T = model.tolerance;
  const double radius = std::max(0.05 * diagonal, 6 * T), thin = T / 2;
  const Pose to_part = part_from_surface(model);
  int n = 0;
  for (const FlatSpot& spot : spots(gauge, radius, 1.5 * radius, radius)) {
    const std::string where = " at place " + print_number(++n);
    const Pose on = {to_part.rotation * rotation_onto_axis(spot.normal), to_part * spot.at};
    edits.push_back(
        {Kind::hole_added, "an extra hole" + where,
         combined_with<Difference>(model, "extra_hole", Cylinder{radius, 1.5 * radius}, on * shift({0, 0, -radius}))});
    edits.push_back(
        {Kind::boss_added, "an extra boss" + where,
         combined_with<Union>(model, "extra_boss", Cylinder{radius, 1.5 * radius}, on * shift({0, 0, -0.5 * radius}))});
    edits.push_back({Kind::sheet_added, "a thin sheet lying above place " + print_number(n),
                     combined_with<Union>(model, "extra_sheet", Box{2 * radius, 2 * radius, thin},
                                          on * shift({-radius, -radius, radius}))});
    edits.push_back({Kind::sheet_added, "a thin sheet standing on place " + print_number(n),
                     combined_with<Union>(model, "extra_fin", Box{2 * radius, thin, 2 * radius},
                                          on * shift({-radius, -thin / 2, -0.5 * radius}))});
  }
  const Vec3 beside = gauge.box().high + 0.1 * diagonal * Vec3::Ones();
  edits.push_back({Kind::body_added, "a block beside the part",
                   combined_with<Union>(model, "extra_block", Box{0.1 * diagonal, 0.1 * diagonal, 0.1 * diagonal},
                                        to_part * shift(beside))});
  doubled_holes(model, edits);
  wrong_depths(model, edits);
  wrong_combinations(model, edits);
  return edits;
}

std::vector<SizedEdit> sized_edits(const Model& model) {
  std::vector<SizedEdit> edits;
  if (open_sheet(model)) return edits;
  own_diameters(model, edits);
  rounded_edges(model, edits);
  tapered_walls(model, edits);
  const Values values = values_of(model);
  for (int k = 0; k < 3; ++k)
    edits.push_back({Kind::body_doubled, std::string("with its copy moved along ") + "xyz"[k], 2 * model.tolerance,
                     true, [&model, values, k](double size) -> std::optional<Model> {
                       Model m = model;
                       Object copy = m.objects.back();
                       copy.name += "_again";
                       copy.frame = frame_of(shift(size * Vec3::Unit(k)) * evaluate(copy.frame, values));
                       Object all;
                       all.name = "damaged_part";
                       all.shape = Union{{m.objects.back().name, copy.name}};
                       m.objects.push_back(std::move(copy));
                       m.objects.push_back(std::move(all));
                       return m;
                     }});
  return edits;
}

}  // namespace partscribe::verify
