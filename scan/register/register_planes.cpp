#include "scan/register/register_planes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace partscribe::scan {
namespace {

constexpr double same_direction = 0.995;  // cosine of 6 degrees, of a place's normal against its plane
constexpr double least_share = 0.02;      // of a view's points on a plane
constexpr double parallel = 0.998;        // cosine of 4 degrees, of planes at a turn that other planes gave
constexpr double like_angle = 0.03;       // rad, between two planes here and two there

/// A turn and what speaks for it.
struct Turn {
  Mat3 rotation;
  double worth;  // the smaller share of each pair of planes, added up
};

Mat3 frame_of(const Vec3& a, const Vec3& b) {
  Mat3 f;
  f.col(0) = (a + b).normalized(), f.col(1) = (a - b).normalized(), f.col(2) = f.col(0).cross(f.col(1));
  return f;
}

double angle_of(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Every turn that lays two planes of the source onto two of the target.
std::vector<Turn> turns_between(const std::vector<ViewPlane>& source, const std::vector<ViewPlane>& target) {
  std::vector<Turn> turns;
  for (std::size_t i = 0; i < source.size(); ++i)
    for (std::size_t j = i + 1; j < source.size(); ++j) {
      const double angle = angle_of(source[i].normal, source[j].normal);
      if (angle < 0.25 || angle > 2.9) continue;
      for (std::size_t k = 0; k < target.size(); ++k)
        for (std::size_t l = 0; l < target.size(); ++l) {
          if (k == l || std::abs(angle_of(target[k].normal, target[l].normal) - angle) > like_angle) continue;
          const Mat3 rotation =
              frame_of(target[k].normal, target[l].normal) * frame_of(source[i].normal, source[j].normal).transpose();
          const double worth = std::min(source[i].share, target[k].share) + std::min(source[j].share, target[l].share);
          const auto known = std::find_if(turns.begin(), turns.end(), [&](const Turn& t) {
            return rotation_vector(t.rotation.transpose() * rotation).norm() < 0.08;
          });
          if (known == turns.end())
            turns.push_back({rotation, worth});
          else if (known->worth < worth)
            *known = {rotation, worth};
        }
    }
  std::stable_sort(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) { return a.worth > b.worth; });
  return turns;
}

/// A shift along one direction and the share of the two planes that it lays onto each other.
struct Shift {
  Vec3 normal;
  double along, worth;
};

struct Extent {
  double low = 1e30, high = -1e30, sum = 0, count = 0;
  void add(double x) { low = std::min(low, x), high = std::max(high, x), sum += x, count += 1; }
};

/// How far surfels reach along a direction.
Extent extent(const Surfels& surfels, const Mat3& rotation, const Vec3& direction) {
  Extent e;
  for (const Vec3& p : surfels.points) e.add((rotation * p).dot(direction));
  return e;
}

}  // namespace

std::vector<ViewPlane> planes_of(const ViewSurface& surface, std::size_t most) {
  constexpr std::size_t most_points = 4000, most_seeds = 150;
  std::vector<std::uint32_t> smooth;
  for (std::uint32_t i = 0; i < surface.points.size(); ++i)
    if (surface.smooth[i]) smooth.push_back(i);
  std::vector<Vec3> points, normals;
  const std::size_t count = std::min(smooth.size(), most_points);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = smooth[(2 * k + 1) * smooth.size() / (2 * count)];
    points.push_back(surface.points[i]), normals.push_back(surface.normals[i]);
  }
  const double near = std::max(1.5 * surface.sigma, 0.15 * surface.spacing);
  std::vector<std::uint8_t> taken(points.size(), 0);
  std::vector<ViewPlane> planes;
  const auto on = [&](std::size_t i, const Vec3& n, double offset, double within) {
    return !taken[i] && normals[i].dot(n) > same_direction && std::abs(points[i].dot(n) - offset) < within;
  };
  while (planes.size() < most) {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!taken[i]) left.push_back(i);
    std::size_t best = 0, best_count = 0;
    for (std::size_t k = 0; k < std::min(left.size(), most_seeds); ++k) {
      const std::size_t seed = left[k * left.size() / std::min(left.size(), most_seeds)];
      const double offset = points[seed].dot(normals[seed]);
      std::size_t like = 0;
      for (const std::size_t i : left) like += on(i, normals[seed], offset, 4 * near);
      if (like > best_count) best_count = like, best = seed;
    }
    if (static_cast<double>(best_count) < least_share * static_cast<double>(points.size()) || best_count < 12) break;
    ViewPlane plane{normals[best], points[best].dot(normals[best]), 0};
    std::size_t members = 0;
    for (int round = 0; round < 4; ++round) {
      const double within = round < 2 ? 4 * near : 2 * near;
      Vec3 middle = Vec3::Zero();
      members = 0;
      for (const std::size_t i : left)
        if (on(i, plane.normal, plane.offset, within)) middle += points[i], ++members;
      if (members < 8) break;
      middle /= static_cast<double>(members);
      Mat3 spread = Mat3::Zero();
      for (const std::size_t i : left)
        if (on(i, plane.normal, plane.offset, within))
          spread += (points[i] - middle) * (points[i] - middle).transpose();
      const Vec3 n = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(0);
      plane.normal = n.dot(plane.normal) < 0 ? Vec3(-n) : n, plane.offset = plane.normal.dot(middle);
    }
    taken[best] = 1;
    members = 0;
    for (const std::size_t i : left)
      if (on(i, plane.normal, plane.offset, 3 * near)) taken[i] = 1, ++members;
    plane.share = static_cast<double>(members) / static_cast<double>(points.size());
    if (plane.share >= least_share) planes.push_back(plane);
  }
  std::stable_sort(planes.begin(), planes.end(),
                   [](const ViewPlane& a, const ViewPlane& b) { return a.share > b.share; });
  return planes;
}

std::vector<Pose> plane_poses(const std::vector<ViewPlane>& source_planes, const std::vector<ViewPlane>& target_planes,
                              const std::vector<ViewSurface>& surfaces, std::size_t source, std::size_t target,
                              double reach, std::size_t most) {
  constexpr std::size_t most_turns = 60, most_shifts = 4, most_judged = 300;
  const ViewSurface& from = surfaces[source];
  const Surfels mine = strided_surfels(from, 400), theirs = strided_surfels(surfaces[target], 400);
  std::vector<Pose> candidates;
  const std::vector<Turn> turns = turns_between(source_planes, target_planes);
  for (std::size_t t = 0; t < std::min(turns.size(), most_turns); ++t) {
    const Mat3& rotation = turns[t].rotation;
    std::vector<Shift> shifts;
    for (const ViewPlane& a : source_planes)
      for (const ViewPlane& b : target_planes)
        if (b.normal.dot(rotation * a.normal) > parallel)
          shifts.push_back({b.normal, b.offset - a.offset, std::min(a.share, b.share)});
    std::stable_sort(shifts.begin(), shifts.end(), [](const Shift& a, const Shift& b) { return a.worth > b.worth; });
    // Up to three directions, the one with most on it first; what they leave open follows from how far both reach.
    std::array<std::vector<double>, 3> along;
    Mat3 directions = Mat3::Zero();
    int known = 0;
    for (const Shift& s : shifts) {
      int of = 0;
      while (of < known && std::abs(directions.col(of).dot(s.normal)) < parallel) ++of;
      if (of == known) {
        if (known == 3) continue;
        const Vec3 out = known == 2 ? Vec3(directions.col(0).cross(directions.col(1))) : Vec3::Zero();
        if (known == 2 && std::abs(out.normalized().dot(s.normal)) < 0.3) continue;
        directions.col(known++) = s.normal;
      }
      const double sign = directions.col(of).dot(s.normal) < 0 ? -1 : 1;
      if (along[std::size_t(of)].size() < most_shifts) along[std::size_t(of)].push_back(sign * s.along);
    }
    if (known < 2) continue;
    if (known == 2) {
      const Vec3 free = directions.col(0).cross(directions.col(1)).normalized();
      directions.col(2) = free;
      const Extent a = extent(mine, rotation, free), b = extent(theirs, Mat3::Identity(), free);
      for (const double s : {b.low - a.low, b.high - a.high, b.sum / b.count - a.sum / a.count}) along[2].push_back(s);
    }
    const Mat3 inverse = Mat3(directions.transpose()).inverse();
    if (!inverse.allFinite()) continue;
    for (const double x : along[0])
      for (const double y : along[1])
        for (const double z : along[2]) candidates.push_back({rotation, inverse * Vec3(x, y, z)});
  }
  // Many are looked at quickly, some closely.
  struct Scored {
    double score;
    Pose pose;
  };
  const std::vector<Pose> poses(surfaces.size());
  const std::vector<std::size_t> others{target};
  const auto judged = [&](const std::vector<Pose>& list, std::size_t samples, double factor) {
    std::vector<Scored> scored;
    for (const Pose& pose : list)
      scored.push_back({agreement(surfaces, poses, source, pose, others, factor * reach, samples).score(), pose});
    std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
    return scored;
  };
  std::vector<Pose> good, result;
  for (const Scored& s : judged(candidates, 40, 6))
    if (good.size() < most_judged) good.push_back(s.pose);
  for (const Scored& s : judged(good, 200, 4)) {
    if (result.size() >= most) break;
    const bool repeated = std::any_of(result.begin(), result.end(), [&](const Pose& r) {
      return same_place(from, r, s.pose, 0.05, 0.05 * from.radius);
    });
    if (!repeated) result.push_back(s.pose);
  }
  return result;
}

}  // namespace partscribe::scan
