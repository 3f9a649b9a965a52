/// scan: from scan files to one cloud in one frame.
#include <algorithm>
#include <memory>

#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/commands/views.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "geometry/io/read_geometry.h"
#include "geometry/normals/normals.h"
#include "geometry/points/keep_points.h"
#include "scan/filter/background.h"
#include "scan/merge/merge.h"

namespace partscribe::cli {
namespace {

constexpr const char* scan_help =
    R"(Examples
  partscribe scan folder/scan.json --out part             range images with poses
  partscribe scan folder/scan.json --poses guess          rough poses: the views are registered
  partscribe scan 0.ply 1.ply 2.ply --poses none          no poses at all: found from the surfaces
  partscribe scan v*.ply --poses turntable                turned about an unknown axis
  partscribe scan bracket.obj --units m                   the file's numbers are metres
  partscribe scan kinect.pcd --units m --on-table 1       only the largest thing that stands on the table

Range images are filtered (reweighted least trimmed squares: outliers flagged, noise averaged, edges kept), views are
brought into one frame, and merged where they overlap. A view that cannot be placed with certainty is left out, with
a warning that says why. Writes cloud.ply (points, normals, noise, view, flags) and poses.json (where each view stood,
its covariance, overlap and status). 'fit' goes on from there.)";

struct ScanArguments {
  std::vector<Path> inputs;
  PoseArguments poses;
  bool all_points = false;
  int on_table = 0;  // 0: everything
};

/// The filter knows normals and noise of its pixels better than neighbourhoods of all views do.
void keep_known(const PointCloud& before, PointCloud& cloud) {
  const bool normals = before.normals.size() == before.size(), sigma = before.sigma.size() == before.size();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (normals && !before.normals[i].isZero()) cloud.normals[i] = before.normals[i];
    if (sigma && before.sigma[i] > 0) cloud.sigma[i] = before.sigma[i];
  }
}

/// Merged, they would smear what is known; the line says how many they are.
std::string set_floating_aside(const Registration& registration, double spacing, PointCloud& cloud) {
  const auto floating = floating_points(registration, cloud, 5 * spacing);
  const auto count = std::count(floating.begin(), floating.end(), 1);
  if (count == 0) return "";
  cloud.rejected.resize(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (floating[i]) cloud.rejected[i] = 1;
  return "Left " + std::to_string(count) +
         " points out: free motions of their views would displace them, and other views saw those faces\n";
}

/// Only one thing that stands on the largest plane is left; the line says what went.
Result<std::string> cut_out(int which, SamplingSummary& sampling, PointCloud& cloud) {
  const auto found = cut_background(cloud, sampling.sigma, sampling.spacing, which);
  if (!found) return found.error();
  keep_points(cloud, found->keep);
  sampling.rejected = static_cast<std::size_t>(std::count(cloud.rejected.begin(), cloud.rejected.end(), 1));
  return "Kept thing " + std::to_string(which) + " of " + std::to_string(found->things.size()) +
         " that stand on a plane of " + std::to_string(found->support) + " points; its lowest " +
         readable(found->lost) + " mm went with the plane\n";
}

Result<int> run_scan(const ScanArguments& arguments, Session& session) {
  const auto& inputs = arguments.inputs;
  const Path folder = output_folder(session.options, inputs.front(), inputs.front());
  if (auto ok = check_overwriting(folder, {"cloud.ply", "poses.json"}, session.options.force); !ok) return ok.error();
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto placed =
      read_views(inputs, arguments.poses, arguments.all_points ? Points::measured : Points::filtered, session);
  if (!placed) return placed.error();
  Scan& scan = placed->scan;
  if (auto ok = session.stage("normals"); !ok) return ok.error();
  std::string news;
  if (placed->filter.views > 0)
    news += "Filtered " + std::to_string(placed->filter.views) + " range images: noise " +
            readable(placed->filter.sigma) + " mm, rejected " + std::to_string(placed->filter.rejected) + " of " +
            std::to_string(placed->filter.returns) + " returns\n";
  const bool several = scan.views.size() > 1 && scan.mesh.empty() && !arguments.all_points;
  const PointCloud samples = scan.cloud;
  SamplingSummary sampling = estimate_normals(scan.cloud, {}, session.context);
  if (several) {
    keep_known(samples, scan.cloud);
    if (auto ok = session.stage("merge"); !ok) return ok.error();
    if (placed->registration) news += set_floating_aside(*placed->registration, sampling.spacing, scan.cloud);
    MergedCloud merged = merge_views(scan.cloud, {}, session.context);
    news += "Merged " + std::to_string(merged.sample.size()) + " points into " + std::to_string(merged.cloud.size()) +
            ", " + readable(merged.spacing) + " mm apart\n";
    scan.cloud = std::move(merged.cloud), sampling.spacing = merged.spacing;
  }
  if (arguments.on_table > 0) {
    if (auto ok = session.stage("cut out"); !ok) return ok.error();
    auto line = cut_out(arguments.on_table, sampling, scan.cloud);
    if (!line) return line.error();
    news += *line;
  }
  if (auto ok = session.stage("write"); !ok) return ok.error();
  if (auto ok = make_folder(folder); !ok) return ok.error();
  const std::string cloud = write_cloud_ply(scan.cloud);
  if (auto ok = write_file(folder / "cloud.ply", cloud); !ok) return ok.error();
  if (auto ok = write_file(folder / "poses.json", poses_json(*placed, sha256(cloud))); !ok) return ok.error();
  session.finish_stage();
  const Vec3 size = scan.cloud.bounds().size();
  session.print(news + "Points " + std::to_string(scan.cloud.size()) + ", set aside " +
                std::to_string(sampling.rejected) + ", views " + std::to_string(scan.views.size()) + "\nSize " +
                readable(size.x()) + " x " + readable(size.y()) + " x " + readable(size.z()) + " mm, noise " +
                readable(sampling.sigma) + " mm, distance between points " + readable(sampling.spacing) +
                " mm\nCloud in " + (folder / "cloud.ply").string() + "; next: partscribe fit " +
                (folder / "cloud.ply").string() + "\n");
  session.print_json(summary_json("scan", {folder / "cloud.ply", folder / "poses.json"}, scan.warnings));
  return 0;
}

}  // namespace

Command scan_command() {
  auto arguments = std::make_shared<ScanArguments>();
  return {"scan", "read, filter, register and merge scan files into one clean cloud in millimetres", scan_help,
          [arguments](Arguments& a) {
            a.paths(arguments->inputs, "scan", "scan files of one part");
            declare(arguments->poses, a);
            a.count(arguments->on_table, "--on-table", "N", 1, 1000,
                    "only the Nth largest thing that stands on the largest plane: a part cut out of its surroundings");
            a.flag(arguments->all_points, "--all-points",
                   "every point as it was measured, neither filtered nor merged");
          },
          [arguments](Session& session) { return run_scan(*arguments, session); }};
}

}  // namespace partscribe::cli
