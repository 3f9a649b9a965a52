/// The parts a scan is joined from: one piece per file or image, in the numbers of its file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/images/range_image.h"
#include "geometry/points/point_cloud.h"
#include "scan/read/read.h"

namespace partscribe::scan {

/// What one file or image contributes, in the common frame but in the file's own unit.
struct Piece {
  PointCloud cloud;
  TriangleMesh mesh;
  View view;
  RangeImage image;                ///< without pixels if it is none
  std::string unit;                ///< stated by the file or its sidecar; empty if nobody says
  PoseCovariance pose_covariance;  ///< in mm, of a cloud that was registered before
};

/// All pieces of the inputs, with the files they came from.
struct Pieces {
  std::vector<Piece> pieces;
  std::vector<std::string> files, sha256, warnings;
};

/// Reads a file and notes its name and sum.
Result<std::string> read_source(const Path& path, Pieces& pieces);

/// A point or mesh file at `pose`. `sensor_at_origin`: the numbers are in a pinhole sensor's own frame.
std::optional<Error> add_geometry(const Path& path, const Pose& pose, bool sensor_at_origin, const std::string& unit,
                                  Context& context, Pieces& pieces);

/// The points of a range image in the world frame, with ray and pixel of each.
PointCloud cloud_of(const RangeImage& image);

/// The file of a simulated view: view_00.png.
std::string view_file_name(std::size_t view);

/// A range image whose numbers are all known; one without any return is only a warning.
void add_range_image(const RangeImage& image, const std::string& file, const std::string& unit, Pieces& pieces);

/// A scan.json with everything it names.
std::optional<Error> add_scan_json(const Path& path, const ReadOptions& options, Context& context, Pieces& pieces);

/// A PNG or PGM with its .json sidecar.
std::optional<Error> add_image_with_sidecar(const Path& path, const ReadOptions& options, Pieces& pieces);

/// The covariance of the views that poses.json beside a cloud holds, if it speaks of this cloud: for the last piece.
/// One that cannot be used is only a warning.
void add_pose_covariance(const Path& cloud, Pieces& pieces);

/// A Stanford .conf with the meshes it names.
std::optional<Error> add_conf(const Path& path, Context& context, Pieces& pieces);

}  // namespace partscribe::scan
