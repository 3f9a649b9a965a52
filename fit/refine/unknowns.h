/// What a refinement varies (a candidate's free parameters and its place) and how distances answer to it.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "fit/candidate.h"

namespace partscribe::fit {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Signed distances of points and the faces that are nearest to them.
struct Distances {
  std::vector<double> value;  ///< mm
  std::vector<int> face;
};

/// Where viewing rays meet the surface next to the points that they brought back.
struct RayFeet {
  Distances at;                ///< residuals: from point to foot along the ray, times the cosine of the incidence there
  std::vector<Vec3> foot;      ///< scan frame; the point itself where its ray passes the surface by
  std::vector<double> cosine;  ///< of the incidence at the foot; 1 where there is none
};

/// d(distance)/d(unknown), one row per point.
struct Jacobian {
  Matrix rows;
  std::vector<Vec3> gradients;  ///< of the distance by the point, in the scan's frame: the surface's normal
};

/// Unknowns are the free parameters in the candidate's order, then a shift in scan axes, then a turn about `center`
/// times `size`, so that all columns are lengths per length. Directions that move nothing give zero columns.
class Unknowns {
 public:
  /// `moves`: false for a shape whose frame stands; its shift and turn move nothing.
  Unknowns(const Candidate& candidate, const std::vector<std::string>& fixed, const Vec3& center, double size,
           bool moves = true);

  std::size_t count() const { return free_.size() + 6; }
  const std::vector<std::size_t>& free_parameters() const { return free_; }
  double size() const { return size_; }
  const Vec3& center() const { return center_; }

  Distances distances(const Candidate& c, const std::vector<Vec3>& points, int threads) const;
  /// A range sensor errs along its ray. Where it sees a curved surface at a slant, the orthogonal distance of a point
  /// is biased by the curvature times the square of the error; the distance along the ray is not. Within `reach` mm of
  /// the surface the residual is the distance along the ray times the cosine of the incidence. Elsewhere, and where the
  /// ray meets no surface near the point, it stays the orthogonal distance, which is given in `orthogonal`.
  RayFeet along_rays(const Candidate& c, const std::vector<Vec3>& points, const std::vector<Vec3>& rays,
                     Distances orthogonal, double reach, int threads) const;
  /// By differences of the exact distance. A parameter that moves none of some dozens of a face's points moves none of
  /// the others: only for the other faces all points are evaluated.
  Jacobian jacobian(const Candidate& c, const std::vector<Vec3>& points, const Distances& at, int threads) const;
  /// Parameters stop at the ends of their domains.
  Candidate stepped(const Candidate& c, const Vector& step) const;
  /// False after a step that turned a size negative.
  bool sensible(const Candidate& c) const;

 private:
  void find_limits(const Candidate& candidate);

  Model model_;
  std::vector<std::size_t> free_;
  std::map<std::string, std::pair<double, double>> limits_;
  Vec3 center_;
  double size_;
  bool moves_;
};

/// The six columns of a rigid motion in a point's row: a shift and a turn about `center` times `size`.
Eigen::Matrix<double, 6, 1> motion_row(const Vec3& point, const Vec3& gradient, const Vec3& center, double size);

}  // namespace partscribe::fit
