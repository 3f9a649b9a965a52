/// How often a true part is refused, and how often damage of twice the tolerance is found, over many seeded scans.
///
///   bench_verdict [RUNS]      default 50 scans per row
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "core/random.h"
#include "scan/simulate.h"
#include "tests/verify/shapes.h"

using namespace partscribe;
using namespace partscribe::testing;

namespace {

/// What is true of the scans of one row.
struct Row {
  const char* name;
  double sigma;        // mm
  double ratio;        // tolerance / smallest honest tolerance
  double outliers;     // share of the pixels
  double mixed;
  double poses;        // mm, every view is moved by so much at random
  bool uneven;         // four in five points of one half are left out
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
  const int runs = argc > 1 ? std::atoi(argv[1]) : 50;
  const Row rows[] = {
      {"ideal, at the smallest honest T", 0.05, 1.0, 0, 0, 0, false},
      {"strays 0.5 %, mixed pixels", 0.05, 1.0, 0.005, 0.3, 0, false},
      {"uneven density, strays", 0.05, 1.0, 0.005, 0.3, 0, true},
      {"views 0.5 sigma apart, strays", 0.05, 1.0, 0.005, 0.3, 0.025, false},
      {"views 2 sigma apart, strays", 0.05, 1.0, 0.005, 0.3, 0.1, false},
      {"T 3 times that, strays 1 %", 0.05, 3.0, 0.01, 0.3, 0, false},
      {"T 5 times that, strays 1 %, uneven", 0.02, 5.0, 0.01, 0.3, 0, true},
  };
  std::printf("%-38s %9s %9s %9s %9s %9s\n", "scans", "honest/s", "verified", "refused", "undecided", "2T found");
  for (const auto& row : rows) {
    int count[4] = {0, 0, 0, 0}, found = 0;
    double honest = 0;
    for (int run = 0; run < runs; ++run) {
      const Scan scan = scan_of(part(0), row, std::uint64_t(run) + 1);
      const VerifyOptions probe{};
      const double least = verdict_on(part(0), scan, probe).smallest_honest_tolerance;
      honest += least / row.sigma / runs;
      VerifyOptions options;
      options.tolerance = row.ratio * least * 1.0001;
      ++count[int(verdict_on(part(0), scan, options).verdict)];
      found += verdict_on(part(2 * options.tolerance), scan, options).verdict == Outcome::out_of_tolerance;
    }
    std::printf("%-38s %9.2f %9d %9d %9d %9d   of %d\n", row.name, honest, count[int(Outcome::verified)],
                count[int(Outcome::out_of_tolerance)], count[int(Outcome::cannot_decide)], found, runs);
    std::fflush(stdout);
  }
}
