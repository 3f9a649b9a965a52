#include "eight_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "bound.h"
#include "core/number.h"
#include "scan/register/register_pair.h"
#include "testing/free_forms.h"
#include "testing/registration/cases.h"

namespace partscribe::testing {
namespace {

/// What became of the views beside the reference.
struct PosesFound {
  int views = 0, refused = 0;
  std::vector<double> angle, pixels;  // of those that are registered: degrees, rms of their points in pixels
};

void add_scan(const registration::Case& scan, PairMethod method, PosesFound& found) {
  Context context;
  context.threads = 2;
  RegisterOptions options;
  options.method = method;
  const auto result = register_views(scan.views, options, context);
  if (!result.ok()) return;
  const Pose back = scan.truth[0] * result->views[0].world_from_view.inverse();
  for (std::size_t v = 1; v < scan.views.size(); ++v) {
    ++found.views;
    if (result->views[v].status == ViewStatus::refused) {
      ++found.refused;
      continue;
    }
    const PointCloud& cloud = scan.views[v].cloud;
    const Pose pose = back * result->views[v].world_from_view;
    std::vector<double> off;
    for (const Vec3& p : cloud.points) off.push_back((pose * p - scan.truth[v] * p).norm());
    found.pixels.push_back(root_mean_square(off) / std::abs(cloud.points[1].x() - cloud.points[0].x()));
    found.angle.push_back(degrees(rotation_vector(pose.rotation * scan.truth[v].rotation.transpose()).norm()));
  }
}

double worst_of(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

void eight_poses_of_1993(const std::vector<std::string>& seeds) {
  const auto lump = sculpture(90);
  struct Row {
    const char* words;
    Surface part;
    double step;  // degrees between poses
    PairMethod method;
  };
  const std::vector<Row> rows{
      {"polyhedron, 45 degrees apart, planar patches", registration::cut_block(), 45, PairMethod::paper},
      {"polyhedron, 45 degrees apart, triangles", registration::cut_block(), 45, PairMethod::paper_triangles},
      {"sculpture, 30 degrees apart, triangles", surface_of(lump), 30, PairMethod::paper_triangles},
      {"sculpture, 45 degrees apart, triangles", surface_of(lump), 45, PairMethod::paper_triangles}};
  const std::vector<std::pair<double, double>> guesses{{1, 0.3}, {3, 1}, {5, 3}};  // degrees, mm
  std::printf(
      "| object, poses, primitives | guesses off | views | refused | rms deg | worst deg | rms pixel | worst pixel | s "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows)
    for (const auto& [angle, shift] : guesses) {
      PosesFound found;
      const std::clock_t start = std::clock();
      for (const std::string& seed : seeds) {
        SimulateOptions scanner;
        scanner.resolution = 128, scanner.sigma = 0.02, scanner.seed = std::stoull(seed);
        add_scan(registration::scan_in_poses(row.part, registration::eight_poses(radians(row.step), 0.6), scanner,
                                             radians(angle), shift),
                 row.method, found);
      }
      std::printf("| %s | %g deg, %g mm | %d | %d | %.4f | %.4f | %.3f | %.3f | %.1f |\n", row.words, angle, shift,
                  found.views, found.refused, root_mean_square(found.angle), worst_of(found.angle),
                  root_mean_square(found.pixels), worst_of(found.pixels),
                  double(std::clock() - start) / CLOCKS_PER_SEC);
      std::fflush(stdout);
    }
}

}  // namespace partscribe::testing
