#include "verify/evaluate/run_openscad.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "core/number.h"
#include "core/process.h"
#include "geometry/io/read_geometry.h"
#include "verify/evaluate/openscad_files.h"
#include "verify/evaluate/solid.h"

namespace partscribe::verify {
namespace {

/// OpenSCAD names a script by the way there from where it runs; its name says it as well.
std::string without_folders(std::string line, const std::string& name) {
  const auto end = line.find("/" + name);
  if (end == std::string::npos) return line;
  const auto begin = line.find_last_of(" '\"", end);
  return line.erase(begin + 1, end - begin);  // npos + 1 is 0
}

/// What OpenSCAD says of its own memory, not of the script.
constexpr const char* its_own_warning = "WARNING: GeometryEvaluator: Node didn't fit into cache";

/// Lines in which OpenSCAD complains about the script `name`; at most twenty, for a loop can repeat one a million
/// times.
std::vector<std::string> complaints_in(const std::string& text, const std::string& name) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const bool complains = line.find("WARNING") != std::string::npos || line.find("ERROR") != std::string::npos;
    if (!complains || line.starts_with(its_own_warning)) continue;
    line = without_folders(std::move(line), name);
    if (line.find("Can't open") != std::string::npos) line += " (a script reads files of its own folder and below)";
    if (std::find(found.begin(), found.end(), line) == found.end()) found.push_back(line);
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

constexpr double most_file_mb = 2048;

/// STL holds single precision; the facets themselves are what the script means.
constexpr double single_precision = 6e-8;

/// The name in "use <name>" or "include <name>" if the line begins so; empty else.
std::string named_file(const std::string& line, const std::string& keyword) {
  const auto begin = line.find_first_not_of(" \t");
  if (begin == std::string::npos || line.compare(begin, keyword.size(), keyword) != 0) return {};
  const auto open = line.find_first_not_of(" \t", begin + keyword.size()), close = line.find('>');
  if (open == std::string::npos || line[open] != '<' || close == std::string::npos) return {};
  return line.substr(open + 1, close - open - 1);
}

/// A script that draws what another draws, moved by -`far`: OpenSCAD computes in double precision and writes in single.
/// Files that the other names are looked for beside it.
std::string moved_script(const Path& script, const std::string& text, const Vec3& far) {
  std::string uses, body;
  const auto found = [&](const std::string& name) {
    const Path beside = std::filesystem::absolute(script).parent_path() / name;
    std::error_code missing;
    return std::filesystem::exists(beside, missing) ? beside.string() : name;
  };
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    // Within a module nothing may be used.
    if (const auto used = named_file(line, "use"); !used.empty())
      uses += "use <" + found(used) + ">\n";
    else if (const auto part = named_file(line, "include"); !part.empty())
      body += "include <" + found(part) + ">\n";
    else
      body += line + "\n";
  }
  const auto back = [&](int k) { return print_number(-far[k]); };
  return uses + "module far_away() {\n" + body + "}\ntranslate([" + back(0) + ", " + back(1) + ", " + back(2) +
         "]) far_away();\n";
}

/// Runs a script as it is, which may read itself and `files`; `evaluation` has the program's name already.
Result<Evaluation> run_script(const Path& path, const std::vector<Path>& files, Evaluation evaluation,
                              const EvaluateOptions& options, Context& context) {
  const auto folder = TemporaryDirectory::make();
  if (!folder) return folder.error();
  const Path script = std::filesystem::absolute(path), stl = folder->path() / "evaluated.stl";
  Confinement reach{openscad_folders(), {folder->path()}};
  reach.readable.push_back(script);
  reach.readable.insert(reach.readable.end(), files.begin(), files.end());
  // Absolute paths: 2021.01 resolves relative output names differently per format. Binary STL: ASCII keeps 6 digits.
  const auto execute = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"openscad", "-o", stl.string(), "--export-format", "binstl"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--check-parameters=true", "--check-parameter-ranges=true", script.string()});
    return run_confined(words, {options.seconds, options.memory_mb, most_file_mb}, reach, context);
  };
  auto run = execute({"--hardwarnings"});
  // It ends with the first warning, also where that is none of the script's.
  if (run.ok() && run->exit_code != 0 && run->err.find(its_own_warning) != std::string::npos) run = execute({});
  if (!run.ok()) return run.error();
  evaluation.seconds = run->seconds;
  if (run->timed_out)
    return Error{"openscad did not finish '" + path.filename().string() + "' within " +
                     std::to_string(static_cast<long>(options.seconds)) + " s",
                 ErrorKind::stopped};
  evaluation.complaints = complaints_in(run->err, script.filename().string());
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
  double largest = 0;
  for (const auto& v : evaluation.mesh.vertices) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  evaluation.error = largest * single_precision;
  return evaluation;
}

/// Evaluates a script whose drawing lies far from the origin near it, and moves the result back in double precision;
/// nothing where that fails.
std::optional<Evaluation> run_near_origin(const Path& path, const std::vector<Path>& files, const Evaluation& far_away,
                                          const EvaluateOptions& options, Context& context) {
  Vec3 far = far_away.mesh.bounds().center();
  for (int k = 0; k < 3; ++k) far[k] = std::round(far[k]);
  const auto text = read_file(path);
  if (!text.ok()) return {};
  const auto folder = TemporaryDirectory::make();
  if (!folder) return {};
  const Path moved = folder->path() / path.filename();
  if (!write_file(moved, moved_script(path, *text, far)).ok()) return {};
  Evaluation named;
  named.backend = far_away.backend, named.program = far_away.program, named.version = far_away.version;
  auto result = run_script(moved, files, std::move(named), options, context);
  if (!result.ok() || result->failed || result->mesh.empty()) return {};
  for (auto& v : result->mesh.vertices) v += far;
  result->seconds += far_away.seconds;
  return std::move(*result);
}

}  // namespace

std::vector<Path> openscad_folders() {
  std::vector<Path> folders;
  const char *named = std::getenv("OPENSCADPATH"), *home = std::getenv("HOME");
  std::istringstream list(named ? named : "");
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) folders.push_back(std::filesystem::absolute(folder));
  if (home && *home == '/')
    for (const char* own : {".local/share/OpenSCAD", ".local/share/fonts", ".fonts"})
      folders.push_back(Path(home) / own);
  return folders;
}

Result<std::string> openscad_version(const EvaluateOptions& options, Context& context) {
  const auto answer = run_process({"openscad", "--version"}, {30, options.memory_mb}, context);
  if (!answer.ok()) return answer.error();
  std::istringstream words(answer->err + " " + answer->out);  // "OpenSCAD version 2021.01", on standard error
  for (std::string word; words >> word;)
    if (word.find_first_of("0123456789") == 0) return word;
  return std::string();
}

Result<Evaluation> evaluate_openscad(const Path& path, const EvaluateOptions& options, Context& context) {
  Evaluation evaluation;
  evaluation.backend = "openscad";
  evaluation.program = "openscad";
  const auto version = openscad_version(options, context);
  if (!version.ok()) return version.error();
  evaluation.version = *version;

  const auto files = files_of_script(std::filesystem::absolute(path));
  auto result = run_script(path, files, std::move(evaluation), options, context);
  if (!result.ok() || result->failed || result->mesh.empty()) return result;
  const double size = result->mesh.bounds().diagonal();
  if (result->error > options.tolerance / 100 && result->error > 10 * size * single_precision)
    if (auto nearer = run_near_origin(path, files, *result, options, context)) return std::move(*nearer);
  return result;
}

std::string finer_openscad(int sides) { return "raise $fn to " + std::to_string(sides); }

}  // namespace partscribe::verify
