#include "cli/pictures/pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "cli/describe.h"
#include "cli/pictures/annotate.h"
#include "cli/pictures/color_scale.h"
#include "cli/pictures/raster_text.h"
#include "cli/report/report_words.h"
#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::cli {
namespace {

constexpr int fine = 3;  // pixels are drawn three times finer, then averaged
constexpr Color scan_color{150, 178, 205}, aside_color{120, 60, 160}, model_color{196, 200, 206},
    line_color{40, 50, 62};

struct Size {
  int width, height;
};

Raster canvas_of(Size size) { return Raster(size.width * fine, size.height * fine, paper); }

/// Diagonal stripes for whoever cannot tell the colours apart.
bool striped(int column, int row) { return (column + row) / (fine * 3) % 3 == 0; }

void draw_deviation(Raster& raster, const Camera& camera, const ReportScene& scene) {
  const DeviationSurface& s = scene.surface;
  draw_triangles(raster, camera, s.points, s.triangles, [&](std::uint32_t t, const Vec3& w, int column, int row) {
    const auto& v = s.triangles[t];
    double unseen = 0, refuted = 0, deviation = 0;
    Vec3 normal = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      unseen += s.support[v[k]] == 1 ? w[k] : 0;
      refuted += s.support[v[k]] == 2 ? w[k] : 0;
      deviation += w[k] * s.deviation[v[k]];
      normal += w[k] * s.normals[v[k]];
    }
    Color color = deviation_color(deviation, scene.tolerance);
    if (refuted > 0.5)
      color = striped(column, row) ? contradicted_stripe : contradicted_color;
    else if (unseen > 0.5)
      color = striped(column, row) ? not_scanned_stripe : not_scanned_color;
    return shaded(color, camera, normal.normalized(), 0.5);
  });
}

void draw_plain(Raster& raster, const Camera& camera, const ReportScene& scene) {
  const DeviationSurface& s = scene.surface;
  draw_triangles(raster, camera, s.points, s.triangles, [&](std::uint32_t t, const Vec3& w, int, int) {
    const auto& v = s.triangles[t];
    const Vec3 normal = w[0] * s.normals[v[0]] + w[1] * s.normals[v[1]] + w[2] * s.normals[v[2]];
    return shaded(model_color, camera, normal.normalized());
  });
}

void draw_outlines(Raster& raster, const Camera& camera, const ReportScene& scene) {
  const double size = scene.artifact->mesh.bounds().diagonal();
  // A triangulated free form has creases everywhere; they would hide what is drawn on it.
  if (scene.surface.edges.size() * 4 < scene.surface.triangles.size())
    draw_lines(raster, camera, scene.surface.points, scene.surface.edges, 1.1 * fine, line_color);
  draw_contour(raster, 0.01 * size, fine, line_color);
}

/// Normals of the points, or of the surface next to them where the scan has none.
std::vector<Vec3> normals_of(const ReportScene& scene, int threads) {
  const PointCloud& cloud = *scene.cloud;
  if (!cloud.normals.empty() || scene.surface.empty()) return cloud.normals;
  std::vector<Vec3> normals(cloud.size());
  const KdTree tree(scene.surface.points);
  parallel_for(cloud.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      normals[i] = scene.surface.normals[tree.nearest_one(cloud.points[i]).index];
  });
  return normals;
}

void draw_scan(Raster& raster, const Camera& camera, const ReportScene& scene, const std::vector<Vec3>& normals) {
  const PointCloud& cloud = *scene.cloud;
  std::vector<Color> colors(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool aside =
        scene.deviations.empty() ? !cloud.rejected.empty() && cloud.rejected[i] : !std::isfinite(scene.deviations[i]);
    colors[i] = aside ? aside_color : normals.empty() ? scan_color : shaded(scan_color, camera, normals[i]);
  }
  draw_points(raster, camera, cloud.points, colors,
              std::clamp(0.75 * scene.spacing * camera.pixels_per_mm, 1.0, 7.0 * fine));
}

ReportPicture finished(const Raster& drawn, const Camera& drawn_by, const ReportScene& scene, bool scale,
                       std::string name, std::string title, std::string description, int ring_px = 0) {
  Raster raster = reduced(drawn, fine);
  Camera camera = drawn_by;
  camera.pixels_per_mm /= fine;
  if (ring_px > 0)
    for (int k = 0; k < 48; ++k) {
      auto at = [&](int step) {
        const double angle = 2 * pi * step / 48;
        return Vec2(raster.width / 2.0 + ring_px * std::cos(angle), raster.height / 2.0 + ring_px * std::sin(angle));
      };
      draw_stroke(raster, at(k), at(k + 1), 2, {20, 20, 20});
    }
  annotate(raster, camera, title);
  if (scale) draw_scale(raster, raster.width - 66, 34, std::min(220, raster.height - 80), scene.tolerance);
  return {std::move(name), std::move(title), std::move(description), raster.width, raster.height, write_png(raster)};
}

std::vector<Vec3> framed_points(const ReportScene& scene) {
  if (!scene.surface.empty()) return scene.surface.points;
  std::vector<Vec3> points;
  const PointCloud& cloud = *scene.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i]) points.push_back(cloud.points[i]);
  return points.empty() ? cloud.points : points;
}

/// The part fills the picture left of the scale and above the bar.
Camera camera_beside_scale(const std::vector<Vec3>& points, const ReportView& view, Size size) {
  constexpr int right = 76, top = 28, bottom = 30;
  Camera camera =
      camera_for(points, view.to_eye, view.up, (size.width - right) * fine, (size.height - top - bottom) * fine);
  const Vec3 shift(0.5 * right * fine / camera.pixels_per_mm, 0.5 * (top - bottom) * fine / camera.pixels_per_mm, 0);
  camera.center += camera.view_from_world.transpose() * shift;
  return camera;
}

/// The direction from which a place on the surface can be seen best: along its normal, unless something is in the way.
Vec3 clear_view(const MeshDistance& surface, const Vec3& place, const Vec3& normal, double size) {
  Vec3 best = normal;
  double best_value = -2;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3 direction = Vec3(x, y, z).normalized();
        const double value = direction.dot(normal);
        if (value <= best_value || value < 0.1) continue;
        if (surface.first_hit(place + 1e-3 * size * normal, direction, 2 * size)) continue;
        best = direction, best_value = value;
      }
  return best;
}

/// What all pictures of a scene need, worked out once.
struct Studio {
  const ReportScene& scene;
  const std::vector<Vec3> points = framed_points(scene);
  const std::vector<Vec3> normals;  // of the scanned points

  Studio(const ReportScene& drawn, int threads) : scene(drawn), normals(normals_of(drawn, threads)) {}

  ReportPicture deviation(const ReportView& view, Size size, std::string name) const {
    Raster raster = canvas_of(size);
    const Camera camera = camera_beside_scale(points, view, size);
    draw_deviation(raster, camera, scene);
    draw_outlines(raster, camera, scene);
    return finished(raster, camera, scene, true, std::move(name), "Deviation in mm, " + view.words,
                    "The surface of " + scene.artifact->file + " seen " + view.words +
                        ", coloured by how far the scan lies from it; the largest local deviation is " +
                        readable(scene.artifact->data_to_model.local_max) + " mm, the tolerance " +
                        print_number(scene.tolerance) + " mm. Striped: not scanned.");
  }

  ReportPicture scan(const ReportView& view, Size size, std::string name) const {
    Raster raster = canvas_of(size);
    const Camera camera = camera_for(points, view.to_eye, view.up, raster.width, raster.height - bar_room);
    draw_scan(raster, camera, scene, normals);
    Box3 box;
    for (const auto& p : points) box.add(p);
    const Vec3 s = box.size();
    return finished(raster, camera, scene, false, std::move(name), "Scan, " + view.words,
                    "The " + std::to_string(scene.cloud->size()) + " scanned points, " + readable(s.x()) + " x " +
                        readable(s.y()) + " x " + readable(s.z()) + " mm; points set aside as outliers are purple.");
  }

  ReportPicture model(const ReportView& view, Size size, std::string name) const {
    Raster raster = canvas_of(size);
    const Camera camera = camera_for(points, view.to_eye, view.up, raster.width, raster.height - bar_room);
    draw_plain(raster, camera, scene);
    draw_outlines(raster, camera, scene);
    const ArtifactVerdict& drawn = *scene.artifact;
    const bool made = !drawn.program.empty();
    return finished(raster, camera, scene, false, std::move(name), (made ? "Model, " : "Mesh, ") + view.words,
                    made ? "The geometry that " + drawn.program + " made of " + drawn.file + "."
                         : "The mesh of " + drawn.file + ".");
  }

 private:
  static constexpr int bar_room = 40 * fine;  // for the bar of a round length
};

}  // namespace

ReportPicture draw_view(const ReportScene& scene, Drawn what, const ReportView& view, int width_px, int height_px,
                        int threads) {
  const Studio studio(scene, threads);
  const Size size{width_px, height_px};
  const std::string name = view.name + ".png";
  return what == Drawn::deviation ? studio.deviation(view, size, name)
         : what == Drawn::model   ? studio.model(view, size, name)
                                  : studio.scan(view, size, name);
}

std::vector<ReportPicture> draw_report(const ReportScene& scene, Context& context) {
  const Studio studio(scene, context.threads);
  if (studio.points.empty()) return {};
  const ArtifactVerdict* artifact = scene.surface.empty() ? nullptr : scene.artifact;
  // What to draw is listed first; then the pictures are made, several at a time.
  std::vector<std::function<ReportPicture()>> tasks;
  const ReportView& first = scene.views.front();
  if (artifact) tasks.push_back([&] { return studio.deviation(first, {760, 520}, "deviation.png"); });
  tasks.push_back([&] { return studio.scan(first, {560, 400}, "scan.png"); });
  if (artifact) {
    tasks.push_back([&] { return studio.model(first, {560, 400}, "model.png"); });
    for (std::size_t k = 1; k < scene.views.size(); ++k)
      tasks.push_back([&, k] { return studio.deviation(scene.views[k], {480, 360}, scene.views[k].name + ".png"); });
  }
  std::unique_ptr<MeshDistance> surface;
  std::unique_ptr<KdTree> vertices;
  if (artifact && !artifact->findings.empty()) {
    surface = std::make_unique<MeshDistance>(artifact->mesh);
    vertices = std::make_unique<KdTree>(scene.surface.points);
    const double size = artifact->mesh.bounds().diagonal();
    for (std::size_t k = 0; k < std::min(most_finding_pictures, artifact->findings.size()); ++k)
      tasks.push_back([&, k, size] {
        const Finding& finding = artifact->findings[k];
        const Vec3 normal = scene.surface.normals[vertices->nearest_one(finding.place).index];
        Raster raster = canvas_of({480, 360});
        Vec3 up = first.up;
        const Vec3 eye = clear_view(*surface, finding.place, normal, size);
        if (std::abs(up.normalized().dot(eye)) > 0.95) up = first.up.unitOrthogonal();
        const double radius = std::clamp(1.4 * finding.extent, 0.1 * size, 0.6 * size);
        Camera camera = camera_for({finding.place, finding.place + eye}, eye, up, raster.width, raster.height);
        camera.center = finding.place;
        camera.pixels_per_mm = 0.5 * raster.height / radius;
        draw_deviation(raster, camera, scene);
        draw_outlines(raster, camera, scene);
        const int ring = static_cast<int>(std::clamp(0.6 * finding.extent * camera.pixels_per_mm / fine, 14.0, 150.0));
        return finished(raster, camera, scene, true, "finding-" + std::to_string(k + 1) + ".png",
                        "Finding " + std::to_string(k + 1) + ": " + title_of(finding.kind),
                        finding.text.empty() ? title_of(finding.kind) : finding.text, ring);
      });
  }
  std::vector<ReportPicture> pictures(tasks.size());
  parallel_for(
      tasks.size(), context.threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) pictures[i] = tasks[i]();
      },
      1);
  return pictures;
}

}  // namespace partscribe::cli
