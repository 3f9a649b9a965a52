#include "geometry/segment/round_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/disjoint_sets.h"
#include "core/number.h"

namespace partscribe::geometry {
namespace {

constexpr double least_direction = 0.01;  // rad: directions closer than this may be one, whatever their sigmas say
constexpr double whole_turn = 1.5 * pi;   // rad of arc: a hole with a keyway is round still
constexpr double across = 0.9;            // cosine: a plane that stands across an axis
constexpr double along = 0.1;             // cosine: a plane that runs along an axis, as the walls of a keyway
constexpr int rim_places = 8;

bool has(const std::vector<std::uint32_t>& ascending, std::uint32_t value) {
  return std::binary_search(ascending.begin(), ascending.end(), value);
}

/// Mean distance of a neighbour's surface from the rim of a face at `along`.
double rim_distance(const Face& face, const Face& neighbour, double height) {
  const Primitive& p = face.surface();
  if (neighbour.kind == FaceKind::free_form) return std::abs((neighbour.middle - p.point).dot(p.axis) - height);
  const Mat3 frame = rotation_onto_axis(p.axis);
  const Vec3 to_middle = frame.transpose() * (face.middle - p.point);
  const double middle = std::atan2(to_middle.y(), to_middle.x());
  const double slope = face.kind == FaceKind::cone ? std::tan(p.half_angle) : 0;
  const double radius = std::max(0.0, p.radius + height * slope);
  double sum = 0;
  for (int i = 0; i < rim_places; ++i) {
    const double angle = middle + face.arc * ((i + 0.5) / rim_places - 0.5);
    const Vec3 place = p.point + frame * Vec3(radius * std::cos(angle), radius * std::sin(angle), height);
    sum += std::abs(distance(neighbour.surface(), place));
  }
  return sum / rim_places;
}

/// Whether a neighbour of a face is met at its upper (side 1) or lower end. A curved one beside the axis, as the shaft
/// through which a hole goes, may be met at both.
bool meets_at(const Face& face, const Face& neighbour, int side) {
  const Primitive &p = face.surface(), &q = neighbour.surface();
  const bool flat = neighbour.kind == FaceKind::plane;
  if (flat && std::abs(q.axis.dot(p.axis)) < along) return false;
  const double here = rim_distance(face, neighbour, side > 0 ? face.high : face.low);
  const double there = rim_distance(face, neighbour, side > 0 ? face.low : face.high);
  if (here < there) return true;
  const bool beside = neighbour.kind == FaceKind::cylinder && from_axis(p.point, p.axis, q.point) > 0.1 * p.radius;
  const bool crosses = neighbour.kind == FaceKind::cylinder && std::abs(q.axis.dot(p.axis)) < across;
  return (beside || crosses) && here < 0.3 * p.radius;
}

/// What the faces of a piece cover together, each about the direction of its middle.
double arc_of(const Faces& faces, const RoundPiece& piece) {
  constexpr int bins = 720;
  std::array<bool, bins> covered{};
  const Mat3 frame = rotation_onto_axis(piece.axis);
  for (const auto f : piece.faces) {
    const Face& face = faces.faces[f];
    const Vec3 to_middle = frame.transpose() * (face.middle - piece.point);
    const double first = std::atan2(to_middle.y(), to_middle.x()) - 0.5 * face.arc;
    const int count = static_cast<int>(std::lround(face.arc / (2 * pi) * bins));
    const int start = static_cast<int>(std::floor(first / (2 * pi) * bins)) + 2 * bins;
    for (int k = 0; k < count; ++k) covered[static_cast<std::size_t>((start + k) % bins)] = true;
  }
  return 2 * pi * static_cast<double>(std::count(covered.begin(), covered.end(), true)) / bins;
}

struct PlaneAcross {
  double place = 0, sigma = 0, length = 0;
  bool faces_out = false;
};

/// A plane across the axis, `side` being out.
PlaneAcross plane_across(const RoundPiece& piece, const Face& plane, double length, int side) {
  const Vec3& n = plane.surface().axis;
  const double cosine = n.dot(piece.axis);
  const double lever = from_axis(piece.point, piece.axis, plane.middle);
  return {(plane.surface().point - piece.point).dot(n) / cosine,
          std::hypot(plane.fit.sigma_point, plane.fit.sigma_axis * lever), length, cosine * side > 0};
}

bool stands_across(const RoundPiece& piece, const Face& face) {
  return face.kind == FaceKind::plane && std::abs(face.surface().axis.dot(piece.axis)) > across;
}

}  // namespace

FeatureScale feature_scale(const Faces& faces) {
  FeatureScale scale;
  scale.fine = 1e-4 * std::sqrt(area_of(faces));
  scale.coarse = std::max(scale.fine, 3 * faces.noise);
  return scale;
}

bool about_equal(double a, double sigma_a, double b, double sigma_b, double floor) {
  return std::abs(a - b) <= 4 * std::hypot(sigma_a, sigma_b) + floor;
}

bool about_parallel(const Vec3& a, const Vec3& b, double sigma) {
  return a.cross(b).norm() <= std::max(least_direction, 4 * sigma);
}

double from_axis(const Vec3& point, const Vec3& axis, const Vec3& place) { return (place - point).cross(axis).norm(); }

const FaceNeighbour* meeting(const Face& face, std::uint32_t neighbour) {
  for (const auto& n : face.neighbours)
    if (n.face == neighbour) return &n;
  return nullptr;
}

bool RoundPiece::full_turn() const { return arc >= whole_turn; }

RoundPiece round_piece(const Faces& faces, std::uint32_t index) {
  const Face& face = faces.faces[index];
  const Primitive& p = face.surface();
  RoundPiece piece;
  piece.faces = {index};
  piece.kind = face.kind, piece.hollow = face.hollow;
  piece.point = p.point, piece.axis = p.axis;
  piece.low = face.low, piece.high = face.high;
  const double slope = face.kind == FaceKind::cone ? std::tan(p.half_angle) : 0;
  piece.half_angle = p.half_angle;
  piece.low_radius = std::max(0.0, p.radius + slope * face.low);
  piece.high_radius = std::max(0.0, p.radius + slope * face.high);
  piece.sigma_radius = face.fit.sigma_radius, piece.sigma_point = face.fit.sigma_point;
  piece.sigma_axis = face.fit.sigma_axis, piece.sigma_half_angle = face.fit.sigma_half_angle;
  piece.arc = face.arc;
  return piece;
}

bool coaxial(const RoundPiece& a, const RoundPiece& b, double slack) {
  if (!about_parallel(a.axis, b.axis, std::hypot(a.sigma_axis, b.sigma_axis))) return false;
  // Half way between both, where their axes are best known.
  const Vec3 place = 0.5 * (a.point + b.point);
  const Vec3 on_a = a.point + a.along(place) * a.axis, on_b = b.point + b.along(place) * b.axis;
  const double tilt = 0.5 * (a.point - b.point).norm() * std::hypot(a.sigma_axis, b.sigma_axis);
  return about_equal((on_a - on_b).norm(), std::hypot(a.sigma_point, tilt), 0, b.sigma_point, slack);
}

std::vector<RoundPiece> round_pieces(const Faces& faces, const FeatureScale& scale) {
  std::vector<RoundPiece> single;
  DisjointSets sets;
  for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
    const FaceKind kind = faces.faces[f].kind;
    if (kind == FaceKind::cylinder || kind == FaceKind::cone) single.push_back(round_piece(faces, f)), sets.add();
  }
  for (std::uint32_t i = 0; i < single.size(); ++i)
    for (std::uint32_t j = i + 1; j < single.size(); ++j) {
      const RoundPiece &a = single[i], &b = single[j];
      if (a.kind != FaceKind::cylinder || b.kind != FaceKind::cylinder || a.hollow != b.hollow) continue;
      if (!about_equal(a.radius(), a.sigma_radius, b.radius(), b.sigma_radius, scale.fine)) continue;
      if (!coaxial(a, b, scale.coarse)) continue;
      // They must stand beside each other, not one behind the other.
      const double middle = a.along(b.point), half = 0.5 * (b.high - b.low);
      const double common = std::min(a.high, middle + half) - std::max(a.low, middle - half);
      if (common > 0.5 * std::min(a.high - a.low, 2 * half)) sets.unite(i, j);
    }
  std::vector<RoundPiece> pieces;
  std::vector<std::uint32_t> piece_of(single.size(), no_face);
  for (std::uint32_t i = 0; i < single.size(); ++i) {
    auto& index = piece_of[sets.root(i)];
    if (index == no_face) {
      index = static_cast<std::uint32_t>(pieces.size());
      pieces.push_back(single[i]);
      continue;
    }
    // The larger face, which came first, says where the axis is.
    RoundPiece& piece = pieces[index];
    const RoundPiece& other = single[i];
    const double middle = piece.along(other.point), half = 0.5 * (other.high - other.low);
    piece.low = std::min(piece.low, middle - half), piece.high = std::max(piece.high, middle + half);
    piece.faces.push_back(other.faces.front());
  }
  for (auto& piece : pieces) {
    if (piece.faces.size() > 1) piece.arc = arc_of(faces, piece);
    std::sort(piece.faces.begin(), piece.faces.end());
  }
  return pieces;
}

PieceRim rim_of(const Faces& faces, const RoundPiece& piece, int side, const FeatureScale& scale) {
  PieceRim rim;
  rim.place = side > 0 ? piece.high : piece.low;
  rim.sigma = std::max(piece.sigma_point, scale.coarse / 3);
  const double end = rim.place;
  double open = 0, closed = 0;
  PlaneAcross best;
  const auto consider = [&](const Face& plane, double length) {
    const PlaneAcross found = plane_across(piece, plane, length, side);
    if (best.length > 0 && length <= best.length) return;
    best = found;
  };
  std::vector<std::uint32_t> between;  // small rounds, chamfers and cones that lead on
  for (const auto f : piece.faces) {
    const Face& face = faces.faces[f];
    const int face_side = face.surface().axis.dot(piece.axis) > 0 ? side : -side;
    for (const auto& n : face.neighbours) {
      const Face& other = faces.faces[n.face];
      if (has(piece.faces, n.face) || !meets_at(face, other, face_side)) continue;
      if (std::find(rim.faces.begin(), rim.faces.end(), n.face) == rim.faces.end()) rim.faces.push_back(n.face);
      if (stands_across(piece, other)) {
        consider(other, n.length);
        (plane_across(piece, other, n.length, side).faces_out ? open : closed) += n.length;
      } else if (n.edge == EdgeKind::tangent) {
        if (other.kind == FaceKind::torus || other.kind == FaceKind::sphere) (other.hollow ? closed : open) += n.length;
      } else {
        (n.edge == EdgeKind::convex ? open : closed) += n.length;
      }
      if (other.kind == FaceKind::torus || other.kind == FaceKind::cone) between.push_back(n.face);
    }
  }
  if (open > closed) rim.state = RimState::open;
  if (closed > open) rim.state = RimState::closed;
  if (!(best.length > 0))
    for (const auto b : between)
      for (const auto& n : faces.faces[b].neighbours) {
        const Face& other = faces.faces[n.face];
        if (!stands_across(piece, other)) continue;
        const PlaneAcross found = plane_across(piece, other, n.length, side);
        const bool beyond = side * (found.place - end) > -scale.coarse;
        const bool fits = rim.state == RimState::unknown || found.faces_out == (rim.state == RimState::open);
        if (beyond && fits && std::abs(found.place - end) < 2 * piece.radius()) consider(other, n.length);
      }
  if (best.length > 0) {
    rim.place = best.place, rim.sigma = best.sigma, rim.plane = true;
    if (rim.state == RimState::unknown) rim.state = best.faces_out ? RimState::open : RimState::closed;
  }
  std::sort(rim.faces.begin(), rim.faces.end());
  return rim;
}

}  // namespace partscribe::geometry
