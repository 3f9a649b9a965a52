#include "testing/recovery/score.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <numeric>

#include "core/number.h"
#include "fit/build.h"
#include "model/distance/distance.h"
#include "model/sketch.h"

namespace partscribe::testing::recovery {

using namespace fit;

namespace {

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

Values fitted_values(const Model& model) {
  Values v;
  for (const auto& p : model.parameters) v[p.name] = p.fitted;
  return v;
}

/// Numbers of a shape in an order that does not depend on how it stands; every equivalent way to write it.
std::vector<std::vector<double>> ways_to_write(const EvaluatedShape& shape) {
  if (const auto* s = std::get_if<SphereOf<double>>(&shape)) return {{s->radius}};
  if (const auto* s = std::get_if<EllipsoidOf<double>>(&shape)) {
    std::vector<double> r = {s->radius_x, s->radius_y, s->radius_z};
    std::sort(r.rbegin(), r.rend());
    return {r};
  }
  if (const auto* s = std::get_if<BoxOf<double>>(&shape)) {
    std::vector<double> r = {s->size_x, s->size_y, s->size_z};
    std::sort(r.rbegin(), r.rend());
    return {r};
  }
  if (const auto* s = std::get_if<CylinderOf<double>>(&shape)) return {{s->radius, s->height}};
  if (const auto* s = std::get_if<TorusOf<double>>(&shape)) return {{s->major_radius, s->minor_radius}};
  if (const auto* s = std::get_if<ConeOf<double>>(&shape)) {
    if (s->top_radius == 0) return {{s->bottom_radius, s->height}};
    if (s->bottom_radius == 0) return {{s->top_radius, s->height}};
    const double a = std::max(s->bottom_radius, s->top_radius), b = std::min(s->bottom_radius, s->top_radius);
    return {{a, s->height, b}, {a, b, s->height}};  // the truth's order is one of these
  }
  if (const auto* s = std::get_if<WedgeOf<double>>(&shape)) {
    if (s->top_x == 0) return {{s->size_x, s->size_y, s->size_z}, {s->size_y, s->size_x, s->size_z}};
    return {{s->size_x, s->size_y, s->size_z, s->top_x}};
  }
  if (const auto* s = std::get_if<SuperellipsoidOf<double>>(&shape)) {
    // Where the exponents are equal, all three axes mean the same; where they are not, the numbers tell.
    std::vector<std::vector<double>> ways;
    for (const auto& a :
         {std::array{s->a1, s->a2, s->a3}, std::array{s->a2, s->a3, s->a1}, std::array{s->a3, s->a1, s->a2}})
      for (const auto& [e1, e2] : {std::pair{s->e1, s->e2}, std::pair{s->e2, s->e1}}) {
        ways.push_back({a[0], a[1], a[2], e1, e2});
        ways.push_back({a[1], a[0], a[2], e1, e2});
      }
    return ways;
  }
  if (const auto* s = std::get_if<SupertoroidOf<double>>(&shape))
    return {{s->major_radius, s->minor_radius, s->half_height, s->e1, s->e2}};
  if (const auto* s = std::get_if<FilletOf<double>>(&shape)) {
    if (s->width == s->height) return {{s->width, s->length}};
    return {{s->width, s->height, s->length}, {s->height, s->width, s->length}};
  }
  return {};
}

/// Square roots of the diagonal of the inverse normal matrix at the truth, with a wide prior for what is free.
std::vector<double> bounds_of(const Case& c) {
  const Values truth = values_of(c.truth);
  const ModelDistance distance(c.truth, truth);
  const Pose part_from_scan = c.scan_from_part.inverse();
  const auto n = static_cast<Eigen::Index>(c.truth.parameters.size());
  const double h = 1e-6 * c.size;
  std::vector<ModelDistance> shifted;
  for (const auto& p : c.truth.parameters) {
    Values v = truth;
    v[p.name] += h;
    shifted.emplace_back(c.truth, v);
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n + 6, n + 6) / (c.size * c.size);
  for (std::size_t i = 0; i < c.exact.size(); ++i) {
    const Vec3 q = part_from_scan * c.exact[i];
    const double d = distance(q).distance;
    Eigen::VectorXd row(n + 6);
    for (Eigen::Index k = 0; k < n; ++k) row[k] = (shifted[static_cast<std::size_t>(k)](q).distance - d) / h;
    Vec3 g;
    for (int k = 0; k < 3; ++k)
      g[k] = (distance(q + h * Vec3::Unit(k)).distance - distance(q - h * Vec3::Unit(k)).distance) / (2 * h);
    row.segment<3>(n) = g;
    row.segment<3>(n + 3) = q.cross(g) / c.size;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(row, 1 / (c.sigma[i] * c.sigma[i]));
  }
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(normal.selfadjointView<Eigen::Lower>()).inverse();
  std::vector<double> result;
  for (Eigen::Index k = 0; k < n; ++k) result.push_back(std::sqrt(inverse(k, k)));
  return result;
}

/// Straight-sided outline: what an extrusion needs to be a box or a wedge in other words.
bool straight_outline(const EvaluatedShape& shape, std::size_t least, std::size_t most) {
  const auto* e = std::get_if<ExtrudeOf<double>>(&shape);
  if (!e || e->sketch.loops.size() != 1) return false;
  const auto& elements = e->sketch.loops[0].elements;
  return elements.size() >= least && elements.size() <= most &&
         std::all_of(elements.begin(), elements.end(),
                     [](const auto& s) { return std::holds_alternative<SketchPointOf<double>>(s); });
}

/// Two straight walls and an arc: a round fillet in other words, if its surface agrees.
bool fillet_outline(const EvaluatedShape& shape) {
  const auto* e = std::get_if<ExtrudeOf<double>>(&shape);
  if (!e || e->sketch.loops.size() != 1) return false;
  const Outline2 outline = outline_of(e->sketch);
  return outline.curves.size() == 3 &&
         std::count_if(outline.curves.begin(), outline.curves.end(),
                       [](const OutlineCurve& c) { return std::holds_alternative<Arc2>(c.curve); }) == 1;
}

bool same_kind(const std::string& truth, const EvaluatedShape& found) {
  if (truth == kind_of(found)) return true;
  if (truth == "box") return straight_outline(found, 4, 4);
  if (truth == "wedge") return straight_outline(found, 3, 4);
  if (truth == "fillet") return fillet_outline(found);
  // A plate with holes: the surface says whether it is the same.
  if (truth == "extrude") return std::holds_alternative<DifferenceOf<double>>(found);
  return false;
}

/// True if the model says which of its faces were not scanned.
bool names_hidden_faces(const Model& model) {
  return std::any_of(model.parameters.begin(), model.parameters.end(),
                     [](const Parameter& p) { return p.note.find("not scanned") != std::string::npos; });
}

/// Root mean square distance (mm) of the places from the surface, those within reach of the model's own sigmas counted
/// as none: of what four sigmas of its numbers move the surface by there.
double beyond_own_sigmas(const Model& model, const Values& values, const std::vector<Vec3>& places) {
  struct Moved {
    ModelDistance surface;
    double sigmas;  // how many times the step its sigma is
  };
  std::vector<Moved> moved;
  for (const Parameter& p : model.parameters) {
    Values v = values;
    const double h = std::max(1e-4 * std::abs(p.fitted), 1e-6);
    v[p.name] += h;
    moved.push_back({ModelDistance(model, v), p.sigma / h});
  }
  const ModelDistance surface(model, values);
  double sum = 0;
  for (const Vec3& place : places) {
    const double d = surface(place).distance;
    double variance = 0;
    for (const Moved& m : moved) variance += std::pow((m.surface(place).distance - d) * m.sigmas, 2);
    if (std::abs(d) > 4 * std::sqrt(variance)) sum += d * d;
  }
  return std::sqrt(sum / double(places.size()));
}

/// Of the numbers of a shape, written in each of these ways: the model's own sigmas, by how much each of its parameters
/// moves the number.
std::vector<std::vector<double>> sigmas_of(const Model& model, const Values& values,
                                           const std::vector<std::vector<double>>& ways) {
  std::vector<std::vector<double>> sigmas = ways;
  for (auto& way : sigmas) std::ranges::fill(way, 0.0);
  for (const Parameter& p : model.parameters) {
    Values v = values;
    const double h = std::max(1e-6 * std::abs(p.fitted), 1e-9);
    v[p.name] += h;
    const auto moved = ways_to_write(evaluate(model.objects.back().shape, v));
    for (std::size_t w = 0; w < ways.size() && w < moved.size(); ++w)
      for (std::size_t k = 0; k < ways[w].size() && k < moved[w].size(); ++k)
        sigmas[w][k] = std::hypot(sigmas[w][k], (moved[w][k] - ways[w][k]) / h * p.sigma);
  }
  return sigmas;
}

/// What users read for a kind.
std::string procedure_of(const std::string& kind) {
  return kind == "half_spaces" ? "convex polyhedron"
         : kind == "revolve"   ? "surface of revolution"
         : kind == "extrude"   ? "extrusion"
                               : kind;
}

/// True if the model says that `kind` fits as well or that the data cannot tell.
bool admits(const Model& model, const std::string& kind) {
  const std::string procedure = procedure_of(kind);
  return std::any_of(model.rivals.begin(), model.rivals.end(), [&](const Rival& r) {
    const bool open =
        r.reason.find("cannot tell") != std::string::npos || r.reason.find("fits as well") != std::string::npos;
    return open && (r.reason.find(procedure) != std::string::npos || r.procedure.find(procedure) != std::string::npos);
  });
}

}  // namespace

const char* name_of(Answer answer) {
  return answer == Answer::right ? "right" : answer == Answer::cannot_tell ? "cannot tell" : "wrong";
}

Score recovered(const Case& c, Context& context) {
  Score score;
  Scan scan = c.scan;
  BuildOptions options;
  options.tolerance = c.tolerance;
  options.triangulate = false;
  const double start = processor_seconds();
  const auto built = build_model(scan, options, context);
  score.seconds = processor_seconds() - start;
  if (!built) {
    score.found = "mesh", score.why = built.error().message;
    score.answer = Answer::cannot_tell;
    return score;
  }
  const Model& model = **built;
  score.model = *built, score.rejected = scan.cloud.rejected;
  const Values values = fitted_values(model);
  const EvaluatedShape shape = evaluate(model.objects.back().shape, values);
  score.found = std::string(kind_of(shape));

  const ModelDistance surface(model, values);
  double sum = 0, noise = 0;
  std::vector<double> sizes;
  for (std::size_t i = 0; i < c.exact.size(); ++i) {
    const double d = surface(c.exact[i]).distance;
    sum += d * d, noise += c.sigma[i] * c.sigma[i];
    sizes.push_back(std::abs(d));
  }
  const double count = double(c.exact.size());
  const double numbers = double(model.parameters.size() + 6);
  const double expected = std::sqrt(noise / count * numbers / count);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(0.95 * count), sizes.end());
  score.surface_error = std::sqrt(sum / count) / expected;

  if (!same_kind(c.kind, shape)) {
    // What was seen is followed as exactly as can be, and the rest is said to be unknown.
    const bool hidden = score.surface_error < 3 && names_hidden_faces(model);
    score.answer = hidden || admits(model, c.kind) ? Answer::cannot_tell : Answer::wrong;
    score.why = "is a " + score.found;
    return score;
  }
  score.answer = Answer::right;
  const auto bounds = bounds_of(c);
  const auto truth = ways_to_write(evaluate(c.truth.objects.back().shape, values_of(c.truth)));
  const auto found = ways_to_write(shape);
  double worst = -1;
  if (!truth.empty() && score.found == c.kind && found.front().size() == truth.front().size()) {
    // The truth's numbers stand in the order of its parameters, which is one of its ways.
    std::vector<double> wanted;
    for (const auto& p : c.truth.parameters) wanted.push_back(p.value);
    double best = 1e300;
    const auto sigmas = sigmas_of(model, values, found);
    for (std::size_t w = 0; w < found.size(); ++w) {
      const auto& way = found[w];
      double most = 0;
      std::vector<Score::Number> of_way;
      std::vector<double> open;
      for (std::size_t k = 0; k < wanted.size(); ++k) {
        const double error = std::abs(way[k] - wanted[k]);
        const double sigma = sigmas[w][k];
        if (bounds[k] > 0.1 * c.size) {
          open.push_back(error / std::max(sigma, 1e-9));
          continue;
        }
        most = std::max(most, std::min(error / std::max(4 * sigma, 1e-9), error / (6 * bounds[k])));
        const double typical = 0.6745 * bounds[k];
        of_way.push_back({k, typical, error / typical});
      }
      const bool nearer =
          std::accumulate(open.begin(), open.end(), 0.0) < std::accumulate(score.open.begin(), score.open.end(), 0.0);
      if (most < best || (most == best && nearer)) best = most, score.numbers = of_way, score.open = open;
    }
    // Nearly equal exponents: another axis in the middle writes the same surface within the noise.
    if (best > 1 && c.kind == "superellipsoid" && score.surface_error < 2) best = -1, score.numbers.clear();
    worst = best;
  }
  const double off = sizes[static_cast<std::size_t>(0.95 * count)];
  if (worst > 1) {
    score.answer = Answer::wrong;
    score.why = "a number is " + print_number(snapped(worst, 0.1)) + " times the allowed error off";
  } else if (worst < 0 && score.surface_error > 6 && off > c.close) {
    const bool said = beyond_own_sigmas(model, values, c.exact) < 6 * expected;
    score.answer = said ? Answer::cannot_tell : Answer::wrong;
    score.why = "the surface is " + print_number(snapped(score.surface_error, 0.1)) + " times the expected error off" +
                (said ? ", as its sigmas say" : "");
  }
  return score;
}

}  // namespace partscribe::testing::recovery
