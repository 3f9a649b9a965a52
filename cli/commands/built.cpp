#include "cli/commands/built.h"

#include "cli/commands/build_json.h"
#include "cli/describe.h"
#include "cli/report/report_page.h"
#include "fit/procedures.h"
#include "geometry/io/read_geometry.h"
#include "model/json.h"

namespace partscribe::cli {
namespace {

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

/// Every model that the fit offers is written, run and judged before it becomes the answer.
struct Trials {
  const Scan& scan;
  const BuildRequest& request;
  const Path folder;
  Session& session;
  std::vector<Trial> tried;

  /// Its place among those that were tried.
  Result<std::size_t> of(const CheckedModel& model) {
    std::string text = write_model_json(*model);
    for (std::size_t i = 0; i < tried.size(); ++i)
      if (tried[i].model == text) return i;
    if (auto ok = session.stage("write"); !ok) return ok.error();
    auto emitted = emit_all(model, request.backends, request.templates, session);
    if (!emitted) return emitted.error();
    const auto scripts = write_artifacts(emitted->artifacts, folder);
    if (!scripts) return scripts.error();
    if (auto ok = session.stage("verify"); !ok) return ok.error();
    Verdict verdict;
    if (!scripts->empty()) {
      VerifyOptions options;
      options.tolerance = request.tolerance;
      options.outlier_rate = std::max(options.outlier_rate, outlier_rate_of(*model));
      auto judged = verify_artifacts(*scripts, scan, *model, options, session.context);
      if (!judged) return judged.error();
      verdict = std::move(*judged);
    }
    add_unwritten(verdict, *emitted);
    tried.push_back({std::move(text), procedure_of(*model), std::move(*emitted), std::move(verdict)});
    return tried.size() - 1;
  }

  /// The first thing that is wrong with a model; nothing if it is verified, or if the scan or a missing program keeps
  /// it from being so.
  Result<std::string> refusal(const CheckedModel& model) {
    const auto place = of(model);
    if (!place) return place.error();
    const Verdict& verdict = tried[*place].verdict;
    std::string reason;
    if (verdict.verdict == Outcome::out_of_tolerance) reason = first_fault(verdict);
    if (!reason.empty() && !std::holds_alternative<TriSurface>(model->objects.back().shape))
      session.print("Tried " + procedure_text(*model) + ": " + reason + ".\n");
    if (auto ok = session.stage("fit"); !ok) return ok.error();
    return reason;
  }
};

}  // namespace

Result<BuiltPart> build_part(Scan& scan, const BuildRequest& request, Session& session) {
  if (auto ok = session.stage("fit"); !ok) return ok.error();
  // Away from the folder of the results, which are written when the answer is known.
  const auto aside = TemporaryDirectory::make();
  if (!aside) return aside.error();
  Trials trials{scan, request, aside->path(), session, {}};
  const bool any_other = request.fit.procedure.empty();
  auto model = fit_stage(scan, request.tolerance, request.name, request.fit, session,
                         any_other ? Refusal([&](const CheckedModel& m) { return trials.refusal(m); }) : Refusal());
  if (!model) return model.error();
  const auto answer = trials.of(*model);
  if (!answer) return answer.error();
  return BuiltPart{std::move(*model), std::move(trials.tried), *answer};
}

Result<std::optional<Wider>> wider_procedure(const BuiltPart& built, const Scan& scan, const PointCloud& as_read,
                                             const BuildRequest& request, Session& session) {
  const double reach = useful_reach(as_read.bounds().diagonal());
  std::vector<Wider> proposals;
  if (const Rival* nearest = nearest_procedure(*built.model))
    proposals.push_back({procedure_word(nearest->procedure), tolerance_that_lets(nearest->deviation)});
  for (const Trial& trial : built.tried)
    if (auto wider = wider_for(trial.procedure, trial.verdict, reach)) proposals.push_back(std::move(*wider));
  return first_verified(std::move(proposals), reach, [&](const Wider& wider) -> Result<std::optional<Verdict>> {
    BuildRequest only = request;
    only.tolerance = wider.tolerance;
    only.fit.procedure = wider.procedure;
    Scan again = scan;
    again.cloud = as_read;
    const auto aside = TemporaryDirectory::make();
    if (!aside) return aside.error();
    Trials alone{again, only, aside->path(), session, {}};
    if (auto ok = session.stage("fit"); !ok) return ok.error();
    const auto fitted = fit_stage(again, only.tolerance, only.name, only.fit, session);
    if (!fitted) return fitted.error();
    if ((*fitted)->fallback) return std::optional<Verdict>();
    const auto place = alone.of(*fitted);
    if (!place) return place.error();
    return std::optional(std::move(alone.tried[*place].verdict));
  });
}

BuildFolder build_folder(const Path& folder, const std::vector<Path>& scans, bool registers) {
  std::error_code ignored;
  bool reads_cloud = false;
  for (const auto& scan : scans)
    reads_cloud = reads_cloud || std::filesystem::equivalent(scan, folder / "cloud.ply", ignored);
  auto outputs = artifact_names();
  for (const char* file : {"model.json", "verdict.json", "report.html"}) outputs.push_back(file);
  if (registers || !reads_cloud) outputs.push_back("poses.json");
  if (!reads_cloud) outputs.push_back("cloud.ply");
  return {ResultFolder(folder, outputs, "build", scans), reads_cloud, registers};
}

Result<std::vector<ReportPicture>> write_built(const BuiltPart& built, const PlacedViews& placed, BuildFolder& into,
                                               Session& session) {
  ResultFolder& results = into.results;
  const Path& folder = results.path();
  const Scan& scan = placed.scan;
  const Trial& trial = built.trial();
  if (auto ok = session.stage("write"); !ok) return ok.error();
  if (auto ok = results.begin(); !ok) return ok.error();
  std::string cloud_sha256;
  if (!into.reads_cloud) {
    const std::string cloud = write_cloud_ply(scan.cloud);
    if (auto ok = write_file(folder / "cloud.ply", cloud); !ok) return ok.error();
    if (into.registers) cloud_sha256 = sha256(cloud);
  }
  if (into.registers)
    if (auto ok = write_file(folder / "poses.json", poses_json(placed, cloud_sha256)); !ok) return ok.error();
  if (auto ok = write_file(folder / "model.json", trial.model); !ok) return ok.error();
  if (auto ok = results.mark(); !ok) return ok.error();
  session.if_cancelled(results.left());
  const auto scripts = write_artifacts(trial.emitted.artifacts, folder);
  if (!scripts) return scripts.error();
  if (auto ok = results.mark(); !ok) return ok.error();
  session.if_cancelled(results.left());
  if (auto ok = write_file(folder / "verdict.json", write_verdict_json(trial.verdict)); !ok) return ok.error();

  if (auto ok = session.stage("report"); !ok) return ok.error();
  const std::optional<Model> reported = *built.model;
  const auto scene = report_scene(reported, trial.verdict, scan.cloud, session.context);
  auto pictures = draw_report(scene, session.context);
  const auto page = report_page({reported->name,
                                 reported,
                                 trial.verdict,
                                 scene,
                                 pictures,
                                 read_scripts(*scripts),
                                 {},
                                 scan.warnings,
                                 session.version});
  if (auto ok = write_file(folder / "report.html", page); !ok) return ok.error();
  session.finish_stage();
  session.if_cancelled("");
  return pictures;
}

/// What a build wrote, the artifacts first.
std::vector<Path> built_files(const Path& folder) {
  auto names = artifact_names();
  for (const char* file : {"model.json", "cloud.ply", "poses.json", "verdict.json", "report.html"})
    names.push_back(file);
  std::vector<Path> files;
  for (const auto& name : names)
    if (std::filesystem::exists(folder / name)) files.push_back(folder / name);
  return files;
}

}  // namespace partscribe::cli
