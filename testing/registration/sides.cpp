#include "testing/registration/sides.h"

#include <algorithm>

#include "scan/register/register_pair.h"

namespace partscribe::testing::registration {
namespace {

/// Where it was put, and turned by each of the turns after which it is said to fit as well.
std::vector<Pose> places_of(const Registration& registration, std::size_t view) {
  const Pose& placed = registration.views[view].world_from_view;
  std::vector<Pose> places{placed};
  for (const AlikePlaces& alike : registration.alike)
    if (std::find(alike.views.begin(), alike.views.end(), view) != alike.views.end())
      places.push_back(rotation_about(alike.point, alike.axis, alike.angle) * placed);
  return places;
}

}  // namespace

std::vector<Pose> best_sides(const std::vector<Pose>& truth, const Registration& registration, double size) {
  std::vector<std::vector<Pose>> places;
  for (std::size_t v = 0; v < truth.size(); ++v) places.push_back(places_of(registration, v));
  std::vector<Pose> best;
  double least = 1e300;
  for (std::size_t first = 0; first < truth.size(); ++first) {
    if (registration.views[first].status == ViewStatus::refused) continue;
    for (const Pose& start : places[first]) {
      const Pose moved = truth[first] * start.inverse();
      const Vec3 middle = moved * registration.center;
      double sum = 0;
      std::vector<Pose> poses;
      for (std::size_t v = 0; v < truth.size(); ++v) {
        const auto off = [&](const Pose& place) {
          const Pose d = moved * place * truth[v].inverse();
          return size * size * rotation_vector(d.rotation).squaredNorm() + (d * middle - middle).squaredNorm();
        };
        poses.push_back(*std::min_element(places[v].begin(), places[v].end(),
                                          [&](const Pose& a, const Pose& b) { return off(a) < off(b); }));
        if (registration.views[v].status != ViewStatus::refused) sum += off(poses.back());
      }
      if (sum < least) least = sum, best = std::move(poses);
    }
  }
  return best;
}

}  // namespace partscribe::testing::registration
