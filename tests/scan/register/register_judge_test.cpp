/// Which views may be used where they have come to lie, and why others may not.
#include "scan/register/register_judge.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/number.h"
#include "scan/register/register_free.h"
#include "testing/registration/cases.h"

using namespace partscribe::scan;
using namespace partscribe::testing::registration;

namespace {

struct Scene {
  Case scan;
  std::vector<ViewSurface> surfaces;
  std::vector<std::size_t> all;
};

Scene scene_of(Case scan) {
  Context context;
  std::vector<ViewSurface> surfaces = view_surfaces(scan.views, 2500, context, false);
  std::vector<std::size_t> all(surfaces.size());
  std::iota(all.begin(), all.end(), 0);
  return {std::move(scan), std::move(surfaces), std::move(all)};
}

/// What is known of views that stay at these poses, which count as exact.
JointResult known_of(const Scene& scene, const std::vector<Pose>& poses) {
  JointOptions stay;
  stay.rounds = 0, stay.contours = false;
  Context context;
  JointResult joint = adjust_jointly(scene.surfaces, poses, scene.all, stay, context);
  joint.covariance.setZero();
  return joint;
}

std::vector<RegisteredView> judged(const Scene& scene, const JointResult& joint, Arrangement arrangement) {
  RegisterOptions options;
  options.arrangement = arrangement;
  std::vector<RegisteredView> views(scene.all.size());
  judge_views(scene.surfaces, joint, scene.all, {}, options, views);
  return views;
}

std::size_t refused(const std::vector<RegisteredView>& views) {
  return static_cast<std::size_t>(std::count_if(
      views.begin(), views.end(), [](const RegisteredView& v) { return v.status == ViewStatus::refused; }));
}

bool says(const RegisteredView& view, const char* words) {
  return view.status == ViewStatus::refused && view.reason.find(words) != std::string::npos;
}

std::vector<Side> prism(int sides, double radius, double low, double high) {
  std::vector<Side> result{{Vec3::UnitZ(), high}, {-Vec3::UnitZ(), -low}};
  for (int k = 0; k < sides; ++k)
    result.push_back({Vec3(std::cos(2 * pi * k / sides), std::sin(2 * pi * k / sides), 0), radius});
  return result;
}

/// A prism on a wider one, seen from around and from both ends: no view shows a side and an end.
Scene tower_from_around() {
  Surface both = convex(prism(12, 16, -16, -4), 20);
  both.first_hit = nearer_of(both.first_hit, convex(prism(12, 9, -5, 14), 20).first_hit);
  SimulateOptions scanner = small();
  scanner.views = "100", scanner.tilt = 0;
  const Case all = scan_of(both, scanner, 0, 0);
  Case some;
  std::vector<Vec3> taken;
  for (std::size_t v = 0; v < all.views.size(); ++v) {
    const Vec3 sight = all.truth[v].rotation.col(2);
    const bool level = std::abs(sight.z()) < 0.17;  // beyond 78 degrees nothing returns
    if (!level && std::abs(sight.z()) < 0.985) continue;
    if (level && std::any_of(taken.begin(), taken.end(), [&](const Vec3& t) { return t.dot(sight) > 0.8; })) continue;
    if (level) taken.push_back(sight);
    some.views.push_back(all.views[v]), some.truth.push_back(all.truth[v]);
  }
  return scene_of(some);
}

}  // namespace

TEST_CASE("judge: views at their true poses may be used, whatever was known of them") {
  for (const Surface& part : {cut_block(), balls()}) {
    const Scene scene = scene_of(scan_of(part, small(), 0, 0));
    const JointResult joint = known_of(scene, scene.scan.truth);
    for (const Arrangement known : {Arrangement::guessed, Arrangement::unknown}) {
      const auto views = judged(scene, joint, known);
      for (const RegisteredView& view : views) UNSCOPED_INFO(view.reason);
      CHECK(refused(views) == 0);
    }
  }
}

TEST_CASE("judge: without guesses hardly anything may have been looked through") {
  // A drum with a post: where a view is turned about the drum, two hundredths of it stand where another looked past.
  SimulateOptions scanner = small();
  scanner.resolution = 140;
  const Scene scene = scene_of(
      scan_of(drum_with({{{9, 0, 3}, 4.5}, {{12, 0, 3}, 4.5}, {{15, 0, 3}, 4.5}, {{18, 0, 3}, 4.5}}, {23, 23, 15}),
              scanner, 0, 0));
  constexpr std::size_t turned = 1;
  std::vector<Pose> poses = scene.scan.truth;
  poses[turned] = Pose{rotation_of(0.4 * Vec3::UnitZ()), Vec3::Zero()} * poses[turned];
  const JointResult joint = known_of(scene, poses);
  const auto guessed = judged(scene, joint, Arrangement::guessed);
  INFO(guessed[turned].reason);
  CHECK(guessed[turned].seen_through > 0.015);
  CHECK(guessed[turned].status == ViewStatus::registered);
  CHECK(says(judged(scene, joint, Arrangement::unknown)[turned], "looked through"));
}

TEST_CASE("judge: without guesses a view on a wrong face is told by what faces sensors that saw nothing there") {
  // A block of equal corners: a view slid along what it sees still lies on faces.
  SimulateOptions scanner = small();
  scanner.views = "12";
  const Scene scene = scene_of(scan_of(convex(block_sides({14, 17, 20}), 22), scanner, 0, 0));
  constexpr std::size_t slid = 11;
  std::vector<Pose> poses = scene.scan.truth;
  const ViewSurface& surface = scene.surfaces[slid];
  poses[slid] =
      Pose{Mat3::Identity(), 0.2 * surface.radius * (poses[slid].rotation * surface.raster.axes.col(0))} * poses[slid];
  const JointResult joint = known_of(scene, poses);
  CHECK(says(judged(scene, joint, Arrangement::unknown)[slid], "saw nothing there"));
  CHECK(judged(scene, joint, Arrangement::guessed)[slid].status == ViewStatus::registered);
}

TEST_CASE(
    "judge: a pose that is hardly known is no pose where nobody guessed it, nor one that a handful of places hold") {
  const Scene scene = scene_of(scan_of(cut_block(), small(), 0, 0));
  const JointResult known = known_of(scene, scene.scan.truth);
  constexpr std::size_t view = 3;
  JointResult joint = known;
  const auto sigma_of_size = [&](double share) {
    joint.covariance(6 * view + 5, 6 * view + 5) = std::pow(share * joint.size, 2);
  };
  sigma_of_size(0.019);
  CHECK(refused(judged(scene, joint, Arrangement::unknown)) == 0);
  sigma_of_size(0.021);
  CHECK(refused(judged(scene, joint, Arrangement::guessed)) == 0);
  const auto views = judged(scene, joint, Arrangement::unknown);
  CHECK(refused(views) == 1);
  CHECK(says(views[view], "mm only, and no guess says where it lies"));

  joint = known, joint.matches[view] = 49;
  CHECK(says(judged(scene, joint, Arrangement::guessed)[view],
             "only 49 places of its surface lie on that of other views, expected 50"));
}

TEST_CASE(
    "judge: views that are free together are moved to where nothing contradicts them, and stay where nothing does") {
  const Scene scene = tower_from_around();
  Context context;
  CHECK_FALSE(any_in_trouble(scene.surfaces, scene.scan.truth, scene.all));
  const auto same = freed_of_contradictions(scene.surfaces, scene.scan.truth, scene.all, false, context);
  for (const std::size_t v : scene.all) CHECK((same[v].translation - scene.scan.truth[v].translation).norm() == 0);
  // The views from around see the tower 3 mm too low: the one from above saw nothing of it where they put its foot.
  std::vector<Pose> poses = scene.scan.truth;
  for (Pose& pose : poses)
    if (std::abs(pose.rotation.col(2).z()) < 0.5) pose.translation.z() -= 3;
  CHECK(any_in_trouble(scene.surfaces, poses, scene.all));
  const auto freed = freed_of_contradictions(scene.surfaces, poses, scene.all, false, context);
  CHECK_FALSE(any_in_trouble(scene.surfaces, freed, scene.all));
}
