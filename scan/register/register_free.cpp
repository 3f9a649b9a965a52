#include "scan/register/register_free.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/decompose.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_start.h"
#include "scan/register/register_steps.h"

namespace partscribe::scan {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// A motion in the unknowns of one view (rotation times size about the center, shift) as an axis.
FreeMotion motion_of(const Vec6& v, const JointResult& joint) {
  FreeMotion motion;
  const Vec3 turn = v.head<3>() / joint.size, shift = v.tail<3>();
  motion.turns = turn.norm() * joint.size > 0.2 * shift.norm();
  // Places that stay: turn x (p - center) + shift = 0, the nearest to the center.
  motion.axis = (motion.turns ? turn : shift).normalized();
  motion.point = motion.turns ? Vec3(joint.center + turn.cross(shift) / turn.squaredNorm()) : joint.center;
  int largest = 0;
  motion.axis.cwiseAbs().maxCoeff(&largest);
  if (motion.axis[largest] < 0) motion.axis = -motion.axis;
  return motion;
}

/// What one view may do, in its unknowns.
using Ways = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Ways ways_of_view(std::size_t view, const JointResult& joint) {
  const auto n = static_cast<Eigen::Index>(joint.free_directions.size());
  Ways span(6, n);
  for (Eigen::Index k = 0; k < n; ++k)
    span.col(k) = joint.free_directions[static_cast<std::size_t>(k)].segment<6>(static_cast<Eigen::Index>(6 * view));
  const auto eigen = eigensystem<6>(span * span.transpose());
  // A view that moves a fifth as far as the one that moves most is only carried along.
  int rank = 0;
  while (rank < 6 && eigen.values[5 - rank] > 0.01) ++rank;
  return eigen.vectors.rightCols(rank);
}

std::vector<Ways> ways_of_views(const JointResult& joint) {
  std::vector<Ways> result(joint.poses.size(), Ways(6, 0));
  if (joint.free_directions.empty()) return result;
  for (std::size_t v = 0; v < result.size(); ++v) result[v] = ways_of_view(v, joint);
  return result;
}

/// Slides first, then turns.
std::vector<FreeMotion> motions_of_view(const Ways& ways, const JointResult& joint) {
  std::vector<FreeMotion> result;
  // Combinations that do not turn are slides, the others turn about an axis.
  const auto split = eigensystem<Eigen::Dynamic>(ways.topRows<3>().transpose() * ways.topRows<3>());
  for (Eigen::Index k = 0; k < ways.cols(); ++k) result.push_back(motion_of(ways * split.vectors.col(k), joint));
  return result;
}

/// The place where several axes meet, or come nearest to each other.
Vec3 nearest_to_axes(const std::vector<FreeMotion>& motions) {
  Mat3 across = Mat3::Zero();
  Vec3 sum = Vec3::Zero();
  for (const FreeMotion& m : motions) {
    const Mat3 one = Mat3::Identity() - m.axis * m.axis.transpose();
    across += one, sum += one * m.point;
  }
  return solve_ldlt(across, sum);
}

bool same_motion(const FreeMotion& a, const FreeMotion& b, double size) {
  if (a.turns != b.turns || a.axis.cross(b.axis).norm() > 0.05) return false;
  return !a.turns || (a.point - b.point).cross(a.axis).norm() < 0.05 * size;
}

/// One entry for all views that move alike.
std::vector<FreeMotion> motions_of(const std::vector<Ways>& ways, const JointResult& joint) {
  std::vector<FreeMotion> result;
  for (std::size_t v = 0; v < ways.size(); ++v) {
    if (ways[v].cols() == 0) continue;
    std::vector<FreeMotion> own = motions_of_view(ways[v], joint);
    // All turns about one point are one thing, whatever axes span them.
    if (own.size() == 3 && own[0].turns) {
      const Vec3 point = nearest_to_axes(own);
      for (int k = 0; k < 3; ++k) own[std::size_t(k)].axis = Vec3::Unit(k), own[std::size_t(k)].point = point;
    }
    for (FreeMotion& motion : own) {
      const auto known = std::find_if(result.begin(), result.end(),
                                      [&](const FreeMotion& m) { return same_motion(m, motion, joint.size); });
      if (known == result.end())
        result.push_back(motion), result.back().views = {v};
      else
        known->views.push_back(v);
    }
  }
  return result;
}

/// Whether a motion of one view is one of its free motions, or several of them together.
bool explained(Pose d, std::size_t view, const std::vector<FreeMotion>& free, const JointResult& joint,
               double shift_limit) {
  std::vector<const FreeMotion*> own;
  for (const FreeMotion& m : free)
    if (std::find(m.views.begin(), m.views.end(), view) != m.views.end()) own.push_back(&m);
  const Vec3& center = joint.center;
  const auto left = [&] {
    Vec6 e;
    e << joint.size * rotation_vector(d.rotation), d * center - center;
    return e;
  };
  for (int round = 0; round < 20 && !own.empty(); ++round) {
    Eigen::MatrixXd j(6, static_cast<Eigen::Index>(own.size()));
    for (std::size_t k = 0; k < own.size(); ++k)
      j.col(static_cast<Eigen::Index>(k)) << (own[k]->turns ? Vec3(joint.size * own[k]->axis) : Vec3(Vec3::Zero())),
          (own[k]->turns ? Vec3(own[k]->axis.cross(d * center - own[k]->point)) : own[k]->axis);
    const Eigen::VectorXd step = j.completeOrthogonalDecomposition().solve(left());
    for (std::size_t k = 0; k < own.size(); ++k) {
      const double s = -step[static_cast<Eigen::Index>(k)];
      d = (own[k]->turns ? rotation_about(own[k]->point, own[k]->axis, s) : Pose{Mat3::Identity(), s * own[k]->axis}) *
          d;
    }
  }
  return left().norm() < shift_limit;
}

/// Motions that the search found to lead to other poses as good, and that are not among those of the normal matrix.
void add_joined(const std::vector<std::vector<Pose>>& joined, const std::vector<std::size_t>& used,
                const JointResult& joint, std::vector<FreeMotion>& motions) {
  for (const std::size_t v : used)
    for (const Pose& d : joined[v]) {
      if (explained(d, v, motions, joint, 0.1 * joint.size)) continue;
      FreeMotion motion;
      const double angle = rotation_vector(d.rotation).norm();
      const Vec3 moved = d * joint.center - joint.center;
      motion.turns = angle * joint.size > 0.2 * moved.norm();
      motion.point = joint.center, motion.axis = moved.normalized();
      if (motion.turns) {
        const FixedLine line = fixed_line(d, joint.center);
        motion.point = line.point, motion.axis = line.axis;
      }
      const auto known = std::find_if(motions.begin(), motions.end(),
                                      [&](const FreeMotion& m) { return same_motion(m, motion, joint.size); });
      if (known == motions.end())
        motions.push_back(motion), motions.back().views = {v};
      else if (std::find(known->views.begin(), known->views.end(), v) == known->views.end())
        known->views.push_back(v);
    }
}

/// What a twist (a turn and a shift for each unit of time, about a center) does in the time in which it turns by
/// `turn`: shift so far.
Mat3 shift_while_turning(const Vec3& turn) {
  const double sq = turn.squaredNorm(), angle = std::sqrt(sq);
  Mat3 cross;
  cross << 0, -turn.z(), turn.y(), turn.z(), 0, -turn.x(), -turn.y(), turn.x(), 0;
  const bool small = sq < 1e-8;
  const double first = small ? 0.5 : (1 - std::cos(angle)) / sq,
               second = small ? 1.0 / 6 : (angle - std::sin(angle)) / (sq * angle);
  return Mat3::Identity() + first * cross + second * cross * cross;
}

/// Along a motion in the unknowns of one view, all the way in one screw.
Pose screwed(const Vec6& v, const JointResult& joint) {
  const Vec3 turn = v.head<3>() / joint.size;
  return moved_about({}, joint.center, turn, shift_while_turning(turn) * v.tail<3>());
}

/// The motion in the unknowns of one view that leads to this pose in one screw.
Vec6 screw_of(const Pose& d, const JointResult& joint) {
  const Vec3 turn = rotation_vector(d.rotation);
  Vec6 v;
  v << joint.size * turn, shift_while_turning(turn).inverse() * (d * joint.center - joint.center);
  return v;
}

std::vector<FreeMotion> all_motions(const std::vector<Ways>& ways, const JointResult& joint,
                                    const std::vector<std::vector<Pose>>& joined,
                                    const std::vector<std::size_t>& used) {
  std::vector<FreeMotion> motions = motions_of(ways, joint);
  add_joined(joined, used, joint, motions);
  return motions;
}

}  // namespace

std::vector<FreeMotion> free_motions(const JointResult& joint, const std::vector<std::vector<Pose>>& joined,
                                     const std::vector<std::size_t>& used) {
  return all_motions(ways_of_views(joint), joint, joined, used);
}

std::vector<FreeMotion> followed_motions(const std::vector<ViewSurface>& surfaces, const JointResult& joint,
                                         const std::vector<std::vector<Pose>>& joined,
                                         const std::vector<std::size_t>& used, JointOptions options, Context& context) {
  constexpr double share = 0.25;    // of the part's size
  constexpr double same_way = 0.5;  // of the way
  constexpr double as_good =
      1.2;  // of the spread of the distances: a flat face beside a round one lies on it nearly as well
  std::vector<Ways> ways = ways_of_views(joint), followed = ways;
  Eigen::Index most = 0;
  for (const Ways& w : ways) most = std::max(most, w.cols());
  const double far = share * joint.size;
  for (Eigen::Index k = 0; k < most && !context.cancelled; ++k) {
    std::vector<Pose> start = joint.poses;
    for (const std::size_t v : used)
      if (k < ways[v].cols()) start[v] = screwed(far * ways[v].col(k), joint) * start[v];
    const JointResult there = adjust_jointly(surfaces, start, used, options, context);
    if (there.surface_sigma > as_good * joint.surface_sigma) continue;
    for (const std::size_t v : used) {
      if (k >= ways[v].cols() || 2 * there.matches[v] < joint.matches[v]) continue;
      const Vec6 way = screw_of(there.poses[v] * joint.poses[v].inverse(), joint) / far;
      if ((way - ways[v].col(k)).norm() < same_way) followed[v].col(k) = way;
    }
  }
  return all_motions(followed, joint, joined, used);
}

bool any_in_trouble(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                    const std::vector<std::size_t>& views) {
  constexpr double trouble = 0.02;
  const double reach = confirm_reach(surfaces);
  return std::any_of(views.begin(), views.end(), [&](std::size_t v) {
    const Agreement a = agreement(surfaces, poses, v, poses[v], views, reach, 1000);
    return a.seen_through() > trouble || a.unanswered() > trouble;
  });
}

namespace {

/// What speaks against the poses of all views together.
double contradiction_of(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                        const std::vector<std::size_t>& views, double reach, int threads) {
  constexpr std::size_t samples = 300;
  std::vector<double> of(views.size());
  parallel_for(
      of.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
          of[k] = agreement(surfaces, poses, views[k], poses[views[k]], views, reach, samples).contradiction_by_all();
      },
      1);
  return std::accumulate(of.begin(), of.end(), 0.0);
}

}  // namespace

std::vector<Pose> freed_of_contradictions(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                                          const std::vector<std::size_t>& views, bool contours, Context& context) {
  constexpr int steps = 24;  // each way, up to the radius
  constexpr double clearly_less = 0.7;
  if (views.size() < 3) return poses;
  double radius = 0, spacing = 0;
  for (const std::size_t v : views)
    radius = std::max(radius, surfaces[v].radius), spacing = std::max(spacing, surfaces[v].spacing);
  JointOptions adjust;
  adjust.start_reach = 6 * spacing, adjust.contours = contours;
  const JointResult joint = adjust_jointly(surfaces, poses, views, adjust, context);
  const double reach = confirm_reach(surfaces),
               before = contradiction_of(surfaces, joint.poses, views, reach, context.threads);
  std::vector<Pose> best = joint.poses;
  double least = before;
  for (const Eigen::VectorXd& direction : joint.free_directions) {
    const Eigen::VectorXd unit = direction / largest_of_a_view(direction);
    const std::vector<Pose> from = best;
    for (int k = -steps; k <= steps && !context.cancelled; ++k) {
      if (k == 0) continue;
      std::vector<Pose> moved = from;
      for (const std::size_t v : views) {
        const Vec6 motion = k * radius / steps * unit.segment<6>(static_cast<Eigen::Index>(6 * v));
        moved[v] = moved_about(from[v], joint.center, motion.head<3>() / joint.size, motion.tail<3>());
      }
      const double now = contradiction_of(surfaces, moved, views, reach, context.threads);
      if (now < least) least = now, best = std::move(moved);
    }
  }
  if (context.cancelled || !(least < clearly_less * before)) return poses;
  context.say("free views moved together, contradictions " + print_number(before) + " to " + print_number(least));
  return best;
}

}  // namespace partscribe::scan
