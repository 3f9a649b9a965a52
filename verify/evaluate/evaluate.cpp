#include "verify/evaluate/evaluate.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "geometry/io/read_geometry.h"
#include "verify/evaluate/run_occt.h"
#include "verify/evaluate/run_openscad.h"
#include "verify/evaluate/solid.h"

namespace partscribe::verify {
namespace {

/// How many mm one unit is, by the name that a file gives it; 3MF's names.
double millimetres_in(const std::string& unit) {
  if (unit == "micron") return 0.001;
  if (unit == "centimeter") return 10;
  if (unit == "inch") return 25.4;
  if (unit == "foot") return 304.8;
  if (unit == "meter") return 1000;
  return 1;
}

Result<Evaluation> evaluate_mesh_file(const Path& path, const EvaluateOptions&, Context& context) {
  const auto raw = read_geometry(path, context);
  if (!raw.ok()) return raw.error();
  if (raw->mesh.empty())
    return bad_input("'" + path.filename().string() + "' was expected to hold a mesh, but it holds " +
                     std::to_string(raw->cloud.size()) + " points and no triangles");
  Evaluation evaluation;
  evaluation.backend = "mesh";
  evaluation.program = "partscribe";
  evaluation.version = raw->format;
  TriangleMesh mesh = raw->mesh;
  const double scale = millimetres_in(raw->unit);
  for (auto& v : mesh.vertices) v *= scale;
  auto check = check_solid(mesh);
  evaluation.mesh = std::move(check.mesh);
  evaluation.solid = check.solid;
  evaluation.complaints = std::move(check.faults);
  return evaluation;
}

std::string finer_mesh(int) { return "export it with finer facets"; }

struct Runner {
  std::string_view suffix;
  bool cad;
  Result<Evaluation> (*evaluate)(const Path&, const EvaluateOptions&, Context&);
  std::string (*finer)(int sides) = nullptr;  // null: circles are exact
};

constexpr std::array runners = {
    Runner{".scad", true, evaluate_openscad, finer_openscad},
    Runner{".scl", true, evaluate_alpha1},
    Runner{".igs", true, evaluate_iges},
    Runner{".iges", true, evaluate_iges},
    Runner{".step", true, evaluate_step},
    Runner{".stp", true, evaluate_step},
    Runner{".stl", false, evaluate_mesh_file, finer_mesh},
    Runner{".off", false, evaluate_mesh_file, finer_mesh},
    Runner{".obj", false, evaluate_mesh_file, finer_mesh},
    Runner{".3mf", false, evaluate_mesh_file, finer_mesh},
    Runner{".ply", false, evaluate_mesh_file, finer_mesh},
};

/// Null if no program evaluates such files.
const Runner* runner_of(const Path& path) {
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const auto found = std::ranges::find(runners, suffix, &Runner::suffix);
  return found == runners.end() ? nullptr : &*found;
}

}  // namespace

bool is_cad_file(const Path& path) {
  const Runner* runner = runner_of(path);
  return runner && runner->cad;
}

Result<Evaluation> evaluate_artifact(const Path& path, const EvaluateOptions& options, Context& context) {
  if (const Runner* runner = runner_of(path)) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return bad_input("artifact '" + path.string() + "' is no file");
    return runner->evaluate(path, options, context);
  }
  std::string known;
  for (const auto& runner : runners) known += (known.empty() ? "" : " ") + std::string(runner.suffix);
  return usage_error("'" + path.filename().string() + "' cannot be evaluated: expected one of " + known);
}

std::string how_to_draw_finer(const Path& path, int sides) {
  const Runner* runner = runner_of(path);
  return runner && runner->finer ? runner->finer(sides) : "";
}

}  // namespace partscribe::verify
