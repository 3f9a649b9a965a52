/// Range image filters beside each other on images with known truth: Markdown tables.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>

#include "bench/filter/peers.h"
#include "bench/filter/scenes.h"
#include "core/random.h"
#include "core/statistics.h"
#include "geometry/images/region_growing.h"
#include "geometry/images/rlts_filter.h"

using namespace partscribe::scan;
using namespace partscribe::filter_bench;

namespace {

Filtered rlts(const RangeImage& image, RltsForm form) {
  Context context;
  const FilteredImage f = rlts_filter(image, {.form = form}, context);
  Filtered out = raw(image);
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    if (!out.kept[i]) continue;
    if (image.projection == Projection::pinhole)
      out.points[i] *= f.depth[i] / out.points[i].z();
    else
      out.points[i].z() = f.depth[i];
    out.kept[i] = f.kept[i];
  }
  return out;
}

struct Score {
  double interior = 0, edge = 0;  // rms of error / sigma
  double left = 0;                // share of kept points off by more than 5 sigma
  double kept = 0;                // share of good points
};

Score score(const Scene& scene, const Filtered& f) {
  Score s;
  std::size_t inside = 0, beside = 0, good = 0, good_kept = 0, kept = 0, left = 0;
  const bool pinhole = scene.image.projection == Projection::pinhole;
  const Filtered before = raw(scene.image);
  for (std::size_t i = 0; i < f.points.size(); ++i) {
    const Truth& t = scene.truth[i];
    if (!before.kept[i] || std::isnan(t.depth)) continue;
    const bool is_good = std::abs(before.points[i].z() - t.depth) <= 4 * t.sigma + scene.image.q;
    good += is_good, good_kept += is_good && f.kept[i];
    if (!f.kept[i]) continue;
    double expected = t.depth;
    const Vec3& p = f.points[i];
    if (!pinhole && (p - before.points[i]).head<2>().norm() > 1e-9) expected = scene.depth_at(p.x(), p.y());
    if (std::isnan(expected)) expected = t.depth;  // moved past the end of the part
    const double error = (p.z() - expected) / t.sigma;
    ++kept, left += std::abs(error) > 5;
    if (t.edge)
      ++beside, s.edge += error * error;
    else
      ++inside, s.interior += error * error;
  }
  s.interior = std::sqrt(s.interior / static_cast<double>(std::max<std::size_t>(inside, 1)));
  s.edge = std::sqrt(s.edge / static_cast<double>(std::max<std::size_t>(beside, 1)));
  s.left = static_cast<double>(left) / static_cast<double>(std::max<std::size_t>(kept, 1));
  s.kept = static_cast<double>(good_kept) / static_cast<double>(std::max<std::size_t>(good, 1));
  return s;
}

struct Method {
  const char* name;
  std::function<Filtered(const RangeImage&, double sigma)> run;
  bool slow = false;  ///< once only
};

double milliseconds(const Method& method, const RangeImage& image, double sigma) {
  double best = 1e300;
  for (int k = 0; k < (method.slow ? 1 : 5); ++k) {
    const std::clock_t start = std::clock();
    const Filtered f = method.run(image, sigma);
    best = std::min(best, 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return best;
}

/// 240 rows of 320.
RangeImage wide(RangeImage image) {
  RangeImage out = image;
  out.width = 320, out.height = 240;
  out.codes.clear();
  const int left = (image.width - 320) / 2, top = (image.height - 240) / 2;
  for (int r = 0; r < 240; ++r)
    for (int c = 0; c < 320; ++c)
      out.codes.push_back(image.codes[static_cast<std::size_t>((r + top) * image.width + c + left)]);
  out.x0 += left * image.pitch_x, out.y0 += top * image.pitch_y;
  out.cx -= left, out.cy -= top;
  return out;
}

/// Share of flips found, bit by bit, counted from a scan with and the same scan without them.
void bit_table(const SceneOptions& options) {
  SceneOptions clean = options;
  clean.bit_error = 0;
  const Scene with = scene_of(options), without = scene_of(clean);
  Context context;
  const FilteredImage f = rlts_filter(with.image, {}, context);
  std::array<int, 16> flips{}, found{};
  for (std::size_t i = 0; i < f.kept.size(); ++i) {
    const int change = with.image.codes[i] ^ without.image.codes[i];
    for (std::size_t b = 0; b < 16; ++b)
      if (change == 1 << b) ++flips[b], found[b] += f.model[i] == RltsModel::rejected;
  }
  std::printf(
      "\nBit errors of 5 %%, %d bits, sigma %g mm, %.4g mm per code\n\n| bit | flips | found | expected | named by the "
      "filter "
      "|\n|---|---|---|---|---|\n",
      options.bits, options.sigma, with.image.q);
  for (int b = 0; b < options.bits; ++b) {
    const auto k = static_cast<std::size_t>(b);
    double expected = 0;
    for (std::size_t i = 0; i < f.model.size(); ++i)
      if (f.model[i] != RltsModel::none) expected += detectable_share(b, with.image.q, with.truth[i].sigma);
    std::printf("| %d | %d | %.0f %% | %.0f %% | %zu |\n", b, flips[k], 100.0 * found[k] / std::max(flips[k], 1),
                100 * expected / static_cast<double>(std::max<std::size_t>(f.returns, 1)), f.bit_errors[k]);
  }
}

/// Figure 2 of the paper: profiles of 12 bits, noise of 5 codes, bit errors of 0.015; rms error of all samples.
void profile_table() {
  constexpr int width = 600, height = 100;
  const auto truth = [](int x) {
    if (x < 200) return 2000 + 500 * std::sin(x * 0.0314159265);
    if (x < 400) return x < 300 ? 1500.0 : 2500.0;
    return 1500.0 + 8 * (100 - std::abs(x - 500));
  };
  RangeImage image;
  image.width = width, image.height = height;
  Random random(7);
  for (int i = 0; i < width * height; ++i) {
    int code = std::clamp(static_cast<int>(std::lround(1 + truth(i % width) + 5 * random.normal())), 1, 4095);
    if (random.uniform() < 0.015) code ^= 1 << random.below(12);
    image.codes.push_back(static_cast<std::uint16_t>(code));
  }
  Context context;
  const FilteredImage rlts = rlts_filter(image, {.form = RltsForm::profile}, context);
  const auto five = [&](int i, bool median) {  // samples of the row
    std::array<double, 5> z{};
    for (int k = 0; k < 5; ++k) z[static_cast<std::size_t>(k)] = image.codes[static_cast<std::size_t>(i + k - 2)] - 1.0;
    std::sort(z.begin(), z.end());
    return median ? z[2] : (z[0] + z[1] + z[2] + z[3] + z[4]) / 5;
  };
  std::printf("\n| figure 2, codes | smooth | step | roof |\n|---|---|---|---|\n");
  for (const char* name : {"raw", "mean of 5", "median of 5", "RLTS profile"}) {
    std::printf("| %s |", name);
    for (int part = 0; part < 3; ++part) {
      double sum = 0;
      for (int r = 0; r < height; ++r)
        for (int x = 200 * part + 2; x < 200 * part + 198; ++x) {
          const int i = r * width + x;
          const double value = *name == 'R'   ? rlts.depth[static_cast<std::size_t>(i)]
                               : *name == 'r' ? image.codes[static_cast<std::size_t>(i)] - 1.0
                                              : five(i, name[2] == 'd');
          sum += (value - truth(x)) * (value - truth(x));
        }
      std::printf(" %.2f |", std::sqrt(sum / (196.0 * height)));
    }
    std::printf("\n");
  }
}

/// Normals and flatness beside the truth.
void surface_table(const std::vector<SceneOptions>& scenes) {
  std::printf(
      "\n| scene | sigma | graph, characterize: us per point | normals: median | 95 %% | below 10 degrees | "
      "patches, along a row, a column | patches: us per point |\n|---|---|---|---|---|---|---|---|\n");
  for (const SceneOptions& options : scenes) {
    const Scene scene = scene_of(options);
    Context context;
    const FilteredImage f = rlts_filter(scene.image, {}, context);
    const std::clock_t start = std::clock();
    const SurfaceGraph graph = surface_graph(scene.image, f, {});
    const std::vector<CharacterizedPoint> points = characterize(graph, {}, context);
    const std::clock_t middle = std::clock();
    const Patches patches = grow_patches(graph, points, {}, context);
    const std::clock_t end = std::clock();
    std::vector<double> angles;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].kind != SurfaceClass::unknown && !std::isnan(scene.truth[i].depth))
        angles.push_back(std::acos(std::clamp(points[i].normal.dot(scene.truth[i].normal), -1.0, 1.0)) * 57.29577951);
    const auto us = [&](std::clock_t ticks) {
      return 1e6 * static_cast<double>(ticks) / CLOCKS_PER_SEC / static_cast<double>(f.returns);
    };
    const auto near = std::count_if(angles.begin(), angles.end(), [](double a) { return a < 10; });
    const PatchCounts most = most_patches(patches.label, scene.image.width, scene.image.height);
    std::printf("| %s | %g | %.1f | %.2f deg | %.2f deg | %.1f %% | %zu, %d, %d | %.1f |\n", options.part.c_str(),
                options.sigma, us(middle - start), quantile(angles, 0.5), quantile(angles, 0.95),
                100.0 * static_cast<double>(near) / static_cast<double>(angles.size()), patches.patches.size(),
                most.along_row, most.along_column, us(end - middle));
  }
}

/// What is left of errors, in units of their own sigma.
std::string pulls_of(std::vector<double> pulls) {
  double square = 0;
  std::size_t beyond = 0;
  for (const double u : pulls) square += u * u, beyond += u > 4;
  const double n = static_cast<double>(pulls.size());
  char text[80];
  std::snprintf(text, sizeof text, "%.2f | %.3f %% | %.2f", std::sqrt(square / n),
                100 * static_cast<double>(beyond) / n, quantile(std::move(pulls), 0.999));
  return text;
}

/// Is sigma true? By the noise of the samples, and with what hides in that.
void sigma_table(const std::vector<SceneOptions>& scenes) {
  std::printf(
      "\n| scene | bits, sigma | by noise: rms | beyond 4 | 99.9 %% | in all: rms | beyond 4 | 99.9 %% "
      "|\n|---|---|---|---|---|---|---|---|\n");
  for (const SceneOptions& options : scenes) {
    const Scene scene = scene_of(options);
    Context context;
    const FilteredImage f = rlts_filter(scene.image, {}, context);
    std::vector<double> by_noise, in_all;
    for (std::size_t i = 0; i < f.depth.size(); ++i) {
      if (!f.kept[i] || std::isnan(scene.truth[i].depth)) continue;
      const double off = std::abs(f.depth[i] - scene.truth[i].depth);
      by_noise.push_back(off / f.sigma[i]), in_all.push_back(off / std::hypot(f.sigma[i], f.doubt[i]));
    }
    std::printf("| %s%s | %d, %g | %s | %s |\n", options.part.c_str(),
                options.projection == Projection::pinhole ? " behind a pinhole"
                : options.mixed > 0                       ? ", mixed pixels"
                                                          : "",
                options.bits, options.sigma, pulls_of(std::move(by_noise)).c_str(),
                pulls_of(std::move(in_all)).c_str());
  }
}

}  // namespace

/// `bench_filter [METHOD]`: only the methods whose names begin so.
int main(int argc, char** argv) {
  profile_table();
  std::vector<Method> methods = {{"raw", [](const RangeImage& i, double) { return raw(i); }}};
  for (const Peer& peer : pcl_filters()) methods.push_back({peer.name, peer.run});
  if (methods.size() == 1) methods.push_back({"PCL: not run", {}});
  const std::vector<Method> ours = {
      {"RLTS combined", [](const RangeImage& i, double) { return rlts(i, RltsForm::combined); }},
      {"RLTS profile", [](const RangeImage& i, double) { return rlts(i, RltsForm::profile); }},
      {"RLTS facet 5x5", [](const RangeImage& i, double) { return rlts(i, RltsForm::facet); }, true},
      {"RLTS quadric 5x5", [](const RangeImage& i, double) { return rlts(i, RltsForm::quadric); }, true}};
  methods.insert(methods.end(), ours.begin(), ours.end());
  if (argc > 1) std::erase_if(methods, [&](const Method& m) { return !std::string(m.name).starts_with(argv[1]); });
  std::vector<SceneOptions> scenes;
  for (const char* part : {"bracket", "dome"}) {
    for (const auto& [bits, sigma] : {std::pair{12, 0.2}, std::pair{16, 0.01}})
      scenes.push_back({.part = part, .bits = bits, .sigma = sigma});
  }
  scenes.push_back({.part = "bracket", .bits = 16, .sigma = 0.05, .mixed = 0.3, .outliers = 0.003});
  scenes.push_back({.part = "bracket", .bits = 16, .sigma = 0.01, .projection = Projection::pinhole});
  for (SceneOptions options : scenes) {
    const Scene scene = scene_of(options);
    options.resolution = 320;
    const RangeImage large = wide(scene_of(options).image);
    const bool pinhole = options.projection == Projection::pinhole;
    std::printf("\n%s, %s, %d bits, sigma %g mm, bit errors %g, mixed pixels %g, outliers %g\n\n", options.part.c_str(),
                pinhole ? "pinhole" : "orthographic", options.bits, options.sigma, options.bit_error, options.mixed,
                options.outliers);
    std::printf(
        "| method | interior / sigma | edge / sigma | off by > 5 sigma | kept | ms | 320x240 images/s |\n"
        "|---|---|---|---|---|---|---|\n");
    for (const Method& method : methods) {
      if (!method.run) {
        std::printf("| %s | | | | | | |\n", method.name);
        continue;
      }
      const Score s = score(scene, method.run(scene.image, options.sigma));
      const double ms = milliseconds(method, scene.image, options.sigma);
      const double rate = 1000 / std::max(milliseconds(method, large, options.sigma), 1e-3);
      std::printf("| %s | %.3f | %.3f | %.3f %% | %.2f %% | %.1f | %.1f |\n", method.name, s.interior, s.edge,
                  100 * s.left, 100 * s.kept, ms, rate);
      std::fflush(stdout);
    }
  }
  sigma_table(scenes);
  surface_table({scenes.begin(), scenes.begin() + 4});
  bit_table({.resolution = 320, .bits = 12, .sigma = 0.2, .bit_error = 0.05});
  bit_table({.resolution = 320, .bits = 16, .sigma = 0.01, .bit_error = 0.05});
}
