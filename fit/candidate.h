/// What every procedure works on, and the form in which it proposes a description of the part.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/context.h"
#include "geometry/normals/normals.h"
#include "geometry/points/point_cloud.h"
#include "model/model.h"

namespace partscribe::fit {

/// Of every point of a cloud those that show the same place of the surface, nearest first. The same for all candidates.
struct Surroundings {
  std::vector<std::size_t> first;  ///< into `index`, one more than there are points
  std::vector<std::uint32_t> index;
};

/// A scan prepared for fitting.
struct FitInput {
  PointCloud cloud;          ///< kept points only, thinned to at most some 60,000, evenly, with normals (sign may be
                             ///< unknown) and sigma; order never depends on the order in the file
  SamplingSummary sampling;  ///< of the full cloud
  double precision = 0;      ///< mm: the last place of the coordinates as they stand in the file
  double thin_spacing = 0;   ///< mm between neighbouring points of `cloud`
  double tolerance = 0.1;    ///< mm
  Box3 bounds;
  const Scan* scan = nullptr;  ///< the whole thing, for procedures that need the mesh or all points
  std::vector<float>
      surface_share;       ///< of a point's neighbours, how many lie on one plane with it; empty: no strays about
  double stray_share = 0;  ///< of the points that were set aside as strays
  double strays_left = 0;  ///< of the points that are strays and still among `cloud`, as far as another search knows
  PointCloud set_aside;    ///< these strays, with all that is known of them
  std::vector<float>
      facet_depth;  ///< mm: how far a point's facet may lie below the true surface; empty: no coarse mesh
  std::shared_ptr<const Surroundings> surroundings;  ///< of `cloud` (surroundings_of); found anew where it is missing
  bool oriented = false;                             ///< normals point outward (rays or a mesh told so)
  bool closed = false;                               ///< a mesh that bounds a solid: nothing of its surface is unseen
};

constexpr double many_strays = 0.1;  ///< share of the points: some are left then, and any shape explains some
inline bool among_strays(const FitInput& input) { return input.stray_share > many_strays; }

/// A length that only the end of the data fixes: no residual speaks about it but those of strays.
struct HeldParameter {
  std::string name;
  double sigma = 0;  ///< mm
};

/// A proposal: one shape with named parameters, standing somewhere in the scan. Values are starts; refine() makes
/// them exact.
struct Candidate {
  std::string procedure;    ///< "sphere", "surface of revolution", ... as users read it
  std::string object_name;  ///< "pin_body"
  Shape shape;
  std::vector<Parameter> parameters;  ///< all that `shape` names
  Pose scan_from_part;
  int extra_numbers = 0;            ///< numbers that are no parameters (control points, triangles)
  std::vector<HeldParameter> held;  ///< what a fit must not move
  std::shared_ptr<const Candidate>
      otherwise;       ///< what may do where this one leaves the data: longer, to the last of them
  std::string unseen;  ///< what makes the shape what it is and was hardly seen: a rival then, never the model
};

}  // namespace partscribe::fit
