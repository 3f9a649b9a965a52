#include "cli/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "cli/describe.h"
#include "core/number.h"

namespace partscribe {
namespace {

constexpr const char* style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1b2430; background: #fff; max-width: 1180px; margin: 0 auto;
  padding: 1.5rem; }
h1 { margin: 0 0 .2rem; } h2 { margin: 2.2rem 0 .6rem; border-bottom: 1px solid #ccd2da; }
.verdict { padding: .9rem 1.1rem; border-left: .5rem solid; border-radius: .3rem; margin: 1rem 0; }
.verdict strong { font-size: 1.25rem; display: block; }
.verified { background: #e8f5ea; border-color: #1e7d34; } .out_of_tolerance { background: #fdeaea; border-color: #b3261e; }
.cannot_decide, .not_run { background: #fff5dd; border-color: #a86b00; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding: .4rem 0; }
th, td { padding: .28rem .7rem; border-bottom: 1px solid #dde2e8; text-align: left; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; } td.number { white-space: nowrap; }
thead th { background: #f2f4f7; }
.pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 1rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; border: 1px solid #dde2e8; }
figcaption { font-size: .9rem; } .scale { max-width: 30rem; margin: .8rem 0; }
.bar { height: 1rem; border: 1px solid #888; display: flex; } .bar span { flex: 1; }
.marks { position: relative; height: 1.4rem; font-size: .85rem; }
.marks span { position: absolute; transform: translateX(-50%); white-space: nowrap; }
pre { background: #f6f7f9; padding: 1rem; overflow-x: auto; font-size: .85rem; line-height: 1.35; }
canvas { width: 100%; max-width: 780px; border: 1px solid #dde2e8; touch-action: none; cursor: grab; }
@media print { body { max-width: none; padding: 0; font-size: 11pt; } .interactive { display: none; }
  pre { white-space: pre-wrap; } figure, tr { break-inside: avoid; } }
)";

// Turns a few thousand coloured points with the mouse or the arrow keys on a plain 2-D canvas: no library, no WebGL.
constexpr const char* viewer = R"js(
(function () {
  const canvas = document.getElementById("map"), pen = canvas.getContext("2d");
  const bytes = Uint8Array.from(atob(document.getElementById("points").textContent.trim()), c => c.charCodeAt(0));
  const data = new DataView(bytes.buffer), count = bytes.length / 9;
  const place = new Float32Array(3 * count), color = [];
  for (let i = 0; i < count; i++) {
    for (let k = 0; k < 3; k++) place[3 * i + k] = data.getInt16(9 * i + 2 * k, true) / 32767;
    color.push("rgb(" + bytes[9 * i + 6] + "," + bytes[9 * i + 7] + "," + bytes[9 * i + 8] + ")");
  }
  let turn = -0.65, tilt = 0.5, zoom = 1;
  function draw() {
    const w = canvas.width, h = canvas.height, s = Math.min(w, h) * 0.5 * zoom;
    const c = Math.cos(turn), d = Math.sin(turn), e = Math.cos(tilt), f = Math.sin(tilt);
    const order = new Array(count), at = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) {
      const x = place[3 * i], y = place[3 * i + 1], z = place[3 * i + 2];
      const side = c * x - d * y, away = d * x + c * y;
      at[3 * i] = w / 2 + s * side;
      at[3 * i + 1] = h / 2 - s * (e * z + f * away);
      at[3 * i + 2] = e * away - f * z;
      order[i] = i;
    }
    order.sort((a, b) => at[3 * b + 2] - at[3 * a + 2]);
    pen.fillStyle = "#fafaf8";
    pen.fillRect(0, 0, w, h);
    const r = Math.max(2, Math.min(8, zoom * 260 / Math.sqrt(count)));
    for (const i of order) {
      pen.fillStyle = color[i];
      pen.fillRect(at[3 * i] - r / 2, at[3 * i + 1] - r / 2, r, r);
    }
  }
  let last = null;
  canvas.addEventListener("pointerdown", e => { last = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointerup", () => { last = null; });
  canvas.addEventListener("pointermove", e => {
    if (!last) return;
    turn += (e.clientX - last[0]) * 0.01;
    tilt += (e.clientY - last[1]) * 0.01;
    last = [e.clientX, e.clientY];
    draw();
  });
  canvas.addEventListener("wheel", e => { e.preventDefault(); zoom *= Math.exp(-e.deltaY * 0.001); draw(); }, { passive: false });
  canvas.addEventListener("keydown", e => {
    const step = { ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1],
      "+": [0, 0, 1.1], "-": [0, 0, 1 / 1.1] }[e.key];
    if (!step) return;
    e.preventDefault();
    turn += step[0]; tilt += step[1]; zoom *= step[2];
    draw();
  });
  draw();
})();
)js";

std::string headline(Outcome outcome, const std::string& tolerance) {
  switch (outcome) {
    case Outcome::verified:
      return "Verified: every artifact agrees with the scan within " + tolerance + " mm.";
    case Outcome::out_of_tolerance:
      return "Out of tolerance: an artifact differs from the scan by more than " + tolerance + " mm.";
    case Outcome::cannot_decide:
      return "Cannot decide: the scan is too noisy or too coarse for " + tolerance + " mm.";
    case Outcome::not_run:
      break;
  }
  return "Not run: a program that is needed to evaluate an artifact is missing.";
}

std::string plain(Outcome outcome) {
  std::string words = name_of(outcome);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// A table with a caption; columns whose heading ends in "#" hold numbers.
class Table {
 public:
  Table(const std::string& caption, const std::vector<std::string>& headings) {
    text_ = "<div class=\"scroll\"><table><caption>" + escaped(caption) + "</caption><thead><tr>";
    for (std::string heading : headings) {
      numeric_.push_back(heading.ends_with('#'));
      if (numeric_.back()) heading.pop_back();
      text_ += std::string("<th scope=\"col\"") + (numeric_.back() ? " class=\"number\">" : ">") + escaped(heading) +
               "</th>";
    }
    text_ += "</tr></thead><tbody>\n";
  }
  void row(const std::vector<std::string>& cells) {
    text_ += "<tr>";
    for (std::size_t k = 0; k < cells.size(); ++k)
      text_ += (k == 0        ? "<th scope=\"row\">"
                : numeric_[k] ? "<td class=\"number\">"
                              : "<td>") +
               escaped(cells[k]) + (k == 0 ? "</th>" : "</td>");
    text_ += "</tr>\n";
  }
  std::string done() const { return text_ + "</tbody></table></div>\n"; }

 private:
  std::string text_;
  std::vector<bool> numeric_;
};

std::string percent(double part, double whole) {
  return whole > 0 ? print_number(snapped(100 * part / whole, 0.1)) + " %" : "-";
}

std::string list_of(const std::vector<std::string>& lines) {
  std::string text = "<ul>\n";
  for (const auto& line : lines) text += "<li>" + escaped(line) + "</li>\n";
  return text + "</ul>\n";
}

std::string verdict_section(const Verdict& verdict) {
  Table table("Each artifact, evaluated by its own program and compared with the scan in both directions (mm)",
              {"file", "program", "verdict", "largest local deviation#", "rms#", "95 %#", "99 %#", "largest raw#",
               "points#", "set aside#", "surface supported#", "not scanned#", "contradicted#"});
  for (const auto& a : verdict.artifacts) {
    const DataToModel& d = a.data_to_model;
    const ModelToData& m = a.model_to_data;
    table.row({Path(a.file).filename().string(), a.program + " " + a.version, plain(a.verdict), readable(d.local_max),
               readable(d.rms), readable(d.p95), readable(d.p99), readable(d.max), std::to_string(d.points),
               std::to_string(d.rejected), percent(m.supported, m.area), percent(m.not_scanned, m.area),
               percent(m.contradicted, m.area)});
  }
  std::string text = "<h2>Verdict</h2>\n" + table.done();
  std::vector<std::string> reasons;
  for (const auto& a : verdict.artifacts)
    for (const auto& reason : a.reasons) reasons.push_back(Path(a.file).filename().string() + ": " + reason);
  if (!reasons.empty()) text += "<h3>What the verifier has to say</h3>\n" + list_of(reasons);
  text += "<p>The smallest tolerance about which this scan can decide is " +
          readable(verdict.smallest_honest_tolerance) + " mm; its noise is " + readable(verdict.noise) + " mm.</p>\n";
  for (const auto& a : verdict.artifacts) {
    if (a.objects.empty()) continue;
    Table rows("Features, by " + Path(a.file).filename().string() + " (mm)",
               {"feature", "points#", "rms#", "largest local deviation#", "covered#", "verdict"});
    for (const auto& f : a.objects)
      rows.row({f.name, std::to_string(f.points), readable(f.rms), readable(f.max), percent(f.covered, 1),
                plain(f.verdict)});
    text += rows.done();
    break;  // the features of the other artifacts are the same, and in verdict.json
  }
  if (!verdict.between_backends.empty()) {
    Table pairs("Distance between what the artifacts describe (mm)", {"first", "second", "distance#", "agree"});
    for (const auto& pair : verdict.between_backends)
      pairs.row({pair.first, pair.second, readable(pair.distance), pair.agree ? "yes" : "no"});
    text += pairs.done();
  }
  return text;
}

std::string css(Color c) {
  return "rgb(" + std::to_string(c.red) + "," + std::to_string(c.green) + "," + std::to_string(c.blue) + ")";
}

std::string scale_bar(double tolerance) {
  std::string text =
      "<div class=\"scale\" role=\"img\" aria-label=\"Colour scale: blue lies behind the model's "
      "surface, orange in front of it, magenta is beyond the tolerance of " +
      print_number(tolerance) + " mm\"><div class=\"bar\">";
  for (int k = -14; k <= 14; ++k)
    text += "<span style=\"background:" + css(deviation_color(k / 12.0 * tolerance, tolerance)) + "\"></span>";
  const std::string t = print_number(tolerance);
  // The marks stand where the magenta ends begin: after 2 of 29 pieces.
  return text + "</div><div class=\"marks\"><span style=\"left:6.9%\">&minus;" + t +
         " mm</span><span style=\"left:50%\">0</span><span style=\"left:93.1%\">+" + t +
         " mm</span></div>Blue: the scan lies behind the model's surface; orange: in front of it; magenta: beyond the "
         "tolerance.</div>\n";
}

std::string picture_section(const ReportInput& input) {
  std::string text = "<h2>Pictures</h2>\n<div class=\"pictures\">\n";
  bool has_map = false;
  for (const auto& p : input.pictures) {
    text += "<figure><img width=\"" + std::to_string(p.width) + "\" height=\"" + std::to_string(p.height) +
            "\" alt=\"" + escaped(p.description) + "\" src=\"data:image/png;base64," + base64(p.png) +
            "\"><figcaption>" + escaped(p.title) + "</figcaption></figure>\n";
    has_map = has_map || p.name.starts_with("deviation");
  }
  text += "</div>\n";
  return has_map ? text + scale_bar(input.verdict.tolerance) : text;
}

/// At most 30,000 points as int16 places in the part's frame and a colour: 9 bytes each.
std::string viewer_section(const ReportInput& input) {
  const auto deviations = deviations_of(input.cloud, drawn_artifact(input.verdict));
  if (deviations.empty()) return {};
  const Pose part_from_scan =
      input.model.as_scanned ? evaluate(input.model.scan_from_part, values_of(input.model)).inverse() : Pose{};
  Box3 box;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < deviations.size(); ++i)
    if (std::isfinite(deviations[i])) kept.push_back(i), box.add(part_from_scan * input.cloud.points[i]);
  if (kept.empty()) return {};
  const std::size_t step = (kept.size() + 29999) / 30000;
  const double scale = 32000 / std::max(0.5 * box.diagonal(), 1e-9);
  std::string bytes;
  for (std::size_t k = 0; k < kept.size(); k += step) {
    const Vec3 p = (part_from_scan * input.cloud.points[kept[k]] - box.center()) * scale;
    for (int axis = 0; axis < 3; ++axis) {
      const auto v = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(p[axis])));
      bytes += static_cast<char>(v & 0xff);
      bytes += static_cast<char>(v >> 8);
    }
    const Color c = deviation_color(deviations[kept[k]], input.verdict.tolerance);
    for (const auto part : {c.red, c.green, c.blue}) bytes += static_cast<char>(part);
  }
  return "<section class=\"interactive\"><h2>Deviation map to turn</h2>\n<p>Drag or use the arrow keys to turn, the "
         "wheel or + and - to come closer. Every " +
         (step == 1 ? std::string("point") : std::to_string(step) + "th point") +
         " is shown.</p>\n<canvas id=\"map\" width=\"1000\" height=\"700\" tabindex=\"0\" role=\"img\" "
         "aria-label=\"The "
         "scanned points coloured by deviation; the pictures above show the same\"></canvas>\n" +
         scale_bar(input.verdict.tolerance) + "<script id=\"points\" type=\"text/plain\">" + base64(bytes) +
         "</script>\n<script>" + viewer + "</script></section>\n";
}

std::string model_section(const Model& model) {
  std::string text = "<h2>What was found</h2>\n<p>" + escaped(procedure_text(model)) + ".</p>\n";
  if (!model.parameters.empty()) {
    Table table("Named dimensions: the value in the procedure, and what the data said",
                {"dimension", "value#", "unit", "fitted ± sigma#", "points#", "nominal", "what it is"});
    for (const auto& parameter : model.parameters) {
      const auto row = describe(parameter);
      table.row({row.name, row.value, row.unit, row.fitted, row.points, row.nominal, row.note});
    }
    text += table.done();
  }
  Table steps("Steps of the procedure, and what the data say of each",
              {"step", "shape", "points#", "rms mm#", "largest local deviation mm#", "covered#", "views#", "note"});
  for (const auto& object : model.objects) {
    const auto& e = object.evidence;
    steps.row({object.name, std::string(kind_of(object.shape)), std::to_string(e.points), readable(e.rms),
               readable(e.max), percent(e.covered, 1), std::to_string(e.views), object.note});
  }
  text += steps.done();
  for (const auto& u : model.unexplained)
    text += "<p>Unexplained: " + escaped(u.reason) + " (" + readable(u.area) + " mm², " + std::to_string(u.points) +
            " points).</p>\n";
  text += "<h2>Why this procedure</h2>\n";
  if (const auto line = hypothesis_line(model); !line.empty())
    text += "<p>Recovered first, as a hypothesis: " + escaped(line) + ".</p>\n";
  if (!model.rivals.empty()) {
    Table rivals("What was considered",
                 {"procedure", "meets the tolerance", "largest local deviation mm#", "description length#", "why not"});
    for (const auto& r : model.rivals)
      rivals.row({r.procedure, r.meets_tolerance ? "yes" : "no", readable(r.deviation), readable(r.description_length),
                  r.reason});
    text += rivals.done();
  }
  return text;
}

std::string provenance_section(const Model& model, const std::vector<std::string>& warnings) {
  const auto& p = model.provenance;
  Table table("The scan and the run", {"what", "value"});
  for (const auto& source : p.sources) table.row({"file " + source.file, "SHA-256 " + source.sha256});
  table.row({"points read", std::to_string(p.points)});
  table.row({"points set aside", std::to_string(p.rejected)});
  table.row({"views", std::to_string(p.views)});
  table.row({"noise along the normal", readable(p.noise) + " mm"});
  table.row({"distance between points", readable(p.spacing) + " mm"});
  table.row({"file units to mm", print_number(p.unit_scale)});
  table.row({"program", p.program + " " + p.version});
  if (!p.options.empty()) table.row({"options", p.options});
  std::string text = "<h2>Provenance</h2>\n" + table.done();
  if (!warnings.empty()) text += "<h3>Warnings of the reader</h3>\n" + list_of(warnings);
  return text;
}

std::string script_section(const ReportInput& input) {
  if (input.script.empty()) return {};
  constexpr std::size_t shown_bytes = 200000;
  std::string shown = input.script.substr(0, shown_bytes);
  std::string text = "<h2>The procedure: " + escaped(input.script_name) + "</h2>\n";
  if (shown.size() < input.script.size()) {
    shown.erase(shown.rfind('\n') + 1);
    text += "<p>Only the beginning; the file has " + std::to_string(input.script.size()) + " bytes.</p>\n";
  }
  return text + "<pre><code>" + escaped(shown) + "</code></pre>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string base64(const std::string& bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string report_page(const ReportInput& input) {
  const Model& model = input.model;
  const Verdict& verdict = input.verdict;
  const std::string tolerance = print_number(verdict.tolerance);
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>" +
      escaped(model.name) + ": " + plain(verdict.verdict) + "</title>\n<style>" + style +
      "</style></head>\n<body><header><h1>" + escaped(model.name) + "</h1>\n<p>" + escaped(procedure_text(model)) +
      ". Tolerance " + tolerance + " mm.</p></header>\n<main>\n";
  page += std::string("<div class=\"verdict ") + name_of(verdict.verdict) + "\"><strong>" +
          escaped(headline(verdict.verdict, tolerance)) + "</strong>" +
          (model.fallback ? "The model is a triangulation, because no procedure met the tolerance." : "") + "</div>\n";
  page += picture_section(input) + verdict_section(verdict) + model_section(model) + viewer_section(input) +
          provenance_section(model, input.warnings) + script_section(input);
  return page + "</main><footer><p>Written by partscribe " + escaped(model.provenance.version) +
         ".</p></footer></body></html>\n";
}

}  // namespace partscribe
