/// Faces of a mesh: its patches described, and how they meet.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/disjoint_sets.h"
#include "core/number.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/fit_facets.h"
#include "geometry/segment/mesh_patches.h"

namespace partscribe::geometry {
namespace {

constexpr double tangent_angle = 0.03;      // rad between two analytic surfaces that meet smoothly
constexpr double widest_smooth_bend = 0.5;  // rad between facets of surfaces that may meet smoothly
constexpr int turn_bins = 720;
constexpr double bent_little = 0.35;    // rad between two cones that may be facets of one turned surface
constexpr std::size_t least_rings = 4;  // in a row

/// The surface through all corners at once, with its uncertainty.
PrimitiveFit fit_of(const MeshPatch& patch, const TriangleMesh& mesh, const Facets& facets, std::size_t& points) {
  PrimitiveFitOptions options;
  options.start = *patch.surface;
  std::vector<Vec3> corners, normals;
  if (patch.surface->kind == PrimitiveKind::plane) {
    std::vector<std::uint32_t> vertices;
    for (const auto f : patch.facets)
      vertices.insert(vertices.end(), facets.facets[f].vertices.begin(), facets.facets[f].vertices.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const auto v : vertices) corners.push_back(mesh.vertices[v]), normals.push_back(patch.surface->axis);
  } else {
    const FacetGroup group(mesh, facets, patch.facets);
    corners = group.corners(), normals = group.corner_normals();
  }
  points = corners.size();
  PrimitiveFit fallback;
  fallback.primitive = *patch.surface;
  fallback.determined = false;
  for (const auto& p : corners) fallback.rms += distance(*patch.surface, p) * distance(*patch.surface, p);
  fallback.rms = corners.empty() ? 0 : std::sqrt(fallback.rms / static_cast<double>(corners.size()));
  const auto fit = fit_primitive(patch.surface->kind, corners, normals, options);
  return fit && fit->rms <= fallback.rms * 1.001 + 1e-12 ? *fit : fallback;
}

/// Sums over the facets of one patch; the axis of round kinds gets a sense that does not depend on the fit.
class Description {
 public:
  Description(const TriangleMesh& mesh, const Facets& facets, const MeshPatch& patch)
      : mesh_(mesh), facets_(facets), patch_(patch) {}

  Face face() {
    Face face;
    for (const auto f : patch_.facets) {
      const Facet& facet = facets_.facets[f];
      face.area += facet.area, face.middle += facet.area * facet.middle;
      face.members.insert(face.members.end(), facet.triangles.begin(), facet.triangles.end());
    }
    std::sort(face.members.begin(), face.members.end());
    if (face.area > 0) face.middle /= face.area;
    face.spread = spread_of(face);
    if (!patch_.surface) return face;
    face.fit = fit_of(patch_, mesh_, facets_, face.points);
    face.kind = face_kind(patch_.surface->kind), face.hollow = patch_.hollow;
    Primitive& p = face.fit.primitive;
    if (p.kind == PrimitiveKind::plane) {
      if (p.axis.dot(patch_.surface->axis) < 0) p.axis = -p.axis;
      p.point = face.middle - distance(p, face.middle) * p.axis;
      return face;
    }
    for (const auto f : patch_.facets)
      face.sagitta = std::max(face.sagitta, std::abs(distance(p, facets_.facets[f].middle)));
    if (p.kind == PrimitiveKind::sphere) {
      face.coverage = std::min(1.0, face.area / (4 * pi * p.radius * p.radius));
      return face;
    }
    Eigen::Index along;
    p.axis.cwiseAbs().maxCoeff(&along);
    if (p.kind != PrimitiveKind::cone && p.axis[along] < 0) p.axis = -p.axis;
    measure_along_axis(face);
    return face;
  }

 private:
  const TriangleMesh& mesh_;
  const Facets& facets_;
  const MeshPatch& patch_;

  Mat3 spread_of(const Face& face) const {
    Mat3 sum = Mat3::Zero();
    for (const auto t : face.members) {
      const Vec3 a = mesh_.corner(t, 0) - face.middle, b = mesh_.corner(t, 1) - face.middle,
                 c = mesh_.corner(t, 2) - face.middle, s = a + b + c;
      const double area = 0.5 * (b - a).cross(c - a).norm();
      sum += area / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    }
    return face.area > 0 ? Mat3(sum / face.area) : sum;
  }

  void measure_along_axis(Face& face) const {
    Primitive& p = face.fit.primitive;
    const Mat3 frame = rotation_onto_axis(p.axis);
    std::vector<char> bins(turn_bins, 0);
    double low = 1e300, high = -1e300;
    for (const auto f : patch_.facets) {
      // Angles of the corners relative to the facet's middle, so that no facet spans the seam.
      const Vec3 m = frame.transpose() * (facets_.facets[f].middle - p.point);
      const double centre = std::atan2(m.y(), m.x());
      double first = 0, last = 0;
      for (const auto v : facets_.facets[f].vertices) {
        const Vec3 q = frame.transpose() * (mesh_.vertices[v] - p.point);
        low = std::min(low, q.z()), high = std::max(high, q.z());
        if (std::hypot(q.x(), q.y()) < 1e-6 * p.radius) continue;
        const double a = std::remainder(std::atan2(q.y(), q.x()) - centre, 2 * pi);
        first = std::min(first, a), last = std::max(last, a);
      }
      const double step = 2 * pi / turn_bins;
      const auto from = static_cast<long>(std::floor((centre + first) / step)),
                 to = static_cast<long>(std::floor((centre + last) / step));
      for (long k = from; k <= to; ++k) bins[static_cast<std::size_t>(((k % turn_bins) + turn_bins) % turn_bins)] = 1;
    }
    face.arc = 2 * pi * static_cast<double>(std::count(bins.begin(), bins.end(), 1)) / turn_bins;
    place_half_way(face, low, high);
    const double slant = p.kind == PrimitiveKind::cone ? std::cos(p.half_angle) : 1;
    face.coverage = p.kind == PrimitiveKind::torus
                        ? face.arc / (2 * pi)
                        : std::min(1.0, face.area * slant / (2 * pi * p.radius * std::max(high - low, 1e-300)));
  }
};

/// Border between two faces.
struct Border {
  double length = 0, turned = 0, convex = 0;
};

bool both_known(const Face& a, const Face& b) { return a.kind != FaceKind::free_form && b.kind != FaceKind::free_form; }

void find_neighbours(const TriangleMesh& mesh, Faces& faces) {
  const auto normals = triangle_normals(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, Border> borders;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> around) {
    if (around.size() == 1 && faces.face_of[around[0].triangle] != no_face)
      faces.faces[faces.face_of[around[0].triangle]].complete = false;
    for (std::size_t i = 0; i + 1 < around.size(); ++i) {
      const auto f = faces.face_of[around[i].triangle], g = faces.face_of[around[i + 1].triangle];
      if (f == g || f == no_face || g == no_face) continue;
      const Vec3 from = mesh.vertices[around[i].from()], to = mesh.vertices[around[i].to()];
      const double length = (to - from).norm();
      if (!(length > 0)) continue;
      const Vec3 n = normals[around[i].triangle], m = normals[around[i + 1].triangle];
      // Of the surfaces where both are known, else of the facets.
      const Face &a = faces.faces[f], &b = faces.faces[g];
      const Vec3 place = 0.5 * (from + to);
      const Vec3 p = both_known(a, b) ? outward_normal(a, place) : n,
                 q = both_known(a, b) ? outward_normal(b, place) : m;
      Border& border = borders[{std::min(f, g), std::max(f, g)}];
      border.length += length, border.turned += length * std::atan2(p.cross(q).norm(), p.dot(q));
      border.convex += n.cross(m).dot(to - from) > 0 ? length : -length;
    }
  });
  for (const auto& [pair, border] : borders) {
    Face &a = faces.faces[pair.first], &b = faces.faces[pair.second];
    const double angle = border.turned / border.length;
    const bool smooth = angle < (both_known(a, b) ? tangent_angle : widest_smooth_bend);
    const EdgeKind edge = smooth ? EdgeKind::tangent : border.convex > 0 ? EdgeKind::convex : EdgeKind::concave;
    a.neighbours.push_back({pair.second, edge, angle, border.length});
    b.neighbours.push_back({pair.first, edge, angle, border.length});
  }
}

/// All its corners lie on two circles: any two rings of a turned surface of free form have a cone between them.
bool has_two_rings(const TriangleMesh& mesh, const Face& face) {
  if (face.kind != FaceKind::cone && face.kind != FaceKind::cylinder) return false;
  const Primitive& p = face.surface();
  const double near = 1e-3 * (face.high - face.low);
  for (const auto t : face.members)
    for (int k = 0; k < 3; ++k) {
      const double along = (mesh.corner(t, k) - p.point).dot(p.axis);
      if (along - face.low > near && face.high - along > near) return false;
    }
  return true;
}

/// Several faces as one of free form; without neighbours.
Face united(const std::vector<const Face*>& parts) {
  Face whole;
  for (const auto* part : parts) {
    whole.area += part->area, whole.middle += part->area * part->middle;
    whole.complete = whole.complete && part->complete;
    whole.members.insert(whole.members.end(), part->members.begin(), part->members.end());
  }
  if (whole.area > 0) whole.middle /= whole.area;
  for (const auto* part : parts) {
    const Vec3 aside = part->middle - whole.middle;
    if (whole.area > 0) whole.spread += part->area / whole.area * (part->spread + aside * aside.transpose());
  }
  std::sort(whole.members.begin(), whole.members.end());
  return whole;
}

/// Many cones in a row, each bent a little against the next, are the facets of one surface of free form. True if there
/// were any: faces then have to be numbered again.
bool unite_rings(const TriangleMesh& mesh, Faces& result) {
  const auto count = static_cast<std::uint32_t>(result.faces.size());
  std::vector<std::uint8_t> ring(count, 0);
  for (std::uint32_t f = 0; f < count; ++f) ring[f] = has_two_rings(mesh, result.faces[f]);
  DisjointSets sets(count);
  for (std::uint32_t f = 0; f < count; ++f)
    for (const auto& n : result.faces[f].neighbours) {
      const Face &a = result.faces[f], &b = result.faces[n.face];
      if (ring[f] && ring[n.face] && n.angle < bent_little &&
          std::abs(a.surface().axis.dot(b.surface().axis)) > 1 - 1e-4)
        sets.unite(f, n.face);
    }
  std::map<std::uint32_t, std::vector<const Face*>> groups;
  for (std::uint32_t f = 0; f < count; ++f) groups[sets.root(f)].push_back(&result.faces[f]);
  if (std::none_of(groups.begin(), groups.end(), [](const auto& g) { return g.second.size() >= least_rings; }))
    return false;
  std::vector<Face> faces;
  for (const auto& [root, group] : groups)
    if (group.size() >= least_rings)
      faces.push_back(united(group));
    else
      for (const auto* face : group) faces.push_back(*face);
  result.faces = std::move(faces);
  return true;
}

void number_faces(const TriangleMesh& mesh, Faces& result) {
  std::stable_sort(result.faces.begin(), result.faces.end(), [](const Face& a, const Face& b) {
    return a.area != b.area ? a.area > b.area : a.members.front() < b.members.front();
  });
  result.face_of.assign(mesh.triangles.size(), no_face);
  for (std::uint32_t f = 0; f < result.faces.size(); ++f) {
    result.faces[f].neighbours.clear();
    for (const auto t : result.faces[f].members) result.face_of[t] = f;
  }
  find_neighbours(mesh, result);
}

}  // namespace

Faces faces_of_mesh(const TriangleMesh& mesh, const FaceOptions& given, Context& context) {
  FaceOptions options = given;
  const double size = mesh.bounds().diagonal();
  if (!(options.tolerance > 0)) options.tolerance = 5e-4 * size;
  context.report("faces", 0);
  const Facets facets = flat_pieces(mesh, std::max(2e-6 * size, 1e-3 * options.tolerance));
  const MeshPatches patches = mesh_patches(mesh, facets, options);
  context.report("faces", 0.8);
  Faces result;
  result.of_mesh = true, result.noise = patches.corner_error;
  for (const auto& patch : patches.patches)
    if (!patch.crumbs) result.faces.push_back(Description(mesh, facets, patch).face());
  number_faces(mesh, result);
  if (unite_rings(mesh, result)) number_faces(mesh, result);
  context.report("faces", 1);
  return result;
}

}  // namespace partscribe::geometry
