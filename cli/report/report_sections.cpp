#include "cli/report/report_sections.h"

#include <algorithm>
#include <cmath>

#include "cli/describe.h"
#include "cli/report/report_code.h"
#include "cli/report/report_html.h"
#include "cli/report/report_words.h"
#include "codegen/describe.h"
#include "codegen/emit.h"
#include "core/number.h"

namespace partscribe::cli {
namespace {

std::string chip(bool good, const std::string& words) {
  return std::string("<span class=\"chip ") + (good ? "good" : "bad") + "\">" + words + "</span>";
}

std::string chip(Outcome outcome) {
  const char* css = outcome == Outcome::verified ? "good" : outcome == Outcome::out_of_tolerance ? "bad" : "open";
  return std::string("<span class=\"chip ") + css + "\">" + title_of(outcome) + "</span>";
}

/// A deviation with a small bar that is full at the tolerance.
std::string bar(double deviation, double tolerance) {
  const double share = std::clamp(std::abs(deviation) / tolerance, 0.0, 1.0);
  return "<span class=\"bar" + std::string(std::abs(deviation) > tolerance ? " over" : "") +
         "\" aria-hidden=\"true\"><i style=\"width:" + print_number(snapped(100 * share, 1)) +
         "%\"></i></span><span class=\"value\">" + escaped(readable(deviation)) + "</span>";
}

std::string place(const Vec3& p) {
  auto shown = [](double v) { return print_number(snapped(v, 0.01)); };
  return "(" + shown(p.x()) + ", " + shown(p.y()) + ", " + shown(p.z()) + ")";
}

double in_unit(double value, Quantity quantity) { return quantity == Quantity::angle ? degrees(value) : value; }

/// With a sign, and no more digits than a thousandth of the tolerance deserves.
std::string signed_number(double value, double step) {
  const double size = snapped(std::abs(value), step);
  return size == 0 ? "0" : (value < 0 ? "\xe2\x88\x92" : "+") + print_number(size);
}

std::string figure(const std::string& name, const std::string& value, const std::string& more) {
  return "<div><dt>" + escaped(name) + "</dt><dd>" + escaped(value) +
         (more.empty() ? "" : "<small>" + escaped(more) + "</small>") + "</dd></div>\n";
}

/// A row of the table that measures: nominal, measured, deviation.
void dimension_row(HtmlTable& table, const FeatureVerdict& feature, std::size_t row, const FeatureDimension& d,
                   double tolerance) {
  const std::string unit = unit_of(d.quantity);
  const double step = d.quantity == Quantity::angle ? 0.001 : power_of_ten_below(tolerance) / 1000;
  table.html_row({"<button type=\"button\" class=\"pick\" data-feature=\"" + std::to_string(row) + "\">" +
                      escaped(feature.name) + "</button>",
                  escaped(d.name), escaped(print_number(snapped(in_unit(d.nominal, d.quantity), step))),
                  escaped(with_sigma(in_unit(d.measured, d.quantity), in_unit(d.sigma, d.quantity))),
                  escaped(signed_number(in_unit(d.deviation, d.quantity), step)), escaped(unit),
                  d.within ? chip(true, "in") : chip(false, "out")},
                 d.within ? "" : " class=\"fault\"");
}

/// Of a script that the report shows; null of any other file.
const Language* language_of(const Path& file) {
  for (const auto& backend : backends())
    if (file.extension() == backend.suffix && !backend.language.keywords.empty()) return &backend.language;
  return nullptr;
}

}  // namespace

std::vector<ReportScript> read_scripts(const std::vector<Path>& files) {
  std::vector<ReportScript> scripts;
  for (const auto& file : files)
    if (language_of(file))
      if (auto text = read_file(file)) scripts.push_back({file.filename().string(), std::move(*text)});
  return scripts;
}

std::string figure_of(const ReportPicture& p, const std::string& css_class) {
  return "<figure" + (css_class.empty() ? "" : " class=\"" + css_class + "\"") + "><img width=\"" +
         std::to_string(p.width) + "\" height=\"" + std::to_string(p.height) + "\" alt=\"" + escaped(p.description) +
         "\" src=\"data:image/png;base64," + base64(p.png) + "\"><figcaption>" + escaped(p.title) +
         "</figcaption></figure>\n";
}

std::string key_figures(const Verdict& verdict, const std::optional<Model>& model) {
  const ArtifactVerdict* artifact = deciding_artifact(verdict);
  std::string text = figure("Tolerance", "\xc2\xb1 " + print_number(verdict.tolerance) + " mm", "allowed everywhere");
  if (artifact && artifact->model_to_data.area > 0) {
    const auto& d = artifact->data_to_model;
    const auto& m = artifact->model_to_data;
    text += figure(
        "Worst deviation", readable(d.local_max) + " mm",
        (d.local_max > 1.5 * verdict.tolerance ? readable(snapped(d.local_max / verdict.tolerance, 0.1)) + " times"
                                               : percent(d.local_max, verdict.tolerance) + " of") +
            " the tolerance; rms " + readable(d.rms) + " mm");
    text += figure("Surface not scanned", percent(m.not_scanned, m.area),
                   readable(m.not_scanned) + " of " + readable(m.area) + " mm\xc2\xb2");
    if (m.contradicted > 0)
      text += figure("Surface contradicted", percent(m.contradicted, m.area),
                     readable(m.contradicted) + " mm\xc2\xb2 that the scan denies");
    text += figure("Points compared", grouped(d.points), grouped(d.rejected) + " set aside as outliers");
  }
  text += figure("Smallest honest tolerance", readable(verdict.smallest_honest_tolerance) + " mm",
                 "below it this scan cannot decide");
  if (model) {
    const auto dimensions = model->parameters.size();
    text += figure("Described as", procedure_text(*model),
                   dimensions == 0
                       ? "no named dimensions"
                       : std::to_string(dimensions) + (dimensions == 1 ? " named dimension" : " named dimensions"));
  }
  return text;
}

std::string findings_section(const Verdict& verdict, const std::vector<ReportPicture>& pictures) {
  const ArtifactVerdict* drawn = drawn_artifact(verdict);
  std::string faults, elsewhere, unseen_pictures;
  HtmlTable unseen("Surface that was not scanned: no fault, but nobody looked",
                   {"where", "area mm\xc2\xb2#", "width mm#", "at x, y, z (mm)", "why", ""});
  for (const auto& artifact : verdict.artifacts) {
    if (&artifact != drawn) {
      std::size_t count = 0;
      for (const auto& f : artifact.findings) count += f.kind != Finding::Kind::not_scanned;
      if (count)
        elsewhere += "<li>" + escaped(artifact.file) + ": " + std::to_string(count) +
                     (count == 1 ? " finding" : " findings") +
                     ", the worst: " + typeset(artifact.findings.front().text) + "</li>\n";
      continue;
    }
    for (std::size_t k = 0; k < artifact.findings.size(); ++k) {
      const Finding& f = artifact.findings[k];
      const std::string number = std::to_string(k + 1);
      const std::string button = "<button type=\"button\" class=\"pick\" data-finding=\"" + std::to_string(k) +
                                 "\" aria-label=\"Show finding " + number + " on the map\">show</button>";
      if (f.kind == Finding::Kind::not_scanned) {
        unseen.html_row({escaped(f.feature.empty() ? "surface" : f.feature), escaped(readable(f.area)),
                         escaped(readable(f.extent)), escaped(place(f.place)), escaped(f.reason), button});
        for (const auto& picture : pictures)
          if (picture.name == "finding-" + number + ".png") unseen_pictures += figure_of(picture);
        continue;
      }
      faults += "<li class=\"finding\">";
      for (const auto& picture : pictures)
        if (picture.name == "finding-" + number + ".png") faults += figure_of(picture);
      faults += "<div><h3>" + number + ". " + title_of(f.kind) + (f.feature.empty() ? "" : ": " + escaped(f.feature)) +
                "</h3>\n<p>" + typeset(f.text) + "</p>\n<p class=\"facts\">" +
                (f.reason.empty() ? "" : escaped(f.reason) + "; ") + "area " + readable(f.area) +
                " mm\xc2\xb2, width " + readable(f.extent) + " mm, " + grouped(f.points) + " scanned points, at " +
                place(f.place) + " mm</p>\n<p class=\"onscreen\">" + button + "</p></div></li>\n";
    }
  }
  std::vector<std::string> reasons;
  for (const auto& a : verdict.artifacts)
    for (const auto& reason : a.reasons) reasons.push_back(a.file + ": " + reason);
  std::string text;
  if (!reasons.empty()) {
    text += "<h3>Why the verdict is what it is</h3>\n<ul>\n";
    for (const auto& reason : reasons) text += "<li>" + typeset(reason) + "</li>\n";
    text += "</ul>\n";
  }
  if (!faults.empty())
    text += "<ol class=\"findings\">\n" + faults + "</ol>\n";
  else if (verdict.verdict == Outcome::verified)
    text += "<p>None: no place was found where the model and the scan disagree.</p>\n";
  if (!elsewhere.empty()) text += "<h3>In the other files</h3>\n<ul>\n" + elsewhere + "</ul>\n";
  if (unseen.rows()) text += unseen.done();
  if (!unseen_pictures.empty()) text += "<div class=\"gallery\">\n" + unseen_pictures + "</div>\n";
  return text;
}

std::string features_section(const Verdict& verdict) {
  const ArtifactVerdict* artifact = drawn_artifact(verdict);
  if (!artifact)
    for (const auto& a : verdict.artifacts)
      if (!artifact && !a.objects.empty()) artifact = &a;
  if (!artifact || artifact->objects.empty()) return {};
  HtmlTable features("Each feature of " + artifact->file + " against the scan",
                     {"feature", "kind", "points#", "rms mm#", "largest local deviation mm#", "scanned#", "verdict"});
  HtmlTable dimensions(
      "Inspection: what the artifact says, and what was measured on the feature's own points",
      {"feature", "dimension", "nominal#", "measured \xc2\xb1 sigma#", "deviation#", "unit", "result"});
  for (std::size_t k = 0; k < artifact->objects.size(); ++k) {
    const FeatureVerdict& f = artifact->objects[k];
    features.html_row({"<button type=\"button\" class=\"pick\" data-feature=\"" + std::to_string(k) +
                           "\" aria-pressed=\"false\">" + escaped(f.name) + "</button>",
                       escaped(f.kind), grouped(f.points), escaped(readable(f.rms)), bar(f.max, verdict.tolerance),
                       escaped(percent(f.covered, 1)), chip(f.verdict)},
                      f.verdict == Outcome::out_of_tolerance ? " class=\"fault\"" : "");
    for (const auto& d : f.dimensions) dimension_row(dimensions, f, k, d, verdict.tolerance);
  }
  return features.done() + (dimensions.rows() ? dimensions.done() : std::string());
}

std::string artifacts_section(const Verdict& verdict) {
  HtmlTable table("Each file, evaluated by its own program and compared with the scan in both directions",
                  {"file", "verdict", "evaluated by", "largest local deviation mm#", "surface supported#",
                   "not scanned#", "contradicted#"});
  HtmlTable statistics("Distances of the scanned points to what each file describes (mm)",
                       {"file", "points#", "set aside#", "rms#", "50 %#", "95 %#", "99 %#", "largest single#",
                        "error of the evaluation#"});
  for (const auto& a : verdict.artifacts) {
    const auto& d = a.data_to_model;
    const auto& m = a.model_to_data;
    const bool compared = m.area > 0;
    table.html_row({escaped(a.file), chip(a.verdict), escaped(a.program + " " + a.version),
                    compared ? bar(d.local_max, verdict.tolerance) : "-", percent(m.supported, m.area),
                    percent(m.not_scanned, m.area), percent(m.contradicted, m.area)});
    if (compared)
      statistics.row({a.file, grouped(d.points), grouped(d.rejected), readable(d.rms), readable(d.p50), readable(d.p95),
                      readable(d.p99), readable(d.max), readable(a.evaluation_error)});
  }
  std::string text = table.done() + "<p>" + escaped(honesty_sentences(verdict)) + "</p>\n" +
                     (statistics.rows() ? statistics.done() : "");
  if (!verdict.between_backends.empty()) {
    HtmlTable pairs("Do the files describe the same part? Largest distance between them (mm)",
                    {"first", "second", "distance#", "agree"});
    for (const auto& pair : verdict.between_backends)
      pairs.html_row({escaped(pair.first), escaped(pair.second), readable(pair.distance),
                      pair.agree ? chip(true, "yes") : chip(false, "no")});
    text += pairs.done();
  }
  HtmlTable opinions("Second opinion: what other programs make of the same file",
                     {"file", "program", "distance mm#", "agrees", "note"});
  for (const auto& a : verdict.artifacts)
    for (const auto& o : a.second_opinions)
      opinions.html_row({escaped(a.file), escaped(o.program + " " + o.version),
                         o.delivered ? readable(o.distance) : "-",
                         !o.delivered ? "<span class=\"chip open\">no answer</span>"
                         : o.agrees   ? chip(true, "yes")
                                      : chip(false, "no"),
                         escaped(o.note)});
  return text + (opinions.rows() ? opinions.done() : std::string());
}

std::string parameters_section(const Model& model) {
  if (model.parameters.empty()) return "<p>The model has no dimension that a person would name.</p>\n";
  HtmlTable table("Named dimensions: the value in the procedure, and what the data said (one standard deviation)",
                  {"dimension", "value#", "unit", "fitted \xc2\xb1 sigma#", "of which noise#", "systematic#", "points#",
                   "nominal size", "what it is"});
  for (const auto& p : model.parameters) {
    const auto row = describe(p);
    auto part = [&](double sigma) { return p.sigma > 0 ? readable(in_unit(sigma, p.quantity)) : std::string(); };
    table.row({row.name, row.value, row.unit, row.fitted, part(p.sigma_noise), part(p.sigma_systematic),
               p.points ? grouped(p.points) : std::string(), row.nominal, row.note});
  }
  return table.done();
}

std::string reasons_section(const Model& model) {
  std::string text;
  if (const auto line = hypothesis_line(model); !line.empty())
    text += "<p>Recovered first, as a hypothesis: " + escaped(line) + ".</p>\n";
  HtmlTable steps("Steps of the procedure, and what the data say of each",
                  {"step", "shape", "points#", "rms mm#", "largest local deviation mm#", "scanned#", "views#", "note"});
  for (const auto& object : model.objects) {
    const auto& e = object.evidence;
    steps.row({object.name, std::string(kind_of(object.shape)), grouped(e.points), readable(e.rms), readable(e.max),
               percent(e.covered, 1), std::to_string(e.views), object.note});
  }
  text += steps.done();
  if (!model.rivals.empty()) {
    HtmlTable rivals(
        "Rivals: what else was considered, and why it lost",
        {"procedure", "meets the tolerance", "largest local deviation mm#", "description length#", "why not"});
    for (const auto& r : model.rivals)
      rivals.html_row({escaped(r.procedure), r.meets_tolerance ? chip(true, "yes") : chip(false, "no"),
                       escaped(readable(r.deviation)), escaped(readable(r.description_length)), escaped(r.reason)});
    text += rivals.done();
  }
  for (const auto& u : model.unexplained)
    text += "<p>Unexplained: " + escaped(u.reason) + " (" + readable(u.area) + " mm\xc2\xb2, " + grouped(u.points) +
            " points).</p>\n";
  return text;
}

std::string scripts_section(const std::vector<ReportScript>& scripts) {
  constexpr std::size_t most_bytes = 60000, most_lines = 500, longest_line = 400;
  std::string inputs, panels;
  for (std::size_t k = 0; k < scripts.size(); ++k) {
    const auto& script = scripts[k];
    std::string shown, gutter;
    std::size_t lines = 0, total = static_cast<std::size_t>(std::count(script.text.begin(), script.text.end(), '\n'));
    for (std::size_t at = 0; at < script.text.size() && lines < most_lines && shown.size() < most_bytes;) {
      const auto end = std::min(script.text.find('\n', at), script.text.size());
      const bool cut = end - at > longest_line;
      shown += script.text.substr(at, cut ? longest_line : end - at) + (cut ? " ..." : "") + "\n";
      gutter += std::to_string(++lines) + "\n";
      at = end + 1;
    }
    const std::string id = "script-" + std::to_string(k + 1);
    const Language* language = language_of(script.name);
    inputs += "<input type=\"radio\" name=\"script\" id=\"" + id + "\"" + (k == 0 ? " checked" : "") +
              "><label for=\"" + id + "\">" + escaped(script.name) + "</label>\n";
    panels += "<div class=\"panel\"><h3>" + escaped(script.name) + "</h3>\n";
    if (lines < total) panels += "<p>The first " + grouped(lines) + " of " + grouped(total) + " lines.</p>\n";
    panels += "<div class=\"code\" tabindex=\"0\" role=\"region\" aria-label=\"Text of " + escaped(script.name) +
              "\"><pre class=\"gutter\" aria-hidden=\"true\">" + gutter + "</pre><pre><code>" +
              (language ? highlighted(shown, *language) : escaped(shown)) + "</code></pre></div></div>\n";
  }
  if (scripts.empty()) return {};
  return "<div class=\"tabs\">\n" + inputs + panels + "</div>\n";
}

std::string provenance_section(const Verdict& verdict, const std::optional<Model>& model,
                               const std::vector<SourceFile>& sources, const std::vector<std::string>& warnings) {
  HtmlTable files("Files of the scan", {"file", "SHA-256"}, "wide");
  for (const auto& source : model ? model->provenance.sources : sources)
    files.html_row({escaped(source.file), "<code>" + escaped(source.sha256) + "</code>"});
  HtmlTable table("The scan and the run", {"what", "value"});
  if (model) {
    const auto& p = model->provenance;
    table.row({"points read", grouped(p.points)});
    table.row({"points set aside by the filter", grouped(p.rejected)});
    table.row({"views", std::to_string(p.views)});
    table.row({"noise along the normal", readable(p.noise) + " mm"});
    table.row({"distance between points", readable(p.spacing) + " mm"});
    table.row({"file units to mm", print_number(p.unit_scale)});
    table.row({"written by", p.program + " " + p.version});
    if (!p.options.empty()) table.row({"options", p.options});
  }
  for (const auto& a : verdict.artifacts)
    if (!a.program.empty())
      table.row(
          {a.file + " evaluated by", a.program + " " + a.version + ", " + readable(snapped(a.seconds, 0.01)) + " s"});
  return (files.rows() ? files.done() : std::string()) + table.done() +
         (warnings.empty() ? std::string() : "<h3>Warnings of the reader</h3>\n" + html_list(warnings));
}

}  // namespace partscribe::cli
