/// report: the page of a folder that build or the single stages filled.
#include <memory>

#include "cli/commands.h"
#include "cli/inputs.h"
#include "cli/report_page.h"
#include "cli/stages.h"
#include "cli/verdict_file.h"

namespace partscribe {
namespace {

constexpr const char* help =
    R"(Examples
  partscribe report bracket-partscribe --force              report.html again, after an edit
  partscribe report bracket-partscribe --png --out figures  the page and its pictures as PNG files

Reads model.json, cloud.ply, verdict.json and the artifacts in DIR. The verdict is the recorded one; the first artifact
is run again for the pictures. Writes report.html, and with --png the pictures beside it.)";

struct Options {
  Path folder;
  bool png = false;
};

const std::vector<std::string> picture_names = {"scan-front.png", "scan-back.png",       "model-front.png",
                                                "model-back.png", "deviation-front.png", "deviation-back.png"};

/// Fills in what verdict.json cannot hold: the geometry and the deviation of each point, from a new run.
Result<Done> evaluate_for_pictures(Verdict& verdict, const Path& folder, const Scan& scan, const Model& model,
                                   Session& session) {
  for (auto& artifact : verdict.artifacts) {
    const Path file = folder / Path(artifact.file).filename();
    if (!std::filesystem::is_regular_file(file)) continue;
    VerifyOptions options;
    options.tolerance = verdict.tolerance;
    auto again = verify({file}, scan, model, options, session.context);
    if (!again) return again.error();
    if (again->artifacts.empty() || again->artifacts.front().mesh.empty()) continue;
    artifact.mesh = std::move(again->artifacts.front().mesh);
    artifact.point_deviation = std::move(again->artifacts.front().point_deviation);
    break;
  }
  return Done{};
}

Result<int> run(const Options& given, Session& session) {
  const Path folder = given.folder, out = session.options.out.empty() ? folder : session.options.out;
  if (auto ok = session.stage("read"); !ok) return ok.error();
  const auto model = read_model(folder / "model.json");
  if (!model) return model.error();
  const auto verdict_text = read_file(folder / "verdict.json");
  if (!verdict_text) return verdict_text.error();
  auto verdict = read_verdict_json(*verdict_text, (folder / "verdict.json").string());
  if (!verdict) return verdict.error();
  const auto scan = read_scans({folder / "cloud.ply"}, session);
  if (!scan) return scan.error();
  std::vector<std::string> files = {"report.html"};
  if (given.png) files.insert(files.end(), picture_names.begin(), picture_names.end());
  if (auto ok = check_overwriting(out, files, session.options.force); !ok) return ok.error();
  if (auto ok = make_folder(out); !ok) return ok.error();

  if (auto ok = session.stage("evaluate"); !ok) return ok.error();
  if (auto ok = evaluate_for_pictures(*verdict, folder, *scan, **model, session); !ok) return ok.error();
  if (auto ok = session.stage("report"); !ok) return ok.error();
  const auto pictures = draw_report(**model, *verdict, scan->cloud);
  std::vector<Path> written = {out / "report.html"};
  std::string script_name, script;
  for (const char* name : {"part.scad", "part.scl"})
    if (const auto text = read_file(folder / name); text && script.empty()) script_name = name, script = *text;
  const auto page = report_page({**model, *verdict, scan->cloud, pictures, script_name, script, {}});
  if (auto ok = write_file(written.front(), page); !ok) return ok.error();
  if (given.png)
    for (const auto& picture : pictures) {
      written.push_back(out / picture.name);
      if (auto ok = write_file(written.back(), picture.png); !ok) return ok.error();
    }
  session.finish_stage();
  for (const auto& file : written) session.print("Wrote " + file.string() + "\n");
  session.print_json(summary_json("report", written, {}));
  return 0;
}

}  // namespace

Command report_command() {
  auto options = std::make_shared<Options>();
  return {"report", "make the HTML page of a build folder, and its pictures", help,
          [options](Arguments& a) {
            a.operand(options->folder, "folder", "a folder with model.json, cloud.ply and verdict.json");
            a.flag(options->png, "--png", "write the pictures as PNG files too");
          },
          [options](Session& session) { return run(*options, session); }};
}

}  // namespace partscribe
