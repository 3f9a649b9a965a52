/// fit: from a scan to model.json.
#include <memory>

#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "cli/names.h"
#include "geometry/io/read_geometry.h"
#include "model/json.h"

namespace partscribe::cli {
namespace {

constexpr const char* fit_help =
    R"(Examples
  partscribe fit bracket.ply --tolerance 0.1              writes bracket-partscribe/model.json
  partscribe fit bracket-partscribe/cloud.ply             the same from the stage before; model.json beside it

Reads a scan, or the cloud.ply that 'scan' wrote. Writes model.json: named parameters with their uncertainty, the
steps of the procedure, the rivals. 'emit' turns it into CAD files, 'explain' into words. Exit code 0 when a model was
written; 'verify' says whether it is right.)";

struct FitCommandArguments {
  std::vector<Path> scans;
  FitArguments fit;
};

Result<int> run_fit(const FitCommandArguments& given, Session& session) {
  const Path named_after = given.fit.name.empty() ? given.scans.front() : Path(given.fit.name);
  const std::string name = part_name(named_after);
  const Path folder = output_folder(session.options, given.scans.front(), named_after);
  if (auto ok = check_same_part(session.options, folder, given.scans); !ok) return ok.error();
  if (auto ok = check_overwriting(folder, {"model.json"}, session.options.force); !ok) return ok.error();
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto scan = read_scans(given.scans, session);
  if (!scan) return scan.error();
  const auto tolerance = tolerance_for(*scan, session);
  session.print("Read " + std::to_string(scan->cloud.size()) + " points; " + tolerance.reason + ".\n");
  if (auto ok = session.stage("fit"); !ok) return ok.error();
  const auto model = fit_stage(*scan, tolerance.tolerance, name, given.fit, session);
  if (!model) return model.error();
  const std::string text = write_model_json(**model);
  if (auto ok = make_folder(folder); !ok) return ok.error();
  if (auto ok = write_file(folder / "model.json", text); !ok) return ok.error();
  session.finish_stage();
  session.print("\n" + found_lines(**model) + "\n" + dimension_table(**model) + "\nModel in " +
                (folder / "model.json").string() + "; next: partscribe emit " + (folder / "model.json").string() +
                "\n" + seconds_line(session) + "\n" + no_procedure_line(**model, given.fit.procedure));
  session.print_json(summary_json("fit", {folder / "model.json"}, scan->warnings));
  return 0;
}

}  // namespace

Command fit_command() {
  auto options = std::make_shared<FitCommandArguments>();
  return {"fit", "find the procedure that describes a scan", fit_help,
          [options](Arguments& a) {
            a.paths(options->scans, "scan", "scan files of one part, in one common frame");
            a.text(options->fit.name, "--name", "NAME", "name of the part (default: from the first file)");
            a.flag(options->fit.no_nominal, "--no-nominal",
                   "keep every measured value; else a nominal size is taken where the data cannot tell the difference");
            declare_procedure(options->fit, a);
          },
          [options](Session& session) { return run_fit(*options, session); }};
}

}  // namespace partscribe::cli
