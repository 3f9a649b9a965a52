#include "fit/fillet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/statistics.h"
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

struct Start {
  Pose scan_from_part;
  double width = 0, height = 0, length = 0, miss = 1e300;
  double concave = 0;  // share of the points near the concave side and no other
};

/// The fillet whose corner lies low along x and y, ends included, and how far the points are from it.
Start start_in(const Mat3& rotation, const std::vector<Vec3>& points, double reach) {
  Start start;
  Vec3 low, high;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> along;
    for (const auto& p : points) along.push_back(rotation.col(k).dot(p));
    low[k] = quantile(along, 0.01), high[k] = quantile(along, 0.99);
  }
  start.scan_from_part.rotation = rotation;
  start.scan_from_part.translation = rotation * low;
  const Vec3 size = high - low;
  start.width = size.x(), start.height = size.y(), start.length = size.z();
  if (!(size.minCoeff() > 0)) return start;
  Model model;
  model.objects.push_back({"fillet", Fillet{start.width, start.height, start.length}, {}, {}, {}});
  const ModelDistance distance(model);
  const Pose part_from_scan = start.scan_from_part.inverse();
  std::vector<double> misses;
  for (const auto& p : points) {
    const Vec3 q = part_from_scan * p;
    const double d = std::abs(distance(q).distance);
    misses.push_back(d);
    const double inside = std::min({q.x(), q.y(), q.z(), size.z() - q.z()});
    if (d < reach && inside > 2 * reach) start.concave += 1 / double(points.size());
  }
  start.miss = quantile(misses, 0.6);
  return start;
}

Parameter length(const char* name, double value, const char* note) {
  Parameter p;
  p.name = name, p.value = p.fitted = value, p.note = note;
  return p;
}

}  // namespace

std::vector<Candidate> propose_fillets(const FitInput& input, Context& context) {
  std::vector<Candidate> result;
  const auto& cloud = input.cloud;
  if (cloud.size() < 50 || cloud.normals.size() != cloud.size() || input.bounds.empty()) return result;
  std::vector<Vec3> points, normals;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / most_points);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    points.push_back(cloud.points[i]);
    if (cloud.normals[i].squaredNorm() > 0.5) normals.push_back(cloud.normals[i]);
  }
  const auto directions = face_directions(normals, 5);
  const double close = std::max({3 * input.tolerance, 3 * input.sampling.sigma, 0.01 * input.bounds.diagonal()});
  Start best;
  for (const auto& x : directions)
    for (const auto& y : directions) {
      if (std::abs(x.dot(y)) > square) continue;
      // Which corner of the box around the data is the fillet's own is told by the data.
      for (const double side_x : {1.0, -1.0}) {
        Mat3 rotation;
        rotation.col(0) = side_x * x;
        rotation.col(1) = (y - y.dot(x) * x).normalized();
        rotation.col(2) = rotation.col(0).cross(rotation.col(1));
        const Start start = start_in(rotation, points, close);
        if (start.miss < best.miss) best = start;
        rotation.col(1) = -rotation.col(1), rotation.col(2) = -rotation.col(2);
        const Start other = start_in(rotation, points, close);
        if (other.miss < best.miss) best = other;
      }
    }
  context.report("fillets", 1);
  // Without its concave side it is a block like any other.
  constexpr double least_concave = 0.03;
  if (!(best.miss < close) || best.concave < least_concave) return result;
  Candidate c;
  c.procedure = "fillet", c.object_name = "fillet_body";
  c.scan_from_part = best.scan_from_part;
  if (std::abs(best.width - best.height) < 0.1 * (best.width + best.height)) {
    c.shape = Fillet{Expr::of("fillet_radius"), Expr::of("fillet_radius"), Expr::of("length")};
    c.parameters = {length("fillet_radius", (best.width + best.height) / 2, "radius of the concave side, length of both legs"),
                    length("length", best.length, "length of the fillet")};
    result.push_back(c);
  }
  c.shape = Fillet{Expr::of("width"), Expr::of("height"), Expr::of("length")};
  c.parameters = {length("width", best.width, "first leg"), length("height", best.height, "second leg"),
                  length("length", best.length, "length of the fillet")};
  result.push_back(std::move(c));
  return result;
}

}  // namespace partscribe
