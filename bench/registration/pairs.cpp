#include "pairs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/number.h"
#include "core/random.h"
#include "scan/filter/filter.h"
#include "scan/read/read.h"
#include "scan/register/register_pair.h"

namespace partscribe::testing {

namespace {

/// Share of the second view's surface that the first has as well, within two pixels and 30 degrees.
double overlap_of(const ViewSurface& first, const Pose& first_pose, const ViewSurface& second,
                  const Pose& second_pose) {
  const Pose there = first_pose.inverse() * second_pose;
  std::size_t shared = 0, asked = 0;
  for (std::size_t k = 0; k < second.samples.size(); k += 3) {
    const auto i = second.samples[k];
    const Vec3 p = there * second.points[i];
    const Neighbour near = first.tree->nearest_one(p);
    ++asked;
    shared += near.sq_distance < 4 * first.spacing * first.spacing &&
              first.normals[near.index].dot(there.rotation * second.normals[i]) > 0.866;
  }
  return asked ? double(shared) / double(asked) : 0;
}

/// Two views and the share of the second's surface that the first has as well.
struct Overlap {
  std::size_t a, b;
  double share;
};

/// The views of a scan at their true poses, and every two of them.
struct ScanPairs {
  std::vector<RegisterView> views;
  std::vector<double> spacing;
  std::vector<Overlap> pairs;
  Vec3 middle = Vec3::Zero();
  double radius = 0;
};

ScanPairs pairs_of_scan(const Path& scan_json, Context& context) {
  ScanPairs result;
  std::vector<RangeImage> images;
  const auto scan = read_scan({scan_json}, {}, context, &images);
  if (!scan.ok()) return result;
  result.views = views_to_register(*scan, images, context);
  result.middle = scan->cloud.bounds().center(), result.radius = scan->cloud.bounds().diagonal() / 3.5;
  const auto surfaces = view_surfaces(result.views, 1500, context);
  for (std::size_t a = 0; a < surfaces.size(); ++a) {
    result.spacing.push_back(surfaces[a].spacing);
    for (std::size_t b = a + 1; b < surfaces.size(); ++b)
      if (surfaces[a].usable() && surfaces[b].usable())
        result.pairs.push_back(
            {a, b, overlap_of(surfaces[a], *result.views[a].guess, surfaces[b], *result.views[b].guess)});
  }
  return result;
}

/// From so many degrees and a twentieth of the radius off.
PairCase started(const ScanPairs& scan, const std::string& name, const Overlap& of, int off, Random& random) {
  const auto direction = [&] { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); };
  const Mat3 turn = rotation_of(off * pi / 180 * direction());
  const Pose truth = *scan.views[of.b].guess;
  PairCase pair{name + " " + std::to_string(of.a) + " " + std::to_string(of.b),
                scan.views[of.a],
                scan.views[of.b],
                truth,
                of.share,
                off * pi / 180,
                scan.radius,
                scan.spacing[of.b]};
  pair.second.guess = Pose{turn, scan.middle - turn * scan.middle + 0.05 * scan.radius * direction()} * truth;
  return pair;
}

}  // namespace

std::vector<std::string> scans_in(const Path& folder, std::vector<std::string> names) {
  if (names.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (std::filesystem::exists(entry.path() / "scan" / "scan.json"))
        names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<PairCase> pair_cases(const Path& scan_json, const std::string& name, int most, Context& context) {
  std::vector<PairCase> result;
  const ScanPairs scan = pairs_of_scan(scan_json, context);
  std::array<std::vector<Overlap>, 5> fifths;
  for (const Overlap& pair : scan.pairs) fifths[std::size_t(std::min(4, int(pair.share * 5)))].push_back(pair);
  Random random(11);
  for (std::size_t fifth = 1; fifth < fifths.size(); ++fifth) {
    const auto& list = fifths[fifth];
    const std::size_t count = std::min(list.size(), std::size_t(most));
    for (std::size_t k = 0; k < count; ++k)
      for (const int off : {5, 15, 30, 60})
        result.push_back(started(scan, name, list[(2 * k + 1) * list.size() / (2 * count)], off, random));
  }
  return result;
}

std::vector<PairCase> basin_cases(const Path& scan_json, Context& context) {
  constexpr std::size_t seeds = 8;
  std::vector<PairCase> result;
  ScanPairs scan = pairs_of_scan(scan_json, context);
  Random random(11);
  for (const double share : {0.3, 0.5, 0.7, 0.9}) {
    std::stable_sort(scan.pairs.begin(), scan.pairs.end(), [&](const Overlap& a, const Overlap& b) {
      return std::abs(a.share - share) < std::abs(b.share - share);
    });
    for (std::size_t seed = 0; seed < std::min(seeds, scan.pairs.size()); ++seed)
      for (const int off : {5, 10, 20, 30}) {
        result.push_back(started(scan, "", scan.pairs[seed], off, random));
        result.back().overlap = share;
      }
  }
  return result;
}

Vec3 true_middle(const PairCase& pair) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : pair.second.cloud.points) middle += pair.truth * p / double(pair.second.cloud.size());
  return middle;
}

PairError pair_error(const PairCase& pair, const Pose& found, const std::vector<FreeMotion>& free) {
  const Vec3 center = true_middle(pair);
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
      d = (free[k].turns ? rotation_about(free[k].point, free[k].axis, s) : Pose{Mat3::Identity(), s * free[k].axis}) *
          d;
    }
  }
  const auto e = error_of();
  return {e.head<3>().norm() / pair.radius, e.tail<3>().norm()};
}

bool is_right(const PairCase& pair, const PairError& error) {
  return error.angle * 180 / pi <= 1 && error.shift <= 0.02 * pair.radius;
}

int degrees_off(const PairCase& pair) { return static_cast<int>(std::lround(pair.start * 180 / pi)); }

}  // namespace partscribe::testing
