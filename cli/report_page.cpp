#include "cli/report_page.h"

#include <algorithm>

#include "cli/color_scale.h"
#include "cli/describe.h"
#include "cli/report_map.h"
#include "cli/report_words.h"
#include "codegen/template.h"
#include "core/number.h"

namespace partscribe {
namespace {

/// SHA-256 as Content-Security-Policy wants it.
std::string policy_hash(const std::string& text) {
  const std::string hex = sha256(text);
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
    bytes += static_cast<char>(value(hex[i]) << 4 | value(hex[i + 1]));
  }
  return "sha256-" + base64(bytes);
}

const ReportPicture* picture_named(const std::vector<ReportPicture>& pictures, const std::string& name) {
  for (const auto& picture : pictures)
    if (picture.name == name) return &picture;
  return nullptr;
}

/// The sides, the scan and the model; the overview and the findings stand elsewhere.
std::string gallery(const std::vector<ReportPicture>& pictures) {
  std::string text;
  for (const auto& picture : pictures)
    if (picture.name != "deviation.png" && !picture.name.starts_with("finding-")) text += figure_of(picture);
  return text;
}

std::string map_remark(const MapData& map) {
  std::string text = map.shown < map.of ? grouped(map.shown) + " of " + grouped(map.of) +
                                              " points are shown, more where the deviation varies; a point left out differs from the one "
                                              "that stands for it by at most " + readable(map.value_error) + " mm."
                                        : "All " + grouped(map.of) + " points are shown.";
  if (map.surface_error > 0) text += " The surface is thinned by at most " + readable(map.surface_error) + " mm.";
  return text;
}

/// The map's program: the files of the pack in one function, so that nothing leaks into the page.
std::string map_program(const TemplatePack& pack) {
  std::string text = "\"use strict\";\n(() => {\n";
  for (const char* file : {"map-data.js", "map-camera.js", "map-gl.js", "map-soft.js", "map.js"}) text += pack.files.at(file);
  return text + "})();\n";
}

TemplateList list_if(const std::string& key, const std::string& text) {
  return text.empty() ? TemplateList{} : TemplateList{{{key, text}}};
}

}  // namespace

std::string report_page(const ReportInput& input) {
  const Verdict& verdict = input.verdict;
  const auto pack = load_template_pack("report", {});
  ensure(pack.ok(), "the report's templates are part of the program");
  const MapData map = map_data(input.scene, {});
  const std::string program = map_program(*pack);

  TemplateRecord data;
  data["name"] = escaped(spoken(input.name));
  data["outcome"] = escaped(title_of(verdict.verdict));
  data["outcome_class"] = name_of(verdict.verdict);
  data["sentence"] = typeset(verdict_sentence(verdict));
  data["fallback"] = input.model && input.model->fallback
                         ? "The model is a triangulation, because no procedure with named dimensions met the tolerance."
                         : "";
  data["style"] = pack->files.at("report.css");
  data["policy"] = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src '" + policy_hash(program) +
                   "'; base-uri 'none'; form-action 'none'";
  data["figures"] = key_figures(verdict, input.model);
  const ReportPicture* hero = picture_named(input.pictures, "deviation.png");
  if (!hero) hero = picture_named(input.pictures, "scan.png");
  data["hero"] = hero ? figure_of(*hero, "hero") : "";
  data["findings"] = findings_section(verdict, input.pictures);
  const std::string features = features_section(verdict);
  data["features"] = list_if("table", features);
  data["artifacts"] = artifacts_section(verdict);
  data["gallery"] = list_if("pictures", gallery(input.pictures));
  data["parameters"] = list_if("table", input.model ? parameters_section(*input.model) : std::string());
  data["reasons"] = list_if("table", input.model ? reasons_section(*input.model) : std::string());
  data["provenance"] = provenance_section(verdict, input.model, input.sources, input.warnings);
  data["scripts"] = list_if("tabs", scripts_section(input.scripts));
  data["version"] = escaped(input.version);
  TemplateList maps;
  if (!map.json.empty()) {
    std::string options;
    for (std::size_t k = 0; k < verdict.artifacts.size(); ++k)
      if (&verdict.artifacts[k] == input.scene.artifact)
        for (std::size_t f = 0; f < verdict.artifacts[k].objects.size(); ++f)
          options += "<option value=\"" + std::to_string(f) + "\">" + escaped(verdict.artifacts[k].objects[f].name) + "</option>";
    maps.push_back({{"json", map.json},
                    {"program", program},
                    {"scale", scale_svg(input.scene.deviations, verdict.tolerance)},
                    {"remark", escaped(map_remark(map))},
                    {"artifact", escaped(input.scene.artifact->file)},
                    {"tolerance", print_number(verdict.tolerance)},
                    {"feature_options", options}});
  }
  data["map"] = maps;
  auto page = pack->render("page.html", data);
  ensure(page.ok(), page.ok() ? "" : page.error().message.c_str());
  return *page;
}

}  // namespace partscribe
