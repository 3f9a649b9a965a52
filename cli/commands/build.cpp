/// build: from scans to a verified procedure in one go.
#include <memory>
#include <optional>

#include "cli/commands.h"
#include "cli/commands/build_json.h"
#include "cli/commands/built.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/names.h"
#include "core/number.h"
#include "geometry/normals/normals.h"
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

/// What build says at the end.
void print_result(const Model& model, const Verdict& verdict, const Path& folder, Session& session) {
  session.print("\n" + found_lines(model));
  if (const auto dimensions = dimension_table(model); !dimensions.empty()) session.print("\n" + dimensions);
  for (const auto& u : model.unexplained)
    session.print("Unexplained: " + u.reason + " (" + readable(u.area) + " mm2, " + std::to_string(u.points) +
                  " points)\n");
  session.print("\n" + verdict_table(verdict));
  std::string names;
  for (const auto& file : built_files(folder)) names += " " + file.filename().string();
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

/// Reads, fits, writes and judges. `asked`: all but the tolerance, which may follow from the scan.
Result<int> work(const BuildArguments& arguments, const BuildRequest& asked, BuildFolder& into, Session& session) {
  const Path& folder = into.results.path();
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

  BuildRequest request = asked;
  request.tolerance = tolerance.tolerance;
  const PointCloud as_read = scan->cloud;
  const auto built = build_part(*scan, request, session);
  if (!built) return built.error();
  const auto pictures = write_built(*built, *placed, into, session);
  if (!pictures) return pictures.error();
  if (!arguments.pictures.empty())
    if (auto drawn = write_pictures(*pictures, arguments.pictures, session.options.force); !drawn) return drawn.error();

  const Model& model = *built->model;
  const Verdict& verdict = built->trial().verdict;
  if (session.options.quiet) warn_of_missing(verdict, session);
  print_result(model, verdict, folder, session);
  if (verdict.verdict == Outcome::out_of_tolerance)
    session.print(scene_hint(arguments.scans.front(), session.options.units, *scan, session.context.threads));
  session.print(no_procedure_line(model, request.fit.procedure));
  std::optional<Wider> wider;
  const bool heard = !session.options.quiet || session.options.json;
  if (heard && (model.fallback || verdict.verdict == Outcome::out_of_tolerance)) {
    // The files are whole: what stops this search takes nothing from them.
    if (auto found = wider_procedure(*built, *scan, as_read, request, session)) wider = std::move(*found);
    session.finish_stage();
  }
  if (wider)
    session.print("Try --procedure " + wider->procedure + " --tolerance " + print_number(wider->tolerance) +
                  ": that was tried and is verified.\n");
  session.print_json(build_json(model, request.fit.procedure, wider, write_verdict_json(verdict), built_files(folder),
                                scan->warnings));
  return exit_code_of(verdict.verdict);
}

Result<int> run_build(const BuildArguments& arguments, Session& session) {
  const auto backends = chosen_backends(arguments.to);
  if (!backends) return backends.error();
  const Path named_after = arguments.fit.name.empty() ? arguments.scans.front() : Path(arguments.fit.name);
  // A build starts from scans, so an earlier run's cloud.ply is an input like any other: its folder is its own.
  const Path folder = output_folder(session.options, arguments.scans.front(), named_after);
  BuildFolder into = build_folder(folder, arguments.scans, arguments.poses.poses != "given");
  if (auto ok = check_same_part(session.options, folder, arguments.scans); !ok) return ok.error();
  if (auto ok = into.results.check(session.options.force); !ok) return ok.error();
  if (!arguments.pictures.empty())
    if (auto ok = check_overwriting(arguments.pictures, {"scan.png"}, session.options.force); !ok) return ok.error();
  const BuildRequest request{part_name(named_after), 0, *backends, arguments.templates, arguments.fit};
  return into.results.close(work(arguments, request, into, session));
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
            declare_backends(arguments->to, a);
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
