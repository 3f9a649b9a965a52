/// How exact fits are beside the Cramer-Rao bound, and how often their stated intervals hold the truth: a table.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fit/trials.h"

using namespace partscribe;

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::string only = argc > 2 ? argv[2] : "";
  const std::vector<std::pair<test::Trouble, const char*>> troubles = {
      {test::Trouble::none, "ideal"},
      {test::Trouble::uneven, "uneven noise"},
      {test::Trouble::outliers, "10 % outliers"},
      {test::Trouble::correlated, "correlated noise"},
      {test::Trouble::poses, "disturbed poses"},
      {test::Trouble::facets, "facets"},
      {test::Trouble::filtered, "filtered"}};
  Context context;
  context.threads = 2;
  std::printf("%d runs each\n\n", runs);
  std::printf("| part | data | rms error / bound (worst) | noise intervals hold | noise sigma / error | all intervals hold (worst) | "
              "sigma / error (worst) |\n|---|---|---|---|---|---|---|\n");
  for (const auto& part : test::trial_parts()) {
    const auto scene = test::scene_of(part, {});
    for (const auto& [trouble, name] : troubles) {
      if (trouble == test::Trouble::facets && part.name == "block") continue;
      if (!only.empty() && only != name && only != part.name) continue;
      const auto s = test::trials(scene, trouble, runs, {}, context);
      std::printf("| %s | %s | %.3f (%.3f) | %.1f %% | %.2f | %.1f %% (%.1f) | %.2f (%.2f) |\n", part.name.c_str(), name,
                  s.efficiency, s.worst_efficiency, 100 * s.noise_coverage, s.noise_ratio, 100 * s.total_coverage,
                  100 * s.worst_coverage, s.total_ratio, s.worst_ratio);
      std::fflush(stdout);
    }
  }
}
