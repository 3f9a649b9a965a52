/// Samples given to the faces that explain them best, beside what their neighbours belong to.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/segment/grow_faces.h"

namespace partscribe::geometry {

/// Takes turns in giving samples to faces and fitting faces again; faces that lose nearly all are dropped. Returns the
/// face of each sample, no_face where none explains it.
std::vector<std::uint32_t> label_samples(const FaceSamples& samples, std::vector<GrownFace>& faces);

/// Drops faces of fewer than `least` samples; labels follow.
void drop_faces(std::vector<GrownFace>& faces, std::vector<std::uint32_t>& label, std::size_t least);

/// What it costs to give a sample with this residual (sigmas) and angle (rad) to a face.
double label_cost(double residual, double turn);
inline constexpr double outlier_cost = 6;  ///< of a sample that belongs to none

}  // namespace partscribe::geometry
