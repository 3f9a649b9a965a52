#include "testing/registration/cases.h"

#include <algorithm>
#include <stdexcept>

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

Case scan_in_poses(const Surface& surface, const std::vector<Pose>& poses, SimulateOptions options, double angle,
                   double shift) {
  Case result;
  options.views = "1", options.tilt = 0;
  const std::uint64_t seed = options.seed;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    options.seed = 100 * seed + k;
    Case one = scan_of(posed(surface, poses[k]), options, angle, shift);
    const Pose back = poses[k].inverse();
    one.views[0].guess = back * *one.views[0].guess;
    one.views[0].name = "pose " + std::to_string(k);
    result.views.push_back(std::move(one.views[0])), result.truth.push_back(back * one.truth[0]);
  }
  return result;
}

std::vector<Pose> eight_poses(double step, double above) {
  std::vector<Pose> poses;
  for (int k = 0; k < 8; ++k)
    poses.push_back({rotation_of(above * Vec3::UnitX()) * rotation_of(step * k * Vec3::UnitY()), Vec3::Zero()});
  return poses;
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
  if (!result.ok()) throw std::runtime_error(result.error().message);  // a test fails by it; measurements have no Catch
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
