/// render: a picture of a script, a CAD file, a mesh or a scan, or of how far a scan lies from one of these.
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/commands/judged.h"
#include "cli/commands/stages.h"
#include "cli/inputs.h"
#include "cli/report/report_scene.h"
#include "core/json_text.h"
#include "geometry/normals/normals.h"

namespace partscribe::cli {
namespace {

constexpr const char* render_help =
    R"(Examples
  partscribe render part.scad                             part.png, from the front, right and above
  partscribe render part.step --view top -o plan.png      straight from above
  partscribe render part.scad --view 1,-2,0.5             from where (1, -2, 0.5) points
  partscribe render bracket.ply                           the points of a scan
  partscribe render edited.scad bracket.ply               the part, coloured by how far the scan lies from it
  partscribe render part.scad --width 1600 --height 1200  larger, for print

The first file is drawn: .scad .scl .igs .iges .step .stp files are run by their own programs, meshes and scans are read.
With scans behind an artifact the two are compared as 'partscribe verify' does, and the picture is the deviation map:
grey where they agree, blue and orange within the tolerance, dark beyond it, striped where nothing was scanned. Needs no
screen and no graphics card. Exit code 0 when the picture was written, whatever it shows.)";

struct RenderArguments {
  std::vector<Path> files;
  std::string view = "overview";
  Path picture;
  int width = 760, height = 520;
};

/// What is drawn; a scene refers to the others, which stay where they are.
struct Subject {
  Scan scan;
  Verdict verdict;
  ArtifactVerdict geometry;
  Drawn what = Drawn::model;
  ReportScene scene;
};

/// An artifact and how far scans lie from it.
Result<Done> compare(const std::vector<Path>& files, Subject& subject, Session& session) {
  const auto operands = told_apart(files, "render");
  if (!operands) return operands.error();
  if (operands->artifacts.size() > 1)
    return usage_error("render draws one artifact at a time, found " + operands->artifacts[0].string() + " and " +
                       operands->artifacts[1].string());
  const Path& artifact = operands->artifacts.front();
  auto scan = read_scans(operands->scans, session);
  if (!scan) return scan.error();
  subject.scan = std::move(*scan);
  const auto model = model_of(artifact);
  if (!model) return model.error();
  const VerifyOptions options = verify_options(*model, subject.scan, {}, session);
  if (auto ok = session.stage("verify"); !ok) return ok.error();
  auto verdict = verify_artifacts({artifact}, subject.scan, *model, options, session.context);
  if (!verdict) return verdict.error();
  subject.verdict = std::move(*verdict);
  const auto& judged = subject.verdict.artifacts.front();
  for (const auto& reason : judged.reasons) session.warn(judged.file + ": " + reason);
  if (judged.mesh.empty())
    return bad_input(artifact.string() + ": expected geometry to draw, found none" +
                     (judged.reasons.empty() ? "" : ": " + judged.reasons.front()));
  subject.what = Drawn::deviation;
  subject.scene = report_scene(*model, subject.verdict, subject.scan.cloud, session.context);
  return Done{};
}

/// What a script or CAD file describes.
Result<Done> evaluate(const Path& artifact, Subject& subject, Session& session) {
  if (!is_file(artifact))
    return bad_input(artifact.string() + ": expected a script or CAD file to draw, found no such file");
  EvaluateOptions options;
  if (session.options.tolerance) options.tolerance = *session.options.tolerance;
  auto evaluation = evaluate_artifact(artifact, options, session.context);
  if (!evaluation) return evaluation.error();
  for (const auto& complaint : evaluation->complaints) session.warn(artifact.string() + ": " + complaint);
  if (evaluation->mesh.empty())
    return bad_input(artifact.string() + ": expected geometry to draw, found none" +
                     (evaluation->complaints.empty() ? "" : ": " + evaluation->complaints.front()));
  subject.geometry.file = artifact.filename().string();
  subject.geometry.program = evaluation->program;
  subject.geometry.mesh = std::move(evaluation->mesh);
  const auto model = model_of(artifact);
  if (!model) return model.error();
  subject.scene = plain_scene(subject.geometry, subject.scan.cloud, *model, session.context);
  return Done{};
}

Result<Done> read(const Path& file, Subject& subject, Session& session) {
  auto scan = read_scans({file}, session);
  if (!scan) return scan.error();
  subject.scan = std::move(*scan);
  if (!subject.scan.mesh.empty()) {
    subject.geometry.file = file.filename().string();
    subject.geometry.mesh = subject.scan.mesh;
    subject.scan.cloud = {};
  } else {
    estimate_normals(subject.scan.cloud, {}, session.context);
    subject.what = Drawn::scan;
  }
  subject.scene = plain_scene(subject.geometry, subject.scan.cloud, {}, session.context);
  return Done{};
}

Result<int> run_render(const RenderArguments& given, Session& session) {
  const Path picture =
      given.picture.empty() ? session.options.out / (given.files.front().stem().string() + ".png") : given.picture;
  if (picture.extension() != ".png")
    return usage_error("the picture is a PNG file: expected a name that ends in .png, found " + picture.string());
  auto free = given.picture.empty()
                  ? check_overwriting(session.options.out, {picture.filename().string()}, session.options.force)
                  : check_overwriting(picture, session.options.force, given.files);
  if (!free) return free.error();
  if (auto ok = session.stage("read"); !ok) return ok.error();
  Subject subject;
  const Path& first = given.files.front();
  auto ready = given.files.size() > 1 ? compare(given.files, subject, session)
               : is_cad_file(first)   ? evaluate(first, subject, session)
                                      : read(first, subject, session);
  if (!ready) return ready.error();
  if (auto ok = session.stage("draw"); !ok) return ok.error();
  const auto view = given.view == "overview" ? subject.scene.views.front() : view_named(given.view, subject.scene);
  const auto drawn = draw_view(subject.scene, subject.what, view, given.width, given.height, session.context.threads);
  if (picture.has_parent_path())
    if (auto ok = make_folder(picture.parent_path()); !ok) return ok.error();
  if (auto ok = write_file(picture, drawn.png); !ok) return ok.error();
  session.finish_stage();
  session.print("Wrote " + picture.string() + ": " + drawn.description + "\n");
  auto json = nlohmann::ordered_json::parse(summary_json("render", {picture}, subject.scan.warnings));
  json["title"] = drawn.title;
  json["description"] = drawn.description;
  session.print_json(json_text(json));
  return 0;
}

}  // namespace

Command render_command() {
  auto options = std::make_shared<RenderArguments>();
  return {
      "render", "draw a script, CAD file, mesh or scan, or how far a scan lies from it", render_help,
      [options](Arguments& a) {
        a.paths(options->files, "files", "what to draw; behind it the scans that it is compared with");
        a.choice(
            options->view, "--view", "VIEW", view_words(),
            {"a direction X,Y,Z of some length",
             [](const std::string& word) { return direction_in(word).has_value(); }},
            "from where: iso, front, right, back, left, top, bottom, or the direction to the eye as X,Y,Z (default: "
            "from the front, right and above, from another corner if that shows more of a plate, or from where a "
            "one-sided scan was taken)");
        a.path(options->picture, "--picture", "FILE",
               "where it is written (default: named after the first file, with .png)", "-o");
        a.count(options->width, "--width", "PIXELS", 200, 8000, "of the picture (default 760)");
        a.count(options->height, "--height", "PIXELS", 150, 8000, "of the picture (default 520)");
      },
      [options](Session& session) { return run_render(*options, session); }};
}

}  // namespace partscribe::cli
