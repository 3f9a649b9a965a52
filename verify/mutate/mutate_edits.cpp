#include "verify/mutate/mutate_edits.h"

#include <Eigen/Geometry>
#include <functional>
#include <set>

#include "core/number.h"
#include "model/surface_patches.h"

namespace partscribe::verify {
namespace {

/// How a shape, mirrored in its own `axis` and then moved by `shift`, is written as a shape of the same kind.
struct OwnMirror {
  int axis = 0;
  Vec3 shift = Vec3::Zero();
};

OwnMirror mirror_in_place(Shape& shape, const Values& values) {
  if (const auto* s = std::get_if<Box>(&shape)) return {0, {-evaluate(s->size_x, values), 0, 0}};
  if (const auto* s = std::get_if<Wedge>(&shape)) return {2, {0, 0, -evaluate(s->size_z, values)}};
  if (const auto* s = std::get_if<Extrude>(&shape)) return {2, {0, 0, -evaluate(s->height, values)}};
  if (auto* s = std::get_if<HalfSpaces>(&shape)) {
    for (auto& plane : s->planes) plane.normal_x = -plane.normal_x;
  } else if (auto* t = std::get_if<TriSurface>(&shape)) {
    for (auto& v : t->vertices) v[0] = -v[0];
    for (auto& triangle : t->triangles) std::swap(triangle[1], triangle[2]);
  } else {
    for (TrimmedPatch* patch : patches_of(shape)) *patch = mirrored(*patch, 0);
    if (auto* swept = std::get_if<SweptSurface>(&shape)) swept->direction[0] *= -1;
  }
  return {};  // all others are their own mirror image in x
}

Mat3 mirror_matrix(int axis) {
  Vec3 d = Vec3::Ones();
  d[axis] = -1;
  return d.asDiagonal();
}

/// Without the objects that the part no longer needs.
void prune(Model& model) {
  std::set<std::string> needed = {model.objects.back().name};
  for (auto o = model.objects.rbegin(); o != model.objects.rend(); ++o)
    if (const auto* names = operands_of(o->shape); names && needed.count(o->name))
      needed.insert(names->begin(), names->end());
  std::erase_if(model.objects, [&](const Object& o) { return !needed.count(o.name); });
}

}  // namespace

std::string quoted(const std::string& text) { return "'" + text + "'"; }

Frame frame_of(const Pose& pose) {
  const Vec3 turn = euler_from_rotation(pose.rotation);
  return {pose.translation.x(), pose.translation.y(), pose.translation.z(), turn.x(), turn.y(), turn.z()};
}

Pose shift(const Vec3& by) { return {Mat3::Identity(), by}; }

bool combines(const Shape& shape) { return operands_of(shape) != nullptr; }

Sketch* sketch_of(Shape& shape) {
  if (auto* e = std::get_if<Extrude>(&shape)) return &e->sketch;
  if (auto* r = std::get_if<Revolve>(&shape)) return &r->sketch;
  if (auto* p = std::get_if<Pocket>(&shape)) return &p->sketch;
  if (auto* b = std::get_if<Boss>(&shape)) return &b->sketch;
  return nullptr;
}

std::vector<TrimmedPatch*> patches_of(Shape& shape) {
  std::vector<TrimmedPatch*> result;
  if (auto* set = std::get_if<SurfaceSet>(&shape))
    for (auto& patch : set->patches) result.push_back(&patch);
  if (auto* swept = std::get_if<SweptSurface>(&shape)) result.push_back(&swept->surface);
  return result;
}

std::vector<const TrimmedPatch*> patches_of(const Shape& shape) {
  const auto patches = patches_of(const_cast<Shape&>(shape));
  return {patches.begin(), patches.end()};
}

const Sketch* sketch_of(const Shape& shape) { return sketch_of(const_cast<Shape&>(shape)); }

std::vector<std::string>* operands_of(Shape& shape) {
  if (auto* u = std::get_if<Union>(&shape)) return &u->objects;
  if (auto* d = std::get_if<Difference>(&shape)) return &d->objects;
  if (auto* n = std::get_if<Intersection>(&shape)) return &n->objects;
  return nullptr;
}

const std::vector<std::string>* operands_of(const Shape& shape) { return operands_of(const_cast<Shape&>(shape)); }

/// Every object is mirrored in its parent's frame: M F S = (M F M') (M' S), M' a mirror that S can express.
Model mirrored(const Model& model, int axis, const Vec3& middle) {
  Model result = model;
  const Values values = values_of(model);
  const Mat3 mirror = mirror_matrix(axis);
  for (auto& object : result.objects) {
    const OwnMirror own =
        combines(object.shape) ? OwnMirror{axis, Vec3::Zero()} : mirror_in_place(object.shape, values);
    const Pose frame = evaluate(object.frame, values);
    const Pose turned{mirror * frame.rotation * mirror_matrix(own.axis), mirror * frame.translation};
    object.frame = frame_of(turned * shift(own.shift));
  }
  auto& last = result.objects.back();
  last.frame = frame_of(shift(2 * middle[axis] * Vec3::Unit(axis)) * evaluate(last.frame, values));
  return result;
}

Model scaled(const Model& model, double factor, const Vec3& middle) {
  Model result = model;
  for (auto& object : result.objects) {
    visit_expressions(object.shape, [&](Expr& e, Domain domain) {
      if (domain == Domain::length || domain == Domain::length_or_zero || domain == Domain::coordinate)
        e = Expr(factor) * e;
    });
    if (auto* t = std::get_if<TriSurface>(&object.shape))
      for (auto& v : t->vertices)
        for (auto& x : v) x *= factor;
    for (TrimmedPatch* patch : patches_of(object.shape))
      for (auto& p : patch->control)
        for (auto& x : p) x *= factor;
    if (auto* swept = std::get_if<SweptSurface>(&object.shape))
      for (auto& x : swept->direction) x *= factor;
    for (Expr* e : {&object.frame.x, &object.frame.y, &object.frame.z}) *e = Expr(factor) * *e;
  }
  Frame& last = result.objects.back().frame;
  const Vec3 back = (1 - factor) * middle;
  last.x = last.x + Expr(back.x()), last.y = last.y + Expr(back.y()), last.z = last.z + Expr(back.z());
  return result;
}

std::vector<Edit> omissions(const Model& model) {
  std::vector<Edit> result;
  auto without = [&](Mutation::Kind kind, std::size_t o, const std::string& what,
                     const std::function<void(Shape&)>& omit) {
    Model damaged = model;
    omit(damaged.objects[o].shape);
    prune(damaged);
    result.push_back({kind, "without " + what, std::move(damaged)});
  };
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    const Shape& shape = model.objects[o].shape;
    if (const Sketch* sketch = sketch_of(shape)) {
      for (std::size_t l = 1; l < sketch->loops.size(); ++l)
        without(Mutation::Kind::feature_missing, o, "loop " + quoted(sketch->loops[l].name),
                [&](Shape& s) { sketch_of(s)->loops.erase(sketch_of(s)->loops.begin() + long(l)); });
      for (std::size_t l = 0; l < sketch->loops.size(); ++l)
        for (std::size_t e = 0; e < sketch->loops[l].elements.size() && sketch->loops[l].elements.size() > 1; ++e)
          without(Mutation::Kind::edge_missing, o,
                  "element " + print_number(double(e + 1)) + " of loop " + quoted(sketch->loops[l].name),
                  [&](Shape& s) {
                    auto& elements = sketch_of(s)->loops[l].elements;
                    elements.erase(elements.begin() + long(e));
                  });
    } else if (const auto* h = std::get_if<HalfSpaces>(&shape)) {
      for (std::size_t i = 0; i < h->planes.size(); ++i)
        without(Mutation::Kind::face_missing, o, "face " + quoted(h->planes[i].name), [&](Shape& s) {
          auto& planes = std::get<HalfSpaces>(s).planes;
          planes.erase(planes.begin() + long(i));
        });
    } else if (const auto* t = std::get_if<TriSurface>(&shape); t && !t->closed && t->triangles.size() > 1) {
      without(Mutation::Kind::face_missing, o, "a triangle of " + quoted(model.objects[o].name),
              [](Shape& s) { std::get<TriSurface>(s).triangles.erase(std::get<TriSurface>(s).triangles.begin()); });
    } else if (const auto* set = std::get_if<SurfaceSet>(&shape); set && !set->closed) {
      for (std::size_t p = 0; p < set->patches.size() && set->patches.size() > 1; ++p)
        without(Mutation::Kind::face_missing, o, "surface " + quoted(set->patches[p].name), [&](Shape& s) {
          auto& patches = std::get<SurfaceSet>(s).patches;
          patches.erase(patches.begin() + long(p));
        });
      for (std::size_t p = 0; p < set->patches.size(); ++p)
        if (set->patches[p].trims.back().loop > 0)
          without(Mutation::Kind::feature_missing, o, "the holes of " + quoted(set->patches[p].name), [&](Shape& s) {
            std::erase_if(std::get<SurfaceSet>(s).patches[p].trims, [](const PatchTrim& t) { return t.loop > 0; });
          });
    } else if (const auto* names = operands_of(shape); names && names->size() > 1) {
      for (std::size_t i = std::holds_alternative<Difference>(shape) ? 1 : 0; i < names->size(); ++i)
        without(Mutation::Kind::feature_missing, o, (*names)[i], [&](Shape& s) {
          auto& left = *operands_of(s);
          left.erase(left.begin() + long(i));
          if (left.size() == 1) s = Union{left};
        });
    }
  }
  return result;
}

}  // namespace partscribe::verify
