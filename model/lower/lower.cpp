#include "model/lower/lower.h"

#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "model/lower/edges.h"
#include "model/lower/reflect.h"
#include "model/lower/solids.h"
#include "model/overloaded.h"

namespace partscribe::model {
namespace {

bool turned(const Frame& f) { return !(f.rx == Expr(0) && f.ry == Expr(0) && f.rz == Expr(0)); }

class Lowering {
 public:
  /// Takes the model's objects for good.
  Lowering(Model& model, const Values& values, const Kinds& known) : model_(model), values_(values), known_(known) {
    for (const auto& p : model.parameters) taken_.insert(p.name);
    for (const auto& o : model.objects) taken_.insert(o.name);
  }

  std::vector<Object> run() {
    for (Object& o : model_.objects) {
      if (o.feature.empty()) o.feature = o.name;
      add(std::move(o));
    }
    return std::move(done_);
  }

 private:
  bool known(std::string_view kind) const { return known_.count(kind) > 0; }

  std::string fresh(const std::string& wish) {
    std::string name = wish;
    for (int k = 2; !taken_.insert(name).second; ++k) name = wish + "_" + std::to_string(k);
    return name;
  }

  const Object& object(const std::string& name) const {
    const auto found = std::find_if(done_.begin(), done_.end(), [&](const Object& o) { return o.name == name; });
    ensure(found != done_.end(), "an object refers to earlier ones");
    return *found;
  }

  /// Appends an object, and before it what it needs.
  void add(Object o) {
    if (std::visit([&](const auto& s) { return stays(s); }, o.shape)) {
      done_.push_back(std::move(o));
      return;
    }
    const Shape shape = std::move(o.shape);
    std::visit([&](const auto& s) { replace(std::move(o), s); }, shape);
  }

  template <class S>
  bool stays(const S& s) const {
    if constexpr (!is_basic<S>)
      if (!known(S::kind)) return false;
    if constexpr (requires { s.sketch; }) return known(islands) || without_islands(s.sketch, values_).size() == 1;
    return true;
  }

  void keep(Object o, Shape shape) {
    o.shape = std::move(shape);
    done_.push_back(std::move(o));
  }

  void put(Object o, Shape shape) {
    o.shape = std::move(shape);
    add(std::move(o));
  }

  /// A helper that belongs to the same feature; the name it got.
  std::string helper(const Object& of, const std::string& wish, Shape shape, const Frame& frame = {}) {
    Object o;
    o.name = fresh(wish);
    o.feature = of.feature;
    o.frame = frame;
    const std::string name = o.name;
    put(std::move(o), std::move(shape));
    return name;
  }

  /// A feature by the solid that it is; a sketch with islands by a body for each piece of material.
  template <class S>
  void replace(Object o, const S& s) {
    if constexpr (SaidSimpler<S>) {
      if (!known(S::kind)) return put(std::move(o), solid_of(s));
    }
    if constexpr (requires { s.sketch; }) {
      Union all;
      for (const Sketch& sketch : without_islands(s.sketch, values_)) {
        S one = s;
        one.sketch = sketch;
        all.objects.push_back(helper(o, o.name + "_island", one));
      }
      keep(std::move(o), all);
    }
  }

  void replace(Object o, const LinearPattern& s) {
    repeat(std::move(o), s.object, s.count,
           [&](double k) { return Frame{Expr(k) * s.step_x, Expr(k) * s.step_y, Expr(k) * s.step_z, 0, 0, 0}; });
  }
  void replace(Object o, const CircularPattern& s) {
    repeat(std::move(o), s.object, s.count, [&](double k) { return Frame{0, 0, 0, 0, 0, Expr(k) * s.step}; });
  }

  template <class FrameOf>
  void repeat(Object o, const std::string& name, const Expr& count, const FrameOf& frame_of) {
    Union all;
    const int copies = static_cast<int>(std::lround(evaluate(count, values_)));
    for (int k = 0; k < copies; ++k)
      all.objects.push_back(copy(o, o.name + "_" + std::to_string(k + 1), name, frame_of(k)));
    keep(std::move(o), all);
  }

  /// One of several copies of an object.
  std::string copy(const Object& of, const std::string& wish, const std::string& name, const Frame& frame) {
    const std::string made = helper(of, wish, Union{{name}}, frame);
    done_.back().repeats = of.feature;
    return made;
  }

  void replace(Object o, const EdgeFillet& s) { work_edge(std::move(o), s); }
  void replace(Object o, const EdgeChamfer& s) { work_edge(std::move(o), s); }

  template <class S>
  void work_edge(Object o, const S& s) {
    Model part;
    part.parameters = model_.parameters;
    part.objects.assign(done_.begin(), done_.begin() + (&object(s.object) - done_.data()) + 1);
    auto made = edge_tool(part, values_, s);
    const auto* tool = std::get_if<EdgeTool>(&made);
    ensure(tool != nullptr, "the edges of a checked model exist");
    const std::string name = helper(o, o.name + "_tool", tool->body.shape, tool->body.frame);
    if (tool->removes)
      keep(std::move(o), Difference{{s.object, name}});
    else
      keep(std::move(o), Union{{s.object, name}});
  }

  void replace(Object o, const Mirror& s) {
    Union all;
    if (s.keep) all.objects.push_back(copy(o, o.name + "_1", s.object, {}));
    const int axis = s.axis == "x" ? 0 : s.axis == "y" ? 1 : 2;
    all.objects.push_back(copy(o, o.name + "_" + (s.keep ? "2" : "1"), image(s.object, axis, s.offset), {}));
    keep(std::move(o), all);
  }

  /// The image of an object that is in `done_`, with the images of what it refers to; its name.
  std::string image(const std::string& name, int axis, const Expr& offset) {
    const Object original = object(name);
    const std::string wish = name + "_image";
    const Placed made =
        reflected(original.shape, axis, [&](const std::string& other) { return image(other, axis, 0); });
    const Frame frame = reflected(original.frame, axis, offset);
    if (made.frame.identity()) return add_image(original, wish, made.shape, frame);
    if (!turned(frame)) {
      Frame both = made.frame;
      both.x = frame.x + both.x, both.y = frame.y + both.y, both.z = frame.z + both.z;
      return add_image(original, wish, made.shape, both);
    }
    return add_image(original, wish, Union{{add_image(original, wish + "_body", made.shape, made.frame)}}, frame);
  }

  std::string add_image(const Object& original, const std::string& wish, Shape shape, const Frame& frame) {
    Object o;
    o.name = fresh(wish);
    o.feature = original.feature, o.repeats = original.repeats;
    o.shape = std::move(shape);
    o.frame = frame;
    done_.push_back(std::move(o));
    return done_.back().name;
  }

  Model& model_;
  const Values& values_;
  const Kinds& known_;
  std::set<std::string> taken_;
  std::vector<Object> done_;
};

}  // namespace

Model lowered(const Model& model, const Kinds& known) {
  const Values values = values_of(model);
  Model result = model;
  result.objects = Lowering(result, values, known).run();
  return result;
}

Model lowered(const Model& model, const Values& values, const Kinds& known) {
  Model result = model;
  auto to_number = [&](Expr& e) { e = Expr(evaluate(e, values)); };
  for (Object& o : result.objects) {
    visit_expressions(o.shape, [&](Expr& e, Domain) { to_number(e); });
    visit_expressions(o.frame, to_number);
  }
  visit_expressions(result.scan_from_part, to_number);
  result.objects = Lowering(result, values, known).run();
  return result;
}

}  // namespace partscribe::model
