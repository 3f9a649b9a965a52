/// Cylinders and cones of a part, put together from their faces, and what stands at their ends.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/segment/faces.h"

namespace partscribe::geometry {

/// What counts as equal on one part, besides four sigmas, mm.
struct FeatureScale {
  double fine = 0;    ///< of sizes and of places that are fitted
  double coarse = 0;  ///< of places where faces end
};
FeatureScale feature_scale(const Faces& faces);

/// |a - b| within four sigmas and `floor`.
bool about_equal(double a, double sigma_a, double b, double sigma_b, double floor);
bool about_parallel(const Vec3& a, const Vec3& b, double sigma);  ///< directions up to their sense
/// mm, from the line through `point` along `axis` to `place`.
double from_axis(const Vec3& point, const Vec3& axis, const Vec3& place);
/// How the face meets that neighbour; null if it does not.
const FaceNeighbour* meeting(const Face& face, std::uint32_t neighbour);

/// Faces of one cylinder that follow each other around it, or one cone.
struct RoundPiece {
  std::vector<std::uint32_t> faces;  ///< ascending
  FaceKind kind = FaceKind::cylinder;
  bool hollow = false;
  Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();
  double low = 0, high = 0;                ///< mm along the axis from `point`
  double low_radius = 0, high_radius = 0;  ///< mm, there
  double half_angle = 0;                   ///< rad, of cones
  double sigma_radius = 0, sigma_point = 0, sigma_axis = 0, sigma_half_angle = 0;
  double arc = 0;  ///< rad, 2 pi at most

  double along(const Vec3& place) const { return (place - point).dot(axis); }
  double radius() const { return 0.5 * (low_radius + high_radius); }
  bool full_turn() const;  ///< but for a keyway
};

std::vector<RoundPiece> round_pieces(const Faces& faces, const FeatureScale& scale);
/// One face as a piece of its own.
RoundPiece round_piece(const Faces& faces, std::uint32_t face);

/// Whether both lie on one axis, but for `slack` mm.
bool coaxial(const RoundPiece& a, const RoundPiece& b, double slack);

enum class RimState { open, closed, unknown };

/// An end of a piece.
struct PieceRim {
  RimState state = RimState::unknown;  ///< closed: it stands on something, or something bars it
  double place = 0, sigma = 0;         ///< mm along the piece's axis: of the plane across it if there is one
  bool plane = false;                  ///< there is one, perhaps behind a small round or chamfer
  std::vector<std::uint32_t> faces;    ///< those that the piece meets there
};

/// `side`: +1 at `high`, -1 at `low`.
PieceRim rim_of(const Faces& faces, const RoundPiece& piece, int side, const FeatureScale& scale);

}  // namespace partscribe::geometry
