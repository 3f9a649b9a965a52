/// What `measure` learns of a part: its faces, what a machinist calls them, how they relate, and what is left over.
#pragma once

#include <string>
#include <vector>

#include "core/context.h"
#include "core/result.h"
#include "fit/relations/relations.h"
#include "geometry/points/point_cloud.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/simple_features.h"

namespace partscribe::cli {

/// A connected piece of the surface that belongs to no face.
struct UnclassifiedPlace {
  double area = 0;  ///< mm^2
  Vec3 place = Vec3::Zero();
  std::string reason;
  bool small = false;  ///< too small or narrow for more to be said of it
};

struct MeasuredPart {
  double tolerance = 0;  ///< mm
  Faces faces;
  std::vector<Vec2> plane_sizes;  ///< by face, mm: length and width of a plane face, the longer first; else 0
  std::vector<SimpleFeature> features;
  std::vector<FaceRelation> relations;
  std::vector<UnclassifiedPlace> unclassified;  ///< larger ones first
};

/// Faces with all that follows from them. A cloud has normals, sigma and flags (estimate_normals).
Result<MeasuredPart> measured_part(const Scan& scan, double tolerance, Context& context);

/// mm^2, of all faces and of what belongs to none.
double total_area(const MeasuredPart& part);

/// The number of a face in tables, files and pictures: larger faces have smaller ones, from 1.
std::size_t face_number(std::size_t face);

/// "plane 1", "free form 12".
std::string face_name(const Faces& faces, std::size_t face);

/// "plane 1" and "planes 1, 2; cylinder 7": faces by kind, in the order of their numbers. Of more than `most` of a kind
/// the first: "planes 1, 2 and 5 more".
std::string face_list(const Faces& faces, const std::vector<std::uint32_t>& members, std::size_t most = 10);

/// The mean place of its faces: of a hole on its axis, of a bolt circle in its middle.
Vec3 place_of(const Faces& faces, const SimpleFeature& feature);

/// Where a face is: of round ones on the axis or in the centre, else its mean place.
Vec3 place_of(const Face& face);

/// The sides of the smallest rectangle around a plane face, by face; zero for other kinds.
std::vector<Vec2> sizes_of_planes(const Scan& scan, const Faces& faces);

/// mm^2 that one point of a cloud stands for, as on its faces.
double area_per_point(const Scan& scan, const Faces& faces);

/// Triangles or points without a face, by connected pieces; points that a filter rejected are none.
std::vector<UnclassifiedPlace> unclassified_places(const Scan& scan, const Faces& faces, double tolerance);

}  // namespace partscribe::cli
