#include "verify/features/roundness.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "verify/report/findings.h"

namespace partscribe::verify {
namespace {

constexpr double nearest_wall = 0.5, farthest_wall = 1.6;  // radii from the axis
constexpr double facing = 0.85;                            // cosine between the scanned normal and the radius
constexpr std::size_t least_points = 20, most_points = 1500;
constexpr double least_around = 0.5;    // share of the circle with points
constexpr double clearly_better = 0.7;  // ratio of root mean squares
constexpr double round_enough = 0.12;   // of the sagitta: flat walls scatter by 0.3 of it about the best circle

}  // namespace

bool scanned_round(const ScanSource& source, const MeshDistance& artifact, const Primitive& cylinder, double low,
                   double high) {
  const Vec3 middle = cylinder.point + 0.5 * (low + high) * cylinder.axis;
  const double margin = std::min(source.spacing, 0.1 * (high - low));
  std::vector<Neighbour> around, near;
  source.tree->within(middle, std::hypot(farthest_wall * cylinder.radius, 0.5 * (high - low)), around);
  std::vector<Vec3> points;
  const std::size_t step = around.size() / most_points + 1;
  for (std::size_t i = 0; i < around.size(); i += step) {
    const Vec3& p = source.points[around[i].index];
    const double along = (p - cylinder.point).dot(cylinder.axis);
    const Vec3 across = p - cylinder.point - along * cylinder.axis;
    if (along < low + margin || along > high - margin) continue;
    if (across.norm() < nearest_wall * cylinder.radius || across.norm() > farthest_wall * cylinder.radius) continue;
    const Vec3 normal = scanned_normal(source, around[i].index, near);
    if (normal.squaredNorm() > 0.5 && std::abs(normal.dot(across.normalized())) < facing) continue;
    points.push_back(p);
  }
  if (points.size() < least_points) return false;
  PrimitiveFitOptions how;
  how.start = cylinder;
  how.robust = 2.5;
  const auto fit = fit_primitive(PrimitiveKind::cylinder, points, {}, how);
  if (!fit || !fit->converged || !fit->determined) return false;
  const Primitive& found = fit->primitive;
  if (std::abs(found.axis.dot(cylinder.axis)) < 0.94) return false;
  const Mat3 frame = rotation_onto_axis(found.axis);
  std::vector<char> seen(36, 0);
  double on_circle = 0, on_artifact = 0;
  std::size_t used = 0;
  for (const auto& p : points) {
    const double off = distance(found, p);
    if (std::abs(off) > 0.2 * found.radius) continue;  // another wall
    const Vec3 q = frame.transpose() * (p - found.point);
    seen[std::min<std::size_t>(35, static_cast<std::size_t>((std::atan2(q.y(), q.x()) + pi) / (2 * pi) * 36))] = 1;
    const double apart = artifact.closest(p).distance;
    on_circle += off * off, on_artifact += apart * apart, ++used;
  }
  const auto bins = std::count(seen.begin(), seen.end(), 1);
  if (2 * used < points.size() || static_cast<double>(bins) < least_around * 36) return false;
  on_circle = std::sqrt(on_circle / static_cast<double>(used)),
  on_artifact = std::sqrt(on_artifact / static_cast<double>(used));
  // Of a square to a heptagon through the same corners, the flattest.
  const double sagitta = cylinder.radius * (1 - std::cos(pi / 7));
  return on_circle < clearly_better * on_artifact && on_circle < std::hypot(1.2 * source.noise, round_enough * sagitta);
}

}  // namespace partscribe::verify
