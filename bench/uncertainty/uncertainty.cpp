/// How exact fits are beside the Cramer-Rao bound, and how often their stated intervals hold the truth: a table.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fit/trials.h"

using namespace partscribe;

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const std::string only = argc > 2 ? argv[2] : "";
  struct Row {
    const char* name;
    test::Trouble trouble;
    test::TrialOptions options;
    int share = 1;  ///< of the runs
  };
  // Filters work on pixels far smaller than what they must not flatten, so these scenes have finer ones.
  test::TrialOptions usual, fine, few, many, dense, unknown;
  fine.views = 5, fine.resolution = 64;
  few.views = 6, many.views = 14, many.resolution = 32;
  dense.views = 10, dense.resolution = 150;
  unknown.rays = false;
  const std::vector<Row> rows = {{"ideal", test::Trouble::none, usual},
                                 {"ideal, 50,000 points", test::Trouble::none, dense, 5},
                                 {"uneven noise", test::Trouble::uneven, usual},
                                 {"10 % outliers", test::Trouble::outliers, usual},
                                 {"correlated noise", test::Trouble::correlated, fine},
                                 {"disturbed poses", test::Trouble::poses, usual},
                                 {"disturbed poses, 6 views", test::Trouble::poses, few},
                                 {"disturbed poses, 14 views", test::Trouble::poses, many},
                                 {"disturbed poses, views unknown", test::Trouble::poses, unknown},
                                 {"facets", test::Trouble::facets, usual},
                                 {"filtered", test::Trouble::filtered, fine}};
  Context context;
  context.threads = 2;
  std::printf("%d runs each\n\n", runs);
  std::printf("| part | data | rms error / bound (worst) | independent | noise intervals hold | noise sigma / error | "
              "all intervals hold (worst) | sigma / error (worst) |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& part : test::trial_parts()) {
    for (const auto& row : rows) {
      if (row.trouble == test::Trouble::facets && part.name == "block") continue;  // flat faces have none
      if (!only.empty() && only != row.name && only != part.name) continue;
      const auto s = test::trials(test::scene_of(part, row.options), row.trouble, std::max(runs / row.share, 1), {}, context);
      std::printf("| %s | %s | %.2f (%.2f) | %.0f %% | %.1f %% | %.2f | %.1f %% (%.1f) | %.2f (%.2f) |\n", part.name.c_str(),
                  row.name, s.efficiency, s.worst_efficiency, 100 * s.effective_share, 100 * s.noise_coverage,
                  s.noise_ratio, 100 * s.total_coverage, 100 * s.worst_coverage, s.total_ratio, s.worst_ratio);
      std::fflush(stdout);
    }
  }
}
