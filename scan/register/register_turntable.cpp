#include "scan/register/register_turntable.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/points/keep_points.h"
#include "scan/register/register_features.h"
#include "scan/register/register_relief.h"
#include "scan/register/register_words.h"
#include "scan/register/round_views.h"

namespace partscribe::scan {

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
/// Wallner 2001), by iterated weights. Nothing if fewer than half of them do; normals along the axis, as of the table,
/// meet any such axis at infinity and are not asked.
std::optional<AxisLine> axis_of_normals(const std::vector<ViewSurface>& surfaces) {
  const double size = surfaces[0].radius;
  const Vec3 center = surfaces[0].center;
  constexpr double along = 0.94, fewest = 20;  // cosine of 20 degrees; normals
  std::optional<AxisLine> line;
  double kept = 0;
  for (int round = 0; round < 25; ++round) {
    Mat6 sum = Mat6::Zero();
    double met = 0, asked = 0, count = 0;
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
        sum += w * l * l.transpose(), ++count;
        if (line && std::abs(normal.dot(line->axis)) < along) met += w, ++asked;
      }
    kept = asked < fewest ? 0 : met / asked;
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

constexpr double least_step = 0.02;  // rad

/// Whether a place of a view has the same surface in most other views while all lie in the sensor's frame: it stands
/// still, or any turn about the axis of the table lays it onto itself.
bool stands_still(const std::vector<ViewSurface>& surfaces, std::size_t view, std::size_t place, double reach) {
  constexpr double alike = 0.9;  // cosine
  const ViewSurface& s = surfaces[view];
  std::size_t seen = 0;
  for (std::size_t o = 0; o < surfaces.size(); ++o) {
    if (o == view) continue;
    const Neighbour near = surfaces[o].nearest_within(s.points[place], 2 * std::max(s.spacing, surfaces[o].spacing));
    if (!std::isfinite(near.sq_distance)) continue;
    const Vec3& normal = surfaces[o].normals[near.index];
    seen += std::abs(normal.dot(s.normals[place])) > alike &&
            std::abs(normal.dot(s.points[place] - surfaces[o].points[near.index])) < reach;
  }
  return 2 * seen >= surfaces.size() - 1;
}

/// Whether a surface bulges towards the origin, which lies well outside it: it may have been seen from there.
bool seen_from_origin(const ViewSurface& surface) {
  constexpr double outside = 3;  // radii
  const Vec3 sight = surface.center.normalized();
  double bulge = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Vec3 off = surface.points[i] - surface.center, normal = surface.normals[i];
    bulge += (normal.dot(surface.points[i]) < 0 ? normal : Vec3(-normal)).dot(off - off.dot(sight) * sight);
  }
  return surface.center.norm() > outside * surface.radius && bulge > 0;
}

struct Standing {
  bool most = true;   ///< of what every view shows
  bool flat = false;  ///< nearly all of that faces one way, as a table does
};

Standing standing(const std::vector<ViewSurface>& surfaces, double reach) {
  constexpr std::size_t asked = 1000;            // of each view
  constexpr double facing = 0.94, nearly = 0.9;  // cosine of 20 degrees
  Standing result;
  std::vector<Vec3> normals;
  Mat3 spread = Mat3::Zero();
  for (std::size_t v = 0; v < surfaces.size(); ++v) {
    const std::size_t stride = surfaces[v].points.size() / asked + 1, before = normals.size();
    std::size_t all = 0;
    for (std::size_t i = 0; i < surfaces[v].points.size(); i += stride, ++all)
      if (stands_still(surfaces, v, i, reach))
        normals.push_back(surfaces[v].normals[i]), spread += normals.back() * normals.back().transpose();
    result.most = result.most && 2 * (normals.size() - before) >= all;
  }
  const Vec3 way = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
  const auto there =
      std::ranges::count_if(normals, [&](const Vec3& normal) { return std::abs(normal.dot(way)) > facing; });
  result.flat = result.most && double(there) > nearly * double(normals.size());
  return result;
}

/// The views without what stands still; nothing where the rest has no surface.
std::optional<std::vector<ViewSurface>> what_moves(const std::vector<RegisterView>& views,
                                                   const std::vector<ViewSurface>& surfaces, bool contours,
                                                   double reach, const RegisterOptions& options, Context& context) {
  std::vector<RegisterView> moving = views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<std::uint8_t> moves(surfaces[v].points.size()), keep(views[v].cloud.size());
    parallel_for(moves.size(), context.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) moves[i] = !stands_still(surfaces, v, i, reach);
    });
    for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = moves[surfaces[v].nearest(views[v].cloud.points[i]).index];
    keep_points(moving[v].cloud, keep);
    if (views[v].measured.empty()) continue;
    moving[v].measured.clear();
    for (std::size_t i = 0; i < keep.size(); ++i)
      if (keep[i]) moving[v].measured.push_back(views[v].measured[i]);
  }
  std::vector<ViewSurface> result = view_surfaces(moving, options.samples, context, contours);
  if (!std::ranges::all_of(result, &ViewSurface::usable)) return {};
  // Of so little a sensor's place is guessed badly. Cameras write what they see in a frame of their own, and turntables
  // leave it there.
  if (std::ranges::all_of(moving,
                          [](const RegisterView& view) { return view.cloud.rays.empty() && view.width == 0; }) &&
      std::ranges::all_of(result, seen_from_origin)) {
    for (RegisterView& view : moving)
      for (const Vec3& p : view.cloud.points) view.cloud.rays.push_back(p.normalized());
    std::vector<ViewSurface> seen = view_surfaces(moving, options.samples, context, contours);
    if (std::ranges::all_of(seen, &ViewSurface::usable)) return seen;
  }
  return result;
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
  for (ViewSurface& s : surfaces) std::erase_if(s.samples, [&](std::uint32_t i) { return !round_about(line, s, i); });
}

std::string in_words(const DepthCorrection& depth) {
  return "seen from every side the part is round only with depths " + in_percent(std::abs(depth.stretch)) + " (sigma " +
         in_percent(depth.stretch_sigma) + (depth.stretch < 0 ? ") smaller" : ") larger") + " and sheared by " +
         in_percent(depth.shear) + " of the width: depths and widths of this scanner do not agree; ";
}

/// Of a round part: by how far it turned, told by its relief. Without relief there are no poses, and only what is wrong
/// with depths is said.
TurntableStart turned_by_relief(const std::vector<RegisterView>& views, const std::vector<ViewSurface>& surfaces,
                                const AxisLine& axis, const RegisterOptions& options, Context& context) {
  const RoundFits round = round_views(surfaces, axis);
  // Cells of a few points each; surfaces may be thinned.
  double cell = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    cell = std::max(
        cell, 3 * surfaces[v].spacing * std::sqrt(double(surfaces[v].points.size()) / double(views[v].cloud.size())));
  auto poses = poses_by_relief(views, round.rounder ? *round.rounder : round.raw, cell, context);
  TurntableStart result;
  if (round.rounder) {
    result.trouble = in_words(round.rounder->depth) + (!poses ? "it is too smooth to correct that"
                                                       : options.correct_depth
                                                           ? "depths are corrected, and no size is surer than that"
                                                           : "ask for corrected depths (--correct-depth)");
    if (poses && options.correct_depth) result.depth = round.rounder->depth;
  }
  if (!poses) return result;
  // What stands still has a relief of its own.
  for (std::size_t v = 0; v + 1 < poses->size(); ++v)
    if (rotation_vector(((*poses)[v].inverse() * (*poses)[v + 1]).rotation).norm() < least_step) return result;
  result.table = table_of(*poses, surfaces[0].center);
  result.start = StartResult::at(std::move(*poses), true);
  return result;
}

}  // namespace

Result<TurntableStart> start_from_turntable(const std::vector<RegisterView>& views, std::vector<ViewSurface>& surfaces,
                                            bool contours, const RegisterOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  std::string left_out;
  const auto none = [&] {
    return bad_input("expected views that equal steps about one axis lay over one another, found no such axis" +
                     (left_out.empty() ? "" : "; " + left_out));
  };
  if (n < 2 || !std::ranges::all_of(surfaces, &ViewSurface::usable)) return none();
  context.report("looking for the axis", 0);
  // A smooth round part stands still as well, but it is not flat, and nothing of it moves.
  const Standing still = standing(surfaces, confirm_reach(surfaces));
  std::optional<std::vector<ViewSurface>> moving;
  if (still.flat) moving = what_moves(views, surfaces, contours, confirm_reach(surfaces), options, context);
  const auto round_axis = moving ? std::optional<AxisLine>() : axis_of_normals(surfaces);
  if (still.most && !moving && !round_axis) {
    if (!still.flat) moving = what_moves(views, surfaces, contours, confirm_reach(surfaces), options, context);
    left_out = "nearly all that the views show stands still, such as the table, and tells no step";
    if (!moving) return none();
  }
  // What stands still beside a round part, such as the foot of the table, is not round about its axis and left out.
  if (round_axis) keep_round(surfaces, *round_axis);
  if (moving) {
    std::size_t before = 0, after = 0;
    for (std::size_t v = 0; v < n; ++v) before += surfaces[v].points.size(), after += (*moving)[v].points.size();
    left_out =
        in_percent(1 - double(after) / double(before)) +
        " of what the views show stands still in most of them, such as the table: it tells no step and was left out";
    context.say(left_out);
    surfaces = std::move(*moving);
  }
  double radius = 0, spacing = 0, sigma = 0;
  for (const ViewSurface& s : surfaces)
    radius = std::max(radius, s.radius), spacing = std::max(spacing, s.spacing), sigma = std::max(sigma, s.sigma);
  const double coarse_cell = std::max(radius / 12, 2 * spacing), reach = (round_axis ? 2 : 1) * confirm_reach(surfaces);
  std::vector<Surfels> few, many;
  std::vector<std::unique_ptr<PlacedModel>> coarse, fine;
  const std::vector<Pose> unmoved(n);
  for (std::size_t v = 0; v < n; ++v) {
    few.push_back(sample_surfels(surfaces[v], 300)), many.push_back(sample_surfels(surfaces[v], 1200));
    coarse.push_back(place_surfaces(surfaces, unmoved, {v}, coarse_cell));
    fine.push_back(place_surfaces(surfaces, unmoved, {v}, 1.5 * spacing));
  }
  const auto pairs_of = [&](const std::vector<Surfels>& sources,
                            const std::vector<std::unique_ptr<PlacedModel>>& targets) {
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
  rough.start_reach = 0.35 * radius, rough.end_reach = coarse_cell, rough.noise = 0.1 * coarse_cell,
  rough.iterations = 40, rough.pure_rotation = true;
  parallel_for(
      starts.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const Pose step = align_symmetric(rough_pairs, starts[k], rough);
          const Vec3 turn = rotation_vector(step.rotation);
          if (turn.norm() < 0.05) continue;
          // A long round part also fits when it is turned end over end.
          if (round_axis && std::abs(turn.normalized().dot(round_axis->axis)) < 0.9) continue;
          scored[k] = {step, score_of(surfaces, step, 4 * reach, 100)};
        }
      },
      1);
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Scored> best;
  for (const Scored& s : scored) {
    bool known = false;
    for (const Scored& b : best)
      known = known || rotation_vector(b.step.rotation.transpose() * s.step.rotation).norm() < 0.05;
    if (!known && s.score > -1e29) best.push_back(s);
    if (best.size() >= 8) break;
  }
  // Round parts start on their axis; anything coarser than their radius would lose it.
  if (round_axis) {
    best.clear();
    for (const double angle : {full, pi / 12, pi / 6, pi / 4, pi / 2})
      for (const double sign : {1.0, -1.0})
        best.push_back({rotation_about(round_axis->point, round_axis->axis, sign * angle)});
  }
  AlignOptions exact;
  exact.start_reach = coarse_cell, exact.end_reach = std::max(1.5 * spacing, 4 * sigma),
  exact.noise = std::max(0.5 * sigma, 0.02 * spacing), exact.pure_rotation = true;
  if (round_axis) exact.start_reach = 6 * spacing;
  for (Scored& s : best) {
    s.step = align_symmetric(exact_pairs, s.step, exact);
    s.score = rotation_vector(s.step.rotation).norm() < 0.05 ? -1e30 : score_of(surfaces, s.step, 1.5 * reach, 500);
    context.say("step " + print_number(rotation_vector(s.step.rotation).norm() * 180 / pi) + " degrees, score " +
                print_number(s.score));
  }
  std::stable_sort(best.begin(), best.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  if (best.empty() || best[0].score < 0.25) return none();
  TurntableStart result;
  result.trouble = left_out;
  Turntable& table = result.table;
  FixedLine line = fixed_line(best[0].step, surfaces[0].center);
  table.step = line.angle;
  table.step_observed = true;
  for (std::size_t k = 1; k < best.size(); ++k)
    table.step_observed = table.step_observed && best[k].score < best[0].score - 0.05;
  if (!table.step_observed) {
    // Only a part that is round about the axis may look the same after any step; the steps are taken as parts of a
    // turn.
    if (!round_axis) return none();
    TurntableStart by_relief = turned_by_relief(views, surfaces, *round_axis, options, context);
    if (!by_relief.start.poses.empty()) return by_relief;
    result.trouble = std::move(by_relief.trouble);
    exact.angle = full;
    const Pose step = align_symmetric(exact_pairs, rotation_about(line.point, line.axis, full), exact);
    const double score = score_of(surfaces, step, 1.5 * reach, 500);
    context.say("one turn in all, score " + print_number(score));
    if (score < 0.25) return none();
    line = fixed_line(step, surfaces[0].center);
    table.step = full, table.step_sigma = std::numeric_limits<double>::infinity();
  }
  table.axis = line.axis, table.point = line.point;
  result.start = StartResult::at(powers(rotation_about(line.point, line.axis, table.step), n), true);
  return result;
}

}  // namespace partscribe::scan
