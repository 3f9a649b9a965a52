/// Seeded hard scans of known parts: what a recovery is measured on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/points/point_cloud.h"
#include "model/model.h"

namespace partscribe::testing::recovery {

using namespace model;

/// What the scanner and the place did to the data.
struct Conditions {
  double least_noise = 0.001, most_noise = 0.01;      ///< sigma along the ray, share of the part's longest side
  double least_outliers = 0.02, most_outliers = 0.1;  ///< share of all points
  double seen = 2.0 / 3;                              ///< share of the surface; from one side, the rest is in shadow
  double density_ratio = 10;                          ///< densest to sparsest place
  std::size_t points = 4000;
  int least_facets = 0, most_facets = 0;  ///< around; above 0: a coarse mesh without noise, half of them whole
};

/// "standard": up to 10 % outliers, one third unseen. "hardest": 30 %, two thirds, noise 1 %. "facets": the mesh of a
/// printed part, 20 to 50 facets around, of every second one a third of the surface is missing. "clean": standard
/// without outliers.
Conditions standard_conditions();
Conditions clean_conditions();
Conditions hardest_conditions();
Conditions facet_conditions();

/// One scan of which everything is known.
struct Case {
  std::string kind;  ///< of a degenerate one what it truly is, "cone"
  Model truth;       ///< in its own frame; parameters in the order of canonical_numbers()
  Pose scan_from_part;
  Scan scan;
  double size = 0;                ///< mm, longest side of the part's own box
  double noise = 0;               ///< mm; of a mesh the depth of its facets
  double outliers = 0, seen = 0;  ///< shares that came out
  double tolerance = 0;           ///< mm, to be asked for
  double close = 0;               ///< mm; a surface of which 95 % lie within this is right
  std::vector<Vec3> exact;        ///< the places that were hit, without noise, in the scan's frame; no outliers
  std::vector<double> sigma;      ///< mm, of each along the surface normal
  std::vector<Vec3> measured;     ///< where each was measured, in the scan's frame; of a mesh empty
};

/// The kinds that are drawn: "sphere", "ellipsoid", "superellipsoid", "box", "wedge", "cylinder", "cone", "torus",
/// "supertoroid", "fillet", "half_spaces", "revolve", "extrude".
const std::vector<std::string>& kinds();

/// Parts that are nearly of a simpler kind, or of which so little was seen: see degenerate_part().
const std::vector<std::string>& degenerate_kinds();

/// The same case for the same arguments always.
Case make_case(const std::string& kind, const Conditions& conditions, std::uint64_t seed);

}  // namespace partscribe::testing::recovery
