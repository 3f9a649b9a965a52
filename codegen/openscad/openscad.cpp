#include "codegen/openscad/openscad.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "codegen/describe.h"
#include "codegen/openscad/openscad_sketch.h"
#include "codegen/openscad/openscad_surfaces.h"
#include "codegen/openscad/openscad_text.h"
#include "codegen/template.h"
#include "codegen/thicken.h"
#include "core/ensure.h"
#include "core/number.h"
#include "model/lower/lower.h"
#include "model/lower/solids.h"
#include "model/surface_patches.h"

namespace partscribe::codegen {
namespace {

/// A condition that the sizes of a shape have to meet, in the script's own words.
class Guards {
 public:
  explicit Guards(const OpenscadText& text) : text_(text) {}

  void add(const Expr& expr, Domain domain) {
    if (expr.is_number()) return;
    // Half of a diameter is positive where the diameter is.
    const bool part = expr.kind == Expr::Kind::divide && expr.arguments[1].is_number() && expr.arguments[1].number > 0;
    if (part && (domain == Domain::length || domain == Domain::length_or_zero)) return add(expr.arguments[0], domain);
    const std::string name = text_.plain(expr);
    if (domain == Domain::length) add(name + " > 0", name + " must be positive");
    if (domain == Domain::length_or_zero) add(name + " >= 0", name + " must not be negative");
    if (domain == Domain::exponent) add(name + " >= 0.1 && " + name + " <= 2", name + " must lie in 0.1 .. 2");
    if (domain == Domain::turn) {
      const std::string turn = text_.angle(expr);
      add(turn + " > 0 && " + turn + " <= 360", turn + " must lie in 0 .. 360");
    }
    if (domain == Domain::count)
      add(name + " >= 1 && " + name + " == floor(" + name + ")", name + " must be a whole number");
    if (domain == Domain::taper) add("abs(" + name + ") <= 0.95", name + " must lie in -0.95 .. 0.95");
  }
  void add(const std::string& condition, const std::string& message) {
    if (seen_.insert(condition).second) list_.push_back({{"condition", condition}, {"message", message}});
  }
  const TemplateList& list() const { return list_; }

 private:
  const OpenscadText& text_;
  std::set<std::string> seen_;
  TemplateList list_;
};

class Writer {
 public:
  /// `stated`: the model before it was lowered, whose sizes the script guards.
  Writer(const Model& model, const Model& stated, const TemplatePack& pack)
      : model_(model), pack_(pack), text_(model), guards_(text_) {
    for (const Object& object : stated.objects)
      visit_expressions(object.shape, [&](const Expr& e, Domain d) { guards_.add(e, d); });
    for (const auto& [name, spelled] : text_.names().object) modules_.insert(spelled);
  }

  Result<std::string> write() {
    TemplateList objects;
    for (const Object& object : model_.objects) {
      auto body = std::visit([&](const auto& shape) { return module_of(object, shape); }, object.shape);
      if (!body.ok()) return body;
      while (!body->empty() && body->back() == '\n') body->pop_back();
      std::vector<std::string> remarks;
      const bool whole = &object == &model_.objects.back();  // the header speaks of it
      const std::string evidence = describe_evidence(object.evidence);
      if (!whole && !object.note.empty()) remarks.push_back(as_title(object.note) + ".");
      if (!whole && !evidence.empty()) remarks.push_back("Fit: " + evidence + ".");
      objects.push_back({{"remarks", template_lines(remarks)}, {"body", *body}});
    }
    needs_.facets |= needs_.disc || needs_.ball;
    needs_.arc |= needs_.ball;
    const bool curved = needs_.facets || needs_.arc || uses_chord_error_;
    auto flag = [](bool on) { return on ? "yes" : ""; };
    auto helpers = pack_.render("helpers.scad", {{"facets", flag(needs_.facets)},
                                                 {"arc", flag(needs_.arc)},
                                                 {"on_axis", flag(needs_.on_axis)},
                                                 {"disc", flag(needs_.disc)},
                                                 {"bore", flag(needs_.bore)},
                                                 {"ball", flag(needs_.ball)}});
    if (!helpers.ok()) return helpers;

    const std::string placement = place(model_.scan_from_part, false);
    TemplateList groups = parameter_groups();
    TemplateRecord data;
    TemplateList header;
    for (const auto& line : header_lines(model_)) header.push_back({{"line", line.empty() ? "" : " " + line}});
    data["header"] = header;
    data["library"] = flag(needs_.library);
    data["switches"] = flag(as_designed_ || !placement.empty());
    data["as_designed"] = flag(as_designed_);
    data["as_scanned"] = placement.empty() ? "" : model_.as_scanned ? "true" : "false";
    data["groups"] = groups;
    data["curved"] = flag(curved);
    data["chord_error"] = print_number(model_.tolerance / 10);
    data["guarded"] = flag(!guards_.list().empty());
    data["asserts"] = guards_.list();
    data["objects"] = objects;
    data["placement"] = placement;
    data["helpers"] = *helpers;
    const std::string& last = text_.names().object.at(model_.objects.back().name);
    data["last"] = last == "part" ? "" : last;
    data["data"] = tables_;
    data["call"] = "";  // of tables that are none
    return pack_.render("part.scad", data);
  }

  bool needs_library() const { return needs_.library; }

 private:
  /// "translate([..]) rotate([..]) ", or on a line of its own before a longer statement; empty for no motion.
  std::string place(const Frame& f, bool own_line) const {
    std::string result;
    const auto zero = [](const Expr& e) { return e == Expr(0); };
    if (!zero(f.x) || !zero(f.y) || !zero(f.z)) {
      result += "translate([" + text_.plain(f.x) + ", " + text_.plain(f.y) + ", " + text_.plain(f.z) + "]) ";
    }
    if (!zero(f.rx) || !zero(f.ry) || !zero(f.rz)) {
      result += "rotate([" + text_.angle(f.rx) + ", " + text_.angle(f.ry) + ", " + text_.angle(f.rz) + "]) ";
    }
    if (own_line && !result.empty()) {
      result.pop_back();
      result += "\n  ";
    }
    return result;
  }

  TemplateList parameter_groups() {
    TemplateList groups;
    for (const auto& group : grouped_parameters(model_)) {
      std::vector<std::string> statements;
      for (const Parameter* p : group.parameters) {
        std::string value = value_text(p->quantity, p->value);
        if (p->formula) value = p->quantity == Quantity::angle ? text_.angle(*p->formula) : text_.plain(*p->formula);
        if (const auto as_built = as_built_text(*p, model_.tolerance)) {
          value = "as_designed ? " + value + " : " + *as_built;
          as_designed_ = true;
        }
        statements.push_back(text_.names().parameter.at(p->name) + " = " + value + ";");
      }
      groups.push_back({{"title", group.title}, {"parameters", parameter_rows(group, statements, model_.tolerance)}});
    }
    return groups;
  }

  TemplateRecord data_of(const Object& object, bool own_line = true) const {
    return {{"name", text_.names().object.at(object.name)}, {"place", place(object.frame, own_line)}};
  }

  /// Every number of the shape under its own name.
  template <class S>
  TemplateRecord data_of_fields(const Object& object, const S& shape) const {
    TemplateRecord data = data_of(object);
    S::fields(shape, [&](const char* name, const auto& field, auto... rest) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(field)>, Expr>) {
        data[name] = text_.of(field, std::get<0>(std::forward_as_tuple(rest...)));
      }
    });
    return data;
  }

  /// The larger of two lengths as text.
  std::string larger(const Expr& a, const Expr& b) const {
    if (a == b) return text_.plain(a);
    if (a.is_number() && b.is_number()) return text_.plain(text_.value(a) > text_.value(b) ? a : b);
    return "max(" + text_.plain(a) + ", " + text_.plain(b) + ")";
  }

  Result<std::string> module_of(const Object& o, const Box& s) {
    return pack_.render("box.scad", data_of_fields(o, s));
  }
  Result<std::string> module_of(const Object& o, const Wedge& s) {
    return pack_.render("wedge.scad", data_of_fields(o, s));
  }

  Result<std::string> module_of(const Object& o, const Cylinder& s) {
    needs_.facets = true;
    return pack_.render("cylinder.scad", data_of_fields(o, s));
  }

  Result<std::string> module_of(const Object& o, const Cone& s) {
    needs_.facets = true;
    TemplateRecord data = data_of_fields(o, s);
    data["largest_radius"] = larger(s.bottom_radius, s.top_radius);
    return pack_.render("cone.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Sphere& s) {
    needs_.ball = true;
    return pack_.render("sphere.scad", data_of_fields(o, s));
  }

  Result<std::string> module_of(const Object& o, const Ellipsoid& s) {
    needs_.ball = true;
    return pack_.render("ellipsoid.scad", data_of_fields(o, s));
  }

  Result<std::string> module_of(const Object& o, const Torus& s) {
    needs_.disc = true;
    TemplateRecord data = data_of_fields(o, s);
    data["outer_radius"] = text_.plain(s.major_radius + s.minor_radius);
    if (!s.major_radius.is_number() || !s.minor_radius.is_number()) {
      const std::string minor = text_.plain(s.minor_radius), major = text_.plain(s.major_radius);
      guards_.add(minor + " < " + major, minor + " must be less than " + major);
    }
    return pack_.render("torus.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Superellipsoid& s) {
    needs_.library = uses_chord_error_ = true;
    TemplateRecord data = data_of_fields(o, s);
    if (s.bend == Expr(0)) data["bend"] = "";
    return pack_.render("superellipsoid.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Supertoroid& s) {
    needs_.library = uses_chord_error_ = true;
    return pack_.render("supertoroid.scad", data_of_fields(o, s));
  }

  /// Plain holes are a cylinder that cuts; others are turned, so that their parts make one body.
  Result<std::string> module_of(const Object& o, const Hole& s) {
    const bool plain = s.head_diameter == Expr(0) && s.sink_diameter == Expr(0) && s.tip_angle == Expr(0);
    if (!plain) return module_of(o, solid_of(s));
    needs_.facets = needs_.bore = true;
    TemplateRecord data = data_of(o);
    data["diameter"] = text_.plain(s.diameter);
    data["from"] = text_.plain(s.through ? -s.depth - s.overshoot : -s.depth);
    data["to"] = text_.plain(s.overshoot);
    return pack_.render("hole.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Slot& s) {
    needs_.disc = true;
    TemplateRecord data = data_of(o);
    const Expr reach = (s.length - s.width) / Expr(2), below = s.through ? s.depth + s.overshoot : s.depth;
    data["reach"] = text_.plain(reach);
    data["back"] = text_.plain(-reach);
    data["radius"] = text_.plain(s.width / Expr(2));
    data["bottom"] = text_.plain(-below);
    data["height"] = text_.plain(below + s.overshoot);
    guards_.add(text_.plain(s.length) + " > " + text_.plain(s.width), "a slot must be longer than wide");
    return pack_.render("slot.scad", data);
  }

  /// k times a step: "i * pitch".
  std::string steps(const Expr& step) const {
    return step == Expr(0) ? "0" : "i * " + text_.factor(step, Domain::coordinate);
  }

  Result<std::string> module_of(const Object& o, const LinearPattern& s) {
    TemplateRecord data = data_of(o);
    data["motion"] = "translate([" + steps(s.step_x) + ", " + steps(s.step_y) + ", " + steps(s.step_z) + "])";
    data["last"] = text_.plain(s.count - Expr(1));
    data["operand"] = text_.names().object.at(s.object);
    return pack_.render("pattern.scad", data);
  }

  Result<std::string> module_of(const Object& o, const CircularPattern& s) {
    TemplateRecord data = data_of(o);
    data["motion"] = "rotate([0, 0, i * " + text_.factor(s.step, Domain::angle) + "])";
    data["last"] = text_.plain(s.count - Expr(1));
    data["operand"] = text_.names().object.at(s.object);
    return pack_.render("pattern.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Mirror& s) {
    TemplateRecord data = data_of(o, false);
    Frame behind;
    (s.axis == "x" ? behind.x : s.axis == "y" ? behind.y : behind.z) = Expr(2) * s.offset;
    data["behind"] = place(behind, false);
    data["normal"] = s.axis == "x" ? "[1, 0, 0]" : s.axis == "y" ? "[0, 1, 0]" : "[0, 0, 1]";
    data["operand"] = text_.names().object.at(s.object);
    data["keep"] = s.keep ? "yes" : "";
    return pack_.render("mirror.scad", data);
  }

  template <LoweredAway S>
  Result<std::string> module_of(const Object&, const S&) {
    ensure(false, "features that OpenSCAD does not know are lowered before");
    return std::string();
  }

  Result<std::string> module_of(const Object& o, const HalfSpaces& s) {
    needs_.library = true;
    std::vector<std::string> rows;
    std::size_t width = 0;
    for (std::size_t i = 0; i < s.planes.size(); ++i) {
      const HalfSpace& h = s.planes[i];
      rows.push_back("[[" + text_.plain(h.normal_x) + ", " + text_.plain(h.normal_y) + ", " + text_.plain(h.normal_z) +
                     "], " + text_.plain(h.offset) + "]" + (i + 1 < s.planes.size() ? "," : ""));
      width = std::max(width, rows.back().size());
    }
    std::string lines;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!s.planes[i].name.empty()) {
        rows[i].resize(width, ' ');
        rows[i] += "  // " + one_line(s.planes[i].name);
      }
      lines += (i ? "\n" : "") + rows[i];
    }
    TemplateRecord data = data_of(o);
    data["rows"] = lines;
    return pack_.render("half_spaces.scad", data);
  }

  Result<std::string> module_of(const Object& o, const Extrude& s) {
    if (!(s.draft == Expr(0))) return drafted(o, s);
    return swept(o, s, "_outline", false, "extrude.scad",
                 {{"height", text_.plain(s.below + s.height)}, {"below", below_text(s.below)}});
  }

  Result<std::string> module_of(const Object& o, const Revolve& s) {
    needs_.facets = true;
    return swept(o, s, "_profile", true, "revolve.scad",
                 {{"angle", s.angle == Expr(2 * pi) ? "" : "angle = " + text_.angle(s.angle) + ", "}});
  }

  Result<std::string> drafted(const Object& o, const Extrude& s) {
    TemplateRecord data = data_of(o);
    data["draft"] = text_.angle(s.draft);
    if (const auto* circle = only_circle(s.sketch, text_)) {
      needs_.facets = true;
      const std::string radius = text_.plain(circle->radius), lean = " * tan(" + text_.angle(s.draft) + ")";
      auto moved = [&](const char* sign, const Expr& by) {
        return by == Expr(0) ? radius : radius + sign + text_.factor(by, Domain::length) + lean;
      };
      const std::string bottom = moved(" + ", s.below), top = moved(" - ", s.height);
      for (const std::string& end : {bottom, top})
        guards_.add(end + " > 0", "the draft is too large: the circle vanishes");
      Frame foot;
      foot.x = circle->center_x, foot.y = circle->center_y, foot.z = -s.below;
      data["foot"] = place(foot, false);
      data["bottom_radius"] = bottom, data["top_radius"] = top;
      data["largest_radius"] = text_.value(s.draft) > 0 ? bottom : top;
      data["height"] = text_.plain(s.below + s.height);
      return pack_.render("drafted_circle.scad", data);
    }
    needs_.library = uses_chord_error_ = true;
    data["loops"] = openscad_loops(s.sketch, text_);
    data["height"] = text_.plain(s.height);
    data["below"] = s.below == Expr(0) ? "" : text_.plain(s.below);
    return pack_.render("drafted.scad", data);
  }

  /// "translate([0, 0, -root]) " where a body begins below the plane of its sketch.
  std::string below_text(const Expr& below) const {
    return below == Expr(0) ? "" : "translate([0, 0, " + text_.plain(-below) + "]) ";
  }

  template <class S>
  Result<std::string> swept(const Object& o, const S& s, const std::string& suffix, bool about_axis, const char* file,
                            const TemplateRecord& more) {
    TemplateRecord data = data_of(o);
    for (const auto& [name, text] : more) data[name] = text;
    std::string sketch_name = text_.names().object.at(o.name) + suffix;
    while (!modules_.insert(sketch_name).second) sketch_name += "_sketch";
    auto sketch = openscad_sketch(s.sketch, sketch_name, about_axis, text_, pack_, needs_);
    if (!sketch.ok()) return sketch.error();
    std::string& module = sketch->text;
    while (!module.empty() && module.back() == '\n') module.pop_back();
    if (needs_.library) uses_chord_error_ = true;
    data["sketch"] = module;
    data["sketch_name"] = sketch_name;
    if (about_axis) data["largest_radius"] = sketch->largest_radius;
    return pack_.render(file, data);
  }

  Result<std::string> module_of(const Object& o, const TriSurface& s) {
    TemplateRecord data = data_of_fields(o, s);
    const std::string name = text_.names().object.at(o.name);
    std::vector<std::string> points, faces;
    for (const auto& v : s.vertices) points.push_back(point_text({v[0], v[1], v[2]}));
    // OpenSCAD wants clockwise faces.
    for (const auto& t : s.triangles) {
      faces.push_back("[" + std::to_string(t[0]) + ", " + std::to_string(t[2]) + ", " + std::to_string(t[1]) + "]");
    }
    table(name + "_points", "Corners [mm].", points);
    if (!s.closed) {
      std::vector<std::string> normals, rim;
      const double stated = text_.value(s.thickness), thickness = stated > 0 ? stated : 10 * model_.tolerance;
      for (const Vec3& n : sheet_normals(s.vertices, s.triangles, thickness))
        normals.push_back(point_text(snapped_vector(n, 1e-6)));
      for (const auto& [from, to] : sheet_rim(s.triangles)) {
        rim.push_back("[" + std::to_string(to) + ", " + std::to_string(from) + "]");
      }
      table(name + "_normals", "Outward directions at the corners, scaled so that the sheet moves by its thickness.",
            normals);
      table(name + "_rim", "Edges of the boundary.", rim);
      needs_.library = true;
      if (stated <= 0) data["thickness"] = print_number(thickness);
    }
    table(name + "_faces", "Triangles, clockwise seen from outside.", faces);
    return pack_.render(s.closed ? "tri_surface.scad" : "sheet.scad", data);
  }

  std::function<std::string(std::string)> fresh_module() {
    return [this](std::string wanted) {
      while (!modules_.insert(wanted).second) wanted += "_surface";
      return wanted;
    };
  }

  Result<std::string> module_of(const Object& o, const SurfaceSet& s) {
    TemplateRecord data = data_of_fields(o, s);
    const std::string name = text_.names().object.at(o.name);
    const double stated = text_.value(s.thickness), thickness = stated > 0 ? stated : 10 * model_.tolerance;
    OpenscadSurfaces made = openscad_surfaces(s, name, thickness, model_.tolerance, fresh_module());
    for (auto& t : made.tables) tables_.push_back(std::move(t));
    data["sheet"] = s.closed ? "" : "yes";
    data["surfaces"] = made.surfaces, data["corners"] = made.corners, data["towards"] = made.towards;
    if (!s.closed && stated <= 0) data["thickness"] = print_number(thickness);
    needs_.library = true;
    return pack_.render("surface_set.scad", data);
  }

  Result<std::string> module_of(const Object& o, const SweptSurface& s) {
    TemplateRecord data = data_of(o);
    const std::string name = text_.names().object.at(o.name);
    SurfaceSet sheet;
    sheet.patches = {with_border(s.surface)};
    const OpenscadSurfaces made = openscad_surfaces(sheet, name, 1, model_.tolerance, fresh_module());
    tables_.insert(tables_.end(), made.tables.begin(), made.tables.end());
    data["surfaces"] = made.surfaces, data["corners"] = made.corners;
    data["direction"] = point_text(Vec3(s.direction.data()));
    needs_.library = true;
    return pack_.render("swept_surface.scad", data);
  }

  void table(const std::string& name, const std::string& remark, const std::vector<std::string>& entries) {
    tables_.push_back({{"name", name}, {"remark", remark}, {"rows", wrapped_entries(entries)}});
  }

  Result<std::string> module_of(const Object& o, const Union& s) { return combined(o, "union", s.objects); }
  Result<std::string> module_of(const Object& o, const Difference& s) { return combined(o, "difference", s.objects); }
  Result<std::string> module_of(const Object& o, const Intersection& s) {
    return combined(o, "intersection", s.objects);
  }

  Result<std::string> combined(const Object& o, const std::string& operation,
                               const std::vector<std::string>& operands) {
    TemplateRecord data = data_of(o, false);
    data["operation"] = operation;
    std::vector<std::string> calls;
    for (const auto& operand : operands) calls.push_back(text_.names().object.at(operand));
    data["operands"] = template_lines(calls);
    return pack_.render("boolean.scad", data);
  }

  const Model& model_;
  const TemplatePack& pack_;
  OpenscadText text_;
  Guards guards_;
  OpenscadNeeds needs_;
  bool uses_chord_error_ = false, as_designed_ = false;
  std::set<std::string> modules_;
  TemplateList tables_;
};

}  // namespace

Result<Artifact> emit_openscad(const CheckedModel& checked, const EmitOptions& options, Context&) {
  auto pack = load_template_pack("openscad", options.templates);
  if (!pack.ok()) return pack.error();
  const Model model = lowered(*checked, Kinds{Hole::kind, Slot::kind, SweptSurface::kind, LinearPattern::kind,
                                              CircularPattern::kind, Mirror::kind});
  Writer writer(model, *checked, *pack);
  auto script = writer.write();
  if (!script.ok()) return script.error();
  Artifact artifact{"openscad", {{options.stem + ".scad", std::move(script).value()}}};
  if (writer.needs_library()) {
    auto library = pack->render("partscribe.scad", {});
    if (!library.ok()) return library.error();
    artifact.files.push_back({"partscribe.scad", std::move(library).value()});
  }
  return artifact;
}

Backend openscad_backend() {
  return {"openscad",
          ".scad",
          {"partscribe.scad"},
          "OpenSCAD script with named parameters (2021.01 or later)",
          {{"assert", "each", "echo", "else", "false", "for", "function", "if", "include", "let", "module", "true",
            "undef", "use", "children"},
           "//",
           "/*",
           "*/"},
          emit_openscad};
}

}  // namespace partscribe::codegen
