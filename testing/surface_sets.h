/// Small bodies of B-spline surfaces for tests: a sheet with a hole, a closed body of six patches, a swept surface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/number.h"
#include "model/shapes.h"

namespace partscribe::testing {

using namespace model;

inline PatchTrim straight(int loop, int edge, std::array<double, 2> from, std::array<double, 2> to) {
  return {loop, edge, 1, {0, 0, 1, 1}, {from, to}};
}

/// A cubic sheet over 60 x 40 with a hole of four cubic pieces, its rim cut obliquely at one corner.
inline SurfaceSet cowl() {
  TrimmedPatch patch{"cowl", 3, 2, {0, 0, 0, 0, 30, 60, 60, 60, 60}, {0, 0, 0, 20, 40, 40, 40}, {}, {}, {}};
  const double heights[5][4] = {{0, 2, 2, 0}, {4, 9, 8, 3}, {6, 14, 12, 5}, {5, 10, 9, 4}, {1, 3, 3, 1}};
  const double xs[] = {0, 10, 30, 50, 60}, ys[] = {0, 10, 30, 40};
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 4; ++j) patch.control.push_back({xs[i], ys[j], heights[i][j]});
  patch.trims = {straight(0, 1, {0, 0}, {60, 0}), straight(0, 2, {60, 0}, {60, 28}), straight(0, 3, {60, 28}, {50, 40}),
                 straight(0, 4, {50, 40}, {0, 40}), straight(0, 5, {0, 40}, {0, 0})};
  const double r = 8, k = 0.5522847498 * r;
  const std::array<double, 2> c = {25, 20};
  const auto piece = [&](int edge, double ax, double ay, double bx, double by) {
    // A quarter of a circle from c + a to c + b, clockwise.
    patch.trims.push_back({1,
                           edge,
                           3,
                           {0, 0, 0, 0, 1, 1, 1, 1},
                           {{c[0] + r * ax, c[1] + r * ay},
                            {c[0] + r * ax + k * bx, c[1] + r * ay + k * by},
                            {c[0] + r * bx + k * ax, c[1] + r * by + k * ay},
                            {c[0] + r * bx, c[1] + r * by}}});
  };
  piece(6, 1, 0, 0, -1), piece(7, 0, -1, -1, 0), piece(8, -1, 0, 0, 1), piece(9, 0, 1, 1, 0);
  SurfaceSet set;
  set.patches = {patch};
  set.thickness = Expr(2);
  return set;
}

/// A wave over (-2, -2) to (62, 42), 12 to 21 mm high, rational in the middle, that moves up by 20 and a little
/// sideways.
inline SweptSurface wave() {
  SweptSurface s;
  s.surface = {"wave", 3, 2, {-2, -2, -2, -2, 30, 62, 62, 62, 62}, {-2, -2, -2, 20, 42, 42, 42}, {}, {}, {}};
  const double heights[5][4] = {
      {14, 15, 15, 14}, {18, 23, 21, 17}, {13, 10, 12, 15}, {15, 22, 24, 18}, {12, 14, 15, 13}};
  const double xs[] = {-2, 9, 30, 51, 62}, ys[] = {-2, 10, 30, 42};
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 4; ++j) {
      s.surface.control.push_back({xs[i], ys[j], heights[i][j]});
      s.surface.weights.push_back(i == 2 ? 1.25 : 1);
    }
  s.direction = {1, 0, 20};
  return s;
}

/// A cube of 20 whose sides bulge by biquadratic patches; two of them rational.
inline SurfaceSet cushion() {
  SurfaceSet set;
  set.closed = true;
  const auto side = [&](const char* name, std::array<int, 3> from, int u, int v, std::array<int, 4> edges,
                        bool rational) {
    // u and v: axis + 1, negative where the parameter runs against it.
    TrimmedPatch patch{name, 2, 2, {0, 0, 0, 20, 20, 20}, {0, 0, 0, 20, 20, 20}, {}, {}, {}};
    std::array<double, 3> along[2] = {}, out{};
    along[0][std::size_t(std::abs(u) - 1)] = u > 0 ? 10 : -10;
    along[1][std::size_t(std::abs(v) - 1)] = v > 0 ? 10 : -10;
    for (std::size_t a = 0; a < 3; ++a)
      if (along[0][a] == 0 && along[1][a] == 0) out[a] = from[a] > 0 ? 8 : -8;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        auto& p = patch.control.emplace_back();
        for (std::size_t a = 0; a < 3; ++a)
          p[a] = from[a] + i * along[0][a] + j * along[1][a] + (i == 1 && j == 1 ? out[a] : 0);
        if (rational) patch.weights.push_back(i == 1 && j == 1 ? 1.5 : 1);
      }
    patch.trims = {straight(0, edges[0], {0, 0}, {20, 0}), straight(0, edges[1], {20, 0}, {20, 20}),
                   straight(0, edges[2], {20, 20}, {0, 20}), straight(0, edges[3], {0, 20}, {0, 0})};
    set.patches.push_back(patch);
  };
  side("bottom", {-10, -10, 0}, 2, 1, {3, 2, 1, 0}, false);
  side("top", {-10, -10, 20}, 1, 2, {4, 5, 6, 7}, true);
  side("front", {-10, -10, 0}, 1, 3, {0, 9, 4, 8}, false);
  side("right", {10, -10, 0}, 2, 3, {1, 10, 5, 9}, false);
  side("back", {10, 10, 0}, -1, 3, {2, 11, 6, 10}, true);
  side("left", {-10, 10, 0}, -2, 3, {3, 8, 7, 11}, false);
  return set;
}

}  // namespace partscribe::testing
