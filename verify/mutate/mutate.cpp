#include "verify/mutate/mutate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/number.h"
#include "core/random.h"
#include "model/lower/lower.h"
#include "model/surface_patches.h"
#include "verify/mutate/mutate_edits.h"
#include "verify/mutate/mutate_features.h"
#include "verify/mutate/mutate_gauge.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t most_vertices = 24;  // of a triangulation that are moved, one at a time

std::string signed_text(double v) { return (v < 0 ? " - " : " + ") + shown(std::abs(v), 1e-5); }

/// The damaged model for a change of this size, if there is such a model.
using Change = std::function<std::optional<Model>(double size)>;

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
    // Each copy of a pattern can be missing alone.
    for (auto& edit : omissions(lowered(model_, Kinds{}))) take(edit.kind, edit.name, std::move(edit.model));
    for (auto& edit : additions(model_, gauge_)) take_either(edit.kind, edit.name, std::move(edit.model));
    for (const auto& edit : sized_edits(model_)) damage(edit.kind, edit.name, edit.start, edit.exact, edit.change);
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
    if (!passes_check(damaged)) return;
    const double moved = gauge_.moved(damaged);
    if (moved > 1.5 * tolerance_) result_.push_back({kind, name, moved, std::move(damaged)});
  }

  /// False for what is left of bores that have nothing in common: no surface could be measured there.
  bool has_material(const Model& damaged) const {
    const ModelDistance distance(damaged);
    const Vec3 low = gauge_.box().low, size = gauge_.box().size();
    Random random(19);
    for (int i = 0; i < 20000; ++i)
      if (distance.bound(low + size.cwiseProduct(Vec3(random.uniform(), random.uniform(), random.uniform()))) < 0)
        return true;
    return false;
  }

  /// As take, for damages that may only add surface; all larger than the tolerance, or pointless.
  void take_either(Mutation::Kind kind, const std::string& name, Model damaged) {
    if (!passes_check(damaged) || !has_material(damaged)) return;
    const double moved = gauge_.moved_either(damaged);
    if (moved > 3 * tolerance_) result_.push_back({kind, name, moved, std::move(damaged)});
  }

  /// Finds the change of a suitable size. `exact`: 2 T is right if it moves the surface at all visibly.
  /// Returns the size; 0 if there is none, NaN if the surface does not depend on it.
  double suitable(const Change& change, double size, bool exact, Model& damaged, double& moved) {
    bool unseen = false;
    for (int attempt = 0; attempt < 16; ++attempt) {
      auto model = change(size);
      if (!model || !passes_check(*model)) {
        if (attempt > 0) break;
        size = -size;
        model = change(size);
        if (!model || !passes_check(*model)) break;
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
    if (near && passes_check(*near))
      result_.push_back(
          {Mutation::Kind::harmless, what + signed_text(size / 20), gauge_.moved(*near), std::move(*near)});
  }

  /// A first guess of an angle that moves the surface by 2 T.
  double small_angle() const { return 4 * tolerance_ / gauge_.box().diagonal(); }

  void parameters() {
    for (std::size_t i = 0; i < model_.parameters.size(); ++i) {
      if (model_.parameters[i].quantity == Quantity::count && !model_.parameters[i].formula) {
        for (const int more : {-1, 1}) {
          Model m = model_;
          m.parameters[i].value += more;
          take_either(Mutation::Kind::parameter, model_.parameters[i].name + (more > 0 ? " one more" : " one fewer"),
                      std::move(m));
        }
        continue;
      }
      const bool length = model_.parameters[i].quantity == Quantity::length;
      damage(
          Mutation::Kind::parameter, model_.parameters[i].name, length ? 2 * tolerance_ : small_angle(), length,
          [&](double size) -> std::optional<Model> {
            Model m = model_;
            auto& p = m.parameters[i];
            p.value += size, p.fitted = p.value, p.nominal.reset();
            if (p.formula) p.formula = *p.formula + Expr(size);
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
      if (e.is_parameter() || domain == Domain::component || domain == Domain::count) continue;
      const bool length = domain == Domain::length || domain == Domain::length_or_zero || domain == Domain::coordinate;
      const std::string what =
          model_.objects[o].name + ": value " + print_number(double(i + 1)) + ", " + shown(evaluate(e, values_), 1e-5);
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
    const Sketch* sketch = sketch_of(model_.objects[o].shape);
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
      damage(Mutation::Kind::dented, model_.objects[o].name + ": vertex " + print_number(double(i)), 4 * tolerance_,
             false, [&, i, n](double size) -> std::optional<Model> {
               Model m = model_;
               auto& v = std::get<TriSurface>(m.objects[o].shape).vertices[i];
               for (std::size_t k = 0; k < 3; ++k) v[k] += size * n[int(k)];
               return m;
             });
    }
  }

  /// Control points of surfaces, each along the normal of the surface where it acts most.
  void control_points(std::size_t o) {
    const auto patches = patches_of(model_.objects[o].shape);
    for (std::size_t p = 0; p < patches.size(); ++p) {
      const NurbsSurface surface = trimmed_surface(*patches[p]).surface;
      const auto acts_at = [](const KnotVector& t, std::size_t i) {
        double sum = 0;
        for (int k = 1; k <= t.degree; ++k) sum += t.knots[i + static_cast<std::size_t>(k)];
        return sum / t.degree;
      };
      const auto columns = static_cast<std::size_t>(surface.v.count());
      const std::size_t count = surface.points.size(), stride = std::max<std::size_t>(1, count / most_vertices + 1);
      for (std::size_t i = 0; i < count; i += stride) {
        const Vec3 n = surface.derivatives(acts_at(surface.u, i / columns), acts_at(surface.v, i % columns)).normal();
        if (!(n.norm() > 0)) continue;
        damage(Mutation::Kind::dented, patches[p]->name + ": control point " + print_number(double(i)), 4 * tolerance_,
               false, [&, p, i, n](double size) -> std::optional<Model> {
                 Model m = model_;
                 auto& point = patches_of(m.objects[o].shape)[p]->control[i];
                 for (std::size_t k = 0; k < 3; ++k) point[k] += size * n[int(k)];
                 return m;
               });
      }
    }
  }

  void numbers(std::size_t o) {
    expressions(o);
    curve_numbers(o);
    tilts(o);
    vertices(o);
    control_points(o);
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
      damage(Mutation::Kind::part_moved, "part moved along " + name, 2 * tolerance_, true,
             [&](double size) -> std::optional<Model> { return placed(shift(size * axis)); });
      damage(Mutation::Kind::part_turned, "part turned about " + name, small_angle(), false,
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
        damage(k < 3 ? Mutation::Kind::feature_moved : Mutation::Kind::feature_turned, name,
               k < 3 ? 2 * tolerance_ : small_angle(), k < 3, [&](double size) -> std::optional<Model> {
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
    const double moved = passes_check(model) ? gauge_.moved(model) : 0;
    if (moved > 1.5 * tolerance_) {
      result_.push_back({Mutation::Kind::scaled, "scaled by 1.005", moved, std::move(model)});
    } else if (moved > 0) {
      const double factor = 1 + 0.005 * 2 * tolerance_ / moved;
      take(Mutation::Kind::scaled,
           "scaled by " + shown(factor, 1e-5) + " (0.5 % moves the surface by " + shown(moved, 1e-5) + " only)",
           scaled(model_, factor, middle_));
    }
  }
};

}  // namespace

const char* name_of(Mutation::Kind kind) {
  switch (kind) {
    case Mutation::Kind::parameter:
      return "parameter off by 2 T";
    case Mutation::Kind::number:
      return "number off by 2 T";
    case Mutation::Kind::dented:
      return "corner of a mesh moved";
    case Mutation::Kind::hole_size:
      return "one hole of another diameter";
    case Mutation::Kind::part_moved:
      return "part moved";
    case Mutation::Kind::part_turned:
      return "part turned";
    case Mutation::Kind::feature_moved:
      return "feature moved";
    case Mutation::Kind::feature_turned:
      return "feature tilted";
    case Mutation::Kind::feature_missing:
      return "hole or boss missing";
    case Mutation::Kind::edge_missing:
      return "fillet or edge missing";
    case Mutation::Kind::face_missing:
      return "face missing";
    case Mutation::Kind::hole_added:
      return "extra hole";
    case Mutation::Kind::hole_doubled:
      return "hole twice";
    case Mutation::Kind::hole_depth:
      return "hole of wrong depth";
    case Mutation::Kind::boss_added:
      return "extra boss";
    case Mutation::Kind::rounded:
      return "sharp edge rounded";
    case Mutation::Kind::tapered:
      return "wall tapered";
    case Mutation::Kind::reordered:
      return "sketch elements swapped";
    case Mutation::Kind::combined:
      return "added instead of cut away";
    case Mutation::Kind::sheet_added:
      return "thin spurious sheet";
    case Mutation::Kind::body_doubled:
      return "shifted duplicate";
    case Mutation::Kind::body_added:
      return "separate body";
    case Mutation::Kind::mirrored:
      return "mirrored";
    case Mutation::Kind::scaled:
      return "scaled";
    case Mutation::Kind::harmless:
      return "harmless";
  }
  return "harmless";
}

bool of_whole_part(Mutation::Kind kind) {
  return kind == Mutation::Kind::part_moved || kind == Mutation::Kind::part_turned ||
         kind == Mutation::Kind::mirrored || kind == Mutation::Kind::scaled;
}

std::vector<Mutation> mutations_of(const Model& model) { return Damages(model).run(); }

}  // namespace partscribe::verify
