#include "model/json.h"

#include <nlohmann/json.hpp>

#include "core/json_nesting.h"
#include "core/json_text.h"
#include "core/number.h"

namespace partscribe::model {
namespace {

using Json = nlohmann::ordered_json;

/// Ends a reading at the first complaint; caught in read_model_json.
struct Complaint {
  std::string text;
};

[[noreturn]] void complain(const std::string& path, const std::string& text) { throw Complaint{path + ": " + text}; }

constexpr std::pair<Quantity, const char*> quantities[] = {
    {Quantity::length, "length"}, {Quantity::angle, "angle"}, {Quantity::count, "count"}, {Quantity::ratio, "ratio"}};

// ---- expressions ------------------------------------------------------------------------------------------------

constexpr Expr::Kind operators[] = {Expr::Kind::negate, Expr::Kind::add,  Expr::Kind::subtract, Expr::Kind::multiply,
                                    Expr::Kind::divide, Expr::Kind::sqrt, Expr::Kind::sin,      Expr::Kind::cos,
                                    Expr::Kind::asin,   Expr::Kind::acos, Expr::Kind::atan2};

std::size_t arity(Expr::Kind kind) {
  switch (kind) {
    case Expr::Kind::add:
    case Expr::Kind::subtract:
    case Expr::Kind::multiply:
    case Expr::Kind::divide:
    case Expr::Kind::atan2:
      return 2;
    default:
      return 1;
  }
}

Json to_json(const Expr& e) {
  if (e.is_number()) return e.number;
  if (e.is_parameter()) return e.parameter;
  Json list = Json::array({std::string(kind_name(e.kind))});
  for (const auto& a : e.arguments) list.push_back(to_json(a));
  return list;
}

double read_number(const Json& j, const std::string& path) {
  if (!j.is_number()) complain(path, "expected a number");
  return j.get<double>();
}

std::string read_string(const Json& j, const std::string& path) {
  if (!j.is_string()) complain(path, "expected a text");
  return j.get<std::string>();
}

Expr read_expr(const Json& j, const std::string& path, int depth = 0) {
  if (depth > 64) complain(path, "the expression is nested too deeply");
  if (j.is_number()) return Expr(j.get<double>());
  if (j.is_string()) return Expr::of(j.get<std::string>());
  if (j.is_array() && !j.empty() && j[0].is_string()) {
    for (const auto kind : operators) {
      if (j[0].get<std::string>() != kind_name(kind)) continue;
      if (j.size() != arity(kind) + 1) complain(path, "wrong number of operands for " + j[0].get<std::string>());
      std::vector<Expr> arguments;
      for (std::size_t i = 1; i < j.size(); ++i) arguments.push_back(read_expr(j[i], path, depth + 1));
      return Expr::call(kind, std::move(arguments));
    }
    complain(path, "unknown operator '" + j[0].get<std::string>() + "'");
  }
  complain(path, "expected a number, a parameter's name or [operator, operands...]");
}

const Json& member(const Json& j, const char* key, const std::string& path) {
  if (!j.is_object()) complain(path, "expected an object");
  const auto found = j.find(key);
  if (found == j.end()) complain(path, "'" + std::string(key) + "' is missing");
  return *found;
}

const Json& list_of(const Json& j, const std::string& path) {
  if (!j.is_array()) complain(path, "expected a list");
  return j;
}

// ---- shapes: writing, by the fields() walk ------------------------------------------------------------------------

struct FieldWriter {
  Json& out;
  void operator()(const char* name, const Expr& e, Domain, const char*) const { out[name] = to_json(e); }
  void operator()(const char* name, const Expr& e, Domain, const char*, double left_out) const {
    if (!(e == Expr(left_out))) out[name] = to_json(e);
  }
  void operator()(const char* name, const std::string& text, const char*) const {
    if (!text.empty()) out[name] = text;
  }
  void operator()(const char* name, int v, const char*) const { out[name] = v; }
  void operator()(const char* name, bool v, const char*) const { out[name] = v; }
  void operator()(const char* name, const std::vector<double>& v, const char*) const {
    if (!v.empty()) out[name] = v;
  }
  void operator()(const char* name, const std::vector<std::string>& v, const char*) const { out[name] = v; }
  void operator()(const char* name, const std::vector<std::array<Expr, 2>>& v, const char*) const {
    Json list = Json::array();
    for (const auto& p : v) list.push_back(Json::array({to_json(p[0]), to_json(p[1])}));
    out[name] = std::move(list);
  }
  template <std::size_t N>
  void operator()(const char* name, const std::vector<std::array<double, N>>& v, const char*) const {
    out[name] = v;
  }
  void operator()(const char* name, const std::vector<std::array<std::uint32_t, 3>>& v, const char*) const {
    out[name] = v;
  }
  template <class Item>
  void operator()(const char* name, const Item& item, const char*) const requires requires(FieldWriter w) {
    Item::fields(item, w);
  }
  {
    Json j = Json::object();
    Item::fields(item, FieldWriter{j});
    out[name] = std::move(j);
  }
  void operator()(const char* name, const std::vector<SketchRelation>& items, const char* meaning) const {
    if (!items.empty()) operator()<SketchRelation>(name, items, meaning);
  }
  void operator()(const char* name, const std::vector<TriFace>& items, const char* meaning) const {
    if (!items.empty()) operator()<TriFace>(name, items, meaning);
  }
  void operator()(const char* name, const std::vector<PatchTrim>& items, const char* meaning) const {
    if (!items.empty()) operator()<PatchTrim>(name, items, meaning);
  }
  template <class Item>
  void operator()(const char* name, const std::vector<Item>& items, const char*) const requires
      requires(const Item& item, FieldWriter w) {
    Item::fields(item, w);
  }
  {
    Json list = Json::array();
    for (const auto& item : items) {
      Json j = Json::object();
      Item::fields(item, FieldWriter{j});
      list.push_back(std::move(j));
    }
    out[name] = std::move(list);
  }
  void operator()(const char* name, const std::vector<SketchElement>& items, const char*) const {
    Json list = Json::array();
    for (const auto& item : items) {
      Json inner = Json::object();
      std::visit([&](const auto& e) { e.fields(e, FieldWriter{inner}); }, item);
      static constexpr const char* kinds[] = {"point", "arc", "nurbs"};
      list.push_back(Json::object({{kinds[item.index()], std::move(inner)}}));
    }
    out[name] = std::move(list);
  }
};

// ---- shapes: reading, by the same walk ------------------------------------------------------------------------------

struct FieldReader {
  const Json& in;
  std::string path;
  std::string at(const char* name) const { return path + "." + name; }
  void operator()(const char* name, Expr& e, Domain, const char*) const {
    e = read_expr(member(in, name, path), at(name));
  }
  void operator()(const char* name, Expr& e, Domain, const char*, double left_out) const {
    e = in.is_object() && in.contains(name) ? read_expr(in[name], at(name)) : Expr(left_out);
  }
  void operator()(const char* name, std::string& text, const char*) const {
    if (in.is_object() && in.contains(name)) text = read_string(in[name], at(name));
  }
  void operator()(const char* name, int& v, const char*) const {
    const double number = read_number(member(in, name, path), at(name));
    if (number != std::floor(number) || std::abs(number) > 1e6) complain(at(name), "expected a whole number");
    v = static_cast<int>(number);
  }
  void operator()(const char* name, bool& v, const char*) const {
    const auto& j = member(in, name, path);
    if (!j.is_boolean()) complain(at(name), "expected true or false");
    v = j.get<bool>();
  }
  void operator()(const char* name, std::vector<double>& v, const char*) const {
    if (!in.is_object() || !in.contains(name)) return;
    for (const auto& item : list_of(in[name], at(name))) v.push_back(read_number(item, at(name)));
  }
  void operator()(const char* name, std::vector<std::string>& v, const char*) const {
    for (const auto& item : list_of(member(in, name, path), at(name))) v.push_back(read_string(item, at(name)));
  }
  void operator()(const char* name, std::vector<std::array<Expr, 2>>& v, const char*) const {
    for (const auto& item : list_of(member(in, name, path), at(name))) {
      if (!item.is_array() || item.size() != 2) complain(at(name), "expected pairs");
      v.push_back({read_expr(item[0], at(name)), read_expr(item[1], at(name))});
    }
  }
  template <std::size_t N>
  void operator()(const char* name, std::vector<std::array<double, N>>& v, const char*) const {
    for (const auto& item : list_of(member(in, name, path), at(name))) {
      if (!item.is_array() || item.size() != N)
        complain(at(name), N == 2 ? "expected pairs of numbers" : "expected triples of numbers");
      auto& numbers = v.emplace_back();
      for (std::size_t k = 0; k < N; ++k) numbers[k] = read_number(item[k], at(name));
    }
  }
  void operator()(const char* name, std::vector<std::array<std::uint32_t, 3>>& v, const char*) const {
    for (const auto& item : list_of(member(in, name, path), at(name))) {
      if (!item.is_array() || item.size() != 3) complain(at(name), "expected triples of indices");
      std::array<std::uint32_t, 3> t{};
      for (int k = 0; k < 3; ++k) {
        if (!item[k].is_number_unsigned() || item[k].get<std::uint64_t>() > 0xFFFFFFFEull)
          complain(at(name), "expected indices of 0 or more");
        t[k] = item[k].get<std::uint32_t>();
      }
      v.push_back(t);
    }
  }
  template <class Item>
  void operator()(const char* name, Item& item, const char*) const requires requires(FieldReader r) {
    Item::fields(item, r);
  }
  { Item::fields(item, FieldReader{member(in, name, path), at(name)}); }
  void operator()(const char* name, std::vector<SketchRelation>& items, const char* meaning) const {
    if (in.is_object() && in.contains(name)) operator()<SketchRelation>(name, items, meaning);
  }
  void operator()(const char* name, std::vector<TriFace>& items, const char* meaning) const {
    if (in.is_object() && in.contains(name)) operator()<TriFace>(name, items, meaning);
  }
  void operator()(const char* name, std::vector<PatchTrim>& items, const char* meaning) const {
    if (in.is_object() && in.contains(name)) operator()<PatchTrim>(name, items, meaning);
  }
  template <class Item>
  void operator()(const char* name, std::vector<Item>& items, const char*) const requires
      requires(Item& item, FieldReader r) {
    Item::fields(item, r);
  }
  {
    int index = 0;
    for (const auto& j : list_of(member(in, name, path), at(name)))
      Item::fields(items.emplace_back(), FieldReader{j, at(name) + "[" + std::to_string(index++) + "]"});
  }
  void operator()(const char* name, std::vector<SketchElement>& items, const char*) const {
    int index = 0;
    for (const auto& j : list_of(member(in, name, path), at(name))) {
      const std::string where = at(name) + "[" + std::to_string(index++) + "]";
      if (!j.is_object() || j.size() != 1) complain(where, "expected one of point, arc, nurbs");
      const std::string kind = j.begin().key();
      SketchElement element;
      if (kind == "point")
        element = SketchPoint{};
      else if (kind == "arc")
        element = SketchArc{};
      else if (kind == "nurbs")
        element = SketchNurbs{};
      else
        complain(where, "expected one of point, arc, nurbs, found '" + kind + "'");
      std::visit([&](auto& e) { e.fields(e, FieldReader{j.begin().value(), where}); }, element);
      items.push_back(std::move(element));
    }
  }
};

Json shape_to_json(const Shape& shape) {
  return std::visit(
      [](const auto& s) {
        Json j = Json::object({{"kind", std::string(s.kind)}});
        s.fields(s, FieldWriter{j});
        return j;
      },
      shape);
}

template <std::size_t I = 0>
Shape read_shape(const std::string& kind, const Json& j, const std::string& path) {
  if constexpr (I == std::variant_size_v<Shape>) {
    complain(path, "unknown shape '" + kind + "'");
  } else {
    using S = std::variant_alternative_t<I, Shape>;
    if (kind != S::kind) return read_shape<I + 1>(kind, j, path);
    S shape;
    S::fields(shape, FieldReader{j, path});
    return shape;
  }
}

// ---- the rest of the document
// -----------------------------------------------------------------------------------------

Json frame_to_json(const Frame& f) {
  return Json::object({{"move", Json::array({to_json(f.x), to_json(f.y), to_json(f.z)})},
                       {"turn", Json::array({to_json(f.rx), to_json(f.ry), to_json(f.rz)})}});
}

Frame read_frame(const Json& j, const std::string& path) {
  Frame f;
  const auto& move = list_of(member(j, "move", path), path + ".move");
  const auto& turn = list_of(member(j, "turn", path), path + ".turn");
  if (move.size() != 3 || turn.size() != 3) complain(path, "expected three lengths to move and three angles to turn");
  f.x = read_expr(move[0], path), f.y = read_expr(move[1], path), f.z = read_expr(move[2], path);
  f.rx = read_expr(turn[0], path), f.ry = read_expr(turn[1], path), f.rz = read_expr(turn[2], path);
  return f;
}

double number_or(const Json& j, const char* key, const std::string& path, double otherwise) {
  return j.contains(key) ? read_number(j[key], path + "." + key) : otherwise;
}
std::string text_or(const Json& j, const char* key, const std::string& path) {
  return j.contains(key) ? read_string(j[key], path + "." + key) : std::string();
}
bool flag_or(const Json& j, const char* key, const std::string& path, bool otherwise) {
  if (!j.contains(key)) return otherwise;
  if (!j[key].is_boolean()) complain(path + "." + key, "expected true or false");
  return j[key].get<bool>();
}
std::size_t count_or(const Json& j, const char* key, const std::string& path) {
  const double v = number_or(j, key, path, 0);
  if (v < 0 || v > 1e15) complain(path + "." + key, "expected a count");
  return static_cast<std::size_t>(v);
}

Json parameter_to_json(const Parameter& p) {
  Json j = {{"name", p.name}};
  for (const auto& [quantity, text] : quantities)
    if (quantity == p.quantity) j["quantity"] = text;
  j["value"] = p.value;
  if (p.formula) j["formula"] = to_json(*p.formula);
  j["fitted"] = p.fitted;
  j["sigma"] = p.sigma;
  j["sigma_noise"] = p.sigma_noise;
  j["sigma_systematic"] = p.sigma_systematic;
  j["points"] = p.points;
  if (p.effective_points > 0) j["effective_points"] = p.effective_points;
  if (p.nominal) {
    j["nominal"] = {{"candidate", p.nominal->candidate},
                    {"z", p.nominal->z},
                    {"kept", p.nominal->kept},
                    {"series", p.nominal->series}};
    if (p.nominal->probability > 0) j["nominal"]["probability"] = p.nominal->probability;
  }
  if (!p.note.empty()) j["note"] = p.note;
  return j;
}

Parameter read_parameter(const Json& j, const std::string& path) {
  Parameter p;
  p.name = read_string(member(j, "name", path), path + ".name");
  const std::string quantity = j.contains("quantity") ? read_string(j["quantity"], path + ".quantity") : "length";
  bool known = false;
  for (const auto& [q, text] : quantities)
    if (quantity == text) p.quantity = q, known = true;
  if (!known) complain(path + ".quantity", "expected length, angle, count or ratio, found '" + quantity + "'");
  if (j.contains("formula")) p.formula = read_expr(j["formula"], path + ".formula");
  // Whoever edits a size by hand need not know what follows from it.
  p.value = p.formula ? number_or(j, "value", path, 0) : read_number(member(j, "value", path), path + ".value");
  p.fitted = number_or(j, "fitted", path, p.value);
  p.sigma = number_or(j, "sigma", path, 0);
  p.sigma_noise = number_or(j, "sigma_noise", path, 0);
  p.sigma_systematic = number_or(j, "sigma_systematic", path, 0);
  p.points = count_or(j, "points", path);
  p.effective_points = count_or(j, "effective_points", path);
  p.note = text_or(j, "note", path);
  if (j.contains("nominal")) {
    const auto& n = j["nominal"];
    const std::string where = path + ".nominal";
    p.nominal = NominalEvidence{read_number(member(n, "candidate", where), where), number_or(n, "z", where, 0),
                                flag_or(n, "kept", where, false), text_or(n, "series", where),
                                number_or(n, "probability", where, 0)};
  }
  return p;
}

Json object_to_json(const Object& o) {
  Json j = {{"name", o.name}, {"shape", shape_to_json(o.shape)}};
  if (!o.frame.identity()) j["frame"] = frame_to_json(o.frame);
  j["evidence"] = {{"points", o.evidence.points},
                   {"rms", o.evidence.rms},
                   {"max", o.evidence.max},
                   {"covered", o.evidence.covered},
                   {"views", o.evidence.views}};
  if (!o.note.empty()) j["note"] = o.note;
  return j;
}

Object read_object(const Json& j, const std::string& path) {
  Object o;
  o.name = read_string(member(j, "name", path), path + ".name");
  const auto& shape = member(j, "shape", path);
  o.shape =
      read_shape(read_string(member(shape, "kind", path + ".shape"), path + ".shape.kind"), shape, path + ".shape");
  if (j.contains("frame")) o.frame = read_frame(j["frame"], path + ".frame");
  if (j.contains("evidence")) {
    const auto& e = j["evidence"];
    const std::string where = path + ".evidence";
    o.evidence = {count_or(e, "points", where), number_or(e, "rms", where, 0), number_or(e, "max", where, 0),
                  number_or(e, "covered", where, 0), static_cast<int>(number_or(e, "views", where, 0))};
  }
  o.note = text_or(j, "note", path);
  return o;
}

Json provenance_to_json(const Provenance& p) {
  Json sources = Json::array();
  for (const auto& s : p.sources) sources.push_back({{"file", s.file}, {"sha256", s.sha256}});
  return {{"sources", sources},   {"points", p.points},   {"rejected", p.rejected},     {"views", p.views},
          {"noise", p.noise},     {"spacing", p.spacing}, {"unit_scale", p.unit_scale}, {"program", p.program},
          {"version", p.version}, {"options", p.options}};
}

Provenance read_provenance(const Json& j, const std::string& path) {
  Provenance p;
  if (j.contains("sources"))
    for (const auto& s : list_of(j["sources"], path + ".sources"))
      p.sources.push_back({read_string(member(s, "file", path), path), text_or(s, "sha256", path)});
  p.points = count_or(j, "points", path);
  p.rejected = count_or(j, "rejected", path);
  p.views = static_cast<int>(number_or(j, "views", path, 0));
  p.noise = number_or(j, "noise", path, 0);
  p.spacing = number_or(j, "spacing", path, 0);
  p.unit_scale = number_or(j, "unit_scale", path, 1);
  if (j.contains("program")) p.program = text_or(j, "program", path);
  p.version = text_or(j, "version", path);
  p.options = text_or(j, "options", path);
  return p;
}

Model read_document(const Json& j) {
  Model m;
  if (!j.is_object()) complain("document", "expected an object");
  const std::string format = read_string(member(j, "format", "document"), "format");
  if (format != "partscribe-model") complain("format", "expected 'partscribe-model', found '" + format + "'");
  const double version = read_number(member(j, "version", "document"), "version");
  if (version < 1 || version > model_format)
    complain("version", "expected 1 to " + print_number(model_format) + ", found " + print_number(version));
  if (const auto units = text_or(j, "units", "document"); !units.empty() && units != "mm")
    complain("units", "expected 'mm', found '" + units + "'");
  if (j.contains("name")) m.name = read_string(j["name"], "name");
  m.tolerance = read_number(member(j, "tolerance", "document"), "tolerance");
  if (j.contains("provenance")) m.provenance = read_provenance(j["provenance"], "provenance");
  int index = 0;
  if (j.contains("parameters"))
    for (const auto& p : list_of(j["parameters"], "parameters"))
      m.parameters.push_back(read_parameter(p, "parameters[" + std::to_string(index++) + "]"));
  index = 0;
  for (const auto& o : list_of(member(j, "objects", "document"), "objects"))
    m.objects.push_back(read_object(o, "objects[" + std::to_string(index++) + "]"));
  if (j.contains("scan_from_part")) m.scan_from_part = read_frame(j["scan_from_part"], "scan_from_part");
  m.as_scanned = flag_or(j, "as_scanned", "document", true);
  m.fallback = flag_or(j, "fallback", "document", false);
  if (j.contains("hypothesis")) {
    const auto& h = j["hypothesis"];
    auto n = [&](const char* key) {
      return read_number(member(h, key, "hypothesis"), std::string("hypothesis.") + key);
    };
    m.hypothesis = Hypothesis{n("a1"),      n("a2"),      n("a3"),  n("e1"),     n("e2"),
                              n("taper_x"), n("taper_y"), n("gof"), n("gof_mm"), text_or(h, "suggests", "hypothesis")};
  }
  if (j.contains("rivals"))
    for (const auto& r : list_of(j["rivals"], "rivals"))
      m.rivals.push_back({read_string(member(r, "procedure", "rivals"), "rivals"),
                          flag_or(r, "meets_tolerance", "rivals", false), number_or(r, "deviation", "rivals", 0),
                          number_or(r, "description_length", "rivals", 0), text_or(r, "reason", "rivals")});
  if (j.contains("unexplained"))
    for (const auto& u : list_of(j["unexplained"], "unexplained"))
      m.unexplained.push_back({text_or(u, "reason", "unexplained"), number_or(u, "area", "unexplained", 0),
                               count_or(u, "points", "unexplained")});
  return m;
}

}  // namespace

std::string write_model_json(const Model& m) {
  Json j;
  j["format"] = "partscribe-model";
  j["version"] = model_format;
  j["program"] = m.provenance.program + (m.provenance.version.empty() ? "" : " " + m.provenance.version);
  j["name"] = m.name;
  j["units"] = "mm";
  j["tolerance"] = m.tolerance;
  j["provenance"] = provenance_to_json(m.provenance);
  j["parameters"] = Json::array();
  for (const auto& p : m.parameters) j["parameters"].push_back(parameter_to_json(p));
  j["objects"] = Json::array();
  for (const auto& o : m.objects) j["objects"].push_back(object_to_json(o));
  j["scan_from_part"] = frame_to_json(m.scan_from_part);
  j["as_scanned"] = m.as_scanned;
  j["fallback"] = m.fallback;
  if (m.hypothesis) {
    const auto& h = *m.hypothesis;
    j["hypothesis"] = {
        {"a1", h.a1},           {"a2", h.a2},           {"a3", h.a3},   {"e1", h.e1},         {"e2", h.e2},
        {"taper_x", h.taper_x}, {"taper_y", h.taper_y}, {"gof", h.gof}, {"gof_mm", h.gof_mm}, {"suggests", h.suggests}};
  }
  j["rivals"] = Json::array();
  for (const auto& r : m.rivals)
    j["rivals"].push_back({{"procedure", r.procedure},
                           {"meets_tolerance", r.meets_tolerance},
                           {"deviation", r.deviation},
                           {"description_length", r.description_length},
                           {"reason", r.reason}});
  j["unexplained"] = Json::array();
  for (const auto& u : m.unexplained)
    j["unexplained"].push_back({{"reason", u.reason}, {"area", u.area}, {"points", u.points}});
  return json_text(j);
}

Result<Model> read_model_json(std::string_view text, const std::string& where) {
  if (nested_too_deeply(text)) return bad_input(where + ": expected a model, found JSON that is nested too deeply");
  try {
    return read_document(Json::parse(text.begin(), text.end()));
  } catch (const Complaint& complaint) {
    return bad_input(where + ": " + complaint.text);
  } catch (const nlohmann::json::parse_error& e) {
    return bad_input(where + ": not JSON: stopped at byte " + print_number(double(e.byte)));
  } catch (const nlohmann::json::exception&) {
    return bad_input(where + ": the document has an unexpected structure");
  }
}

}  // namespace partscribe::model
