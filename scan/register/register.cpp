#include "scan/register/register.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/ensure.h"
#include "core/number.h"
#include "geometry/points/kd_tree.h"
#include "scan/register/as_published/register_as_published.h"
#include "scan/register/register_alike.h"
#include "scan/register/register_free.h"
#include "scan/register/register_joint.h"
#include "scan/register/register_judge.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_start.h"
#include "scan/register/register_turntable.h"
#include "scan/register/register_words.h"

namespace partscribe::scan {
namespace {

std::string place_text(const Vec3& v, double resolution) {
  return "(" + in_steps(v.x(), resolution) + ", " + in_steps(v.y(), resolution) + ", " + in_steps(v.z(), resolution) +
         ")";
}

std::string name_of(const std::vector<RegisterView>& views, std::size_t v) {
  return views[v].name.empty() ? std::to_string(v) : views[v].name;
}

/// Along free motions views stay where they were guessed to be, and nobody said how good the guesses are.
Eigen::MatrixXd with_free_motions(const JointResult& joint) {
  constexpr double guess_share = 0.02;  // of the part's size
  Eigen::MatrixXd result = joint.covariance;
  for (const Eigen::VectorXd& direction : joint.free_directions) {
    Eigen::VectorXd step = guess_share * joint.size / largest_of_a_view(direction) * direction;
    for (Eigen::Index i = 0; i < step.size(); i += 6) step.segment<3>(i) /= joint.size;
    result += step * step.transpose();
  }
  return result;
}

/// "view 2" or "views 2, 3".
std::string names_of(const std::vector<RegisterView>& views, const std::vector<std::size_t>& some) {
  std::string names;
  for (const std::size_t v : some) names += (names.empty() ? "" : ", ") + name_of(views, v);
  return (some.size() == 1 ? "view " : "views ") + names;
}

void name_motions(const std::vector<RegisterView>& views, std::vector<FreeMotion>& motions) {
  for (FreeMotion& motion : motions) {
    motion.words = names_of(views, motion.views) + (motion.turns ? " turn about " : " slide along ") +
                   place_text(motion.axis, 0.001) + (motion.turns ? " through " + place_text(motion.point, 0.01) : "");
  }
}

std::vector<AlikePlaces> alike_places(const std::vector<RegisterView>& views, const AlikeSides& sides,
                                      const Vec3& center) {
  std::vector<AlikePlaces> result;
  for (const AlikeTurn& alike : sides.turns) {
    if (alike.open.empty()) continue;
    const FixedLine line = fixed_line(alike.turn, center);
    result.push_back({alike.open, line.angle, line.axis, line.point,
                      names_of(views, alike.open) + (alike.open.size() == 1 ? " fits" : " fit") +
                          " as well turned by " + in_degrees(line.angle) + " degrees about " +
                          place_text(line.axis, 0.001) + " through " + place_text(line.point, 0.01)});
  }
  return result;
}

/// Of a part that a sixth or a quarter of a turn lays onto itself views of different sides are the same picture, and
/// contradict nobody where they come to lie upon one another, most of them: of a prism all alike four upper and four
/// lower views stood 8 to 18 degrees apart instead of 71.
bool upon_one_another(const AlikeSides& alike, const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& poses,
                      const std::vector<std::size_t>& views) {
  constexpr double half = 0.97 * pi;
  const double near = std::cos(radians(25));
  if (std::none_of(alike.turns.begin(), alike.turns.end(), [](const AlikeTurn& t) {
        return !t.open.empty() && rotation_vector(t.turn.rotation).norm() < half;
      }))
    return false;
  const auto sight = [&](std::size_t v) {
    return Vec3(poses[v].rotation * surfaces[v].raster.ray(surfaces[v].center));
  };
  const auto close = std::count_if(views.begin(), views.end(), [&](std::size_t v) {
    return std::any_of(views.begin(), views.end(),
                       [&](std::size_t w) { return w != v && sight(v).dot(sight(w)) > near; });
  });
  return 2 * static_cast<std::size_t>(close) >= views.size();
}

bool as_published(const RegisterOptions& options) { return options.method != PairMethod::symmetric; }

std::optional<Error> check(const std::vector<RegisterView>& views, const RegisterOptions& options) {
  if (as_published(options) && options.arrangement != Arrangement::guessed)
    return usage_error("expected guesses of the poses for registration as published, found another arrangement");
  std::size_t points = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    points += views[v].cloud.size();
    if (options.arrangement == Arrangement::guessed && !views[v].guess)
      return usage_error("view " + std::to_string(v) + " (" + views[v].name +
                         "): expected a guess of its pose, found none; register it as of unknown pose");
    for (const Vec3& p : views[v].cloud.points)
      if (!p.allFinite())
        return bad_input("view " + std::to_string(v) + " (" + views[v].name +
                         "): expected finite coordinates, found some that are not");
  }
  if (points == 0) return bad_input("expected views with points, found none");
  return {};
}

/// `world_from_view`: from the frame in which the point was measured to that of the cloud.
void correct_depth(const DepthCorrection& depth, const Pose& world_from_view, PointCloud& cloud, std::size_t i) {
  const Pose view_from_world = world_from_view.inverse();
  cloud.points[i] = world_from_view * (depth * (view_from_world * cloud.points[i]));
  const auto turned = [&](Vec3& v, const Mat3& linear) {
    v = world_from_view.rotation * (linear * (view_from_world.rotation * v)).normalized();
  };
  if (!cloud.normals.empty()) turned(cloud.normals[i], depth.linear.inverse().transpose());
  if (!cloud.rays.empty()) turned(cloud.rays[i], depth.linear);
}

/// Views whose depths were corrected, as if they had been measured so.
std::vector<RegisterView> corrected(std::vector<RegisterView> views, const DepthCorrection& depth) {
  for (RegisterView& view : views) {
    for (std::size_t i = 0; i < view.cloud.size(); ++i) correct_depth(depth, {}, view.cloud, i);
    for (Vec3& p : view.measured) p = depth * p;
  }
  return views;
}

}  // namespace

std::vector<RegisterView> views_of(const Scan& scan, const std::vector<Vec3>& measured) {
  std::vector<RegisterView> views(scan.views.size());
  std::vector<Pose> from_world;
  for (std::size_t v = 0; v < views.size(); ++v) {
    views[v].name = scan.views[v].file, views[v].guess = scan.views[v].world_from_view;
    views[v].width = scan.views[v].width, views[v].height = scan.views[v].height;
    from_world.push_back(scan.views[v].world_from_view.inverse());
  }
  const PointCloud& all = scan.cloud;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::int32_t v = all.view.empty() ? 0 : all.view[i];
    if (v < 0 || static_cast<std::size_t>(v) >= views.size()) continue;
    RegisterView& view = views[static_cast<std::size_t>(v)];
    PointCloud& cloud = view.cloud;
    const Pose& pose = from_world[static_cast<std::size_t>(v)];
    cloud.points.push_back(pose * all.points[i]);
    if (!measured.empty()) view.measured.push_back(pose * measured[i]);
    if (!all.normals.empty()) cloud.normals.push_back(pose.rotation * all.normals[i]);
    if (!all.rays.empty()) cloud.rays.push_back(pose.rotation * all.rays[i]);
    if (!all.sigma.empty()) cloud.sigma.push_back(all.sigma[i]);
    if (!all.pixel.empty()) cloud.pixel.push_back(all.pixel[i]);
    if (!all.rejected.empty()) cloud.rejected.push_back(all.rejected[i]);
  }
  return views;
}

void place_views(const Registration& registration, Scan& scan) {
  ensure(registration.views.size() == scan.views.size(), "the registration must be of this scan's views");
  std::vector<Pose> before, change;
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    before.push_back(scan.views[v].world_from_view);
    change.push_back(registration.views[v].world_from_view * scan.views[v].world_from_view.inverse());
    scan.views[v].world_from_view = registration.views[v].world_from_view;
  }
  scan.pose_covariance = {registration.center, registration.covariance};
  PointCloud& cloud = scan.cloud;
  std::size_t kept = 0;
  const auto keep = [&](auto& column, std::size_t i) {
    if (!column.empty()) column[kept] = column[i];
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::int32_t v = cloud.view.empty() ? 0 : cloud.view[i];
    if (v < 0 || static_cast<std::size_t>(v) >= change.size() ||
        registration.views[static_cast<std::size_t>(v)].status == ViewStatus::refused)
      continue;
    if (registration.depth) correct_depth(*registration.depth, before[static_cast<std::size_t>(v)], cloud, i);
    const Pose& pose = change[static_cast<std::size_t>(v)];
    cloud.points[kept] = pose * cloud.points[i];
    if (!cloud.normals.empty()) cloud.normals[kept] = pose.rotation * cloud.normals[i];
    if (!cloud.rays.empty()) cloud.rays[kept] = pose.rotation * cloud.rays[i];
    keep(cloud.sigma, i), keep(cloud.view, i), keep(cloud.pixel, i), keep(cloud.rejected, i);
    ++kept;
  }
  cloud.points.resize(kept);
  const auto cut = [&](auto& column) {
    if (!column.empty()) column.resize(kept);
  };
  cut(cloud.normals), cut(cloud.rays), cut(cloud.sigma), cut(cloud.view), cut(cloud.pixel), cut(cloud.rejected);
}

std::vector<std::uint8_t> floating_points(const Registration& registration, const PointCloud& cloud, double reach) {
  ensure(cloud.normals.size() == cloud.size() && cloud.view.size() == cloud.size(),
         "what floats is told by normals and views");
  constexpr double along_normal = 0.15;  // of the motion; normals of noisy points are off by some degrees
  constexpr double same_face = 0.7;      // cosine
  constexpr std::size_t nearby = 6;
  std::vector<std::uint8_t> floating(cloud.size(), 0);
  const std::size_t n = registration.views.size();
  std::size_t placed = 0;
  for (const RegisteredView& v : registration.views) placed += v.status != ViewStatus::refused;
  for (const FreeMotion& motion : registration.free_motions) {
    std::vector<std::uint8_t> moves(n, 0);
    for (const std::size_t v : motion.views) moves[v] = 1;
    if (2 * motion.views.size() > placed)
      for (auto& m : moves) m = !m;
    std::vector<std::uint32_t> loose;
    std::vector<Vec3> still, facing;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto v = static_cast<std::size_t>(cloud.view[i]);
      if (v >= n || floating[i]) continue;
      const Vec3 way = motion.turns ? Vec3(motion.axis.cross(cloud.points[i] - motion.point)) : motion.axis;
      if (!moves[v])
        still.push_back(cloud.points[i]), facing.push_back(cloud.normals[i]);
      else if (std::abs(way.dot(cloud.normals[i])) > along_normal * way.norm())
        loose.push_back(static_cast<std::uint32_t>(i));
    }
    if (loose.empty() || still.empty()) continue;
    const KdTree tree(still);
    std::vector<Neighbour> near;
    for (const auto i : loose) {
      tree.nearest(cloud.points[i], nearby, near);
      for (const Neighbour& k : near)
        if (k.sq_distance < reach * reach && facing[k.index].dot(cloud.normals[i]) > same_face) floating[i] = 1;
    }
  }
  return floating;
}

Result<Registration> register_views(const std::vector<RegisterView>& views, const RegisterOptions& options,
                                    Context& context) {
  if (auto error = check(views, options)) return *error;
  const Error stopped{"stopped while registering views", ErrorKind::stopped};
  const bool contours =
      options.contours && views.size() > 2;  // of two views nothing would tell which face a border belongs to
  std::vector<ViewSurface> surfaces = view_surfaces(views, options.samples, context, contours);
  if (context.cancelled) return stopped;
  std::vector<Pose> guesses;
  for (const RegisterView& view : views) guesses.push_back(view.guess.value_or(Pose{}));
  Registration result;
  StartResult start;
  if (options.arrangement == Arrangement::turntable) {
    auto table = start_from_turntable(views, surfaces, contours, options, context);
    if (context.cancelled) return stopped;
    if (!table) return table.error();
    start = std::move(table->start), result.turntable = table->table;
    if (!table->trouble.empty()) result.warnings.push_back(table->trouble);
    if (table->depth)
      result.depth = table->depth,
      surfaces = view_surfaces(corrected(views, *table->depth), options.samples, context, contours);
  } else if (as_published(options)) {
    start = register_as_published(surfaces, guesses,
                                  options.method == PairMethod::paper ? PaperOptions{} : free_form_options(), context);
  } else {
    start = options.arrangement == Arrangement::guessed ? start_from_guesses(surfaces, guesses, options, context)
                                                        : start_from_features(surfaces, options, context);
  }
  if (context.cancelled) return stopped;

  result.views.resize(views.size());
  std::vector<std::size_t> used;
  double step = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.views[v].world_from_view = start.poses[v];
    if (start.placed[v])
      used.push_back(v), step = std::max(step, 6 * surfaces[v].spacing);
    else
      result.views[v].reason = start.reason[v];
  }
  if (used.empty()) return bad_input("expected a view with smooth surface on it, found none");
  JointResult joint;
  joint.poses = start.poses;
  // A refused view has pulled at the others: they are adjusted again without it.
  JointOptions adjust;
  adjust.start_reach = step, adjust.contours = options.contours;
  if (as_published(options)) adjust.rounds = 0;  // poses stay as published; only what they are worth is found
  AlikeSides alike;
  std::vector<std::uint8_t> asked_again(views.size(), 0);
  for (int changes_of_side = 4;;) {
    joint = adjust_jointly(surfaces, joint.poses, used, adjust, context);
    if (context.cancelled) return stopped;
    result.free_motions = free_motions(joint, start.joined, used);
    const std::vector<std::size_t> good =
        judge_views(surfaces, joint, used, result.free_motions, options, result.views);
    if (good.size() < used.size()) {
      used = good;
      continue;
    }
    if (options.arrangement == Arrangement::guessed && !as_published(options) && used.size() > 1) {
      std::vector<std::size_t> refused;
      for (std::size_t v = 0; v < views.size(); ++v)
        if (!asked_again[v] && std::find(used.begin(), used.end(), v) == used.end())
          refused.push_back(v), asked_again[v] = 1;
      if (refused.empty()) break;
      start.poses = joint.poses;
      const std::vector<std::size_t> back = placed_after_all(surfaces, guesses, options, used, refused, start, context);
      if (back.empty()) break;
      joint.poses = start.poses;
      used.insert(used.end(), back.begin(), back.end());
      std::sort(used.begin(), used.end());
      continue;
    }
    if (options.arrangement != Arrangement::unknown) break;
    alike = alike_sides(surfaces, joint.poses, used, context);
    if (context.cancelled) return stopped;
    if (changes_of_side-- == 0 || alike.better.empty()) break;
    joint.poses = alike.better;
  }
  if (!joint.free_directions.empty() && adjust.rounds > 0) {
    adjust.start_reach = step / 2;
    result.free_motions = followed_motions(surfaces, joint, start.joined, used, adjust, context);
    if (context.cancelled) return stopped;
  }
  if (options.arrangement == Arrangement::unknown) {
    // Without guesses a few views may agree by chance. Which side a view shows is told by others, and those that slide
    // lie where they contradict nobody: of a prism three views of eight came out a third of a turn round so.
    const bool sides_open = alike.any_open(), enough = enough_agree(used.size(), views.size(), sides_open);
    const bool on_sides = std::any_of(used.begin(), used.end(), [&](std::size_t v) { return start.on_a_side[v] != 0; });
    const bool some_slide = std::any_of(result.free_motions.begin(), result.free_motions.end(),
                                        [&](const FreeMotion& m) { return 2 * m.views.size() < used.size(); });
    const bool sides_known = alike.better.empty() && (!on_sides || (!some_slide && !alike.turns.empty())) &&
                             !upon_one_another(alike, surfaces, joint.poses, used);
    for (const std::size_t v : used) {
      if (v == used.front() || (enough && sides_known)) continue;
      result.views[v].status = ViewStatus::refused;
      result.views[v].reason =
          enough ? "the part looks alike from several sides, and nothing tells which of them each view shows"
                 : "only " + std::to_string(used.size()) + " of " + std::to_string(views.size()) +
                       " views agree, expected " + enough_in_words(sides_open) + " where no poses are known";
    }
    if (enough && sides_known) result.alike = alike_places(views, alike, joint.center);
  }
  result.center = joint.center, result.covariance = with_free_motions(joint);
  for (const auto& row : joint.gap)
    for (const double gap : row) result.worst_gap = std::max(result.worst_gap, gap);
  name_motions(views, result.free_motions);
  if (result.turntable && !result.turntable->steps.empty() && used.size() == views.size())
    *result.turntable = table_of(joint.poses, surfaces[0].center);
  // The last view has turned by all the steps together.
  if (result.turntable && result.turntable->step_observed)
    result.turntable->step_sigma = std::sqrt(joint.covariance_of(used.back()).topLeftCorner<3, 3>().trace() / 3) /
                                   std::max(1.0, double(used.back()));
  if (result.turntable && !result.turntable->step_observed)
    result.warnings.push_back(
        "the part is round about the axis of the table: the steps cannot be seen and are taken as equal parts of one "
        "turn");
  for (const FreeMotion& motion : result.free_motions)
    result.warnings.push_back("the data do not fix that " + motion.words);
  for (const AlikePlaces& places : result.alike)
    result.warnings.push_back("the part looks alike from several sides: " + places.words);
  for (std::size_t v = 0; v < views.size(); ++v)
    if (result.views[v].status == ViewStatus::refused)
      result.warnings.push_back("view " + name_of(views, v) + " is not registered: " + result.views[v].reason);
  context.say("surfaces " + print_number(joint.surface_sigma) + " mm in " + std::to_string(joint.surface_matches) +
              " matches, contours " + print_number(joint.contour_sigma) + " px (bias " +
              print_number(joint.contour_bias) + ") in " + std::to_string(joint.contour_matches));
  return result;
}

}  // namespace partscribe::scan
