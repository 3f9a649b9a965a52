/// emit: from model.json to CAD files.
#include "codegen/emit.h"

#include <memory>

#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/inputs.h"

namespace partscribe::cli {
namespace {

constexpr const char* emit_help =
    R"(Examples
  partscribe emit bracket-partscribe/model.json                    all backends, beside the model
  partscribe emit model.json --to openscad,step --out cad          two kinds of file into cad/
  partscribe emit model.json --to openscad --templates my-packs    your own template pack

Writes part.scad, part.scl with prelude.scl, part.igs, part.step. The same model always gives the same bytes.)";

struct EmitArguments {
  Path model;
  std::vector<std::string> to;
  Path templates;
};

Result<int> run_emit(const EmitArguments& given, Session& session) {
  const auto chosen = chosen_backends(given.to);
  if (!chosen) return chosen.error();
  const Path folder = output_folder(session.options, given.model, given.model);
  for (const auto& names : {artifact_names(), judgement_names})
    if (auto ok = check_overwriting(folder, names, session.options.force); !ok) return ok.error();
  if (auto ok = session.stage("read"); !ok) return ok.error();
  const auto model = read_model(given.model);
  if (!model) return model.error();
  if (auto ok = make_folder(folder); !ok) return ok.error();
  if (auto ok = session.stage("emit"); !ok) return ok.error();
  const auto emitted = emit_all(*model, *chosen, given.templates, session);
  if (!emitted) return emitted.error();
  if (!emitted->failures.empty())
    return bad_input(emitted->failures.front().file + " cannot be written: " + emitted->failures.front().reason);
  const auto scripts = write_artifacts(emitted->artifacts, folder);
  if (!scripts) return scripts.error();
  session.finish_stage();
  for (const auto& script : *scripts) session.print("Wrote " + script.string() + "\n");
  session.print_json(summary_json("emit", *scripts, {}));
  return 0;
}

}  // namespace

Command emit_command() {
  auto options = std::make_shared<EmitArguments>();
  std::string list;
  for (const auto& backend : backends())
    list += "\n  " + backend.name + " (" + backend.suffix + "): " + backend.description;
  return {"emit", "write a model as CAD files", emit_help + ("\n\nBackends" + list),
          [options](Arguments& a) {
            a.operand(options->model, "model", "a model.json");
            declare_backends(options->to, a);
            a.path(options->templates, "--templates", "DIR",
                   "a folder of template packs in place of the built-in ones");
          },
          [options](Session& session) { return run_emit(*options, session); }};
}

}  // namespace partscribe::cli
