/// Plane curves (lines, arcs, NURBS), closed outlines of them, and exact distances to both.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "geometry/surfaces/nurbs.h"
#include "geometry/vec.h"

namespace partscribe::geometry {

struct Line2 {
  Vec2 a, b;
};

/// Counter-clockwise when `to` > `from`; radians.
struct Arc2 {
  Vec2 center;
  double radius = 0, from = 0, to = 0;
  Vec2 at(double angle) const;
};

/// Clamped.
using Nurbs2 = NurbsCurve<2>;

using Curve2 = std::variant<Line2, Arc2, Nurbs2>;

Vec2 start_of(const Curve2& curve);
Vec2 end_of(const Curve2& curve);

/// Points along the curve, both ends included, so that no chord is farther than `chord_error` from it.
std::vector<Vec2> polyline(const Curve2& curve, double chord_error);

/// One boundary curve of an outline with the name of its role.
struct OutlineCurve {
  Curve2 curve;
  std::string name;
  int loop = 0;
};

/// Closed loops of curves, each end meeting the next start.
struct Outline2 {
  std::vector<OutlineCurve> curves;  ///< loop after loop, in order
};

/// Signed distance to an outline: negative inside (even-odd rule over the loops).
class OutlineDistance {
 public:
  explicit OutlineDistance(Outline2 outline);
  ~OutlineDistance();
  OutlineDistance(OutlineDistance&&) noexcept;
  struct Hit {
    double distance = 0;
    int curve = -1;  ///< index into outline().curves
    Vec2 foot = Vec2::Zero();
  };
  /// `ignored[i]` true: curve i bounds the inside but is no surface (a profile's part on the axis).
  Hit operator()(const Vec2& point) const;
  /// The nearest point of one curve, ends included, and a unit normal of the curve there (either way).
  struct CurveFoot {
    double distance = 0;  ///< >= 0
    Vec2 point = Vec2::Zero(), normal = Vec2::UnitX();
  };
  CurveFoot foot(const Vec2& point, int curve) const;
  void ignore(int curve) { ignored_[static_cast<std::size_t>(curve)] = true; }
  const Outline2& outline() const { return outline_; }
  bool inside(const Vec2& point) const;

 private:
  struct Prepared;  // what each query needs of every arc
  struct NurbsFoot;
  NurbsFoot nurbs_foot(const Vec2& p, std::size_t curve) const;
  Outline2 outline_;
  std::vector<char> ignored_;
  std::vector<std::vector<Vec2>> chords_;  // per curve; only NURBS have any
  std::vector<std::vector<double>> chord_u_;
  double chord_error_ = 0;  // mm
  std::unique_ptr<Prepared> prepared_;
};

/// The area enclosed by one loop, positive for counter-clockwise.
double signed_area(const Outline2& outline, int loop);

}  // namespace partscribe::geometry
