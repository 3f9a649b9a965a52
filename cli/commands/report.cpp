/// report: the page of a folder that build or the single stages filled, or of any artifact and scan.
#include <algorithm>
#include <memory>

#include "cli/commands.h"
#include "cli/commands/judged.h"
#include "cli/commands/stages.h"
#include "cli/inputs.h"
#include "cli/measure/measured_part.h"
#include "cli/names.h"
#include "cli/report/report_faces.h"
#include "cli/report/report_page.h"
#include "cli/report/report_server.h"
#include "cli/report/report_words.h"
#include "cli/verdict_file.h"
#include "geometry/normals/normals.h"

namespace partscribe::cli {
namespace {

constexpr const char* report_help =
    R"(Examples
  partscribe report bracket-partscribe --force              report.html again, after an edit
  partscribe report bracket-partscribe --force --pictures figures   the page anew, and its pictures as PNG files
  partscribe report edited.scad bracket.ply --out review    verify my script and report what came out
  partscribe report bracket-partscribe --faces --force      with what 'partscribe measure' says of the scan
  partscribe report bracket-partscribe --serve              edit the script in the browser and verify it there

Given a folder (or a model.json or verdict.json in it) it reads model.json, cloud.ply, verdict.json and the artifacts
there. The verdict is the recorded one; the artifacts are run again for the pictures, because verdict.json holds no
geometry. Given artifacts and scans it verifies them first. Writes report.html: one file that needs no network.)";

struct ReportArguments {
  std::vector<Path> files;
  Path pictures;
  bool faces = false, serve = false;
  int port = 0;
};

/// Everything a page is made of.
struct Material {
  std::string name;
  std::optional<Model> model;
  Verdict verdict;
  Scan scan;
  std::vector<Path> artifacts;
  Path folder;  ///< where report.html goes unless --out says otherwise
};

bool has_suffix(const Path& file, const std::vector<std::string>& suffixes) {
  std::string suffix = file.extension().string();
  for (char& c : suffix)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c | 0x20);
  return std::find(suffixes.begin(), suffixes.end(), suffix) != suffixes.end();
}

/// Fills in what verdict.json cannot hold: the geometry and the deviation of each point, from a new run.
Result<Done> evaluate_for_pictures(Material& material, Session& session) {
  for (auto& recorded : material.verdict.artifacts) {
    const Path file = material.folder / Path(recorded.file).filename();
    if (!is_file(file)) continue;
    VerifyOptions options;
    options.tolerance = material.verdict.tolerance;
    if (material.model) options.outlier_rate = std::max(options.outlier_rate, outlier_rate_of(*material.model));
    auto again = verify_artifacts({file}, material.scan, material.model, options, session.context);
    if (!again) return again.error();
    ArtifactVerdict& fresh = again->artifacts.front();
    if (fresh.mesh.empty()) continue;
    if (fresh.verdict != recorded.verdict)
      session.warn(file.string() + " is now " + name_of(fresh.verdict) + ", but verdict.json says " +
                   name_of(recorded.verdict) + ": run 'partscribe verify' again");
    recorded.mesh = std::move(fresh.mesh);
    recorded.point_deviation = std::move(fresh.point_deviation);
    recorded.point_object = std::move(fresh.point_object);
    recorded.triangle_object = std::move(fresh.triangle_object);
    recorded.sample_support = std::move(fresh.sample_support);
    recorded.objects = std::move(fresh.objects);
    if (recorded.findings.empty()) recorded.findings = std::move(fresh.findings);
  }
  return Done{};
}

Result<Material> recorded_material(const Path& given, Session& session) {
  Material material;
  material.folder = is_folder(given) ? given : given.has_parent_path() ? given.parent_path() : Path(".");
  auto model = read_model(material.folder);
  if (!model) return model.error();
  material.model = **model;
  material.name = material.model->name;
  const Path verdict_file = material.folder / "verdict.json";
  const auto text = read_file(verdict_file);
  if (!text) return text.error();
  auto verdict = read_verdict_json(*text, verdict_file.string());
  if (!verdict) return verdict.error();
  material.verdict = std::move(*verdict);
  auto scan = read_scans({material.folder / "cloud.ply"}, session);
  if (!scan) return scan.error();
  material.scan = std::move(*scan);
  for (const auto& artifact : material.verdict.artifacts)
    material.artifacts.push_back(material.folder / Path(artifact.file).filename());
  return material;
}

Result<Material> verified_material(const std::vector<Path>& files, Session& session) {
  Material material;
  auto operands = told_apart(files, "report");
  if (!operands) return operands.error();
  material.artifacts = std::move(operands->artifacts);
  material.name = part_name(material.artifacts.front());
  material.folder = folder_name(material.artifacts.front()) + "-report";
  auto scan = read_scans(operands->scans, session);
  if (!scan) return scan.error();
  material.scan = std::move(*scan);
  auto model = model_of(material.artifacts.front());
  if (!model) return model.error();
  material.model = std::move(*model);
  if (material.model) material.name = material.model->name;
  const VerifyOptions options = verify_options(material.model, material.scan, {}, session);
  if (auto ok = session.stage("verify"); !ok) return ok.error();
  auto verdict = verify_artifacts(material.artifacts, material.scan, material.model, options, session.context);
  if (!verdict) return verdict.error();
  material.verdict = std::move(*verdict);
  return material;
}

/// The scan measured as 'measure' does: the section of the page, and its picture among the others.
Result<std::string> measured_section(const Material& material, std::vector<ReportPicture>& pictures, Session& session) {
  if (auto ok = session.stage("faces"); !ok) return ok.error();
  Scan scan = material.scan;
  estimate_normals(scan.cloud, {}, session.context);
  const auto part = measured_part(scan, material.verdict.tolerance, session.context);
  if (!part) return part.error();
  pictures.push_back(picture_of_faces(scan, part->faces, session.context));
  return faces_section(*part, pictures.back());
}

/// The page of what was judged, and its pictures.
struct Drawing {
  std::string page;
  std::vector<ReportPicture> pictures;
};

Result<Drawing> draw_page(const Material& material, bool faces, const std::vector<ReportScript>& scripts,
                          Session& session) {
  const auto scene = report_scene(material.model, material.verdict, material.scan.cloud, session.context);
  Drawing drawing;
  drawing.pictures = draw_report(scene, session.context);
  std::string measured;
  if (faces) {
    auto section = measured_section(material, drawing.pictures, session);
    if (!section) return section.error();
    measured = std::move(*section);
  }
  std::vector<SourceFile> sources;
  for (std::size_t i = 0; i < material.scan.files.size() && i < material.scan.sha256.size(); ++i)
    sources.push_back({material.scan.files[i], material.scan.sha256[i]});
  drawing.page = report_page({material.name, material.model, material.verdict, scene, drawing.pictures, scripts,
                              sources, material.scan.warnings, session.version, measured});
  return drawing;
}

/// A script that was edited in the browser, run beside the other scripts of its folder and judged like the file.
Result<BenchAnswer> judge_edited(const Material& material, const Path& file, const std::string& script,
                                 Session& session) {
  const auto aside = TemporaryDirectory::make();
  if (!aside) return aside.error();
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::absolute(file).parent_path(), ignored))
    if (entry.is_regular_file(ignored) && entry.path().extension() == file.extension())
      std::filesystem::copy_file(entry.path(), aside->path() / entry.path().filename(), ignored);
  const Path edited = aside->path() / file.filename();
  if (auto ok = write_file(edited, script); !ok) return ok.error();
  Material fresh = material;
  VerifyOptions options;
  options.tolerance = material.verdict.tolerance;
  if (material.model) options.outlier_rate = std::max(options.outlier_rate, outlier_rate_of(*material.model));
  auto verdict = verify_artifacts({edited}, material.scan, material.model, options, session.context);
  if (!verdict) return verdict.error();
  fresh.verdict = std::move(*verdict);
  auto drawing = draw_page(fresh, false, {{file.filename().string(), script}}, session);
  if (!drawing) return drawing.error();
  return BenchAnswer{std::move(drawing->page), name_of(fresh.verdict.verdict), verdict_sentence(fresh.verdict)};
}

/// Until Ctrl-C, the page with the first script beside it.
Result<int> serve(const Material& material, std::string page, BenchPort& port, Session& session) {
  const auto file = std::find_if(material.artifacts.begin(), material.artifacts.end(), [](const Path& a) {
    return has_suffix(a, {".scad", ".scl"});
  });
  if (file == material.artifacts.end())
    return usage_error("--serve needs a script that can be edited (.scad or .scl), found " +
                       (material.artifacts.empty() ? "no artifact" : material.artifacts.front().string()));
  const auto script = read_file(*file);
  if (!script) return script.error();
  Workbench bench{material.name,
                  file->filename().string(),
                  *script,
                  {std::move(page), name_of(material.verdict.verdict), verdict_sentence(material.verdict)},
                  [&](const std::string& edited) { return judge_edited(material, *file, edited, session); }};
  session.finish_stage();
  port.serve(std::move(bench), session, [&](const std::string& address) {
    session.print("Open " + address + "\nCtrl-C ends it; only this machine can reach it.\n");
    session.print_json("{\"address\": \"" + address + "\"}");
  });
  return 0;
}

Result<int> run_report(const ReportArguments& given, Session& session) {
  const Path& first = given.files.front();
  const bool recorded = given.files.size() == 1 && (is_folder(first) || has_suffix(first, {".json"}));
  std::optional<BenchPort> port;
  if (given.serve) {
    auto taken = BenchPort::take(given.port);
    if (!taken) return taken.error();
    port.emplace(std::move(*taken));
  }
  if (auto ok = session.stage("read"); !ok) return ok.error();
  auto material = recorded ? recorded_material(first, session) : verified_material(given.files, session);
  if (!material) return material.error();
  const Path out = session.options.out.empty() ? material->folder : session.options.out;
  if (!given.serve)
    if (auto ok = check_overwriting(out, {"report.html"}, session.options.force); !ok) return ok.error();
  if (recorded) {
    if (auto ok = session.stage("evaluate"); !ok) return ok.error();
    if (auto ok = evaluate_for_pictures(*material, session); !ok) return ok.error();
  }

  if (auto ok = session.stage("report"); !ok) return ok.error();
  auto drawing = draw_page(*material, given.faces, read_scripts(material->artifacts), session);
  if (!drawing) return drawing.error();
  if (port) return serve(*material, std::move(drawing->page), *port, session);
  if (auto ok = make_folder(out); !ok) return ok.error();
  std::vector<Path> written;
  if (!given.pictures.empty()) {
    auto drawn = write_pictures(drawing->pictures, given.pictures, session.options.force);
    if (!drawn) return drawn.error();
    written = std::move(*drawn);
  }
  written.insert(written.begin(), out / "report.html");
  if (auto ok = write_file(written.front(), drawing->page); !ok) return ok.error();
  session.finish_stage();
  for (const auto& file : written) session.print("Wrote " + file.string() + "\n");
  session.print(verdict_sentence(material->verdict) + "\n");
  session.print_json(summary_json("report", written, material->scan.warnings));
  return recorded ? 0 : exit_code_of(material->verdict.verdict);
}

}  // namespace

Command report_command() {
  auto options = std::make_shared<ReportArguments>();
  return {"report", "make the HTML page of a build folder or of any artifact and scan, and its pictures", report_help,
          [options](Arguments& a) {
            a.paths(options->files, "files",
                    "a folder with model.json, cloud.ply and verdict.json, or artifacts and scans");
            declare_pictures(options->pictures, a);
            a.flag(options->faces, "--faces",
                   "measure the scan as well: its faces, features and relations, with a picture of them");
            a.flag(options->serve, "--serve",
                   "show the page with the script beside it in the browser: edit a number, press Verify, see the new "
                   "map; nothing is written");
            a.count(options->port, "--port", "N", 0, 65535, "of this machine, for --serve (default 0: any free one)");
          },
          [options](Session& session) { return run_report(*options, session); }};
}

}  // namespace partscribe::cli
