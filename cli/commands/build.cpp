/// build: from scans to a verified procedure in one go.
#include <memory>
#include <optional>

#include "cli/commands.h"
#include "cli/commands/build_json.h"
#include "cli/commands/stages.h"
#include "cli/commands/views.h"
#include "cli/commands/wider.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/names.h"
#include "cli/report/report_page.h"
#include "cli/result_folder.h"
#include "core/number.h"
#include "fit/procedures.h"
#include "geometry/io/read_geometry.h"
#include "geometry/normals/normals.h"
#include "model/json.h"
#include "scan/filter/background.h"

namespace partscribe::cli {
namespace {

constexpr const char* build_help =
    R"(Examples
  partscribe build bracket.ply                            writes bracket-partscribe/
  partscribe build bracket.stl --tolerance 0.1            within 0.1 mm everywhere, or it says so
  partscribe build view1.ply view2.ply --units inch       several views in one common frame, inches
  partscribe build scan.json --to openscad,step --out cad  range images with poses; two kinds of file
  partscribe build scan.json --poses guess                rough poses: the views are registered first
  partscribe build worn.ply --no-nominal                  the measured sizes, nothing rounded to nominal ones
  partscribe build pin.ply --procedure revolve            only a surface of revolution

Reads point clouds, meshes (PLY STL OBJ OFF 3MF PCD XYZ VTK) and range images (scan.json, .conf, 16-bit PNG or PGM
with a sidecar). Writes into DIR: cloud.ply model.json part.scad part.scl prelude.scl part.igs part.step verdict.json
report.html. Every artifact is run by its own program and compared with the scan; the exit code is the verdict.)";

struct BuildArguments {
  std::vector<Path> scans;
  std::vector<std::string> to;
  FitArguments fit;
  PoseArguments poses;
  std::string filter = "none";  ///< none, rlts, profile
  Path templates, pictures;
};

/// What a build wrote, the artifacts first.
std::vector<Path> files_in(const Path& folder) {
  auto names = artifact_names();
  for (const char* file : {"model.json", "cloud.ply", "poses.json", "verdict.json", "report.html"})
    names.push_back(file);
  std::vector<Path> files;
  for (const auto& name : names)
    if (std::filesystem::exists(folder / name)) files.push_back(folder / name);
  return files;
}

/// What build says at the end.
void print_result(const Model& model, const Verdict& verdict, const Path& folder, Session& session) {
  session.print("\n" + found_lines(model));
  if (const auto dimensions = dimension_table(model); !dimensions.empty()) session.print("\n" + dimensions);
  for (const auto& u : model.unexplained)
    session.print("Unexplained: " + u.reason + " (" + readable(u.area) + " mm2, " + std::to_string(u.points) +
                  " points)\n");
  session.print("\n" + verdict_table(verdict));
  std::string names;
  for (const auto& file : files_in(folder)) names += " " + file.filename().string();
  session.print("\nFiles in " + folder.string() + ":" + names + "\n");
  session.print("Open " + (folder / "report.html").string() + " for pictures and reasons.\n");
  session.print(seconds_line(session) + "\n");
}

/// A sensor's picture of a part among other things is no scan of one part. Asked only where no verdict holds: a plate
/// of which one side was scanned, with bosses, looks like a table as well. Empty where nothing stands on a plane, or
/// where the plane is the body's own: the scan goes on behind it, or shows it under what stands there.
std::string scene_hint(const Path& input, const std::string& units, const Scan& scan, int threads) {
  if (scan.views.size() > 1 || !scan.mesh.empty()) return "";
  Context context;  // the stages are over
  context.threads = threads;
  PointCloud cloud = scan.cloud;
  const SamplingSummary sampling = estimate_normals(cloud, {}, context);
  const auto found = cut_background(cloud, sampling.sigma, sampling.spacing, 1);
  if (!found || 2 * found->behind > found->above || 2 * found->covered > found->support) return "";
  const auto things = found->things.size();
  return (things == 1 ? "Something stands" : std::to_string(things) + " things stand") +
         " on a plane in this scan. If that is a table, partscribe scan " + input.string() +
         (units.empty() ? "" : " --units " + units) + " --on-table 1 cuts the largest out for build.\n";
}

/// A format that has no such body is a row of the verdict, and none that is verified.
void add_unwritten(Verdict& verdict, const Emitted& emitted) {
  for (const auto& [file, backend, reason] : emitted.failures) {
    ArtifactVerdict& row = verdict.artifacts.emplace_back();
    row.file = file, row.backend = backend;
    row.verdict = verdict.verdict = Outcome::out_of_tolerance;
    row.reasons.push_back("it cannot be written: " + reason);
  }
}

/// "part.scad: hole 1: 0.3 mm too far in +x ...".
std::string first_fault(const Verdict& verdict) {
  for (const auto& a : verdict.artifacts) {
    if (a.verdict != Outcome::out_of_tolerance) continue;
    for (const auto& f : a.findings)
      if (f.kind != Finding::Kind::not_scanned) return a.file + ": " + f.text;
    if (!a.reasons.empty()) return a.file + ": " + a.reasons.front();
  }
  return "its files differ";
}

/// A model, written and judged.
struct Trial {
  std::string model;  ///< its model.json
  std::string procedure;
  Emitted emitted;
  Verdict verdict;
};

/// Every model that the fit offers is written, run and judged before it becomes the answer.
struct Trials {
  const Scan& scan;
  const std::vector<std::string>& backends;
  const Path& templates;
  const Path folder;
  double tolerance;
  Session& session;
  std::vector<Trial> tried;

  Result<const Trial*> of(const CheckedModel& model) {
    std::string text = write_model_json(*model);
    for (const Trial& known : tried)
      if (known.model == text) return &known;
    if (auto ok = session.stage("write"); !ok) return ok.error();
    auto emitted = emit_all(model, backends, templates, session);
    if (!emitted) return emitted.error();
    const auto scripts = write_artifacts(emitted->artifacts, folder);
    if (!scripts) return scripts.error();
    if (auto ok = session.stage("verify"); !ok) return ok.error();
    Verdict verdict;
    if (!scripts->empty()) {
      VerifyOptions options;
      options.tolerance = tolerance;
      options.outlier_rate = std::max(options.outlier_rate, outlier_rate_of(*model));
      auto judged = verify_artifacts(*scripts, scan, *model, options, session.context);
      if (!judged) return judged.error();
      verdict = std::move(*judged);
    }
    add_unwritten(verdict, *emitted);
    tried.push_back({std::move(text), procedure_of(*model), std::move(*emitted), std::move(verdict)});
    return &tried.back();
  }

  /// The first thing that is wrong with a model; nothing if it is verified, or if the scan or a missing program keeps
  /// it from being so.
  Result<std::string> refusal(const CheckedModel& model) {
    const auto trial = of(model);
    if (!trial) return trial.error();
    std::string reason;
    if ((*trial)->verdict.verdict == Outcome::out_of_tolerance) reason = first_fault((*trial)->verdict);
    if (!reason.empty() && !std::holds_alternative<TriSurface>(model->objects.back().shape))
      session.print("Tried " + procedure_text(*model) + ": " + reason + ".\n");
    if (auto ok = session.stage("fit"); !ok) return ok.error();
    return reason;
  }
};

/// A procedure and the tolerance at which this very build would verify it, where nothing is verified now or all that is
/// is a triangulation. `as_read`: the scan's points as they were before the fit.
Result<std::optional<Wider>> wider_procedure(const Trials& trials, const Model& model, const PointCloud& as_read,
                                             const std::string& name, const FitArguments& fit, Session& session) {
  const double reach = useful_reach(as_read.bounds().diagonal());
  std::vector<Wider> proposals;
  if (const Rival* nearest = nearest_procedure(model))
    proposals.push_back({procedure_word(nearest->procedure), tolerance_that_lets(nearest->deviation)});
  for (const Trial& trial : trials.tried)
    if (auto wider = wider_for(trial.procedure, trial.verdict, reach)) proposals.push_back(std::move(*wider));
  return first_verified(std::move(proposals), reach, [&](const Wider& wider) -> Result<std::optional<Verdict>> {
    FitArguments only = fit;
    only.procedure = wider.procedure;
    Scan again = trials.scan;
    again.cloud = as_read;
    const auto aside = TemporaryDirectory::make();
    if (!aside) return aside.error();
    Trials alone{again, trials.backends, trials.templates, aside->path(), wider.tolerance, session, {}};
    if (auto ok = session.stage("fit"); !ok) return ok.error();
    const auto fitted = fit_stage(again, wider.tolerance, name, only, session);
    if (!fitted) return fitted.error();
    if ((*fitted)->fallback) return std::optional<Verdict>();
    const auto trial = alone.of(*fitted);
    if (!trial) return trial.error();
    return std::optional((*trial)->verdict);
  });
}

/// Reads, fits, writes and judges into `results`, whose files are `name`'s. `reads_cloud`: the cloud there is an input
/// and stays.
Result<int> work(const BuildArguments& arguments, const std::vector<std::string>& backends, const std::string& name,
                 bool reads_cloud, ResultFolder& results, Session& session) {
  const Path& folder = results.path();
  const bool registers = arguments.poses.poses != "given";
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto placed =
      read_views(arguments.scans, arguments.poses, arguments.filter == "none" ? Points::measured : Points::flagged,
                 session, arguments.filter == "profile" ? RltsForm::profile : RltsForm::combined);
  if (!placed) return placed.error();
  Scan* const scan = &placed->scan;
  if (auto ok = make_folder(folder); !ok) return ok.error();
  const auto tolerance = tolerance_for(*scan, session);
  session.print(
      "Read " + std::to_string(scan->cloud.size()) + " points" +
      (scan->mesh.empty() ? "" : " of a mesh with " + std::to_string(scan->mesh.triangles.size()) + " triangles") +
      " in " + std::to_string(scan->views.size()) + (scan->views.size() == 1 ? " view" : " views") + "; " +
      tolerance.reason + ".\n");
  if (placed->filter.rejected > 0)
    session.print("Set aside " + std::to_string(placed->filter.rejected) + " of " +
                  std::to_string(placed->filter.returns) + " returns of range images as outliers.\n");

  if (auto ok = session.stage("fit"); !ok) return ok.error();
  // Away from the folder of the results, which are written when the answer is known.
  const auto aside = TemporaryDirectory::make();
  if (!aside) return aside.error();
  Trials trials{*scan, backends, arguments.templates, aside->path(), tolerance.tolerance, session, {}};
  const bool any_other = arguments.fit.procedure.empty();
  const PointCloud as_read = scan->cloud;
  const auto model =
      fit_stage(*scan, tolerance.tolerance, name, arguments.fit, session,
                any_other ? Refusal([&](const CheckedModel& m) { return trials.refusal(m); }) : Refusal());
  if (!model) return model.error();
  const auto trial = trials.of(*model);
  if (!trial) return trial.error();
  const Verdict& verdict = (*trial)->verdict;
  if (auto ok = session.stage("write"); !ok) return ok.error();
  if (auto ok = results.begin(); !ok) return ok.error();
  std::string cloud_sha256;
  if (!reads_cloud) {
    const std::string cloud = write_cloud_ply(scan->cloud);
    if (auto ok = write_file(folder / "cloud.ply", cloud); !ok) return ok.error();
    if (registers) cloud_sha256 = sha256(cloud);
  }
  if (registers)
    if (auto ok = write_file(folder / "poses.json", poses_json(*placed, cloud_sha256)); !ok) return ok.error();
  if (auto ok = write_file(folder / "model.json", (*trial)->model); !ok) return ok.error();
  if (auto ok = results.mark(); !ok) return ok.error();
  session.if_cancelled(results.left());
  const auto scripts = write_artifacts((*trial)->emitted.artifacts, folder);
  if (!scripts) return scripts.error();
  if (auto ok = results.mark(); !ok) return ok.error();
  session.if_cancelled(results.left());
  const std::string json = write_verdict_json(verdict);
  if (auto ok = write_file(folder / "verdict.json", json); !ok) return ok.error();

  if (auto ok = session.stage("report"); !ok) return ok.error();
  const std::optional<Model> reported = **model;
  const auto scene = report_scene(reported, verdict, scan->cloud, session.context);
  const auto pictures = draw_report(scene, session.context);
  const auto page = report_page(
      {name, reported, verdict, scene, pictures, read_scripts(*scripts), {}, scan->warnings, session.version});
  if (auto ok = write_file(folder / "report.html", page); !ok) return ok.error();
  if (!arguments.pictures.empty())
    if (auto drawn = write_pictures(pictures, arguments.pictures, session.options.force); !drawn) return drawn.error();
  session.finish_stage();

  session.if_cancelled("");
  print_result(**model, verdict, folder, session);
  if (verdict.verdict == Outcome::out_of_tolerance)
    session.print(scene_hint(arguments.scans.front(), session.options.units, *scan, session.context.threads));
  session.print(no_procedure_line(**model, arguments.fit.procedure));
  std::optional<Wider> wider;
  const bool heard = !session.options.quiet || session.options.json;
  if (heard && ((*model)->fallback || verdict.verdict == Outcome::out_of_tolerance)) {
    // The files are whole: what stops this search takes nothing from them.
    if (auto found = wider_procedure(trials, **model, as_read, name, arguments.fit, session)) wider = std::move(*found);
    session.finish_stage();
  }
  if (wider)
    session.print("Try --procedure " + wider->procedure + " --tolerance " + print_number(wider->tolerance) +
                  ": that was tried and is verified.\n");
  session.print_json(build_json(**model, arguments.fit.procedure, wider, json, files_in(folder), scan->warnings));
  return exit_code_of(verdict.verdict);
}

Result<int> run_build(const BuildArguments& arguments, Session& session) {
  const auto backends = chosen_backends(arguments.to);
  if (!backends) return backends.error();
  const Path named_after = arguments.fit.name.empty() ? arguments.scans.front() : Path(arguments.fit.name);
  // A build starts from scans, so an earlier run's cloud.ply is an input like any other: its folder is its own.
  const Path folder = output_folder(session.options, arguments.scans.front(), named_after);
  std::error_code ignored;
  bool reads_cloud = false;
  for (const auto& scan : arguments.scans)
    reads_cloud = reads_cloud || std::filesystem::equivalent(scan, folder / "cloud.ply", ignored);
  auto outputs = artifact_names();
  for (const char* file : {"model.json", "verdict.json", "report.html"}) outputs.push_back(file);
  if (arguments.poses.poses != "given" || !reads_cloud) outputs.push_back("poses.json");
  if (!reads_cloud) outputs.push_back("cloud.ply");
  ResultFolder results(folder, outputs, "build", arguments.scans);
  if (auto ok = check_same_part(session.options, folder, arguments.scans); !ok) return ok.error();
  if (auto ok = results.check(session.options.force); !ok) return ok.error();
  if (!arguments.pictures.empty())
    if (auto ok = check_overwriting(arguments.pictures, {"scan.png"}, session.options.force); !ok) return ok.error();
  return results.close(work(arguments, *backends, part_name(named_after), reads_cloud, results, session));
}

}  // namespace

Command build_command() {
  auto arguments = std::make_shared<BuildArguments>();
  return {"build", "read scans, find the procedure, write it for every CAD system, verify it, report", build_help,
          [arguments](Arguments& a) {
            a.paths(arguments->scans, "scan", "scan files of one part");
            declare(arguments->poses, a);
            a.choice(arguments->filter, "--filter", {"none", "rlts", "profile"},
                     "what tells outliers of range images before the fit: nothing, for the fit does so itself; or "
                     "reweighted least trimmed squares in windows, or through five samples of a row as published in "
                     "1993, which also take walls of one pixel");
            a.list(arguments->to, "--to", "LIST", "which of openscad,alpha1,iges,step to write (default: all)");
            a.text(arguments->fit.name, "--name", "NAME", "name of the part (default: from the first file)");
            a.flag(arguments->fit.no_nominal, "--no-nominal",
                   "keep every measured value; else a nominal size is taken where the data cannot tell the difference");
            declare_procedure(arguments->fit, a);
            a.path(arguments->templates, "--templates", "DIR",
                   "a folder of template packs in place of the built-in ones");
            declare_pictures(arguments->pictures, a);
          },
          [arguments](Session& session) { return run_build(*arguments, session); }};
}

}  // namespace partscribe::cli
