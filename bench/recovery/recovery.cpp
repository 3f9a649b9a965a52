/// How often each kind of part is recovered from hard scans, and how near its numbers come to the best possible.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/recovery/best_fit.h"
#include "codegen/emit.h"
#include "core/files.h"
#include "core/number.h"
#include "core/statistics.h"
#include "testing/recovery/score.h"
#include "verify/verify.h"

using namespace partscribe::codegen;
using namespace partscribe::verify;
using namespace partscribe::testing::recovery;

namespace {

const char* usage =
    "usage: recovery [--runs N] [--first SEED] [--kind KIND] [--setting standard|clean|hardest|facets|degenerate] "
    "[--verbose] [--save FILE.xyz]\n";

void save(const Case& c, const std::string& file) {
  if (std::FILE* out = std::fopen(file.c_str(), "w")) {
    for (const Vec3& p : c.scan.cloud.points) std::fprintf(out, "%.6f %.6f %.6f\n", p.x(), p.y(), p.z());
    std::fclose(out);
  }
}

std::string middle(const std::vector<double>& ratios) {
  return ratios.empty() ? "-" : print_number(snapped(median(ratios), 0.01));
}

Conditions conditions_of(const std::string& setting) {
  if (setting == "clean") return clean_conditions();
  return setting == "standard" || setting == "degenerate" ? standard_conditions()
         : setting == "facets"                            ? facet_conditions()
                                                          : hardest_conditions();
}

/// How far numbers are off, in units of the error that half of all have if they are as small as can be: ours, and those
/// of the best fit to the same points.
class Errors {
 public:
  void add(double ours, std::optional<double> best) {
    ours_.push_back(ours);
    if (!best) return;
    const double cut = std::min(ours, most), best_cut = std::min(*best, most);
    best_.push_back(*best), square_ += cut * cut, best_square_ += best_cut * best_cut;
  }
  /// The medians of both, and the root mean square of ours over that of the best fit: chance is the same in both, so
  /// that this is known far better than either.
  std::string cells() const {
    return middle(ours_) + " | " + middle(best_) + " | " +
           (best_square_ > 0 ? print_number(snapped(std::sqrt(square_ / best_square_), 0.01)) : "-");
  }

 private:
  static constexpr double most = 6;  // what is farther off is right by its own sigma alone
  std::vector<double> ours_, best_;
  double square_ = 0, best_square_ = 0;
};

/// What the program says of a model that it has built: the verdict on its script, run against the scan.
Outcome verdict_on(const Score& score, const Case& c, Context& context) {
  const TemporaryDirectory folder;
  const auto artifact = emit(*score.model, "alpha1", {}, context);
  if (!artifact) return Outcome::not_run;
  for (const auto& f : artifact->files)
    if (!write_file(folder.path() / f.name, f.bytes)) return Outcome::not_run;
  Scan scan = c.scan;
  scan.cloud.rejected = score.rejected;
  VerifyOptions options;
  options.tolerance = c.tolerance;
  const auto verdict =
      verify_artifacts({folder.path() / artifact->files[0].name}, scan, **score.model, options, context);
  return verdict ? verdict->verdict : Outcome::not_run;
}

std::string row(const std::string& kind, const std::string& setting, std::uint64_t first, std::uint64_t runs,
                bool verbose, const std::string& file) {
  std::map<Answer, std::size_t> answers;
  Errors on_rays, without_rays;
  std::vector<double> seconds;
  // A body of another kind that lies as near to all that was seen as a fit of the true kind would: nobody could tell.
  constexpr double as_near_as_right = 1.5;
  std::size_t wrong_and_verified = 0, nobody_could = 0, open = 0, open_held = 0;
  for (std::uint64_t seed = first; seed < first + runs; ++seed) {
    const Case c = make_case(kind, conditions_of(setting), seed);
    if (!file.empty()) save(c, file);
    Context context;
    if (verbose && runs == 1)
      context.log = [](const std::string& line) { std::fprintf(stderr, "    %s\n", line.c_str()); };
    const Score score = recovered(c, context);
    ++answers[score.answer];
    nobody_could += score.answer == Answer::cannot_tell && score.model && score.surface_error < as_near_as_right;
    const bool believed = score.answer == Answer::wrong && verdict_on(score, c, context) == Outcome::verified;
    wrong_and_verified += believed;
    seconds.push_back(score.seconds);
    constexpr double two_sigmas = 2;
    open += score.open.size(),
        open_held +=
        std::size_t(std::count_if(score.open.begin(), score.open.end(), [](double u) { return u < two_sigmas; }));
    if (score.answer == Answer::right && !score.numbers.empty()) {
      const auto fitted = best_numbers(c);
      Errors& errors = c.scan.cloud.rays.empty() ? without_rays : on_rays;
      for (const Score::Number& n : score.numbers)
        errors.add(n.ratio, fitted.empty()
                                ? std::nullopt
                                : std::optional(std::abs(fitted[n.parameter] - c.truth.parameters[n.parameter].value) /
                                                n.typical));
    }
    if (verbose && (score.answer != Answer::right || runs == 1))
      std::fprintf(stderr,
                   "%s %s %llu: %s, found %s%s%s%s (noise %.2f %%, outliers %.0f %%, seen %.0f %%, %s, size %.1f, T "
                   "%g, surface %.1f, %.2f s)\n",
                   kind.c_str(), setting.c_str(), static_cast<unsigned long long>(seed), name_of(score.answer),
                   score.found.c_str(), believed ? ", verified" : "", score.why.empty() ? "" : ": ", score.why.c_str(),
                   100 * c.noise / c.size, 100 * c.outliers, 100 * c.seen,
                   c.scan.cloud.rays.empty() ? "no rays" : "rays", c.size, c.tolerance, score.surface_error,
                   score.seconds);
  }
  char text[300];
  const auto share = [&](Answer a) { return 100.0 * double(answers[a]) / double(runs); };
  std::snprintf(text, sizeof text, "| %s | %s | %.1f | %.1f | %.1f | %.1f | %.1f | %s | %s | %zu of %zu | %.2f |",
                kind.c_str(), setting.c_str(), share(Answer::right), share(Answer::cannot_tell),
                100.0 * double(nobody_could) / double(runs), share(Answer::wrong),
                100.0 * double(wrong_and_verified) / double(runs), on_rays.cells().c_str(),
                without_rays.cells().c_str(), open_held, open, median(seconds));
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t runs = 200, first = 1;
  std::vector<std::string> wanted, settings = {"standard", "hardest", "facets", "degenerate"};
  bool verbose = false;
  std::string file;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto value = [&]() -> std::string { return i + 1 < argc ? argv[++i] : ""; };
    if (option == "--runs")
      runs = std::strtoull(value().c_str(), nullptr, 10);
    else if (option == "--first")
      first = std::strtoull(value().c_str(), nullptr, 10);
    else if (option == "--kind")
      wanted = {value()};
    else if (option == "--setting")
      settings = {value()};
    else if (option == "--verbose")
      verbose = true;
    else if (option == "--save")
      file = value();
    else
      return std::fputs(usage, stderr), 2;
  }
  for (const auto& kind : wanted)
    if (std::find(kinds().begin(), kinds().end(), kind) == kinds().end() &&
        std::find(degenerate_kinds().begin(), degenerate_kinds().end(), kind) == degenerate_kinds().end())
      return std::fputs(usage, stderr), 2;
  if (runs == 0) return std::fputs(usage, stderr), 2;
  std::printf(
      "%llu runs each, seeds from %llu\n\n| kind | setting | right %% | cannot tell %% | nobody could %% | wrong %% | "
      "wrong and verified %% | error / bound, rays known | the best fit's | ours / its, rms | rays unknown | the best "
      "fit's | ours / its, rms | open numbers within 2 sigmas | s "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      static_cast<unsigned long long>(runs), static_cast<unsigned long long>(first));
  for (const auto& setting : settings)
    for (const auto& kind : wanted.empty() ? (setting == "degenerate" ? degenerate_kinds() : kinds()) : wanted) {
      std::puts(row(kind, setting, first, runs, verbose, file).c_str());
      std::fflush(stdout);
    }
  return 0;
}
