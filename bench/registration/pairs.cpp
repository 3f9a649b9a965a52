#include "pairs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/number.h"
#include "core/random.h"
#include "scan/filter.h"
#include "scan/read.h"
#include "scan/register_pair.h"

namespace partscribe {

namespace {

/// Share of the second view's surface that the first has as well, within two pixels and 30 degrees.
double overlap_of(const ViewSurface& first, const Pose& first_pose, const ViewSurface& second, const Pose& second_pose) {
  const Pose there = first_pose.inverse() * second_pose;
  std::size_t shared = 0, asked = 0;
  for (std::size_t k = 0; k < second.samples.size(); k += 3) {
    const auto i = second.samples[k];
    const Vec3 p = there * second.points[i];
    const Neighbour near = first.tree->nearest_one(p);
    ++asked;
    shared += near.sq_distance < 4 * first.spacing * first.spacing && first.normals[near.index].dot(there.rotation * second.normals[i]) > 0.866;
  }
  return asked ? double(shared) / double(asked) : 0;
}

}  // namespace

std::vector<std::string> scans_in(const Path& folder, std::vector<std::string> names) {
  if (names.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (std::filesystem::exists(entry.path() / "scan" / "scan.json")) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<PairCase> pair_cases(const Path& scan_json, const std::string& name, int most, Context& context) {
  std::vector<PairCase> result;
  std::vector<RangeImage> images;
  const auto scan = read_scan({scan_json}, {}, context, &images);
  if (!scan.ok()) return result;
  const auto views = views_to_register(*scan, images, context);
  std::vector<Pose> poses;
  for (const auto& view : views) poses.push_back(*view.guess);
  const auto surfaces = view_surfaces(views, 1500, context);
  struct Found {
    std::size_t a, b;
    double overlap;
  };
  std::array<std::vector<Found>, 5> fifths;
  for (std::size_t a = 0; a < views.size(); ++a)
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      if (!surfaces[a].usable() || !surfaces[b].usable()) continue;
      const double overlap = overlap_of(surfaces[a], poses[a], surfaces[b], poses[b]);
      fifths[std::size_t(std::min(4, int(overlap * 5)))].push_back({a, b, overlap});
    }
  const Vec3 middle = scan->cloud.bounds().center();
  const double radius = scan->cloud.bounds().diagonal() / 3.5;
  Random random(11);
  for (std::size_t fifth = 1; fifth < fifths.size(); ++fifth) {
    const auto& list = fifths[fifth];
    const std::size_t count = std::min(list.size(), std::size_t(most));
    for (std::size_t k = 0; k < count; ++k) {
      const Found& f = list[(2 * k + 1) * list.size() / (2 * count)];
      for (const int off : {5, 15, 30, 60}) {
        const auto direction = [&] { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); };
        const Mat3 turn = rotation_of(off * pi / 180 * direction());
        PairCase pair{name + " " + std::to_string(f.a) + " " + std::to_string(f.b), views[f.a], views[f.b], poses[f.b], f.overlap, off * pi / 180, radius, surfaces[f.b].spacing};
        pair.second.guess = Pose{turn, middle - turn * middle + 0.05 * radius * direction()} * poses[f.b];
        result.push_back(std::move(pair));
      }
    }
  }
  return result;
}

PairError pair_error(const PairCase& pair, const Pose& found, const std::vector<FreeMotion>& free) {
  Vec3 center = Vec3::Zero();
  for (const Vec3& p : pair.second.cloud.points) center += pair.truth * p / double(pair.second.cloud.size());
  const Pose back = pair.truth.inverse();
  Pose d = found * back;
  const auto error_of = [&] {
    Eigen::Matrix<double, 6, 1> e;
    e << pair.radius * rotation_vector(d.rotation), d * center - center;
    return e;
  };
  for (int round = 0; round < 30 && !free.empty(); ++round) {
    // The motions are those of the part where the view was placed; they stay in the world.
    Eigen::MatrixXd j(6, Eigen::Index(free.size()));
    for (std::size_t k = 0; k < free.size(); ++k)
      j.col(Eigen::Index(k)) << (free[k].turns ? Vec3(pair.radius * free[k].axis) : Vec3(Vec3::Zero())),
          (free[k].turns ? Vec3(free[k].axis.cross(d * center - free[k].point)) : free[k].axis);
    const Eigen::VectorXd step = j.completeOrthogonalDecomposition().solve(error_of());
    for (std::size_t k = 0; k < free.size(); ++k) {
      const double s = -step[Eigen::Index(k)];
      d = (free[k].turns ? rotation_about(free[k].point, free[k].axis, s) : Pose{Mat3::Identity(), s * free[k].axis}) * d;
    }
  }
  const auto e = error_of();
  return {e.head<3>().norm() / pair.radius, e.tail<3>().norm()};
}

bool is_right(const PairCase& pair, const PairError& error) { return error.angle * 180 / pi <= 1 && error.shift <= 0.02 * pair.radius; }

int degrees_off(const PairCase& pair) { return static_cast<int>(std::lround(pair.start * 180 / pi)); }

}  // namespace partscribe
