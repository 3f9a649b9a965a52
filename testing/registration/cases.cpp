#include "testing/registration/cases.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "scan/register/register_pair.h"
#include "testing/registration/sides.h"

namespace partscribe::testing::registration {

Case scan_of(const Surface& surface, SimulateOptions options, double angle, double shift) {
  options.pose_noise_angle = angle, options.pose_noise_shift = shift;
  Context context;
  context.threads = 2;
  const SimulatedScan scan = simulate(surface, options, context);
  Case result{views_of(scan.merged), {}};
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    result.truth.push_back(scan.views[v].image.world_from_view);
    result.views[v].guess = scan.views[v].initial_guess;
  }
  return result;
}

SimulateOptions small() {
  SimulateOptions options;
  options.views = "cube", options.resolution = 72, options.sigma = 0.02, options.bit_error = 0.002;
  return options;
}

Registration run(const std::vector<RegisterView>& views, const RegisterOptions& options, int threads) {
  Context context;
  context.threads = threads;
  const auto result = register_views(views, options, context);
  REQUIRE(result.ok());
  return *result;
}

Off off_truth(const Registration& found, const std::vector<Pose>& truth) {
  std::size_t reference = 0;
  while (found.views[reference].status != ViewStatus::reference) ++reference;
  constexpr double size = 20;
  const std::vector<Pose> poses = best_sides(truth, found, size);
  const Pose back = truth[reference] * poses[reference].inverse();
  Off worst;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (found.views[v].status == ViewStatus::refused) continue;
    const Pose d = back * poses[v] * truth[v].inverse();
    worst.angle = std::max(worst.angle, rotation_vector(d.rotation).norm());
    worst.shift = std::max(worst.shift, (d * Vec3(0, 0, 0)).norm());
  }
  return worst;
}

Registration run_from_nothing(Case scan) {
  RegisterOptions unknown;
  unknown.arrangement = Arrangement::unknown;
  for (auto& view : scan.views) view.guess.reset();
  return run(scan.views, unknown);
}

int count(const Registration& registration, ViewStatus status) {
  return static_cast<int>(std::count_if(registration.views.begin(), registration.views.end(),
                                        [&](const auto& v) { return v.status == status; }));
}

}  // namespace partscribe::testing::registration
