/// Reads scans: one or several files in any supported form become one Scan in one frame, in millimetres.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/images/range_image.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::scan {

/// Millimetres per unit.
struct Unit {
  std::string name;  ///< "mm", "cm", "m", "inch", "foot", "um"
  double millimetres = 1;
};

/// Knows common spellings: "mm", "millimeter", "in", "inch", ...; capitals do not matter.
std::optional<Unit> parse_unit(const std::string& name);

struct ReadOptions {
  std::optional<Unit> unit;    ///< none: what the file or its sidecar says, else mm with a plausibility warning
  bool initial_guess = false;  ///< of a scan.json take the poses "initial_guess" where there are any: for registration
};

/// Inputs: files of read_geometry's formats; a scan.json (range images or clouds with poses) or a folder holding
/// one; a 16-bit PNG or PGM range image or a numpy depth image with a .json sidecar; a Stanford .conf. Several files
/// are several views in one common frame, kept in their order. Fails on the first file that cannot be used.
///
/// scan.json: "unit"; "views", each with "png" (or "pgm", "npy", "ply", "file") and "camera_to_world" (or
/// "world_from_view"), 4 x 4, row by row. Images need either "K" (3 x 3) or "fx fy cx cy", or "x0 y0 pitch_x pitch_y"
/// (orthographic), and (but for depths of numpy) "z0" and "q" as in RangeImage (or "scale" and "offset": z = offset +
/// scale * code), "invalid_code" (0 unless given); for all views or per view. Height maps state "images" with
/// "pixel_size" and "origin" instead: heights grow towards the sensor. A sidecar (part.json beside part.png) states the
/// same fields of its one image.
///
/// Range images give every point its ray, view and pixel. Points of files without a known sensor have no rays.
///
/// Meshes: equal vertices are united, unused ones dropped, and the cloud holds the vertices with their normals.
/// Where more than a fifth of the surface lies in triangles longer than 1/50 of the bounding diagonal (CAD, not a
/// scan), vertices alone do not stand for the surface: samples follow them, spread evenly over the triangles with an
/// edge above 1/125 of the diagonal, one per (diagonal/250)^2, with their triangle's normal; same mesh, same samples.
///
/// `images`, if asked for: the range image of every view, in mm; without pixels for a view that is none.
Result<Scan> read_scan(const std::vector<Path>& inputs, const ReadOptions& options, Context& context,
                       std::vector<RangeImage>* images = nullptr);

/// The surface samples of the rule above; none for a mesh that is dense already.
struct SurfaceSamples {
  std::vector<Vec3> points, normals;
};
SurfaceSamples sample_coarse_mesh(const TriangleMesh& mesh);

}  // namespace partscribe::scan
