#include "verify/mutate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "core/ensure.h"
#include "core/number.h"
#include "core/random.h"
#include "model/check.h"
#include "model/distance.h"

namespace partscribe {
namespace {

constexpr std::size_t probes = 2000;           // places by which displacements are measured
constexpr std::size_t visible = probes / 200;  // so many of them must lie off the damaged surface
constexpr std::size_t most_vertices = 24;      // of a triangulation that are moved, one at a time

std::string quoted(const std::string& text) { return "'" + text + "'"; }
std::string shown(double v) { return print_number(snapped(v, 1e-5)); }
std::string signed_text(double v) { return (v < 0 ? " - " : " + ") + shown(std::abs(v)); }

Vec3 gradient(const ModelDistance& distance, const Vec3& p, double h) {
  Vec3 g;
  for (int k = 0; k < 3; ++k)
    g[k] = (distance(p + h * Vec3::Unit(k)).distance - distance(p - h * Vec3::Unit(k)).distance) / (2 * h);
  return g;
}

/// From far away the nearest places are the outermost ones of the part: they span its box.
Box3 bounds_of(const ModelDistance& distance, Vec3 center) {
  double reach = 1000;
  Box3 box;
  // The first look is from anywhere, the second from about the part and closer.
  for (int look = 0; look < 2; ++look) {
    Random random(7);
    box = {};
    for (int i = 0; i < 400; ++i) {
      Vec3 direction(random.normal(), random.normal(), random.normal());
      if (i < 6) direction = (i % 2 ? -1.0 : 1.0) * Vec3::Unit(i / 2);
      Vec3 p = center + reach * direction.normalized();
      double d = distance(p).distance;
      for (int step = 0; step < 60 && std::abs(d) > 1e-7 * reach; ++step) {
        const Vec3 g = gradient(distance, p, 1e-6 * reach);
        if (g.squaredNorm() < 0.01) break;
        p -= d * g.normalized();
        d = distance(p).distance;
      }
      if (std::abs(d) < 1e-3 * reach) box.add(p);
    }
    ensure(!box.empty(), "a model has a surface");
    center = box.center();
    reach = 2 * box.diagonal();
  }
  return box;
}

Box3 bounds_of(const Model& model, const ModelDistance& distance) {
  return bounds_of(distance,
                   model.as_scanned ? evaluate(model.scan_from_part, values_of(model)).translation : Vec3(0, 0, 0));
}

// ---- how far a damage moves the surface ---------------------------------------------------------------------------

bool passes(const Model& model) { return std::holds_alternative<CheckedModel>(check(model)); }

/// Measures damages of one model.
class Gauge {
 public:
  explicit Gauge(const Model& model) : truth_(model), distance_(model), points_(surface_points(model, probes, 11)) {
    for (const auto& p : points_) box_.add(p.point);
  }

  const Box3& box() const { return box_; }

  /// At least `visible` probes are so far from the surface of `damaged`.
  double moved(const Model& damaged) const {
    const ModelDistance distance(damaged);
    std::vector<double> off;
    for (const auto& p : points_) off.push_back(std::abs(distance(p.point).distance));
    std::nth_element(off.begin(), off.begin() + visible, off.end(), std::greater<>());
    return off[visible];
  }

  /// True if both describe the same surface.
  bool same(const Model& damaged) const {
    const ModelDistance distance(damaged);
    const double limit = 1e-6 * box_.diagonal();
    for (const auto& p : points_)
      if (std::abs(distance(p.point).distance) > limit) return false;
    for (const auto& p : surface_points(damaged, probes / 4, 13))
      if (std::abs(distance_(p.point).distance) > limit) return false;
    return true;
  }

 private:
  const Model& truth_;
  ModelDistance distance_;
  std::vector<SurfacePoint> points_;
  Box3 box_;
};

/// The damaged model for a change of this size, if there is such a model.
using Change = std::function<std::optional<Model>(double size)>;

// ---- mirrors --------------------------------------------------------------------------------------------------------

Frame frame_of(const Pose& pose) {
  const Vec3 turn = euler_from_rotation(pose.rotation);
  return {pose.translation.x(), pose.translation.y(), pose.translation.z(), turn.x(), turn.y(), turn.z()};
}

Pose shift(const Vec3& by) { return {Mat3::Identity(), by}; }

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
  }
  return {};  // all others are their own mirror image in x
}

bool combines(const Shape& shape) {
  return std::holds_alternative<Union>(shape) || std::holds_alternative<Difference>(shape) ||
         std::holds_alternative<Intersection>(shape);
}

Mat3 mirror_matrix(int axis) {
  Vec3 d = Vec3::Ones();
  d[axis] = -1;
  return d.asDiagonal();
}

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

// ---- scale ----------------------------------------------------------------------------------------------------------

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
    for (Expr* e : {&object.frame.x, &object.frame.y, &object.frame.z}) *e = Expr(factor) * *e;
  }
  Frame& last = result.objects.back().frame;
  const Vec3 back = (1 - factor) * middle;
  last.x = last.x + Expr(back.x()), last.y = last.y + Expr(back.y()), last.z = last.z + Expr(back.z());
  return result;
}

// ---- what can be left out
// ---------------------------------------------------------------------------------------------

/// Without the objects that the part no longer needs.
void prune(Model& model) {
  std::set<std::string> needed = {model.objects.back().name};
  for (auto o = model.objects.rbegin(); o != model.objects.rend(); ++o) {
    if (!needed.count(o->name)) continue;
    auto need = [&](const std::vector<std::string>& names) { needed.insert(names.begin(), names.end()); };
    if (const auto* u = std::get_if<Union>(&o->shape)) need(u->objects);
    if (const auto* d = std::get_if<Difference>(&o->shape)) need(d->objects);
    if (const auto* n = std::get_if<Intersection>(&o->shape)) need(n->objects);
  }
  std::erase_if(model.objects, [&](const Object& o) { return !needed.count(o.name); });
}

struct Omission {
  std::string name;
  Model model;
};

std::vector<Omission> omissions(const Model& model) {
  std::vector<Omission> result;
  auto without = [&](std::size_t o, const std::string& what, const std::function<void(Shape&)>& omit) {
    Model damaged = model;
    omit(damaged.objects[o].shape);
    prune(damaged);
    result.push_back({"without " + what, std::move(damaged)});
  };
  auto sketch_of = [](Shape& shape) -> Sketch* {
    if (auto* e = std::get_if<Extrude>(&shape)) return &e->sketch;
    if (auto* r = std::get_if<Revolve>(&shape)) return &r->sketch;
    return nullptr;
  };
  for (std::size_t o = 0; o < model.objects.size(); ++o) {
    Shape shape = model.objects[o].shape;
    const std::string owner = quoted(model.objects[o].name);
    if (const Sketch* sketch = sketch_of(shape)) {
      for (std::size_t l = 1; l < sketch->loops.size(); ++l)
        without(o, "loop " + quoted(sketch->loops[l].name),
                [&](Shape& s) { std::erase(sketch_of(s)->loops, sketch->loops[l]); });
      for (std::size_t l = 0; l < sketch->loops.size(); ++l)
        for (std::size_t e = 0; e < sketch->loops[l].elements.size() && sketch->loops[l].elements.size() > 1; ++e)
          without(o, "element " + print_number(double(e + 1)) + " of loop " + quoted(sketch->loops[l].name),
                  [&](Shape& s) {
                    auto& elements = sketch_of(s)->loops[l].elements;
                    elements.erase(elements.begin() + long(e));
                  });
    } else if (const auto* h = std::get_if<HalfSpaces>(&shape)) {
      for (std::size_t i = 0; i < h->planes.size(); ++i)
        without(o, "face " + quoted(h->planes[i].name), [&](Shape& s) {
          auto& planes = std::get<HalfSpaces>(s).planes;
          planes.erase(planes.begin() + long(i));
        });
    } else if (const auto* t = std::get_if<TriSurface>(&shape); t && !t->closed && t->triangles.size() > 1) {
      without(o, "a triangle of " + owner,
              [](Shape& s) { std::get<TriSurface>(s).triangles.erase(std::get<TriSurface>(s).triangles.begin()); });
    }
    auto operands = [&]<class S>(const S* combination, bool keep_first) {
      if (!combination) return;
      for (std::size_t i = keep_first ? 1 : 0; i < combination->objects.size() && combination->objects.size() > 1; ++i)
        without(o, combination->objects[i], [&](Shape& s) {
          auto names = combination->objects;
          names.erase(names.begin() + long(i));
          if (names.size() == 1)
            s = Union{names};
          else
            std::get<S>(s).objects = names;
        });
    };
    operands(std::get_if<Union>(&shape), false);
    operands(std::get_if<Difference>(&shape), true);
    operands(std::get_if<Intersection>(&shape), false);
  }
  return result;
}

// ---- the list
// ---------------------------------------------------------------------------------------------------------

class Damages {
 public:
  explicit Damages(const Model& model)
      : model_(model), values_(values_of(model)), gauge_(model), tolerance_(model.tolerance) {
    Model in_part = model;
    in_part.as_scanned = false;
    middle_ = bounds_of(in_part, ModelDistance(in_part)).center();
  }

  std::vector<Mutation> run() {
    parameters();
    for (std::size_t o = 0; o < model_.objects.size(); ++o) numbers(o);
    placements();
    for (auto& omission : omissions(model_)) take(Mutation::Kind::missing, omission.name, std::move(omission.model));
    for (int axis = 0; axis < 3; ++axis)
      take(Mutation::Kind::mirrored, std::string("mirrored in ") + "xyz"[axis], mirrored(model_, axis, middle_));
    scale();
    std::stable_sort(result_.begin(), result_.end(),
                     [](const Mutation& a, const Mutation& b) { return a.kind < b.kind; });
    return std::move(result_);
  }

 private:
  const Model& model_;
  Values values_;
  Gauge gauge_;
  double tolerance_;
  Vec3 middle_;  // of the part's box, in the part's frame
  double sign_ = 1;
  std::vector<Mutation> result_;

  void take(Mutation::Kind kind, const std::string& name, Model damaged) {
    if (!passes(damaged)) return;
    const double moved = gauge_.moved(damaged);
    if (moved > 1.5 * tolerance_) result_.push_back({kind, name, moved, std::move(damaged)});
  }

  /// Finds the change of a suitable size. `exact`: 2 T is right if it moves the surface at all visibly.
  /// Returns the size; 0 if there is none, NaN if the surface does not depend on it.
  double suitable(const Change& change, double size, bool exact, Model& damaged, double& moved) {
    bool unseen = false;
    for (int attempt = 0; attempt < 16; ++attempt) {
      auto model = change(size);
      if (!model || !passes(*model)) {
        if (attempt > 0) break;
        size = -size;
        model = change(size);
        if (!model || !passes(*model)) break;
      }
      moved = gauge_.moved(*model);
      if ((exact && attempt == 0 && moved > 1.5 * tolerance_) ||
          (moved > 1.9 * tolerance_ && moved < 2.3 * tolerance_)) {
        damaged = std::move(*model);
        return size;
      }
      // A little more of an arc only replaces a little of the straight edge that follows: angles get larger first.
      if (attempt == 0 && moved < 1e-3 * tolerance_ && gauge_.same(*model)) {
        damaged = std::move(*model);
        if (exact) return std::nan("");
        unseen = true;
      }
      size *= moved > 0 ? std::clamp(2.1 * tolerance_ / moved, 0.1, 4.0) : 4.0;
    }
    return unseen ? std::nan("") : 0;
  }

  void damage(Mutation::Kind kind, const std::string& what, double start, bool exact, const Change& change,
              bool with_harmless = false, bool unseen_is_harmless = false) {
    Model damaged;
    double moved = 0;
    const double size = suitable(change, sign_ * start, exact, damaged, moved);
    if (std::isnan(size)) {
      if (unseen_is_harmless)
        result_.push_back({Mutation::Kind::harmless, what + signed_text(sign_ * start), 0, std::move(damaged)});
      return;
    }
    if (size == 0) return;
    result_.push_back({kind, what + signed_text(size), moved, std::move(damaged)});
    sign_ = -sign_;
    if (!with_harmless) return;
    auto near = change(size / 20);
    if (near && passes(*near))
      result_.push_back(
          {Mutation::Kind::harmless, what + signed_text(size / 20), gauge_.moved(*near), std::move(*near)});
  }

  /// A first guess of an angle that moves the surface by 2 T.
  double small_angle() const { return 4 * tolerance_ / gauge_.box().diagonal(); }

  void parameters() {
    for (std::size_t i = 0; i < model_.parameters.size(); ++i) {
      const bool length = model_.parameters[i].quantity == Quantity::length;
      damage(
          Mutation::Kind::parameter, model_.parameters[i].name, length ? 2 * tolerance_ : small_angle(), length,
          [&](double size) -> std::optional<Model> {
            Model m = model_;
            auto& p = m.parameters[i];
            p.value += size, p.fitted = p.value, p.nominal.reset();
            return m;
          },
          true, true);
    }
  }

  void expressions(std::size_t o) {
    std::vector<std::pair<Expr, Domain>> all;
    visit_expressions(std::as_const(model_.objects[o].shape), [&](const Expr& e, Domain d) { all.push_back({e, d}); });
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto& [e, domain] = all[i];
      if (e.is_parameter() || domain == Domain::component) continue;
      const bool length = domain == Domain::length || domain == Domain::length_or_zero || domain == Domain::coordinate;
      const std::string what =
          model_.objects[o].name + ": value " + print_number(double(i + 1)) + ", " + shown(evaluate(e, values_));
      damage(
          Mutation::Kind::number, what, length ? 2 * tolerance_ : small_angle(), length,
          [&, i](double size) -> std::optional<Model> {
            Model m = model_;
            std::size_t at = 0;
            visit_expressions(m.objects[o].shape, [&](Expr& x, Domain) {
              if (at++ == i) x = x + Expr(size);
            });
            return m;
          },
          false, true);
    }
  }

  /// Weights and knots, which are plain numbers.
  void curve_numbers(std::size_t o) {
    auto sketch_of = [](Shape& shape) -> Sketch* {
      if (auto* e = std::get_if<Extrude>(&shape)) return &e->sketch;
      if (auto* r = std::get_if<Revolve>(&shape)) return &r->sketch;
      return nullptr;
    };
    Shape shape = model_.objects[o].shape;
    const Sketch* sketch = sketch_of(shape);
    if (!sketch) return;
    for (std::size_t l = 0; l < sketch->loops.size(); ++l)
      for (std::size_t e = 0; e < sketch->loops[l].elements.size(); ++e) {
        const auto* curve = std::get_if<SketchNurbs>(&sketch->loops[l].elements[e]);
        if (!curve) continue;
        auto changed = [&, l, e](std::vector<double> SketchNurbs::*list, std::size_t i) {
          return [&, l, e, list, i](double size) -> std::optional<Model> {
            Model m = model_;
            (std::get<SketchNurbs>(sketch_of(m.objects[o].shape)->loops[l].elements[e]).*list)[i] += size;
            return m;
          };
        };
        const std::string name = model_.objects[o].name + ": ";
        for (std::size_t i = 0; i < curve->weights.size(); ++i)
          damage(Mutation::Kind::number, name + "weight " + print_number(double(i + 1)), 0.02, false,
                 changed(&SketchNurbs::weights, i));
        for (std::size_t i = 0; i < curve->knots.size(); ++i)
          if (curve->knots[i] > curve->knots.front() && curve->knots[i] < curve->knots.back())
            damage(Mutation::Kind::number, name + "knot " + print_number(double(i + 1)), 0.02, false,
                   changed(&SketchNurbs::knots, i));
      }
  }

  /// Planes tilt about the foot of the origin: their normals must remain unit vectors.
  void tilts(std::size_t o) {
    const auto* planes = std::get_if<HalfSpaces>(&model_.objects[o].shape);
    if (!planes) return;
    for (std::size_t i = 0; i < planes->planes.size(); ++i) {
      const auto& plane = planes->planes[i];
      const Vec3 n(evaluate(plane.normal_x, values_), evaluate(plane.normal_y, values_),
                   evaluate(plane.normal_z, values_));
      const Vec3 axis = n.unitOrthogonal();
      damage(Mutation::Kind::number, "normal of face " + quoted(plane.name), small_angle(), false,
             [&, i, n, axis](double size) -> std::optional<Model> {
               Model m = model_;
               const Vec3 turned = (rotation_of(size * axis) * n).normalized();
               auto& p = std::get<HalfSpaces>(m.objects[o].shape).planes[i];
               p.normal_x = turned.x(), p.normal_y = turned.y(), p.normal_z = turned.z();
               return m;
             });
    }
  }

  void vertices(std::size_t o) {
    const auto* mesh = std::get_if<TriSurface>(&model_.objects[o].shape);
    if (!mesh) return;
    std::vector<Vec3> normals(mesh->vertices.size(), Vec3::Zero());
    auto corner = [&](std::uint32_t v) { return Vec3(mesh->vertices[v].data()); };
    for (const auto& t : mesh->triangles)
      for (const auto v : t) normals[v] += (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0]));
    const std::size_t stride = std::max<std::size_t>(1, (normals.size() + most_vertices - 1) / most_vertices);
    for (std::size_t i = 0; i < normals.size(); i += stride) {
      if (!(normals[i].norm() > 0)) continue;
      const Vec3 n = normals[i].normalized();
      damage(Mutation::Kind::number, model_.objects[o].name + ": vertex " + print_number(double(i)), 4 * tolerance_,
             false, [&, i, n](double size) -> std::optional<Model> {
               Model m = model_;
               auto& v = std::get<TriSurface>(m.objects[o].shape).vertices[i];
               for (std::size_t k = 0; k < 3; ++k) v[k] += size * n[int(k)];
               return m;
             });
    }
  }

  void numbers(std::size_t o) {
    expressions(o);
    curve_numbers(o);
    tilts(o);
    vertices(o);
  }

  /// The whole part, and each object that others are combined from.
  void placements() {
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = Vec3::Unit(k);
      const std::string name(1, "xyz"[k]);
      auto placed = [&](const Pose& by) {
        Model m = model_;
        auto& last = m.objects.back();
        last.frame = frame_of(by * evaluate(last.frame, values_));
        return m;
      };
      damage(Mutation::Kind::moved, "part moved along " + name, 2 * tolerance_, true,
             [&](double size) -> std::optional<Model> { return placed(shift(size * axis)); });
      damage(Mutation::Kind::moved, "part turned about " + name, small_angle(), false,
             [&](double size) -> std::optional<Model> {
               return placed(shift(middle_) * Pose{rotation_of(size * axis), Vec3::Zero()} * shift(-middle_));
             });
    }
    for (std::size_t o = 0; o + 1 < model_.objects.size(); ++o) {
      if (combines(model_.objects[o].shape)) continue;
      for (int k = 0; k < 6; ++k) {
        const std::string name = model_.objects[o].name + (k < 3 ? " moved along " : " turned about ") + "xyz"[k % 3];
        auto component = [k](Frame& f) -> Expr& {
          Expr* all[] = {&f.x, &f.y, &f.z, &f.rx, &f.ry, &f.rz};
          return *all[k];
        };
        damage(Mutation::Kind::moved, name, k < 3 ? 2 * tolerance_ : small_angle(), k < 3,
               [&](double size) -> std::optional<Model> {
                 Model m = model_;
                 Expr& e = component(m.objects[o].frame);
                 e = e + Expr(size);
                 return m;
               });
      }
    }
  }

  void scale() {
    Model model = scaled(model_, 1.005, middle_);
    const double moved = passes(model) ? gauge_.moved(model) : 0;
    if (moved > 1.5 * tolerance_) {
      result_.push_back({Mutation::Kind::scaled, "scaled by 1.005", moved, std::move(model)});
    } else if (moved > 0) {
      const double factor = 1 + 0.005 * 2 * tolerance_ / moved;
      take(Mutation::Kind::scaled,
           "scaled by " + shown(factor) + " (0.5 % moves the surface by " + shown(moved) + " only)",
           scaled(model_, factor, middle_));
    }
  }
};

}  // namespace

const char* name_of(Mutation::Kind kind) {
  switch (kind) {
    case Mutation::Kind::parameter:
      return "parameter";
    case Mutation::Kind::number:
      return "number";
    case Mutation::Kind::moved:
      return "moved";
    case Mutation::Kind::missing:
      return "missing";
    case Mutation::Kind::mirrored:
      return "mirrored";
    case Mutation::Kind::scaled:
      return "scaled";
    case Mutation::Kind::harmless:
      return "harmless";
  }
  return "harmless";
}

std::vector<Mutation> mutations_of(const Model& model) { return Damages(model).run(); }

std::vector<SurfacePoint> surface_points(const Model& model, std::size_t count, std::uint64_t seed) {
  const ModelDistance distance(model);
  const Box3 box = bounds_of(model, distance);
  const Vec3 center = box.center();
  const double radius = 0.51 * box.diagonal();
  const double least_step = 1e-3 * radius, sharp = 1e-9 * radius, h = 1e-6 * radius;
  Random random(seed);
  std::vector<SurfacePoint> points;
  // Lines uniform in direction and offset meet every piece of surface in proportion to its area (Crofton).
  for (std::size_t lines = 0; points.size() < count; ++lines) {
    ensure(lines < 1000 * count + 10000, "random lines meet the surface");
    const Vec3 direction = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3 side = direction.unitOrthogonal();
    const double angle = random.uniform(0, 2 * pi), offset = radius * std::sqrt(random.uniform());
    const Vec3 start = center + offset * (std::cos(angle) * side + std::sin(angle) * direction.cross(side));
    auto along = [&](double t) { return distance(start + t * direction).distance; };
    double t = -radius, d = along(t);
    while (t < radius && points.size() < count) {
      const double next = t + std::max(std::abs(d), least_step), d_next = along(next);
      if ((d < 0) != (d_next < 0)) {
        double low = t, high = next, d_low = d, d_high = d_next, root = t;
        for (int i = 0; i < 80 && high - low > 0.1 * sharp; ++i) {
          root = i % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * d_low / (d_low - d_high);
          const double d_root = along(root);
          if (std::abs(d_root) < sharp) break;
          if ((d_root < 0) == (d_low < 0))
            low = root, d_low = d_root;
          else
            high = root, d_high = d_root;
        }
        const Vec3 p = start + root * direction;
        // Beside an open sheet the sign changes where there is no surface.
        const Vec3 g = gradient(distance, p, h);
        if (std::abs(along(root)) < 10 * sharp && g.norm() > 0.5) points.push_back({p, g.normalized()});
      }
      t = next, d = d_next;
    }
  }
  return points;
}

}  // namespace partscribe
