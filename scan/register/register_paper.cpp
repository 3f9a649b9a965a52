#include "scan/register/register_paper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/decompose.h"

namespace partscribe::scan {

Pose closest_motion(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  Vec3 pm = Vec3::Zero(), xm = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    pm += from[i] / static_cast<double>(from.size()), xm += to[i] / static_cast<double>(from.size());
  Mat3 S = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) S += (from[i] - pm) * (to[i] - xm).transpose();
  const Vec3 d(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  Eigen::Matrix4d N;
  N << S.trace(), d.transpose(), d, S + S.transpose() - S.trace() * Mat3::Identity();
  const Eigen::Vector4d q = eigensystem(N).vectors.col(3);
  Pose pose;
  pose.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  pose.translation = xm - pose.rotation * pm;
  return pose;
}

std::vector<Patch> planar_patches(const ViewSurface& surface, const PaperOptions& options) {
  const double most_radius = 0.35 * surface.radius, bend = std::cos(options.patch_angle);
  const double reach = 2.3 * surface.spacing;  // to the next return of a slanted face
  std::vector<std::uint8_t> taken(surface.points.size(), 0);
  const auto least = static_cast<std::size_t>(
      std::max(12.0, 0.1 * 3 * most_radius * most_radius / (surface.spacing * surface.spacing)));
  std::vector<Patch> patches;
  std::vector<Neighbour> near;
  std::vector<std::uint32_t> pending;
  for (std::uint32_t seed = 0; seed < surface.points.size(); ++seed) {
    if (taken[seed] || !surface.smooth[seed]) continue;
    Patch patch;
    pending.assign(1, seed);
    taken[seed] = 1;
    while (!pending.empty()) {
      const auto i = pending.back();
      pending.pop_back();
      patch.members.push_back(i);
      surface.tree->within(surface.points[i], reach, near);
      for (const Neighbour& n : near) {
        if (taken[n.index] || !surface.smooth[n.index]) continue;
        if (surface.normals[n.index].dot(surface.normals[seed]) < bend) continue;
        if ((surface.points[n.index] - surface.points[seed]).norm() > most_radius) continue;
        taken[n.index] = 1;
        pending.push_back(n.index);
      }
    }
    std::sort(patch.members.begin(), patch.members.end());
    if (patch.members.size() < least) continue;
    for (const auto i : patch.members)
      patch.center += surface.points[i] / static_cast<double>(patch.members.size()), patch.normal += surface.normals[i];
    patch.normal.normalize();
    patches.push_back(std::move(patch));
  }
  std::stable_sort(patches.begin(), patches.end(),
                   [](const Patch& a, const Patch& b) { return a.members.size() > b.members.size(); });
  return patches;
}

namespace {

/// The patches of all views registered so far, in the world.
struct PatchModel {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> patch;  // of each point
  std::vector<Vec3> center, normal;  // of each patch

  void add(const ViewSurface& surface, const std::vector<Patch>& patches, const Pose& pose) {
    for (const Patch& p : patches) {
      for (const auto i : p.members)
        points.push_back(pose * surface.points[i]), patch.push_back(static_cast<std::uint32_t>(center.size()));
      center.push_back(pose * p.center), normal.push_back(pose.rotation * p.normal);
    }
  }
};

struct Pairing {
  std::vector<Vec3> p, x;  // where the points are now, and what they are matched with
  double mean = 0, deviation = 0;
};

/// x_i: the projection of a point on the plane of the primitive that is nearest to it.
Pairing match(const std::vector<Patch>& patches, const std::vector<std::uint8_t>& visible, const PatchModel& model,
              const KdTree& tree, const Pose& pose, double limit, double normal_angle) {
  Pairing pairing;
  std::vector<double> residuals;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!visible[k]) continue;
    const Vec3 p = pose * patches[k].center;
    const auto m = model.patch[tree.nearest_one(p).index];
    if (model.normal[m].dot(pose.rotation * patches[k].normal) < std::cos(normal_angle)) continue;
    const Vec3 x = p - model.normal[m].dot(p - model.center[m]) * model.normal[m];
    const double residual = (x - p).norm();
    if (residual > limit) continue;
    pairing.p.push_back(p), pairing.x.push_back(x), residuals.push_back(residual);
  }
  for (const double r : residuals) pairing.mean += r / static_cast<double>(residuals.size());
  for (const double r : residuals)
    pairing.deviation += (r - pairing.mean) * (r - pairing.mean) / static_cast<double>(residuals.size());
  pairing.deviation = std::sqrt(pairing.deviation);
  return pairing;
}

}  // namespace

StartResult register_as_published(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                  const PaperOptions& options, Context& context) {
  const std::size_t n = surfaces.size();
  StartResult result = StartResult::at(guesses, false);
  PatchModel model;
  std::vector<std::size_t> placed;
  for (std::size_t v = 0; v < n && !context.cancelled; ++v) {
    if (!surfaces[v].usable()) {
      result.reason[v] =
          "expected at least 50 points on smooth surface, found " + std::to_string(surfaces[v].samples.size());
      continue;
    }
    const std::vector<Patch> patches = planar_patches(surfaces[v], options);
    Pose pose = guesses[v];
    if (!placed.empty()) {
      std::vector<std::uint8_t> visible(patches.size(), 0);
      for (std::size_t k = 0; k < patches.size(); ++k)
        for (const std::size_t o : placed) {
          const Vec3 p = result.poses[o].inverse() * (pose * patches[k].center);
          const Vec3 normal = result.poses[o].rotation.transpose() * (pose.rotation * patches[k].normal);
          const Sight seen = sight(surfaces[o].raster, p, 0.2 * surfaces[v].radius);
          if (seen == Sight::measured && normal.dot(surfaces[o].raster.ray(p)) < 0) visible[k] = 1;
        }
      const KdTree tree(model.points);
      double limit = 1e30, before = 1e30;
      std::size_t matched = 0;
      for (int k = 0; k < options.iterations; ++k) {
        const Pairing pairing = match(patches, visible, model, tree, pose, limit, options.normal_angle);
        matched = pairing.p.size();
        if (matched < 4) break;
        pose = closest_motion(pairing.p, pairing.x) * pose;
        limit = pairing.mean + 2 * pairing.deviation + 1e-9;
        if (std::abs(before - pairing.mean) < 1e-7 * surfaces[v].radius) break;
        before = pairing.mean;
      }
      if (matched < 4) {
        result.reason[v] =
            "expected at least 4 planar patches that views before it share, found " + std::to_string(matched);
        continue;
      }
    }
    result.poses[v] = pose, result.placed[v] = 1;
    placed.push_back(v);
    model.add(surfaces[v], patches, pose);
  }
  return result;
}

}  // namespace partscribe::scan
