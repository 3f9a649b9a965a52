#include "codegen/alpha1/alpha1.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "codegen/alpha1/alpha1_superellipsoid.h"
#include "codegen/alpha1/alpha1_text.h"
#include "codegen/describe.h"
#include "codegen/template.h"
#include "core/ensure.h"
#include "core/number.h"
#include "model/lower/lower.h"
#include "model/sketch.h"

namespace partscribe::codegen {
namespace {

constexpr const char* prelude_name = "prelude.scl";

bool zero(const Expr& e) { return e == Expr(0); }

/// "Cubic" or the number itself.
std::string order_name(int order) {
  static const char* names[] = {"Linear", "Quadratic", "Cubic", "Quartic", "Quintic"};
  return order >= 2 && order <= 6 ? names[order - 2] : std::to_string(order);
}

/// Entries with `;` after each, several to a line.
std::string collected(const std::vector<std::string>& entries) {
  std::string text, line;
  for (const auto& entry : entries) {
    if (!line.empty() && line.size() + entry.size() > 90) {
      text += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + entry + ";";
  }
  return text + line;
}

void trim_end(std::string& text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
}

class Writer {
 public:
  Writer(const Model& model, const TemplatePack& pack, const std::string& stem)
      : model_(model), pack_(pack), stem_(stem), text_(model), values_(values_of(model)) {}

  Result<std::string> write() {
    TemplateList objects;
    for (const Object& object : model_.objects) {
      steps_.clear();
      auto made = std::visit([&](const auto& shape) { return expression_of(object, shape); }, object.shape);
      if (!made.ok()) return made;
      trim_end(*made);
      std::string body;
      for (const auto& s : steps_) body += s + "\n";
      body += text_.object(object.name) + " : " + placed(*made, object.frame) + ";";
      std::vector<std::string> remarks;
      const bool whole = &object == &model_.objects.back();  // the header speaks of it
      const std::string evidence = describe_evidence(object.evidence);
      if (!object.note.empty()) remarks.push_back(as_title(object.note) + ".");
      if (!whole && !evidence.empty()) remarks.push_back("Fit: " + evidence + ".");
      for (const auto& note : text_.take_notes()) remarks.push_back("Where the parameters stand now, " + note + ".");
      objects.push_back({{"remarks", template_lines(remarks)}, {"body", body}});
    }
    std::string last = text_.object(model_.objects.back().name);
    std::string placement;
    const std::string in_scan = placed(last, model_.scan_from_part);
    if (in_scan != last) {
      for (const auto& note : text_.take_notes()) placement += "# Where the parameters stand now, " + note + ".\n";
      placement += "Placed : if ( AsScanned ) " + in_scan + "; else " + last + ";";
      last = "Placed";
    }
    TemplateRecord data;
    TemplateList header;
    for (const auto& line : header_lines(model_)) header.push_back({{"line", line.empty() ? "" : " " + line}});
    data["header"] = header;
    data["prelude"] = prelude_name;
    data["groups"] = parameter_groups();
    data["switches"] = as_designed_ || !placement.empty() ? "yes" : "";
    data["as_designed"] = as_designed_ ? "yes" : "";
    data["as_scanned"] = placement.empty() ? "" : model_.as_scanned ? "true" : "false";
    data["objects"] = objects;
    data["placement"] = placement;
    data["last"] = last;
    data["dump"] = stem_ + ".a1";
    return pack_.render("part.scl", data);
  }

  /// The prelude with what this procedure asks of it.
  Result<std::string> prelude() const {
    return pack_.render(prelude_name, {{"draft", drafted_ ? "yes" : ""}, {"surfaces", surfaces_ ? "yes" : ""}});
  }

 private:
  /// The expression turned and moved to its frame.
  std::string placed(std::string made, const Frame& f) {
    const bool turns = !zero(f.rx) || !zero(f.ry) || !zero(f.rz), moves = !zero(f.x) || !zero(f.y) || !zero(f.z);
    const std::string gap = made.size() > 60 ? "\n    " : " ";
    const std::string turn = text_.angle(f.rx) + ", " + text_.angle(f.ry) + ", " + text_.angle(f.rz);
    const std::string move = text_.plain(f.x) + ", " + text_.plain(f.y) + ", " + text_.plain(f.z);
    if (turns && moves) return "moved( turned(" + gap + made + "," + gap + turn + " ), " + move + " )";
    if (turns) return "turned(" + gap + made + "," + gap + turn + " )";
    if (moves) return "moved(" + gap + made + "," + gap + move + " )";
    return made;
  }

  TemplateList parameter_groups() {
    TemplateList groups;
    for (const auto& group : grouped_parameters(model_)) {
      std::vector<std::string> statements;
      auto real = [](const std::string& number) { return print_real(*parse_number(number)); };
      for (const Parameter* p : group.parameters) {
        std::string value = real(value_text(p->quantity, p->value));
        if (p->formula) value = p->quantity == Quantity::angle ? text_.angle(*p->formula) : text_.plain(*p->formula);
        std::string statement = text_.parameter(p->name) + " : " + value + ";";
        if (const auto as_built = as_built_text(*p, model_.tolerance)) {
          statement = text_.parameter(p->name) + " : if ( AsDesigned ) " + value + "; else " + real(*as_built) + ";";
          as_designed_ = true;
        }
        statements.push_back(statement);
      }
      groups.push_back({{"title", group.title}, {"parameters", parameter_rows(group, statements, model_.tolerance)}});
    }
    return groups;
  }

  /// Every number of the shape under its own name.
  template <class S>
  TemplateRecord fields_of(const S& shape) {
    TemplateRecord data;
    S::fields(shape, [&](const char* name, const auto& field, auto... rest) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(field)>, Expr>) {
        static_cast<void>(std::initializer_list<int>{(static_cast<void>(rest), 0)...});
        data[name] = text_.plain(field);
      }
    });
    return data;
  }

  /// Renders statements that come before the object's own.
  Result<Done> step(const std::string& file, const TemplateRecord& data) {
    auto rendered = pack_.render(file, data);
    if (!rendered.ok()) return rendered.error();
    trim_end(*rendered);
    steps_.push_back(std::move(*rendered));
    return Done{};
  }

  using Made = Result<std::string>;

  Made expression_of(const Object&, const Box& s) { return pack_.render("box.scl", fields_of(s)); }
  Made expression_of(const Object&, const Wedge& s) {
    TemplateRecord data = fields_of(s);
    data["prism"] = zero(s.top_x) ? "yes" : "";
    return pack_.render("wedge.scl", data);
  }
  Made expression_of(const Object&, const Cylinder& s) { return pack_.render("cylinder.scl", fields_of(s)); }
  Made expression_of(const Object&, const Cone& s) {
    TemplateRecord data = fields_of(s);
    data["bottom"] = zero(s.bottom_radius) ? "" : "yes";
    data["top"] = zero(s.top_radius) ? "" : "yes";
    return pack_.render("cone.scl", data);
  }
  Made expression_of(const Object&, const Sphere& s) { return pack_.render("sphere.scl", fields_of(s)); }
  Made expression_of(const Object&, const Ellipsoid& s) { return pack_.render("ellipsoid.scl", fields_of(s)); }

  Made expression_of(const Object& o, const Torus& s) {
    TemplateRecord data = fields_of(s);
    const std::string tube = text_.fresh(o.name + " tube");
    data["tube"] = tube;
    data["outer"] = text_.plain(s.major_radius + s.minor_radius);
    data["inner"] = text_.plain(s.major_radius - s.minor_radius);
    data["minor_factor"] = text_.factor(s.minor_radius);
    if (auto done = step("torus.scl", data); !done.ok()) return done.error();
    return "solidOfRevolution( " + tube + " )";
  }

  Made expression_of(const Object& o, const Superellipsoid& s) {
    const auto now = std::get<SuperellipsoidOf<double>>(evaluate(Shape(s), values_));
    // Two procedures of one part may differ by a fifth of the tolerance; half of that is left to others.
    const auto net = superellipsoid_net(now, model_.tolerance / 10);
    TemplateRecord data;
    const std::string label = text_.fresh(o.name + " net");
    data["net"] = label;
    data["corner"] = text_.fresh(o.name + " corner");
    data["section"] = text_.fresh(o.name + " section");
    for (const auto& [name, field] :
         {std::pair{"a1", &s.a1}, {"a2", &s.a2}, {"a3", &s.a3}, {"taper_x", &s.taper_x}, {"taper_y", &s.taper_y}})
      data[name] = text_.factor(*field);
    for (const auto& [name, field] : {std::pair{"e1", &s.e1}, {"e2", &s.e2}})
      data[name] = print_real(text_.value(*field)) + (field->is_number() ? "" : " (" + text_.plain(*field) + ")");
    data["deviation"] = print_number(std::max(snapped(net.deviation, 1e-4), 1e-4));
    TemplateList around, along;
    for (const auto& a : net.around) around.push_back({{"c", print_real(a.c)}, {"s", print_real(a.s)}});
    const bool bent = !zero(s.bend);
    data["bend"] = "";
    if (bent)
      data["bend"] =
          print_degrees(now.bend) + " degrees" + (s.bend.is_number() ? "" : " (" + text_.angle(s.bend) + ")");
    for (const auto& a : net.along) {
      std::string row = print_real(a.r) + ", " + print_real(a.q) + ", ";
      if (bent)
        for (const double v : {a.rc, a.qc, a.rs, a.qs, a.u}) row += print_real(v) + ", ";
      along.push_back({{"row", row + print_real(bent ? a.w : a.z)}});
    }
    data["around"] = around;
    data["along"] = along;
    if (auto done = step("superellipsoid.scl", data); !done.ok()) return done.error();
    const std::string order = order_name(net.order);
    return "solidOfSurface( surface( " + order + ", \"ec_periodic\", \"kv_uniform\", " + order +
           ", \"ec_open\", \"kv_uniform\", " + label + " ) )";
  }

  Made expression_of(const Object& o, const Supertoroid& s) {
    const auto now = std::get<SupertoroidOf<double>>(evaluate(Shape(s), values_));
    const auto net = supertoroid_net(now, model_.tolerance / 10);
    TemplateRecord data;
    const std::string label = text_.fresh(o.name + " net");
    data["net"] = label;
    data["section"] = text_.fresh(o.name + " section");
    data["major_radius"] = text_.plain(s.major_radius);
    data["minor_radius"] = text_.factor(s.minor_radius);
    data["half_height"] = text_.factor(s.half_height);
    for (const auto& [name, field] : {std::pair{"e1", &s.e1}, {"e2", &s.e2}})
      data[name] = print_real(text_.value(*field)) + (field->is_number() ? "" : " (" + text_.plain(*field) + ")");
    data["deviation"] = print_number(std::max(snapped(net.deviation, 1e-4), 1e-4));
    TemplateList around, tube;
    for (const auto& a : net.around) around.push_back({{"c", print_real(a.c)}, {"s", print_real(a.s)}});
    for (const auto& a : net.tube) tube.push_back({{"c", print_real(a.c)}, {"s", print_real(a.s)}});
    data["around"] = around;
    data["tube"] = tube;
    if (auto done = step("supertoroid.scl", data); !done.ok()) return done.error();
    const std::string order = order_name(net.order);
    return "solidOfSurface( surface( " + order + ", \"ec_periodic\", \"kv_uniform\", " + order +
           ", \"ec_periodic\", \"kv_uniform\", " + label + " ) )";
  }

  /// All copies, collected by a loop over their number and united.
  Made repeated(const Object& o, const Expr& count, const std::string& motion) {
    const std::string copies = text_.fresh(o.name + " copies");
    steps_.push_back(copies + " : forCollect ( I; 0; I < " + text_.plain(count) + "; I + 1 ) " + motion + ";");
    return "solidUnionOf( " + copies + " )";
  }

  Made expression_of(const Object& o, const LinearPattern& s) {
    const std::string operand = text_.object(s.object);
    auto along = [&](const Expr& step) { return zero(step) ? std::string("0.0") : "I * " + text_.factor(step); };
    return repeated(
        o, s.count,
        "moved( " + operand + ", " + along(s.step_x) + ", " + along(s.step_y) + ", " + along(s.step_z) + " )");
  }
  Made expression_of(const Object& o, const CircularPattern& s) {
    return repeated(o, s.count,
                    "turned( " + text_.object(s.object) + ", 0.0, 0.0, I * " + text_.angle_factor(s.step) + " )");
  }

  template <LoweredAway S>
  Made expression_of(const Object&, const S&) {
    ensure(false, "features that SCL does not know are lowered before");
    return std::string();
  }

  Made expression_of(const Object& o, const HalfSpaces& s) {
    TemplateList planes;
    std::vector<std::string> rows;
    std::size_t width = 0;
    for (const auto& h : s.planes) {
      rows.push_back("halfSpace( " + text_.plain(h.normal_x) + ", " + text_.plain(h.normal_y) + ", " +
                     text_.plain(h.normal_z) + ", " + text_.plain(h.offset) + " );");
      width = std::max(width, rows.back().size());
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!s.planes[i].name.empty()) rows[i].resize(width, ' ');
      planes.push_back({{"plane", rows[i]}, {"role", one_line(s.planes[i].name)}});
    }
    const std::string sides = text_.fresh(o.name + " sides");
    if (auto done = step("half_spaces.scl", {{"sides", sides}, {"planes", planes}}); !done.ok()) return done.error();
    return "solidOfHalfSpaces( " + sides + " )";
  }

  Made expression_of(const Object& o, const Extrude& s) {
    auto profiles = profiles_of(o, s.sketch, false);
    if (!profiles.ok()) return profiles;
    if (!zero(s.draft)) {
      drafted_ = true;
      return "solidOfDraftedExtrusion( " + *profiles + ", " + text_.plain(s.below) + ", " + text_.plain(s.height) +
             ", " + text_.angle(s.draft) + " )";
    }
    const std::string made = "solidOfExtrusion( " + *profiles + ", " + text_.plain(s.below + s.height) + " )";
    return zero(s.below) ? made : "moved( " + made + ", 0.0, 0.0, " + text_.plain(-s.below) + " )";
  }

  Made expression_of(const Object& o, const Revolve& s) {
    auto profiles = profiles_of(o, s.sketch, true);
    if (!profiles.ok()) return profiles;
    if (s.angle == Expr(2 * pi)) return "solidOfRevolution( " + *profiles + " )";
    return "solidOfPartialRevolution( " + *profiles + ", " + text_.angle(s.angle) + " )";
  }

  Made expression_of(const Object& o, const TriSurface& s) {
    TemplateList corners, triangles;
    std::vector<std::string> labels;
    for (const auto& v : s.vertices) {
      labels.push_back(text_.fresh(o.name + " v " + std::to_string(labels.size() + 1)));
      corners.push_back(
          {{"label", labels.back()}, {"x", print_real(v[0])}, {"y", print_real(v[1])}, {"z", print_real(v[2])}});
    }
    for (const auto& t : s.triangles)
      triangles.push_back({{"a", labels[t[0]]}, {"b", labels[t[1]]}, {"c", labels[t[2]]}});
    const std::string facets = text_.fresh(o.name + " facets");
    if (auto done = step("tri_surface.scl", {{"corners", corners}, {"triangles", triangles}, {"facets", facets}});
        !done.ok())
      return done.error();
    return "polyhedronOfFacets( " + facets + " )";
  }

  Made expression_of(const Object& o, const SurfaceSet& s) {
    std::vector<std::string> surfaces;
    for (const auto& patch : s.patches) {
      auto name = surface_of(patch, o.name + " " + (s.patches.size() == 1 ? "surface" : patch.name));
      if (!name.ok()) return name.error();
      surfaces.push_back(std::move(*name));
    }
    if (surfaces.size() == 1 && !s.closed) return surfaces[0];
    const std::string faces = text_.fresh(o.name + " faces");
    steps_.push_back(faces + " : seqCollect {\n    " + collected(surfaces) + "\n}");
    return "shellOf( " + faces + " )";
  }

  Made expression_of(const Object& o, const SweptSurface& s) {
    const auto name = surface_of(s.surface, o.name + " surface");
    if (!name.ok()) return name.error();
    std::string move;
    for (const double x : s.direction) move += (move.empty() ? "" : ", ") + print_real(x);
    return "solidOfSweptSurface( " + *name + ", vec( " + move + " ) )";
  }

  /// The statements that make a patch; its label.
  Made surface_of(const TrimmedPatch& patch, const std::string& role) {
    const std::string name = text_.fresh(role);
    TemplateRecord data = {{"name", name},
                           {"whole", patch.trims.empty() ? name : name + "Whole"},
                           {"bordered", patch.trims.empty() ? "" : "yes"},
                           {"u", order_name(patch.degree_u + 1)},
                           {"v", order_name(patch.degree_v + 1)},
                           {"knots_u", collected(reals(patch.knots_u))},
                           {"knots_v", collected(reals(patch.knots_v))},
                           {"rows", net_rows(patch)}};
    data["weighted"] = patch.weights.empty() ? "" : "yes";
    data["weights"] = patch.weights.empty() ? TemplateList{} : weight_rows(patch);
    TemplateList trims, loops;
    for (const auto& trim : patch.trims) {
      const std::string label = text_.fresh(role + " trim " + std::to_string(trims.size() + 1));
      std::vector<std::string> points;
      for (const auto& p : trim.control)
        points.push_back("pt( " + print_real(p[0]) + ", " + print_real(p[1]) + ", 0.0 )");
      trims.push_back({{"label", label},
                       {"order", order_name(trim.degree + 1)},
                       {"knots", collected(reals(trim.knots))},
                       {"points", collected(points)}});
      if (static_cast<std::size_t>(trim.loop) >= loops.size()) loops.push_back({{"curves", ""}});
      auto& curves = std::get<std::string>(loops.back().at("curves").value);
      curves += (curves.empty() ? "" : " ") + label + ";";
    }
    data["trims"] = trims, data["loops"] = loops;
    surfaces_ = true;
    if (auto done = step("surface_patch.scl", data); !done.ok()) return done.error();
    return name;
  }

  static std::vector<std::string> reals(const std::vector<double>& values) {
    std::vector<std::string> result;
    for (const double v : values) result.push_back(print_real(v));
    return result;
  }

  /// A row of the net runs along u.
  static TemplateList rows_of(const TrimmedPatch& patch, const std::function<std::string(std::size_t)>& entry) {
    const std::size_t columns = patch.knots_v.size() - static_cast<std::size_t>(patch.degree_v) - 1;
    TemplateList rows;
    for (std::size_t j = 0; j < columns; ++j) {
      std::vector<std::string> entries;
      for (std::size_t i = j; i < patch.control.size(); i += columns) entries.push_back(entry(i));
      rows.push_back({{"row", collected(entries)}});
    }
    return rows;
  }
  static TemplateList net_rows(const TrimmedPatch& patch) {
    return rows_of(patch, [&](std::size_t i) {
      const auto& p = patch.control[i];
      return "pt( " + print_real(p[0]) + ", " + print_real(p[1]) + ", " + print_real(p[2]) + " )";
    });
  }
  static TemplateList weight_rows(const TrimmedPatch& patch) {
    return rows_of(patch, [&](std::size_t i) { return print_real(patch.weights[i]); });
  }

  Made expression_of(const Object& o, const Union& s) { return combined(o, "solidUnion", " with ", s.objects); }
  Made expression_of(const Object& o, const Difference& s) {
    return combined(o, "solidDifference", " without ", s.objects);
  }
  Made expression_of(const Object& o, const Intersection& s) {
    return combined(o, "solidCommon", " within ", s.objects);
  }

  /// A chain of two-shell operations, each result with a label of its own: "BracketWithoutBore1".
  Made combined(const Object& o, const std::string& operation, const std::string& joint,
                const std::vector<std::string>& operands) {
    std::string result = text_.object(operands[0]);
    for (std::size_t i = 1; i < operands.size(); ++i) {
      const std::string made = operation + "( " + result + ", " + text_.object(operands[i]) + " )";
      if (i + 1 == operands.size()) return made;
      result = text_.fresh(o.name + joint + operands[i]);
      steps_.push_back(result + " : " + made + ";");
    }
    return result;
  }

  // ---- sketches -------------------------------------------------------------------------------------------------

  /// A point of the sketch in the plane it is drawn in.
  std::string point(const Expr& x, const Expr& y, bool about_axis) {
    return std::string(about_axis ? "atRadius( " : "pt( ") + text_.plain(x) + ", " + text_.plain(y) + " )";
  }

  struct Place {
    Expr x, y;
  };

  /// a + b, where a - b + b is a.
  static Expr sum(const Expr& a, const Expr& b) {
    if (a.kind == Expr::Kind::subtract && a.arguments[1] == b) return a.arguments[0];
    if (a.kind == Expr::Kind::add && a.arguments[1] == -b) return a.arguments[0];
    return a + b;
  }
  static Place on_arc(const SketchArc& a, const Expr& angle) {
    return {sum(a.center_x, a.radius * cos_of(angle)), sum(a.center_y, a.radius * sin_of(angle))};
  }
  static Place first_of(const SketchElement& e) {
    if (const auto* p = std::get_if<SketchPoint>(&e)) return {p->x, p->y};
    if (const auto* a = std::get_if<SketchArc>(&e)) return on_arc(*a, a->from);
    const auto& n = std::get<SketchNurbs>(e);
    return {n.control.front()[0], n.control.front()[1]};
  }
  static Place last_of(const SketchElement& e) {
    if (const auto* a = std::get_if<SketchArc>(&e)) return on_arc(*a, a->to);
    if (const auto* n = std::get_if<SketchNurbs>(&e)) return {n->control.back()[0], n->control.back()[1]};
    return first_of(e);
  }
  bool meet(const Place& a, const Place& b) const {
    return std::hypot(text_.value(a.x) - text_.value(b.x), text_.value(a.y) - text_.value(b.y)) <= sketch_join;
  }

  /// Writes a profile for every loop; returns the label of the only one, or of the array of all.
  Made profiles_of(const Object& o, const Sketch& sketch, bool about_axis) {
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < sketch.loops.size(); ++i) {
      const Loop& loop = sketch.loops[i];
      const std::string role = !loop.name.empty() ? loop.name : i == 0 ? "outline" : "hole " + std::to_string(i);
      labels.push_back(text_.fresh(o.name + " " + role));
      if (auto done = profile(o, loop, labels.back(), about_axis); !done.ok()) return done.error();
    }
    if (labels.size() == 1) return labels[0];
    const std::string all = text_.fresh(o.name + " profiles");
    steps_.push_back(all + " : seqCollect {\n    " + indented_list(labels) + "\n}");
    return all;
  }

  static std::string indented_list(const std::vector<std::string>& entries) {
    std::string text = collected(entries);
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 5) text.insert(at + 1, "    ");
    return text;
  }

  Result<Done> profile(const Object& o, const Loop& loop, const std::string& label, bool about_axis) {
    TemplateList curves, corners;
    auto corner = [&](const std::string& text, const std::string& role) {
      corners.push_back({{"corner", text}, {"role", one_line(role)}});
    };
    for (const auto& element : loop.elements) {
      if (const auto* p = std::get_if<SketchPoint>(&element)) {
        corner(point(p->x, p->y, about_axis), p->edge);
      } else if (const auto* a = std::get_if<SketchArc>(&element)) {
        const double turn = text_.value(a->to) - text_.value(a->from);
        // Three points say a whole circle only in halves.
        const int parts = std::abs(turn) > 1.9 * pi ? 2 : 1;
        for (int k = 0; k < parts; ++k) {
          auto at = [&](int half) {
            const Expr angle = half == 0           ? a->from
                               : half == 2 * parts ? a->to
                                                   : a->from + (a->to - a->from) * Expr(half) / Expr(2 * parts);
            const Place place = on_arc(*a, angle);
            return point(place.x, place.y, about_axis);
          };
          const bool last = k + 1 == parts;
          std::string role = k == 0 ? a->name : "";
          if (last && !a->edge.empty()) role += (role.empty() ? "" : ", then ") + a->edge;
          const std::string first = at(2 * k), middle = at(2 * k + 1), end = at(2 * k + 2);
          const std::string gap = first.size() + middle.size() + end.size() > 80 ? "\n             " : " ";
          corner("arcThru3Pts( " + first + "," + gap + middle + "," + gap + end + " )", role);
        }
      } else {
        const auto& n = std::get<SketchNurbs>(element);
        const std::string name = text_.fresh(o.name + " " + (n.name.empty() ? "curve" : n.name));
        for (const char* part : {" knots", " points", " weights"}) text_.fresh(name + part);
        std::vector<std::string> knots, points, weights;
        for (const double k : n.knots) knots.push_back(print_real(k));
        for (const auto& c : n.control) points.push_back(point(c[0], c[1], about_axis));
        for (std::size_t i = 0; i < n.control.size(); ++i)
          weights.push_back(print_real(n.weights.empty() ? 1.0 : n.weights[i]));
        curves.push_back({{"name", name},
                          {"order", order_name(n.degree + 1)},
                          {"knots", collected(knots)},
                          {"points", collected(points)},
                          {"weights", collected(weights)}});
        corner(name, n.edge.empty() ? "" : "then " + n.edge);
      }
    }
    const Place first = first_of(loop.elements.front());
    if (!meet(last_of(loop.elements.back()), first)) corner(point(first.x, first.y, about_axis), "");
    separate(corners);
    return step("sketch.scl", {{"curves", curves}, {"loop", label}, {"corners", corners}});
  }

  const Model& model_;
  const TemplatePack& pack_;
  const std::string& stem_;
  Alpha1Text text_;
  Values values_;
  std::vector<std::string> steps_;  // statements that come before the present object's own
  bool as_designed_ = false, drafted_ = false, surfaces_ = false;
};

}  // namespace

Result<Artifact> emit_alpha1(const CheckedModel& checked, const EmitOptions& options, Context&) {
  auto pack = load_template_pack("alpha1", options.templates);
  if (!pack.ok()) return pack.error();
  const Model model = lowered(*checked, Kinds{SweptSurface::kind, LinearPattern::kind, CircularPattern::kind});
  Writer writer(model, *pack, options.stem);
  auto part = writer.write();
  if (!part.ok()) return part.error();
  auto prelude = writer.prelude();
  if (!prelude.ok()) return prelude.error();
  return Artifact{"alpha1", {{options.stem + ".scl", std::move(*part)}, {prelude_name, std::move(*prelude)}}};
}

Backend alpha1_backend() {
  return {
      "alpha1",
      ".scl",
      {"prelude.scl"},
      "Alpha_1 procedural model in SCL",
      {{"and",   "const", "else", "false",     "for",    "forcollect", "foreach", "function", "if",   "include", "let",
        "local", "not",   "or",   "procedure", "return", "step",       "then",    "to",       "true", "while"},
       "#",
       "",
       ""},
      emit_alpha1};
}

}  // namespace partscribe::codegen
