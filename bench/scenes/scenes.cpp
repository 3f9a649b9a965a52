/// The primitives of three simulated parts, as we find them and as CGAL and CloudCompare do.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "core/number.h"
#include "core/statistics.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/normals/normals.h"
#include "geometry/points/kd_tree.h"
#include "parts.h"
#include "peers.h"
#include "scan/simulate/simulate.h"

using namespace bench;

namespace {

const char* usage =
    "usage: bench_scenes [--threads N] [--verbose] [--only NAME] [--write DIR] [--growth [MOST]]\n"
    "  --only NAME  contestants whose name holds this\n"
    "  --write DIR  the scans as PLY files, and nothing else\n"
    "  --growth     scans of the flange from 100,000 points up to MOST (5,000,000): seconds of ours\n";

const char* legend =
    "Three parts with 44 planes, cylinders, cones, spheres and tori, each scanned from 20 sides to about 60,000 "
    "points\n"
    "(orthographic, along the ray), merged without rays; set a: noise 0.02 mm, 0.5 % outliers, mixed pixels one in\n"
    "ten steps; set b: 0.08 mm, 2 %, one in ten.\n"
    "  found: the points of one shape are those of a primitive, over half of both together (IoU > 0.5); kind: of "
    "these\n"
    "  with the right kind; false: shapes that are nothing of the kind; IoU: mean of those found; place: distance\n"
    "  between the surfaces, of the right kind: median of their medians, mm, and over what the best unbiased fit of "
    "all\n"
    "  true points leaves; axis: median, degrees; size: median, % of the radius or tube; seconds: of processor "
    "time\n\n";

struct NoiseSet {
  const char* name;
  double sigma, outliers;
};
constexpr NoiseSet noise_sets[] = {{"a", 0.02, 0.005}, {"b", 0.08, 0.02}};

struct Scene {
  const Part* part;
  Question question;
  std::vector<std::uint32_t> truth;  // face of each point; no_face: lies on none
  std::vector<std::size_t> count;    // points of each face
};

Scene scene_of(const Part& part, const NoiseSet& noise, int resolution, std::uint64_t seed, Context& context) {
  Scene scene{&part, {}, {}, std::vector<std::size_t>(part.truth.faces.size(), 0)};
  partscribe::scan::SimulateOptions options;
  options.views = "dodecahedron";
  options.resolution = resolution;
  options.sigma = noise.sigma, options.outliers = noise.outliers;
  options.mixed = 0.1;
  options.seed = seed;
  auto scan = partscribe::scan::simulate(partscribe::scan::surface_of(part.truth.mesh), options, context);
  Question& question = scene.question;
  question.cloud.points = std::move(scan.merged.cloud.points);
  question.sigma = noise.sigma, question.seed = seed;
  const double reach = 5 * noise.sigma;
  for (const auto& hit : MeshDistance(part.truth.mesh).closest(question.cloud.points, context.threads)) {
    const auto face = hit.distance < reach ? part.truth.face_of[hit.triangle] : no_face;
    scene.truth.push_back(face);
    if (face != no_face) ++scene.count[face];
  }
  std::vector<double> gaps(question.cloud.size());
  KdTree(question.cloud.points).nearest_of_each(2, context.threads, [&](std::uint32_t i, auto near) {
    gaps[i] = std::sqrt(near.back().sq_distance);
  });
  question.spacing = median(std::move(gaps));
  return scene;
}

struct Score {
  double found = 0, kind = 0, none = 0, normals = 0, seconds = 0;  // summed over runs
  std::vector<double> iou, place, over_bound, axis, size;
  int runs = 0;
  std::vector<std::string> words;
};

/// What is still missing from both the points of a shape and those of a face.
void judge_surface(const Scene& scene, std::uint32_t face, const Primitive& found, Score& score) {
  const TrueFace& true_face = scene.part->truth.faces[face];
  const Primitive& truth = true_face.surface;
  std::vector<double> distances, ideal;
  std::vector<Vec3> points;
  for (std::uint32_t i = 0; i < scene.truth.size(); ++i)
    if (scene.truth[i] == face) points.push_back(scene.question.cloud.points[i]);
  PrimitiveFitOptions options;
  options.start = truth, options.robust = 2.5, options.sigma = scene.question.sigma;
  const auto best = fit_primitive(truth.kind, points, {}, options);
  for (const auto t : true_face.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = scene.part->truth.mesh.corner(t, k);
      distances.push_back(std::abs(distance(found, corner)));
      if (best) ideal.push_back(std::abs(distance(best->primitive, corner)));
    }
  const double place = median(std::move(distances));
  score.place.push_back(place);
  if (best) score.over_bound.push_back(place / std::max(median(std::move(ideal)), 1e-6));
  if (truth.kind != PrimitiveKind::sphere)
    score.axis.push_back(
        degrees(std::atan2(truth.axis.cross(found.axis).norm(), std::abs(truth.axis.dot(found.axis)))));
  if (truth.kind == PrimitiveKind::cylinder || truth.kind == PrimitiveKind::sphere)
    score.size.push_back(100 * std::abs(found.radius / truth.radius - 1));
  if (truth.kind == PrimitiveKind::torus) score.size.push_back(100 * std::abs(found.tube / truth.tube - 1));
  if (truth.kind == PrimitiveKind::cone)
    score.size.push_back(100 * std::abs(std::tan(found.half_angle) / std::tan(truth.half_angle) - 1));
}

void judge(const Scene& scene, const Answer& answer, Score& score) {
  ++score.runs;
  score.normals += answer.normals, score.seconds += answer.seconds;
  std::vector<std::uint8_t> met(scene.count.size(), 0);
  for (const FoundShape& shape : answer.shapes) {
    std::vector<std::size_t> common(scene.count.size(), 0);
    for (const auto i : shape.points)
      if (scene.truth[i] != no_face) ++common[scene.truth[i]];
    const auto face = static_cast<std::uint32_t>(std::max_element(common.begin(), common.end()) - common.begin());
    const double both = double(shape.points.size() + scene.count[face] - common[face]);
    const double iou = both > 0 ? double(common[face]) / both : 0;
    const TrueFace& truth = scene.part->truth.faces[face];
    const std::string words = std::string(name_of(shape.kind)) + " of " + std::to_string(shape.points.size()) +
                              " points on a " + name_of(truth.kind) + " of " + std::to_string(scene.count[face]) +
                              ", IoU " + print_number(0.01 * std::round(100 * iou));
    if (iou <= 0.5) {
      ++score.none;
      score.words.push_back("false: " + words);
      continue;
    }
    met[face] = 1;
    ++score.found;
    score.iou.push_back(iou);
    if (shape.kind != truth.kind) {
      score.words.push_back("kind: " + words);
      continue;
    }
    ++score.kind;
    if (shape.surface) judge_surface(scene, face, *shape.surface, score);
  }
  for (std::uint32_t f = 0; f < met.size(); ++f)
    if (!met[f])
      score.words.push_back(std::string("missing: ") + name_of(scene.part->truth.faces[f].kind) + " of " +
                            std::to_string(scene.count[f]) + " points");
}

void print_header() {
  std::printf("%-3s %-24s %6s %6s %6s %6s %8s %8s %8s %7s %8s %8s  %s\n", "set", "", "found", "kind", "false", "IoU",
              "place", "/ bound", "axis", "size", "seconds", "normals", "setting");
}

std::string number(const std::vector<double>& values, const char* format) {
  char text[40] = "-";
  if (!values.empty()) std::snprintf(text, sizeof text, format, median(values));
  return text;
}

void print(const char* set, const Contestant& contestant, const Score& s, double scale) {
  double iou = 0;
  for (const double x : s.iou) iou += x / double(s.iou.size());
  std::printf("%-3s %-24s %6.1f %6.1f %6.1f %6.2f %8s %8s %8s %7s %8.2f %8.2f  %s\n", set, contestant.name.c_str(),
              s.found * scale, s.kind * scale, s.none * scale, iou, number(s.place, "%.4f").c_str(),
              number(s.over_bound, "%.1f").c_str(), number(s.axis, "%.3f").c_str(), number(s.size, "%.2f").c_str(),
              s.seconds * scale, s.normals * scale, contestant.setting.c_str());
  std::fflush(stdout);
}

void growth(const Part& part, std::size_t most, Context& context) {
  std::printf("%10s %8s %8s %8s %8s %8s\n", "points", "normals", "wall", "faces", "wall", "found");
  const auto wall = [] {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  };
  const Scene first = scene_of(part, noise_sets[0], 110, 1, context);
  for (const std::size_t wanted : {100000, 500000, 1000000, 2000000, 5000000}) {
    if (wanted > most) break;
    const int resolution = int(110 * std::sqrt(double(wanted) / double(first.truth.size())));
    Scene scene = scene_of(part, noise_sets[0], resolution, 1, context);
    PointCloud cloud = scene.question.cloud;
    double cpu = processor_seconds(), start = wall();
    estimate_normals(cloud, {}, context);
    const double normals = processor_seconds() - cpu, normals_wall = wall() - start;
    cpu = processor_seconds(), start = wall();
    const Faces faces = faces_of_cloud(cloud, {}, context);
    std::printf("%10zu %8.2f %8.2f %8.2f %8.2f %8zu\n", cloud.size(), normals, normals_wall, processor_seconds() - cpu,
                wall() - start, faces.faces.size());
    std::fflush(stdout);
  }
}

}  // namespace

double bench::processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

Contestant bench::ours() {
  return {"ours", "as it is", 3, [](const Question& question, Context& context) -> std::optional<Answer> {
            Answer answer;
            PointCloud cloud = question.cloud;
            double before = processor_seconds();
            estimate_normals(cloud, {}, context);
            answer.normals = processor_seconds() - before;
            before = processor_seconds();
            const Faces faces = faces_of_cloud(cloud, {}, context);
            answer.seconds = processor_seconds() - before;
            for (const Face& face : faces.faces)
              if (face.kind != FaceKind::free_form) answer.shapes.push_back({face.kind, face.surface(), face.members});
            return answer;
          }};
}

int main(int count, char** arguments) {
  Context context;
  context.threads = 1;
  bool verbose = false;
  std::string only;
  Path folder;
  std::size_t most = 0;
  for (int i = 1; i < count; ++i) {
    const std::string option = arguments[i];
    const bool more = i + 1 < count;
    if (option == "--verbose")
      verbose = true;
    else if (option == "--threads" && more)
      context.threads = std::max(1, std::atoi(arguments[++i]));
    else if (option == "--only" && more)
      only = arguments[++i];
    else if (option == "--write" && more)
      folder = arguments[++i];
    else if (option == "--growth")
      most = more ? static_cast<std::size_t>(parse_number(arguments[++i]).value_or(0)) : 5000000;
    else
      return std::fprintf(stderr, "%s", usage), 2;
  }
  const auto all = parts();
  if (most > 0) return growth(all[0], most, context), 0;
  std::vector<Contestant> contestants = {ours()};
  for (auto& c : cgal()) contestants.push_back(std::move(c));
  for (auto& c : cloudcompare()) contestants.push_back(std::move(c));
  std::erase_if(contestants, [&](const Contestant& c) { return c.name.find(only) == std::string::npos; });
  std::printf("%s", legend);
  print_header();
  for (const NoiseSet& noise : noise_sets) {
    std::vector<Scene> scenes;
    for (const Part& part : all) {
      scenes.push_back(scene_of(part, noise, 110, 1, context));
      const Scene& scene = scenes.back();
      if (!folder.empty()) {
        const Path file = folder / (part.name + "_" + noise.name + ".ply");
        if (const auto done = write_file(file, write_cloud_ply(scene.question.cloud)); !done)
          return std::fprintf(stderr, "%s\n", done.error().message.c_str()), 1;
      }
      if (verbose)
        std::printf(
            "    %s %s: %zu faces, %zu points, %.3f mm apart, %.1f %% on none\n", noise.name, part.name.c_str(),
            part.truth.faces.size(), scene.truth.size(), scene.question.spacing,
            100.0 * double(std::count(scene.truth.begin(), scene.truth.end(), no_face)) / double(scene.truth.size()));
    }
    if (!folder.empty()) continue;
    for (const Contestant& contestant : contestants) {
      Score score;
      bool there = true;
      for (int run = 0; run < contestant.runs && there; ++run)
        for (Scene& scene : scenes) {
          scene.question.seed = static_cast<std::uint64_t>(run) + 1;
          const auto answer = contestant.answer(scene.question, context);
          there = answer.has_value();
          if (!there) break;
          judge(scene, *answer, score);
        }
      if (there)
        print(noise.name, contestant, score, 1.0 / contestant.runs);
      else
        std::printf("%-3s %-24s is not installed: not run\n", noise.name, contestant.name.c_str());
      if (verbose)
        for (const auto& words : score.words) std::printf("      %s\n", words.c_str());
    }
  }
}
