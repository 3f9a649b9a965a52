#include "fit/triangulate.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/reconstruct.h"
#include "geometry/decimate.h"
#include "geometry/mesh_repair.h"
#include "geometry/orient_normals.h"
#include "geometry/self_intersection.h"
#include "geometry/thin.h"

namespace partscribe {
namespace {

/// Coordinates on the decimal grid `resolution`; false where that would unite vertices or flatten a triangle.
bool snap(const TriangleMesh& mesh, double resolution, TriangleMesh& result) {
  result = mesh;
  for (Vec3& v : result.vertices)
    for (int k = 0; k < 3; ++k) v[k] = snapped(v[k], resolution);
  const auto order = coordinate_order(result.vertices);
  for (std::size_t i = 1; i < order.size(); ++i)
    if (result.vertices[order[i]] == result.vertices[order[i - 1]]) return false;
  for (std::size_t t = 0; t < result.triangles.size(); ++t) {
    const Vec3 now = triangle_normal(result, t), before = triangle_normal(mesh, t);
    if (!(now.squaredNorm() > 0.5) || now.dot(before) < 0.5) return false;
  }
  return true;
}

TriangleMesh snapped_mesh(const TriangleMesh& mesh, double resolution) {
  TriangleMesh result;
  for (int digits = 0; digits < 7; ++digits, resolution /= 10)
    if (snap(mesh, power_of_ten_below(resolution * 1.000001), result)) return result;
  return mesh;
}

/// Decimated as far as the bound allows without letting the surface pass through itself.
TriangleMesh simplified(const TriangleMesh& mesh, double max_error, Context& context) {
  TriangleMesh first;
  for (const double share : {1.0, 0.4, 0.1}) {
    DecimateOptions options;
    options.max_error = share * max_error;
    TriangleMesh small = decimated(mesh, options, context);
    if (self_intersections(small, 1).empty()) return small;
    if (share == 1.0) first = std::move(small);
  }
  // The source crosses itself already; the smallest mesh is as good as any.
  return self_intersections(mesh, 1).empty() ? mesh : first;
}

/// Starts the vertices at the lowest one in each triangle and sorts both lists, so that equal surfaces have equal text.
TriangleMesh canonical(const TriangleMesh& mesh) {
  const auto order = coordinate_order(mesh.vertices);
  std::vector<std::uint32_t> index(order.size());
  TriangleMesh result;
  for (std::uint32_t i = 0; i < order.size(); ++i)
    index[order[i]] = i, result.vertices.push_back(mesh.vertices[order[i]]);
  for (const auto& t : mesh.triangles) {
    std::array<std::uint32_t, 3> w = {index[t[0]], index[t[1]], index[t[2]]};
    std::rotate(w.begin(), std::min_element(w.begin(), w.end()), w.end());
    result.triangles.push_back(w);
  }
  std::sort(result.triangles.begin(), result.triangles.end());
  return result;
}

/// Vertices and triangles of a mesh file in an order that depends on the coordinates only.
TriangleMesh ordered_source(const TriangleMesh& mesh) { return canonical(welded(mesh, 0)); }

}  // namespace

Result<Candidate> triangulate(const FitInput& input, Context& context) {
  TriangleMesh mesh;
  bool closed = false;
  const double tolerance = input.tolerance;
  if (input.scan && !input.scan->mesh.empty()) {
    RepairOptions options;
    options.separation = 0.1 * tolerance;
    RepairReport report = repair(ordered_source(input.scan->mesh), options);
    if (report.dropped_components > 0)
      context.say("triangulate: " + std::to_string(report.dropped_components) +
                  " small floating pieces of the mesh left out");
    if (report.filled_holes > 0)
      context.say("triangulate: " + std::to_string(report.filled_holes) + " holes of the mesh filled");
    mesh = std::move(report.mesh);
    closed = report.closed;
  } else {
    // All points if they are prepared, because averaging many lowers the noise; else the thinned ones.
    const bool full = input.oriented && input.scan && input.scan->cloud.normals.size() == input.scan->cloud.size();
    PointCloud turned;
    if (!full && !input.oriented) {
      turned = input.cloud;
      orient_normals(turned, 12, context);
    }
    const PointCloud& cloud = full ? input.scan->cloud : input.oriented ? input.cloud : turned;
    SamplingSummary sampling = input.sampling;
    if (!full) sampling.spacing = std::max(sampling.spacing, 0.6 * input.thin_spacing);
    Reconstruction made = reconstruct(cloud, sampling, {}, context);
    mesh = std::move(made.mesh);
    closed = made.closed;
  }
  if (mesh.empty())
    return bad_input("triangulate: expected points that lie on a surface, found " + std::to_string(input.cloud.size()) +
                     " points that span none");
  mesh = snapped_mesh(simplified(mesh, 0.4 * tolerance, context), power_of_ten_below(tolerance / 20));
  mesh = canonical(mesh);

  Candidate candidate;
  candidate.procedure = "triangulation";
  candidate.object_name = closed ? "body" : "sheet";
  TriSurface surface;
  for (const Vec3& v : mesh.vertices) surface.vertices.push_back({v.x(), v.y(), v.z()});
  surface.triangles = mesh.triangles;
  surface.closed = closed;
  if (closed) {
    surface.thickness = 0;
  } else {
    Parameter thickness;
    thickness.name = "sheet_thickness";
    thickness.value = std::max(2.0, std::ceil(3 * tolerance));
    thickness.fitted = thickness.value;
    thickness.note = "thickness of the solid made from the open sheet; chosen, not measured";
    surface.thickness = Expr::of(thickness.name);
    candidate.parameters.push_back(std::move(thickness));
  }
  candidate.extra_numbers = static_cast<int>(3 * surface.vertices.size() + 3 * surface.triangles.size());
  candidate.shape = std::move(surface);
  return candidate;
}

}  // namespace partscribe
