/// Scanned points with links between those that lie side by side on one smooth surface.
///
/// Range images and point clouds become the same graph, so that what is asked of surfaces afterwards is written once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/context.h"
#include "geometry/images/range_image.h"
#include "geometry/images/rlts_filter.h"
#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

/// Nodes keep the index of their pixel (row * width + column) or point; nodes without a usable point have no links.
struct SurfaceGraph {
  std::vector<Vec3> points;   ///< raw samples: the sensor's frame for images, the cloud's for clouds
  std::vector<Vec3> normals;  ///< unit, against the ray or as in the cloud
  std::vector<double> sigma;  ///< mm along the normal
  std::vector<std::uint8_t> usable;
  double spacing = 0;                ///< mm, median length of a link
  std::vector<std::uint32_t> first;  ///< of each node's links; one more than nodes
  std::vector<std::uint32_t> links;

  std::size_t size() const { return points.size(); }
  std::span<const std::uint32_t> around(std::size_t node) const {
    return {links.data() + first[node], links.data() + first[node + 1]};
  }
};

struct SurfaceGraphOptions {
  double max_turn = 0.26;  ///< rad between the normals of linked points, beyond what their noise explains
  double max_climb = 0.5;  ///< of a link out of the plane of its ends, per length; a step is steeper
  int neighbours = 10;     ///< of a point in a cloud
};

/// Four links per pixel, between kept samples.
SurfaceGraph surface_graph(const RangeImage& image, const FilteredImage& filtered, const SurfaceGraphOptions& options);

/// Links to nearest neighbours, both ways. The cloud has normals and sigma (estimate_normals).
SurfaceGraph surface_graph(const PointCloud& cloud, const SurfaceGraphOptions& options, Context& context);

}  // namespace partscribe::geometry
