/// simulate: what a range scanner would deliver of a known shape.
#include "scan/simulate/simulate.h"

#include <cmath>
#include <memory>

#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/names.h"
#include "core/number.h"
#include "verify/evaluate/evaluate.h"

namespace partscribe::cli {
namespace {

constexpr const char* simulate_help =
    R"(Examples
  partscribe simulate pin.stl --sigma 0.02                            6 views with 0.02 mm of noise
  partscribe simulate model.json --views 12 --resolution 512          more and finer views of a model
  partscribe simulate part.scad --sigma-codes 4 --bit-error 0.001     the noise of the 1993 paper
  partscribe simulate part.step --views cube --outliers 0.01 --mixed 0.3 --seed 7

Reads a model.json, a mesh, or a .scad .scl .igs .step file (run by its own program). Writes into DIR a scan that any
command reads: view_NN.png (16-bit range images), scan.json (poses and how codes become millimetres), merged.ply. The
same seed gives the same bytes.)";

struct SimulateArguments {
  Path shape;
  SimulateOptions simulate;
  double sigma_codes = 0;
  int seed = 1;
  bool pinhole = false, no_merged = false;
  double pose_noise_deg = 0;
};

/// A shape to look at, and what must live as long as it does.
struct Subject {
  std::shared_ptr<const Model> model;
  std::shared_ptr<const TriangleMesh> mesh;
  Surface surface;
};

Result<Subject> subject_of(const Path& shape, Session& session) {
  if (shape.extension() == ".json") {
    const auto model = read_model(shape);
    if (!model) return model.error();
    const auto kept = std::make_shared<const Model>(**model);
    return Subject{kept, nullptr, surface_of(*kept)};
  }
  EvaluateOptions options;
  if (session.options.tolerance) options.tolerance = *session.options.tolerance;
  auto evaluation = evaluate_artifact(shape, options, session.context);
  if (!evaluation) return evaluation.error();
  if (evaluation->failed || evaluation->mesh.empty())
    return bad_input(shape.string() + ": expected a shape, but " + evaluation->program + " said: " +
                     (evaluation->complaints.empty() ? "nothing came out" : evaluation->complaints.front()));
  const auto kept = std::make_shared<const TriangleMesh>(std::move(evaluation->mesh));
  return Subject{nullptr, kept, surface_of(*kept)};
}

Result<int> run_simulate(const SimulateArguments& given, Session& session) {
  SimulateOptions options = given.simulate;
  if (!viewpoints(options.views))
    return usage_error(
        "--views: expected tetrahedron, octahedron, cube, icosahedron, dodecahedron or a number, found '" +
        options.views + "'");
  if (given.sigma_codes > 0 && options.sigma > 0)
    return usage_error("--sigma and --sigma-codes say the same thing in two units: give one of them");
  const Path folder = session.options.out.empty() ? Path(folder_name(given.shape) + "-scan") : session.options.out;
  if (auto ok = check_overwriting(folder, {"scan.json", "merged.ply"}, session.options.force); !ok) return ok.error();

  if (auto ok = session.stage("shape"); !ok) return ok.error();
  const auto subject = subject_of(given.shape, session);
  if (!subject) return subject.error();
  if (auto ok = make_folder(folder); !ok) return ok.error();
  options.seed = static_cast<std::uint64_t>(given.seed);
  options.pose_noise_angle = radians(given.pose_noise_deg);
  if (given.pinhole) options.projection = Projection::pinhole;
  if (auto ok = session.stage("simulate"); !ok) return ok.error();
  if (given.sigma_codes > 0) options.sigma = given.sigma_codes * code_step(subject->surface, options);
  const auto scan = simulate(subject->surface, options, session.context);
  if (session.context.cancelled) return Error{"cancelled while simulating", ErrorKind::stopped};
  if (auto ok = session.stage("write"); !ok) return ok.error();
  std::vector<Path> written;
  for (const auto& file : files_of(scan, options)) {
    if (given.no_merged && file.name == "merged.ply") continue;
    if (auto ok = write_file(folder / file.name, file.bytes); !ok) return ok.error();
    written.push_back(folder / file.name);
  }
  session.finish_stage();
  std::size_t returns = 0, errors = 0;
  for (const auto& view : scan.views) returns += view.returns, errors += view.bit_errors;
  session.print("Simulated " + std::to_string(scan.views.size()) + " views with " + std::to_string(returns) +
                " returns, noise " + readable(options.sigma) + " mm, " + std::to_string(errors) +
                " bit errors; files in " + folder.string() + "; next: partscribe build " + folder.string() + "\n");
  session.print_json(summary_json("simulate", written, {}));
  return 0;
}

}  // namespace

Command simulate_command() {
  auto given = std::make_shared<SimulateArguments>();
  return {"simulate", "scan a known shape: a seeded range scanner with noise", simulate_help,
          [given](Arguments& a) {
            auto& s = given->simulate;
            a.operand(given->shape, "shape", "model.json, a mesh, or a .scad .scl .igs .step file");
            a.text(s.views, "--views", "SET",
                   "tetrahedron, octahedron, cube, icosahedron, dodecahedron or a number; more views see more of the "
                   "surface (default octahedron)");
            a.count(s.resolution, "--resolution", "PIXELS", 4, 4096, "of each square image (default 256)");
            a.number(s.sigma, "--sigma", "MM", 0, 1000, "noise along the line of sight (default 0)");
            a.number(given->sigma_codes, "--sigma-codes", "CODES", 0, 10000, "the same in range codes");
            a.number(s.bit_error, "--bit-error", "P", 0, 1, "share of codes with one flipped bit (default 0)");
            a.count(s.bits, "--bits", "12|16", 12, 16, "of a range code (default 16)");
            a.number(s.outliers, "--outliers", "SHARE", 0, 1, "pixels with a random range (default 0)");
            a.number(s.mixed, "--mixed", "P", 0, 1, "chance of a mixed pixel at a depth step (default 0)");
            a.flag(given->pinhole, "--pinhole", "a pinhole camera in place of parallel rays");
            a.number(given->pose_noise_deg, "--pose-noise-angle", "DEG", 0, 180,
                     "error of the stated first guess of each pose");
            a.number(s.pose_noise_shift, "--pose-noise-shift", "MM", 0, 1e6, "the same, of the position");
            a.count(given->seed, "--seed", "N", 0, 2147483647, "of the random numbers (default 1)");
            a.flag(given->no_merged, "--no-merged", "leave out merged.ply, which repeats what the images contain");
          },
          [given](Session& session) { return run_simulate(*given, session); }};
}

}  // namespace partscribe::cli
