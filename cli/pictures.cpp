#include "cli/pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cli/describe.h"
#include "core/number.h"
#include "geometry/kd_tree.h"

namespace partscribe {
namespace {

constexpr int picture_width = 560, picture_height = 420;
constexpr Color background{250, 250, 248}, scan_color{150, 178, 205}, rejected_color{235, 120, 20},
    model_color{214, 196, 150};

struct Side {
  std::string name, words;
  Vec3 to_eye;  ///< in the part's frame
};

Color mixed(Color a, Color b, double share) {
  auto mix = [&](int x, int y) { return static_cast<std::uint8_t>(x + (y - x) * share + 0.5); };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

/// The mean of the normals: long for a surface that was seen from one side only.
Vec3 mean_normal(const PointCloud& cloud) {
  Vec3 sum = Vec3::Zero();
  for (const auto& n : cloud.normals) sum += n;
  return cloud.normals.empty() ? sum : Vec3(sum / static_cast<double>(cloud.normals.size()));
}

/// Median distance between neighbours, from some hundred points.
double spacing_of(const PointCloud& cloud) {
  if (cloud.size() < 2) return 0;
  const KdTree tree(cloud.points);
  std::vector<double> distances;
  std::vector<Neighbour> found;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / 400);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    tree.nearest(cloud.points[i], 5, found);
    distances.push_back(std::sqrt(found.back().sq_distance));
  }
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  return distances[distances.size() / 2];
}

ReportPicture finished(const Raster& raster, std::string name, std::string title, std::string description) {
  const Raster half = halved(raster);
  return {std::move(name), std::move(title), std::move(description), half.width, half.height, write_png(half)};
}

std::vector<Vec3> kept_points(const PointCloud& cloud) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i]) points.push_back(cloud.points[i]);
  return points.empty() ? cloud.points : points;
}

}  // namespace

Color deviation_color(double deviation, double tolerance) {
  if (!std::isfinite(deviation)) return {120, 120, 120};
  const double share = deviation / tolerance;
  if (std::abs(share) > 1) return {230, 0, 200};
  constexpr Color middle{225, 225, 220};
  return share < 0 ? mixed(middle, {20, 80, 200}, -share) : mixed(middle, {225, 95, 0}, share);
}

const ArtifactVerdict* drawn_artifact(const Verdict& verdict) {
  for (const auto& artifact : verdict.artifacts)
    if (!artifact.mesh.empty()) return &artifact;
  return nullptr;
}

std::vector<float> deviations_of(const PointCloud& cloud, const ArtifactVerdict* artifact) {
  if (!artifact) return {};
  const auto& given = artifact->point_deviation;
  std::vector<float> result(cloud.size(), std::numeric_limits<float>::quiet_NaN());
  std::size_t next = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.rejected.empty() && cloud.rejected[i]) continue;
    if (next == given.size()) return {};
    result[i] = given[next++];
  }
  return next == given.size() ? result : std::vector<float>();
}

std::vector<ReportPicture> draw_report(const Model& model, const Verdict& verdict, const PointCloud& cloud) {
  const Pose scan_from_part = model.as_scanned ? evaluate(model.scan_from_part, values_of(model)) : Pose{};
  Vec3 up = scan_from_part.rotation * Vec3(0, 0, 1);
  std::vector<Side> sides = {{"front", "from the front, right and above", {0.75, -1, 0.7}},
                             {"back", "from the back, left and below", {-0.75, 1, -0.55}}};
  for (auto& side : sides) side.to_eye = scan_from_part.rotation * side.to_eye;
  // A scan from one side only is looked at from that side.
  if (const Vec3 facing = mean_normal(cloud); facing.norm() > 0.5) {
    const Vec3 eye = facing.normalized();
    if (std::abs(eye.dot(up)) > 0.9) up = scan_from_part.rotation * Vec3(0, 1, 0);
    const Vec3 right = up.cross(eye).normalized();
    sides = {{"front", "from the side of the scanner", eye},
             {"back", "from the side of the scanner, turned by 50 degrees", 0.64 * eye + 0.77 * right}};
  }

  const auto kept = kept_points(cloud);
  Box3 box;
  for (const auto& point : kept) box.add(point);
  const double spacing = spacing_of(cloud);
  const ArtifactVerdict* artifact = drawn_artifact(verdict);
  const auto deviations = deviations_of(cloud, artifact);
  const std::string size =
      readable(box.size().x()) + " x " + readable(box.size().y()) + " x " + readable(box.size().z()) + " mm";
  std::vector<ReportPicture> scans, models, maps;
  for (const auto& side : sides) {
    const Camera camera = camera_for(kept, side.to_eye, up, 2 * picture_width, 2 * picture_height);
    const double radius = std::clamp(0.75 * spacing * camera.pixels_per_mm, 1.0, 14.0);
    const Raster empty(2 * picture_width, 2 * picture_height, background);
    std::vector<Color> colors(cloud.size());

    Raster scan = empty;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const bool rejected = !cloud.rejected.empty() && cloud.rejected[i];
      colors[i] = rejected                ? rejected_color
                  : cloud.normals.empty() ? scan_color
                                          : shaded(scan_color, camera, cloud.normals[i]);
    }
    draw_points(scan, camera, cloud.points, colors, radius);
    scans.push_back(finished(scan, "scan-" + side.name + ".png", "Scan, " + side.words,
                             "The " + std::to_string(cloud.size()) + " scanned points, " + size + ", seen " +
                                 side.words + "; points set aside as outliers are orange."));
    if (!artifact) continue;

    Raster solid = empty;
    draw_mesh(solid, camera, artifact->mesh, model_color);
    models.push_back(finished(
        solid, "model-" + side.name + ".png", "Model, " + side.words,
        "The geometry that " + artifact->program + " made of " + artifact->file + ", seen " + side.words + "."));
    if (deviations.empty()) continue;

    Raster map = empty;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Color color = deviation_color(deviations[i], verdict.tolerance);
      colors[i] = cloud.normals.empty() ? color : mixed(color, shaded(color, camera, cloud.normals[i]), 0.35);
    }
    std::vector<Vec3> judged;
    std::vector<Color> judged_colors;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (std::isfinite(deviations[i])) judged.push_back(cloud.points[i]), judged_colors.push_back(colors[i]);
    draw_points(map, camera, judged, judged_colors, radius);
    maps.push_back(finished(map, "deviation-" + side.name + ".png", "Deviation, " + side.words,
                            "The points coloured by their local deviation from the model, seen " + side.words +
                                "; the largest is " + readable(artifact->data_to_model.local_max) +
                                " mm, the tolerance " + print_number(verdict.tolerance) + " mm."));
  }
  std::vector<ReportPicture> all;
  for (auto* group : {&scans, &models, &maps})
    for (auto& picture : *group) all.push_back(std::move(picture));
  return all;
}

}  // namespace partscribe
