/// Even samples of a cloud with links between neighbours: what faces of clouds are found on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/points/point_cloud.h"

namespace partscribe::geometry {

struct FaceSamples {
  std::vector<Vec3> points, normals;  ///< normals unit, out of the material
  std::vector<double> sigma;          ///< mm along the normal, never zero
  std::vector<std::uint32_t> source;  ///< index of each sample in the cloud
  double pitch = 0;                   ///< mm between neighbours
  double area = 0;                    ///< mm^2 that a sample stands for
  std::vector<std::uint32_t> first;   ///< of each sample's links, nearest first; one more than samples
  std::vector<std::uint32_t> links;

  std::size_t size() const { return points.size(); }
  std::span<const std::uint32_t> around(std::uint32_t sample) const {
    return {links.data() + first[sample], links.data() + first[sample + 1]};
  }
};

/// From points with `left_out` 0, spread evenly: one for every cube of edge `spacing` (mm), or of more where the noise
/// is as thick. `least_sigma`: mm, a floor of the noise.
FaceSamples face_samples(const PointCloud& cloud, const std::vector<std::uint8_t>& left_out, double least_sigma,
                         double spacing, int threads);

}  // namespace partscribe::geometry
