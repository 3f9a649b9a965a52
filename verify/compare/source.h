/// The scan as the verifier uses it: kept points in an order of their own, their search tree, their noise.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/context.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/point_cloud.h"
#include "verify/compare/sight.h"

namespace partscribe::verify {

/// Built once per scan and used for every artifact; the Scan must outlive it.
struct ScanSource {
  std::vector<Vec3> points;  ///< kept points by coordinates, so that the file's order changes nothing
  /// of each point, its number among the kept points of the cloud; nowhere: added
  std::vector<std::uint32_t> kept_place;
  std::vector<Vec3> normals;        ///< empty, or as points; unit or zero, of unknown sign
  std::vector<Vec3> rays;           ///< empty, or as points; unit or zero
  std::vector<std::int32_t> sight;  ///< of each point, the map of its view among `sights`, or -1
  std::vector<Vec3> set_aside;      ///< points that a filter rejected
  std::size_t kept = 0;             ///< points of the cloud that were kept
  std::unique_ptr<KdTree> tree;     ///< over points
  double spacing = 0;               ///< mm, median over the cloud of the spacing in the 8-neighbourhood
  double sparsest = 0;              ///< mm, spacing above which points are no surface but outliers: see .cpp
  double noise = 0;                 ///< mm, scatter along the normal inside small neighbourhoods
  bool dense = false;               ///< the nearest points of a point are a ball of noise, not a piece of surface
  double disagreement = 0;          ///< mm, offset of the view that lies farthest from the others, noise taken out
  std::vector<SightMap> sights;
  std::unique_ptr<MeshDistance> surface;  ///< of a scan that is a mesh
  bool closed_surface = false;

  static constexpr std::uint32_t nowhere = ~0u;
};

/// A sensor's line of sight to one scanned point.
struct LineOfSight {
  Vec3 from, ray;     ///< mm; unit
  double length = 0;  ///< mm, to the point
  double pixel = 0;   ///< mm, to the neighbouring line at the point
};

/// Of a point whose sensor is known. Where lines of sight run parallel they begin `reach` mm before it.
std::optional<LineOfSight> line_of_sight(const ScanSource& source, std::size_t point, double reach);

/// Where a surface would have hidden the point by more than `margin` mm, the line moved `aside`; nothing if it would
/// not.
std::optional<MeshHit> hidden_by(const MeshDistance& surface, const LineOfSight& sight, double margin,
                                 const Vec3& aside = Vec3::Zero());

/// Adds even samples where a mesh has too few vertices to stand for its surface.
ScanSource prepare_source(const Scan& scan, Context& context);

/// How many neighbours must be averaged so that noise stays below a quarter of the tolerance: 3.3 sigma / sqrt k <= T /
/// 4, at least 9 and at most most_neighbours().
int neighbours_for(const ScanSource& source, double tolerance);

/// 100, or fewer where the cloud is so small that 100 points are no longer local.
int most_neighbours(const ScanSource& source);

/// Where only one view saw the surface, it may be off by this many times the disagreement of the views (measured: up
/// to 1.3).
inline constexpr double view_reach = 1.5;

/// The tolerance at which neighbours_for() reaches its limit: below it the scan cannot tell a deviation from noise. Nor
/// can it where one of its views may lie farther off than the tolerance.
double smallest_honest_tolerance(const ScanSource& source);

/// The mean spacing of points whose 8th neighbour is at this distance.
double spacing_from_eighth(double distance);

}  // namespace partscribe::verify
