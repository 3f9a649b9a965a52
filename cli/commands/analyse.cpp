/// analyse: what a model weighs, how it turns, which dimension does how much to it, and files for simulators.
#include <algorithm>
#include <memory>

#include "cli/analyse/analysis.h"
#include "cli/commands.h"
#include "cli/commands/stages.h"
#include "cli/describe.h"
#include "cli/inputs.h"
#include "codegen/analysis/density.h"
#include "codegen/analysis/simulator_files.h"
#include "codegen/exchange/brep.h"
#include "core/number.h"
#include "model/json.h"
#include "verify/exchange/mesh_shape.h"

namespace partscribe::cli {
namespace {

constexpr const char* default_material = "steel";

constexpr const char* analyse_help =
    R"(Examples
  partscribe analyse bracket-partscribe                        mass, centroid, inertia, and what each dimension does
  partscribe analyse model.json --density aluminium            of another material; or --density 2700
  partscribe analyse model.json --urdf bracket.urdf            a link for a simulator, with bracket.stl beside it
  partscribe analyse model.json --target mass=0.12kg --by thickness --out lighter.json
                                                               the thickness at which it weighs that, and that model
  partscribe analyse model.json --json | jq .mass              for a program

Everything is computed from the exact boundary that STEP holds, in its frame. For each named dimension the model is
built twice more, with the dimension a little larger and a little smaller; the table says what that does per mm or
radian. The uncertainty of the mass follows from those of the dimensions. Exit code 0 when the numbers were printed; 2
if an option is wrong, a file exists already or no value meets the target; 3 if the model cannot be read, is an open
surface, or has no boundary that OpenCASCADE can build.)";

struct AnalyseArguments {
  Path model;
  std::string density = default_material, frame = "scan", target, by;
  Path urdf, mjcf, json;
  bool quick = false;
};

/// What is to be written, known before the work begins.
struct AnalyseFiles {
  std::vector<Path> meshes;  ///< beside the simulator's files; one if both have the same name
  Path model;                ///< the changed one; empty: none
};

Result<AnalyseFiles> files_for(const AnalyseArguments& given, const Session& session) {
  AnalyseFiles files;
  std::vector<Path> all;
  for (const auto& [file, option] : {std::pair(given.urdf, "--urdf"), {given.mjcf, "--mjcf"}}) {
    if (file.empty()) continue;
    if (file.extension() == ".stl" || !file.has_stem())
      return usage_error(std::string(option) + " " + file.string() +
                         ": expected a file for the description; its mesh goes into the .stl of the same name");
    const Path mesh = Path(file).replace_extension(".stl");
    all.push_back(file);
    if (std::find(files.meshes.begin(), files.meshes.end(), mesh) == files.meshes.end()) files.meshes.push_back(mesh);
  }
  all.insert(all.end(), files.meshes.begin(), files.meshes.end());
  if (!given.json.empty()) all.push_back(given.json);
  if (!session.options.out.empty()) {
    files.model = session.options.out;
    if (files.model.extension() != ".json") files.model /= "model.json";
    if (!session.options.force && std::filesystem::exists(files.model))
      return usage_error(files.model.string() + " exists already; give --force to overwrite it or another --out");
  }
  for (const auto& file : all)
    if (auto ok = check_overwriting(file, session.options.force, {given.model}); !ok) return ok.error();
  if (!files.model.empty()) all.push_back(files.model);
  for (auto& file : all) file = std::filesystem::absolute(file).lexically_normal();
  std::sort(all.begin(), all.end());
  if (const auto twice = std::adjacent_find(all.begin(), all.end()); twice != all.end())
    return usage_error("two options name the same file, " + twice->string() + ": give it to one of them");
  return files;
}

Result<Done> check_request(const AnalyseArguments& given, const Session& session) {
  if (given.target.empty() && !given.by.empty())
    return usage_error("--by " + given.by + " needs a wish: --target mass=0.12kg, or volume=5cm3");
  if (!given.target.empty() && given.by.empty())
    return usage_error("--target " + given.target + " needs the dimension that may change: --by NAME");
  if (given.target.empty() && !session.options.out.empty())
    return usage_error("--out is for the changed model of --target; without it nothing is written there");
  return Done{};
}

/// The same part, in the frame that was asked for.
Result<CheckedModel> in_frame(const CheckedModel& model, const std::string& frame, const Path& file) {
  if (frame == "scan") return model;
  Model own = *model;
  own.as_scanned = false;
  return checked(std::move(own), file.string());
}

/// The changed model: the number is chosen now, and no longer a nominal size that the data suggested.
Result<std::string> changed_model(const CheckedModel& model, const TargetAnswer& answer) {
  auto changed = with_value(model, answer.parameter, answer.solved.value);
  if (!changed) return changed.error();
  Model text = **changed;
  for (auto& parameter : text.parameters) {
    if (parameter.name != answer.parameter) continue;
    parameter.nominal.reset();
    parameter.note += (parameter.note.empty() ? "" : "; ") + std::string("chosen for ") + amount_text(answer.target);
  }
  return write_model_json(text);
}

/// The descriptions and their mesh, in memory.
Result<std::vector<std::pair<Path, std::string>>> simulator_files(const AnalyseArguments& given,
                                                                  const AnalyseFiles& files, const CheckedModel& model,
                                                                  const Analysis& analysis, Session& session) {
  std::vector<std::pair<Path, std::string>> written;
  if (files.meshes.empty()) return written;
  const auto body = build_body(model, session.context);
  if (!body.ok()) return body.error();
  const auto mesh = verify::mesh_shape(*body->shape, session.options.tolerance.value_or(model->tolerance));
  SimulatedBody simulated{analysis.name, "", analysis.body, analysis.density.density};
  for (const auto& [file, text_of] : {std::pair(given.urdf, &urdf_text), {given.mjcf, &mjcf_text}}) {
    if (file.empty()) continue;
    simulated.mesh = Path(file).replace_extension(".stl").filename().string();
    written.emplace_back(file, text_of(simulated));
  }
  for (const auto& file : files.meshes) written.emplace_back(file, mesh_in_metres(mesh.mesh));
  return written;
}

Result<int> run_analyse(const AnalyseArguments& given, Session& session) {
  const auto density = parse_density(given.density);
  if (!density) return density.error();
  Result<Target> target = given.target.empty() ? Result<Target>(Target{}) : parse_target(given.target);
  if (!target) return target.error();
  if (auto ok = check_request(given, session); !ok) return ok.error();
  const auto files = files_for(given, session);
  if (!files) return files.error();

  if (auto ok = session.stage("read"); !ok) return ok.error();
  const auto read = read_model(given.model);
  if (!read) return read.error();
  const auto model = in_frame(*read, given.frame, given.model);
  if (!model) return model.error();
  if (!given.target.empty())
    if (auto ok = check_solvable(*model, given.by); !ok) return ok.error();
  if (auto ok = session.stage("body"); !ok) return ok.error();
  const auto body = mass_properties(*model, session.context);
  if (!body.ok()) return Error{given.model.string() + ": " + body.error().message, body.error().kind};
  Analysis analysis;
  analysis.name = (*model)->name, analysis.procedure = procedure_text(**model);
  analysis.density = *density, analysis.in_scan_frame = given.frame == "scan";
  analysis.body = *body, analysis.principal = principal_moments(body->inertia);
  if (!given.quick) {
    if (auto ok = session.stage("sensitivities"); !ok) return ok.error();
    auto all = sensitivities(*model, *body, {}, session.context);
    if (!all) return all.error();
    analysis.varied = true;
    analysis.sensitivities = std::move(*all), analysis.sigma = mass_sigma(analysis.sensitivities);
  }
  if (!given.target.empty()) {
    if (auto ok = session.stage("target"); !ok) return ok.error();
    const auto solved = solve_volume(*model, given.by, volume_for(*target, density->density), session.context);
    if (!solved) return solved.error();
    const auto parameter = std::find_if((*model)->parameters.begin(), (*model)->parameters.end(),
                                        [&](const Parameter& p) { return p.name == given.by; });
    analysis.target = TargetAnswer{*target, given.by, parameter->quantity, parameter->value, *solved};
    if (!solved->found) return usage_error(out_of_reach(*analysis.target, density->density));
  }

  if (auto ok = session.stage("write"); !ok) return ok.error();
  auto outputs = simulator_files(given, *files, *model, analysis, session);
  if (!outputs) return outputs.error();
  if (!files->model.empty()) {
    auto text = changed_model(*read, *analysis.target);
    if (!text) return text.error();
    outputs->emplace_back(files->model, std::move(*text));
    if (files->model.has_parent_path())
      if (auto ok = make_folder(files->model.parent_path()); !ok) return ok.error();
  }
  std::vector<Path> written;
  for (const auto& [path, bytes] : *outputs) written.push_back(path);
  if (!given.json.empty()) {
    outputs->emplace_back(given.json, analysis_json(analysis, written));
    written.push_back(given.json);
  }
  for (const auto& [path, bytes] : *outputs)
    if (auto ok = write_file(path, bytes); !ok) return ok.error();
  session.finish_stage();
  session.print(analysis_text(analysis) + (written.empty() ? "" : "\n"));
  for (const auto& path : written) session.print("Wrote " + path.string() + "\n");
  session.print_json(analysis_json(analysis, written));
  return 0;
}

}  // namespace

Command analyse_command() {
  auto given = std::make_shared<AnalyseArguments>();
  std::string list;
  for (const auto& material : materials())
    list += (list.empty() ? "" : ", ") + material.name + " " + print_number(material.density);
  return {"analyse", "say what a model weighs, how it turns and which dimensions matter; files for simulators",
          analyse_help + ("\n\nMaterials, kg/m^3: " + list + "."),
          [given](Arguments& a) {
            a.operand(given->model, "model", "a model.json, or the folder that holds one");
            a.text(given->density, "--density", "KG/M3",
                   "a number in kg/m^3, or a material (default " + std::string(default_material) + ")");
            a.choice(given->frame, "--frame", {"scan", "part"},
                     "of places and directions, and of the files: the scan's, as that of the CAD files (default), or "
                     "the part's own");
            a.flag(given->quick, "--quick", "no uncertainties and no table of the dimensions: builds the model once");
            a.path(given->urdf, "--urdf", "FILE", "write a URDF with one link, and its mesh as .stl beside it");
            a.path(given->mjcf, "--mjcf", "FILE", "the same for MuJoCo");
            a.text(given->target, "--target", "WISH",
                   "mass=0.12kg or volume=5cm3: find the value of --by that gives it");
            a.text(given->by, "--by", "NAME", "the dimension that --target may change; --out FILE writes that model");
            a.path(given->json, "--json-file", "FILE",
                   "write the JSON to a file too; '--json FILE' means the same when FILE ends in .json");
          },
          [given](Session& session) { return run_analyse(*given, session); }};
}

}  // namespace partscribe::cli
