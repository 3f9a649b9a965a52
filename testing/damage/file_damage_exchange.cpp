/// Damages of STEP and IGES files as programs, editors and transfers make them.
#include <algorithm>
#include <cmath>
#include <functional>
#include <regex>

#include "core/number.h"
#include "testing/damage/file_damage.h"

namespace partscribe::testing {
namespace {

const std::vector<std::string> invalid = {"cannot",       "invalid",      "open",     "edges",  "no surface",
                                          "ends",         "not a number", "expected", "refers", "too far",
                                          "missing",      "holds no",     "gave up",  "finite", "tree",
                                          "only good to", "belong",       "circle",   "counts", "contradicts itself"};
const std::vector<std::string> cut_off = {"ends before", "is cut off", "not whole"};

void truncations(const FileSubject& s, std::vector<FileDamage>& damages) {
  for (const double share : {0.02, 0.25, 0.5, 0.75, 0.9, 0.97, 0.995})
    damages.push_back({"truncated file", print_number(100 * share) + " % left",
                       s.bytes.substr(0, static_cast<std::size_t>(share * double(s.bytes.size()))), cut_off});
  auto lines = lines_of(s.bytes);
  lines.pop_back();
  damages.push_back({"truncated file", "without its last line", text_of(lines), cut_off});
}

/// A new text for the n-th match of `pattern`, made by `change` from the match; empty if there is none.
std::string nth_changed(const std::string& text, const std::regex& pattern, std::size_t n,
                        const std::function<std::string(const std::smatch&)>& change) {
  for (std::sregex_iterator m(text.begin(), text.end(), pattern), end; m != end; ++m)
    if (n-- == 0)
      return text.substr(0, static_cast<std::size_t>(m->position(0))) + change(*m) +
             text.substr(static_cast<std::size_t>(m->position(0) + m->length(0)));
  return "";
}

// ---- STEP -----------------------------------------------------------------------------------------------------------

/// Every entity on one line, as many programs write them.
std::string unfolded(const std::string& text) {
  std::string result;
  for (const auto& line : lines_of(text)) {
    std::string part = line;
    if (!part.empty() && part[0] == ' ') part.erase(0, part.find_first_not_of(' '));
    result += part;
    if (!part.empty() && part.back() == ';') result += '\n';
  }
  return result;
}

void in_step(const FileSubject& s, std::vector<FileDamage>& damages) {
  const std::string text = unfolded(s.bytes);
  const double T = s.model.tolerance;
  truncations(s, damages);
  const std::string millimetre = "SI_UNIT(.MILLI.,.METRE.)";
  damages.push_back({"units swapped", "unit header m", with(text, millimetre, "SI_UNIT($,.METRE.)"), {"1000"}});
  damages.push_back(
      {"units swapped", "unit header cm", with(text, millimetre, "SI_UNIT(.CENTI.,.METRE.)"), {"10 times"}});
  std::string inch =
      nth_changed(text, std::regex("\\( ?LENGTH_UNIT\\(\\) ?NAMED_UNIT\\(\\*\\) ?SI_UNIT\\(.MILLI.,.METRE.\\) ?\\)"), 0,
                  [](const std::smatch&) {
                    return std::string("( CONVERSION_BASED_UNIT('INCH',#900001) LENGTH_UNIT() NAMED_UNIT(#900002) )");
                  });
  if (!inch.empty()) {
    const auto at = inch.rfind("ENDSEC;");
    inch.insert(at,
                "#900001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#900003);\n#900002 = "
                "DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n#900003 = ( LENGTH_UNIT() NAMED_UNIT(*) "
                "SI_UNIT(.MILLI.,.METRE.) );\n");
  }
  damages.push_back({"units swapped", "unit header inch", inch, {"25.4", "inch"}});

  static const std::regex shell("(CLOSED_SHELL\\('[^']*',\\()([^)]*)\\)");
  auto shell_with = [&](const std::function<std::string(const std::string&)>& faces) {
    return nth_changed(text, shell, 0, [&](const std::smatch& m) { return m[1].str() + faces(m[2].str()) + ")"; });
  };
  auto all_but_last = [](const std::string& list) {
    return list.substr(0, list.rfind(',') == std::string::npos ? 0 : list.rfind(','));
  };
  damages.push_back({"open shell", "last face missing", shell_with(all_but_last), invalid});
  damages.push_back({"open shell", "first face missing", shell_with([](const std::string& l) {
                       const auto c = l.find(',');
                       return c == std::string::npos ? std::string() : l.substr(c + 1);
                     }),
                     invalid});
  damages.push_back({"reference to nothing", "in the shell", shell_with([&](const std::string& l) {
                       return (all_but_last(l).empty() ? "" : all_but_last(l) + ",") + "#999999";
                     }),
                     invalid});
  damages.push_back({"endless loop", "a shell that refers to itself",
                     nth_changed(text, std::regex("#([0-9]+) ?= ?CLOSED_SHELL\\('[^']*',\\(([^)]*)\\)\\)"), 0,
                                 [&](const std::smatch& m) {
                                   return "#" + m[1].str() + " = CLOSED_SHELL('',(" + m[2].str() + ",#" + m[1].str() +
                                          "))";
                                 }),
                     invalid, false, 20});
  damages.push_back(
      {"duplicated body",
       "the same body twice",
       nth_changed(text, std::regex("(ADVANCED_BREP_SHAPE_REPRESENTATION\\('[^']*',\\(#[0-9]+,)(#[0-9]+)\\)"), 0,
                   [](const std::smatch& m) { return m[1].str() + m[2].str() + "," + m[2].str() + ")"; }),
       {"twice", "edges", "facets", "same place", "overlap", "duplicate"}});
  static const std::regex face("(ADVANCED_FACE\\([^;]*,)\\.([TF])\\.\\);");
  // The reader turns such a face over again: what it delivers is the part.
  for (const std::size_t n : {0u, 1u})
    damages.push_back(
        {"harmless edits",
         "sense of face " + print_number(double(n + 1)) + " flipped, which the reader repairs",
         nth_changed(text, face, n,
                     [](const std::smatch& m) { return m[1].str() + (m[2].str() == "T" ? ".F.);" : ".T.);"); }),
         {},
         true});
  static const std::regex point("CARTESIAN_POINT\\('[^']*',\\(([-0-9.E+]+),([-0-9.E+]+),([-0-9.E+]+)\\)\\)");
  auto point_with = [&](std::size_t n, const std::string& x) {
    return nth_changed(text, point, n, [&](const std::smatch& m) {
      return "CARTESIAN_POINT('',(" + x + "," + m[2].str() + "," + m[3].str() + "))";
    });
  };
  damages.push_back({"not a number", "NAN", point_with(1, "NAN"), invalid});
  damages.push_back({"not a number", "1.E400", point_with(1, "1.E400"), invalid});
  damages.push_back({"decimal comma", "in a point",
                     nth_changed(text, point, 1,
                                 [](const std::smatch& m) {
                                   return "CARTESIAN_POINT('',(1,5," + m[2].str() + "," + m[3].str() + "))";
                                 }),
                     invalid});
  // Corners, for the middle of a plane may lie anywhere on it.
  std::size_t number = 0;
  static const std::regex corner("VERTEX_POINT\\('[^']*',(#[0-9]+)\\)");
  for (std::sregex_iterator m(text.begin(), text.end(), corner), end; m != end && number < 3; ++m)
    damages.push_back(
        {"coordinate changed", "corner " + print_number(double(++number)),
         nth_changed(
             text, std::regex("(" + (*m)[1].str() + " ?= ?CARTESIAN_POINT\\('[^']*',\\()([-0-9.E+]+),"), 0,
             [&](const std::smatch& p) { return p[1].str() + print_real(std::stod(p[2].str()) + 4 * T) + ","; }),
         invalid});
  for (const char* surface : {"CYLINDRICAL_SURFACE", "SPHERICAL_SURFACE"})
    damages.push_back({"coordinate changed", std::string("radius of a ") + surface,
                       nth_changed(text, std::regex(std::string(surface) + "\\('[^']*',(#[0-9]+),([-0-9.E+]+)\\)"), 0,
                                   [&](const std::smatch& m) {
                                     return std::string(surface) + "(''," + m[1].str() + "," +
                                            print_real(std::stod(m[2].str()) + 2 * T) + ")";
                                   }),
                       invalid});
  for (const char* entity :
       {"VERTEX_POINT", "EDGE_CURVE", "ADVANCED_FACE", "MANIFOLD_SOLID_BREP", "AXIS2_PLACEMENT_3D"})
    damages.push_back({"line missing", entity,
                       nth_changed(text, std::regex("#[0-9]+ ?= ?" + std::string(entity) + "[^;]*;\n"),
                                   entity == std::string("AXIS2_PLACEMENT_3D") ? 1 : 0,
                                   [](const std::smatch&) { return std::string(); }),
                       invalid});
  damages.push_back({"empty geometry",
                     "no entity",
                     text.substr(0, text.find("DATA;") + 6) + "ENDSEC;\nEND-ISO-10303-21;\n",
                     {"no surface", "cannot"}});
  damages.push_back(
      {"empty geometry",
       "a placement only",
       nth_changed(text, std::regex("(ADVANCED_BREP_SHAPE_REPRESENTATION\\('[^']*',\\(#[0-9]+),#[0-9]+\\)"), 0,
                   [](const std::smatch& m) { return m[1].str() + ")"; }),
       {"no surface", "cannot"}});

  damages.push_back({"harmless edits", "one entity a line", text, {}, true});
  damages.push_back({"harmless edits", "line ends of Windows", text_of(lines_of(text), "\r\n"), {}, true});
  damages.push_back({"harmless edits", "a remark", with(text, "DATA;\n", "DATA;\n/* looked at */\n"), {}, true});
  damages.push_back({"harmless edits",
                     "another author and date",
                     with(text, "1970-01-01T00:00:00", "2024-02-29T12:00:00"),
                     {},
                     true});
  damages.push_back({"harmless edits",
                     "product renamed",
                     nth_changed(text, std::regex("PRODUCT\\('[^']*','[^']*'"), 0,
                                 [](const std::smatch&) { return std::string("PRODUCT('P-4711','drawing 7'"); }),
                     {},
                     true});
  damages.push_back({"harmless edits",
                     "faces renamed",
                     std::regex_replace(text, std::regex("ADVANCED_FACE\\('[^']*'"), "ADVANCED_FACE('area'"),
                     {},
                     true});
  auto lines = lines_of(text);
  const auto first = std::find(lines.begin(), lines.end(), "DATA;"), last = std::find(first, lines.end(), "ENDSEC;");
  if (first != lines.end() && last != lines.end()) std::reverse(first + 1, last);
  damages.push_back({"harmless edits", "entities in reverse order", text_of(lines), {}, true});
}

// ---- IGES -----------------------------------------------------------------------------------------------------------

/// The parameter record of a directory entry, as free text, and the lines it came from.
struct Record {
  std::size_t first = 0, count = 0;
  std::string text;
};

std::vector<Record> records_of(const std::vector<std::string>& lines) {
  std::vector<Record> records;
  std::string owner;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].size() < 80 || lines[i][72] != 'P') continue;
    const std::string entry = lines[i].substr(64, 8);
    if (records.empty() || entry != owner) records.push_back({i, 0, ""}), owner = entry;
    std::string part = lines[i].substr(0, 64);
    while (!part.empty() && part.back() == ' ') part.pop_back();
    records.back().text += part, ++records.back().count;
  }
  return records;
}

/// The file with another text in a record; empty where it needs more lines than before.
std::string rewritten(const std::vector<std::string>& lines, const Record& record, std::string text) {
  auto result = lines;
  for (std::size_t k = 0; k < record.count; ++k) {
    std::string part = text.substr(0, 64);
    if (text.size() > 64) {  // not inside a number
      const auto comma = part.find_last_of(",;");
      part = part.substr(0, comma + 1);
    }
    text.erase(0, part.size());
    part.resize(64, ' ');
    result[record.first + k] = part + lines[record.first + k].substr(64);
  }
  return text.empty() ? text_of(result) : "";
}

void in_iges(const FileSubject& s, std::vector<FileDamage>& damages) {
  truncations(s, damages);
  const auto lines = lines_of(s.bytes);
  const auto records = records_of(lines);
  const double T = s.model.tolerance;
  auto entity = [](const Record& r) { return r.text.substr(0, r.text.find(',')); };
  auto of_kind = [&](const std::string& kind, std::size_t n) -> const Record* {
    for (const auto& r : records)
      if (entity(r) == kind && n-- == 0) return &r;
    return nullptr;
  };
  auto fields = [](const Record& r) {
    std::vector<std::string> list;
    std::string field;
    for (const char c : r.text) {
      if (c == ',' || c == ';')
        list.push_back(field), field.clear();
      else
        field += c;
    }
    return list;
  };
  auto joined = [](const std::vector<std::string>& list) {
    std::string text;
    for (std::size_t i = 0; i < list.size(); ++i) text += list[i] + (i + 1 < list.size() ? "," : ";");
    return text;
  };
  auto changed = [&](const Record* r, const std::function<bool(std::vector<std::string>&)>& change) -> std::string {
    if (!r) return "";
    auto list = fields(*r);
    return change(list) ? rewritten(lines, *r, joined(list)) : std::string();
  };

  damages.push_back({"units swapped", "unit header inch", with(s.bytes, ",2,2HMM,", ",1,2HIN,"), {"25.4", "inch"}});
  damages.push_back({"units swapped", "unit header m", with(s.bytes, ",2,2HMM,", ",6,2HM ,"), {"1000"}});
  damages.push_back({"units swapped", "unit header um", with(s.bytes, ",2,2HMM,", ",9,2HUM,"), {"1000", "0.001"}});
  const Record* shell = of_kind("514", 0);
  damages.push_back({"open shell", "last face missing",
                     changed(shell,
                             [](auto& f) {
                               const int n = std::stoi(f[1]);
                               if (n < 2) return false;
                               f[1] = std::to_string(n - 1);
                               f.erase(f.begin() + 2 * n, f.begin() + 2 * n + 2);
                               return true;
                             }),
                     invalid});
  damages.push_back({"open shell", "first face missing",
                     changed(shell,
                             [](auto& f) {
                               const int n = std::stoi(f[1]);
                               if (n < 2) return false;
                               f[1] = std::to_string(n - 1);
                               f.erase(f.begin() + 2, f.begin() + 4);
                               return true;
                             }),
                     invalid});
  damages.push_back({"duplicated body",
                     "a face twice",
                     changed(shell,
                             [](auto& f) {
                               const int n = std::stoi(f[1]);
                               f[1] = std::to_string(n + 1);
                               const std::string face = f[2], sense = f[3];
                               f.insert(f.begin() + 2 + 2 * n, {face, sense});
                               return true;
                             }),
                     {"twice", "edges", "facets", "same place", "overlap", "duplicate", "invalid", "open"}});
  damages.push_back({"harmless edits",
                     "sense of face 1 flipped, which the reader repairs",
                     changed(shell, [](auto& f) { return f[3] = f[3] == "0" ? "1" : "0", true; }),
                     {},
                     true});
  damages.push_back(
      {"reference to nothing", "in the shell", changed(shell, [](auto& f) { return f[2] = "99999", true; }), invalid});
  damages.push_back(
      {"endless loop", "a shell that refers to itself",
       changed(shell,
               [&](auto& f) { return f[2] = std::to_string(std::stoi(lines[shell->first].substr(64, 8))), true; }),
       invalid, false, 20});
  for (const auto& [kind, at] : {std::pair<std::string, std::size_t>{"110", 1}, {"116", 1}, {"502", 2}}) {
    const Record* r = of_kind(kind, 0);
    damages.push_back(
        {"not a number", "NAN in entity " + kind, changed(r, [&](auto& f) { return f[at] = "NAN", true; }), invalid});
    damages.push_back({"not a number", "1E400 in entity " + kind,
                       changed(r, [&](auto& f) { return f[at] = "1E400", true; }), invalid});
  }
  for (const auto& kind : {"502", "116"})
    damages.push_back({"coordinate changed", std::string("entity ") + kind,
                       changed(of_kind(kind, 0),
                               [&](auto& f) {
                                 const std::size_t at = kind == std::string("502") ? 2 : 1;
                                 return f[at] = print_real(snapped(std::stod(f[at]) + 4 * T, 0.01)), true;
                               }),
                       invalid});
  damages.push_back(
      {"coordinate changed", "radius of a cylinder",
       changed(of_kind("192", 0), [&](auto& f) { return f[3] = print_real(std::stod(f[3]) + 2 * T), true; }), invalid});
  damages.push_back(
      {"coordinate changed", "radius of a ball",
       changed(of_kind("196", 0), [&](auto& f) { return f[2] = print_real(std::stod(f[2]) + 2 * T), true; }), invalid});
  for (const auto& [kind, at] : {std::pair<std::string, std::size_t>{"150", 1},
                                 {"154", 1},
                                 {"154", 2},
                                 {"156", 1},
                                 {"158", 1},
                                 {"160", 2},
                                 {"152", 1}})
    damages.push_back(
        {"coordinate changed",
         "size in primitive " + kind,
         changed(of_kind(kind, 0),
                 [&, at = at](auto& f) { return f[at] = print_real(snapped(std::stod(f[at]) + 2 * T, 0.001)), true; }),
         {"tree"}});
  damages.push_back({"added instead of cut away",
                     "in the boolean tree",
                     changed(of_kind("180", 0),
                             [](auto& f) {
                               for (auto& x : f)
                                 if (x == "3") return x = "1", true;
                               return false;
                             }),
                     {"tree"}});
  damages.push_back(
      {"decimal comma", "in a point", changed(of_kind("116", 0), [](auto& f) { return f[1] = "1,5", true; }), invalid});
  for (const std::string letter : {"D", "P"}) {
    std::size_t n = 0, seen = 0;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (lines[i].size() > 72 && lines[i][72] == letter[0]) ++n;
    auto fewer = lines;
    for (std::size_t i = 0; i < fewer.size(); ++i)
      if (fewer[i].size() > 72 && fewer[i][72] == letter[0] && ++seen == n / 2) {
        fewer.erase(fewer.begin() + long(i));
        break;
      }
    damages.push_back({"line missing", "in section " + letter, text_of(fewer), invalid});
  }
  std::vector<std::string> bare;
  for (const auto& l : lines)
    if (l.size() > 72 && (l[72] == 'S' || l[72] == 'G')) bare.push_back(l);
  damages.push_back(
      {"empty geometry",
       "no entity",
       text_of(bare) + "S      1G      3D      0P      0                                        T0000001\n",
       {"no surface", "cannot", "counts"}});

  damages.push_back({"harmless edits", "line ends of Windows", text_of(lines, "\r\n"), {}, true});
  auto renamed = lines;
  std::string title = "Another title than before, as a person would write it.";
  title.resize(72, ' ');
  renamed[0] = title + renamed[0].substr(72);
  damages.push_back({"harmless edits", "another title", text_of(renamed), {}, true});
  damages.push_back({"harmless edits", "another date", with(s.bytes, "19700101.000000", "20240229.120000"), {}, true});
  damages.push_back({"harmless edits", "another author", with(s.bytes, "10Hpartscribe", "10Hworkshop 7"), {}, true});
}

}  // namespace

void damage_exchange(const FileSubject& s, std::vector<FileDamage>& damages) {
  if (s.backend == "step") in_step(s, damages);
  if (s.backend == "iges") in_iges(s, damages);
}

}  // namespace partscribe::testing
