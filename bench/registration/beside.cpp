#include "beside.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <optional>

#include "bound.h"
#include "core/number.h"
#include "core/statistics.h"
#include "pairs.h"
#include "peers.h"

namespace partscribe::testing {
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
    if (row.errors[i] && other.errors[i])
      angle.push_back(row.errors[i]->angle * 180 / pi), shift.push_back(row.errors[i]->shift);
  const std::size_t starts = angle.size();
  return {median(std::move(angle)), median(std::move(shift)), starts};
}

/// Those whose names hold $PEERS, where that is set: some take long.
std::vector<peers::Method> all_methods() {
  auto methods = peers::small_gicp_methods();
  for (const auto& more : {peers::pcl_methods(), peers::open3d_methods()})
    methods.insert(methods.end(), more.begin(), more.end());
  if (const char* asked = std::getenv("PEERS"))
    std::erase_if(methods, [&](const peers::Method& m) { return m.name.find(asked) == std::string::npos; });
  return methods;
}

/// Where ours and then each method put the second view of a pair.
struct Answers {
  std::vector<Pose> world_from_second;
  std::vector<double> spent;  // ms
  bool refused = false;       // by ours
  std::vector<FreeMotion> free;
};

/// `gates`: mm, of each method. Nothing where ours cannot use the views.
std::optional<Answers> answers_to(const PairCase& pair, const std::vector<peers::Method>& methods,
                                  const std::vector<double>& gates, Context& context) {
  RegisterOptions options;
  options.guess_angle = pair.start + 0.1;
  const std::vector<RegisterView> views{pair.first, pair.second};
  double start = seconds();
  const auto ours = register_views(views, options, context);
  const double spent = 1000 * (seconds() - start);
  if (!ours.ok()) return {};
  Answers answers{
      {ours->views[1].world_from_view}, {spent}, ours->views[1].status == ViewStatus::refused, ours->free_motions};
  const Pose first = *pair.first.guess;
  for (std::size_t k = 0; k < methods.size(); ++k) {
    start = seconds();
    const Pose found = methods[k].align(pair.first.cloud.points, pair.second.cloud.points,
                                        first.inverse() * *pair.second.guess, pair.spacing, gates[k]);
    answers.spent.push_back(1000 * (seconds() - start));
    answers.world_from_second.push_back(first * found);
  }
  return answers;
}

/// What one method made of the pairs of one part.
struct BasinRow {
  std::string name, gate;
  std::map<int, int> by_overlap{}, by_start{};  // within one degree; percent, degrees
  int refused = 0, wrong = 0;
  std::map<int, std::vector<double>> angle{}, shift{};       // degrees, mm, where it was within one degree
  std::vector<double> angle_in_bounds{}, shift_in_bounds{};  // where no motion is free
  std::vector<double> spent{};                               // ms

  void count(const PairCase& pair, const PairError& e, const PairError& bound) {
    const double degrees = e.angle * 180 / pi;
    if (degrees > 1) {
      ++wrong;
      return;
    }
    const int overlap = static_cast<int>(std::lround(100 * pair.overlap));
    ++by_overlap[overlap], ++by_start[degrees_off(pair)];
    angle[overlap].push_back(degrees), shift[overlap].push_back(e.shift);
    if (bound.angle > 0)
      angle_in_bounds.push_back(e.angle / bound.angle), shift_in_bounds.push_back(e.shift / bound.shift);
  }
};

/// What noise leaves at least of the second view against the first, on the root mean square.
PairError bound_of(const PairCase& pair, Context& context) {
  const auto surfaces = view_surfaces({pair.first, pair.second}, 100, context, false);
  // Both views are off, by as much in opposite directions.
  const Mat6 covariance =
      4 * pose_bound(surfaces, {*pair.first.guess, pair.truth}, true_middle(pair), pair.radius, Eigen::MatrixXd(12, 0))
              .bottomRightCorner<6, 6>();
  return {std::sqrt(covariance.topLeftCorner<3, 3>().trace()) / pair.radius,
          std::sqrt(covariance.bottomRightCorner<3, 3>().trace())};
}

}  // namespace

void basin(const Path& scan_json) {
  Context context;
  std::vector<BasinRow> rows{{"Partscribe", "itself"}};
  std::vector<peers::Method> methods;
  std::vector<double> gates;
  for (const double gate : {10.0, 25.0})
    for (const auto& method : all_methods()) {
      if (std::any_of(rows.begin(), rows.end(),
                      [&](const BasinRow& r) { return r.name == method.name && r.gate == print_number(gate) + " mm"; }))
        continue;
      methods.push_back(method), gates.push_back(gate);
      rows.push_back({method.name, print_number(gate) + " mm"});
    }
  const auto pairs = basin_cases(scan_json, context);
  std::size_t declared = 0;
  for (const PairCase& pair : pairs) {
    const auto answers = answers_to(pair, methods, gates, context);
    if (!answers) continue;
    declared += !answers->free.empty();
    const PairError bound = answers->free.empty() ? bound_of(pair, context) : PairError{};
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows[k].spent.push_back(answers->spent[k]);
      if (k == 0 && answers->refused)
        ++rows[k].refused;
      else
        rows[k].count(pair, pair_error(pair, answers->world_from_second[k], answers->free), bound);
    }
  }
  std::printf("%zu starts, free motions declared of %zu\n", pairs.size(), declared);
  std::printf(
      "| method | partners within | overlap 30 %% | 50 | 70 | 90 | 5 deg | 10 | 20 | 30 | refused | wrong | median deg "
      "at 30 / 50 / 70 / 90 %% | mm | ms | off / bound, deg | mm "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (BasinRow& row : rows) {
    std::printf("| %s | %s |", row.name.c_str(), row.gate.c_str());
    for (const int overlap : {30, 50, 70, 90}) std::printf(" %d |", row.by_overlap[overlap]);
    for (const int off : {5, 10, 20, 30}) std::printf(" %d |", row.by_start[off]);
    std::printf(" %d | %d |", row.refused, row.wrong);
    for (auto* errors : {&row.angle, &row.shift})
      for (const int overlap : {30, 50, 70, 90}) {
        std::printf(overlap == 30 ? " " : " / ");
        if ((*errors)[overlap].empty())
          std::printf("none");
        else
          std::printf("%.4f", median((*errors)[overlap]));
        std::printf(overlap == 90 ? " |" : "");
      }
    std::printf(" %.0f | %.2f | %.2f |\n", median(row.spent), root_mean_square(row.angle_in_bounds),
                root_mean_square(row.shift_in_bounds));
  }
}

void beside(const Path& folder, const std::vector<std::string>& names) {
  Context context;
  const auto methods = all_methods();
  std::vector<Row> rows(methods.size() + 1);
  for (const auto& name : scans_in(folder, names))
    for (const PairCase& pair : pair_cases(folder / name / "scan" / "scan.json", name, 1, context)) {
      for (Row& row : rows) ++row.asked[degrees_off(pair)], row.errors.emplace_back();
      std::vector<double> gates;
      for (const auto& method : methods) gates.push_back(method.gate * pair.radius);
      const auto answers = answers_to(pair, methods, gates, context);
      if (!answers) continue;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        rows[k].spent.push_back(answers->spent[k]);
        if (k == 0 && answers->refused)
          ++rows[k].refused;
        else
          count(pair, answers->world_from_second[k], answers->free, rows[k]);
      }
    }
  std::printf(
      "| method | partners within | 5 deg | 15 | 30 | 60 | refused | wrong | median deg | median mm | ms | both right "
      "| ours / its, deg | mm |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Row& row = rows[k];
    std::printf("| %s | %s |", k == 0 ? "Partscribe" : methods[k - 1].name.c_str(),
                k == 0 ? "itself" : (print_number(methods[k - 1].gate) + " radius").c_str());
    int wrong = -row.refused;
    for (const auto& [degrees, asked] : row.asked)
      std::printf(" %d of %d |", row.right[degrees], asked), wrong += asked - row.right[degrees];
    std::printf(" %d | %d |", row.refused, wrong);
    const Medians its = medians_of(row, row), common = medians_of(row, rows[0]), ours = medians_of(rows[0], row);
    if (its.starts == 0)
      std::printf(" | |");
    else
      std::printf(" %.4f | %.4f |", its.angle, its.shift);
    std::printf(" %.0f |", median(row.spent));
    if (k == 0 || common.starts == 0)
      std::printf(" | | |\n");
    else
      std::printf(" %zu | %.2f | %.2f |\n", common.starts, ours.angle / common.angle, ours.shift / common.shift);
  }
}

}  // namespace partscribe::testing
