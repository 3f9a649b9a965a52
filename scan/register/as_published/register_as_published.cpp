#include "scan/register/as_published/register_as_published.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/decompose.h"
#include "scan/register/as_published/constrained_icp.h"
#include "scan/register/register_words.h"

namespace partscribe::scan {
namespace {

/// A view that waits for its turn.
struct WaitingView {
  std::size_t view = 0;
  std::vector<ReferencePoint> points;
  std::vector<std::uint8_t> visible = {};
  double shown = 0;            // least_fixed by the visible points
  double held = 0;             // least_fixed by the points that counted in its last registration
  Pose pose = {};              // where that put it
  bool registered = false;     // it did not fail
  std::size_t tried_with = 0;  // views in the model then; 0: not tried
};

/// How well some of its points fix a view: the least, over all directions of motion, of the mean square by which their
/// distances along the normal change (a radian counts as the part's radius); 0 if a motion leaves all of them alone.
double least_fixed(const std::vector<ReferencePoint>& points, const std::vector<std::uint8_t>& some,
                   const ViewSurface& surface) {
  Mat6 sum = Mat6::Zero();
  double count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!some[i]) continue;
    Eigen::Matrix<double, 6, 1> row;
    row << (points[i].place - surface.center).cross(points[i].normal) / surface.radius, points[i].normal;
    sum += row * row.transpose(), ++count;
  }
  return count > 0 ? std::max(0.0, eigenvalues_of(sum)[0] / count) : 0;
}

/// How far a first estimate may carry a point before or behind what it belongs to, of the part's rms radius.
constexpr double estimate_share = 0.2;

/// Less than this and a motion is as good as free: views of a block that two pairs of parallel faces held had 0.0001 at
/// most, others 0.004 and more.
constexpr double held_enough = 0.002;

/// The points of a waiting view that its placed neighbours show by an estimate of its pose.
std::vector<std::uint8_t> visible_by(const WaitingView& waiting, const Pose& estimate, const ViewSurface& surface,
                                     const std::vector<PlacedView>& placed, const PaperOptions& options) {
  return options.visibility ? visible_points(waiting.points, estimate, placed, estimate_share * surface.radius)
                            : std::vector<std::uint8_t>(waiting.points.size(), 1);
}

/// A view registered from its first estimate, and again from what came of that where it shows more, or other, points.
IcpResult registered_from(const Pose& first_estimate, const WaitingView& waiting, const ViewSurface& surface,
                          const std::vector<PlacedView>& placed, const PublishedModel& model,
                          const PaperOptions& options) {
  std::vector<std::uint8_t> visible = waiting.visible;
  IcpResult found = constrained_icp(waiting.points, visible, model, state_of(first_estimate), surface.spacing, options);
  for (int look = 1; look < options.looks && found.failure.empty(); ++look) {
    std::vector<std::uint8_t> now = visible_by(waiting, pose_of(found.state), surface, placed, options);
    if (now == visible) break;
    visible = std::move(now);
    found = constrained_icp(waiting.points, visible, model, found.state, surface.spacing, options);
  }
  return found;
}

}  // namespace

StartResult register_as_published(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                  const PaperOptions& options, Context& context) {
  StartResult result = StartResult::at(guesses, false);
  const std::unique_ptr<PublishedModel> model =
      options.primitives == PaperPrimitives::triangles ? model_of_triangles(options) : model_of_patches(options);
  std::vector<PlacedView> placed;
  std::vector<WaitingView> waiting;
  const auto join = [&](std::size_t v, const Pose& pose) {
    result.poses[v] = pose, result.placed[v] = 1, result.reason[v].clear();
    placed.push_back({&surfaces[v], pose});
    model->add(surfaces[v], pose);
  };
  for (std::size_t v = 0; v < surfaces.size(); ++v) {
    if (!surfaces[v].usable())
      result.reason[v] =
          "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
    else if (placed.empty())
      join(v, guesses[v]);
    else
      waiting.push_back({.view = v, .points = reference_points(surfaces[v], options)});
  }
  while (!context.cancelled) {
    WaitingView *next = nullptr, *loose = nullptr;
    for (WaitingView& w : waiting) {
      if (w.tried_with == placed.size()) {
        if (w.registered && (!loose || w.held > loose->held)) loose = &w;
        continue;
      }
      w.visible = visible_by(w, guesses[w.view], surfaces[w.view], placed, options);
      w.shown = least_fixed(w.points, w.visible, surfaces[w.view]);
      if (!next || w.shown > next->shown) next = &w;
    }
    if (next) {
      const ViewSurface& surface = surfaces[next->view];
      const IcpResult found = registered_from(guesses[next->view], *next, surface, placed, *model, options);
      next->tried_with = placed.size(), next->registered = found.failure.empty();
      next->pose = pose_of(found.state), next->held = least_fixed(next->points, found.valid, surface);
      result.reason[next->view] = found.failure;
      context.say("view " + std::to_string(next->view) + ": " + std::to_string(found.asked) + " of " +
                  std::to_string(next->points.size()) + " points visible, " + std::to_string(found.overlapping) +
                  " overlap after " + std::to_string(found.errors.size()) + " iterations, held by " +
                  in_steps(next->held, 1e-4));
      if (!next->registered || next->held < held_enough) continue;
    } else if (loose) {
      next = loose;  // nobody else can hold it: the part leaves that motion free
    } else {
      break;
    }
    join(next->view, next->pose);
    waiting.erase(waiting.begin() + (next - waiting.data()));
  }
  return result;
}

}  // namespace partscribe::scan
