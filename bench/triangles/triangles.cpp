/// Fewest triangles within a tolerance both ways: ours beside CGAL, OpenMesh, meshoptimizer and PMP.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/triangles/deviation.h"
#include "bench/triangles/peers.h"
#include "bench/triangles/sets.h"
#include "core/files.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/decimate.h"
#include "geometry/mesh/self_intersection.h"

using namespace bench;

namespace {

constexpr const char* usage =
    "usage: bench_triangles [--face FILE] [--bunny FILE] [--mustard FILE] [--set NAME] [--contestant NAME]\n"
    "                       [--search-ours] [--threads N] [--json FILE] [--write DIR]\n"
    "  files in metres, as those scans are published; --set: only that one; --contestant: those whose names begin so\n"
    "  --search-ours: ours also with its bound searched as the others' settings are; else only where it misses T\n"
    "  --threads: of the measurement; all contestants have one\n";

/// One answer, and what was measured of it.
struct Outcome {
  std::string contestant;
  double setting = 0, seconds = 0;
  TriangleMesh mesh;
  Deviation off;
  bool met = false;
  int runs = 1;  // it took to find the setting
};

struct Question {
  const TriangleSet& set;
  const DeviationFrom& deviation;

  bool meets(const TriangleMesh& mesh) const { return sound(mesh) && deviation.within(mesh, set.tolerance); }
  static bool sound(const TriangleMesh& mesh) {
    return !mesh.empty() &&
           std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const Vec3& v) { return v.allFinite(); });
  }
  Outcome outcome(const std::string& contestant, double setting, Simplified answer) const {
    Outcome o{contestant, setting, answer.seconds, std::move(answer.mesh), {}, false, 1};
    if (sound(o.mesh)) o.off = deviation.of(o.mesh), o.met = o.off.two_sided() <= set.tolerance;
    return o;
  }
};

/// The answer with the fewest triangles that meets the tolerance, by a setting between one that does and one that does
/// not, a percent apart. `coarser`: the factor by which a setting makes fewer triangles.
Outcome searched(const Contestant& contestant, const Question& question, double start, double fine, double coarse,
                 int& runs) {
  const auto between = [](double a, double b) { return std::sqrt(a * b); };
  const bool whole = contestant.knob == Knob::count;
  std::optional<std::pair<double, Simplified>> best;
  double good = fine, bad = coarse;  // the source itself meets it; nothing is left at the other end
  const auto try_setting = [&](double setting) {
    Simplified answer = contestant.run(question.set.mesh, setting);
    ++runs;
    const bool met = question.meets(answer.mesh);
    if (met && (!best || answer.mesh.triangles.size() < best->second.mesh.triangles.size()))
      best = {setting, std::move(answer)};
    (met ? good : bad) = setting;
    return met;
  };
  // Out from the start by even steps, until one setting is good and one is bad. They must not be large: what
  // contestants make of a setting rises and falls.
  double setting = start;
  const bool first = try_setting(setting);
  const double step = first == (fine > coarse) ? 1 / 1.4 : 1.4;
  while (runs < 12) {
    setting = whole ? std::round(setting * step) : setting * step;
    if (setting < std::min(fine, coarse) || setting > std::max(fine, coarse) || try_setting(setting) != first) break;
  }
  while (std::abs(std::log(good / bad)) > 0.01 && (!whole || std::abs(good - bad) > 2) && runs < 45) {
    const double next = between(good, bad);
    try_setting(whole ? std::round(next) : next);
  }
  if (!best) return {contestant.name, fine, 0, question.set.mesh, {}, false, runs};
  Outcome o = question.outcome(contestant.name, best->first, std::move(best->second));
  o.runs = runs;
  return o;
}

std::vector<Outcome> outcomes(const Contestant& contestant, const Question& question, bool search_ours, double guess) {
  const TriangleSet& set = question.set;
  std::vector<Outcome> result;
  int runs = 0;
  if (contestant.knob == Knob::count) {
    result.push_back(searched(contestant, question, guess, double(set.mesh.triangles.size()), 4, runs));
    return result;
  }
  result.push_back(question.outcome(contestant.name, set.tolerance, contestant.run(set.mesh, set.tolerance)));
  if (contestant.knob == Knob::tolerance && result.back().met && !search_ours) return result;
  result.back().contestant += ", told T";
  result.push_back(searched(contestant, question, set.tolerance, set.tolerance / 1000, set.tolerance * 1000, runs));
  return result;
}

std::string scaled_text(double mm, double tolerance) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f T", mm / tolerance);
  return text;
}

void print(const Outcome& o, const TriangleSet& set) {
  const bool found = o.seconds > 0 || o.met;
  std::printf("| %-42s | %7zu | %10s | %10s | %8.2f | %4d | %5zu | %s |\n", o.contestant.c_str(),
              o.mesh.triangles.size(), scaled_text(o.off.data_to_mesh, set.tolerance).c_str(),
              scaled_text(o.off.mesh_to_data, set.tolerance).c_str(), o.seconds, o.runs,
              self_intersections(o.mesh).size(),
              o.met    ? "yes"
              : !found ? "nothing found"
                       : "NO");
  std::fflush(stdout);
}

std::string json_line(const Outcome& o, const TriangleSet& set, const std::string& version) {
  const MeshTopology whole = topology(o.mesh);
  nlohmann::ordered_json line;
  line["set"] = set.name, line["contestant"] = o.contestant, line["version"] = version;
  line["compiler"] = __VERSION__;
  line["source_triangles"] = set.mesh.triangles.size();
  line["tolerance_mm"] = set.tolerance, line["spacing_mm"] = set.spacing;
  line["setting"] = o.setting, line["triangles"] = o.mesh.triangles.size();
  line["data_to_mesh_mm"] = o.off.data_to_mesh, line["mesh_to_data_mm"] = o.off.mesh_to_data;
  line["met"] = o.met, line["cpu_seconds"] = o.seconds, line["runs"] = o.runs;
  line["nonmanifold_edges"] = whole.nonmanifold_edges, line["crossing_pairs"] = self_intersections(o.mesh).size();
  if (set.least) line["least_on_surface"] = *set.least;
  if (set.least_free) line["least"] = *set.least_free;
  return line.dump() + "\n";
}

}  // namespace

double bench::processor_seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

Contestant bench::ours() {
  return {"ours", "", Knob::tolerance, [](const TriangleMesh& mesh, double tolerance) {
            partscribe::core::Context context;
            const double before = processor_seconds();
            DecimateOptions options;
            options.max_error = tolerance;
            TriangleMesh small = decimated(mesh, options, context);
            return Simplified{std::move(small), processor_seconds() - before};
          }};
}

int main(int count, char** arguments) {
  std::map<std::string, std::string> files;
  std::string only_set, only_contestant, json_file, folder;
  bool search_ours = false;
  int threads = 1;
  for (int i = 1; i < count; ++i) {
    const std::string option = arguments[i];
    const bool more = i + 1 < count;
    if (option == "--search-ours")
      search_ours = true;
    else if (!more)
      return std::fprintf(stderr, "%s", usage), 2;
    else if (option == "--set")
      only_set = arguments[++i];
    else if (option == "--contestant")
      only_contestant = arguments[++i];
    else if (option == "--threads")
      threads = std::max(1, std::atoi(arguments[++i]));
    else if (option == "--json")
      json_file = arguments[++i];
    else if (option == "--write")
      folder = arguments[++i];
    else if (option == "--face" || option == "--bunny" || option == "--mustard")
      files[option.substr(2)] = arguments[++i];
    else
      return std::fprintf(stderr, "%s", usage), 2;
  }
  std::vector<Contestant> contestants = {ours()};
  for (const auto& list : {cgal_simplifiers(), openmesh_simplifiers(), meshoptimizer_simplifiers(), pmp_simplifiers()})
    contestants.insert(contestants.end(), list.begin(), list.end());
  std::erase_if(contestants, [&](const Contestant& c) { return !c.name.starts_with(only_contestant); });
  std::ofstream json;
  if (!json_file.empty()) json.open(json_file);

  // Of each set: the fewest triangles of every contestant; `broken`: how much ours was off where it missed T by itself.
  struct Row {
    std::string set;
    std::map<std::string, std::size_t> fewest;
    double broken = 0;
  };
  std::vector<Row> summary;
  for (const SetMaker& maker : set_makers()) {
    if (!only_set.empty() && maker.name != only_set) continue;
    if (!maker.file.empty() && !files.contains(maker.file)) {
      std::printf("\n%s: not run, no --%s FILE given\n", maker.name.c_str(), maker.file.c_str());
      continue;
    }
    const auto made = maker.make(maker.file.empty() ? "" : files[maker.file]);
    if (!made.ok()) return std::fprintf(stderr, "%s\n", made.error().message.c_str()), 3;
    const TriangleSet& set = *made;
    const MeshTopology whole = topology(set.mesh);
    std::printf("\n**%s**: %zu triangles, %zu edges on its border, T = %g mm, measured every %g mm", set.name.c_str(),
                set.mesh.triangles.size(), whole.boundary_edges, set.tolerance, set.spacing);
    if (set.least) std::printf("; at least %.0f triangles with vertices on the surface", *set.least);
    if (set.least_free) std::printf(", %.0f with vertices beside it", *set.least_free);
    std::printf("\n\n| %-42s | %7s | %10s | %10s | %8s | %4s | %5s | met |\n|---|---|---|---|---|---|---|---|\n", "",
                "triangles", "data-mesh", "mesh-data", "CPU s", "runs", "cross");
    const DeviationFrom deviation(set.mesh, set.spacing, threads);
    const Question question{set, deviation};
    summary.push_back({set.name, {}, 0});
    double guess = 0.02 * double(set.mesh.triangles.size());
    for (const Contestant& contestant : contestants) {
      if (!contestant.run) {
        std::printf("| %-42s | not installed: not run |\n", contestant.name.c_str());
        continue;
      }
      if (contestant.locks_border && whole.boundary_edges == 0) continue;
      for (const Outcome& o : outcomes(contestant, question, search_ours, guess)) {
        print(o, set);
        if (json.is_open()) json << json_line(o, set, contestant.version) << std::flush;
        if (!folder.empty()) {
          const partscribe::core::Path file =
              partscribe::core::Path(folder) / (set.name + ", " + o.contestant + ".ply");
          if (const auto done = partscribe::core::write_file(file, write_mesh_ply(o.mesh)); !done)
            return std::fprintf(stderr, "%s\n", done.error().message.c_str()), 1;
        }
        const std::size_t left = o.mesh.triangles.size();
        auto& fewest = summary.back().fewest;
        if (contestant.knob == Knob::tolerance && !o.met) summary.back().broken = o.off.two_sided() / set.tolerance;
        if (o.met)
          fewest[contestant.name] = fewest.contains(contestant.name) ? std::min(fewest[contestant.name], left) : left;
        if (o.met) guess = double(left);
      }
    }
  }

  std::printf("\n| triangles with T met both ways |");
  for (const Contestant& c : contestants) std::printf(" %s |", c.name.c_str());
  std::printf(" ours / best peer |\n|---|");
  for (std::size_t i = 0; i <= contestants.size(); ++i) std::printf("---|");
  for (const Row& row : summary) {
    std::printf("\n| %s |", row.set.c_str());
    std::size_t best = 0, our = 0;
    for (const Contestant& c : contestants) {
      const auto found = row.fewest.find(c.name);
      if (found == row.fewest.end()) {
        std::printf(" - |");
        continue;
      }
      std::printf(" %zu", found->second);
      if (c.knob == Knob::tolerance && row.broken > 0) std::printf(" searched, %.2f T as told", row.broken);
      std::printf(" |");
      if (c.knob == Knob::tolerance)
        our = found->second;
      else
        best = best == 0 ? found->second : std::min(best, found->second);
    }
    if (our > 0 && best > 0)
      std::printf(" %.2f |", double(our) / double(best));
    else
      std::printf(" - |");
  }
  std::printf("\n");
}
