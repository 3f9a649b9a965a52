/// Scanned points with everything that is known of each.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"
#include "geometry/vec.h"

namespace partscribe::geometry {

/// Points in mm in one common frame. Optional columns are empty or as long as `points`.
struct PointCloud {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;           ///< unit, outward where rays or faces tell; may be zero where unknown
  std::vector<Vec3> rays;              ///< unit, from the sensor to the point
  std::vector<float> sigma;            ///< standard deviation along the normal, mm
  std::vector<std::int32_t> view;      ///< index into `views`
  std::vector<std::int32_t> pixel;     ///< row * width + column in that view's image, -1 if none
  std::vector<std::uint8_t> rejected;  ///< 1: a filter says outlier; kept here so that it can be counted

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  Box3 bounds() const;
};

/// One way the data were seen from.
struct View {
  std::string file;
  Pose world_from_view;
  bool has_sensor = false;    ///< true: the sensor stood at world_from_view.translation
  int width = 0, height = 0;  ///< pixels, 0 for unorganised points
};

/// How sure it is where the views of a scan stood.
struct PoseCovariance {
  Vec3 center = Vec3::Zero();  ///< the rotations' centre, in the scan's frame
  /// 6 n x 6 n, view after view: rotation vector (rad), shift (mm), in the scan's axes. Empty: nobody estimated it.
  Eigen::MatrixXd matrix;
};

/// What a reader delivers and every later stage starts from: all files of one part in one frame.
struct Scan {
  PointCloud cloud;                   ///< for a mesh: its vertices
  TriangleMesh mesh;                  ///< empty unless the source is a mesh
  std::vector<View> views;            ///< one per file or image
  PoseCovariance pose_covariance;     ///< of registered views
  double unit_scale = 1;              ///< what the numbers in the files were multiplied with to give mm
  std::vector<std::string> warnings;  ///< one line each, for the user
  std::vector<std::string> sha256;    ///< of each input file, in the order of `files`
  std::vector<std::string> files;     ///< names without folders
};

}  // namespace partscribe::geometry
