// CloudCompare's plug-in qRANSAC_SD (Schnabel's original program), by its command line.
#include <sys/resource.h>

#include <array>
#include <cstdlib>
#include <map>

#include "core/number.h"
#include "core/process.h"
#include "geometry/io/read_geometry.h"
#include "peers.h"

namespace bench {
namespace {

double seconds_of_children() {
  rusage usage;
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Processor seconds that CloudCompare takes with these arguments.
double run(const Path& folder, const std::vector<std::string>& arguments, Context& context) {
  // The platform is asked for by a variable, and programs are started with hardly any.
  std::vector<std::string> all = {"/usr/bin/env",
                                  "QT_QPA_PLATFORM=offscreen",
                                  "HOME=" + folder.string(),
                                  "CloudCompare",
                                  "-SILENT",
                                  "-AUTO_SAVE",
                                  "OFF",
                                  "-NO_TIMESTAMP",
                                  "-C_EXPORT_FMT",
                                  "PLY",
                                  "-PLY_EXPORT_FMT",
                                  "BINARY_LE"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const double before = seconds_of_children();
  (void)run_process(all, {}, context, folder);
  return seconds_of_children() - before;
}

using Place = std::array<float, 3>;
Place place(const Vec3& p) { return {float(p.x()), float(p.y()), float(p.z())}; }

std::optional<FaceKind> kind_of(const std::string& file) {
  for (const auto& [word, kind] : std::vector<std::pair<std::string, FaceKind>>{{"_PLANE_", FaceKind::plane},
                                                                                {"_CYLINDER_", FaceKind::cylinder},
                                                                                {"_CONE_", FaceKind::cone},
                                                                                {"_SPHERE_", FaceKind::sphere},
                                                                                {"_TORUS_", FaceKind::torus}})
    if (file.find(word) != std::string::npos) return kind;
  return std::nullopt;
}

struct Setting {
  double epsilon;  // sigmas; the program takes points within three times as much
  double normal;   // degrees
  int least;
  bool by_octree;  // normals by CloudCompare's own command, else by the plug-in
};

std::optional<Answer> ask(const Setting& setting, const Question& question, Context& context) {
  if (find_program("CloudCompare").empty()) return std::nullopt;
  const Path folder = std::filesystem::temp_directory_path() / ("bench_scenes_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "shapes");
  PointCloud bare;
  std::map<Place, std::uint32_t> index;
  for (const Vec3& p : question.cloud.points) {
    const Place there = place(p);
    index.emplace(there, static_cast<std::uint32_t>(bare.size()));
    bare.points.push_back({there[0], there[1], there[2]});
  }
  if (!write_file(folder / "scan.ply", write_cloud_ply(bare))) return std::nullopt;
  Answer answer;
  const std::vector<std::string> open = {"-O", "scan.ply"};
  const double opening = run(folder, open, context);
  auto arguments = open;
  if (setting.by_octree) {
    arguments.insert(arguments.end(), {"-OCTREE_NORMALS", print_number(3 * question.spacing)});
    answer.normals = run(folder, arguments, context) - opening;
  }
  arguments.insert(arguments.end(), {"-RANSAC", "EPSILON_ABSOLUTE", print_number(setting.epsilon * question.sigma),
                                     "BITMAP_EPSILON_ABSOLUTE", print_number(4 * question.spacing), "SUPPORT_POINTS",
                                     std::to_string(setting.least), "MAX_NORMAL_DEV", print_number(setting.normal),
                                     "PROBABILITY", "0.01", "ENABLE_PRIMITIVE", "PLANE", "SPHERE", "CYLINDER", "CONE",
                                     "TORUS", "OUT_CLOUD_DIR", (folder / "shapes").string()});
  answer.seconds = run(folder, arguments, context) - opening - answer.normals;
  std::vector<Path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder / "shapes")) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const auto kind = kind_of(file.filename().string());
    const auto cloud = read_geometry(file, context);
    if (!kind || !cloud) continue;
    FoundShape found;
    found.kind = *kind;
    for (const Vec3& p : cloud->cloud.points)
      if (const auto at = index.find(place(p)); at != index.end()) found.points.push_back(at->second);
    answer.shapes.push_back(std::move(found));
  }
  std::filesystem::remove_all(folder);
  return answer;
}

}  // namespace

std::vector<Contestant> cloudcompare() {
  std::vector<Contestant> all;
  for (const Setting& setting :
       {Setting{1.5, 25, 200, false}, {2, 25, 100, false}, {2, 15, 100, false}, {2, 25, 100, true}})
    all.push_back({"CloudCompare qRANSAC_SD",
                   "within " + print_number(3 * setting.epsilon) + " sigmas and " + print_number(setting.normal) +
                       " degrees, " + std::to_string(setting.least) + " points, normals by " +
                       (setting.by_octree ? "-OCTREE_NORMALS" : "the plug-in"),
                   3, [setting](const Question& q, Context& context) { return ask(setting, q, context); }});
  return all;
}

}  // namespace bench
