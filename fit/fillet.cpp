#include "fit/fillet.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/refine.h"
#include "model/distance.h"

namespace partscribe {
namespace {

constexpr std::size_t most_points = 600;
constexpr double same = 0.998;    // cosine of 3.6 degrees: normals of one plane face
constexpr double square = 0.09;   // sine of 5 degrees

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

struct Start {
  Pose scan_from_part;
  Vec3 size = Vec3::Zero();  // width, height, length
  double miss = 1e300;       // mm, that 60 % of the points keep to
};

/// The fillet whose corner lies low along x and y, ends included, and how far the points are from it.
Start start_in(const Mat3& rotation, const std::vector<Vec3>& points) {
  Start start;
  Vec3 low, high;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const auto& p : points) along.push_back(rotation.col(k).dot(p));
    low[k] = quantile(along, 0.01), high[k] = quantile(along, 0.99);
  }
  start.scan_from_part.rotation = rotation;
  start.scan_from_part.translation = rotation * low;
  start.size = high - low;
  if (!(start.size.minCoeff() > 0)) return start;
  // To first order, which will do for comparing starts.
  const Pose part_from_scan = start.scan_from_part.inverse();
  std::vector<double> misses;
  for (const auto& p : points) {
    const Vec3 q = part_from_scan * p;
    const Vec2 u(1 - q.x() / start.size.x(), 1 - q.y() / start.size.y());
    const Vec2 slope(u.x() / start.size.x(), u.y() / start.size.y());
    const double concave = u.x() > 0 && u.y() > 0 ? (1 - u.norm()) * u.norm() / std::max(slope.norm(), 1e-9) : 1e300;
    const Vec3 outside = (-q).cwiseMax(q - start.size).cwiseMax(0);
    const double faces = std::min({std::abs(q.x()), std::abs(q.y()), std::abs(q.z()), std::abs(start.size.z() - q.z())});
    misses.push_back(std::max(outside.norm(), std::min(std::abs(concave), faces)));
  }
  start.miss = quantile(misses, 0.6);
  return start;
}

/// Every way to stand a fillet on two directions that are square to each other: its length along either or across both.
std::vector<Mat3> frames_on(const Vec3& a, const Vec3& b) {
  Mat3 axes;
  axes.col(0) = a, axes.col(1) = (b - b.dot(a) * a).normalized(), axes.col(2) = axes.col(0).cross(axes.col(1));
  std::vector<Mat3> frames;
  for (int along = 0; along < 3; ++along)
    for (const double side_x : {1.0, -1.0})
      for (const double side_y : {1.0, -1.0}) {
        Mat3 r;
        r.col(0) = side_x * axes.col((along + 1) % 3), r.col(1) = side_y * axes.col((along + 2) % 3);
        r.col(2) = r.col(0).cross(r.col(1));
        frames.push_back(r);
      }
  return frames;
}

/// Enough points lie on the concave side and on no side of a block, facing the right way, and enough on a leg: without its
/// concave side it is a block like any other, without its legs any bent patch.
bool shows_itself(const Candidate& c, const Vec3& size, const FitInput& input) {
  constexpr double clearly = 3;  // sigmas
  const PointCloud& cloud = input.cloud;
  const double reach = clearly * std::max(input.sampling.sigma, 0.1 * input.tolerance);
  const ModelDistance distance(bare_model(c));
  const Pose part_from_scan = c.scan_from_part.inverse();
  std::size_t concave = 0, legs = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 q = part_from_scan * cloud.points[i];
    if (!(std::abs(distance(q).distance) < reach)) continue;
    const Vec3 n = part_from_scan.rotation * cloud.normals[i];
    const bool outward = !input.oriented || n.x() > 0 || n.y() > 0;
    if (std::min(q.minCoeff(), (size - q).minCoeff()) > reach) concave += outward;
    else legs += std::max(std::abs(n.x()), std::abs(n.y())) > same && std::min(q.x(), q.y()) < reach;
  }
  return concave >= std::max<std::size_t>(15, cloud.size() / 250) && legs > cloud.size() / 20;
}

Parameter length(const char* name, double value, const char* note) {
  Parameter p;
  p.name = name, p.value = p.fitted = value, p.note = note;
  return p;
}

Candidate candidate_from(const Start& start, bool round) {
  Candidate c;
  c.procedure = "fillet", c.object_name = "fillet_body";
  c.scan_from_part = start.scan_from_part;
  const Vec3& size = start.size;
  if (round) {
    c.shape = Fillet{Expr::of("fillet_radius"), Expr::of("fillet_radius"), Expr::of("length")};
    c.parameters = {length("fillet_radius", (size.x() + size.y()) / 2, "radius of the concave side, length of both legs"),
                    length("length", size.z(), "length of the fillet")};
  } else {
    c.shape = Fillet{Expr::of("width"), Expr::of("height"), Expr::of("length")};
    c.parameters = {length("width", size.x(), "first leg"), length("height", size.y(), "second leg"),
                    length("length", size.z(), "length of the fillet")};
  }
  return c;
}

}  // namespace

std::vector<Candidate> propose_fillets(const FitInput& input, Context& context) {
  const auto& cloud = input.cloud;
  if (cloud.size() < 50 || cloud.normals.size() != cloud.size() || input.bounds.empty()) return {};
  std::vector<Vec3> points, normals;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    points.push_back(cloud.points[i]);
    if (cloud.normals[i].squaredNorm() > 0.5) normals.push_back(cloud.normals[i]);
  }
  std::vector<Vec3> directions = face_directions(normals, 5);
  const std::size_t faces = directions.size();
  for (std::size_t i = 0; i < faces; ++i) directions.push_back(wall_direction(normals, directions[i].unitOrthogonal()));
  Start best;
  for (std::size_t i = 0; i < faces; ++i)
    for (std::size_t k = i + 1; k < directions.size(); ++k) {
      if (std::abs(directions[i].dot(directions[k])) > square) continue;
      // Which corner of the box around the data is the fillet's own is told by the data.
      for (const Mat3& frame : frames_on(directions[i], directions[k])) {
        const Start start = start_in(frame, points);
        if (start.miss < best.miss) best = start;
      }
    }
  context.report("fillets", 1);
  const double close = std::max({2 * input.tolerance, 3 * input.sampling.sigma, 0.02 * input.bounds.diagonal()});
  if (!(best.miss < close)) return {};
  RefineOptions quick;
  quick.points = most_points, quick.iterations = 20, quick.uncertainty = false;
  Candidate any = candidate_from(best, false);
  refine(any, input, quick, context);
  Start polished;
  polished.scan_from_part = any.scan_from_part;
  for (int k = 0; k < 3; ++k) polished.size[k] = any.parameters[static_cast<std::size_t>(k)].value;
  if (!(polished.size.minCoeff() > 0) || !shows_itself(any, polished.size, input)) return {};
  std::vector<Candidate> result;
  if (std::abs(polished.size.x() - polished.size.y()) < 0.1 * (polished.size.x() + polished.size.y()))
    result.push_back(candidate_from(polished, true));
  result.push_back(std::move(any));
  return result;
}

}  // namespace partscribe
