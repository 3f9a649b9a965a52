#include "bench/invented/parts.h"

#include <cmath>

#include "bench/invented/csg.h"
#include "core/number.h"
#include "testing/meshes.h"

namespace partscribe::testing {
namespace {

const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();

TriangleMesh box(const Vec3& low, const Vec3& high) { return box(low, high); }

TriangleMesh bracket() {
  TriangleMesh m = united(box({0, 0, 0}, {60, 40, 6}), box({0, 0.01, 0.01}, {6.01, 39.99, 50}));
  for (const double v : {10.0, 30.0}) {
    m = without(m, rod({45, v, -1}, z, 8, 3));
    m = without(m, rod({-1, v, 38}, x, 8, 2.5));
  }
  return without(m, rod({25, -1, 3}, y, 30, 1.25));
}

TriangleMesh housing() {
  TriangleMesh m = without(box({0, 0, 0}, {60, 60, 35}), box({3, 3, 3}, {57, 57, 36}));
  for (const double u : {8.0, 52.0})
    for (const double v : {8.0, 52.0}) {
      m = united(m, rod({u, v, 1.5}, z, 32.5, 4));
      m = without(m, rod({u, v, 5}, z, 30, 1.5));
    }
  return m;
}

TriangleMesh plate() {
  TriangleMesh m = box({0, 0, 0}, {100, 70, 12});
  for (const double u : {12.0, 50.0, 88.0})
    for (const double v : {12.0, 58.0}) m = without(m, rod({u, v, 2}, z, 11, 2));
  m = without(m, box({30, 25, 6}, {70, 45, 13}));
  return without(m, rod({-1, 35, 5}, x, 28, 1.75));
}

TriangleMesh crossed() {
  TriangleMesh m = box({0, 0, 0}, {50, 40, 40});
  m = without(m, rod({-1, 20, 22}, x, 42, 2.5));
  m = without(m, rod({25, -1, 15}, y, 34, 4));
  m = without(m, rod({35, 30, 12}, z, 29, 3));
  return without(m, box({-1, -1, 30}, {16, 41, 41}));
}

TriangleMesh flange() {
  TriangleMesh m = turned({{0, 0}, {40, 0}, {40, 10}, {20, 10}, {20, 30}, {0, 30}}, 96);
  m = without(m, rod({0, 0, -1}, z, 32, 6, 64));
  for (int k = 0; k < 6; ++k) m = without(m, rod({30 * std::cos(k * pi / 3), 30 * std::sin(k * pi / 3), -1}, z, 12, 3));
  return without(m, rod({21, 0, 20}, -x, 17, 1.5));
}

TriangleMesh shaft() {
  TriangleMesh m = turned({{0, 0}, {10, 0}, {10, 30}, {15, 30}, {15, 60}, {7, 60}, {7, 100}, {0, 100}}, 96);
  m = without(m, rod({0, 0, -1}, z, 41, 2.5));
  m = without(m, rod({0, 0, 75}, z, 26, 1.65));
  return without(m, box({-2.5, 8, 5}, {2.5, 16, 25}));
}

TriangleMesh manifold() {
  TriangleMesh m = box({0, 0, 0}, {80, 40, 30});
  m = without(m, rod({-1, 20, 13}, x, 71, 4));
  for (const double u : {15.0, 32.0, 48.0, 65.0}) {
    m = without(m, rod({u, 20, 6}, z, 25, 3));
    m = without(m, rod({u, 20, 25}, z, 6, 5));
  }
  return m;
}

TriangleMesh channel() {
  TriangleMesh m = without(box({0, 0, 0}, {80, 40, 30}), box({-1, 4, 4}, {81, 36, 31}));
  for (const double u : {15.0, 40.0, 65.0}) m = without(m, rod({u, 20, -1}, z, 6, 2.5));
  for (const double u : {20.0, 60.0}) m = without(m, rod({u, -1, 20}, y, 42, 3));
  return without(m, rod({30, 2, 31}, -z, 25, 0.8));
}

TriangleMesh tray() {
  TriangleMesh m = without(box({0, 0, 0}, {90, 60, 20}), box({3, 3, 3}, {87, 57, 21}));
  for (const double u : {15.0, 75.0})
    for (const double v : {13.0, 47.0}) {
      m = united(m, rod({u, v, 1.5}, z, 10, 3.5));
      m = without(m, rod({u, v, 1}, z, 11, 1.25));
    }
  return without(m, box({35, -1, 8}, {55, 4, 21}));
}

TriangleMesh wedge() {
  TriangleMesh m = box({0, 0, 0}, {70, 45, 40});
  const Mat3 turn = rotation_of(-0.6 * y);
  m = without(m, block({200, 100, 60}, {turn, Vec3(35, 22.5, 26) + turn * Vec3(0, 0, 30)}));
  const Vec3 out = turn * z;
  for (const double v : {12.0, 33.0}) m = without(m, rod(Vec3(35, v, 26) + 2 * out, -out, 22, 2));
  return without(m, rod({-1, 22.5, 6}, x, 51, 3));
}

TriangleMesh knob() {
  std::vector<Vec2> profile = {{0, 0}, {9, 0}, {9, 12}};
  for (int k = 0; k <= 40; ++k) {
    const double a = -0.9 + (0.5 * pi + 0.9) * k / 40;
    profile.emplace_back(k == 40 ? 0 : 20 * std::cos(a), 28 + 20 * std::sin(a));
  }
  TriangleMesh m = turned(profile, 96);
  m = without(m, rod({0, 0, -1}, z, 26, 3));
  return without(m, rod({-25, 0, 28}, x, 20, 1.5));
}

}  // namespace

std::vector<NamedPart> parts_with_bores() {
  return {{"bracket", bracket()}, {"housing", housing()}, {"plate", plate()},       {"crossed", crossed()},
          {"flange", flange()},   {"shaft", shaft()},     {"manifold", manifold()}, {"channel", channel()},
          {"tray", tray()},       {"wedge", wedge()},     {"knob", knob()}};
}

}  // namespace partscribe::testing
