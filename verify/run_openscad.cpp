#include "verify/run_openscad.h"

#include <algorithm>
#include <sstream>

#include "core/process.h"
#include "geometry/read_geometry.h"
#include "verify/solid.h"

namespace partscribe {
namespace {

/// Lines in which OpenSCAD complains; at most twenty, for a loop can repeat one a million times.
std::vector<std::string> complaints_in(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const bool complains = line.find("WARNING") != std::string::npos || line.find("ERROR") != std::string::npos;
    if (complains && std::find(found.begin(), found.end(), line) == found.end()) found.push_back(line);
    if (found.size() == 20) break;
  }
  return found;
}

std::string last_line(const std::string& text) {
  std::string last;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) last = line;
  return last;
}

}  // namespace

Result<Evaluation> evaluate_openscad(const Path& path, const EvaluateOptions& options, Context& context) {
  Evaluation evaluation;
  evaluation.backend = "openscad";
  evaluation.program = "openscad";
  const auto version = run_process({"openscad", "--version"}, {30, options.memory_mb}, context);
  if (!version.ok()) return version.error();
  // "OpenSCAD version 2021.01", on standard error.
  std::istringstream words(version->err + " " + version->out);
  for (std::string word; words >> word;)
    if (word.find_first_of("0123456789") == 0) {
      evaluation.version = word;
      break;
    }

  const TemporaryDirectory folder;
  const Path stl = folder.path() / "evaluated.stl";
  // Absolute paths: 2021.01 resolves relative output names differently per format. Binary STL: ASCII keeps 6 digits.
  const auto run = run_process({"openscad", "-o", stl.string(), "--export-format", "binstl", "--hardwarnings",
                                "--check-parameters=true", "--check-parameter-ranges=true",
                                std::filesystem::absolute(path).string()},
                               {options.seconds, options.memory_mb}, context);
  if (!run.ok()) return run.error();
  evaluation.seconds = run->seconds;
  if (run->timed_out)
    return Error{"openscad did not finish '" + path.filename().string() + "' within " +
                     std::to_string(static_cast<long>(options.seconds)) + " s",
                 ErrorKind::stopped};
  evaluation.complaints = complaints_in(run->err);
  evaluation.failed = !evaluation.complaints.empty();
  // The exit code alone is no verdict: an open polyhedron inside a boolean is dropped with exit code 0.
  if (run->exit_code != 0) {
    evaluation.failed = true;
    std::string why = "openscad ended with exit code " + std::to_string(run->exit_code);
    if (evaluation.complaints.empty() && !last_line(run->err).empty()) why += ": " + last_line(run->err);
    evaluation.complaints.push_back(why);
  }
  std::error_code missing;
  if (!std::filesystem::exists(stl, missing)) {
    if (!evaluation.failed) evaluation.complaints.push_back("openscad wrote no geometry");
    evaluation.failed = true;
    return evaluation;
  }
  const auto raw = read_geometry(stl, context);
  if (!raw.ok()) {
    evaluation.failed = true;
    evaluation.complaints.push_back("the geometry that openscad wrote cannot be read: " + raw.error().message);
    return evaluation;
  }
  auto check = check_solid(raw->mesh);
  evaluation.mesh = in_canonical_order(check.mesh);  // facets of a boolean come in a different order each run
  evaluation.solid = check.solid;
  for (const auto& fault : check.faults) evaluation.complaints.push_back(fault);
  // STL holds single precision; the facets themselves are what the script means.
  double largest = 0;
  for (const auto& v : evaluation.mesh.vertices) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  evaluation.error = largest * 6e-8;
  return evaluation;
}

}  // namespace partscribe
