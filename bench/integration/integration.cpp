/// Integration of pinhole views at true poses beside Open3D's: Markdown tables, `bench_integration MODEL.json...`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "bench/integration/peers.h"
#include "core/files.h"
#include "core/statistics.h"
#include "geometry/points/kd_tree.h"
#include "model/distance/distance.h"
#include "model/json.h"
#include "scan/filter/filter.h"
#include "scan/merge/merge.h"
#include "scan/simulate/simulate.h"

using namespace partscribe::scan;

namespace {

double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct Scene {
  SimulatedScan scan;
  std::vector<RangeImage> images;
  std::vector<Vec3> seen;  // true places behind the pixels, every twentieth
};

Scene scene_of(const Model& model, int bits, double sigma, double bit_error) {
  Context context;
  const Surface surface = surface_of(model);
  SimulateOptions options;
  options.projection = Projection::pinhole;
  options.views = "cube", options.bits = bits, options.sigma = sigma, options.bit_error = bit_error;
  Scene scene{simulate(surface, options, context), {}, {}};
  std::size_t k = 0;
  for (const SimulatedView& view : scene.scan.views) {
    const RangeImage& image = view.image;
    scene.images.push_back(image);
    for (int row = 0; row < image.height; ++row)
      for (int column = 0; column < image.width; ++column) {
        if (!view_point(image, row, column) || ++k % 20 != 0) continue;
        const Vec3 from = image.world_from_view.translation;
        const Vec3 direction = image.world_from_view.rotation *
                               Vec3((column - image.cx) / image.fx, (row - image.cy) / image.fy, 1).normalized();
        if (const auto hit = surface.first_hit(from, direction)) scene.seen.push_back(from + hit->distance * direction);
      }
  }
  return scene;
}

/// `stated`: the sigma of each point; nothing where a method states none.
void row(const char* name, const std::vector<Vec3>& points, const std::vector<float>& stated,
         const ModelDistance& truth, const Scene& scene, double sigma, double spent) {
  std::vector<double> off, ratio;
  double square = 0;
  for (const Vec3& p : points) off.push_back(std::abs(truth(p).distance)), square += off.back() * off.back();
  for (std::size_t i = 0; i < stated.size(); ++i) ratio.push_back(off[i] / std::max<double>(stated[i], 1e-9));
  const KdTree tree(points);
  std::size_t shown = 0;
  for (const Vec3& p : scene.seen) shown += tree.nearest_one(p).sq_distance < 1;
  const double worst = *std::max_element(off.begin(), off.end());
  std::printf("| %s | %zu | %.4f | %.4f | %.4f | %.3f | %.2f | %.2f | ", name, points.size(),
              std::sqrt(square / double(points.size())), median(off), quantile(off, 0.95), worst, median(off) / sigma,
              worst / sigma);
  if (ratio.empty())
    std::printf("| | ");
  else
    std::printf("%.2f | %.2f | ", quantile(ratio, 0.999), *std::max_element(ratio.begin(), ratio.end()));
  std::printf("%.2f %% | %.2f |\n", 100 * double(shown) / double(scene.seen.size()), spent);
}

/// What the filter kept, and how much of the good: samples within four deviations and a code of the part.
void filtered_row(const Scan& filtered, const ModelDistance& truth, const Scene& scene, double sigma, double spent) {
  std::vector<Vec3> points;
  std::vector<float> stated;
  std::size_t good = 0, good_kept = 0;
  for (std::size_t i = 0; i < filtered.cloud.size(); ++i) {
    const bool kept = !filtered.cloud.rejected[i];
    const bool is_good =
        std::abs(truth(scene.scan.merged.cloud.points[i]).distance) < 4 * sigma + scene.images.front().q;
    good += is_good, good_kept += is_good && kept;
    if (kept) points.push_back(filtered.cloud.points[i]), stated.push_back(filtered.cloud.sigma[i]);
  }
  char name[80];
  std::snprintf(name, sizeof name, "filtered, %.2f %% of the good kept", 100 * double(good_kept) / double(good));
  row(name, points, stated, truth, scene, sigma, spent);
}

std::vector<peers::DepthView> depth_views(const Scan& scan, const std::vector<RangeImage>& images) {
  std::vector<peers::DepthView> result;
  std::vector<Pose> view_from_world;
  for (const RangeImage& image : images) {
    result.push_back({image.width, image.height, image.fx, image.fy, image.cx, image.cy, image.world_from_view, {}});
    result.back().depth.assign(std::size_t(image.width) * std::size_t(image.height), 0.0f);
    view_from_world.push_back(image.world_from_view.inverse());
  }
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const auto v = std::size_t(scan.cloud.view[i]);
    if (!scan.cloud.rejected[i])
      result[v].depth[std::size_t(scan.cloud.pixel[i])] = float((view_from_world[v] * scan.cloud.points[i]).z());
  }
  return result;
}

void compare(const Model& model, int bits, double sigma, double bit_error) {
  Context context;
  const ModelDistance truth(model);
  const Scene scene = scene_of(model, bits, sigma, bit_error);
  std::printf("\n**%s, %d bits, sigma %g mm, bit errors %g**\n\n", model.name.c_str(), bits, sigma, bit_error);
  std::printf(
      "| method | points | rms mm | median | 95 %% | worst | median / sigma | worst / sigma | off / stated sigma, 99.9 "
      "%% | worst | seen surface within 1 mm | s |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  row("as measured", scene.scan.merged.cloud.points, {}, truth, scene, sigma, 0);
  double start = seconds();
  Scan filtered = scene.scan.merged;
  filter_views(filtered, scene.images, context);
  const double filter_time = seconds() - start;
  filtered_row(filtered, truth, scene, sigma, filter_time);
  start = seconds();
  const MergedCloud merged = merge_views(filtered.cloud, {}, context);
  const double merge_time = filter_time + seconds() - start;
  row("filtered, merged", merged.cloud.points, merged.cloud.sigma, truth, scene, sigma, merge_time);
  if (!peers::has_open3d()) {
    std::printf("| Open3D: not run | | | | | | | | | | | |\n");
    return;
  }
  const auto views = depth_views(filtered, scene.images);
  for (const double voxel : {0.625, 1.25})
    for (const bool scalable : {true, false}) {
      start = seconds();
      const auto zeros = peers::open3d_distance_field(views, voxel, scalable);
      const double spent = seconds() - start;
      char name[80];
      std::snprintf(name, sizeof name, "filtered, Open3D %s distance field, voxel %g mm",
                    scalable ? "scalable" : "uniform", voxel);
      row(name, zeros, {}, truth, scene, sigma, filter_time + spent);
    }
  for (const int depth : {8, 9}) {
    start = seconds();
    const auto vertices = peers::open3d_poisson(merged.cloud.points, merged.cloud.normals, depth);
    const double spent = seconds() - start;
    row(("filtered, merged, Open3D Poisson, depth " + std::to_string(depth)).c_str(), vertices, {}, truth, scene, sigma,
        merge_time + spent);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::printf("usage: bench_integration MODEL.json...\n"), 2;
  for (int k = 1; k < argc; ++k) {
    const auto text = read_file(argv[k]);
    const auto model = text.ok() ? read_model_json(*text, argv[k]) : Result<Model>(text.error());
    if (!model.ok()) return std::printf("%s\n", model.error().message.c_str()), 3;
    compare(*model, 16, 0.01, 0.001);
    compare(*model, 12, 0.2, 0.01);
  }
}
