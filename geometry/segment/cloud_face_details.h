/// What is said of a face once its points are known: its fit, its extent, its area, its neighbours.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/segment/face_samples.h"
#include "geometry/segment/faces.h"

namespace partscribe::geometry {

/// A cloud whose points have been given to faces.
struct LabelledCloud {
  const PointCloud& cloud;
  const std::vector<std::uint8_t>& inner;  ///< of each point: all samples around it belong to one face
  double least_sigma = 0, pitch = 0;       ///< mm
};

/// The face of these points (ascending), fitted from `start`; without area and neighbours.
Face described(const LabelledCloud& labelled, const Primitive& start, std::vector<std::uint32_t> members);

/// Areas of the faces, and with them their coverage. `label`: the face of each sample.
void measure_areas(const FaceSamples& samples, const std::vector<std::uint32_t>& label, std::vector<Face>& faces);

/// The neighbours of all faces. `label`: the face of each sample.
void find_neighbours(const FaceSamples& samples, const std::vector<std::uint32_t>& label, Faces& faces);

}  // namespace partscribe::geometry
