/// How often a true part is refused, and how often a face off by 1.25 to 2 times the tolerance is found, over many
/// seeded scans, some of which are damaged too; prints the table of the manual, and on standard error why a true part
/// was not verified.
///
///   bench_verdict [RUNS [ROW [EVERY]]]   default 50 scans in each row; ROW counts from 1, 0 for all; EVERY: which
///   scans
///                                        are damaged too, 5 for every fifth
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>

#include "core/random.h"
#include "scan/simulate/simulate.h"
#include "testing/meshes.h"
#include "verify/compare/source.h"

using namespace partscribe::scan;
using namespace partscribe::verify;
using namespace partscribe::testing;

namespace {

/// What is true of the scans of one row.
struct Row {
  const char* name;
  double sigma;     // mm
  double ratio;     // tolerance / smallest honest tolerance
  double outliers;  // share of the pixels
  double mixed;
  double poses;  // mm, every view is moved by so much at random
  bool uneven;   // four in five points of one half are left out
};

TriangleMesh part(double raise) {
  return turned({{0, 0}, {9, 0}, {9, 4}, {5, 4}, {5, 10 + raise}, {2, 10 + raise}, {2, 6}, {0, 6}}, 128);
}

Scan scan_of(const TriangleMesh& mesh, const Row& row, std::uint64_t seed) {
  SimulateOptions options;
  options.views = "icosahedron";
  options.resolution = 64;
  options.sigma = row.sigma;
  options.mixed = row.mixed;
  options.outliers = row.outliers;
  options.bit_error = 0.001;
  options.seed = seed;
  Context context;
  context.threads = 2;
  Scan scan = simulate(surface_of(mesh), options, context).merged;
  Random random(seed);
  std::vector<Vec3> shift;
  for (std::size_t v = 0; v < scan.views.size(); ++v)
    shift.push_back(row.poses * Vec3(random.normal(), random.normal(), random.normal()) / std::sqrt(3.0));
  PointCloud kept;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vec3 p = scan.cloud.points[i] + shift[std::size_t(scan.cloud.view[i])];
    if (row.uneven && p.x() > 0 && random.uniform() < 0.8) continue;
    kept.points.push_back(p), kept.rays.push_back(scan.cloud.rays[i]), kept.view.push_back(scan.cloud.view[i]);
  }
  scan.cloud = std::move(kept);
  return scan;
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 50, only = argc > 2 ? std::atoi(argv[2]) : 0;
  const Row rows[] = {
      {"ideal, at the smallest honest T", 0.05, 1.0, 0, 0, 0, false},
      {"outliers 0.5 %, mixed pixels", 0.05, 1.0, 0.005, 0.3, 0, false},
      {"uneven density, outliers", 0.05, 1.0, 0.005, 0.3, 0, true},
      {"views 0.5 sigma apart, outliers", 0.05, 1.0, 0.005, 0.3, 0.025, false},
      {"views 2 sigma apart, outliers", 0.05, 1.0, 0.005, 0.3, 0.1, false},
      {"T 3 times that, outliers 1 %", 0.05, 3.0, 0.01, 0.3, 0, false},
      {"T 5 times that, outliers 1 %, uneven", 0.02, 5.0, 0.01, 0.3, 0, true},
  };
  constexpr double raised_by[] = {1.25, 1.5, 2};  // T
  // A refusal takes longer than a pass, since it is explained.
  const int damaged_every = argc > 3 ? std::max(1, std::atoi(argv[3])) : 5;
  std::printf("| scans | smallest honest T / sigma | verified | refused | undecided |");
  for (const double by : raised_by) std::printf(" off by %g T: refused |", by);
  std::printf("\n|---|---|---|---|---|---|---|---|\n");
  Context context;
  for (const auto& row : rows) {
    if (only > 0 && &row != &rows[only - 1]) continue;
    int count[4] = {0, 0, 0, 0}, found[std::size(raised_by)] = {};
    int damaged = 0;
    double honest = 0;
    for (int run = 0; run < runs; ++run) {
      const Scan scan = scan_of(part(0), row, std::uint64_t(run) + 1);
      const double least = smallest_honest_tolerance(prepare_source(scan, context));
      honest += least / row.sigma / runs;
      VerifyOptions options;
      options.tolerance = row.ratio * least * 1.0001;
      const Verdict verdict = verdict_on(part(0), scan, options);
      ++count[int(verdict.verdict)];
      if (verdict.verdict != Outcome::verified)
        std::fprintf(stderr, "%s, scan %d: %s\n", row.name, run + 1, all_reasons(verdict).c_str());
      if (run % damaged_every != 0) continue;
      ++damaged;
      for (std::size_t i = 0; i < std::size(raised_by); ++i)
        found[i] +=
            verdict_on(part(raised_by[i] * options.tolerance), scan, options).verdict == Outcome::out_of_tolerance;
    }
    std::printf("| %s | %.2f | %d | %d | %d |", row.name, honest, count[int(Outcome::verified)],
                count[int(Outcome::out_of_tolerance)], count[int(Outcome::cannot_decide)]);
    for (const int n : found) std::printf(" %d of %d |", n, damaged);
    std::printf("\n");
    std::fflush(stdout);
  }
}
