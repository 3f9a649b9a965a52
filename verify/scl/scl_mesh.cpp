/// Triangles of evaluated Alpha_1 geometry with the measured distance to the surfaces they stand for.
#include <BRep_Tool.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>

#include "verify/exchange/mesh_shape.h"
#include "verify/scl/scl_shape.h"

namespace partscribe::verify {
namespace {

Vec3 vec3(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

double to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const double sq = way.squaredNorm();
  const double t = sq > 0 ? std::clamp((p - a).dot(way) / sq, 0.0, 1.0) : 0.0;
  return (a + t * way - p).norm();
}

/// Parameters at which a direction is sampled: every distinct knot and `parts` equal steps between.
std::vector<double> samples(const std::vector<double>& knots, int parts) {
  std::vector<double> result;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i)
    for (int k = 0; k < parts; ++k) result.push_back(knots[i] + (knots[i + 1] - knots[i]) * k / parts);
  result.push_back(knots.back());
  return result;
}

}  // namespace

SclMesh surface_mesh(const SclGeometry& geometry, double deviation) {
  TopoDS_Face face;
  if (TopExp_Explorer faces(*geometry.shape, TopAbs_FACE); faces.More()) face = TopoDS::Face(faces.Current());
  const auto surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
  ensure(!surface.IsNull(), "a natural geometry is one B-spline surface");
  std::vector<double> uk, vk;
  for (int i = surface->FirstUKnotIndex(); i <= surface->LastUKnotIndex(); ++i) uk.push_back(surface->UKnot(i));
  for (int i = surface->FirstVKnotIndex(); i <= surface->LastVKnotIndex(); ++i) vk.push_back(surface->VKnot(i));
  const GeomAdaptor_Surface adaptor(surface);  // remembers the span it is in
  auto at = [&](double u, double v) { return vec3(adaptor.Value(u, v)); };

  int u_parts = surface->UDegree() > 1 ? 2 : 1, v_parts = surface->VDegree() > 1 ? 2 : 1;
  constexpr std::size_t max_nodes = 4'000'000;
  for (;;) {
    const auto us = samples(uk, u_parts), vs = samples(vk, v_parts);
    const std::size_t nu = us.size(), nv = vs.size();
    std::vector<Vec3> grid(nu * nv);
    for (std::size_t j = 0; j < nv; ++j)
      for (std::size_t i = 0; i < nu; ++i) grid[j * nu + i] = at(us[i], vs[j]);
    double u_error = 0, v_error = 0, error = 0;
    SclMesh result;
    // Nodes on a seam or a pole are one.
    auto equal = [](const Vec3& a, const Vec3& b) { return (a - b).norm() <= scl_join; };
    std::vector<std::uint32_t> node(nu * nv, ~0u);
    bool u_closed = true, v_closed = true;
    for (std::size_t j = 0; j < nv; ++j) u_closed = u_closed && equal(grid[j * nu], grid[j * nu + nu - 1]);
    for (std::size_t i = 0; i < nu; ++i) v_closed = v_closed && equal(grid[i], grid[(nv - 1) * nu + i]);
    std::vector<bool> row_pole(nv, true), column_pole(nu, true);
    for (std::size_t j = 0; j < nv; ++j)
      for (std::size_t i = 0; i < nu; ++i)
        if (!equal(grid[j * nu + i], grid[j * nu])) row_pole[j] = false;
    for (std::size_t i = 0; i < nu; ++i)
      for (std::size_t j = 0; j < nv; ++j)
        if (!equal(grid[j * nu + i], grid[i])) column_pole[i] = false;
    for (std::size_t j = 0; j < nv; ++j)
      for (std::size_t i = 0; i < nu; ++i) {
        const std::size_t jj = column_pole[i] || (v_closed && j + 1 == nv) ? 0 : j;
        const std::size_t ii = row_pole[j] || (u_closed && i + 1 == nu) ? 0 : i;
        const std::size_t source = jj * nu + ii;
        if (node[source] == ~0u) {
          node[source] = static_cast<std::uint32_t>(result.mesh.vertices.size());
          result.mesh.vertices.push_back(grid[source]);
        }
        node[j * nu + i] = node[source];
      }
    for (std::size_t j = 0; j + 1 < nv; ++j)
      for (std::size_t i = 0; i + 1 < nu; ++i) {
        const std::size_t a = j * nu + i, b = a + 1, d = a + nu, c = d + 1;
        const double u = 0.5 * (us[i] + us[i + 1]), v = 0.5 * (vs[j] + vs[j + 1]);
        if (surface->UDegree() > 1) u_error = std::max(u_error, to_segment(at(u, vs[j]), grid[a], grid[b]));
        if (surface->VDegree() > 1) v_error = std::max(v_error, to_segment(at(us[i], v), grid[a], grid[d]));
        const Vec3 centre = at(u, v);
        const double first = to_segment(centre, grid[a], grid[c]), second = to_segment(centre, grid[b], grid[d]);
        error = std::max({error, u_error, v_error, std::min(first, second)});
        auto add = [&](std::size_t p, std::size_t q, std::size_t r) {
          if (node[p] != node[q] && node[q] != node[r] && node[r] != node[p])
            result.mesh.triangles.push_back({node[p], node[q], node[r]});
        };
        if (first <= second)
          add(a, b, c), add(a, c, d);
        else
          add(a, b, d), add(b, c, d);
      }
    result.error = error;
    if (error <= deviation || nu * nv * 4 > max_nodes) {
      result.mesh = welded(result.mesh, 0);
      return result;
    }
    // Chord errors fall with the square of the step; both directions together fill the budget.
    auto wanted = [&](int parts, double chord) {
      return std::max(parts,
                      std::min(4 * parts, static_cast<int>(std::ceil(parts * std::sqrt(chord / (0.45 * deviation))))));
    };
    const int u_before = u_parts, v_before = v_parts;
    u_parts = wanted(u_parts, u_error), v_parts = wanted(v_parts, v_error);
    if (u_parts == u_before && v_parts == v_before) ++u_parts, ++v_parts;
  }
}

namespace {

Result<Done> add_object(const SclGeometryPtr& object, double deviation, const SclStop& stop, SclMesh& all, int depth) {
  if (object->kind == SclGeometryKind::group) {
    if (depth > 50) return bad_input("expected groups at most 50 deep");
    for (const auto& member : object->members)
      if (auto done = add_object(member, deviation, stop, all, depth + 1); !done.ok()) return done;
    return Done{};
  }
  if (object->kind != SclGeometryKind::surface && object->kind != SclGeometryKind::primitive &&
      object->kind != SclGeometryKind::shell)
    return bad_input(std::string("expected a solid or surface as the result, found ") + name_of(object->kind));
  SclMesh part;
  if (!object->trimmed.empty()) {
    SurfaceTriangles made = triangulated(object->trimmed, deviation);
    part.mesh = std::move(made.mesh), part.error = made.deviation;
  } else if (!object->shape) {
    part.mesh = welded(facet_mesh(*object), 0);
  } else if (object->natural) {
    part = surface_mesh(*object, deviation);
  } else {
    if (stop && stop()) return Error{"the triangulation was stopped", ErrorKind::stopped};
    // mesh_shape aims at a tenth of the tolerance it is given.
    auto mesh = mesh_shape(*object->shape, 10 * deviation);
    if (mesh.mesh.empty()) return bad_input("the object could not be triangulated");
    part.mesh = std::move(mesh.mesh);
    part.error = mesh.error;
  }
  const bool closed = topology(part.mesh).closed();
  if (closed && volume(part.mesh) < 0)
    for (auto& t : part.mesh.triangles) std::swap(t[1], t[2]);
  const auto base = static_cast<std::uint32_t>(all.mesh.vertices.size());
  all.mesh.vertices.insert(all.mesh.vertices.end(), part.mesh.vertices.begin(), part.mesh.vertices.end());
  for (const auto& t : part.mesh.triangles) all.mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  all.error = std::max(all.error, part.error);
  all.solid = all.solid && closed;
  return Done{};
}

}  // namespace

Result<SclMesh> scl_mesh(const std::vector<SclGeometryPtr>& objects, double deviation, const SclStop& stop) {
  SclMesh all;
  all.solid = true;
  try {
    for (const auto& object : objects)
      if (auto done = add_object(object, deviation, stop, all, 0); !done.ok()) return done.error();
  } catch (const Standard_Failure& f) {
    return bad_input(std::string("the object could not be triangulated: ") +
                     (f.GetMessageString() ? f.GetMessageString() : "geometry kernel failed"));
  }
  if (all.mesh.empty()) return bad_input("expected an object with area as the result");
  return all;
}

}  // namespace partscribe::verify
