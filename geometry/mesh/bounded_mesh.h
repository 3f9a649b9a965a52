/// A mesh that is changed a few triangles at a time and stays within a bound of what it was.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/context.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/surface_walk.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::geometry {

/// Triangles that take the place of others.
struct MeshEdit {
  using Corners = std::array<Vec3, 3>;
  struct Added {
    std::uint32_t triangle = 0;  ///< whose number it takes, one of those removed
    std::array<std::uint32_t, 3> vertices{};
    Corners corners;             ///< mm
    Vec3 normal = Vec3::Zero();  ///< unit
    Corners inward;              ///< in its plane, square to the edge that begins at each corner
  };
  std::vector<std::uint32_t> removed;
  std::vector<Added> added;
  std::uint32_t moved = ~0u;  ///< the vertex that comes to lie at `place`
  Vec3 place = Vec3::Zero();

  void clear() { removed.clear(), added.clear(), moved = ~0u; }
};

/// The sum of weighted squared distances from planes, x^T a x + 2 b.x + c [Garland & Heckbert 1997].
struct Quadric {
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double c = 0;
  void add_plane(const Vec3& normal, const Vec3& point, double weight) {
    const double d = -normal.dot(point);
    a += weight * normal * normal.transpose();
    b += weight * d * normal;
    c += weight * d * d;
  }
  void add(const Quadric& other, double weight) { a += weight * other.a, b += weight * other.b, c += weight * other.c; }
  double at(const Vec3& x) const { return std::max(0.0, x.dot(a * x) + 2 * b.dot(x) + c); }
};

/// Samples of the original surface (its corners, and more where it bends much from one triangle to the next) each
/// belong to a triangle of the mesh that is within the bound of it; triangles are probed at places about as close to
/// each other as the original's corners.
class BoundedMesh {
 public:
  using Triangle = std::array<std::uint32_t, 3>;

  /// `mesh` is manifold and outlives it. `bound`: mm, of both directions.
  BoundedMesh(const TriangleMesh& mesh, double bound, Context& context);

  std::size_t vertices() const { return points_.size(); }
  std::size_t triangles_left() const { return left_; }
  const Vec3& point(std::uint32_t v) const { return points_[v]; }
  const Triangle& triangle(std::uint32_t t) const { return triangles_[t]; }
  MeshEdit::Corners corners(std::uint32_t t) const;
  const std::vector<std::uint32_t>& fan(std::uint32_t v) const { return fans_[v]; }  ///< its triangles, ascending
  bool on_border(std::uint32_t v) const { return border_[v]; }
  std::size_t edge_triangles(std::uint32_t a, std::uint32_t b) const;
  void neighbours(std::uint32_t v, std::vector<std::uint32_t>& list) const;  ///< ascending

  /// Puts a triangle into an edit; false where it has no area, becomes more of a needle than the one whose number it
  /// takes, or turns over against that one.
  bool add(MeshEdit& edit, std::uint32_t t, const Triangle& vertices) const;
  /// The same for triangles that lie across those that they replace: `before` is twice the area vector of these, mm^2,
  /// and no needle is allowed.
  bool add_across(MeshEdit& edit, std::uint32_t t, const Triangle& vertices, const Vec3& before) const;

  /// How far samples of some triangles are off: the sum of the fourth powers of distance / bound.
  double unrest(const std::vector<std::uint32_t>& triangles) const;

  /// Would everything stay within the bound, no triangles cross, and the unrest of the samples concerned be less than
  /// `most_unrest`?
  bool allows(const MeshEdit& edit, double most_unrest = std::numeric_limits<double>::infinity());
  /// Does what was last allowed.
  void make(const MeshEdit& edit);

  /// For each vertex the planes of the original triangles around it, and walls on original borders, by area: each
  /// sample deals those of its place out to the corners of its triangle. Places are relative to origin().
  std::vector<Quadric> quadrics() const;
  const Vec3& origin() const { return origin_; }

  /// Where the moved vertex of an edit should rather lie for the sake of the samples concerned: one step of Gauss and
  /// Newton for the fourth powers of their distances.
  Vec3 better_place(const MeshEdit& edit) const;

  TriangleMesh result() const;

 private:
  bool add(MeshEdit& edit, std::uint32_t t, const Triangle& vertices, const Vec3& before, double shape_before) const;
  void add_sample(std::uint32_t t, const Vec3& p);
  void sample_borders();
  void find_narrow_places(const std::vector<std::uint32_t>& sampled, Context& context);
  bool strays(const MeshEdit& edit, double bound);
  bool covered(const MeshEdit::Corners& corners, double bound, double pitch, bool refine) const;
  bool crosses(const MeshEdit& edit);

  const TriangleMesh& mesh_;
  MeshDistance original_;
  SurfaceWalk walk_;
  double bound_;
  Vec3 origin_;
  double edge_ = 1;  // mm, the original's mean
  std::size_t left_ = 0;
  std::vector<Vec3> points_;
  std::vector<Vec3> samples_;    // first one for each corner, then others
  std::vector<Quadric> planes_;  // of the first samples
  std::vector<Triangle> triangles_;
  std::vector<SurfacePlace> feet_;  // of each vertex: near the nearest place of the original
  SurfacePlace foot_;               // of the vertex that allows() was asked to move
  std::vector<std::uint8_t> border_;
  std::vector<std::uint8_t> on_border_;      // of the first samples
  std::vector<std::uint8_t> beside_border_;  // of the original's triangles
  std::vector<std::vector<std::uint32_t>> fans_, samples_of_;
  std::vector<std::vector<std::uint32_t>> across_;  // of the first samples: others that surfaces could meet at
  std::vector<std::uint32_t> owners_;  // the triangle that each of the first samples, those at vertices, belongs to
  std::vector<double> unrest_;         // of each triangle
  std::vector<std::uint32_t> seen_;    // of each triangle: when it was last put into nearby_ or removed
  std::uint32_t look_ = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> moved_;  // what allows() found: sample, which of `added`
  std::vector<double> unrest_of_added_;
  std::vector<std::uint8_t> over_border_;
  std::vector<std::uint32_t> nearby_;
};

/// Barycentric coordinates of the place in a triangle that is nearest to p; zeros where it has no area.
Vec3 barycentric(const MeshEdit::Corners& corners, const Vec3& p);

/// The nearest point of a triangle.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace partscribe::geometry
