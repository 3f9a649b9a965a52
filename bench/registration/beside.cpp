#include "beside.h"

#include <cstdio>
#include <ctime>
#include <map>
#include <optional>

#include "core/number.h"
#include "core/statistics.h"
#include "pairs.h"
#include "peers.h"

namespace partscribe {
namespace {

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Row {
  std::map<int, int> right, asked;  // by degrees of the start
  int refused = 0;
  std::vector<std::optional<PairError>> errors;  // of every start; nothing where it was not right
  std::vector<double> spent;                     // ms
};

void count(const PairCase& pair, const Pose& world_from_second, const std::vector<FreeMotion>& free, Row& row) {
  const PairError e = pair_error(pair, world_from_second, free);
  if (!is_right(pair, e)) return;
  ++row.right[degrees_off(pair)];
  row.errors.back() = e;
}

/// Medians (degrees, mm) of `row` where it was right, or where `other` was as well.
struct Medians {
  double angle = 0, shift = 0;
  std::size_t starts = 0;
};
Medians medians_of(const Row& row, const Row& other) {
  std::vector<double> angle, shift;
  for (std::size_t i = 0; i < row.errors.size(); ++i)
    if (row.errors[i] && other.errors[i]) angle.push_back(row.errors[i]->angle * 180 / pi), shift.push_back(row.errors[i]->shift);
  const std::size_t starts = angle.size();
  return {median(std::move(angle)), median(std::move(shift)), starts};
}

}  // namespace

void beside(const Path& folder, const std::vector<std::string>& names) {
  Context context;
  auto methods = peers::small_gicp_methods();
  for (const auto& more : {peers::pcl_methods(), peers::open3d_methods()}) methods.insert(methods.end(), more.begin(), more.end());
  std::vector<Row> rows(methods.size() + 1);
  for (const auto& name : scans_in(folder, names))
    for (const PairCase& pair : pair_cases(folder / name / "scan" / "scan.json", name, 1, context)) {
      for (Row& row : rows) ++row.asked[degrees_off(pair)], row.errors.emplace_back();
      RegisterOptions options;
      options.guess_angle = pair.start + 0.1;
      double start = seconds();
      const auto ours = register_views({pair.first, pair.second}, options, context);
      rows[0].spent.push_back(1000 * (seconds() - start));
      if (!ours.ok()) continue;
      if (ours->views[1].status == ViewStatus::refused) ++rows[0].refused;
      else count(pair, ours->views[1].world_from_view, ours->free_motions, rows[0]);
      const Pose first = *pair.first.guess;
      for (std::size_t k = 0; k < methods.size(); ++k) {
        start = seconds();
        const Pose found = methods[k].align(pair.first.cloud.points, pair.second.cloud.points, first.inverse() * *pair.second.guess, pair.spacing, methods[k].gate * pair.radius);
        rows[k + 1].spent.push_back(1000 * (seconds() - start));
        count(pair, first * found, ours->free_motions, rows[k + 1]);
      }
    }
  std::printf("| method | partners within | 5 deg | 15 | 30 | 60 | refused | wrong | median deg | median mm | ms | both right | ours / its, deg | mm |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Row& row = rows[k];
    std::printf("| %s | %s |", k == 0 ? "Partscribe" : methods[k - 1].name.c_str(), k == 0 ? "itself" : (print_number(methods[k - 1].gate) + " radius").c_str());
    int wrong = -row.refused;
    for (const auto& [degrees, asked] : row.asked) std::printf(" %d of %d |", row.right[degrees], asked), wrong += asked - row.right[degrees];
    std::printf(" %d | %d |", row.refused, wrong);
    const Medians its = medians_of(row, row), common = medians_of(row, rows[0]), ours = medians_of(rows[0], row);
    if (its.starts == 0) std::printf(" | |");
    else std::printf(" %.4f | %.4f |", its.angle, its.shift);
    std::printf(" %.0f |", median(row.spent));
    if (k == 0 || common.starts == 0) std::printf(" | | |\n");
    else std::printf(" %zu | %.2f | %.2f |\n", common.starts, ours.angle / common.angle, ours.shift / common.shift);
  }
}

}  // namespace partscribe
