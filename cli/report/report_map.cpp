#include "cli/report/report_map.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/pictures/color_scale.h"
#include "cli/pictures/pictures.h"
#include "cli/report/report_html.h"
#include "cli/report/report_points.h"
#include "core/number.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::cli {
namespace {

using Json = nlohmann::ordered_json;

void append(std::string& bytes, long value) {  // 16 bits, the low byte first
  const auto word = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::clamp(value, -32767l, 32767l)));
  bytes += static_cast<char>(word & 0xff);
  bytes += static_cast<char>(word >> 8);
}

void append_index(std::string& bytes, std::uint32_t index) {
  bytes += static_cast<char>(index & 0xff);
  bytes += static_cast<char>(index >> 8 & 0xff);
}

void append_normal(std::string& bytes, const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis)
    bytes += static_cast<char>(static_cast<std::int8_t>(std::lround(127 * std::clamp(normal[axis], -1.0, 1.0))));
}

/// Places and deviations as 16-bit numbers.
struct Quantiser {
  Vec3 center = Vec3::Zero();
  double step = 1, deviation_step = 1;  ///< mm per unit
  void place(std::string& bytes, const Vec3& p) const {
    for (int axis = 0; axis < 3; ++axis) append(bytes, std::lround((p[axis] - center[axis]) / step));
  }
  void deviation(std::string& bytes, double d) const { append(bytes, std::lround(d / deviation_step)); }
};

Json numbers(const Vec3& v, double resolution) {
  return Json::array({snapped(v.x(), resolution), snapped(v.y(), resolution), snapped(v.z(), resolution)});
}

Json packed_surface(const DeviationSurface& surface, const Quantiser& q) {
  std::string places, normals, features, triangles, edges;
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    q.place(places, surface.points[v]);
    q.deviation(places, surface.deviation[v]);
    append_normal(normals, surface.normals[v]);
    normals += static_cast<char>(surface.support[v]);
    append_index(features, static_cast<std::uint32_t>(surface.feature[v] + 1));
  }
  for (const auto& triangle : surface.triangles)
    for (const auto v : triangle) append_index(triangles, v);
  for (const auto& edge : surface.edges)
    for (const auto v : edge) append_index(edges, v);
  Json json;
  json["places"] = base64(places);
  json["normals"] = base64(normals);
  json["features"] = base64(features);
  json["triangles"] = base64(triangles);
  json["edges"] = base64(edges);
  return json;
}

}  // namespace

MapData map_data(const ReportScene& scene, const MapOptions& options) {
  MapData map;
  if (scene.deviations.empty() || scene.surface.empty()) return map;
  const PointCloud& cloud = *scene.cloud;
  const auto most = static_cast<std::size_t>(scene.detail * static_cast<double>(options.most_points));
  const auto shown = shown_points(cloud.points, scene.deviations, scene.tolerance, most);
  map.shown = shown.index.size(), map.of = shown.of;
  map.value_error = shown.value_error;
  map.surface_error = scene.surface.error;

  Box3 box;
  double largest = 2 * scene.tolerance;
  for (const auto& p : scene.surface.points) box.add(p);
  for (const auto i : shown.index) {
    box.add(cloud.points[i]);
    largest = std::max(largest, std::abs(static_cast<double>(scene.deviations[i])));
  }
  Quantiser q;
  q.center = box.center();
  q.step = std::max(0.5 * box.size().maxCoeff(), 1e-9) / 32000;
  q.deviation_step = largest / 32000;

  std::string places, normals, features, aside;
  // Points are lit as the surface beside them: a scan need not know its normals.
  const KdTree vertices(scene.surface.points);
  for (const auto i : shown.index) {
    q.place(places, cloud.points[i]);
    append_normal(normals, scene.surface.normals[vertices.nearest_one(cloud.points[i]).index]);
    normals += '\0';
    q.deviation(places, scene.deviations[i]);
    append_index(features, static_cast<std::uint32_t>(scene.features[i] + 1));
  }
  // Points that were set aside, as far as they lie near the part: at most a few thousand, evenly taken.
  std::vector<std::uint32_t> outliers;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (!std::isfinite(scene.deviations[i]) && ((cloud.points[i] - q.center).cwiseAbs() / q.step).maxCoeff() < 32767)
      outliers.push_back(i);
  const std::size_t stride = outliers.size() / static_cast<std::size_t>(std::max(1.0, 3000 * scene.detail)) + 1;
  for (std::size_t k = 0; k < outliers.size(); k += stride) {
    q.place(aside, cloud.points[outliers[k]]);
    append(aside, 0);
  }
  std::string ramp;
  for (int k = 0; k < 256; ++k) {
    const Color c = deviation_color((k - 127.5) / 128 * 2 * scene.tolerance, scene.tolerance);
    for (const auto part : {c.red, c.green, c.blue}) ramp += static_cast<char>(part);
  }

  Json json;
  json["tolerance"] = scene.tolerance;
  json["center"] = numbers(q.center, 1e-9);
  json["step"] = q.step;
  json["deviationStep"] = q.deviation_step;
  json["spacing"] = snapped(scene.spacing, 1e-6);
  json["ramp"] = base64(ramp);
  json["views"] = Json::array();
  for (const auto& view : scene.views)
    json["views"].push_back({{"name", view.name},
                             {"words", view.words},
                             {"eye", numbers(view.to_eye, 1e-6)},
                             {"up", numbers(view.up, 1e-6)}});
  json["features"] = Json::array();
  for (const auto& feature : scene.artifact->objects) json["features"].push_back(feature.name);
  json["findings"] = Json::array();
  for (const auto& finding : scene.artifact->findings)
    json["findings"].push_back({{"place", numbers(finding.place, 1e-4)},
                                {"direction", numbers(finding.direction, 1e-4)},
                                {"extent", snapped(finding.extent, 1e-3)},
                                {"kind", name_of(finding.kind)},
                                {"text", finding.text}});
  json["surface"] = packed_surface(scene.surface, q);
  json["points"] = {{"places", base64(places)}, {"normals", base64(normals)}, {"features", base64(features)}};
  json["aside"] = base64(aside);
  map.json = json.dump();
  // Inside a script element nothing may look like its end.
  for (std::size_t at = 0; (at = map.json.find("</", at)) != std::string::npos; at += 3)
    map.json.replace(at, 2, "<\\/");
  return map;
}

}  // namespace partscribe::cli
