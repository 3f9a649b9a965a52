/// The last steps of a fit use every point of the scan, at the cost of one or two distances per point.
#pragma once

#include "core/context.h"
#include "fit/refine/normal_equations.h"
#include "fit/refine/unknowns.h"
#include "fit/uncertainty/noise_model.h"

namespace partscribe::fit {

/// Points in an order that their coordinates alone decide, in runs that share one row of the Jacobian.
struct AllPoints {
  std::vector<Vec3> points;
  std::vector<int> group;  ///< view, or region where views are unknown; the unit of systematic error
  int group_count = 1;
  bool by_view = false;
  std::vector<std::vector<int>> views;  ///< of each group, where it is made of views
  std::vector<Vec3> rays;               ///< from the sensor, where known
  std::vector<double> cosine;           ///< of the incidence, where rays are known
  std::vector<Vec3> foot;               ///< where rays are known: where they meet the candidate
  double reach = 0;                     ///< mm; residuals up to this count along the ray
  std::vector<double> relative;         ///< sigma that came with the data
  Distances at;               ///< of the points, at the present candidate; along the rays where these are known
  std::vector<double> sigma;  ///< of each point, mm
  Welsch kernel;              ///< as asked for, with the density of outliers where it was counted
  std::vector<char> used;     ///< 0: too near to an edge to tell which face it belongs to

  /// A cell's points of one face: points[begin .. end), all with the derivatives at `place`.
  struct Node {
    std::size_t begin = 0, end = 0;
    Vec3 place;
  };
  std::vector<Node> nodes;

  /// A point of a wall thinner than the noise: it counts for both sides (thin_walls.h).
  struct Pair {
    std::size_t near = 0, far = 0;  ///< its entries; the far ones come after all others
    Vec3 before, behind;            ///< places to whose nearest faces the two belong
    double share = 0.5;             ///< of the near side
  };
  std::vector<Pair> pairs;
  bool chords_corrected = false;  ///< the residuals are those of the corners of a mesh (chords.h)
  std::vector<double> say;        ///< weight of each entry, if there are pairs; 1 for entries in no pair
  Jacobian jacobian;              ///< one row per node
};

struct AllPointsOptions {
  std::size_t nodes = 16000;      ///< rows of the Jacobian, about; fewer blur it at the rims of small faces
  std::size_t points = 20000000;  ///< scans with more fall back on the thinned points
  Welsch kernel{3};
  /// the points contain all outliers near the surface, so that the density of outliers can be estimated
  bool outliers_near = false;
};

/// All usable points of the scan behind `input` (of a mesh, or where there is none: the thinned ones), with distances,
/// noise and derivatives at `candidate`.
AllPoints all_points(const Candidate& candidate, const FitInput& input, const Unknowns& unknowns, double least_sigma,
                     const AllPointsOptions& options, Context& context);

/// Gauss-Newton on all points. The estimating equations sum psi(d_i / sigma_i) / sigma_i * J = 0 use the exact distance
/// of every point. J is that of the point's node, which causes no bias and costs efficiency only in the second order of
/// how much J varies inside a node. Afterwards `all` holds the distances at the result. Returns about how much the log
/// likelihood has improved.
double polish(Candidate& candidate, AllPoints& all, const Unknowns& unknowns, double least_sigma,
              const AllPointsOptions& options, Context& context);

/// Sigma of every point, from the residuals of those that are `told` (empty: all), at least `least_sigma`.
void learn_noise(AllPoints& all, const std::vector<double>& residuals, std::vector<char> told, double least_sigma);

}  // namespace partscribe::fit
