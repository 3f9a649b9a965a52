/// How exact fits are beside the Cramer-Rao bound, and how often their stated intervals hold the truth: a table.
/// bench_uncertainty [RUNS [WORD ...]]: rows and parts of such names; `numbers` lists every number of the parts.
#include <cstdio>
#include <cstdlib>
#include <set>

#include "testing/trials.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const auto parts = trial_parts();
  std::set<std::string> rows_asked, parts_asked;
  bool numbers = false;
  for (int k = 2; k < argc; ++k) {
    const std::string word = argv[k];
    const bool part = std::ranges::any_of(parts, [&](const auto& p) { return p.name == word; });
    if (word == "numbers")
      numbers = true;
    else
      (part ? parts_asked : rows_asked).insert(word);
  }
  struct Row {
    const char* name;
    Trouble trouble;
    TrialOptions options;
    int share = 1;  ///< of the runs
  };
  // Filters work on pixels far smaller than what they must not flatten, so these scenes have finer ones.
  TrialOptions usual, fine, few, many, dense, unknown, wide, sharp, blunt;
  fine.views = 5, fine.resolution = 64;
  wide = sharp = blunt = fine;
  wide.filter = 2, wide.resolution = 128;
  sharp.step = 0.75, blunt.step = 100;
  few.views = 6, many.views = 14, many.resolution = 32;
  dense.views = 10, dense.resolution = 150;
  unknown.rays = false;
  const std::vector<Row> rows = {{"ideal", Trouble::none, usual},
                                 {"ideal, 50,000 points", Trouble::none, dense, 5},
                                 {"uneven noise", Trouble::uneven, usual},
                                 {"10 % outliers", Trouble::outliers, usual},
                                 {"correlated noise", Trouble::correlated, fine},
                                 {"disturbed poses", Trouble::poses, usual},
                                 {"disturbed poses, 6 views", Trouble::poses, few},
                                 {"disturbed poses, 14 views", Trouble::poses, many},
                                 {"disturbed poses, views unknown", Trouble::poses, unknown},
                                 {"facets", Trouble::facets, usual},
                                 {"filtered", Trouble::filtered, fine},
                                 {"filtered, 5 x 5 of finer", Trouble::filtered, wide, 4},
                                 {"filtered, small steps kept", Trouble::filtered, sharp, 4},
                                 {"filtered, no steps kept", Trouble::filtered, blunt, 4}};
  Context context;
  context.threads = 2;
  std::printf("%d runs each\n\n", runs);
  std::printf(
      "| part | data | rms error / bound (worst) | independent | noise intervals hold | noise sigma / error | "
      "all intervals hold (worst) | sigma / error (worst) |\n|---|---|---|---|---|---|---|---|\n");
  const auto asked = [](const std::set<std::string>& names, const std::string& name) {
    return names.empty() || names.count(name) > 0;
  };
  for (const auto& part : parts) {
    for (const auto& row : rows) {
      if (row.trouble == Trouble::facets && part.name == "block") continue;  // flat faces have none
      if (!asked(rows_asked, row.name) || !asked(parts_asked, part.name)) continue;
      const auto s = trials(scene_of(part, row.options), row.trouble, std::max(runs / row.share, 1), {}, context);
      std::printf("| %s | %s | %.2f (%.2f) | %.0f %% | %.1f %% | %.2f | %.1f %% (%.1f) | %.2f (%.2f) |\n",
                  part.name.c_str(), row.name, s.efficiency, s.worst_efficiency, 100 * s.effective_share,
                  100 * s.noise_coverage, s.noise_ratio, 100 * s.total_coverage, 100 * s.worst_coverage, s.total_ratio,
                  s.worst_ratio);
      for (const auto& n : s.numbers)
        if (numbers)
          std::printf(
              "    %-14s bias %8.5f  error %8.5f  noise sigma %8.5f  sigma %8.5f  holds %5.1f %%  sigma / error %.2f\n",
              n.name.c_str(), n.bias, n.error, n.noise, n.sigma, 100 * n.held, n.sigma / n.error);
      std::fflush(stdout);
    }
  }
}
