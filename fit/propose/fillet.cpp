#include "fit/propose/fillet.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/propose/convex_body.h"
#include "fit/refine/refine.h"
#include "fit/sketch/length_parameter.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t fillet_points = 600;
constexpr double same = 0.998;            // cosine of 3.6 degrees: normals of one plane face
constexpr double square = 0.09;           // sine of 5 degrees
constexpr double most_unexplained = 0.6;  // of the points

/// Directions, regardless of sign, that many normals share: of plane faces, the most frequent first, at most `most`.
std::vector<Vec3> face_directions(std::vector<Vec3> normals, std::size_t most) {
  const std::size_t all = normals.size();
  std::vector<Vec3> directions;
  while (directions.size() < most && normals.size() > all / 30) {
    std::size_t best = 0, best_count = 0;
    for (std::size_t i = 0; i < normals.size(); i += 3) {
      std::size_t count = 0;
      for (const auto& n : normals) count += std::abs(n.dot(normals[i])) > same;
      if (count > best_count) best_count = count, best = i;
    }
    if (best_count < all / 30) break;
    Vec3 mean = Vec3::Zero();
    const Vec3 seed = normals[best];
    for (const auto& n : normals)
      if (std::abs(n.dot(seed)) > same) mean += n.dot(seed) > 0 ? n : Vec3(-n);
    mean.normalize();
    directions.push_back(mean);
    std::erase_if(normals, [&](const Vec3& n) { return std::abs(n.dot(mean)) > same; });
  }
  return directions;
}

/// The direction along which walls run: that to which the normals are square, apart from those of its own ends.
Vec3 wall_direction(const std::vector<Vec3>& normals, Vec3 direction) {
  constexpr double end = 0.8;
  for (int round = 0; round < 8; ++round) {
    Mat3 scatter = Mat3::Zero();
    for (const auto& n : normals) {
      const double along = direction.dot(n);
      if (std::abs(along) < end) scatter += std::exp(-along * along / 0.08) * n * n.transpose();
    }
    direction = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(0);
  }
  return direction;
}

/// Points and their normals, few enough to try many starts on.
struct Sample {
  std::vector<Vec3> points, normals;
};

/// Directions along which the fillet may run: perpendicular to most normals, those of plane faces, or of the edges
/// where two of these meet.
std::vector<Vec3> axes_of(const std::vector<Vec3>& normals, const std::vector<Vec3>& faces) {
  constexpr double known = 0.995;
  std::vector<Vec3> axes;
  const auto add = [&](const Vec3& d) {
    if (std::none_of(axes.begin(), axes.end(), [&](const Vec3& a) { return std::abs(a.dot(d)) > known; }))
      axes.push_back(d);
  };
  Mat3 scatter = Mat3::Zero();
  for (const Vec3& n : normals) scatter += n * n.transpose();
  const Mat3 main = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors();
  for (int k = 0; k < 3; ++k) add(wall_direction(normals, main.col(k)));
  for (const Vec3& f : faces) add(wall_direction(normals, f.unitOrthogonal()));
  for (const Vec3& f : faces) add(f);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t k = i + 1; k < faces.size(); ++k)
      if (std::abs(faces[i].dot(faces[k])) < square) add(faces[i].cross(faces[k]).normalized());
  return axes;
}

struct Start {
  Pose scan_from_part;
  Vec3 size = Vec3::Zero();  // width, height, length
  double cost = 1e300;       // share of the points that it leaves unexplained
  double open_end = 0;       // mm, how well an end is known of which no face was seen; 0: both were
};

struct Concave {
  double into = 0;  // mm, how far a point is inside the bend, where nothing of the fillet is; to first order
  Vec2 normal = Vec2::Zero();
};

/// Of a point in the fillet's frame. Beyond the ends of its legs there is none.
Concave concave_side(const Vec3& q, const Vec3& size) {
  const Vec2 half = size.head<2>(), u = (half - q.head<2>()).cwiseQuotient(half), slope = u.cwiseQuotient(half);
  if (!(u.minCoeff() > 0)) return {};
  return {(1 - u.norm()) * u.norm() / std::max(slope.norm(), 1e-9), slope.normalized()};
}

/// Share of the points that a fillet does not explain; `thick` is how far off, in mm, one is as good as unexplained.
/// Distances to first order: they will do for comparing starts.
double cost_of(const Pose& scan_from_part, const Vec3& size, const Sample& sample, bool oriented, double thick) {
  constexpr double turned = 0.1;  // 1 - cosine at which a normal is as good as another's
  const Pose part_from_scan = scan_from_part.inverse();
  double sum = 0;
  for (std::size_t i = 0; i < sample.points.size(); ++i) {
    const Vec3 q = part_from_scan * sample.points[i], n = part_from_scan.rotation * sample.normals[i];
    const Concave side = concave_side(q, size);
    const double outside = (-q).cwiseMax(q - size).cwiseMax(0).norm(),
                 beside = std::hypot(outside, std::max(side.into, 0.0));
    double best = 1;
    const auto face = [&](double off, const Vec3& normal) {
      const double cosine = n.dot(normal), d = off / thick;
      best = std::min(best, d * d + (1 - (oriented ? cosine : std::abs(cosine))) / turned);
    };
    face(std::hypot(q.x(), beside), {-1, 0, 0}), face(std::hypot(q.y(), beside), {0, -1, 0});
    face(std::hypot(q.z(), beside), {0, 0, -1}), face(std::hypot(size.z() - q.z(), beside), {0, 0, 1});
    face(std::hypot(side.into, outside), {side.normal.x(), side.normal.y(), 0});
    sum += best;
  }
  return sum / double(sample.points.size());
}

/// The fillet whose corner lies low along x and y around all points but `left_out` of them at either end of each axis.
Start start_in(const Mat3& rotation, const Sample& sample, bool oriented, double left_out, double thick) {
  Start start;
  const Box3 box = box_along(rotation, sample.points, left_out);
  start.scan_from_part = {rotation, rotation * box.low};
  start.size = box.high - box.low;
  if (start.size.minCoeff() > 0) start.cost = cost_of(start.scan_from_part, start.size, sample, oriented, thick);
  return start;
}

/// Frames with their z along the axis or against it, and x along the faces that are perpendicular to it, or evenly
/// around.
std::vector<Mat3> frames_about(const Vec3& axis, const std::vector<Vec3>& faces) {
  constexpr int even = 24;
  std::vector<Vec3> across;
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  for (int k = 0; k < even; ++k) across.push_back(std::cos(2 * pi * k / even) * u + std::sin(2 * pi * k / even) * v);
  for (const Vec3& f : faces) {
    if (std::abs(f.dot(axis)) > square) continue;
    const Vec3 x = (f - f.dot(axis) * axis).normalized(), y = axis.cross(x);
    across.insert(across.end(), {x, y, -x, -y});
  }
  std::vector<Mat3> frames;
  for (const Vec3& x : across) {
    Mat3 r;
    r << x, axis.cross(x), axis;
    frames.push_back(r);
  }
  return frames;
}

/// Its ends were seen up to both legs: they show where these are as well as points of their own. Of the area of an end
/// .45 lies within .15 of the other leg's length from a leg.
bool ends_reach_legs(const Start& start, const FitInput& input, double near, std::size_t least) {
  constexpr double beside = 0.15, share_beside = 0.45, facing_along = 0.9;
  const Pose part_from_scan = start.scan_from_part.inverse();
  const Vec3& size = start.size;
  std::size_t all = 0, low_x = 0, low_y = 0;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 q = part_from_scan * input.cloud.points[i];
    const double along = (part_from_scan.rotation * input.cloud.normals[i]).z();
    if (std::min(std::abs(q.z()), std::abs(size.z() - q.z())) > near || std::abs(along) < facing_along) continue;
    if (std::min(q.x(), q.y()) < -near || (size - q).head<2>().minCoeff() < 0 || concave_side(q, size).into > -near)
      continue;
    ++all, low_x += q.x() < beside * size.x(), low_y += q.y() < beside * size.y();
  }
  return all > least && 2 * double(std::min(low_x, low_y)) > share_beside * double(all);
}

/// True if the data show the fillet itself: its concave side explains points, with matching normals, far better than
/// the sides of the block around it would, and enough points lie on a leg, or on ends that reach both legs. Without its
/// concave side a fillet cannot be told from a block, without its legs from any curved patch. With many outliers only
/// points whose normals are oblique to both legs count, because some outliers always lie along a leg, as the thin tip
/// of a fillet would.
bool shows_itself(const Start& start, const FitInput& input) {
  constexpr std::size_t least_points = 40;  // fewer lie there by chance
  constexpr double facing = 0.8, on_leg = 0.98, slanting = 0.35,
                   outlier = 12;         // cosines; half the square of a residual in sigmas
  constexpr double legs_share = 0.0125;  // of the points; outliers put 0.008 there
  const PointCloud& cloud = input.cloud;
  const double sigma = std::max(input.sampling.sigma, 0.2 * input.tolerance), n_points = double(cloud.size());
  const Pose part_from_scan = start.scan_from_part.inverse();
  const Vec3& size = start.size;
  const auto misfit = [&](double off) { return 0.5 * std::min(0.5 * off * off / (sigma * sigma), outlier); };
  double gain = 0;
  std::size_t legs = 0, concave = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 q = part_from_scan * cloud.points[i], n = part_from_scan.rotation * cloud.normals[i];
    const Concave side = concave_side(q, size);
    const double into = std::min(q.minCoeff(), (size - q).minCoeff());
    const double cosine = n.head<2>().dot(side.normal);
    const bool counts = !among_outliers(input) || side.normal.minCoeff() > slanting;
    if (counts && into > std::abs(side.into) && (input.oriented ? cosine : std::abs(cosine)) > facing)
      gain += misfit(into) - misfit(side.into), ++concave;
    // Near the line where a leg meets the concave side, a point supports neither.
    if (std::abs(into) < 3 * sigma && std::min(std::abs(q.x()), std::abs(q.y())) < 3 * sigma &&
        std::abs(side.into) > 3 * sigma)
      legs += std::max(std::abs(n.x()), std::abs(n.y())) > on_leg;
  }
  if (concave < least_points || !(gain > 20 + 0.1 * input.outlier_share * n_points)) return false;
  const double least_on_legs = legs_share * n_points;
  return double(legs) > least_on_legs ||
         (!among_outliers(input) && ends_reach_legs(start, input, 3 * sigma, std::size_t(least_on_legs)));
}

/// Puts the ends on their faces. An end of which no face was seen stays beyond the points of the sides: that leaves
/// none of them out.
void settle_ends(Start& start, const FitInput& input) {
  constexpr double same_way = 0.95, on_end = 0.9;
  constexpr std::size_t least_points = 20;
  const double near = 3 * std::max(input.sampling.sigma, 0.1 * input.tolerance);
  const Pose part_from_scan = start.scan_from_part.inverse();
  std::vector<double> sides, ends;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 q = part_from_scan * input.cloud.points[i], n = part_from_scan.rotation * input.cloud.normals[i];
    const Concave side = concave_side(q, start.size);
    if (std::min(q.x(), q.y()) < -near || std::max(q.x() - start.size.x(), q.y() - start.size.y()) > near) continue;
    const auto on = [&](double off, double cosine) { return std::abs(off) < near && std::abs(cosine) > same_way; };
    if (on(q.x(), n.x()) || on(q.y(), n.y()) || on(side.into, n.head<2>().dot(side.normal)))
      sides.push_back(q.z());
    else if (std::abs(n.z()) > on_end)
      ends.push_back(q.z());
  }
  if (sides.size() < least_points) return;
  // An end of which little was seen may have been set aside whole.
  if (!among_outliers(input))
    for (const Vec3& p : input.set_aside.points) {
      const Vec3 q = part_from_scan * p;
      if (q.head<2>().minCoeff() > -near && concave_side(q, start.size).into < near &&
          (start.size - q).head<2>().minCoeff() > -near)
        ends.push_back(q.z());
    }
  std::sort(ends.begin(), ends.end());
  double at[2] = {std::min(0.0, quantile(sides, 0.005)), std::max(start.size.z(), quantile(sides, 0.995))};
  for (const int high : {0, 1}) {
    // Where most points face along, with hardly a point of the sides beyond.
    const double inside = quantile(sides, high ? 0.97 : 0.03) + (high ? -near : near);
    std::size_t most = least_points - 1, first = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const auto last = std::upper_bound(ends.begin(), ends.end(), ends[i] + 2 * near);
      const auto count = static_cast<std::size_t>(last - ends.begin()) - i;
      if (count > most && (high ? ends[i] + near > inside : ends[i] + near < inside)) most = count, first = i;
    }
    if (most >= least_points)
      at[high] = ends[first + most / 2];
    else
      start.open_end = std::max(3 * input.tolerance, 0.05 * start.size.z());
  }
  if (!(at[1] > at[0])) return;
  start.scan_from_part.translation += start.scan_from_part.rotation.col(2) * at[0];
  start.size.z() = at[1] - at[0];
}

Candidate candidate_from(const Start& start, bool round) {
  Candidate c;
  c.procedure = "fillet", c.object_name = "fillet_body";
  c.scan_from_part = start.scan_from_part;
  const Vec3& size = start.size;
  if (round) {
    c.shape = Fillet{Expr::of("fillet_radius"), Expr::of("fillet_radius"), Expr::of("length")};
    c.parameters = {
        length_parameter("fillet_radius", (size.x() + size.y()) / 2, "radius of the concave side, length of both legs"),
        length_parameter("length", size.z(), "length of the fillet")};
  } else {
    c.shape = Fillet{Expr::of("width"), Expr::of("height"), Expr::of("length")};
    c.parameters = {length_parameter("width", size.x(), "first leg"),
                    length_parameter("height", size.y(), "second leg"),
                    length_parameter("length", size.z(), "length of the fillet")};
  }
  if (start.open_end > 0) c.held = {{"length", start.open_end}};
  return c;
}

/// The same legs, in either order. The ends are settled later.
bool alike(const Start& a, const Start& b) {
  const auto near = [&](const Mat3& rotation, const Vec2& legs) {
    const Mat3 turn = a.scan_from_part.rotation.transpose() * rotation;
    return turn.trace() > 1 + 2 * std::cos(0.15) && (a.size.head<2>() - legs).norm() < 0.1 * a.size.norm();
  };
  const Mat3& r = b.scan_from_part.rotation;
  Mat3 exchanged;
  exchanged << r.col(1), r.col(0), -r.col(2);
  return near(r, b.size.head<2>()) || near(exchanged, {b.size.y(), b.size.x()});
}

Vec3 size_of(const Candidate& c) { return {c.parameters[0].value, c.parameters[1].value, c.parameters[2].value}; }

/// The best of many starts, each refined; at most `most` that differ, the best first.
std::vector<Start> best_starts(const Sample& sample, const FitInput& input, std::size_t most, Context& context) {
  constexpr std::size_t most_refined = 6;
  constexpr double dearer = 0.2;                  // share of the points
  constexpr double largest = 1.2, coarse = 0.08;  // of the data's size
  const double size = input.bounds.diagonal();
  const std::vector<Vec3> faces = face_directions(sample.normals, 5);
  std::vector<Start> starts;
  for (const Vec3& axis : axes_of(sample.normals, faces))
    for (const Mat3& frame : frames_about(axis, faces))
      for (const double left_out : {0.01, 0.05})
        starts.push_back(start_in(frame, sample, input.oriented, left_out, coarse * size));
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.cost < b.cost; });
  std::vector<Start> tried, refined_starts;
  RefineOptions quick;
  quick.points = fillet_points, quick.iterations = 20, quick.uncertainty = false, quick.fixed = {"length"};
  for (const Start& start : starts) {
    if (tried.size() == most_refined || start.cost > starts[0].cost + dearer || context.cancelled) break;
    if (std::any_of(tried.begin(), tried.end(), [&](const Start& t) { return alike(t, start); })) continue;
    tried.push_back(start);
    Candidate any = candidate_from(start, false);
    refine(any, input, quick, context);
    Start refined{any.scan_from_part, size_of(any), 0};
    // A concave side much larger than the data bends too little to be one.
    if (!(refined.size.minCoeff() > 0) || refined.size.maxCoeff() > largest * size) continue;
    const double thick = 3 * std::max(input.sampling.sigma, 0.1 * input.tolerance);
    refined.cost = cost_of(refined.scan_from_part, refined.size, sample, input.oriented, thick);
    refined_starts.push_back(refined);
  }
  std::stable_sort(refined_starts.begin(), refined_starts.end(),
                   [](const Start& a, const Start& b) { return a.cost < b.cost; });
  std::vector<Start> best;
  for (const Start& start : refined_starts)
    if (best.size() < most && std::none_of(best.begin(), best.end(), [&](const Start& b) { return alike(b, start); }))
      best.push_back(start);
  return best;
}

}  // namespace

std::vector<Candidate> propose_fillets(const FitInput& input, Context& context) {
  const auto& cloud = input.cloud;
  if (cloud.size() < 50 || cloud.normals.size() != cloud.size() || input.bounds.empty()) return {};
  Sample sample;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / fillet_points);
  for (std::size_t i = 0; i < cloud.size(); i += step)
    if (cloud.normals[i].squaredNorm() > 0.5)
      sample.points.push_back(cloud.points[i]), sample.normals.push_back(cloud.normals[i]);
  // If the concave side was hardly seen, many fillets explain the rest; which is best can only be decided with all
  // points.
  const std::size_t most = among_outliers(input) ? 3 : 1;
  std::vector<Candidate> result;
  for (Start& start : best_starts(sample, input, most, context)) {
    if (!(start.cost < most_unexplained)) continue;
    settle_ends(start, input);
    Candidate any = candidate_from(start, false);
    if (shows_itself(start, input)) {
      if (std::abs(start.size.x() - start.size.y()) < 0.1 * (start.size.x() + start.size.y()))
        result.push_back(candidate_from(start, true));
      result.push_back(std::move(any));
    } else if (among_outliers(input)) {
      any.unseen = "its concave side was hardly seen";
      result.push_back(std::move(any));
    }
  }
  context.report("fillets", 1);
  return result;
}

}  // namespace partscribe::fit
