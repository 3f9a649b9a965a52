// Fits of single primitives beside Ceres, PCL, CGAL and GeometricTools: time, exactness, basin, and distance from the
// Cramer-Rao bound. `bench_primitives [trials]`; processor time throughout, all contestants in this one run.
#include "testing/primitives.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/number.h"
#include "core/statistics.h"
#include "peers.h"

namespace {

using namespace partscribe::geometry;
namespace scenes = partscribe::testing::primitives;
using scenes::kinds;

double seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Ours: without sigma, with the same start as everybody.
peers::Fit prepare_ours(const peers::Question& question) {
  const PrimitiveKind kind = question.kind;
  const std::vector<Vec3>& points = question.points;
  PrimitiveFitOptions options;
  options.start = question.start;
  return [&points, kind, options]() -> std::optional<Primitive> {
    const auto fit = fit_primitive(kind, points, {}, options);
    if (!fit) return {};
    return fit->primitive;
  };
}

std::vector<peers::Peer> contestants() {
  return {{"ours", prepare_ours},       {"Ceres", peers::ceres_fits()}, {"PCL", peers::pcl_fits()},
          {"CGAL", peers::cgal_fits()}, {"GTE", peers::gte_fits()},     {"GTE min.", peers::gte_minimizer_fits()}};
}

void print_cell(double value, const char* format) {
  char text[32];
  if (std::isnan(value))
    std::snprintf(text, sizeof text, "-");
  else
    std::snprintf(text, sizeof text, format, value);
  std::printf("%12s", text);
}

/// Median of repeated fits, contestants taking turns forwards and backwards.
void print_times(const std::vector<peers::Peer>& all, std::size_t count) {
  std::printf("\nProcessor ms at %zu points, start 0.1 rad and 10 %% off (ratio to ours)\n", count);
  Random random(1);
  for (const PrimitiveKind kind : kinds) {
    const Primitive truth = scenes::example(kind, 100, random);
    const std::vector<Vec3> points = scenes::scan(truth, count, 2 * pi, 0.02, random).points;
    const Primitive start = scenes::start(truth, 0.1, 0.1, random);
    std::vector<peers::Fit> fits;
    for (const peers::Peer& peer : all)
      fits.push_back(peer.prepare ? peer.prepare({kind, points, start}) : peers::Fit{});
    std::vector<std::vector<double>> times(all.size());
    for (int round = 0; round < 8; ++round)
      for (std::size_t k = 0; k < fits.size(); ++k) {
        const std::size_t i = round % 2 ? fits.size() - 1 - k : k;
        if (!fits[i]) continue;
        // Slow ones are timed three times; short fits are repeated to be longer than the clock's step.
        if (times[i].size() >= 3 && times[i].back() > 0.3) continue;
        const int repeat = times[i].empty() || times[i].back() > 0.02 ? 1 : 10;
        const double begin = seconds();
        for (int r = 0; r < repeat; ++r) fits[i]();
        const double each = (seconds() - begin) / repeat;
        if (round == 0)
          times[i] = {each};  // warm-up, replaced below
        else if (round == 1)
          times[i] = {each};
        else
          times[i].push_back(each);
      }
    std::printf("%-10s", name_of(kind));
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!fits[i])
        print_cell(NAN, "");
      else if (i == 0)
        print_cell(1e3 * median(times[i]), "%.3f");
      else {
        char text[48];
        std::snprintf(text, sizeof text, "%.4g (%.3g)", 1e3 * median(times[i]), median(times[i]) / median(times[0]));
        std::printf("%18s", text);
        continue;
      }
      if (i > 0) std::printf("      ");
    }
    std::printf("\n");
  }
}

/// Distance from exact points to what was fitted to them, near and far from the origin.
void print_exactness(const std::vector<peers::Peer>& all) {
  for (const double offset : {100.0, 1e5}) {
    std::printf("\nError of the number (radius, angle, tube, offset) on exact points %g mm from the origin\n", offset);
    Random random(2);
    for (const PrimitiveKind kind : kinds) {
      const Primitive truth = scenes::example(kind, offset, random);
      const std::vector<Vec3> points = scenes::scan(truth, 2000, 2 * pi, 0, random).points;
      const Primitive start = scenes::start(truth, 0.1, 0.1, random);
      std::printf("%-10s", name_of(kind));
      for (const peers::Peer& peer : all) {
        const peers::Fit fit = peer.prepare ? peer.prepare({kind, points, start}) : peers::Fit{};
        const auto found = fit ? fit() : std::nullopt;
        print_cell(found ? std::abs(scenes::number(*found, truth) - scenes::number(truth, truth)) : NAN, "%.1e");
      }
      std::printf("\n");
    }
  }
}

/// How many of 60 starts end at the noise.
void print_basin(const std::vector<peers::Peer>& all) {
  for (const auto& [angle, share] : {std::pair{0.6, 0.3}, std::pair{1.0, 0.5}}) {
    std::printf("\nOf 60 starts %g rad and %g %% off, found\n", angle, 100 * share);
    for (const PrimitiveKind kind : kinds) {
      std::printf("%-10s", name_of(kind));
      for (const peers::Peer& peer : all) {
        Random random(3);
        int found = 0;
        bool any = false;
        for (int trial = 0; trial < 60 && peer.prepare; ++trial) {
          const Primitive truth = scenes::example(kind, 100, random);
          const std::vector<Vec3> points = scenes::scan(truth, 500, 2 * pi, 0.02, random).points;
          const peers::Fit fit = peer.prepare({kind, points, scenes::start(truth, angle, share, random)});
          if (!fit) break;
          any = true;
          const auto p = fit();
          found += p && scenes::rms(*p, points) < 1.3 * scenes::rms(truth, points);
        }
        print_cell(any ? found : NAN, "%.0f");
      }
      std::printf("\n");
    }
  }
}

/// Root mean square error over the bound, and how often our 95 % intervals hold the truth.
void print_statistics(const std::vector<peers::Peer>& all, int trials) {
  for (const double arc : {2 * pi, pi / 3}) {
    std::printf(
        "\nRms error over Cramer-Rao bound, 500 points, sigma 0.02, %.0f degrees of arc; %d trials of ours, %d of "
        "others\n",
        degrees(arc), trials, trials / 10);
    for (const PrimitiveKind kind : kinds) {
      if (arc < 6 && (kind == PrimitiveKind::plane || kind == PrimitiveKind::line)) continue;
      std::printf("%-10s", name_of(kind));
      int covered = 0;
      double typical = 0;
      for (std::size_t i = 0; i < all.size(); ++i) {
        Random random(4);
        double sum = 0;
        bool any = false;
        const int own = i == 0 ? trials : trials / 10;
        for (int trial = 0; trial < own && all[i].prepare; ++trial) {
          const Primitive truth = scenes::example(kind, 100, random);
          Random same = random;
          const std::vector<Vec3> exact = scenes::scan(truth, 500, arc, 0, same).points;
          const std::vector<Vec3> points = scenes::scan(truth, 500, arc, 0.02, random).points;
          const Primitive start = scenes::start(truth, 0.1, 0.1, random);
          const double limit = scenes::bound(truth, exact, 0.02), value = scenes::number(truth, truth);
          double error = 0;
          if (i == 0) {
            PrimitiveFitOptions options;
            options.start = start;
            const auto fit = fit_primitive(kind, points, {}, options);
            error = scenes::number(fit->primitive, truth) - value;
            covered += std::abs(error) < 1.95996 * scenes::number_sigma(*fit);
            typical += limit / own;
          } else {
            const peers::Fit fit = all[i].prepare({kind, points, start});
            const auto p = fit ? fit() : std::nullopt;
            if (!p) break;
            error = scenes::number(*p, truth) - value;
          }
          any = true;
          sum += error * error / (limit * limit);
        }
        print_cell(any ? std::sqrt(sum / own) : NAN, "%.3f");
      }
      std::printf("   bound %.2e, ours covers %.2f %%\n", typical, 100.0 * covered / trials);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 2000;
  const std::vector<peers::Peer> all = contestants();
  std::printf("%-10s", "");
  for (const peers::Peer& peer : all) std::printf("%12s", peer.prepare ? peer.name : "not inst.");
  std::printf("\n");
  print_times(all, 100000);
  print_exactness(all);
  print_basin(all);
  print_statistics(all, trials);
}
