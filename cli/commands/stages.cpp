#include "cli/commands/stages.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/inputs.h"
#include "cli/suggest.h"
#include "codegen/emit.h"
#include "codegen/exchange/brep.h"
#include "core/json_text.h"
#include "core/number.h"
#include "fit/build.h"
#include "fit/procedures.h"
#include "geometry/normals/normals.h"

namespace partscribe::cli {
namespace {

constexpr const char* stem = "part";

std::string file_of(const std::string& backend) {
  for (const auto& b : backends())
    if (b.name == backend) return stem + b.suffix;
  return backend;
}

}  // namespace

void declare_procedure(FitArguments& arguments, Arguments& options) {
  std::string all;
  for (const auto& word : procedure_words()) all += (all.empty() ? "" : ", ") + word;
  options.choice(arguments.procedure, "--procedure", "NAME", procedure_words(),
                 {"the name of a rival as explain prints it", is_procedure},
                 "only this procedure: " + all + " (default: the best)");
}

Result<CheckedModel> fit_stage(Scan& scan, double tolerance, const std::string& name, const FitArguments& arguments,
                               Session& session, const Refusal& refusal) {
  // Only what changes the model: neither folders nor threads.
  const auto stamped = [&](const CheckedModel& built) {
    Model model = *built;
    model.provenance.version = session.version;
    model.provenance.options = "--tolerance " + print_number(tolerance) + " --name " + name;
    if (!session.options.units.empty()) model.provenance.options += " --units " + session.options.units;
    if (arguments.no_nominal) model.provenance.options += " --no-nominal";
    if (!arguments.procedure.empty()) model.provenance.options += " --procedure " + arguments.procedure;
    return checked(std::move(model), "the fitted model");
  };
  BuildOptions options;
  options.tolerance = tolerance;
  options.name = name;
  options.nominal = !arguments.no_nominal;
  options.force = arguments.procedure;
  if (refusal)
    options.refusal = [&](const CheckedModel& model) -> Result<std::string> {
      const auto whole = stamped(model);
      return whole ? refusal(*whole) : Result<std::string>(whole.error());
    };
  const auto built = build_model(scan, options, session.context);
  return built ? stamped(*built) : built;
}

Result<MeasuredPart> measure_stage(Scan& scan, double tolerance, Session& session) {
  constexpr std::size_t least_points = 50;  // of a cloud
  if (scan.mesh.empty() && scan.cloud.size() < least_points)
    return bad_input(scan.files.front() + ": expected at least " + std::to_string(least_points) + " points, found " +
                     std::to_string(scan.cloud.size()));
  // Of meshes as well: those that are scans are measured by their points.
  if (auto ok = session.stage("normals"); !ok) return ok.error();
  estimate_normals(scan.cloud, {}, session.context);
  if (auto ok = session.stage("faces"); !ok) return ok.error();
  return measured_part(scan, tolerance, session.context);
}

void declare_backends(std::vector<std::string>& names, Arguments& options) {
  std::vector<std::string> all;
  std::string list;
  for (const auto& backend : backends()) {
    all.push_back(backend.name);
    list += (list.empty() ? "" : ",") + backend.name;
  }
  options.list(names, "--to", "LIST", all, "which of " + list + " to write (default: all)");
}

Result<std::vector<std::string>> chosen_backends(const std::vector<std::string>& names) {
  std::vector<std::string> all, chosen;
  std::string list;
  for (const auto& backend : backends()) {
    all.push_back(backend.name);
    list += (list.empty() ? "" : ", ") + backend.name;
  }
  for (const auto& name : names)
    if (std::find(all.begin(), all.end(), name) == all.end())
      return usage_error("--to: expected some of " + list + ", found '" + name + "'" + did_you_mean(name, all));
  for (const auto& name : all)
    if (names.empty() || std::find(names.begin(), names.end(), name) != names.end()) chosen.push_back(name);
  return chosen;
}

std::vector<std::string> artifact_names() {
  std::vector<std::string> names;
  for (const auto& backend : backends()) names.push_back(stem + backend.suffix);
  for (const auto& backend : backends())
    names.insert(names.end(), backend.companions.begin(), backend.companions.end());
  return names;
}

Result<Emitted> emit_all(const CheckedModel& model, const std::vector<std::string>& chosen, const Path& templates,
                         Session& session) {
  EmitOptions options;
  options.templates = templates;
  options.stem = stem;
  options.brep = std::make_shared<SharedBrep>();
  Emitted emitted;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    session.context.report(chosen[i], double(i) / double(chosen.size()));
    auto artifact = emit(model, chosen[i], options, session.context);
    if (artifact) {
      emitted.artifacts.push_back(std::move(*artifact));
      continue;
    }
    // A user's templates are input, and their faults no model's.
    if (artifact.error().kind == ErrorKind::stopped || !templates.empty()) return artifact.error();
    emitted.failures.push_back({file_of(chosen[i]), chosen[i], artifact.error().message});
  }
  return emitted;
}

Result<std::vector<Path>> write_artifacts(const std::vector<Artifact>& artifacts, const Path& folder) {
  std::error_code ignored;
  for (const auto& name : artifact_names()) std::filesystem::remove(folder / name, ignored);
  for (const auto& name : judgement_names) std::filesystem::remove(folder / name, ignored);
  std::vector<Path> scripts;
  for (const auto& artifact : artifacts) {
    for (const auto& file : artifact.files)
      if (auto written = write_file(folder / file.name, file.bytes); !written) return written.error();
    scripts.push_back(folder / artifact.files.front().name);
  }
  return scripts;
}

double outlier_rate_of(const Model& model) {
  const auto& p = model.provenance;
  return p.points == 0 ? 0 : static_cast<double>(p.rejected) / static_cast<double>(p.points);
}

void warn_of_missing(const Verdict& verdict, Session& session) {
  for (const auto& artifact : verdict.artifacts)
    if (artifact.verdict == Outcome::not_run && !artifact.reasons.empty())
      session.warn(artifact.file + ": " + artifact.reasons.front());
}

std::string seconds_line(const Session& session) {
  double total = 0;
  std::string text;
  for (const auto& [name, seconds] : session.stages()) {
    total += seconds;
    text += (text.empty() ? "" : ", ") + name + " " + print_number(snapped(seconds, 0.1));
  }
  return "Seconds: " + text + "; together " + print_number(snapped(total, 0.1)) + ".";
}

void declare_pictures(Path& folder, Arguments& options) {
  options.path(folder, "--pictures", "DIR",
               "write the pictures (deviation.png, the six sides, each finding, ...) as PNG files there too");
}

Result<std::vector<Path>> write_pictures(const std::vector<ReportPicture>& pictures, const Path& folder, bool force) {
  std::vector<std::string> names;
  for (const auto& picture : pictures) names.push_back(picture.name);
  if (auto ok = check_overwriting(folder, names, force); !ok) return ok.error();
  if (auto ok = make_folder(folder); !ok) return ok.error();
  std::vector<Path> written;
  for (const auto& picture : pictures) {
    written.push_back(folder / picture.name);
    if (auto ok = write_file(written.back(), picture.png); !ok) return ok.error();
  }
  return written;
}

std::string summary_json(const std::string& command, const std::vector<Path>& files,
                         const std::vector<std::string>& warnings) {
  nlohmann::ordered_json json;
  json["command"] = command;
  json["files"] = nlohmann::ordered_json::array();
  for (const auto& file : files) json["files"].push_back(file.string());
  json["warnings"] = warnings;
  return json_text(json);
}

}  // namespace partscribe::cli
