/// A verdict as text: JSON for programs, JUnit for build servers, CSV for sheets, a table for people.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/csv_text.h"
#include "core/json_text.h"
#include "core/number.h"
#include "verify/align/align.h"
#include "verify/report/words.h"
#include "verify/verify.h"

namespace partscribe::verify {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t width = 100;         // columns
constexpr std::size_t most_rows = 60;      // of features without fault that a table shows
constexpr std::size_t most_findings = 12;  // that a table shows

double rounded(double v) { return snapped(v, 1e-6); }

/// `text` padded or cut to `columns` columns; what is cut ends in "~".
std::string column(const std::string& text, std::size_t columns, bool right = false) {
  if (text.size() > columns) return text.substr(0, columns - 1) + "~";
  const std::string space(columns - text.size(), ' ');
  return right ? space + text : text + space;
}

std::string xml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (static_cast<unsigned char>(c) < 32)
      escaped += ' ';
    else
      escaped += c;
  }
  return escaped;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += (text.empty() ? "" : "; ") + line;
  return text;
}

const char* name_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::length:
      return "length";
    case Quantity::angle:
      return "angle";
    case Quantity::count:
      return "count";
    case Quantity::ratio:
      return "ratio";
  }
  return "length";
}

/// Angles to a billionth of a radian, all else to a millionth.
double rounded(double v, Quantity quantity) { return snapped(v, quantity == Quantity::angle ? 1e-9 : 1e-6); }

Json vector_json(const Vec3& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

Json dimension_json(const FeatureDimension& d) {
  const auto q = d.quantity;
  return {{"name", d.name},
          {"quantity", name_of(q)},
          {"nominal", rounded(d.nominal, q)},
          {"measured", rounded(d.measured, q)},
          {"sigma", rounded(d.sigma, q)},
          {"deviation", rounded(d.deviation, q)},
          {"within", d.within}};
}

Json feature_json(const FeatureVerdict& o) {
  Json entry = {{"name", o.name},
                {"kind", o.kind},
                {"points", o.points},
                {"rms", rounded(o.rms)},
                {"max", rounded(o.max)},
                {"covered", rounded(o.covered)},
                {"verdict", name_of(o.verdict)},
                {"dimensions", Json::array()}};
  for (const auto& d : o.dimensions) entry["dimensions"].push_back(dimension_json(d));
  return entry;
}

Json finding_json(const Finding& f) {
  return {{"kind", name_of(f.kind)},
          {"feature", f.feature},
          {"place", vector_json(f.place)},
          {"direction", vector_json(f.direction)},
          {"deviation", rounded(f.deviation)},
          {"area", rounded(f.area)},
          {"extent", rounded(f.extent)},
          {"points", f.points},
          {"reason", f.reason},
          {"text", f.text}};
}

bool was_compared(const ArtifactVerdict& artifact) { return artifact.model_to_data.area > 0; }

std::string percent(double part, double whole) { return whole > 0 ? shown(100 * part / whole, 0.1) + " %" : "-"; }

std::string main_reason(const Verdict& verdict) {
  for (const auto& artifact : verdict.artifacts)
    if (artifact.verdict == verdict.verdict && !artifact.reasons.empty())
      return (verdict.artifacts.size() > 1 ? artifact.file + ": " : "") + artifact.reasons.front();
  for (const auto& pair : verdict.between_backends)
    if (!pair.agree) return pair.first + " and " + pair.second + " differ by " + shown(pair.distance, 0.0001) + " mm";
  return name_of(verdict.verdict);
}

/// What the findings say of one feature; else what its numbers do.
std::string failure_of(const ArtifactVerdict& artifact, const FeatureVerdict& feature) {
  std::vector<std::string> lines;
  for (const auto& f : artifact.findings)
    if (f.kind != Finding::Kind::not_scanned &&
        (f.feature == feature.name || f.text.find(feature.name + " at (") != std::string::npos))
      lines.push_back(f.text);
  if (lines.empty())
    lines.push_back("deviates by " + shown(feature.max, 0.0001) + " mm, covered " + shown(feature.covered, 0.001));
  return joined(lines);
}

/// `line` broken at spaces so that no line is wider than the table; what follows the first is indented.
std::string wrapped(const std::string& line, std::size_t indent) {
  std::string text, rest = line;
  while (rest.size() > width) {
    auto cut = rest.rfind(' ', width);
    if (cut == std::string::npos || cut <= indent) break;
    text += rest.substr(0, cut) + "\n";
    rest = std::string(indent, ' ') + rest.substr(cut + 1);
  }
  return text + rest + "\n";
}

/// Faults, the worst first; of what was not scanned, how much and where most of it is.
std::string finding_lines(const ArtifactVerdict& a) {
  std::string text;
  std::size_t shown = 0, faults = 0, unscanned = 0;
  for (const auto& f : a.findings) {
    const bool fault = f.kind != Finding::Kind::not_scanned;
    ++(fault ? faults : unscanned);
    if (fault ? faults > most_findings : unscanned > 2) continue;
    text += wrapped("  " + std::string(fault ? std::to_string(++shown) + ". " : "-  ") + f.text, 5);
  }
  if (faults > most_findings) text += "  and " + std::to_string(faults - most_findings) + " more\n";
  if (text.empty()) return text;
  const char* title = faults == 0                      ? "what was not scanned"
                      : a.verdict == Outcome::verified ? "what deserves a look"
                                                       : "what is wrong, the worst first";
  return "\n" + a.file + ", " + title + "\n" + text;
}

/// The first artifact that describes the same surface as artifact `i` and is judged alike: `i` itself if none does.
std::size_t first_like(const Verdict& verdict, std::size_t i) {
  const double same = 1e-3 * verdict.tolerance,
               alike = 1e-2 * verdict.tolerance;  // mm: between surfaces; between what is found of them
  const auto& a = verdict.artifacts[i];
  for (std::size_t k = 0; k < i; ++k) {
    const auto& b = verdict.artifacts[k];
    if (a.file == b.file || a.verdict != b.verdict || a.alignment.has_value() != b.alignment.has_value()) continue;
    if (std::abs(a.data_to_model.local_max - b.data_to_model.local_max) > alike) continue;
    for (const auto& p : verdict.between_backends)
      if (p.agree && p.first == b.file && p.second == a.file && p.distance <= same) return k;
  }
  return i;
}

/// Which artifacts have the faults of another one, because they have its surface; `like`: of each artifact the first
/// one that has it.
std::string same_surface_lines(const Verdict& verdict, const std::vector<std::size_t>& like) {
  std::string text;
  for (std::size_t i = 0; i < like.size(); ++i) {
    std::vector<std::string> others;
    for (std::size_t k = i + 1; k < like.size(); ++k)
      if (like[k] == i) others.push_back(verdict.artifacts[k].file);
    if (!others.empty() && verdict.artifacts[i].verdict != Outcome::verified)
      text += wrapped("  The same is wrong with " + listed(others) + ".", 4);
  }
  return text;
}

/// How far the artifacts are from each other: one line for all where they agree, else each pair that differs.
std::string agreement_lines(const Verdict& verdict) {
  const auto& pairs = verdict.between_backends;
  if (pairs.empty()) return {};
  std::string text = "\n";
  double farthest = 0;
  std::size_t agree = 0;
  for (const auto& p : pairs) {
    if (p.agree)
      farthest = std::max(farthest, p.distance), ++agree;
    else
      text += p.first + " and " + p.second + " DIFFER: " + shown(p.distance, 0.0001) + " mm apart\n";
  }
  if (agree == 0) return text;
  const std::string apart = shown(farthest, 0.0001) + " mm apart\n";
  if (pairs.size() == 1) return text + pairs[0].first + " and " + pairs[0].second + " agree: " + apart;
  return text +
         (agree == pairs.size() ? "All files agree with each other: at most "
                                : "The other pairs of files agree: at most ") +
         apart;
}

/// The inspection rows of the features that are out of tolerance.
std::string failing_dimensions(const ArtifactVerdict& a) {
  std::string text;
  for (const auto& o : a.objects) {
    if (o.verdict == Outcome::verified) continue;
    for (const auto& d : o.dimensions) {
      const bool angle = d.quantity == Quantity::angle;
      auto value = [&](double v) { return shown(angle ? degrees(v) : v, 0.001); };
      text += "  " + column(column(o.name, 29), 30) + column(column(d.name + (angle ? " [deg]" : ""), 21), 22) +
              column(value(d.nominal), 10, true) + column(value(d.measured), 10, true) +
              column(value(d.sigma), 9, true) + column(value(d.deviation), 10, true) + (d.within ? "  in" : "  OUT") +
              "\n";
    }
  }
  if (text.empty()) return text;
  return "\n" + column(a.file + ", inspection", 54) + column("nominal", 10, true) + column("measured", 10, true) +
         column("sigma", 9, true) + column("deviation", 10, true) + "\n" + text;
}

Json opinion_json(const SecondOpinion& o) {
  return {{"program", o.program},
          {"version", o.version},
          {"delivered", o.delivered},
          {"agrees", o.agrees},
          {"exact_circles", o.exact_circles},
          {"distance", rounded(o.distance)},
          {"note", o.note}};
}

std::string opinion_lines(const ArtifactVerdict& a) {
  std::string text;
  for (const auto& o : a.second_opinions) {
    std::string line = o.program + " " + o.version + " on " + a.file + ": ";
    if (!o.delivered)
      line += "no answer, " + o.note;
    else
      line += (o.agrees ? "agrees, " : "DIFFERS, ") + shown(o.distance, 0.0001) + " mm apart" +
              (!o.agrees && o.exact_circles ? " (it reads polygons as circles)" : "");
    text += wrapped(line, 2);
  }
  return text;
}

Json alignment_json(const Alignment& alignment) {
  Json json;
  json["method"] = name_of(alignment.method);
  Json rows = Json::array();
  const Pose& pose = alignment.scan_to_artifact;
  for (int r = 0; r < 3; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 3; ++c) row.push_back(snapped(pose.rotation(r, c), 1e-12));
    row.push_back(rounded(pose.translation[r]));
    rows.push_back(std::move(row));
  }
  rows.push_back({0, 0, 0, 1});
  json["scan_to_artifact"] = std::move(rows);
  json["rotation_degrees"] = rounded(degrees(alignment.rotation));
  const Vec3& t = alignment.translation;
  json["translation"] = {rounded(t.x()), rounded(t.y()), rounded(t.z())};
  json["rms"] = rounded(alignment.rms);
  json["points"] = alignment.points;
  json["remark"] = alignment.remark;
  return json;
}

/// Loudly: what was judged is not how the files lie.
std::string alignment_lines(const ArtifactVerdict& artifact) {
  if (!artifact.alignment) return "";
  const Alignment& a = *artifact.alignment;
  const std::string motion = a.moves()
                                 ? "before it was compared with " + artifact.file + ", the scan was " + words_for(a)
                                 : "the scan lies on " + artifact.file + " as it should and was not moved";
  return wrapped("ALIGNED (" + std::string(name_of(a.method)) + "): " + motion + "; rms " + shown(a.rms, 0.0001) +
                     " mm over " + std::to_string(a.points) + " points" + (a.remark.empty() ? "" : "; " + a.remark),
                 2);
}

/// What the scan is good for, and how much of it was not believed.
std::string scan_lines(const Verdict& verdict) {
  std::string text = snapped(verdict.smallest_honest_tolerance, 0.0001) > 0
                         ? "The scan's local noise is " + shown(verdict.noise, 0.0001) +
                               " mm; it can decide tolerances from " +
                               shown(verdict.smallest_honest_tolerance, 0.0001) + " mm.\n"
                         : "The scan has no noise that could be measured; it can decide any tolerance.\n";
  const DataToModel* most = nullptr;
  for (const auto& a : verdict.artifacts)
    if (was_compared(a) && a.data_to_model.rejected > 0 && (!most || a.data_to_model.rejected > most->rejected))
      most = &a.data_to_model;
  if (!most) return text;
  const auto all = static_cast<double>(most->points + most->rejected);
  const std::size_t here = most->rejected - std::min(most->set_aside, most->rejected);
  const auto rejected = static_cast<double>(most->rejected);
  const std::string share = 2000 * rejected < all ? "under 0.1 %" : percent(rejected, all);
  const std::string alone = "since they stand alone off the artifact";
  const std::string why = most->set_aside == 0 ? ", " + alone
                          : here == 0          ? std::string(", by a filter or by the fit")
                                      : ": " + std::to_string(most->set_aside) + " by a filter or by the fit, " +
                                            std::to_string(here) + " " + alone;
  return text + wrapped(std::to_string(most->rejected) + " of " + print_number(all) + " points (" + share +
                            ") were set aside as outliers" + why + ".",
                        2);
}

}  // namespace

std::string write_verdict_json(const Verdict& verdict) {
  Json json;
  json["verdict"] = name_of(verdict.verdict);
  json["tolerance"] = verdict.tolerance;
  json["smallest_honest_tolerance"] = rounded(verdict.smallest_honest_tolerance);
  json["noise"] = rounded(verdict.noise);
  json["artifacts"] = Json::array();
  for (const auto& a : verdict.artifacts) {
    Json entry;
    entry["file"] = a.file;
    entry["backend"] = a.backend;
    entry["program"] = a.program;
    entry["version"] = a.version;
    entry["verdict"] = name_of(a.verdict);
    entry["seconds"] = snapped(a.seconds, 0.001);
    entry["evaluation_error"] = rounded(a.evaluation_error);
    if (a.alignment) entry["alignment"] = alignment_json(*a.alignment);
    entry["reasons"] = a.reasons;
    if (was_compared(a)) {
      const auto& d = a.data_to_model;
      const Vec3& w = d.worst;
      entry["data_to_model"] = {
          {"points", d.points},       {"rejected", d.rejected},
          {"set_aside", d.set_aside}, {"local_max", rounded(d.local_max)},
          {"rms", rounded(d.rms)},    {"p50", rounded(d.p50)},
          {"p95", rounded(d.p95)},    {"p99", rounded(d.p99)},
          {"max", rounded(d.max)},    {"worst", {rounded(w.x()), rounded(w.y()), rounded(w.z())}}};
      const auto& m = a.model_to_data;
      entry["model_to_data"] = {{"area", rounded(m.area)},
                                {"supported", rounded(m.supported)},
                                {"not_scanned", rounded(m.not_scanned)},
                                {"contradicted", rounded(m.contradicted)}};
    }
    entry["objects"] = Json::array();
    for (const auto& o : a.objects) entry["objects"].push_back(feature_json(o));
    entry["findings"] = Json::array();
    for (const auto& f : a.findings) entry["findings"].push_back(finding_json(f));
    for (const auto& o : a.second_opinions) entry["second_opinions"].push_back(opinion_json(o));
    json["artifacts"].push_back(std::move(entry));
  }
  json["between_backends"] = Json::array();
  for (const auto& p : verdict.between_backends)
    json["between_backends"].push_back(
        {{"first", p.first}, {"second", p.second}, {"distance", rounded(p.distance)}, {"agree", p.agree}});
  return json_text(json);
}

std::string write_verdict_csv(const Verdict& verdict) {
  std::string text =
      "file,backend,feature,kind,dimension,unit,nominal,measured,sigma,deviation,within,points,rms,max,covered,"
      "verdict\n";
  auto number = [](double v) { return print_number(rounded(v)); };
  for (const auto& a : verdict.artifacts) {
    const std::string start = quoted_csv(a.file) + "," + quoted_csv(a.backend) + ",";
    auto quality = [&](std::size_t points, double rms, double max, double covered, Outcome outcome) {
      return std::to_string(points) + "," + number(rms) + "," + number(max) + "," + number(covered) + "," +
             name_of(outcome) + "\n";
    };
    const auto& d = a.data_to_model;
    const double covered = was_compared(a) ? a.model_to_data.supported / a.model_to_data.area : 0;
    text += start + "all,,,,,,,,," + quality(d.points, d.rms, d.local_max, covered, a.verdict);
    for (const auto& o : a.objects) {
      const std::string feature = start + quoted_csv(o.name) + "," + quoted_csv(o.kind) + ",";
      const std::string end = quality(o.points, o.rms, o.max, o.covered, o.verdict);
      if (o.dimensions.empty()) text += feature + ",,,,,,," + end;
      for (const auto& dimension : o.dimensions) {
        const bool angle = dimension.quantity == Quantity::angle;
        auto value = [&](double v) { return number(angle ? degrees(v) : v) + ","; };
        text += feature + quoted_csv(dimension.name) + "," + (angle ? "deg," : "mm,") + value(dimension.nominal) +
                value(dimension.measured) + value(dimension.sigma) + value(dimension.deviation) +
                (dimension.within ? "yes," : "no,") + end;
      }
    }
  }
  return text;
}

std::string write_verdict_junit(const Verdict& verdict) {
  std::string body;
  std::size_t tests = 0, failures = 0, skipped = 0;
  auto test_case = [&](const std::string& file, const std::string& name, Outcome outcome, const std::string& why) {
    ++tests;
    body += "    <testcase classname=\"" + xml(file) + "\" name=\"" + xml(name) + "\"";
    if (outcome == Outcome::verified) {
      body += "/>\n";
    } else if (outcome == Outcome::not_run) {
      ++skipped;
      body += "><skipped message=\"" + xml(why) + "\"/></testcase>\n";
    } else {
      ++failures;
      body += "><failure type=\"" + std::string(name_of(outcome)) + "\" message=\"" + xml(why) + "\"/></testcase>\n";
    }
  };
  for (const auto& a : verdict.artifacts) {
    test_case(a.file, "within " + print_number(verdict.tolerance) + " mm", a.verdict, joined(a.reasons));
    for (const auto& o : a.objects) test_case(a.file, o.name, o.verdict, failure_of(a, o));
  }
  for (const auto& p : verdict.between_backends)
    test_case("between backends", p.first + " and " + p.second, p.agree ? Outcome::verified : Outcome::out_of_tolerance,
              "differ by " + shown(p.distance, 0.0001) + " mm");
  const std::string counts = " tests=\"" + std::to_string(tests) + "\" failures=\"" + std::to_string(failures) +
                             "\" errors=\"0\" skipped=\"" + std::to_string(skipped) + "\"";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + counts +
         ">\n  <testsuite name=\"partscribe verify\"" + counts + ">\n" + body + "  </testsuite>\n</testsuites>\n";
}

std::string verdict_table(const Verdict& verdict) {
  std::string text = column("artifact", 24) + column("program", 22) + column("verdict", 17) +
                     column("local max", 10, true) + column("rms", 9, true) + column("scanned", 9, true) +
                     column("against", 9, true) + "\n";
  for (const auto& a : verdict.artifacts) {
    const bool compared = was_compared(a);
    text += column(column(a.file, 23), 24) +
            column(column(a.program + (a.version.empty() ? "" : " ") + a.version, 21), 22) +
            column(name_of(a.verdict), 17) +
            column(compared ? shown(a.data_to_model.local_max, 0.0001) : "-", 10, true) +
            column(compared ? shown(a.data_to_model.rms, 0.0001) : "-", 9, true) +
            column(percent(a.model_to_data.supported, a.model_to_data.area), 9, true) +
            column(percent(a.model_to_data.contradicted, a.model_to_data.area), 9, true) + "\n";
  }
  for (const auto& a : verdict.artifacts) text += alignment_lines(a);
  // One surface in several files is told once.
  std::vector<std::size_t> like;
  std::vector<const ArtifactVerdict*> told;
  for (std::size_t i = 0; i < verdict.artifacts.size(); ++i) {
    like.push_back(first_like(verdict, i));
    if (like[i] == i) told.push_back(&verdict.artifacts[i]);
  }
  for (const auto* a : told) text += finding_lines(*a) + failing_dimensions(*a);
  // All artifacts have the same faces: the first shows every one, the others those that are not as they should be.
  bool first = true;
  for (const auto* a : told) {
    std::string faces;
    for (const auto& o : a->objects)
      if ((first && a->objects.size() <= most_rows) || o.verdict != Outcome::verified)
        faces += "  " + column(column(o.name, 43), 44) + column(name_of(o.verdict), 17) +
                 column(shown(o.max, 0.0001), 10, true) + column(shown(o.rms, 0.0001), 9, true) +
                 column(percent(o.covered, 1), 9, true) + column(std::to_string(o.points), 9, true) + "\n";
    if (!faces.empty())
      text += "\n" + column(a->file + ", feature by feature", 46) + column("verdict", 17) +
              column("local max", 10, true) + column("rms", 9, true) + column("scanned", 9, true) +
              column("points", 9, true) + "\n" + faces;
    if (!a->objects.empty()) first = false;
    for (const auto& reason : a->reasons) text += wrapped("  " + a->file + ": " + reason, 4);
  }
  text += same_surface_lines(verdict, like);
  text += agreement_lines(verdict);
  for (const auto& a : verdict.artifacts) text += opinion_lines(a);
  text += "\n" + scan_lines(verdict);
  if (verdict.verdict == Outcome::verified) {
    double unseen = 0;
    for (const auto& a : verdict.artifacts)
      if (was_compared(a)) unseen = std::max(unseen, a.model_to_data.not_scanned / a.model_to_data.area);
    const bool aligned = std::any_of(verdict.artifacts.begin(), verdict.artifacts.end(),
                                     [](const auto& a) { return a.alignment.has_value(); });
    text += "VERIFIED within " + print_number(verdict.tolerance) + " mm" + (aligned ? " after alignment" : "") +
            (unseen > 0.001 ? "; " + shown(100 * unseen, 0.1) + " % of the surface was not scanned" : "") + "\n";
  } else {
    text += "NOT VERIFIED: " + main_reason(verdict) + "\n";
  }
  return text;
}

}  // namespace partscribe::verify
