#include "cli/report/report_page.h"

#include <algorithm>

#include "cli/describe.h"
#include "cli/pictures/color_scale.h"
#include "cli/report/report_map.h"
#include "cli/report/report_words.h"
#include "codegen/template.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

const ReportPicture* picture_named(const std::vector<ReportPicture>& pictures, const std::string& name) {
  for (const auto& picture : pictures)
    if (picture.name == name) return &picture;
  return nullptr;
}

/// The sides, the scan and the model; the overview, the findings and the faces stand elsewhere.
std::string gallery(const std::vector<ReportPicture>& pictures) {
  std::string text;
  for (const auto& picture : pictures)
    if (picture.name != "deviation.png" && picture.name != "faces.png" && !picture.name.starts_with("finding-"))
      text += figure_of(picture);
  return text;
}

std::string map_remark(const MapData& map) {
  std::string text =
      map.shown < map.of
          ? grouped(map.shown) + " of " + grouped(map.of) +
                " points are shown, more where the deviation varies; a point left out differs from the one "
                "that stands for it by at most " +
                readable(map.value_error) + " mm."
          : "All " + grouped(map.of) + " points are shown.";
  if (map.surface_error > 0) text += " The surface is thinned by at most " + readable(map.surface_error) + " mm.";
  return text;
}

/// The map's program: the files of the pack in one function, so that nothing leaks into the page.
std::string map_program(const TemplatePack& pack) {
  std::string text = "\"use strict\";\n(() => {\n";
  for (const char* file : {"map-data.js", "map-camera.js", "map-gl.js", "map-soft.js", "map.js"})
    text += pack.files.at(file);
  return text + "})();\n";
}

/// What the page says and holds of the maps, of each artifact that has one.
struct MapParts {
  std::string choices, scales, remarks, data;
};

void add_map(MapParts& parts, const ReportScene& scene, const MapData& map, std::size_t index) {
  const std::string number = std::to_string(index), file = escaped(scene.artifact->file);
  const std::string mine = " data-map=\"" + number + "\"" + (index ? " hidden" : "");
  parts.choices += "<option value=\"" + number + "\">" + file + ": " + title_of(scene.artifact->verdict) + "</option>";
  parts.scales += "<div" + mine + ">" + scale_svg(scene.deviations, scene.tolerance) + "</div>";
  parts.remarks += "<p class=\"remark\"" + mine + ">" + file + ": " + escaped(map_remark(map)) + "</p>";
  parts.data +=
      "<script type=\"application/json\" class=\"map-data\" data-file=\"" + file + "\">" + map.json + "</script>\n";
}

MapParts map_parts(const ReportScene& first, const MapData& first_map) {
  MapParts parts;
  add_map(parts, first, first_map, 0);
  std::size_t count = 1;
  for (const auto& scene : first.others)
    if (const MapData map = map_data(scene, {}); !map.json.empty()) add_map(parts, scene, map, count++);
  parts.choices = count == 1 ? std::string()
                             : "<fieldset>\n<legend>File</legend>\n<label class=\"unseen\" "
                               "for=\"artifact\">File</label>\n<select id=\"artifact\">" +
                                   parts.choices + "</select>\n</fieldset>";
  return parts;
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
  const std::string program = map_program(*pack), scheme = pack->files.at("scheme.js");

  TemplateRecord data;
  data["name"] = escaped(spoken(input.name));
  data["outcome"] = escaped(title_of(verdict.verdict));
  data["outcome_class"] = name_of(verdict.verdict);
  data["sentence"] = typeset(verdict_sentence(verdict));
  std::string fallback;
  if (input.model && input.model->fallback) {
    fallback = "The model is " + procedure_text(*input.model) + ".";
    if (const auto nearest = nearest_procedure_line(*input.model); !nearest.empty()) fallback += " " + nearest;
  }
  data["fallback"] = escaped(fallback);
  data["style"] = pack->files.at("report.css");
  data["policy"] = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src " + policy_hash(scheme) +
                   " " + policy_hash(program) + "; base-uri 'none'; form-action 'none'";
  data["scheme"] = scheme;
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
  data["measured"] = list_if("tables", input.faces);
  data["reasons"] = list_if("table", input.model ? reasons_section(*input.model) : std::string());
  data["provenance"] = provenance_section(verdict, input.model, input.sources, input.warnings);
  data["scripts"] = list_if("tabs", scripts_section(input.scripts));
  data["version"] = escaped(input.version);
  TemplateList maps;
  if (!map.json.empty()) {
    const MapParts parts = map_parts(input.scene, map);
    maps.push_back({{"choices", parts.choices},
                    {"scales", parts.scales},
                    {"remarks", parts.remarks},
                    {"data", parts.data},
                    {"program", program},
                    {"tolerance", print_number(verdict.tolerance)}});
  }
  data["map"] = maps;
  auto page = pack->render("page.html", data);
  ensure(page.ok(), page.ok() ? "" : page.error().message.c_str());
  return *page;
}

}  // namespace partscribe::cli
