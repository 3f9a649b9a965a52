/// Integration of views at true poses beside a truncated signed distance field: Markdown tables, `bench_integration MODEL.json...`.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "core/files.h"
#include "core/statistics.h"
#include "geometry/kd_tree.h"
#include "model/distance.h"
#include "model/json.h"
#include "scan/filter.h"
#include "scan/merge.h"
#include "scan/simulate.h"

using namespace partscribe;

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
  options.views = "cube", options.bits = bits, options.sigma = sigma, options.bit_error = bit_error;
  Scene scene{simulate(surface, options, context), {}, {}};
  std::size_t k = 0;
  for (const SimulatedView& view : scene.scan.views) {
    const RangeImage& image = view.image;
    scene.images.push_back(image);
    for (int row = 0; row < image.height; ++row)
      for (int column = 0; column < image.width; ++column) {
        if (!view_point(image, row, column) || ++k % 20 != 0) continue;
        const Vec3 from = image.world_from_view * Vec3(image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, 0);
        const Vec3 direction = image.world_from_view.rotation.col(2);
        if (const auto hit = surface.first_hit(from, direction)) scene.seen.push_back(from + hit->distance * direction);
      }
  }
  return scene;
}

/// A voxel grid of averaged, truncated depths (Curless & Levoy 1996, all weights 1); its zeros on the edges of the grid.
class DistanceField {
 public:
  DistanceField(const std::vector<RangeImage>& images, const std::vector<std::vector<double>>& depths, const Box3& bounds, double voxel)
      : voxel_(voxel), low_(bounds.low - Vec3::Constant(4 * voxel)) {
    for (int k = 0; k < 3; ++k) count_[k] = static_cast<int>((bounds.size()[k] + 8 * voxel) / voxel) + 1;
    value_.assign(std::size_t(count_[0]) * std::size_t(count_[1]) * std::size_t(count_[2]), 0.0f);
    weight_.assign(value_.size(), 0);
    for (std::size_t v = 0; v < images.size(); ++v) add(images[v], depths[v]);
  }

  std::vector<Vec3> zeros() const {
    std::vector<Vec3> result;
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x)
          for (int axis = 0; axis < 3; ++axis) {
            const int nx = x + (axis == 0), ny = y + (axis == 1), nz = z + (axis == 2);
            if (nx >= count_[0] || ny >= count_[1] || nz >= count_[2]) continue;
            const std::size_t i = at(x, y, z), j = at(nx, ny, nz);
            if (!weight_[i] || !weight_[j]) continue;
            const double a = value_[i] / weight_[i], b = value_[j] / weight_[j];
            if ((a < 0) == (b < 0) || std::abs(a) > 0.98 || std::abs(b) > 0.98) continue;
            result.push_back(place(x, y, z) + Vec3::Unit(axis) * (voxel_ * a / (a - b)));
          }
    return result;
  }

 private:
  std::size_t at(int x, int y, int z) const { return (std::size_t(z) * std::size_t(count_[1]) + std::size_t(y)) * std::size_t(count_[0]) + std::size_t(x); }
  Vec3 place(int x, int y, int z) const { return low_ + voxel_ * Vec3(x, y, z); }

  void add(const RangeImage& image, const std::vector<double>& depth) {
    const Pose view_from_world = image.world_from_view.inverse();
    const double reach = 4 * voxel_;
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x) {
          const Vec3 p = view_from_world * place(x, y, z);
          const int column = static_cast<int>(std::lround((p.x() - image.x0) / image.pitch_x)), row = static_cast<int>(std::lround((p.y() - image.y0) / image.pitch_y));
          if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
          const double measured = depth[std::size_t(row) * std::size_t(image.width) + std::size_t(column)];
          if (!(measured - p.z() > -reach)) continue;
          value_[at(x, y, z)] += static_cast<float>(std::min(1.0, (measured - p.z()) / reach)), ++weight_[at(x, y, z)];
        }
  }

  double voxel_;
  Vec3 low_;
  std::array<int, 3> count_{};
  std::vector<float> value_;
  std::vector<std::uint16_t> weight_;
};

void row(const char* name, const std::vector<Vec3>& points, const ModelDistance& truth, const Scene& scene, double sigma, double spent) {
  std::vector<double> off, away;
  double square = 0;
  for (const Vec3& p : points) off.push_back(std::abs(truth(p).distance)), square += off.back() * off.back();
  const KdTree tree(points);
  std::size_t shown = 0;
  for (const Vec3& p : scene.seen) shown += tree.nearest_one(p).sq_distance < 1;
  std::printf("| %s | %zu | %.4f | %.4f | %.4f | %.3f | %.2f | %.2f %% | %.2f |\n", name, points.size(), std::sqrt(square / double(points.size())), median(off),
              quantile(off, 0.95), *std::max_element(off.begin(), off.end()), median(off) / sigma, 100 * double(shown) / double(scene.seen.size()), spent);
}

std::vector<Vec3> kept_points(const PointCloud& cloud) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.rejected.empty() || !cloud.rejected[i]) points.push_back(cloud.points[i]);
  return points;
}

/// The filtered depth of every pixel; not a number where none is kept.
std::vector<std::vector<double>> depths_of(const Scan& scan, const std::vector<RangeImage>& images) {
  std::vector<std::vector<double>> result;
  std::vector<Pose> view_from_world;
  for (const RangeImage& image : images) {
    result.emplace_back(std::size_t(image.width) * std::size_t(image.height), std::nan(""));
    view_from_world.push_back(image.world_from_view.inverse());
  }
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const auto v = std::size_t(scan.cloud.view[i]);
    if (!scan.cloud.rejected[i]) result[v][std::size_t(scan.cloud.pixel[i])] = (view_from_world[v] * scan.cloud.points[i]).z();
  }
  return result;
}

void compare(const Model& model, int bits, double sigma, double bit_error) {
  Context context;
  const ModelDistance truth(model);
  const Scene scene = scene_of(model, bits, sigma, bit_error);
  std::printf("\n**%s, %d bits, sigma %g mm, bit errors %g**\n\n", model.name.c_str(), bits, sigma, bit_error);
  std::printf("| method | points | rms mm | median | 95 %% | worst | median / sigma | seen surface within 1 mm | s |\n|---|---|---|---|---|---|---|---|---|\n");
  row("as measured", scene.scan.merged.cloud.points, truth, scene, sigma, 0);
  double start = seconds();
  Scan filtered = scene.scan.merged;
  filter_views(filtered, scene.images, context);
  const double filter_time = seconds() - start;
  row("filtered", kept_points(filtered.cloud), truth, scene, sigma, filter_time);
  start = seconds();
  const MergedCloud merged = merge_views(filtered.cloud, {}, context);
  row("filtered, merged", merged.cloud.points, truth, scene, sigma, filter_time + seconds() - start);
  const auto depths = depths_of(filtered, scene.images);
  const Box3 bounds = surface_of(model).bounds;
  for (const double share : {150.0, 75.0}) {
    const double voxel = bounds.diagonal() / share;
    start = seconds();
    const auto zeros = DistanceField(scene.images, depths, bounds, voxel).zeros();
    char name[80];
    std::snprintf(name, sizeof name, "filtered, distance field, voxel %.2f mm", voxel);
    row(name, zeros, truth, scene, sigma, filter_time + seconds() - start);
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
