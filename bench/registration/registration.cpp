/// Registration measured on scans with known poses; prints the tables of docs/registration.md.
///
///   bench_registration cases DIR [CASE...]   scans with true poses and disturbed guesses, as `partscribe simulate` writes
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <string>

#include "core/number.h"
#include "core/statistics.h"
#include "scan/read.h"
#include "scan/register.h"
#include "scan/register_joint.h"
#include "scan/register_pair.h"

using namespace partscribe;

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
};

/// Pose errors of all views as one vector of rotation vectors (times `size`) and shifts at `center`.
Eigen::VectorXd error_vector(const std::vector<Pose>& truth, const std::vector<Pose>& found, const Vec3& center, double size) {
  Eigen::VectorXd e(6 * static_cast<Eigen::Index>(truth.size()));
  for (std::size_t v = 0; v < truth.size(); ++v) {
    const Pose d = found[v] * truth[v].inverse();
    e.segment<3>(6 * static_cast<Eigen::Index>(v)) = size * rotation_vector(d.rotation);
    e.segment<3>(6 * static_cast<Eigen::Index>(v) + 3) = d * center - center;
  }
  return e;
}

/// The least squares of what is left when all views move alike and every declared motion is taken out.
PoseErrors errors_of(const std::vector<Pose>& truth, const Registration& registration, double size) {
  std::vector<Pose> found, there;
  std::vector<std::size_t> index;
  for (std::size_t v = 0; v < truth.size(); ++v)
    if (registration.views[v].status != ViewStatus::refused)
      found.push_back(registration.views[v].world_from_view), there.push_back(truth[v]), index.push_back(v);
  PoseErrors result;
  if (found.size() < 2) return result;
  // The first view is the frame; the rest is small then.
  const Pose shift = there[0] * found[0].inverse();
  for (Pose& pose : found) pose = shift * pose;
  const Vec3 center = shift * registration.center;
  Eigen::VectorXd e = error_vector(there, found, center, size);
  std::vector<Eigen::VectorXd> basis;
  for (int k = 0; k < 6; ++k) {
    Eigen::VectorXd same = Eigen::VectorXd::Zero(e.size());
    for (Eigen::Index v = 0; v < e.size() / 6; ++v) same[6 * v + k] = 1;
    basis.push_back(same);
  }
  for (const FreeMotion& motion : registration.free_motions) {
    const Vec3 axis = shift.rotation * motion.axis, point = shift * motion.point;
    for (const std::size_t moved : motion.views) {
      Eigen::VectorXd free = Eigen::VectorXd::Zero(e.size());
      for (std::size_t k = 0; k < index.size(); ++k)
        if (index[k] == moved) {
          const auto i = 6 * static_cast<Eigen::Index>(k);
          if (motion.turns) free.segment<3>(i) = size * axis, free.segment<3>(i + 3) = axis.cross(center - point);
          else free.segment<3>(i + 3) = axis;
        }
      if (free.norm() > 0) basis.push_back(free);
    }
  }
  for (std::size_t a = 0; a < basis.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) basis[a] -= basis[b].dot(basis[a]) * basis[b];
    if (basis[a].norm() < 1e-3) { basis[a].setZero(); continue; }
    basis[a].normalize();
    e -= basis[a].dot(e) * basis[a];
  }
  for (Eigen::Index v = 0; v < e.size() / 6; ++v) {
    result.angle.push_back(e.segment<3>(6 * v).norm() / size * 180 / pi), result.shift.push_back(e.segment<3>(6 * v + 3).norm());
    result.rms_angle += std::pow(result.angle.back(), 2), result.rms_shift += std::pow(result.shift.back(), 2);
    result.worst_angle = std::max(result.worst_angle, result.angle.back()), result.worst_shift = std::max(result.worst_shift, result.shift.back());
  }
  result.rms_angle = std::sqrt(result.rms_angle / double(found.size())), result.rms_shift = std::sqrt(result.rms_shift / double(found.size()));
  return result;
}

double radius_of(const Scan& scan) { return scan.cloud.bounds().diagonal() / 3.5; }

int refused(const Registration& registration) {
  int count = 0;
  for (const auto& view : registration.views) count += view.status == ViewStatus::refused;
  return count;
}

void cases(const Path& folder, const std::vector<std::string>& names) {
  std::printf("| case | views | refused | free motions | rms deg | worst deg | rms mm | worst mm | overlap least | gap mm | s |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<std::string> found = names;
  if (found.empty())
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (std::filesystem::exists(entry.path() / "scan" / "scan.json")) found.push_back(entry.path().filename().string());
  std::sort(found.begin(), found.end());
  for (const auto& name : found) {
    const Path file = folder / name / "scan" / "scan.json";
    const auto exact = read_scan({file}, {}, quiet());
    const auto guess = read_scan({file}, {{}, true}, quiet());
    if (!exact.ok() || !guess.ok()) { std::printf("| %s | not run |\n", name.c_str()); continue; }
    const double start = seconds();
    const auto result = register_views(views_of(*guess), {}, quiet());
    const double spent = seconds() - start;
    if (!result.ok()) { std::printf("| %s | %s |\n", name.c_str(), result.error().message.c_str()); continue; }
    std::vector<Pose> truth;
    for (const View& view : exact->views) truth.push_back(view.world_from_view);
    const PoseErrors e = errors_of(truth, *result, radius_of(*exact));
    double overlap = 1;
    for (const auto& view : result->views) overlap = std::min(overlap, view.overlap);
    std::printf("| %s | %zu | %d | %zu | %.4f | %.4f | %.4f | %.4f | %.2f | %.4f | %.1f |\n", name.c_str(), truth.size(), refused(*result),
                result->free_motions.size(), e.rms_angle, e.worst_angle, e.rms_shift, e.worst_shift, overlap, result->worst_gap, spent);
    if (std::getenv("VERBOSE")) {
      for (const auto& line : result->warnings) std::printf("  %s\n", line.c_str());
      for (std::size_t v = 0; v < e.angle.size() && e.angle.size() == truth.size(); ++v) {
        const Mat6& c = result->views[v].covariance;
        std::printf("  %zu: %.4f deg %.4f mm, sigma %.4f deg %.4f mm, overlap %.3f, through %.4f, %s\n", v, e.angle[v], e.shift[v],
                    std::sqrt(c.topLeftCorner<3, 3>().trace()) * 180 / pi, std::sqrt(c.bottomRightCorner<3, 3>().trace()), result->views[v].overlap,
                    result->views[v].seen_through, result->views[v].reason.c_str());
      }
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  if (words.size() >= 2 && words[0] == "cases") return cases(words[1], {words.begin() + 2, words.end()}), 0;
  std::fprintf(stderr, "usage: bench_registration cases DIR [CASE...]\n");
  return 2;
}
