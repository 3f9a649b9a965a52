/// Points on a model's surface with noise, outliers and unseen parts: scans whose truth is known to the last digit.
#pragma once

#include "core/random.h"
#include "geometry/points/point_cloud.h"
#include "model/distance/distance.h"

namespace partscribe::testing {

using namespace model;

struct Sampling {
  std::size_t points = 20000;
  double noise = 0.02;            ///< mm along the normal
  double outliers = 0;            ///< share of points scattered over the bounding box
  double reach = 40;              ///< mm; starts are drawn from this half cube
  Vec3 seen_from = Vec3::Zero();  ///< not zero: only what faces this direction
  std::uint64_t seed = 1;
};

/// Random places are drawn onto the surface along the gradient of the exact distance.
inline Scan sampled(const Model& model, const Sampling& s) {
  const ModelDistance distance(model);
  Random random(s.seed);
  Scan scan;
  scan.files = {"simulated"};
  const Vec3 center = model.as_scanned ? evaluate(model.scan_from_part, values_of(model)).translation : Vec3(0, 0, 0);
  while (scan.cloud.points.size() < s.points) {
    Vec3 p = center + Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) * s.reach;
    // Starts in a thin shell about the surface: every part of it gets its share, holes too.
    if (std::abs(distance.bound(p)) > 0.03 * s.reach || std::abs(distance(p).distance) > 0.03 * s.reach) continue;
    Vec3 g = Vec3::Zero();
    const double h = 1e-6 * s.reach;
    double d = 0;
    for (int step = 0; step < 30; ++step) {
      d = distance(p).distance;
      for (int k = 0; k < 3; ++k)
        g[k] = (distance(p + h * Vec3::Unit(k)).distance - distance(p - h * Vec3::Unit(k)).distance) / (2 * h);
      if (std::abs(g.norm() - 1) > 1e-3 || std::abs(d) < 1e-10) break;
      p -= d * g;
    }
    if (std::abs(d) > 1e-8 || std::abs(g.norm() - 1) > 1e-3) continue;
    if (s.seen_from.norm() > 0 && g.dot(s.seen_from.normalized()) < 0.15) continue;
    scan.cloud.points.push_back(p + s.noise * random.normal() * g);
    if (random.uniform() < s.outliers)
      scan.cloud.points.push_back(center +
                                  Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) * s.reach);
  }
  return scan;
}

}  // namespace partscribe::testing
