/// scan: from scan files to one cloud in one frame.
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/stages.h"
#include "core/json_text.h"
#include "geometry/normals.h"
#include "geometry/read_geometry.h"

namespace partscribe {
namespace {

constexpr const char* help =
    R"(Examples
  partscribe scan view1.ply view2.ply                  writes view1-partscribe/cloud.ply and poses.json
  partscribe scan folder/scan.json --out part          range images with poses
  partscribe scan bracket.obj --units m                the file's numbers are metres

Reads every format and units once, estimates normals and noise, flags outliers (they are kept, and counted). Writes
cloud.ply (points, normals, noise, view, flags) and poses.json (where each view stood). 'fit' goes on from there.)";

nlohmann::ordered_json pose_json(const Pose& pose) {
  auto rows = nlohmann::ordered_json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({pose.rotation(r, 0), pose.rotation(r, 1), pose.rotation(r, 2), pose.translation[r]});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

std::string poses_json(const Scan& scan) {
  nlohmann::ordered_json json;
  json["views"] = nlohmann::ordered_json::array();
  for (const auto& view : scan.views) {
    nlohmann::ordered_json row;
    row["file"] = view.file;
    row["world_from_view"] = pose_json(view.world_from_view);
    row["status"] = "given";
    json["views"].push_back(row);
  }
  return json_text(json);
}

Result<int> run(const std::vector<Path>& inputs, Session& session) {
  const Path folder = output_folder(session.options, inputs.front(), part_name(inputs.front()));
  if (auto ok = check_overwriting(folder, {"cloud.ply", "poses.json"}, session.options.force); !ok) return ok.error();
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto scan = read_scans(inputs, session);
  if (!scan) return scan.error();
  if (auto ok = make_folder(folder); !ok) return ok.error();
  if (auto ok = session.stage("normals"); !ok) return ok.error();
  const auto sampling = estimate_normals(scan->cloud, {}, session.context);
  if (auto ok = session.stage("write"); !ok) return ok.error();
  if (auto ok = write_file(folder / "cloud.ply", write_cloud_ply(scan->cloud)); !ok) return ok.error();
  if (auto ok = write_file(folder / "poses.json", poses_json(*scan)); !ok) return ok.error();
  session.finish_stage();
  const Vec3 size = scan->cloud.bounds().size();
  session.print("Points " + std::to_string(scan->cloud.size()) + ", set aside " + std::to_string(sampling.rejected) +
                ", views " + std::to_string(scan->views.size()) + "\nSize " + readable(size.x()) + " x " +
                readable(size.y()) + " x " + readable(size.z()) + " mm, noise " + readable(sampling.sigma) +
                " mm, distance between points " + readable(sampling.spacing) + " mm\nCloud in " +
                (folder / "cloud.ply").string() + "; next: partscribe fit " + (folder / "cloud.ply").string() + "\n");
  session.print_json(summary_json("scan", {folder / "cloud.ply", folder / "poses.json"}, scan->warnings));
  return 0;
}

}  // namespace

Command scan_command() {
  auto inputs = std::make_shared<std::vector<Path>>();
  return {"scan", "read scan files into one cleaned cloud in millimetres", help,
          [inputs](Arguments& a) { a.paths(*inputs, "scan", "scan files of one part, in one common frame"); },
          [inputs](Session& session) { return run(*inputs, session); }};
}

}  // namespace partscribe
