/// B-spline surfaces within a tolerance of points, as we, FITPACK, SISL and OpenCASCADE fit them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/random.h"
#include "peers.h"

using namespace bench;

namespace {

const char* usage =
    "usage: bench_splines [--only NAME] [--field NAME] [--points KIND] [--seconds MOST]\n                     "
    "[--growth | --size] [--verbose]\n"
    "  --only NAME     contestants whose name holds this\n"
    "  --field NAME    fields whose name holds this\n"
    "  --points KIND   gridded or scattered\n"
    "  --seconds MOST  of processor time for one fit (60)\n"
    "  --growth        the smooth field with 10,000, 100,000 and 1,000,000 points\n"
    "  --size          250,000 scattered points at 0.1 % of the size\n";

const char* legend =
    "Fields of 80 x 60 mm, 160 x 160 points of each: a grid, and the same jittered by up to 0.4 of their distance.\n"
    "Each contestant's own parameter is driven to the fewest control points with which the true surface and the "
    "fitted\n"
    "one are nowhere farther from each other than the tolerance, measured without noise by the same code. `ours`: the\n"
    "parameter as the program has it.\n"
    "  control: points of the net; to fit, to truth: largest distance each way, over the tolerance; rms: from the "
    "true\n"
    "  surface, mm; bending: integral of the squared curvatures; seconds: of processor time of one fit at the setting\n"
    "  found; MB: memory at most; asked: fits that were tried; allowed: the parameter found, mm\n\n";

Question question_of(const Field& field, bool gridded, int columns, int rows, double sigma, double tolerance) {
  Question question;
  question.sigma = sigma, question.tolerance = tolerance;
  if (gridded) question.columns = columns, question.rows = rows;
  partscribe::core::Random random(1993);
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      double a = i, b = j;
      if (!gridded) {
        a = std::clamp(a + random.uniform(-0.4, 0.4), 0.0, double(columns - 1));
        b = std::clamp(b + random.uniform(-0.4, 0.4), 0.0, double(rows - 1));
      }
      const double x = field_size.x() * a / (columns - 1), y = field_size.y() * b / (rows - 1);
      question.points.emplace_back(x, y, field.height(x, y) + sigma * random.normal());
    }
  return question;
}

struct Outcome {
  std::optional<Answer> answer;  // the one with the fewest control points of those that keep the tolerance
  Quality quality;
  double allowed = 0;
  int asked = 0;
  std::string setting;
};

bool verbose = false;

/// One fit; kept in the outcome if it is better than what is there. Does it keep the tolerance?
bool ask_once(const Contestant& contestant, const Field& field, const Question& question, double allowed,
              bool in_any_case, Outcome& outcome, bool* answered = nullptr) {
  ++outcome.asked;
  auto answer = contestant.ask(question, allowed);
  // More control points than a third of the points say nothing of these; tighter settings only give more.
  if (answer && 3 * answer->surface.points.size() > question.points.size()) answer.reset();
  if (answered) *answered = answer.has_value();
  if (!answer) {
    if (verbose) std::printf("      %s %s %.5f: none\n", contestant.name.c_str(), contestant.setting.c_str(), allowed);
    return false;
  }
  const Quality q = quality(field, answer->surface);
  const bool kept = q.worst() <= question.tolerance;
  if (verbose)
    std::printf("      %s %s %.5f: %zu, %.3f, %.2f s\n", contestant.name.c_str(), contestant.setting.c_str(), allowed,
                answer->surface.points.size(), q.worst() / question.tolerance, answer->seconds);
  const bool better = !outcome.answer || answer->surface.points.size() < outcome.answer->surface.points.size();
  if (in_any_case || (kept && better))
    outcome.setting = contestant.setting, outcome.answer = std::move(answer), outcome.quality = q,
    outcome.allowed = allowed;
  return kept;
}

Outcome driven(const Contestant& contestant, const Field& field, const Question& question) {
  Outcome outcome;
  double allowed = contestant.loosest * question.tolerance, failing = 2 * allowed;
  if (!contestant.driven) {
    ask_once(contestant, field, question, allowed, true, outcome);
    return outcome;
  }
  int missed = 0;  // in turn without any answer: it only gets harder
  while (allowed > 0.004 * question.tolerance && missed < 2) {
    bool answered = false;
    if (ask_once(contestant, field, question, allowed, false, outcome, &answered)) break;
    missed = answered ? 0 : missed + 1;
    failing = allowed, allowed /= 1.5;
  }
  if (!outcome.answer) return outcome;
  for (int round = 0; round < 4; ++round) {
    const double middle = std::sqrt(failing * allowed);
    (ask_once(contestant, field, question, middle, false, outcome) ? allowed : failing) = middle;
  }
  return outcome;
}

bool better(const Outcome& a, const Outcome& b) {
  if (!a.answer || !b.answer) return a.answer.has_value();
  const auto n = a.answer->surface.points.size(), m = b.answer->surface.points.size();
  return n < m || (n == m && a.quality.worst() < b.quality.worst());
}

void print(const Contestant& contestant, const Question& question, const Outcome& outcome) {
  if (!outcome.answer) {
    std::printf("  %-22s not kept (%d asked)\n", contestant.name.c_str(), outcome.asked);
  } else {
    const Answer& a = *outcome.answer;
    const Quality& q = outcome.quality;
    std::printf("  %-22s %7zu %3d x %-3d %8.3f%s %8.3f%s %8.4f %8.3f %9.3f %7.1f %6d %9.5f %s\n",
                contestant.name.c_str(), a.surface.points.size(), a.surface.u.count(), a.surface.v.count(),
                q.to_fit / question.tolerance, q.to_fit > question.tolerance ? "!" : " ",
                q.to_truth / question.tolerance, q.to_truth > question.tolerance ? "!" : " ", q.rms, q.bending,
                a.seconds, a.megabytes, outcome.asked, outcome.allowed, outcome.setting.c_str());
  }
  std::fflush(stdout);
}

void print_title(const Field& field, const Question& question) {
  std::printf("%s, %zu %s points, sigma %.2f, tolerance %.2f\n", field.name.c_str(), question.points.size(),
              question.columns ? "gridded" : "scattered", question.sigma, question.tolerance);
  std::printf("  %-22s %7s %9s %9s %9s %8s %8s %9s %7s %6s %9s\n", "", "control", "", "to fit", "to truth", "rms",
              "bending", "seconds", "MB", "asked", "allowed");
}

bool takes(const Contestant& contestant, const Question& question) {
  return !(contestant.needs_grid && question.columns == 0) && !(contestant.needs_scatter && question.columns > 0);
}

}  // namespace

int main(int count, char** arguments) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  std::string only, named, kind, mode;
  double seconds = 60;
  for (int i = 1; i < count; ++i) {
    const std::string option = arguments[i];
    const bool more = i + 1 < count;
    if (option == "--only" && more)
      only = arguments[++i];
    else if (option == "--field" && more)
      named = arguments[++i];
    else if (option == "--points" && more)
      kind = arguments[++i];
    else if (option == "--seconds" && more)
      seconds = std::atof(arguments[++i]);
    else if (option == "--growth" || option == "--size")
      mode = option;
    else if (option == "--verbose")
      verbose = true;
    else
      return std::fprintf(stderr, "%s", usage), 2;
  }
  std::vector<Contestant> contestants = {ours(false, seconds), ours(true, seconds)};
  for (const auto& peers : {fitpack(seconds), sisl(seconds), occt(seconds)})
    contestants.insert(contestants.end(), peers.begin(), peers.end());
  std::erase_if(contestants, [&](const Contestant& c) { return c.name.find(only) == std::string::npos; });
  auto all = fields();
  std::erase_if(all, [&](const Field& f) { return f.name.find(named) == std::string::npos; });
  std::printf("%s", legend);
  const auto compare = [&](const Field& field, const Question& question) {
    print_title(field, question);
    for (std::size_t c = 0; c < contestants.size();) {
      const std::size_t first = c;
      std::optional<Outcome> best;
      int asked = 0;
      for (; c < contestants.size() && contestants[c].name == contestants[first].name; ++c) {
        if (!takes(contestants[c], question)) continue;
        Outcome outcome = driven(contestants[c], field, question);
        asked += outcome.asked;
        if (!best || better(outcome, *best)) best = std::move(outcome);
      }
      if (!best) continue;
      best->asked = asked;
      print(contestants[first], question, *best);
    }
  };
  if (mode == "--growth") {
    // Driven once, with 10,000 points; the others take the setting found.
    const Field smooth = fields().front();
    for (const bool gridded : {true, false})
      for (const Contestant& contestant : contestants) {
        double allowed = 0;
        for (const int side : {100, 316, 1000}) {
          const Question question = question_of(smooth, gridded, side, side, 0.03, 0.05);
          if (!takes(contestant, question)) break;
          Outcome outcome;
          if (side == 100)
            outcome = driven(contestant, smooth, question), allowed = outcome.allowed, print_title(smooth, question);
          else
            ask_once(contestant, smooth, question, allowed, true, outcome);
          print(contestant, question, outcome);
        }
      }
    return 0;
  }
  if (mode == "--size") {
    for (const Field& field : all) compare(field, question_of(field, false, 500, 500, 0.03, 0.001 * field_size.norm()));
    return 0;
  }
  for (const Field& field : all)
    for (const double sigma : {0.0, 0.03})
      for (const double tolerance : {0.05, 0.15})
        for (const bool gridded : {true, false})
          if (kind.empty() || kind == (gridded ? "gridded" : "scattered"))
            compare(field, question_of(field, gridded, 160, 160, sigma, tolerance));
}
