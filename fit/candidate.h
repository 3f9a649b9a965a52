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

/// For every point of a cloud, the neighbours that lie on the same piece of surface, nearest first. The same for all
/// candidates.
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
  /// share of a point's neighbours that lie on one plane with it; empty: there are no outliers
  std::vector<float> surface_share;
  double outlier_share = 0;  ///< of the points that were set aside as outliers
  /// share of the points that are outliers but still in `cloud`, as another search estimated it
  double outliers_left = 0;
  PointCloud set_aside;  ///< these outliers, with all that is known of them
  /// mm: how far a point's facet may lie below the true surface; empty: no coarse mesh
  std::vector<float> facet_depth;
  std::shared_ptr<const Surroundings> surroundings;  ///< of `cloud` (surroundings_of); found anew where it is missing
  bool oriented = false;                             ///< normals point outward (rays or a mesh told so)
  bool closed = false;                               ///< a mesh that bounds a solid: nothing of its surface is unseen
};

/// share of the points; above it some outliers remain undetected, and any shape passes through a few of them
constexpr double many_outliers = 0.1;
inline bool among_outliers(const FitInput& input) { return input.outlier_share > many_outliers; }

/// A length that only the end of the data determines: no residual depends on it except those of outliers.
struct HeldParameter {
  std::string name;
  double sigma = 0;  ///< mm
};

/// A body lower than this share of its width is a plate: it lies flat, and its height is its thickness.
inline constexpr double height_of_plate = 0.5;

/// A proposal: a part with named parameters, standing somewhere in the scan. Values are starts; refine() makes them
/// exact.
struct Candidate {
  std::string procedure;              ///< "sphere", "surface of revolution", ... as users read it
  std::vector<Object> steps;          ///< what the part is made of, in order; empty where one shape is all
  std::string object_name;            ///< of the part: "pin_body"
  Shape shape;                        ///< of the part; a boolean of `steps` where there are some
  std::vector<Parameter> parameters;  ///< all that the shapes and frames name
  Pose scan_from_part;
  int extra_numbers = 0;            ///< numbers that are no parameters (control points, triangles)
  std::vector<HeldParameter> held;  ///< what a fit must not move
  /// used if this candidate does not fit: the same with a longer extent, up to the last points
  std::shared_ptr<const Candidate> otherwise;
  std::string unseen;  ///< the defining feature of the shape if it was hardly seen: such a candidate is named as a
                       ///< rival, never chosen
};

/// Calls `visit` with every expression of a candidate's shapes and frames.
template <class Visit>
void visit_expressions(const Candidate& candidate, Visit&& visit) {
  for (const Object& step : candidate.steps) {
    model::visit_expressions(step.shape, visit);
    model::visit_expressions(step.frame, [&](const Expr& e) { visit(e, Domain::coordinate); });
  }
  model::visit_expressions(candidate.shape, visit);
}

}  // namespace partscribe::fit
