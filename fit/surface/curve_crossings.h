/// Where curves in a plane cross each other or themselves.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/surfaces/nurbs.h"

namespace partscribe::fit {

/// Two curves, or one twice, and at which shares (0 .. 1) of their domains they cross.
struct CurveCrossing {
  std::array<std::size_t, 2> curve;
  std::array<double, 2> share;
};

/// All crossings that twenty straight pieces to each span of a curve have.
std::vector<CurveCrossing> crossings_of(std::span<const NurbsCurve<2>* const> curves);

}  // namespace partscribe::fit
