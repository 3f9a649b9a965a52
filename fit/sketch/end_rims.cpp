#include "fit/sketch/end_rims.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {

std::vector<PlanePoint> rim_of(const std::vector<Vec2>& face) {
  constexpr std::size_t neighbours = 20;
  constexpr double sector = 2.3;  // rad; by chance one in 300 points of an even face has such a gap
  std::vector<PlanePoint> rim;
  if (face.size() < 2 * neighbours) return rim;
  std::vector<Vec3> flat;
  for (const Vec2& p : face) flat.emplace_back(p.x(), p.y(), 0);
  const KdTree tree(flat);
  std::vector<Neighbour> near;
  std::vector<double> angles;
  for (std::size_t i = 0; i < face.size(); ++i) {
    tree.nearest(flat[i], neighbours + 1, near);
    angles.clear();
    for (const auto& n : near) {
      const Vec2 d = face[n.index] - face[i];
      if (d.squaredNorm() > 0) angles.push_back(std::atan2(d.y(), d.x()));
    }
    if (angles.size() < neighbours / 2) continue;
    std::sort(angles.begin(), angles.end());
    double widest = 0, middle = 0;
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const double next = k + 1 < angles.size() ? angles[k + 1] : angles[0] + 2 * pi;
      if (next - angles[k] > widest) widest = next - angles[k], middle = 0.5 * (next + angles[k]);
    }
    if (widest < sector) continue;
    const Vec2 out(std::cos(middle), std::sin(middle));
    double farthest = 0;
    for (const auto& n : near) farthest = std::max(farthest, out.dot(face[n.index] - face[i]));
    rim.push_back({face[i] + farthest * out, out});
  }
  return rim;
}

}  // namespace partscribe::fit
