/// Normals, curvatures and their signs at scanned points.
///
/// Heights are measured along the normal, so that a surface that bulges towards the normal has negative mean curvature.
/// A sign counts only beyond three of its own standard deviations.
#pragma once

#include <cstdint>
#include <vector>

#include "core/context.h"
#include "geometry/normals/surface_graph.h"

namespace partscribe::geometry {

/// By the signs of mean and Gaussian curvature (Besl & Jain 1988).
enum class SurfaceClass : std::uint8_t {
  unknown,  ///< too few neighbours on the same surface
  flat,
  peak,
  pit,
  ridge,
  valley,
  saddle_ridge,
  saddle_valley,
  minimal
};

struct CharacterizedPoint {
  Vec3 normal = Vec3::Zero();               ///< unit
  double least = 0, most = 0;               ///< principal curvatures, 1/mm, least <= most
  Vec3 along_least = Vec3::Zero();          ///< unit, direction of the least
  double mean = 0, sigma_mean = 0;          ///< 1/mm
  double gaussian = 0, sigma_gaussian = 0;  ///< 1/mm^2
  int neighbours = 0;                       ///< that the quadric was fitted to
  SurfaceClass kind = SurfaceClass::unknown;
};

struct CharacterizeOptions {
  double radius = 0;  ///< mm of a neighbourhood; larger sees less curvature and blurs more; 0: 5.5 spacings
  int least_neighbours = 15;
};

/// One per node. Neighbourhoods are reached by links only, so they end at steps and creases.
std::vector<CharacterizedPoint> characterize(const SurfaceGraph& graph, const CharacterizeOptions& options,
                                             Context& context);

SurfaceClass class_of_signs(int mean, int gaussian);

}  // namespace partscribe::geometry
