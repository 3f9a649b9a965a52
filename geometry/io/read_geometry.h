/// Reads the file formats in which points and meshes travel, without interpreting units or poses.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/context.h"
#include "core/files.h"
#include "core/result.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

/// What one file holds, in the file's own units and frame, nothing lost: coordinates are read as double.
struct RawGeometry {
  std::string format;  ///< "PLY", "STL", ...
  PointCloud cloud;    ///< points (a mesh's vertices), normals, view, pixel, sigma, rejected where the file has them
  TriangleMesh mesh;   ///< empty for point files; polygons are cut into triangles
  std::size_t collapsed = 0;          ///< triangles with two equal corners that were left out
  int width = 0, height = 0;          ///< of an organised cloud (PLY range_grid, PCD); cloud.pixel is filled then
  std::string unit;                   ///< the file's own statement ("millimeter" in 3MF), usually empty
  std::vector<std::string> warnings;  ///< one line each
};

/// PLY (ascii, both binaries; points, meshes, tristrips, range_grid), STL (both), OBJ, OFF, 3MF, PCD (ascii, binary,
/// binary_compressed), XYZ ASC PTS TXT CSV, VTK legacy polydata and unstructured grids of flat cells (ascii, binary).
/// The content decides, then the suffix.
/// Errors: one line with file, place (line or byte), what was expected and found.
Result<RawGeometry> read_geometry(const Path& path, Context& context);

/// The same from bytes; `name` is used for messages and its suffix for formats without a signature.
Result<RawGeometry> parse_geometry(std::string_view bytes, const std::string& name);

/// Little-endian binary STL (float32, as the format has it).
std::string write_stl(const TriangleMesh& mesh);

/// Binary PLY with double coordinates and every column that the cloud has; reads back equal.
std::string write_cloud_ply(const PointCloud& cloud);

/// Binary PLY mesh with double coordinates.
std::string write_mesh_ply(const TriangleMesh& mesh);

}  // namespace partscribe::geometry
