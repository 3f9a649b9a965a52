#include "model/sketch.h"

#include "core/number.h"
#include "model/overloaded.h"

namespace partscribe::model {
namespace {

Curve2 curve_of(const SketchArcOf<double>& a) { return Arc2{{a.center_x, a.center_y}, a.radius, a.from, a.to}; }

Curve2 curve_of(const SketchNurbsOf<double>& n) {
  Nurbs2 curve{{n.degree, n.knots}, {}, n.weights};
  for (const auto& p : n.control) curve.points.emplace_back(p[0], p[1]);
  return curve;
}

Vec2 start_of_element(const SketchElementOf<double>& element) {
  if (const auto* p = std::get_if<SketchPointOf<double>>(&element)) return {p->x, p->y};
  if (const auto* a = std::get_if<SketchArcOf<double>>(&element)) return start_of(curve_of(*a));
  return start_of(curve_of(std::get<SketchNurbsOf<double>>(element)));
}

}  // namespace

Outline2 outline_of(const EvaluatedSketch& sketch) {
  Outline2 outline;
  for (std::size_t l = 0; l < sketch.loops.size(); ++l) {
    const auto& loop = sketch.loops[l];
    const std::string loop_name = loop.name.empty() ? "loop " + print_number(double(l + 1)) : loop.name;
    int unnamed = 0;
    auto add = [&](Curve2 curve, const std::string& name) {
      ++unnamed;
      outline.curves.push_back(
          {std::move(curve), name.empty() ? loop_name + " edge " + print_number(unnamed) : name, static_cast<int>(l)});
    };
    for (std::size_t i = 0; i < loop.elements.size(); ++i) {
      const auto& element = loop.elements[i];
      Vec2 end = start_of_element(element);
      std::string edge;
      if (const auto* p = std::get_if<SketchPointOf<double>>(&element)) {
        edge = p->edge;
      } else if (const auto* a = std::get_if<SketchArcOf<double>>(&element)) {
        add(curve_of(*a), a->name.empty() ? loop.elements.size() == 1 ? loop_name : "" : a->name);
        end = end_of(outline.curves.back().curve);
        edge = a->edge;
      } else {
        const auto& n = std::get<SketchNurbsOf<double>>(element);
        add(curve_of(n), n.name);
        end = end_of(outline.curves.back().curve);
        edge = n.edge;
      }
      const Vec2 next = start_of_element(loop.elements[(i + 1) % loop.elements.size()]);
      if ((next - end).norm() > sketch_join) add(Line2{end, next}, edge);
    }
  }
  return outline;
}

Box3 flat_box(const Outline2& outline) {
  Box3 box;
  auto add = [&](const Vec2& p) { box.add(Vec3(p.x(), p.y(), 0)); };
  for (const auto& item : outline.curves)
    std::visit(Overloaded{[&](const Line2& l) { add(l.a), add(l.b); },
                          [&](const Arc2& a) {
                            add(a.center - Vec2::Constant(a.radius)), add(a.center + Vec2::Constant(a.radius));
                          },
                          [&](const Nurbs2& n) {
                            for (const auto& p : n.points) add(p);  // a curve stays in their hull
                          }},
               item.curve);
  return box;
}

std::vector<std::vector<std::size_t>> loops_around(const Outline2& outline, std::size_t loops) {
  std::vector<OutlineDistance> alone;
  std::vector<Vec2> places;
  for (std::size_t l = 0; l < loops; ++l) {
    Outline2 one;
    for (const auto& c : outline.curves)
      if (c.loop == static_cast<int>(l)) one.curves.push_back(c);
    places.push_back(start_of(one.curves.front().curve));
    alone.emplace_back(std::move(one));
  }
  std::vector<std::vector<std::size_t>> around(loops);
  for (std::size_t l = 0; l < loops; ++l)
    for (std::size_t k = 0; k < loops; ++k)
      if (k != l && alone[k].inside(places[l])) around[l].push_back(k);
  return around;
}

}  // namespace partscribe::model
