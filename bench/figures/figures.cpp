/// Figures 2 to 5 of the 1993 paper, from a run of this program: `bench_figures FOLDER MODEL.json`.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cli/pictures/raster.h"
#include "core/files.h"
#include "core/number.h"
#include "core/random.h"
#include "geometry/images/rlts_filter.h"
#include "model/json.h"
#include "scan/filter/filter.h"
#include "scan/register/register.h"
#include "scan/simulate/simulate.h"

using namespace partscribe::cli;

namespace {

constexpr Color paper{255, 255, 255}, ink{20, 24, 32}, faint{215, 218, 224};
constexpr std::array<Color, 8> view_colors{{{31, 97, 170},
                                            {214, 102, 24},
                                            {34, 139, 84},
                                            {168, 48, 60},
                                            {110, 76, 160},
                                            {120, 84, 60},
                                            {200, 78, 150},
                                            {70, 130, 150}}};

/// A picture in which one mm is one pixel, from the lower left corner.
class Sheet {
 public:
  Sheet(int width, int height) : raster_(width, height, paper) { camera_.center = {0.5 * width, 0.5 * height, 0}; }
  void line(const std::vector<Vec3>& points, double width, Color color) {
    std::vector<std::array<std::uint32_t, 2>> lines;
    for (std::uint32_t i = 0; i + 1 < points.size(); ++i) lines.push_back({i, i + 1});
    draw_lines(raster_, camera_, points, lines, width, color);
  }
  void dots(const std::vector<Vec3>& points, const std::vector<Color>& colors) {
    draw_points(raster_, camera_, points, colors, 1.3);
  }
  void pixel(int column, int row, Color color) {
    raster_.pixels[std::size_t(row) * std::size_t(raster_.width) + std::size_t(column)] = color;
  }
  void save(const Path& path) const {
    if (const auto done = write_file(path, write_png(raster_)); !done.ok())
      std::printf("%s\n", done.error().message.c_str());
  }

 private:
  Raster raster_;
  Camera camera_;
};

/// A step, a slope, a ridge and a round, in codes.
double profile_at(int i) {
  if (i < 60) return 900;
  if (i < 110) return 1500;
  if (i < 170) return 1500 - 8 * (i - 110);
  if (i < 200) return 1020 + 12 * (i - 170);
  if (i < 230) return 1380 - 12 * (i - 200);
  return 1020 + std::sqrt(std::max(0.0, 200.0 * 200 - std::pow((i - 290) * 4.0, 2)));
}

/// Figure 2: 12 bits, sigma 5 codes, bit errors with probability 0.015; trimmed lines through five samples.
void filtered_profile(const Path& folder) {
  constexpr int samples = 340;
  RangeImage image;
  image.width = samples, image.height = 1, image.z0 = 1, image.q = 1;
  Random random(3);
  std::size_t flipped = 0;
  for (int i = 0; i < samples; ++i) {
    int code = int(std::lround(profile_at(i) + 5 * random.normal()));
    if (random.uniform() < 0.015) code ^= 1 << int(12 * random.uniform()), ++flipped;
    image.codes.push_back(std::uint16_t(std::clamp(code, 1, 4095)));
  }
  Context context;
  const FilteredImage filtered = rlts_filter(image, {.form = RltsForm::profile, .sigma = 5}, context);
  Sheet sheet(3 * samples + 20, 560);
  std::vector<Vec3> noisy, clean;
  std::vector<Color> colors;
  double before = 0, after = 0;
  std::size_t kept = 0;
  for (int i = 0; i < samples; ++i) {
    const double raw = image.codes[std::size_t(i)], x = 10 + 3 * i;
    noisy.push_back({x, 300 + std::clamp(raw - 700, 0.0, 950.0) * 0.26, 0});
    before += std::pow(raw - profile_at(i), 2) / samples;
    if (!filtered.kept[std::size_t(i)]) continue;
    const double z = filtered.depth[std::size_t(i)];
    after += std::pow(z - profile_at(i), 2), ++kept;
    clean.push_back({x, 20 + std::clamp(z - 700, 0.0, 950.0) * 0.26, 0}), colors.push_back(view_colors[0]);
  }
  sheet.line({{10, 285, 0}, {10.0 + 3 * samples, 285, 0}}, 1, faint);
  sheet.line(noisy, 1.2, ink);
  sheet.line(clean, 1.2, view_colors[0]);
  sheet.save(folder / "figure-2.png");
  std::printf(
      "figure 2: %zu of %d samples with a flipped bit; rms error %.2f codes before, %.2f of the %zu that are kept\n",
      flipped, samples, std::sqrt(before), std::sqrt(after / double(kept)), kept);
}

/// Figure 3: the eight views, lit along their direction of sight.
void views(const Path& folder, const SimulatedScan& scan, const std::vector<RegisterView>& filtered) {
  const int side = scan.views[0].image.width;
  Sheet sheet(4 * side, 2 * side);
  for (std::size_t v = 0; v < filtered.size(); ++v)
    for (std::size_t i = 0; i < filtered[v].cloud.size(); ++i) {
      const PointCloud& cloud = filtered[v].cloud;
      if (cloud.rejected[i] || cloud.normals[i].isZero()) continue;
      const double light = std::max(0.0, -cloud.normals[i].dot(Vec3(-0.3, 0.35, 1).normalized()));
      sheet.pixel(int(v % 4) * side + cloud.pixel[i] % side, int(v / 4) * side + cloud.pixel[i] / side,
                  mixed({40, 48, 64}, {232, 236, 244}, light));
    }
  sheet.save(folder / "figure-3.png");
}

struct Placed {
  Vec3 point;
  std::size_t view;
};

/// Points within `half` of the plane x = at.
std::vector<Placed> section(const std::vector<Placed>& points, double at, double half) {
  std::vector<Placed> result;
  for (const Placed& p : points)
    if (std::abs(p.point.x() - at) < half) result.push_back(p);
  return result;
}

/// y to the right, z up, into a field of the sheet.
void draw_section(const std::vector<Placed>& points, const Box3& bounds, const Vec3& corner, double scale,
                  Sheet& sheet) {
  std::vector<Vec3> places;
  std::vector<Color> colors;
  for (const Placed& p : points) {
    places.push_back(corner + scale * Vec3(p.point.y() - bounds.low.y(), p.point.z() - bounds.low.z(), 0));
    colors.push_back(view_colors[p.view % view_colors.size()]);
  }
  sheet.dots(places, colors);
}

/// Figure 4: one section, of all views and of each. Figure 5: sections along x, each of all views.
void sections(const Path& folder, const std::vector<Placed>& points, const Box3& bounds) {
  const Vec3 size = bounds.size();
  const double pixel = size.x() / 200, width = size.y(), height = size.z();
  {
    const double large = 480 / std::max(width, height), small = 230 / std::max(width, height);
    Sheet sheet(1000, int(large * height + 2 * small * height + 80));
    const auto cut = section(points, bounds.low.x() + 0.3 * size.x(), pixel);
    draw_section(cut, bounds, {500 - 0.5 * large * width, 2 * small * height + 60, 0}, large, sheet);
    for (std::size_t v = 0; v < 8; ++v) {
      std::vector<Placed> one;
      for (const Placed& p : cut)
        if (p.view == v) one.push_back(p);
      draw_section(one, bounds, {10 + 250.0 * double(v % 4), v < 4 ? small * height + 40 : 20, 0}, small, sheet);
    }
    sheet.save(folder / "figure-4.png");
  }
  const double scale = 230 / std::max(width, height);
  Sheet sheet(1000, int(3 * (scale * height + 20)));
  for (int k = 0; k < 12; ++k)
    draw_section(section(points, bounds.low.x() + (k + 0.5) / 12 * size.x(), pixel), bounds,
                 {10 + 250.0 * (k % 4), 10 + (2 - k / 4) * (scale * height + 20), 0}, scale, sheet);
  sheet.save(folder / "figure-5.png");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::printf("usage: bench_figures FOLDER MODEL.json\n"), 2;
  const Path folder = argv[1];
  filtered_profile(folder);

  const auto text = read_file(argv[2]);
  const auto model = text.ok() ? read_model_json(*text, argv[2]) : Result<Model>(text.error());
  if (!model.ok()) return std::printf("%s\n", model.error().message.c_str()), 3;
  Context context;
  SimulateOptions options;
  const Surface surface = surface_of(*model);
  options.views = "cube", options.bits = 12, options.bit_error = 0.015;
  options.pose_noise_angle = 5 * pi / 180, options.pose_noise_shift = 3;
  // Five codes of 12 bits, as `simulate --sigma-codes 5`.
  options.sigma = 5 * simulate(surface, options, context).views[0].image.q;
  SimulatedScan scan = simulate(surface, options, context);
  std::vector<RangeImage> images;
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    images.push_back(scan.views[v].image);
    scan.merged.views[v].file = "view " + std::to_string(v);
  }
  std::vector<RegisterView> filtered = views_to_register(scan.merged, images, context);
  views(folder, scan, filtered);
  for (std::size_t v = 0; v < filtered.size(); ++v) filtered[v].guess = scan.views[v].initial_guess;
  const auto registration = register_views(filtered, {}, context);
  if (!registration.ok()) return std::printf("%s\n", registration.error().message.c_str()), 3;
  const Pose to_part = images[0].world_from_view * registration->views[0].world_from_view.inverse();
  std::vector<Placed> points;
  Box3 bounds;
  double worst = 0;
  for (std::size_t v = 0; v < filtered.size(); ++v) {
    const Pose pose = to_part * registration->views[v].world_from_view;
    const PointCloud& cloud = filtered[v].cloud;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (!cloud.rejected[i]) points.push_back({pose * cloud.points[i], v}), bounds.add(points.back().point);
    const Vec3 middle = surface.bounds.center();
    worst = std::max(worst, (pose * images[v].world_from_view.inverse() * middle - middle).norm());
  }
  sections(folder, points, bounds);
  std::printf(
      "figures 3 to 5: %zu views, the middle of the part is %.3f mm off its true place at most, a pixel is %.3f mm\n",
      filtered.size(), worst, images[0].pitch_x);
}
