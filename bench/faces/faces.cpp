/// How well the faces of meshes and scans are found, against the faces that CAD files state.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "core/number.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/normals/normals.h"
#include "scan/read/read.h"
#include "score.h"

using namespace bench;

namespace {

const char* usage =
    "usage: bench_faces [--scan | --rays | --check] [--deflection MM] [--threads N] [--verbose] CASE_DIR...\n"
    "  A case is a folder with nominal.step, which is meshed, or nominal.stl, of which faces are only counted.\n"
    "  --scan      scan/merged.ply instead, points without rays; --rays: the views of scan/scan.json with their rays\n"
    "  --deflection MM  of the mesh; 1/2000 of the diagonal unless given\n"
    "  --check     the faces of the file itself as answer, then the same with radii off by 0.4 % and planes turned by\n"
    "              0.4 degrees: all, then none must be right\n";

const char* legend =
    "Faces over 0.5 % of the area, of the CAD file:\n"
    "  found: a face of its kind and surface covers half of it or more (of meshes: radius within 0.2 %, axis and half\n"
    "  angle within 0.2 degrees); kind, off: most of what covers it is another kind, or its kind but not its surface;\n"
    "  missing: more than half of it belongs to no face; inside out, split: of those found; area: that bears its face\n"
    "of those reported with a closed form:\n"
    "  false: most of its area is no such face; alike: a free form of the file follows it within 1/20000 of the\n"
    "  diagonal (scans 1/5000); vague: called free form where the file has a closed form; free: free forms found so\n"
    "radii, offsets, axes: within three of the sigmas stated; seconds: of processor time\n\n";

enum class Input { mesh, points, rays, file };

struct Options {
  Input input = Input::mesh;
  double deflection = 0;
  bool verbose = false, spoil = false;
  Context context;
};

double processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// The answer that is right, or spoilt.
Faces faces_of_file(const Truth& truth, bool spoil) {
  Faces answer;
  answer.of_mesh = true;
  answer.face_of = truth.face_of;
  for (const TrueFace& t : truth.faces) {
    Face face;
    face.kind = t.kind, face.hollow = t.hollow, face.area = t.area, face.members = t.triangles;
    face.fit.primitive = t.surface;
    Primitive& p = face.fit.primitive;
    if (spoil && t.kind == FaceKind::plane)
      p.axis = rotation_of(radians(0.4) * rotation_onto_axis(p.axis).col(0)) * p.axis;
    if (spoil) p.radius *= 1.004;
    answer.faces.push_back(face);
  }
  return answer;
}

std::string ratio(int part, int all) { return std::to_string(part) + "/" + std::to_string(all); }

bool of_scan(const Options& options) { return options.input == Input::points || options.input == Input::rays; }

/// One row of the table; its header where there is no score.
void print_row(const std::string& name, const Score* s, const Options& options) {
  const auto column = [](const char* title, const std::string& value) {
    std::printf(" %*s", static_cast<int>(std::strlen(title)), value.empty() ? title : value.c_str());
  };
  const auto count = [&](const char* title, int Score::*value) { column(title, s ? std::to_string(s->*value) : ""); };
  const auto number = [&](const char* title, double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.2f", value);
    column(title, s ? text : "");
  };
  std::printf("%-20s", s ? name.c_str() : "case");
  count("faces", &Score::truth);
  if (of_scan(options)) count("unseen", &Score::unseen);
  count("found", &Score::found);
  count("kind", &Score::wrong_kind);
  count(" off", &Score::off);
  count("missing", &Score::missing);
  count("inside out", &Score::inside_out);
  count("split", &Score::split);
  number("area, %", s && s->area > 0 ? 100 * s->right_area / s->area : 0);
  count("reported", &Score::reported);
  count("false", &Score::none);
  count("alike", &Score::alike);
  count("vague", &Score::vague);
  column(" free", s ? ratio(s->free_found, s->free) : "");
  if (of_scan(options)) {
    column("  radii", s ? ratio(s->radii.inside, s->radii.all) : "");
    column("offsets", s ? ratio(s->offsets.inside, s->offsets.all) : "");
    column("   axes", s ? ratio(s->axes.inside, s->axes.all) : "");
  }
  number("seconds", s ? s->seconds : 0);
  std::printf("\n");
}

std::string counts_of(const auto& faces, double least_area) {
  std::string text;
  for (int k = 0; k <= static_cast<int>(FaceKind::free_form); ++k) {
    int all = 0, large = 0;
    for (const auto& f : faces)
      if (static_cast<int>(f.kind) == k) ++all, large += f.area >= least_area;
    if (all > 0)
      text += " " + std::to_string(all) + " " + name_of(static_cast<FaceKind>(k)) + " (" + std::to_string(large) + ")";
  }
  return text;
}

/// The points of the case's scan; empty if there is none.
Result<PointCloud> read_points(const Path& folder, Options& options) {
  if (options.input == Input::points) {
    auto raw = read_geometry(folder / "scan/merged.ply", options.context);
    if (!raw) return raw.error();
    return std::move(raw->cloud);
  }
  auto scan = partscribe::scan::read_scan({folder / "scan/scan.json"}, {}, options.context);
  if (!scan) return scan.error();
  return std::move(scan->cloud);
}

/// A mesh or scan without truth: only what is said of it.
Result<Score> count_only(const Path& folder, Options& options) {
  const std::string name = folder.filename().string();
  auto raw = read_geometry(folder / "nominal.stl", options.context);
  if (!raw) return raw.error();
  const TriangleMesh mesh = welded(raw->mesh, 0);
  Faces faces;
  const double before = processor_seconds();
  if (options.input == Input::mesh) {
    faces = faces_of_mesh(mesh, {}, options.context);
  } else {
    auto cloud = read_points(folder, options);
    if (!cloud) return cloud.error();
    estimate_normals(*cloud, {}, options.context);
    faces = faces_of_cloud(*cloud, {}, options.context);
  }
  std::printf("%-20s no faces are stated; reported (over 0.5 %% of the area):%s, %.2f s\n", name.c_str(),
              counts_of(faces.faces, 0.005 * area(mesh)).c_str(), processor_seconds() - before);
  return Score{};
}

Result<Score> measure(const Path& folder, Options& options) {
  if (!std::filesystem::exists(folder / "nominal.step") && std::filesystem::exists(folder / "nominal.stl") &&
      options.input != Input::file)
    return count_only(folder, options);
  if (!std::filesystem::exists(folder / "nominal.step")) return bad_input("holds no nominal.step: left out");
  auto truth = read_truth(folder / "nominal.step", options.deflection);
  if (!truth) return truth.error();
  const double diagonal = truth->mesh.bounds().diagonal();
  ScoreOptions rules;
  rules.place = diagonal / 5000;
  rules.alike = diagonal / 20000;
  std::vector<Place> places;
  Faces faces;
  double before = processor_seconds();
  if (options.input == Input::mesh || options.input == Input::file) {
    faces = options.input == Input::file ? faces_of_file(*truth, options.spoil)
                                         : faces_of_mesh(truth->mesh, {}, options.context);
    for (std::uint32_t i = 0; i < truth->mesh.triangles.size(); ++i) {
      const Vec3 a = truth->mesh.corner(i, 0);
      places.push_back({i, 0.5 * (truth->mesh.corner(i, 1) - a).cross(truth->mesh.corner(i, 2) - a).norm()});
    }
  } else {
    auto cloud = read_points(folder, options);
    if (!cloud) return cloud.error();
    before = processor_seconds();
    const double sigma = estimate_normals(*cloud, {}, options.context).sigma;
    faces = faces_of_cloud(*cloud, {}, options.context);
    rules.of_scan = true;
    rules.place = std::max(diagonal / 1000, sigma);
    rules.alike = std::max(diagonal / 5000, sigma);
    // Bit errors and mixed pixels lie on no face.
    const double reach = std::max(8 * sigma, diagonal / 500);
    const auto hits = MeshDistance(truth->mesh).closest(cloud->points, options.context.threads);
    for (const auto& hit : hits) places.push_back({hit.distance < reach ? hit.triangle : no_triangle, 1});
  }
  const double seconds = processor_seconds() - before;
  ensure(faces.face_of.size() == places.size(), "every triangle or point is said to be of a face or of none");
  Score result = score(*truth, places, faces, rules);
  result.seconds = seconds;
  print_row(folder.filename().string(), &result, options);
  if (options.verbose) {
    std::printf("  the file:%s; mesh of %zu triangles within %.4f mm\n  the answer:%s; noise %.4f mm\n",
                counts_of(truth->faces, 0.005 * truth->area).c_str(), truth->mesh.triangles.size(), truth->error,
                counts_of(faces.faces, 0.005 * truth->area).c_str(), faces.noise);
    for (const auto& w : result.words) std::printf("  %s\n", w.c_str());
  }
  std::fflush(stdout);
  return result;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  options.context.threads = 2;
  std::vector<Path> cases;
  for (int i = 1; i < count; ++i) {
    const std::string option = arguments[i];
    if (option == "--scan")
      options.input = Input::points;
    else if (option == "--rays")
      options.input = Input::rays;
    else if (option == "--check")
      options.input = Input::file;
    else if (option == "--verbose")
      options.verbose = true;
    else if (option == "--deflection" && i + 1 < count)
      options.deflection = parse_number(arguments[++i]).value_or(0);
    else if (option == "--threads" && i + 1 < count)
      options.context.threads = std::max(1, std::atoi(arguments[++i]));
    else if (option.starts_with("--"))
      return std::fprintf(stderr, "%s", usage), 2;
    else
      cases.push_back(std::filesystem::path(option + "/").parent_path());
  }
  if (cases.empty()) return std::fprintf(stderr, "%s", usage), 2;
  std::printf("%s", legend);
  print_row("", nullptr, options);
  for (const bool spoil : {false, true}) {
    if (spoil && options.input != Input::file) break;
    options.spoil = spoil;
    Score total;
    for (const auto& folder : cases) {
      const auto result = measure(folder, options);
      if (!result)
        std::printf("%-20s %s\n", folder.filename().c_str(), result.error().message.c_str());
      else
        total += *result;
    }
    print_row("all", &total, options);
    const auto percent = [](int part, int all) { return all > 0 ? 100.0 * part / all : 0; };
    std::printf("found %.1f %%, false %.1f %% of those reported\n", percent(total.found, total.truth),
                percent(total.none, total.reported));
  }
}
