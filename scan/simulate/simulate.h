/// A seeded range scanner: looks at a surface from several sides and delivers what a real one would.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "geometry/images/range_image.h"
#include "geometry/mesh/triangle_mesh.h"
#include "geometry/points/point_cloud.h"
#include "model/model.h"

namespace partscribe::scan {

/// Where a ray meets a surface first.
struct SurfaceHit {
  double distance = 0;  ///< along the unit direction, mm
  Vec3 normal;          ///< unit, outward
};

/// The thing that is scanned.
struct Surface {
  std::function<std::optional<SurfaceHit>(const Vec3& origin, const Vec3& direction)> first_hit;
  Box3 bounds;
};

Surface surface_of(const TriangleMesh& mesh);
/// Sphere tracing on the exact distance; hits are exact to 1e-9 mm.
Surface surface_of(const Model& model);

struct SimulateOptions {
  std::string views = "octahedron";  ///< tetrahedron octahedron cube icosahedron dodecahedron, or a number
  int resolution = 256;              ///< pixels, square images
  double sigma = 0;                  ///< mm, Gaussian along the optical axis, grows with incidence
  double bit_error = 0;              ///< probability that one random bit of a code is flipped
  int bits = 16;                     ///< 12 or 16
  double outliers = 0;               ///< share of pixels replaced by a range anywhere in the volume
  double mixed = 0;                  ///< probability of a mixed pixel at a depth step
  double drop_angle = 1.3613568;     ///< rad; beyond this incidence nothing returns (78 degrees)
  Projection projection = Projection::orthographic;
  double tilt = 0.19;  ///< rad; the view set is turned, so that no view lies on a part axis
  double pose_noise_angle = 0, pose_noise_shift = 0;  ///< rad, mm: disturbance of the stated initial guess only
  std::uint64_t seed = 1;
};

struct SimulatedView {
  RangeImage image;  ///< world_from_view is the true pose
  Pose initial_guess;
  std::size_t returns = 0, bit_errors = 0;
};

struct SimulatedScan {
  std::vector<SimulatedView> views;
  Scan merged;  ///< all returns in the world frame with view, pixel and ray
};

/// Unit directions from the part to the sensors of a named set; nothing for an unknown name.
std::optional<std::vector<Vec3>> viewpoints(const std::string& name);

/// mm that one code of the images of this surface stands for.
double code_step(const Surface& surface, const SimulateOptions& options);

SimulatedScan simulate(const Surface& surface, const SimulateOptions& options, Context& context);

/// The files of a simulated scan: view_NN.png, scan.json, merged.ply; names and bytes.
struct SimulatedFile {
  std::string name, bytes;
};
std::vector<SimulatedFile> files_of(const SimulatedScan& scan, const SimulateOptions& options);

}  // namespace partscribe::scan
