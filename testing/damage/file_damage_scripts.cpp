/// Damages of OpenSCAD scripts and Alpha_1 procedures as a person, an editor or a program makes them.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>

#include "core/number.h"
#include "testing/damage/file_damage.h"

namespace partscribe::testing {
namespace {

const std::vector<std::string> complaint = {"warning", "error", "expected", "unknown", "undefined", "is not defined"};

/// A named number of a script: where its designed value stands.
struct NamedNumber {
  std::string name;
  std::size_t begin, end;  // of the value
  double value;
};

std::vector<NamedNumber> named_numbers(const std::string& text, bool scad) {
  static const std::regex in_scad("(^|\n)([a-z][a-z0-9_]*) = (as_designed \\? )?([0-9]+\\.?[0-9]*)");
  static const std::regex in_scl("(^|\n)([A-Z][A-Za-z0-9]*) : (if \\( AsDesigned \\) )?([0-9]+\\.[0-9]*)");
  std::vector<NamedNumber> found;
  const auto& pattern = scad ? in_scad : in_scl;
  for (std::sregex_iterator m(text.begin(), text.end(), pattern), end; m != end; ++m) {
    const auto at = static_cast<std::size_t>(m->position(4));
    const std::string name = (*m)[2];
    if (name == "chord_error") continue;
    found.push_back({name, at, at + static_cast<std::size_t>(m->length(4)), std::stod((*m)[4].str())});
  }
  return found;
}

std::string with_value(const std::string& text, const NamedNumber& n, const std::string& value) {
  return text.substr(0, n.begin) + value + text.substr(n.end);
}

std::string with_word(const std::string& text, const std::string& from, const std::string& to) {
  return std::regex_replace(text, std::regex("\\b" + from + "\\b"), to);
}

std::string without_remarks(const std::string& text, const std::string& mark) {
  std::vector<std::string> kept;
  for (auto line : lines_of(text)) {
    const auto at = line.find(mark);
    if (at != std::string::npos) line = line.substr(0, at);
    while (!line.empty() && line.back() == ' ') line.pop_back();
    if (!line.empty()) kept.push_back(line);
  }
  return text_of(kept);
}

/// Everything that both languages allow. `top` is where the statement that makes the part begins.
void in_both(const FileSubject& s, bool scad, std::size_t top, std::vector<FileDamage>& damages) {
  const std::string& text = s.bytes;
  for (const double share : {0.05, 0.3, 0.6, 0.9, 1.0}) {
    const auto length = static_cast<std::size_t>(share * double(top));
    damages.push_back(
        {"truncated file",
         "after " + print_number(double(length)) + " characters",
         text.substr(0, length),
         {"warning", "error", "expected", "no geometry", "ends", "nothing", "holds no", "no solid", "empty"}});
  }
  const auto numbers = named_numbers(text, scad);
  const double T = s.model.tolerance;
  for (const auto& n : numbers) {
    const std::string shown = n.name + " = ";
    damages.push_back({"not a number",
                       shown + "0 / 0",
                       with_value(text, n, scad ? "(0 / 0)" : "0.0 / 0.0"),
                       {"warning", "error", "undef", "nan", "divi", "number"}});
    damages.push_back({"not a number",
                       shown + "1e400",
                       with_value(text, n, scad ? "1e400" : "1.0e400"),
                       {"warning", "error", "inf", "number", "large", "range"}});
    damages.push_back({"decimal comma", shown + print_number(n.value) + ",5",
                       with_value(text, n, print_number(std::floor(n.value)) + ",5"), complaint});
    damages.push_back({"name misspelt", n.name,
                       with(text, "\n" + n.name + (scad ? " =" : " :"), "\n" + n.name + (scad ? "x =" : "x :")),
                       complaint});
    damages.push_back(
        {"name set twice",
         n.name,
         scad ? text + n.name + " = " + print_number(n.value + 2 * T) + ";\n"
              : text.substr(0, top) + n.name + " : " + print_real(n.value + 2 * T) + ";\n" + text.substr(top),
         {"warning", "overwritten", "twice", "already", "defined", "too far"}});
    damages.push_back({"harmless edits",
                       n.name + " renamed",
                       with_word(text, n.name, n.name + (scad ? "_of_part" : "OfPart")),
                       {},
                       true});
    damages.push_back(
        {"harmless edits", n.name + " + T / 10", with_value(text, n, print_real(n.value + 0.1 * T)), {}, true});
  }
  damages.push_back({"harmless edits",
                     "remarks removed",
                     without_remarks(without_remarks(text, scad ? "//" : "#"), scad ? "/*" : "#"),
                     {},
                     true});
  damages.push_back({"harmless edits", "line ends of Windows", text_of(lines_of(text), "\r\n"), {}, true});
  damages.push_back({"harmless edits", "blank lines and indentation", with_all(text, "\n", "\n\n   "), {}, true});
  damages.push_back({"harmless edits", "no last line end", text.substr(0, text.size() - 1), {}, true});
  damages.push_back({"harmless edits",
                     "a remark with another number",
                     std::string(scad ? "// " : "# ") + "radius was 99 mm\n" + text,
                     {},
                     true});
}

void in_scad(const FileSubject& s, std::vector<FileDamage>& damages) {
  const std::string& text = s.bytes;
  const auto placed = text.rfind("if (as_scanned)");
  const auto top = placed != std::string::npos ? placed : text.find("\npart();") + 1;
  in_both(s, true, top, damages);
  const std::string part = placed != std::string::npos ? "scan_from_part() part();\n" : "part();\n";
  const std::string rest = placed != std::string::npos ? "" : text.substr(top + 8);
  auto made_by = [&](const std::string& statement) { return text.substr(0, top) + statement + rest; };
  damages.push_back({"units swapped", "25.4 times", made_by("scale(25.4) " + part), {"25.4", "inch"}});
  damages.push_back({"units swapped", "a 25.4th", made_by("scale(1 / 25.4) " + part), {"25.4", "inch"}});
  damages.push_back({"units swapped", "m for mm", made_by("scale(1000) " + part), {"1000"}});
  damages.push_back({"axes swapped",
                     "x and y",
                     made_by("multmatrix([[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]) " + part),
                     {"mirror", "whole part"}});
  damages.push_back({"shifted duplicate",
                     "along x",
                     made_by(part + "translate([" + print_number(6 * s.model.tolerance) + ", 0, 0]) " + part),
                     {}});
  damages.push_back({"shifted duplicate",
                     "beside",
                     made_by(part + "translate([" + print_number(2 * s.extent) + ", 0, 0]) " + part),
                     {"separate body", "too much", "invented", "no scanned point"}});
  damages.push_back(
      {"wrong frame", "switched off", with(text, "as_scanned = true", "as_scanned = false"), {"whole part"}});
  damages.push_back(
      {"empty geometry", "nothing made", made_by(""), {"no geometry", "no top level", "empty", "wrote no", "nothing"}});
  damages.push_back({"empty geometry",
                     "a cut too large",
                     made_by("difference() { " + part + "cube(1000, center = true); }\n"),
                     {"no geometry", "no top level", "empty", "wrote no", "nothing"}});
  damages.push_back({"warning", "an unknown name", text + "echo(no_such_name);\n", {"warning"}});
  damages.push_back({"warning", "a failed assertion", text + "assert(1 > 2, \"sizes do not fit\");\n", {"error"}});
  damages.push_back({"endless loop",
                     "a list without end",
                     text + "forever = [for (i = 0; i >= 0; i = i + 1) i % 7];\n",
                     {"did not finish", "memory", "error"},
                     false,
                     4});
  damages.push_back({"endless loop",
                     "a function without end",
                     text + "function f(n) = f(n + 1) + 1;\necho(f(0));\n",
                     {"did not finish", "recursion", "error"},
                     false,
                     10});
  damages.push_back({"missing file beside it", "include", "include <sizes.scad>\n" + text, {"warning", "can't open"}});
  for (auto at = text.find("difference()"); at != std::string::npos; at = text.find("difference()", at + 1))
    damages.push_back({"added instead of cut away",
                       "difference as union",
                       text.substr(0, at) + "union()" + text.substr(at + 12),
                       {}});
  if (text.find("facets(") != std::string::npos)
    damages.push_back({"coarse facets",
                       "chord error 8 T",
                       std::regex_replace(text, std::regex("chord_error = [0-9.]+;"),
                                          "chord_error = " + print_number(8 * s.model.tolerance) + ";"),
                       {}});
  if (text.find("polyhedron(") != std::string::npos) {
    static const std::regex face("\\[([0-9]+), ([0-9]+), ([0-9]+)\\](?=[, ])");
    const auto faces = text.find("_faces = [");
    std::smatch m;
    const std::string tail = text.substr(faces);
    if (std::regex_search(tail, m, face)) {
      const auto at = faces + static_cast<std::size_t>(m.position(0));
      const auto length = static_cast<std::size_t>(m.length(0));
      damages.push_back({"inverted facets",
                         "one",
                         text.substr(0, at) + "[" + m[2].str() + ", " + m[1].str() + ", " + m[3].str() + "]" +
                             text.substr(at + length),
                         {"opposite", "same direction", "orient", "inverted", "open", "edges", "inside"}});
      damages.push_back({"missing facet",
                         "one",
                         text.substr(0, at) + text.substr(at + length + 1),
                         {"open", "edges", "boundary", "hole"}});
      damages.push_back({"inverted facets",
                         "all",
                         text.substr(0, faces) + std::regex_replace(tail, face, "[$2, $1, $3]"),
                         {"inside out", "opposite", "orient", "inside"}});
    }
  }
  if (placed != std::string::npos)
    damages.push_back({"harmless edits", "the part made first", text.substr(top) + text.substr(0, top), {}, true});
  damages.push_back({"harmless edits", "wrapped in a union", made_by("union() { " + part + part + "}\n"), {}, true});
}

void in_scl(const FileSubject& s, std::vector<FileDamage>& damages) {
  const std::string& text = s.bytes;
  const auto top = text.find("Out : seqCollect {");
  in_both(s, false, top, damages);
  const auto begin = top + 18, end = text.find(';', begin);
  std::string last = text.substr(begin, end - begin);
  last.erase(0, last.find_first_not_of(' '));
  auto made_by = [&](const std::string& statements, const std::string& out) {
    return text.substr(0, top) + statements + "Out : seqCollect { " + out + " }\n" +
           text.substr(text.find("dumpGeomFile", top));
  };
  auto transformed = [&](const std::string& how) {
    return made_by("Wrong : objTransform( " + last + ", " + how + " );\n", "Wrong;");
  };
  damages.push_back({"units swapped", "25.4 times", transformed("sG( 25.4 )"), {"25.4", "inch"}});
  damages.push_back({"units swapped", "a 25.4th", transformed("sG( 1.0 / 25.4 )"), {"25.4", "inch"}});
  damages.push_back({"axes swapped", "z down", transformed("sXYZ( 1.0, 1.0, -1.0 )"), {"mirror", "whole part"}});
  damages.push_back({"shifted duplicate",
                     "along x",
                     made_by("Wrong : objTransform( " + last + ", tX( " + print_real(6 * s.model.tolerance) + " ) );\n",
                             last + "; Wrong;"),
                     {"overlap", "two shells"}});
  damages.push_back(
      {"shifted duplicate",
       "beside",
       made_by("Wrong : objTransform( " + last + ", tX( " + print_real(2 * s.extent) + " ) );\n", last + "; Wrong;"),
       {"separate body", "too much", "invented", "no scanned point"}});
  damages.push_back({"duplicated body",
                     "the same object twice",
                     made_by("", last + "; " + last + ";"),
                     {"twice", "edges", "facets", "same place", "overlap", "duplicate"}});
  damages.push_back(
      {"wrong frame", "switched off", with(text, "AsScanned : true", "AsScanned : false"), {"whole part"}});
  damages.push_back({"empty geometry",
                     "an empty list",
                     made_by("", ""),
                     {"no geometry", "nothing", "no solid", "holds no", "empty", "expected"}});
  damages.push_back(
      {"warning", "an unknown name", made_by("Wrong : sG( NoSuchLabel );\n", last + ";"), {"nosuchlabel"}});
  damages.push_back({"warning",
                     "an unknown function",
                     made_by("Wrong : filletEdges( " + last + " );\n", last + ";"),
                     {"filletedges"}});
  damages.push_back({"endless loop",
                     "while true",
                     made_by("while ( true ) { pt( 0.0, 0.0, 0.0 ); }\n", last + ";"),
                     {"steps", "end", "limit", "true"},
                     false,
                     20});
  damages.push_back({"endless loop",
                     "a procedure that calls itself",
                     made_by("procedure again( X ) again( X );\nWrong : again( 1.0 );\n", last + ";"),
                     {"deep", "recurs", "steps", "procedures"},
                     false,
                     20});
  FileDamage alone{"missing file beside it", "the prelude", text, {"prelude.scl"}};
  alone.without_companions = true;
  damages.push_back(alone);
  for (auto at = text.find("solidDifference("); at != std::string::npos; at = text.find("solidDifference(", at + 1))
    damages.push_back({"added instead of cut away",
                       "difference as union",
                       text.substr(0, at) + "solidUnion(" + text.substr(at + 16),
                       {}});
  static const std::regex facet("facet\\( (\\w+), (\\w+), (\\w+) \\);");
  std::smatch m;
  if (std::regex_search(text, m, facet)) {
    const auto at = static_cast<std::size_t>(m.position(0)), length = static_cast<std::size_t>(m.length(0));
    damages.push_back({"inverted facets",
                       "one",
                       text.substr(0, at) + "facet( " + m[2].str() + ", " + m[1].str() + ", " + m[3].str() + " );" +
                           text.substr(at + length),
                       {"opposite", "same direction", "orient", "inverted", "open", "edges", "inside"}});
    damages.push_back(
        {"missing facet", "one", text.substr(0, at) + text.substr(at + length), {"open", "edges", "boundary", "hole"}});
  }
}

}  // namespace

void damage_scripts(const FileSubject& s, std::vector<FileDamage>& damages) {
  if (s.backend == "openscad") in_scad(s, damages);
  if (s.backend == "alpha1") in_scl(s, damages);
}

}  // namespace partscribe::testing
