/// Normals beside other programs on views with known truth: Markdown tables, `bench_normals [--clouds|--images]
/// MODEL.json...`.
#include "geometry/normals/normals.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>

#include "bench/normals/peers.h"
#include "bench/normals/plane_normal.h"
#include "core/files.h"
#include "core/large_memory.h"
#include "core/statistics.h"
#include "geometry/images/grid_normals.h"
#include "geometry/images/rlts_filter.h"
#include "geometry/points/kd_tree.h"
#include "model/json.h"
#include "scan/simulate/simulate.h"

using namespace partscribe::scan;

namespace {

/// One view of a part.
struct Scene {
  RangeImage image;
  std::vector<Vec3> grid, truth;   // of every pixel, in the sensor's frame; not finite: no return
  std::vector<std::uint8_t> edge;  // a pixel within two columns and rows has another normal, depth or nothing
  std::vector<Vec3> points;        // of the returns, row by row
  std::vector<std::uint32_t> pixel;
};

Scene scene_of(const Model& model, int resolution, double sigma, double bit_error) {
  const Vec3 none = Vec3::Constant(std::nan(""));
  const Surface surface = surface_of(model);
  SimulateOptions options;
  options.views = "1", options.resolution = resolution, options.sigma = sigma, options.bit_error = bit_error;
  Context context;
  Scene scene;
  scene.image = simulate(surface, options, context).views.front().image;
  const RangeImage& image = scene.image;
  const Pose view_from_world = image.world_from_view.inverse();
  std::vector<double> depth;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const auto p = view_point(image, row, column);
      scene.grid.push_back(p.value_or(none)), scene.truth.push_back(none), depth.push_back(std::nan(""));
      const Vec3 from =
          image.world_from_view * Vec3(image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, 0);
      const auto hit = surface.first_hit(from, image.world_from_view.rotation.col(2));
      if (hit) scene.truth.back() = view_from_world.rotation * hit->normal, depth.back() = hit->distance;
      if (!p || !hit) continue;
      scene.points.push_back(*p), scene.pixel.push_back(std::uint32_t(scene.grid.size() - 1));
    }
  scene.edge.assign(scene.grid.size(), 0);
  for (const std::uint32_t i : scene.pixel)
    for (int y = -2; y <= 2; ++y)
      for (int x = -2; x <= 2; ++x) {
        const int row = int(i) / image.width + y, column = int(i) % image.width + x;
        const bool inside = row >= 0 && column >= 0 && row < image.height && column < image.width;
        const std::size_t j = std::size_t(row * image.width + column);
        if (!inside || std::isnan(depth[j]) || scene.truth[i].dot(scene.truth[j]) < 0.9 ||
            std::abs(scene.truth[i].dot(Vec3(x * image.pitch_x, y * image.pitch_y, depth[j] - depth[i]))) >
                0.5 * image.pitch_x)
          scene.edge[i] = 1;
      }
  return scene;
}

struct Score {
  double us = 0, megabytes = 0;           // a point of processor time, beside the input
  double median = 0, near = 0, none = 0;  // deg; shares within ten degrees and without a normal
  double inside_rms = 0;                  // deg, away from edges, of those within ten degrees
};

double status_kb(const char* name) {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(name)) return std::stod(line.substr(std::strlen(name)));
  return 0;
}

/// In whatever form a method gives them; what it takes to compare them is not its time.
struct Normals {
  Normals(std::vector<Vec3> some) : all(std::move(some)) {}
  Normals(LargeVector<Eigen::Vector3f> some) : single(std::move(some)) {}

  /// Of the places truth speaks of: those in the list, or all in order.
  std::vector<Vec3> at(const std::vector<std::uint32_t>& places, std::size_t count) {
    for (const Eigen::Vector3f& n : single) all.push_back(n.cast<double>());
    if (places.size() != all.size()) return std::move(all);
    std::vector<Vec3> result(count, Vec3::Zero());
    for (std::size_t k = 0; k < places.size(); ++k) result[places[k]] = all[k];
    return result;
  }
  std::vector<Vec3> all;
  LargeVector<Eigen::Vector3f> single;
};
using Run = std::function<Normals()>;

/// Touches as much as a method may need and gives it back. The host of a virtual machine finds memory first, which
/// takes up to forty times as long as to clear it: that is no method's time.
void find_memory(std::size_t bytes) { const LargeVector<char> memory(bytes, 1); }

/// In a process of its own, so that every memory peak is its own.
Score measure(const Run& run, const std::vector<std::uint32_t>& places, const std::vector<Vec3>& truth,
              const std::vector<std::uint8_t>& edge, std::size_t points) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  malloc_trim(0);
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    find_memory((std::size_t(32) << 20) + 600 * points);
    std::ofstream("/proc/self/clear_refs") << "5";
    const double before = status_kb("VmRSS:");
    const std::clock_t start = std::clock();
    Normals found = run();
    Score s;
    s.us = 1e6 * double(std::clock() - start) / CLOCKS_PER_SEC / double(points);
    s.megabytes = (status_kb("VmHWM:") - before) / 1024;
    const std::vector<Vec3> normals = found.at(places, truth.size());
    std::vector<double> off;
    double square = 0;
    std::size_t inside = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!truth[i].allFinite()) continue;
      const bool known = normals[i].allFinite() && normals[i].norm() > 0.5;
      off.push_back(known ? std::acos(std::min(std::abs(normals[i].normalized().dot(truth[i])), 1.0)) * 180 /
                                3.14159265358979
                          : 90);
      s.none += !known, s.near += off.back() < 10;
      if (!edge[i] && off.back() < 10) square += off.back() * off.back(), ++inside;
    }
    const double n = double(off.size());
    s.none /= n, s.near /= n, s.median = median(off),
                              s.inside_rms = std::sqrt(square / double(std::max<std::size_t>(inside, 1)));
    const bool sent = write(ends[1], &s, sizeof s) == ssize_t(sizeof s);
    _exit(sent ? 0 : 1);
  }
  Score s;
  const bool got = read(ends[0], &s, sizeof s) == ssize_t(sizeof s);
  close(ends[0]), close(ends[1]);
  int status = 0;
  waitpid(child, &status, 0);
  return got ? s : Score{};
}

struct Method {
  std::string name;
  Run run;
};

/// All methods in turn and back again; medians of the times.
std::vector<Score> measure_all(const std::vector<Method>& methods, int rounds, const std::vector<std::uint32_t>& places,
                               const std::vector<Vec3>& truth, const std::vector<std::uint8_t>& edge,
                               std::size_t points) {
  std::vector<Score> scores(methods.size());
  std::vector<std::vector<double>> times(methods.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < methods.size(); ++k) {
      const std::size_t m = round % 2 ? methods.size() - 1 - k : k;
      scores[m] = measure(methods[m].run, places, truth, edge, points);
      times[m].push_back(scores[m].us);
    }
  for (std::size_t m = 0; m < methods.size(); ++m) scores[m].us = median(times[m]);
  return scores;
}

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  const KdTree tree(points);
  std::vector<Vec3> result(points.size());
  tree.nearest_of_each(std::size_t(count), 1, [&](std::uint32_t i, std::span<const Neighbour> near) {
    result[i] =
        peers::plane_normal(near.size(), [&](std::size_t k) -> Vec3 { return points[near[k].index] - points[i]; });
  });
  return result;
}

/// With support chosen from the noise, reweighted, and outliers marked.
std::vector<Vec3> robust(const std::vector<Vec3>& points) {
  PointCloud cloud;
  cloud.points = points;
  Context context;
  estimate_normals(cloud, {}, context);
  return cloud.normals;
}

/// The slopes that the range image filter gives with the depths.
std::vector<Vec3> of_filter(const RangeImage& image) {
  Context context;
  const FilteredImage f = rlts_filter(image, {}, context);
  std::vector<Vec3> result(f.depth.size());
  for (std::size_t i = 0; i < result.size(); ++i)
    if (f.kept[i])
      result[i] = Vec3(f.slope_column[i] / image.pitch_x, f.slope_row[i] / image.pitch_y, -1).normalized();
    else
      result[i] = Vec3::Zero();
  return result;
}

void print(const std::string& name, const Score& s) {
  std::printf("| %s | %.3f | %.0f | %.3f | %.3f | %.1f %% | %.1f %% |\n", name.c_str(), s.us, s.megabytes, s.median,
              s.inside_rms, 100 * s.near, 100 * s.none);
  std::fflush(stdout);
}

constexpr const char* head =
    "| method | us a point | MB | median deg | rms inside | within 10 deg | none |\n|---|---|---|---|---|---|---|\n";

/// Returns of the first view at this resolution, by one at a low one.
int resolution_for(const Model& model, double points) {
  return int(std::lround(100 * std::sqrt(points / double(scene_of(model, 100, 0, 0).points.size()))));
}

void clouds(const Model& model, const std::string& name) {
  std::vector<std::pair<std::string, double>> first;  // us of the smallest
  for (const double size : {1e4, 1e5, 1e6}) {
    const Scene scene = scene_of(model, resolution_for(model, size), 0.01, 0);
    std::vector<Vec3> truth;
    std::vector<std::uint8_t> edge;
    for (const std::uint32_t i : scene.pixel) truth.push_back(scene.truth[i]), edge.push_back(scene.edge[i]);
    for (const int count : {10, 20}) {
      if (count == 20 && size > 5e5) continue;
      std::vector<Method> methods = {{"Partscribe, equal support", [&, count] { return planes(scene.points, count); }}};
      for (const auto& list : {peers::nanoflann_methods(), peers::small_gicp_methods(), peers::open3d_methods(),
                               peers::pcl_methods(), peers::cgal_methods()}) {
        for (const auto& m : list)
          methods.push_back({m.name, [&, m, count] { return m.normals(scene.points, count); }});
      }
      if (count == 10)
        methods.push_back({"Partscribe, support from noise and edges", [&] { return robust(scene.points); }});
      std::printf("\n**%s, %zu points, pitch %.4f mm, sigma 0.01 mm, %d neighbours**\n\n%s", name.c_str(),
                  scene.points.size(), scene.image.pitch_x, count, head);
      const auto scores = measure_all(methods,
                                      size > 5e5    ? 3
                                      : count == 10 ? 7
                                                    : 3,
                                      {}, truth, edge, scene.points.size());
      for (std::size_t m = 0; m < methods.size(); ++m) print(methods[m].name, scores[m]);
    }
  }
}

void images(const Model& model, const std::string& name) {
  for (const double sigma : {0.01, 0.2}) {
    const Scene scene = scene_of(model, 480, sigma, 0.001);
    std::vector<Vec3> truth(scene.grid.size(), Vec3::Constant(std::nan("")));
    for (const std::uint32_t i : scene.pixel) truth[i] = scene.truth[i];
    // A plane through 5x5 pixels of pitch h has the slope error sigma / (7.07 h).
    std::printf(
        "\n**%s, organised, %zu points, pitch %.3f mm, sigma %g mm, bit errors 0.001; a plane through 5x5: %.3f deg at "
        "normal incidence**\n\n%s",
        name.c_str(), scene.points.size(), scene.image.pitch_x, sigma,
        std::sqrt(2.0) * sigma / (7.07 * scene.image.pitch_x) * 180 / 3.14159265358979, head);
    std::vector<Method> methods = {{"Partscribe, with the range image filter", [&] { return of_filter(scene.image); }}};
    methods.push_back({"Partscribe, planes through 5x5", [&] { return grid_normals(scene.image, {}, 1); }});
    methods.push_back({"Partscribe, cloud, support from noise and edges", [&] { return robust(scene.points); }});
    for (const auto& m : peers::pcl_grid_methods())
      methods.push_back({m.name, [&, m] { return m.normals(scene.grid, scene.image.width, scene.image.height); }});
    for (const auto& m : {peers::nanoflann_methods().front()})
      methods.push_back({m.name + ", 25 neighbours", [&, m] { return m.normals(scene.points, 25); }});
    const auto scores = measure_all(methods, 7, scene.pixel, truth, scene.edge, scene.points.size());
    for (std::size_t m = 0; m < methods.size(); ++m) print(methods[m].name, scores[m]);
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Read when a library is loaded, which is before main.
  if (!std::getenv("OMP_NUM_THREADS")) setenv("OMP_NUM_THREADS", "1", 1), execv("/proc/self/exe", argv);
  bool some = false, only_clouds = false, only_images = false;
  for (int k = 1; k < argc; ++k) {
    only_clouds |= !std::strcmp(argv[k], "--clouds"), only_images |= !std::strcmp(argv[k], "--images");
    if (argv[k][0] == '-') continue;
    const auto text = read_file(argv[k]);
    const auto model = text.ok() ? read_model_json(*text, argv[k]) : Result<Model>(text.error());
    if (!model.ok()) return std::printf("%s\n", model.error().message.c_str()), 3;
    const std::string name = model->name.empty() ? argv[k] : model->name;
    if (!only_images) clouds(*model, name);
    if (!only_clouds) images(*model, name);
    some = true;
  }
  if (!some) return std::printf("usage: bench_normals [--clouds|--images] MODEL.json...\n"), 2;
}
