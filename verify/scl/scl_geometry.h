/// The geometry that an Alpha_1 procedure builds: curves, profiles, B-spline surfaces, shells and their combinations.
///
/// Everything is made by a function that checks its arguments; an Error says what Alpha_1 would have to be told
/// differently. Shells that enclose a volume always face outward.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::verify {

enum class SclGeometryKind { line, arc, circle, curve, profile, surface, primitive, shell, group };
const char* name_of(SclGeometryKind kind);

struct SclGeometry;  ///< defined in the .cpp
using SclGeometryPtr = std::shared_ptr<const SclGeometry>;
using SclMade = Result<SclGeometryPtr>;
using SclStop = std::function<bool()>;  ///< true: give up at once

SclGeometryKind kind_of(const SclGeometry& geometry);
/// A shell or a primitive that encloses a volume.
bool is_solid(const SclGeometry& geometry);
/// The members of a group; empty for anything else.
const std::vector<SclGeometryPtr>& members_of(const SclGeometry& geometry);

/// Linear part and translation.
struct SclTransform {
  Mat3 linear = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  Vec3 operator*(const Vec3& p) const { return linear * p + translation; }
};

// ---- curves and profiles ----------------------------------------------------------------------------------------

SclMade scl_line(const Vec3& a, const Vec3& b);
SclMade scl_arc_through(const Vec3& a, const Vec3& b, const Vec3& c);
/// The shorter way about `center`; half a turn does not tell which way.
SclMade scl_arc_about(const Vec3& a, const Vec3& center, const Vec3& b);
/// Clamped; weights may be empty.
SclMade scl_nurbs_curve(int order, const std::vector<double>& knots, const std::vector<Vec3>& points,
                        const std::vector<double>& weights);
/// The NURBS curve of an arc or circle.
SclMade scl_curve_of(const SclGeometryPtr& arc);

/// A corner of a profile: a point, or a curve when `curve` is set.
struct SclCorner {
  Vec3 point = Vec3::Zero();
  SclGeometryPtr curve;
};
/// Corners joined in order by straight lines where they do not meet.
SclMade scl_profile(const std::vector<SclCorner>& corners);

// ---- B-spline surfaces ------------------------------------------------------------------------------------------

enum class SclEnd { open, floating, periodic };

/// One direction of a tensor product: knots empty means uniform ones; `bezier` asks for a single Bezier span.
struct SclDirection {
  int order = 4;
  SclEnd end = SclEnd::open;
  bool bezier = false;
  std::vector<double> knots;
};
/// `mesh[j][i]`: u runs along a row, that is with i. Uniform and Bezier domains run from 0 to 1 and from 0 to the
/// number of spans. Weights, as `mesh`, or empty: all 1.
SclMade scl_surface(const SclDirection& u, const SclDirection& v, const std::vector<std::vector<Vec3>>& mesh,
                    const std::vector<std::vector<double>>& weights = {});
/// Inserts knots; the surface stays what it is. `row`: the u direction.
SclMade scl_refined(const SclGeometryPtr& surface, bool row, const std::vector<double>& knots);

/// A whole surface within loops of curves in the plane of its parameters (z = 0): what lies to the left of all stays.
SclMade scl_trimmed(const SclGeometryPtr& surface, const std::vector<std::vector<SclGeometryPtr>>& loops);

// ---- solids -----------------------------------------------------------------------------------------------------

/// A block or half a block spanned by three vectors; the wedge's triangle lies between `a` and `b`.
SclMade scl_box(const Vec3& corner, const Vec3& a, const Vec3& b, const Vec3& c);
SclMade scl_wedge(const Vec3& corner, const Vec3& a, const Vec3& b, const Vec3& c);
SclMade scl_cylinder(const Vec3& base, const Vec3& axis, double radius);
SclMade scl_unit_sphere();
/// The shell of a primitive; a shell stays what it is.
SclMade scl_shell_of(const SclGeometryPtr& geometry);
/// Profiles in the plane y = 0 with x >= 0, turned about z by an angle (rad, above 0, a full turn at most): the
/// first is the outline, the others are holes. An open outline is closed straight to the axis.
SclMade scl_revolved(const std::vector<SclGeometryPtr>& profiles, double angle);
/// Closed profiles in the plane z = 0, moved along z: the first is the outline, the others are holes.
SclMade scl_extruded(const std::vector<SclGeometryPtr>& profiles, double height);
/// The same from z = -below to height, with walls that lean inwards by an angle (rad) as z rises; at z = 0 it has the
/// profiles.
SclMade scl_drafted(const std::vector<SclGeometryPtr>& profiles, double below, double height, double draft);
/// What a surface without borders passes as it moves.
SclMade scl_swept(const SclGeometryPtr& surface, const Vec3& direction);
/// Surfaces that meet along their edges, as one shell.
SclMade scl_sewn(const std::vector<SclGeometryPtr>& surfaces);
/// Flat convex facets, counter-clockwise seen from outside; equal corners are one. A solid if they close up.
SclMade scl_facets(const std::vector<std::vector<Vec3>>& facets);
/// All points p with planes[i].head<3>() . p <= planes[i][3].
SclMade scl_half_spaces(const std::vector<std::array<double, 4>>& planes);
enum class SclOperation { unite, subtract, intersect };
SclMade scl_combined(SclOperation operation, const SclGeometryPtr& a, const SclGeometryPtr& b, const SclStop& stop);

SclMade scl_transformed(const SclGeometryPtr& geometry, const SclTransform& transform);
SclMade scl_group(std::vector<SclGeometryPtr> members);

// ---- evaluation -------------------------------------------------------------------------------------------------

struct SclMesh {
  TriangleMesh mesh;
  double error = 0;    ///< mm, largest measured distance between a triangle and its surface
  bool solid = false;  ///< every part is closed and faces outward
};
/// All objects as one welded mesh with deviations of at most about `deviation`.
Result<SclMesh> scl_mesh(const std::vector<SclGeometryPtr>& objects, double deviation, const SclStop& stop);

}  // namespace partscribe::verify
