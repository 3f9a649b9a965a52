#include "scan/register/register_features.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/random.h"

namespace partscribe::scan {
namespace {

using Histogram = Eigen::Matrix<float, 33, 1>;

/// The three angles of Rusu's point pair, each in one of eleven bins.
void count_pair(const Vec3& p, const Vec3& n, const Vec3& q, const Vec3& m, Histogram& histogram) {
  const Vec3 d = (q - p).normalized();
  const Vec3 v = d.cross(n);
  if (v.squaredNorm() < 1e-12) return;
  const Vec3 w = n.cross(v.normalized());
  const auto bin = [](double x, double low, double high) {
    return std::clamp(static_cast<int>(11 * (x - low) / (high - low)), 0, 10);
  };
  histogram[bin(v.normalized().dot(m), -1, 1)] += 1;
  histogram[11 + bin(n.dot(d), -1, 1)] += 1;
  histogram[22 + bin(std::atan2(w.dot(m), n.dot(m)), -pi, pi)] += 1;
}

struct Match {
  std::uint32_t source, target;
};

/// The three likest points of the target for each of the source.
std::vector<Match> like_points(const Features& source, const Features& target) {
  constexpr std::size_t most = 3;
  std::vector<Match> result;
  for (std::uint32_t i = 0; i < source.histograms.size(); ++i) {
    std::array<std::pair<float, std::uint32_t>, most + 1> best;
    best.fill({1e30f, 0});
    for (std::uint32_t j = 0; j < target.histograms.size(); ++j) {
      const float d = (source.histograms[i] - target.histograms[j]).squaredNorm();
      if (d >= best[most - 1].first) continue;
      best[most] = {d, j};
      std::sort(best.begin(), best.end());
    }
    for (std::size_t k = 0; k < most; ++k)
      if (best[k].first < 1e30f) result.push_back({i, best[k].second});
  }
  return result;
}

/// The pose that lays two oriented points over two others.
Pose pose_of_pairs(const Vec3& p1, const Vec3& n1, const Vec3& p2, const Vec3& n2, const Vec3& q1, const Vec3& m1,
                   const Vec3& q2, const Vec3& m2) {
  const auto frame = [](const Vec3& a, const Vec3& na, const Vec3& b, const Vec3& nb) {
    const Vec3 x = (b - a).normalized();
    const Vec3 n = na + nb;
    const Vec3 y = (n - n.dot(x) * x).normalized();
    Mat3 f;
    f << x, y, x.cross(y);
    return f;
  };
  Pose pose;
  pose.rotation = frame(q1, m1, q2, m2) * frame(p1, n1, p2, n2).transpose();
  pose.translation = 0.5 * (q1 + q2) - pose.rotation * (0.5 * (p1 + p2));
  return pose;
}

}  // namespace

std::unique_ptr<Features> features_of(const ViewSurface& surface, double cell) {
  auto result = std::make_unique<Features>();
  result->cell = cell;
  result->surfels = thin_surfels(surface, cell);
  const auto& [points, normals] = result->surfels;
  result->tree = std::make_unique<KdTree>(points);
  const double reach = 5 * cell;
  std::vector<Histogram> simple(points.size(), Histogram::Zero());
  std::vector<std::vector<Neighbour>> near(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    result->tree->within(points[i], reach, near[i]);
    for (const Neighbour& n : near[i])
      if (n.index != i) count_pair(points[i], normals[i], points[n.index], normals[n.index], simple[i]);
    if (near[i].size() > 1) simple[i] /= static_cast<float>(near[i].size() - 1);
  }
  result->histograms.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Histogram sum = simple[i];
    float weights = 1;
    for (const Neighbour& n : near[i]) {
      if (n.index == i) continue;
      const float w = static_cast<float>(cell / std::sqrt(n.sq_distance));
      sum += w * simple[n.index], weights += w;
    }
    result->histograms[i] = sum / weights;
  }
  return result;
}

std::vector<Pose> feature_poses(const Features& source, const Features& target, std::size_t most) {
  const auto &a = source.surfels, &b = target.surfels;
  const std::vector<Match> matches = like_points(source, target);
  std::vector<Pose> result;
  if (matches.size() < 10) return result;
  const double cell = source.cell;
  std::vector<std::uint32_t> probe;
  for (std::size_t k = 0; k < std::min<std::size_t>(80, a.points.size()); ++k)
    probe.push_back(static_cast<std::uint32_t>(k * a.points.size() / std::min<std::size_t>(80, a.points.size())));
  struct Scored {
    int hits;
    Pose pose;
  };
  std::vector<Scored> scored;
  Random random(7);
  for (int draw = 0; draw < 60000; ++draw) {
    const Match &s = matches[random.below(matches.size())], &t = matches[random.below(matches.size())];
    const Vec3 d = a.points[t.source] - a.points[s.source], e = b.points[t.target] - b.points[s.target];
    const double length = d.norm();
    if (length < 6 * cell || std::abs(length - e.norm()) > cell) continue;
    const auto off = [](double x, double y) { return std::abs(x - y) > 0.12; };
    const Vec3 &n1 = a.normals[s.source], &n2 = a.normals[t.source], &m1 = b.normals[s.target],
               &m2 = b.normals[t.target];
    if (off(n1.dot(n2), m1.dot(m2)) || off(n1.dot(d) / length, m1.dot(e) / length) ||
        off(n2.dot(d) / length, m2.dot(e) / length))
      continue;
    if (off(n1.cross(n2).dot(d) / length, m1.cross(m2).dot(e) / length)) continue;
    const Pose pose =
        pose_of_pairs(a.points[s.source], n1, a.points[t.source], n2, b.points[s.target], m1, b.points[t.target], m2);
    if (!pose.rotation.allFinite()) continue;
    int hits = 0;
    for (const auto i : probe) {
      const Neighbour near = target.tree->nearest_one(pose * a.points[i]);
      hits += near.sq_distance < 2.25 * cell * cell && b.normals[near.index].dot(pose.rotation * a.normals[i]) > 0.9;
    }
    scored.push_back({hits, pose});
  }
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& x, const Scored& y) { return x.hits > y.hits; });
  const Vec3 middle = a.points.empty() ? Vec3(Vec3::Zero()) : a.points[a.points.size() / 2];
  for (const Scored& s : scored) {
    bool known = false;
    for (const Pose& r : result)
      known = known || (rotation_vector(r.rotation.transpose() * s.pose.rotation).norm() < 0.25 &&
                        (r * middle - s.pose * middle).norm() < 5 * cell);
    if (!known) result.push_back(s.pose);
    if (result.size() >= most) break;
  }
  return result;
}

}  // namespace partscribe::scan
