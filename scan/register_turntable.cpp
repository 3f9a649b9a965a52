#include "scan/register_turntable.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/number.h"
#include "core/parallel.h"
#include "scan/register_features.h"
#include "scan/register_relief.h"
#include "scan/register_words.h"
#include "scan/round_views.h"

namespace partscribe {

Turntable table_of(const std::vector<Pose>& first_from_view, const Vec3& near) {
  Turntable table{Vec3::Zero(), Vec3::Zero(), 0, 0, true, {}};
  double weights = 0;
  for (std::size_t v = 0; v + 1 < first_from_view.size(); ++v) {
    FixedLine line = fixed_line(first_from_view[v].inverse() * first_from_view[v + 1], near);
    if (table.axis.dot(line.axis) < 0) line.axis = -line.axis, line.angle = -line.angle;
    const double w = line.angle * line.angle;  // the axis of a small turn is not sure
    table.axis += w * line.axis, table.point += w * line.point, weights += w;
    table.steps.push_back(line.angle), table.step += line.angle / double(first_from_view.size() - 1);
  }
  table.axis.normalize(), table.point /= weights;
  return table;
}

namespace {

/// The axis that most normals of all views meet while they lie in the sensor's frame: a.(p x n) + m.n = 0 (Pottmann &
/// Wallner 2001), by iterated weights. Nothing if fewer than half of them do.
std::optional<AxisLine> axis_of_normals(const std::vector<ViewSurface>& surfaces) {
  const double size = surfaces[0].radius;
  const Vec3 center = surfaces[0].center;
  std::optional<AxisLine> line;
  double kept = 0;
  for (int round = 0; round < 25; ++round) {
    Mat6 sum = Mat6::Zero();
    double weights = 0, count = 0;
    const double width = std::max(0.15, 0.6 * std::pow(0.85, round));
    for (const ViewSurface& surface : surfaces)
      // Not the samples: they favour rare directions.
      for (std::size_t i = 0; i < surface.points.size(); i += 11) {
        if (!surface.smooth[i]) continue;
        const Vec3 p = (surface.points[i] - center) / size, normal = surface.normals[i];
        const double off = line ? off_axis(*line, surface.points[i], normal, 0.02 * size) : 0;
        const double w = std::exp(-off * off / (2 * width * width));
        Eigen::Matrix<double, 6, 1> l;
        l << p.cross(normal), normal;
        sum += w * l * l.transpose();
        weights += w, ++count;
      }
    kept = weights / count;
    const Mat3 a = sum.topLeftCorner<3, 3>(), b = sum.topRightCorner<3, 3>();
    const Mat3 d = sum.bottomRightCorner<3, 3>() + 1e-9 * count * Mat3::Identity();
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(a - b * d.inverse() * b.transpose());
    const Vec3 axis = eigen.eigenvectors().col(0);
    Vec3 moment = -d.inverse() * b.transpose() * axis;
    moment -= moment.dot(axis) * axis;
    line = AxisLine{center + size * axis.cross(moment), axis};
  }
  if (kept < 0.5) return {};
  return line;
}

std::vector<Pose> powers(const Pose& step, std::size_t count) {
  std::vector<Pose> result{Pose{}};
  while (result.size() < count) result.push_back(result.back() * step);
  return result;
}

/// The mean score of all views at equal steps.
double score_of(const std::vector<ViewSurface>& surfaces, const Pose& step, double reach, std::size_t samples) {
  const auto poses = powers(step, surfaces.size());
  std::vector<std::size_t> all(surfaces.size());
  for (std::size_t v = 0; v < all.size(); ++v) all[v] = v;
  double sum = 0;
  for (const std::size_t v : all) {
    const Agreement a = agreement(surfaces, poses, v, poses[v], all, reach, samples);
    // What a part hides from itself differs little between steps; surfaces that no other view confirms count most.
    sum += a.overlap() - 3 * a.seen_through();
  }
  return sum / static_cast<double>(surfaces.size());
}

void keep_round(std::vector<ViewSurface>& surfaces, const AxisLine& line) {
  for (ViewSurface& s : surfaces)
    std::erase_if(s.samples, [&](std::uint32_t i) { return !round_about(line, s, i); });
}

std::string in_words(const DepthCorrection& depth) {
  return "seen from every side the part is round only with depths " + in_percent(std::abs(depth.stretch)) + " (sigma " + in_percent(depth.stretch_sigma) +
         (depth.stretch < 0 ? ") smaller" : ") larger") + " and sheared by " + in_percent(depth.shear) + " of the width: depths and widths of this scanner do not agree; ";
}

/// Of a round part: by how far it turned, told by its relief. Without relief there are no poses, and only what is wrong with depths is said.
TurntableStart turned_by_relief(const std::vector<RegisterView>& views, const std::vector<ViewSurface>& surfaces, const AxisLine& axis,
                                const RegisterOptions& options, Context& context) {
  const RoundFits round = round_views(surfaces, axis);
  // Cells of a few points each; surfaces may be thinned.
  double cell = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    cell = std::max(cell, 3 * surfaces[v].spacing * std::sqrt(double(surfaces[v].points.size()) / double(views[v].cloud.size())));
  auto poses = poses_by_relief(views, round.rounder ? *round.rounder : round.raw, cell, context);
  TurntableStart result;
  if (round.rounder) {
    result.trouble = in_words(round.rounder->depth) + (!poses ? "it is too smooth to correct that" : options.correct_depth ? "depths are corrected, and no size is surer than that" : "ask for corrected depths (--correct-depth)");
    if (poses && options.correct_depth) result.depth = round.rounder->depth;
  }
  if (!poses) return result;
  result.table = table_of(*poses, surfaces[0].center);
  result.start = StartResult::at(std::move(*poses), true);
  return result;
}

}  // namespace

std::optional<TurntableStart> start_from_turntable(const std::vector<RegisterView>& views, std::vector<ViewSurface>& surfaces, const RegisterOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  if (n < 2) return {};
  double radius = 0, spacing = 0, sigma = 0;
  for (const ViewSurface& s : surfaces) {
    if (!s.usable()) return {};
    radius = std::max(radius, s.radius), spacing = std::max(spacing, s.spacing), sigma = std::max(sigma, s.sigma);
  }
  context.report("looking for the axis", 0);
  // What stands still beside a round part, such as the foot of the table, is not round about its axis and left out.
  const auto round_axis = axis_of_normals(surfaces);
  if (round_axis) keep_round(surfaces, *round_axis);
  const double coarse_cell = std::max(radius / 12, 2 * spacing), reach = (round_axis ? 2 : 1) * confirm_reach(surfaces);
  std::vector<Surfels> few, many;
  std::vector<std::unique_ptr<PlacedModel>> coarse, fine;
  const std::vector<Pose> still(n);
  for (std::size_t v = 0; v < n; ++v) {
    few.push_back(sample_surfels(surfaces[v], 300)), many.push_back(sample_surfels(surfaces[v], 1200));
    coarse.push_back(place_surfaces(surfaces, still, {v}, coarse_cell));
    fine.push_back(place_surfaces(surfaces, still, {v}, 1.5 * spacing));
  }
  const auto pairs_of = [&](const std::vector<Surfels>& sources, const std::vector<std::unique_ptr<PlacedModel>>& targets) {
    std::vector<AlignPair> pairs;
    for (std::size_t v = 0; v + 1 < n; ++v) pairs.push_back({&sources[v + 1], targets[v].get()});
    return pairs;
  };
  const auto rough_pairs = pairs_of(few, coarse), exact_pairs = pairs_of(many, fine);

  std::vector<Pose> starts;
  const double cell = std::max(radius / 16, 2 * spacing);
  std::vector<std::unique_ptr<Features>> features;
  for (const ViewSurface& s : surfaces) features.push_back(features_of(s, cell));
  for (std::size_t v = 0; v + 1 < n; ++v)
    for (const Pose& pose : feature_poses(*features[v + 1], *features[v], 12)) starts.push_back(pose);
  const double full = 2 * pi / static_cast<double>(n);
  struct Scored {
    Pose step;
    double score = -1e30;
  };
  std::vector<Scored> scored(starts.size());
  AlignOptions rough;
  rough.start_reach = 0.35 * radius, rough.end_reach = coarse_cell, rough.noise = 0.1 * coarse_cell, rough.iterations = 40, rough.pure_rotation = true;
  parallel_for(starts.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Pose step = align_symmetric(rough_pairs, starts[k], rough);
      const Vec3 turn = rotation_vector(step.rotation);
      if (turn.norm() < 0.05) continue;
      // A long round part also fits when it is turned end over end.
      if (round_axis && std::abs(turn.normalized().dot(round_axis->axis)) < 0.9) continue;
      scored[k] = {step, score_of(surfaces, step, 4 * reach, 100)};
    }
  }, 1);
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Scored> best;
  for (const Scored& s : scored) {
    bool known = false;
    for (const Scored& b : best) known = known || rotation_vector(b.step.rotation.transpose() * s.step.rotation).norm() < 0.05;
    if (!known && s.score > -1e29) best.push_back(s);
    if (best.size() >= 8) break;
  }
  // Round parts start on their axis; anything coarser than their radius would lose it.
  if (round_axis) {
    best.clear();
    for (const double angle : {full, pi / 12, pi / 6, pi / 4, pi / 2})
      for (const double sign : {1.0, -1.0}) best.push_back({rotation_about(round_axis->point, round_axis->axis, sign * angle)});
  }
  AlignOptions exact;
  exact.start_reach = coarse_cell, exact.end_reach = std::max(1.5 * spacing, 4 * sigma), exact.noise = std::max(0.5 * sigma, 0.02 * spacing), exact.pure_rotation = true;
  if (round_axis) exact.start_reach = 6 * spacing;
  for (Scored& s : best) {
    s.step = align_symmetric(exact_pairs, s.step, exact);
    s.score = rotation_vector(s.step.rotation).norm() < 0.05 ? -1e30 : score_of(surfaces, s.step, 1.5 * reach, 500);
    context.say("step " + print_number(rotation_vector(s.step.rotation).norm() * 180 / pi) + " degrees, score " + print_number(s.score));
  }
  std::stable_sort(best.begin(), best.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  if (best.empty() || best[0].score < 0.25) return {};
  TurntableStart result;
  Turntable& table = result.table;
  FixedLine line = fixed_line(best[0].step, surfaces[0].center);
  table.step = line.angle;
  table.step_observed = true;
  for (std::size_t k = 1; k < best.size(); ++k) table.step_observed = table.step_observed && best[k].score < best[0].score - 0.05;
  if (!table.step_observed) {
    // Only a part that is round about the axis may look the same after any step; the steps are taken as parts of a turn.
    if (!round_axis) return {};
    TurntableStart by_relief = turned_by_relief(views, surfaces, *round_axis, options, context);
    if (!by_relief.start.poses.empty()) return by_relief;
    result.trouble = std::move(by_relief.trouble);
    exact.angle = full;
    const Pose step = align_symmetric(exact_pairs, rotation_about(line.point, line.axis, full), exact);
    const double score = score_of(surfaces, step, 1.5 * reach, 500);
    context.say("one turn in all, score " + print_number(score));
    if (score < 0.25) return {};
    line = fixed_line(step, surfaces[0].center);
    table.step = full, table.step_sigma = std::numeric_limits<double>::infinity();
  }
  table.axis = line.axis, table.point = line.point;
  result.start = StartResult::at(powers(rotation_about(line.point, line.axis, table.step), n), true);
  return result;
}

}  // namespace partscribe
