#include "codegen/openscad/openscad_surfaces.h"

#include <algorithm>
#include <cctype>

#include "codegen/describe.h"
#include "codegen/openscad/openscad_text.h"
#include "codegen/thicken.h"
#include "core/number.h"
#include "model/surface_patches.h"

namespace partscribe::codegen {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Triangles whose corners are listed surface after surface, each on the first that has it.
struct ListedTriangles {
  std::vector<std::vector<Vec2>> places;  // of each surface: (u, v)
  std::vector<Vec3> corners;
  Triangles triangles;
};

ListedTriangles listed(const std::vector<TrimmedSurface>& surfaces, double deviation, double tolerance) {
  const SurfaceTriangles made = triangulated(surfaces, deviation);
  struct Owner {
    std::uint32_t patch = ~0u;
    Vec2 uv;
  };
  std::vector<Owner> owners(made.mesh.vertices.size());
  for (std::size_t t = 0; t < made.mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (Owner& owner = owners[made.mesh.triangles[t][k]]; made.patch[t] < owner.patch)
        owner = {made.patch[t], made.place[t][k]};
  ListedTriangles result;
  std::vector<std::uint32_t> number(owners.size());
  for (std::uint32_t p = 0; p < surfaces.size(); ++p) {
    const NurbsSurface& s = surfaces[p].surface;
    auto& places = result.places.emplace_back();
    for (std::size_t i = 0; i < owners.size(); ++i) {
      if (owners[i].patch != p) continue;
      // So many digits that a corner moves along its surface by a hundredth of the tolerance at most.
      const SurfacePoint at = s.derivatives(owners[i].uv.x(), owners[i].uv.y());
      const auto rounded = [&](double v, const Vec3& along, const KnotVector& knots) {
        return std::clamp(snapped(v, power_of_ten_below(0.01 * tolerance / std::max(along.norm(), 1e-9))), knots.low(),
                          knots.high());
      };
      const Vec2 uv(rounded(owners[i].uv.x(), at.du, s.u), rounded(owners[i].uv.y(), at.dv, s.v));
      number[i] = static_cast<std::uint32_t>(result.corners.size());
      places.push_back(uv);
      result.corners.push_back(s.at(uv.x(), uv.y()));
    }
  }
  for (const auto& t : made.mesh.triangles) result.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  return result;
}

std::string numbers_text(const std::vector<double>& numbers) {
  std::vector<std::string> entries;
  for (const double v : numbers) entries.push_back(print_number(v));
  return "[" + wrapped_entries(entries) + "]";
}

std::string list_text(const std::vector<std::string>& entries) { return "[" + wrapped_entries(entries) + "]"; }

class Tables {
 public:
  explicit Tables(TemplateList& list) : list_(list) {}

  void rows(const std::string& name, const std::string& remark, const std::string& text) {
    list_.push_back({{"name", name}, {"remark", remark}, {"rows", text}});
  }
  void call(const std::string& name, const std::string& remark, const std::string& text) {
    list_.push_back({{"name", name}, {"remark", remark}, {"call", text}});
  }

  /// A surface by its control points and its knots.
  void surface(const std::string& name, const TrimmedPatch& patch) {
    const std::size_t columns = patch.knots_v.size() - static_cast<std::size_t>(patch.degree_v) - 1;
    std::string control, weights;
    for (std::size_t i = 0; i < patch.control.size(); i += columns) {
      std::vector<std::string> row, row_weights;
      for (std::size_t j = i; j < i + columns; ++j) {
        row.push_back(point_text(Vec3(patch.control[j].data())));
        if (!patch.weights.empty()) row_weights.push_back(print_number(patch.weights[j]));
      }
      const std::string comma = i + columns < patch.control.size() ? ",\n" : "";
      control += list_text(row) + comma;
      weights += list_text(row_weights) + comma;
    }
    rows(name + "_control", "Control points [mm], a row for each u. Move one, and the surface follows.", control);
    if (!patch.weights.empty()) rows(name + "_weights", "Their weights.", weights);
    call(name, "The surface: degrees, knots along u and along v, control points.",
         "spline_surface([" + std::to_string(patch.degree_u) + ", " + std::to_string(patch.degree_v) + "],\n  " +
             numbers_text(patch.knots_u) + ",\n  " + numbers_text(patch.knots_v) + ",\n  " + name + "_control" +
             (patch.weights.empty() ? ")" : ", " + name + "_weights)"));
  }

 private:
  TemplateList& list_;
};

}  // namespace

OpenscadSurfaces openscad_surfaces(const SurfaceSet& set, const std::string& name, double thickness, double tolerance,
                                   const std::function<std::string(std::string)>& fresh) {
  OpenscadSurfaces result;
  Tables tables(result.tables);
  std::vector<std::string> surfaces, corners;
  for (const TrimmedPatch& patch : set.patches) {
    std::string wanted = name + "_" + (set.patches.size() == 1 ? "surface" : patch.name);
    std::replace_if(
        wanted.begin(), wanted.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    surfaces.push_back(fresh(wanted));
    corners.push_back(surfaces.back() + "_corners");
    tables.surface(surfaces.back(), patch);
  }
  const ListedTriangles made = listed(trimmed_surfaces(set.patches), tolerance / 8, tolerance);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    std::vector<std::string> places;
    for (const Vec2& at : made.places[k])
      places.push_back("[" + print_number(at.x()) + ", " + print_number(at.y()) + "]");
    tables.rows(corners[k], "Where on it corners of triangles lie, [u, v].", wrapped_entries(places));
  }
  if (!set.closed) {
    std::vector<std::string> rim;
    for (const auto& [from, to] : sheet_rim(made.triangles))
      rim.push_back("[" + std::to_string(to) + ", " + std::to_string(from) + "]");
    tables.rows(name + "_rim", "Edges of the boundary.", wrapped_entries(rim));
    std::vector<std::array<double, 3>> vertices;
    for (const Vec3& p : made.corners) vertices.push_back({p.x(), p.y(), p.z()});
    const auto backs = sheet_normals(vertices, made.triangles, thickness);
    if (std::all_of(backs.begin(), backs.end(), [&](const Vec3& n) { return n == backs.front(); }))
      result.towards = ",\n    towards = " + point_text(snapped_vector(backs.front(), 1e-6));
  }
  std::vector<std::string> faces;
  for (const auto& t : made.triangles)
    faces.push_back("[" + std::to_string(t[0]) + ", " + std::to_string(t[2]) + ", " + std::to_string(t[1]) + "]");
  tables.rows(name + "_faces", "Triangles, clockwise seen from outside.", wrapped_entries(faces));
  result.surfaces = list_text(surfaces), result.corners = list_text(corners);
  return result;
}

}  // namespace partscribe::codegen
