/// Registration measured on scans with known poses; prints the tables of docs/method/registration.md.
///
///   bench_registration published FILE DEG MM  poses of FILE disturbed, and how far apart the views end up
///   bench_registration unknown FILE           the same with the poses forgotten
///   bench_registration blocks SEED...         blocks and balls without poses, 72 scans of each seed; each to stderr
///   bench_registration paper DIR [CASE...]    the same as cases by the method of 1993
///   bench_registration eight SEED...          parts in eight poses by the method of 1993, its own experiment
///   bench_registration starts DIR [CASE...]   pairs of views from starts 5 to 60 degrees off; what became of each to
///   stderr bench_registration beside DIR [CASE...]   the same pairs beside small_gicp, if the headers were found
///   bench_registration turntable FILE FILE... views by equal steps about an unknown axis
///   bench_registration cases DIR [CASE...]   scans with true poses and disturbed guesses, as `partscribe simulate`
///   writes
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <map>
#include <string>

#include "beside.h"
#include "bound.h"
#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "eight_poses.h"
#include "pairs.h"
#include "scan/filter/filter.h"
#include "scan/read/read.h"
#include "scan/register/register.h"
#include "scan/register/register_joint.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_surface.h"
#include "testing/registration/parts.h"
#include "testing/registration/sides.h"

using namespace partscribe::scan;
using namespace partscribe::testing;

namespace {

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Context& quiet() {
  static Context context;
  context.threads = 2;
  if (std::getenv("VERBOSE")) context.log = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  return context;
}

/// How far poses are off the truth, as one rigid body best laid over it, without the motions that were declared free.
struct PoseErrors {
  double rms_angle = 0, worst_angle = 0;  // degrees
  double rms_shift = 0, worst_shift = 0;  // mm, at the middle of the part
  std::vector<double> angle, shift;
  Vec3 center = Vec3::Zero();  // of the part at the true poses, mm
  Eigen::MatrixXd free;        // the declared motions there, a column each
};

/// Pose errors of all views as one vector of rotation vectors (times `size`) and shifts at `center`.
Eigen::VectorXd error_vector(const std::vector<Pose>& truth, const std::vector<Pose>& found, const Vec3& center,
                             double size) {
  Eigen::VectorXd e(6 * static_cast<Eigen::Index>(truth.size()));
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const Pose d = found[v] * truth[v].inverse();
    e.segment<3>(6 * static_cast<Eigen::Index>(v)) = size * rotation_vector(d.rotation);
    e.segment<3>(6 * static_cast<Eigen::Index>(v) + 3) = d * center - center;
  }
  return e;
}

/// One view's part of a declared motion.
struct ViewMotion {
  Eigen::Index view;  // among those that are registered
  const FreeMotion* motion;
};

/// What is left when all views move alike and every declared motion is followed, as far as it goes, to where that is
/// least, and views that were said to fit on either side of a part are taken on the better one.
PoseErrors errors_of(const std::vector<Pose>& truth, const Registration& registration, double size) {
  const std::vector<Pose> sides = registration::best_sides(truth, registration, size);
  std::vector<Pose> found, there;
  std::vector<ViewMotion> motions;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (registration.views[v].status == ViewStatus::refused) continue;
    for (const FreeMotion& motion : registration.free_motions)
      if (std::find(motion.views.begin(), motion.views.end(), v) != motion.views.end())
        motions.push_back({Eigen::Index(found.size()), &motion});
    found.push_back(sides[v]), there.push_back(truth[v]);
  }
  PoseErrors result;
  if (found.size() < 2) return result;
  const auto views = Eigen::Index(found.size()), free = Eigen::Index(motions.size());
  Pose moved = there[0] * found[0].inverse();  // all views alike; the first is the frame to begin with
  const auto left = [&] {
    std::vector<Pose> now;
    for (const Pose& pose : found) now.push_back(moved * pose);
    return error_vector(there, now, moved * registration.center, size);
  };
  for (int round = 0; round < 30; ++round) {
    const Vec3 center = moved * registration.center;
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(6 * views, 6 + free);
    for (Eigen::Index v = 0; v < views; ++v) j.block<6, 6>(6 * v, 0).setIdentity();
    for (Eigen::Index k = 0; k < free; ++k) {
      const FreeMotion& m = *motions[std::size_t(k)].motion;
      const Vec3 axis = moved.rotation * m.axis;
      if (m.turns)
        j.block<3, 1>(6 * motions[std::size_t(k)].view, 6 + k) = size * axis,
                                                            j.block<3, 1>(6 * motions[std::size_t(k)].view + 3, 6 + k) =
                                                                axis.cross(center - moved * m.point);
      else
        j.block<3, 1>(6 * motions[std::size_t(k)].view + 3, 6 + k) = axis;
    }
    const Eigen::VectorXd step = -j.completeOrthogonalDecomposition().solve(left());
    result.center = center, result.free = j.rightCols(free);
    for (Eigen::Index k = 0; k < free; ++k) {
      const FreeMotion& m = *motions[std::size_t(k)].motion;
      Pose& pose = found[std::size_t(motions[std::size_t(k)].view)];
      pose = (m.turns ? rotation_about(m.point, m.axis, step[6 + k]) : Pose{Mat3::Identity(), step[6 + k] * m.axis}) *
             pose;
    }
    const Mat3 turn = rotation_of(step.head<3>() / size);
    moved = Pose{turn, center + step.segment<3>(3) - turn * center} * moved;
  }
  const Eigen::VectorXd e = left();
  for (Eigen::Index v = 0; v < views; ++v) {
    result.angle.push_back(e.segment<3>(6 * v).norm() / size * 180 / pi),
        result.shift.push_back(e.segment<3>(6 * v + 3).norm());
    result.rms_angle += std::pow(result.angle.back(), 2), result.rms_shift += std::pow(result.shift.back(), 2);
    result.worst_angle = std::max(result.worst_angle, result.angle.back()),
    result.worst_shift = std::max(result.worst_shift, result.shift.back());
  }
  result.rms_angle = std::sqrt(result.rms_angle / double(views)),
  result.rms_shift = std::sqrt(result.rms_shift / double(views));
  return result;
}

/// Degrees and mm that errors have on the root mean square if nothing but noise is in them (pose_bound), of each view
/// that is registered.
struct BoundOfPoses {
  std::vector<double> angle, shift;
};
BoundOfPoses bound_of(const std::vector<RegisterView>& views, const std::vector<Pose>& truth,
                      const Registration& registration, const PoseErrors& errors, double size) {
  std::vector<RegisterView> placed;
  std::vector<Pose> there;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (registration.views[v].status != ViewStatus::refused) placed.push_back(views[v]), there.push_back(truth[v]);
  const Eigen::MatrixXd covariance =
      pose_bound(view_surfaces(placed, 100, quiet(), false), there, errors.center, size, errors.free);
  BoundOfPoses result;
  for (Eigen::Index v = 0; v < Eigen::Index(placed.size()); ++v) {
    result.angle.push_back(std::sqrt(covariance.block<3, 3>(6 * v, 6 * v).trace()) / size * 180 / pi);
    result.shift.push_back(std::sqrt(covariance.block<3, 3>(6 * v + 3, 6 * v + 3).trace()));
  }
  return result;
}

double radius_of(const Scan& scan) { return scan.cloud.bounds().diagonal() / 3.5; }

int refused(const Registration& registration) {
  int count = 0;
  for (const auto& view : registration.views) count += view.status == ViewStatus::refused;
  return count;
}

void cases(const Path& folder, const std::vector<std::string>& names, bool paper) {
  std::printf(
      "| case | views | refused | free motions | rms deg | worst deg | rms mm | worst mm | overlap least | gap mm | s "
      "| bound rms deg | worst view's | bound rms mm |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& name : scans_in(folder, names)) {
    const Path file = folder / name / "scan" / "scan.json";
    const auto exact = read_scan({file}, {}, quiet());
    std::vector<RangeImage> images;
    const auto guess = read_scan({file}, {{}, true}, quiet(), &images);
    if (!exact.ok() || !guess.ok()) {
      std::printf("| %s | not run |\n", name.c_str());
      continue;
    }
    const double start = seconds();
    RegisterOptions options;
    if (paper) options.method = PairMethod::paper;
    const auto result = register_views(views_to_register(*guess, images, quiet()), options, quiet());
    const double spent = seconds() - start;
    if (!result.ok()) {
      std::printf("| %s | %s |\n", name.c_str(), result.error().message.c_str());
      continue;
    }
    std::vector<Pose> truth;
    for (const View& view : exact->views) truth.push_back(view.world_from_view);
    const PoseErrors e = errors_of(truth, *result, radius_of(*exact));
    double overlap = 1;
    for (const auto& view : result->views) overlap = std::min(overlap, view.overlap);
    const BoundOfPoses bound =
        bound_of(views_to_register(*guess, images, quiet()), truth, *result, e, radius_of(*exact));
    const std::size_t worst = std::size_t(std::max_element(e.angle.begin(), e.angle.end()) - e.angle.begin());
    std::printf("| %s | %zu | %d | %zu | %.4f | %.4f | %.4f | %.4f | %.2f | %.4f | %.1f | %.4f | %.4f | %.4f |\n",
                name.c_str(), truth.size(), refused(*result), result->free_motions.size(), e.rms_angle, e.worst_angle,
                e.rms_shift, e.worst_shift, overlap, result->worst_gap, spent, root_mean_square(bound.angle),
                worst < bound.angle.size() ? bound.angle[worst] : 0, root_mean_square(bound.shift));
    if (std::getenv("VERBOSE")) {
      for (const auto& line : result->warnings) std::printf("  %s\n", line.c_str());
      for (std::size_t v = 0; v < e.angle.size() && e.angle.size() == truth.size(); ++v) {
        const Mat6& c = result->views[v].covariance;
        std::printf(
            "  %zu: %.4f deg %.4f mm, bound %.4f deg %.4f mm, sigma %.4f deg %.4f mm, overlap %.3f, through %.4f, %s\n",
            v, e.angle[v], e.shift[v], bound.angle[v], bound.shift[v],
            std::sqrt(c.topLeftCorner<3, 3>().trace()) * 180 / pi, std::sqrt(c.bottomRightCorner<3, 3>().trace()),
            result->views[v].overlap, result->views[v].seen_through, result->views[v].reason.c_str());
      }
    }
    std::fflush(stdout);
  }
}

/// The median distance of each pair of views that overlap, as register_views reports it, at given poses.
std::string gap_at(const std::vector<RegisterView>& views, const std::vector<Pose>& poses) {
  const auto surfaces = view_surfaces(views, 2000, quiet());
  std::vector<double> gaps;
  for (std::size_t a = 0; a < views.size(); ++a)
    for (std::size_t b = 0; b < views.size(); ++b) {
      if (a == b) continue;
      const Pose there = poses[b].inverse() * poses[a];
      std::vector<double> distances;
      for (const auto i : surfaces[a].samples) {
        const Vec3 p = there * surfaces[a].points[i];
        const Neighbour near = surfaces[b].tree->nearest_one(p);
        const Vec3& n = surfaces[b].normals[near.index];
        if (near.sq_distance < 9 && n.dot(there.rotation * surfaces[a].normals[i]) > 0.8)
          distances.push_back(std::abs((p - surfaces[b].points[near.index]).dot(n)));
      }
      if (distances.size() > surfaces[a].samples.size() / 6) gaps.push_back(median(std::move(distances)));
    }
  char text[100];
  std::snprintf(text, sizeof text, "%.3f median, %.3f worst", median(gaps), gaps.empty() ? 0 : quantile(gaps, 0.999));
  return text;
}

/// Views with published poses, disturbed by so much, or forgotten.
void published(const Path& file, double degrees_off, double shift, bool forget) {
  std::vector<RangeImage> images;
  const auto scan = read_scan({file}, {}, quiet(), &images);
  if (!scan.ok()) {
    std::printf("not run: %s\n", scan.error().message.c_str());
    return;
  }
  auto views = views_to_register(*scan, images, quiet());
  std::vector<Pose> truth;
  Random random(5);
  for (RegisterView& view : views) {
    truth.push_back(*view.guess);
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : view.cloud.points) middle += (*view.guess * p) / double(view.cloud.size());
    const auto direction = [&] { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); };
    const Mat3 turn = rotation_of(degrees_off * pi / 180 * direction());
    view.guess = Pose{turn, middle - turn * middle + shift * direction()} * *view.guess;
    if (forget) view.guess.reset();
  }
  RegisterOptions options;
  if (forget) options.arrangement = Arrangement::unknown;
  const double start = seconds();
  const auto result = register_views(views, options, quiet());
  if (!result.ok()) {
    std::printf("%s\n", result.error().message.c_str());
    return;
  }
  const double spent = seconds() - start;
  std::vector<Pose> found;
  for (const auto& view : result->views) found.push_back(view.world_from_view);
  const PoseErrors e = errors_of(truth, *result, radius_of(*scan));
  std::printf("| %s | %s | %d of %zu | %.3f / %.3f | %.3f / %.3f | %s | %s | %.1f |\n",
              file.parent_path().filename().c_str(),
              forget ? "no poses"
                     : (std::to_string(int(degrees_off)) + " deg, " + std::to_string(int(shift)) + " mm off").c_str(),
              int(views.size()) - refused(*result), views.size(), e.rms_angle, e.worst_angle, e.rms_shift,
              e.worst_shift, gap_at(views, found).c_str(), gap_at(views, truth).c_str(), spent);
  for (const auto& line : result->warnings) std::printf("  %s\n", line.c_str());
}

/// What became of scans: all views, or some of them, are placed and right; nothing is placed; wrong, and nothing said
/// so.
struct ScanOutcomes {
  int whole = 0, partly = 0, refused = 0, wrong = 0;
};

/// Parts with few features, scanned with few pixels, of which no pose is known. Right: all placed views within one
/// degree and 2 % of the radius.
void blocks(const std::vector<std::string>& seeds) {
  const std::pair<const char*, Surface> parts[] = {
      {"plain block", registration::plain_block()},
      {"cut block", registration::cut_block()},
      {"balls", registration::balls()},
      {"block alike from two sides", registration::block_alike_from_two_sides(2)},
      {"prism alike from three sides", registration::prism_alike_from_sides(3, 2)}};
  std::printf("| part | whole | partly | refused | wrong |\n|---|---|---|---|---|\n");
  for (const auto& [name, part] : parts) {
    ScanOutcomes of_part;
    for (const std::string& seed : seeds)
      for (const char* arrangement : {"8", "12", "cube"})
        for (const int pixels : {60, 90, 140})
          for (const double noise : {0.02, 0.08}) {
            SimulateOptions scanner;
            scanner.views = arrangement, scanner.resolution = pixels, scanner.sigma = noise, scanner.bit_error = 0.002,
            scanner.seed = std::stoull(seed);
            const SimulatedScan scan = simulate(part, scanner, quiet());
            std::vector<RegisterView> views = views_of(scan.merged);
            std::vector<Pose> truth;
            for (std::size_t v = 0; v < views.size(); ++v)
              truth.push_back(scan.views[v].image.world_from_view), views[v].guess.reset();
            RegisterOptions options;
            options.arrangement = Arrangement::unknown;
            const auto result = register_views(views, options, quiet());
            if (!result.ok()) {
              ++of_part.refused;
              std::fprintf(stderr, "%s, seed %s, views %s, %d pixels, noise %g: %s\n", name, seed.c_str(), arrangement,
                           pixels, noise, result.error().message.c_str());
              continue;
            }
            const double radius = radius_of(scan.merged);
            const PoseErrors e = errors_of(truth, *result, radius);
            const int left_out = refused(*result), of = static_cast<int>(truth.size());
            const bool wrong = e.worst_angle > 1 || e.worst_shift > 0.02 * radius;
            ++(wrong                ? of_part.wrong
               : left_out == 0      ? of_part.whole
               : left_out + 1 == of ? of_part.refused
                                    : of_part.partly);
            std::fprintf(stderr,
                         "%s, seed %s, views %s, %d pixels, noise %g: %s%d of %d placed, %.2f deg %.2f mm, free "
                         "motions %zu, alike %zu\n",
                         name, seed.c_str(), arrangement, pixels, noise, wrong ? "WRONG, " : "", of - left_out, of,
                         e.worst_angle, e.worst_shift, result->free_motions.size(), result->alike.size());
          }
    std::printf("| %s | %d | %d | %d | %d |\n", name, of_part.whole, of_part.partly, of_part.refused, of_part.wrong);
    std::fflush(stdout);
  }
}

/// Files of a turntable's views, in order.
void turntable(const std::vector<std::string>& files) {
  std::vector<RegisterView> views;
  for (const auto& file : files) {
    const auto scan = read_scan({file}, {}, quiet());
    if (!scan.ok()) {
      std::printf("not run: %s\n", scan.error().message.c_str());
      return;
    }
    views.push_back(views_of(*scan)[0]);
    views.back().guess.reset();
  }
  for (const bool correct_depth : {false, true}) {
    RegisterOptions options;
    options.arrangement = Arrangement::turntable, options.correct_depth = correct_depth;
    const double start = seconds();
    const auto result = register_views(views, options, quiet());
    if (!result.ok()) {
      std::printf("%s\n", result.error().message.c_str());
      continue;
    }
    const Turntable& table = *result->turntable;
    std::printf("%s: axis (%.4f, %.4f, %.4f) through (%.2f, %.2f, %.2f), ",
                correct_depth ? "depths corrected" : "as measured", table.axis.x(), table.axis.y(), table.axis.z(),
                table.point.x(), table.point.y(), table.point.z());
    if (table.steps.empty())
      std::printf("step %.3f degrees (sigma %.3f)%s", table.step * 180 / pi, table.step_sigma * 180 / pi,
                  table.step_observed ? "" : " not observed");
    else
      std::printf("steps");
    for (const double step : table.steps) std::printf(" %.2f", step * 180 / pi);
    std::printf(", %d of %zu registered, worst gap %.3f mm, %.1f s\n", int(views.size()) - refused(*result),
                views.size(), result->worst_gap, seconds() - start);
    for (std::size_t v = 1; v < views.size(); ++v) {
      const RegisteredView& view = result->views[v];
      std::printf("  view %zu: overlap %.2f, median distance %.3f mm\n", v, view.overlap, view.residual_median);
    }
    for (const auto& line : result->warnings) std::printf("  %s\n", line.c_str());
  }
}

/// What became of pairs; a pair apart from motions that were declared counts as declared.
struct Outcomes {
  int recovered = 0, declared = 0, refused = 0, wrong = 0;
};

/// Right: within one degree and 2 % of the radius.
void starts(const Path& folder, const std::vector<std::string>& names) {
  std::map<std::pair<int, int>, Outcomes> table;  // overlap in fifths, start in degrees
  Outcomes all;
  const double begin = seconds();
  for (const auto& name : scans_in(folder, names))
    for (const PairCase& pair : pair_cases(folder / name / "scan" / "scan.json", name, 1, quiet())) {
      const int off = degrees_off(pair);
      RegisterOptions options;
      options.guess_angle = pair.start + 0.1;
      const auto result = register_views({pair.first, pair.second}, options, quiet());
      if (!result.ok()) continue;
      const PairError e = pair_error(pair, result->views[1].world_from_view, result->free_motions);
      const char* word = "";
      const auto count = [&](int Outcomes::*kind, const char* said) {
        ++(table[{std::min(4, int(pair.overlap * 5)), off}].*kind), ++(all.*kind), word = said;
      };
      if (refused(*result) > 0)
        count(&Outcomes::refused, "refused");
      else if (!is_right(pair, e))
        count(&Outcomes::wrong, "wrong");
      else if (!result->free_motions.empty())
        count(&Outcomes::declared, "declared");
      else
        count(&Outcomes::recovered, "recovered");
      std::fprintf(stderr, "%s, overlap %.2f, from %d: %s, %.2f deg %.2f mm of %.1f", pair.name.c_str(), pair.overlap,
                   off, word, e.angle * 180 / pi, e.shift, pair.radius);
      for (const auto& line : result->warnings) std::fprintf(stderr, "; %s", line.c_str());
      std::fprintf(stderr, "\n");
    }
  std::printf("| overlap | start 5 deg | 15 | 30 | 60 |\n|---|---|---|---|---|\n");
  for (int fifth = 1; fifth <= 4; ++fifth) {
    std::printf("| %d-%d %% |", 20 * fifth, 20 * fifth + 20);
    for (const int off : {5, 15, 30, 60}) {
      const Outcomes c = table[{fifth, off}];
      std::printf(" %d / %d / %d / %d |", c.recovered, c.declared, c.refused, c.wrong);
    }
    std::printf("\n");
  }
  std::printf("recovered %d, apart from declared motions %d, refused %d, wrong %d; %.0f s\n", all.recovered,
              all.declared, all.refused, all.wrong, seconds() - begin);
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  if (words.size() >= 2 && (words[0] == "cases" || words[0] == "paper"))
    return cases(words[1], {words.begin() + 2, words.end()}, words[0] == "paper"), 0;
  if (words.size() == 4 && words[0] == "published")
    return published(words[1], std::stod(words[2]), std::stod(words[3]), false), 0;
  if (words.size() == 2 && words[0] == "unknown") return published(words[1], 0, 0, true), 0;
  if (words.size() >= 2 && words[0] == "blocks") return blocks({words.begin() + 1, words.end()}), 0;
  if (words.size() >= 2 && words[0] == "eight") return eight_poses_of_1993({words.begin() + 1, words.end()}), 0;
  if (words.size() >= 3 && words[0] == "turntable") return turntable({words.begin() + 1, words.end()}), 0;
  if (words.size() >= 2 && words[0] == "starts") return starts(words[1], {words.begin() + 2, words.end()}), 0;
  if (words.size() >= 2 && words[0] == "beside") return beside(words[1], {words.begin() + 2, words.end()}), 0;
  if (words.size() == 2 && words[0] == "basin") return basin(words[1]), 0;
  std::fprintf(stderr,
               "usage: bench_registration cases|paper|starts|beside DIR [CASE...] | basin FILE | published FILE DEG MM "
               "| unknown FILE | blocks SEED... | eight SEED... | turntable FILE...\n");
  return 2;
}
