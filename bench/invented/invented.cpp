/// How often material that no scan shows is refused, and true parts with hidden bores are not, with and without rays;
/// prints the table of the manual, and on standard error what came out wrong.
///
///   bench_invented [PART [true|invented|half [MIXED]]]   default: all eleven parts, all three, a tenth of the edge
///   pixels mixed
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "bench/invented/csg.h"
#include "bench/invented/parts.h"
#include "core/random.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"
#include "scan/simulate/simulate.h"
#include "testing/meshes.h"
#include "verify/compare/samples.h"
#include "verify/evaluate/solid.h"

using namespace partscribe::scan;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

constexpr double tolerance = 0.2;
constexpr int places = 10;
double mixed = 0.1;  // share of the pixels at edges

Scan scan_of(const TriangleMesh& mesh, const std::string& views, bool pinhole, std::uint64_t seed) {
  SimulateOptions options;
  options.views = views;
  options.resolution = 160;
  options.sigma = 0.04;
  options.mixed = mixed;
  options.outliers = 0.001;
  options.bit_error = 0.0005;
  options.projection = pinhole ? Projection::pinhole : Projection::orthographic;
  options.seed = seed;
  Context context;
  context.threads = 2;
  return simulate(surface_of(mesh), options, context).merged;
}

/// The same points, merged: nobody knows who saw them, nor from where.
Scan without_rays(const Scan& scan) {
  Scan merged;
  merged.cloud.points = scan.cloud.points;
  merged.views.push_back({});
  return merged;
}

/// The views for which `take` holds.
template <class Take>
Scan some_views(const Scan& scan, Take take) {
  Scan result = scan;
  result.cloud = {};
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const auto v = std::size_t(scan.cloud.view[i]);
    if (!take(scan.views[v], v)) continue;
    result.cloud.points.push_back(scan.cloud.points[i]);
    result.cloud.rays.push_back(scan.cloud.rays[i]);
    result.cloud.view.push_back(scan.cloud.view[i]);
  }
  return result;
}

struct Invention {
  std::string kind;
  double thickness = 0;  // mm
  TriangleMesh mesh;     // with the part
  double area = 0;       // mm^2, of surface that the part lacks
  Vec3 place = Vec3::Zero();
};

/// At least two views see a fifth of what is invented at less than 60 degrees.
bool in_plain_view(Invention& invention, const TriangleMesh& part, const Scan& scan) {
  const MeshDistance truth(part), surface(invention.mesh);
  const auto normals = triangle_normals(invention.mesh);
  const double size = invention.mesh.bounds().diagonal();
  std::vector<SurfaceSample> invented;
  const auto samples = even_samples(invention.mesh, 30000);
  for (const auto& s : samples)
    if (truth.closest(s.point).distance > tolerance) invented.push_back(s);
  invention.area = area(invention.mesh) * double(invented.size()) / double(samples.size());
  int views = 0;
  for (const auto& view : scan.views) {
    std::size_t seen = 0;
    for (const auto& s : invented) {
      const Vec3 to = view.world_from_view.translation - s.point;
      seen += normals[s.triangle].dot(to.normalized()) > 0.5 &&
              !surface.first_hit(s.point + 1e-6 * size * normals[s.triangle], to.normalized(), to.norm());
    }
    views += seen * 5 >= invented.size();
  }
  return !invented.empty() && views >= 2;
}

Invention invented_on(const TriangleMesh& part, const Scan& scan, int number, Random& random) {
  static const char* kinds[] = {"fin", "lug", "pin", "sheet"};
  static const double thicknesses[] = {0.2, 0.3, 0.5, 0.8, 1.2, 2, 3, 4, 5};
  const auto samples = even_samples(part, 5000);
  while (true) {
    const auto& s = samples[random.below(samples.size())];
    const Vec3 n = triangle_normal(part, s.triangle);
    Invention result;
    result.kind = kinds[number % 4], result.thickness = thicknesses[random.below(9)], result.place = s.point;
    const Vec3 lean =
        (n + 0.35 * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1))).normalized();
    const Mat3 turn =
        rotation_onto_axis(result.kind == "sheet" ? lean : n) * rotation_of(random.uniform(0, 2 * pi) * Vec3::UnitZ());
    const double height = random.uniform(4, 10), width = random.uniform(8, 25), t = result.thickness;
    const Vec3 middle = s.point + (0.5 * height - 0.6) * (turn * Vec3::UnitZ());
    if (result.kind == "fin")
      result.mesh = block({width, t, height + 1.2}, {turn, middle});
    else if (result.kind == "lug")
      result.mesh =
          block({3 + 0.3 * width, std::max(t, 2.0), 0.6 * height + 1.2}, {turn, s.point + (0.3 * height - 0.6) * n});
    else if (result.kind == "pin")
      result.mesh = rod(s.point - 0.6 * n, lean, height + 0.6, 0.5 * t, 24);
    else {  // a leaning fin
      const Mat3 leaning = turn * rotation_of(random.uniform(0.5, 1.1) * Vec3::UnitX());
      result.mesh =
          block({width, t, 1.5 * height}, {leaning, s.point + (0.75 * height - 1) * (leaning * Vec3::UnitZ())});
    }
    const auto with_part = united_if_possible(part, result.mesh);
    if (!with_part || !check_solid(*with_part).faults.empty()) continue;
    result.mesh = *with_part;
    if (in_plain_view(result, part, scan)) return result;
  }
}

struct Tally {
  int right = 0, tried = 0;
};
std::map<std::string, Tally> tallies;  // by row of the table

void judge(const std::string& row, const std::string& what, const TriangleMesh& mesh, const Scan& scan,
           Outcome expected) {
  VerifyOptions options;
  options.tolerance = tolerance;
  Tally& tally = tallies[row];
  ++tally.tried;
  const Verdict verdict = verdict_on(mesh, scan, options);
  const auto& m = verdict.artifacts.front().model_to_data;
  tally.right += verdict.verdict == expected;
  std::fprintf(stderr, "%s %s, %s: %s (%.1f supported, %.1f not scanned, %.1f contradicted)\n",
               verdict.verdict == expected ? "  " : "!!", row.c_str(), what.c_str(), name_of(verdict.verdict),
               m.supported, m.not_scanned, m.contradicted);
  if (verdict.verdict != expected) std::fprintf(stderr, "%s", all_reasons(verdict).c_str());
}

void judge_both(const std::string& row, const std::string& what, const TriangleMesh& mesh, const Scan& scan,
                Outcome expected) {
  judge(row + ", with rays", what, mesh, scan, expected);
  judge(row + ", without rays", what, mesh, without_rays(scan), expected);
}

void true_parts(const NamedPart& part) {
  for (const std::string views : {"octahedron", "6", "cube", "icosahedron", "14"})
    judge_both("true parts from 6 to 14 views", part.name + " from " + views, part.mesh,
               scan_of(part.mesh, views, views != "octahedron" && views != "cube", 3), Outcome::verified);
}

void invented(const NamedPart& part, std::uint64_t number) {
  static const char* sets[] = {"octahedron", "cube", "10", "icosahedron", "14"};
  const Scan scan = scan_of(part.mesh, sets[number % 5], number % 2 == 0, 5);
  Random random(number + 1);
  for (int k = 0; k < places; ++k) {
    const Invention i = invented_on(part.mesh, scan, k, random);
    const std::string what = part.name + " " + sets[number % 5] + " with a " + i.kind + " " +
                             print_number(i.thickness) + " thick, " + print_number(std::round(i.area)) + " mm^2 at (" +
                             print_number(std::round(i.place.x())) + ", " + print_number(std::round(i.place.y())) +
                             ", " + print_number(std::round(i.place.z())) + ")";
    judge_both("invented " + i.kind, what, i.mesh, scan, Outcome::out_of_tolerance);
  }
}

void halves(const NamedPart& part) {
  const Scan scan = scan_of(part.mesh, "14", true, 7);
  for (const std::size_t v : {0u, 6u})
    judge_both("true parts from one view", part.name + " view " + std::to_string(v), part.mesh,
               some_views(scan, [&](const View&, std::size_t w) { return v == w; }), Outcome::verified);
  const Vec3 middle = part.mesh.bounds().center();
  for (int side = 0; side < 6; ++side)
    judge_both("true parts from one half space", part.name + " side " + std::to_string(side), part.mesh,
               some_views(scan,
                          [&](const View& view, std::size_t) {
                            return (side % 2 ? -1 : 1) * (view.world_from_view.translation - middle)[side / 2] > 0;
                          }),
               Outcome::verified);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string only = argc > 1 ? argv[1] : "", what = argc > 2 ? argv[2] : "";
  if (argc > 3) mixed = std::atof(argv[3]);
  const auto parts = parts_with_bores();
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!only.empty() && only != "all" && parts[p].name != only) continue;
    if (what.empty() || what == "true") true_parts(parts[p]);
    if (what.empty() || what == "invented") invented(parts[p], p);
    if (what.empty() || what == "half") halves(parts[p]);
  }
  std::printf("| scans | right | tried |\n|---|---|---|\n");
  for (const auto& [row, tally] : tallies) std::printf("| %s | %d | %d |\n", row.c_str(), tally.right, tally.tried);
}
