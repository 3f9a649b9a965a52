#include "fit/surface/triangulate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "fit/surface/faced_mesh.h"
#include "fit/surface/height_field.h"
#include "fit/surface/reconstruct.h"
#include "geometry/mesh/decimate.h"
#include "geometry/mesh/mesh_repair.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/normals/orient_normals.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"

namespace partscribe::fit {
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

/// The points of `cloud` with normals on the side that those of nearby `oriented` points say.
PointCloud turned_like(const PointCloud& oriented, const PointCloud& cloud, Context& context) {
  PointCloud result;
  result.points = cloud.points;
  result.normals = cloud.normals;
  result.rejected = cloud.rejected;
  const KdTree tree(oriented.points);
  parallel_for(result.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (!result.points[i].allFinite()) continue;
      tree.nearest(result.points[i], 4, near);
      double vote = 0;
      for (const Neighbour& n : near) {
        const double along = oriented.normals[n.index].dot(result.normals[i]);
        vote += along * std::abs(along) / (n.sq_distance + 1e-12);
      }
      if (vote < 0) result.normals[i] = -result.normals[i];
    }
  });
  return result;
}

/// Are the points one point, or on one line?
bool spans_a_line(const std::vector<Vec3>& points) {
  if (points.size() < 3) return true;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Mat3 cov = Mat3::Zero();
  for (const Vec3& p : points) cov += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cov);
  return !(eigen.eigenvalues()[1] > 1e-8 * eigen.eigenvalues()[2]);
}

/// Decimated as far as the bound allows; where the result would pass through itself the source stays as it is.
TriangleMesh simplified(const TriangleMesh& mesh, double max_error, Context& context) {
  DecimateOptions options;
  options.max_error = max_error;
  TriangleMesh small = decimated(mesh, options, context);
  for (int round = 0; round < 4; ++round) {
    const auto pairs = self_intersections(small);
    if (pairs.empty()) return small;
    // The source crosses itself already: nothing is gained by keeping it.
    if (round == 0 && !self_intersections(mesh, 1).empty()) return small;
    options.frozen.resize(mesh.vertices.size(), 0);
    for (const auto& [a, b] : pairs) {
      Box3 box_a, box_b;
      for (int k = 0; k < 3; ++k) box_a.add(small.corner(a, k)), box_b.add(small.corner(b, k));
      const Vec3 margin = Vec3::Constant((3 + round) * max_error);
      const Vec3 low = box_a.low.cwiseMax(box_b.low) - margin, high = box_a.high.cwiseMin(box_b.high) + margin;
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if ((mesh.vertices[v].array() >= low.array()).all() && (mesh.vertices[v].array() <= high.array()).all())
          options.frozen[v] = 1;
    }
    small = decimated(mesh, options, context);
  }
  return small;
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

Candidate candidate_of(const TriangleMesh& mesh, double tolerance) {
  const bool closed = topology(mesh).closed();
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
    candidate.parameters.push_back(sheet_thickness(tolerance));
    surface.thickness = Expr::of(candidate.parameters.back().name);
  }
  candidate.extra_numbers = static_cast<int>(3 * surface.vertices.size() + 3 * surface.triangles.size());
  candidate.shape = std::move(surface);
  return candidate;
}

/// A body of faces: its numbers are those of their surfaces.
Candidate candidate_of(FacedMesh faced) {
  Candidate candidate = candidate_of(faced.mesh, 0);
  auto& surface = std::get<TriSurface>(candidate.shape);
  candidate.extra_numbers = 0;
  for (const auto& face : faced.faces)
    candidate.extra_numbers += face.surface.empty() ? 3 * face.triangles : 3 + static_cast<int>(face.sizes.size());
  surface.faces = std::move(faced.faces);
  return candidate;
}

}  // namespace

Parameter sheet_thickness(double tolerance) {
  Parameter thickness;
  thickness.name = "sheet_thickness";
  thickness.value = thickness.fitted = std::max(2.0, std::ceil(3 * tolerance));
  thickness.note = "thickness of the solid made from the open sheet; chosen, not measured";
  return thickness;
}

TriangleMesh Triangulator::repaired(double tolerance) const {
  RepairOptions options;
  options.separation = 0.1 * tolerance;
  RepairReport report = repair(ordered_source(input_.scan->mesh), options);
  if (report.dropped_components > 0)
    context_.say("triangulate: " + std::to_string(report.dropped_components) +
                 " small floating pieces of the mesh left out");
  if (report.filled_holes > 0)
    context_.say("triangulate: " + std::to_string(report.filled_holes) + " holes of the mesh filled");
  return std::move(report.mesh);
}

TriangleMesh Triangulator::from_points(double tolerance) {
  if (!surface_) {
    // All points if they are prepared, because averaging many lowers the noise; else the thinned ones.
    const bool full = input_.scan && input_.scan->cloud.normals.size() == input_.scan->cloud.size();
    const PointCloud& all = full ? input_.scan->cloud : input_.cloud;
    SamplingSummary sampling = input_.sampling;
    if (!full) sampling.spacing = std::max(sampling.spacing, 0.6 * input_.thin_spacing);
    HeightFieldOptions one_side;
    one_side.max_error = 0.6 * tolerance;
    one_side.oriented = input_.oriented;
    const auto views = input_.scan ? input_.scan->views : std::vector<View>();
    if (auto field = triangulated_height_field(all, views, sampling, one_side, context_)) return std::move(field->mesh);
    if (input_.oriented) {
      surface_ = reconstruct(all, sampling, {}, context_).mesh;
    } else {
      PointCloud turned = input_.cloud;
      orient_normals(turned, 12, context_);
      if (full) turned = turned_like(turned, all, context_);
      surface_ = reconstruct(turned, sampling, {}, context_).mesh;
    }
  }
  return simplified(*surface_, 0.4 * tolerance, context_);
}

const TriangleMesh& Triangulator::surface(double tolerance) {
  if (!last_ || last_->first != tolerance) {
    const bool of_mesh = input_.scan && !input_.scan->mesh.empty();
    last_.emplace(tolerance, of_mesh ? repaired(tolerance) : from_points(tolerance));
  }
  return last_->second;
}

Result<Candidate> Triangulator::within(double tolerance) {
  const Error no_surface = bad_input("triangulate: expected points that lie on a surface, found " +
                                     std::to_string(input_.cloud.size()) + " points that span none");
  if (spans_a_line(input_.cloud.points)) return no_surface;
  const bool of_mesh = input_.scan && !input_.scan->mesh.empty();
  const double max_error = 0.4 * tolerance;
  const TriangleMesh& whole = surface(tolerance);
  if (const auto& faced = of_faces(tolerance)) return *faced;
  const TriangleMesh mesh = of_mesh ? simplified(whole, max_error, context_) : whole;
  if (mesh.empty()) return no_surface;
  return candidate_of(canonical(snapped_mesh(mesh, power_of_ten_below(tolerance / 20))), tolerance);
}

const std::optional<Candidate>& Triangulator::of_faces(double tolerance) {
  if (faced_ && faced_->first == tolerance) return faced_->second;
  faced_.emplace(tolerance, std::nullopt);
  if (!input_.scan || input_.scan->mesh.empty()) return faced_->second;
  const double as_faces = 0.15 * tolerance;  // files that hold the faces and files that hold triangles are to agree
  const TriangleMesh fine = canonical(snapped_mesh(surface(tolerance), power_of_ten_below(tolerance / 2000)));
  if (auto faced = faced_mesh(fine, tolerance, as_faces, context_)) faced_->second = candidate_of(std::move(*faced));
  return faced_->second;
}

std::optional<TriangleMesh> Triangulator::surface_of_data(double tolerance) {
  if (spans_a_line(input_.cloud.points)) return std::nullopt;
  const TriangleMesh& mesh = surface(tolerance);
  if (mesh.empty()) return std::nullopt;
  return surface_ && topology(*surface_).closed() ? *surface_ : mesh;
}

std::optional<Candidate> Triangulator::unsimplified() const {
  if (!surface_ || surface_->empty()) return std::nullopt;
  return candidate_of(*surface_, input_.tolerance);
}

}  // namespace partscribe::fit
