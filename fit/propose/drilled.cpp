#include "fit/propose/drilled.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "fit/propose/drill.h"
#include "fit/refine/refine.h"
#include "geometry/points/keep_points.h"
#include "geometry/segment/holes.h"
#include "model/check.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

DrilledHole drilled(const FoundHole& found) {
  DrilledHole hole;
  const auto size = [&](const char* name) {
    const auto at = std::ranges::find(found.feature.dimensions, name, &FeatureSize::name);
    return at == found.feature.dimensions.end() ? 0 : at->value;
  };
  HoleOf<double>& form = hole.form;
  form.diameter = size("diameter"), form.depth = size("depth"), form.through = !found.closed;
  form.tip_angle = size("tip angle");
  form.head_diameter = size("counterbore diameter"), form.head_depth = size("counterbore depth");
  form.sink_diameter = size("countersink diameter");
  if (form.sink_diameter > 0) form.sink_angle = size("countersink angle");
  hole.sigma = std::max(found.sigma_point, 0.5 * found.sigma_diameter());
  hole.mouth = found.mouth, hole.out = found.axis;
  return hole;
}

std::vector<DrilledHole> holes_in(const FitInput& input, Context& context) {
  FaceOptions options;
  options.tolerance = input.tolerance;
  const Faces faces =
      input.closed ? faces_of(*input.scan, options, context) : faces_of_cloud(input.cloud, options, context);
  const FeatureScale scale = feature_scale(faces);
  std::vector<DrilledHole> holes;
  for (const FoundHole& found : holes_of(faces, round_pieces(faces, scale), scale)) holes.push_back(drilled(found));
  return holes;
}

/// The part that a hole takes out of a scan.
class Cutter {
 public:
  explicit Cutter(const DrilledHole& hole)
      : distance_(model_of(hole)), hole_from_scan_(Pose{rotation_onto_axis(hole.out), hole.mouth}.inverse()) {}
  double distance(const Vec3& p) const { return distance_(hole_from_scan_ * p).distance; }

 private:
  ModelDistance distance_;
  Pose hole_from_scan_;

  static Model model_of(const DrilledHole& hole) {
    const HoleOf<double>& f = hole.form;
    Model model;
    model.objects.push_back({"hole",
                             Hole{f.diameter, f.depth, f.through, f.tip_angle, f.head_diameter, f.head_depth,
                                  f.sink_diameter, f.sink_angle, f.overshoot},
                             {},
                             {},
                             {}});
    model.as_scanned = false;
    return model;
  }
};

/// The input without the points of the holes.
FitInput without(const std::vector<DrilledHole>& holes, const FitInput& input, Context& context) {
  const double reach = std::max(input.tolerance, 4 * input.sampling.sigma);
  std::vector<std::uint8_t> keep(input.cloud.size(), 1);
  for (const DrilledHole& hole : holes) {
    const Cutter cutter(hole);
    for (std::size_t i = 0; i < keep.size(); ++i)
      if (keep[i] && cutter.distance(input.cloud.points[i]) < reach) keep[i] = 0;
  }
  FitInput rest = input;
  keep_points(rest.cloud, keep);
  const auto keep_of = [&](auto& column) {
    if (column.size() != keep.size()) return;
    std::size_t to = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
      if (keep[i]) column[to++] = column[i];
    column.resize(to);
  };
  keep_of(rest.surface_share), keep_of(rest.facet_depth);
  rest.bounds = rest.cloud.bounds();
  rest.surroundings = surroundings_of(rest, context);
  return rest;
}

}  // namespace

std::vector<Candidate> propose_drilled(const FitInput& input, const BodyMaker& bodies, Context& context) {
  std::vector<Candidate> candidates;
  const std::vector<DrilledHole> holes = holes_in(input, context);
  if (holes.empty()) return candidates;
  const FitInput rest = without(holes, input, context);
  constexpr std::size_t least_points = 50;
  if (rest.cloud.size() < least_points) return candidates;
  context.say("drilled: " + print_number(double(holes.size())) + " holes, " +
              print_number(double(rest.cloud.size())) + " points outside of them");
  for (Candidate& body : bodies(rest)) {
    if (context.cancelled) break;
    if (!drawable(body) || std::holds_alternative<Complaints>(check(bare_model(body)))) continue;
    RefineOptions quick;
    quick.points = 6000, quick.iterations = 25, quick.uncertainty = false;
    refine(body, rest, quick, context);
    if (!drawable(body) || std::holds_alternative<Complaints>(check(bare_model(body)))) continue;
    const double off = evidence_of(body, rest, context).local_max;
    auto part = off <= input.tolerance ? with_holes(body, holes, input.tolerance) : std::nullopt;
    context.say("drilled: " + body.procedure + " off by " + millimetres(off, input.tolerance) +
                (off > input.tolerance ? "" : part ? ", drilled" : ", a hole does not lie in it"));
    if (part) candidates.push_back(std::move(*part));
  }
  return candidates;
}

}  // namespace partscribe::fit
