#include "fit/propose/wedges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "fit/refine/refine.h"
#include "fit/sketch/length_parameter.h"

namespace partscribe::fit {
namespace {

constexpr std::size_t wedge_points = 600;
constexpr double least_lean = 0.1;  // share of the foot; less is a block

/// Points on the scanned faces and their normals, few enough to try many starts on.
struct Sample {
  std::vector<Vec3> points, normals;
};

struct Start {
  Pose scan_from_part;
  Vec3 size = Vec3::Zero();  // foot, height, width
  double top = 0;            // mm, along x
  double cost = 1e300;       // share of the points that it leaves unexplained
};

/// Outward planes of a wedge in its frame; the leaning one first.
std::array<Plane3, 6> planes_of(const Vec3& size, double top) {
  const Vec3 lean = Vec3(size.y(), size.x() - top, 0).normalized();
  return {Plane3{lean, lean.x() * size.x()},
          {{-1, 0, 0}, 0},
          {{0, -1, 0}, 0},
          {{0, 1, 0}, size.y()},
          {{0, 0, -1}, 0},
          {{0, 0, 1}, size.z()}};
}

/// Share of the points that a wedge does not explain; `thick` is how far off, in mm, one is as good as unexplained.
double cost_of(const Start& start, const Sample& sample, bool oriented, double thick) {
  constexpr double turned = 0.1;  // 1 - cosine at which a normal is as good as another's
  const Pose part_from_scan = start.scan_from_part.inverse();
  const auto planes = planes_of(start.size, start.top);
  double sum = 0;
  for (std::size_t i = 0; i < sample.points.size(); ++i) {
    const Vec3 q = part_from_scan * sample.points[i], n = part_from_scan.rotation * sample.normals[i];
    std::array<double, 6> off;
    for (std::size_t k = 0; k < 6; ++k) off[k] = planes[k].normal.dot(q) - planes[k].offset;
    double best = 1;
    for (std::size_t k = 0; k < 6; ++k) {
      double beside = 0;
      for (std::size_t l = 0; l < 6; ++l)
        if (l != k) beside = std::max(beside, off[l]);
      const double cosine = n.dot(planes[k].normal), d = std::hypot(off[k], beside) / thick;
      best = std::min(best, d * d + (1 - (oriented ? cosine : std::abs(cosine))) / turned);
    }
    sum += best;
  }
  return sum / double(sample.points.size());
}

/// Frames of which two axes are given by two faces, in all ways to name the axes.
std::vector<Mat3> frames_of(const std::vector<ConvexFace>& faces) {
  constexpr std::size_t most_faces = 5;
  constexpr double least_sine = 0.3, known = 0.999;
  std::vector<Mat3> result;
  const auto add = [&](const Mat3& r) {
    if (std::none_of(result.begin(), result.end(),
                     [&](const Mat3& k) { return (k.transpose() * r).trace() > 3 * known; }))
      result.push_back(r);
  };
  const std::size_t count = std::min(most_faces, faces.size());
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) {
      Vec3 z = faces[i].normal.cross(faces[j].normal);
      if (!(z.norm() > least_sine)) continue;
      z.normalize();
      const std::array<Vec3, 3> axes = {faces[i].normal, z.cross(faces[i].normal), z};
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b)
          for (int signs = 0; signs < 4 && a != b; ++signs) {
            Mat3 r;
            r.col(0) = (signs & 1 ? -1 : 1) * axes[a], r.col(1) = (signs & 2 ? -1 : 1) * axes[b];
            r.col(2) = r.col(0).cross(r.col(1));
            add(r);
          }
    }
  return result;
}

/// The block in a frame around all points but a few; of no size if there is none.
Start block_around(const Mat3& rotation, const Sample& sample) {
  constexpr double left_out = 0.01;
  const Box3 box = box_along(rotation, sample.points, left_out);
  return {{rotation, rotation * box.low}, box.high - box.low};
}

/// The wedge in such a block, with the best of some tops.
Start start_in(const Start& block, const Sample& sample, bool oriented, double thick) {
  Start best;
  if (!(block.size.minCoeff() > 0)) return best;
  for (const double top : {0.0, 0.25, 0.5, 0.75}) {
    Start start = block;
    start.top = top * block.size.x();
    start.cost = cost_of(start, sample, oriented, thick);
    if (start.cost < best.cost) best = start;
  }
  return best;
}

/// Wedges whose slope lies where the data end: of a slope that was hardly seen, or set aside with the outliers, the
/// border of a cheek is left.
std::vector<Start> starts_at_ends(const Start& block, const std::vector<ConvexFace>& ends, const Sample& sample,
                                  bool oriented, double thick) {
  constexpr double square = 0.05;
  std::vector<Start> result;
  if (!(block.size.minCoeff() > 0)) return result;
  const Pose& frame = block.scan_from_part;
  for (const ConvexFace& end : ends) {
    const Vec3 n = frame.rotation.transpose() * end.normal;
    if (std::abs(n.z()) > square || n.x() < square || n.y() < square) continue;
    const double reach = end.offset - end.normal.dot(frame.translation);
    Start start = block;
    start.size.x() = reach / n.x(), start.top = (reach - n.y() * block.size.y()) / n.x();
    if (start.top < 0) start.size.y() = reach / n.y(), start.top = 0;
    if (!(start.size.minCoeff() > 0)) continue;
    start.cost = cost_of(start, sample, oriented, thick);
    result.push_back(start);
  }
  return result;
}

Candidate candidate_from(const Start& start, bool with_top) {
  Candidate c;
  c.procedure = "wedge", c.object_name = "wedge_block";
  c.scan_from_part = start.scan_from_part;
  c.shape = Wedge{Expr::of("foot_length"), Expr::of("height"), Expr::of("width"),
                  with_top ? Expr::of("top_length") : Expr(0)};
  c.parameters = {length_parameter("foot_length", start.size.x(), "length of the foot, along x at y = 0"),
                  length_parameter("height", start.size.y(), "height above the foot, along y"),
                  length_parameter("width", start.size.z(), "width between the two parallel cheeks, along z")};
  if (with_top) c.parameters.push_back(length_parameter("top_length", start.top, "length left at the full height"));
  return c;
}

/// A wedge after refinement; none if it leans hardly or away.
std::optional<Start> refined(const Start& start, bool with_top, const FitInput& input, const Sample& sample,
                             double thick, Context& context) {
  RefineOptions quick;
  quick.points = wedge_points, quick.iterations = 20, quick.uncertainty = false;
  Candidate c = candidate_from(start, with_top);
  refine(c, input, quick, context);
  Start result{c.scan_from_part,
               {c.parameters[0].value, c.parameters[1].value, c.parameters[2].value},
               with_top ? c.parameters[3].value : 0};
  if (!(result.size.minCoeff() > 0 && result.top >= 0 && result.top < (1 - least_lean) * result.size.x()))
    return std::nullopt;
  if (result.size.maxCoeff() > input.bounds.diagonal())
    return std::nullopt;  // nearly parallel walls that meet far away
  result.cost = cost_of(result, sample, input.oriented, thick);
  return result;
}

}  // namespace

std::vector<Candidate> propose_wedges(const std::vector<ConvexFace>& scanned, const std::vector<ConvexFace>& ends,
                                      const FitInput& input, Context& context) {
  constexpr std::size_t most_refined = 5, most_at_ends = 2;
  constexpr double coarse = 0.08, dearer = 0.2;  // of the data's size; share of the points
  const PointCloud& cloud = input.cloud;
  if (scanned.size() < 2 || cloud.normals.size() != cloud.size()) return {};
  const double size = input.bounds.diagonal(), reach = reach_of(input), thick = reach;
  Sample sample;
  for (std::size_t i = 0, step = std::max<std::size_t>(1, cloud.size() / wedge_points); i < cloud.size(); i += step)
    if (cloud.normals[i].squaredNorm() > 0.5 && std::abs(convex_distance(scanned, cloud.points[i])) < 1.5 * reach)
      sample.points.push_back(cloud.points[i]), sample.normals.push_back(cloud.normals[i]);
  if (sample.points.size() < 50) return {};
  std::vector<Start> starts, at_ends;
  for (const Mat3& frame : frames_of(scanned)) {
    const Start block = block_around(frame, sample);
    starts.push_back(start_in(block, sample, input.oriented, coarse * size));
    if (among_outliers(input)) continue;  // the data end anywhere
    for (const Start& start : starts_at_ends(block, ends, sample, input.oriented, coarse * size))
      at_ends.push_back(start);
  }
  const auto cheaper = [](const Start& a, const Start& b) { return a.cost < b.cost; };
  std::ranges::stable_sort(starts, cheaper), std::ranges::stable_sort(at_ends, cheaper);
  std::vector<Candidate> result;
  for (const bool with_top : {true, false}) {
    Start best;
    std::size_t tried = 0;
    for (const Start& start : starts) {
      if (tried == most_refined || start.cost > starts[0].cost + dearer || context.cancelled) break;
      ++tried;
      const auto fitted = refined(start, with_top, input, sample, thick, context);
      if (fitted && fitted->cost < best.cost) best = *fitted;
    }
    if (best.size.minCoeff() > 0) result.push_back(candidate_from(best, with_top));
  }
  // Too few points of a sample lie on such a slope to keep it in its place.
  for (std::size_t k = 0; k < std::min(most_at_ends, at_ends.size()); ++k)
    result.push_back(candidate_from(at_ends[k], at_ends[k].top > 0));
  return result;
}

}  // namespace partscribe::fit
