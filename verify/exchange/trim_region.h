/// Which part of a surface's parameter plane belongs to a face, decided exactly on its boundary curves.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::verify {

/// A boundary curve in the parameter plane, run from `first` to `last`.
struct TrimCurve {
  std::function<Vec2(double)> at;
  double first = 0, last = 1;
  bool straight = false;
  std::vector<double> kinks;  ///< parameters between first and last where the curve must be sampled
};

/// Inside is what a ray leaves through an odd number of boundary curves.
class TrimRegion {
 public:
  /// `loops`: closed sequences of curves, each beginning where the one before it ends.
  explicit TrimRegion(std::vector<std::vector<TrimCurve>> loops);
  TrimRegion() = default;

  bool contains(const Vec2& p) const;
  const Vec2& low() const { return low_; }
  const Vec2& high() const { return high_; }

 private:
  /// A part of a curve along which the second coordinate only rises or only falls.
  struct Piece {
    Vec2 a, b;  // its ends, a the lower one
    double ta, tb;
    double slack;  // it stays so close to its chord
    std::uint32_t curve;
  };
  bool left_of(const Vec2& p, const Piece& piece) const;
  void add_piece(std::uint32_t curve, double t0, const Vec2& a, double t1, const Vec2& b, int depth);

  std::vector<TrimCurve> curves_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> bucket_start_, bucket_;  // pieces by strips of the second coordinate
  Vec2 low_ = Vec2::Zero(), high_ = Vec2::Zero();
  double fine_ = 0;
};

}  // namespace partscribe::verify
