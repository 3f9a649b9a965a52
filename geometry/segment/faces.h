/// The faces of a part: pieces of its surface that one plane, cylinder, cone, sphere or torus describes, and a rest.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/context.h"
#include "geometry/points/point_cloud.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::geometry {

enum class FaceKind { plane, cylinder, cone, sphere, torus, free_form };
const char* name_of(FaceKind kind);  ///< "plane", ..., "free_form"

FaceKind face_kind(PrimitiveKind kind);  ///< of a plane, cylinder, cone, sphere or torus

/// Cylinder, cone, sphere or torus.
inline bool is_round(FaceKind kind) { return kind != FaceKind::plane && kind != FaceKind::free_form; }
/// Has a normal or an axis.
inline bool has_direction(FaceKind kind) { return kind != FaceKind::sphere && kind != FaceKind::free_form; }

/// How two faces meet: at an edge that stands out or runs in, or smoothly.
enum class EdgeKind { convex, concave, tangent };
const char* name_of(EdgeKind kind);  ///< "convex", ...

/// Another face that this one meets.
struct FaceNeighbour {
  std::uint32_t face = 0;
  EdgeKind edge = EdgeKind::convex;
  double angle = 0;   ///< rad between the normals, mean along the edge
  double length = 0;  ///< mm of common edge
};

struct Face {
  FaceKind kind = FaceKind::free_form;
  /// The surface with its uncertainty; nothing of it holds for free form. The normal of a plane points out of the
  /// material. `point` of a cylinder or cone is the place on its axis half way between the ends of the face.
  PrimitiveFit fit;
  bool hollow = false;         ///< of round kinds: the material is outside of the surface, as around a hole
  double area = 0;             ///< mm^2
  std::size_t points = 0;      ///< that the fit rests on
  double low = 0, high = 0;    ///< mm along the axis from `point`; of planes and spheres 0
  double arc = 0;              ///< rad about the axis that is covered; of planes and free form 0
  double coverage = 1;         ///< share of the full turn between its ends that is there; of planes and free form 1
  double sagitta = 0;          ///< mm that flat facets of a mesh lie inside the round surface
  Vec3 middle = Vec3::Zero();  ///< mean place of the face, on or near it
  Mat3 spread = Mat3::Zero();  ///< mm^2, mean square distances of its area from `middle`; zero: not known
  bool complete = true;        ///< false: the face runs out where nothing was scanned
  std::vector<std::uint32_t> members;     ///< triangles of the mesh or points of the cloud, ascending
  std::vector<FaceNeighbour> neighbours;  ///< by face

  const Primitive& surface() const { return fit.primitive; }
};

inline constexpr std::uint32_t no_face = ~0u;

/// All faces of one mesh or cloud.
struct Faces {
  std::vector<Face> faces;             ///< larger ones first
  std::vector<std::uint32_t> face_of;  ///< of each triangle or point; no_face: too small or too rough to say
  double noise = 0;                    ///< mm along the normals, of a cloud; of a mesh how far its corners are off
  bool of_mesh = false;                ///< members are triangles, and flat facets stand for round surfaces
};

/// Told a cylinder that stands between `low` and `high` along its axis: is the part round there?
using IsRound = std::function<bool(const Primitive& cylinder, double low, double high)>;

struct FaceOptions {
  double tolerance = 0;    ///< mm: what is smaller than a few of it is no face; 0: from size and noise
  double least_noise = 0;  ///< mm, of clouds: what lies this close to a surface is on it, however exact the points are
  std::size_t samples = 40000;  ///< of clouds: faces are sought on so many points, small ones among what is left
  /// Of meshes. Facets of a polygon are one round surface if at least eight would close the circle; four to seven equal
  /// walls are a square to a heptagon unless this knows better.
  IsRound is_round;
  /// Of meshes: pieces of one cylinder or sphere that overlap along the axis, as a slot divides them, are one face.
  bool join_pieces = false;
};

/// Of a mesh whose corners lie on the surfaces, as CAD programs write it. Corners must be shared (welded).
Faces faces_of_mesh(const TriangleMesh& mesh, const FaceOptions& options, Context& context);

/// Of scanned points with normals, sigma and flags (estimate_normals).
Faces faces_of_cloud(const PointCloud& cloud, const FaceOptions& options, Context& context);

/// Whether more than half of a mesh's area lies on faces of a closed form.
bool mostly_known(const Faces& faces, const TriangleMesh& mesh);

/// Whether a mesh was drawn and not scanned: it is mostly known by its corners.
bool is_drawn(const TriangleMesh& mesh);

/// Of a mesh as of a mesh if its corners lie on surfaces, else of its points; of a cloud as of a cloud.
Faces faces_of(const Scan& scan, const FaceOptions& options, Context& context);

/// Moves `point` of a face with an axis half way between `low` and `high`, mm along the axis from where it is now.
void place_half_way(Face& face, double low, double high);

/// mm^2 of all faces together.
double area_of(const Faces& faces);

/// Unit normal of a face of closed form near `point`, out of the material.
Vec3 outward_normal(const Face& face, const Vec3& point);

/// Unit normal of a primitive's surface near `point`, on the side where distance() is positive.
Vec3 surface_normal(const Primitive& primitive, const Vec3& point);

}  // namespace partscribe::geometry
