#include "fit/propose/drilled.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/evidence/evidence.h"
#include "fit/propose/drill.h"
#include "geometry/points/keep_points.h"
#include "geometry/segment/holes.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

/// What lies beyond the seen end of a hole, before its mouth as one looks in.
struct Beyond {
  bool bars = false;            ///< something does: a floor, or the other side of the part
  std::optional<double> floor;  ///< mm below the mouth
};

Beyond beyond_end_of(const FoundHole& found, double seen, const FitInput& input) {
  constexpr double near_axis = 0.7;  // of the radius
  constexpr double looks_out = 0.7;  // cosine
  constexpr std::size_t least = 5;   // points of a floor
  const double reach = near_axis * 0.5 * found.diameter();
  Beyond beyond;
  std::vector<double> floor;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 d = input.cloud.points[i] - found.mouth;
    const double depth = -d.dot(found.axis);
    if (depth < seen - input.tolerance || (d + depth * found.axis).norm() > reach) continue;
    beyond.bars = true;
    if (input.oriented && input.cloud.normals[i].dot(found.axis) > looks_out) floor.push_back(depth);
  }
  if (floor.size() < least) return beyond;
  std::ranges::sort(floor);
  const double nearest = floor[least / 2];  // an outlier or two may lie before it
  std::erase_if(floor, [&](double depth) { return std::abs(depth - nearest) > 2 * input.tolerance; });
  if (floor.size() >= least) beyond.floor = median(std::move(floor));
  return beyond;
}

DrilledHole drilled(const FoundHole& found, const FitInput& input) {
  DrilledHole hole;
  const auto size = [&](const char* name) {
    const auto at = std::ranges::find(found.feature.dimensions, name, &FeatureSize::name);
    return at == found.feature.dimensions.end() ? 0 : at->value;
  };
  HoleOf<double>& form = hole.form;
  form.diameter = size("diameter"), form.depth = size("depth"), form.tip_angle = size("tip angle");
  form.through = found.far_end == RimState::open;
  if (found.far_end == RimState::unknown) {
    const Beyond beyond = beyond_end_of(found, form.depth, input);
    form.through = !beyond.bars, form.depth = beyond.floor.value_or(form.depth);
    hole.floor_seen = beyond.floor.has_value();
  }
  form.head_diameter = size("counterbore diameter"), form.head_depth = size("counterbore depth");
  form.sink_diameter = size("countersink diameter");
  if (form.sink_diameter > 0) form.sink_angle = size("countersink angle");
  hole.sigma = std::max(found.sigma_point, 0.5 * found.sigma_diameter());
  hole.mouth = found.mouth, hole.out = found.axis, hole.point = found.point;
  hole.sigma_axis = found.sigma_axis;
  return hole;
}

std::vector<DrilledHole> holes_in(const FitInput& input, const Faces& faces) {
  const FeatureScale scale = feature_scale(faces);
  std::vector<DrilledHole> holes;
  for (const FoundHole& found : holes_of(faces, round_pieces(faces, scale), scale))
    holes.push_back(drilled(found, input));
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
  keep_entries(rest.surface_share, keep), keep_entries(rest.facet_depth, keep);
  rest.bounds = rest.cloud.bounds();
  rest.surroundings = surroundings_of(rest, context);
  return rest;
}

}  // namespace

std::vector<Candidate> propose_drilled(const FitInput& input, const Faces& faces, const BodyMaker& bodies,
                                       Context& context) {
  std::vector<Candidate> candidates;
  const std::vector<DrilledHole> holes = holes_in(input, faces);
  if (holes.empty()) return candidates;
  const FitInput rest = without(holes, input, context);
  constexpr std::size_t least_points = 50;
  if (rest.cloud.size() < least_points) return candidates;
  context.say("drilled: " + print_number(double(holes.size())) + " holes, " + print_number(double(rest.cloud.size())) +
              " points outside of them");
  for (const Candidate& body : best_bodies(bodies(rest), rest, "drilled", context)) {
    if (in_sketch(body, holes)) break;  // cheaper than what follows, and found as one extrusion
    // Numbers that may be equal are one; the total cost says whether they are.
    std::size_t parameters = 0;
    for (const double alike : {0.5 * input.tolerance, 0.0})
      if (auto part = with_holes(body, holes, {input.tolerance, alike, 2 * input.thin_spacing});
          part && part->parameters.size() != parameters) {
        parameters = part->parameters.size();
        candidates.push_back(std::move(*part));
      }
  }
  return candidates;
}

}  // namespace partscribe::fit
