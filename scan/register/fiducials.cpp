#include "scan/register/fiducials.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>

#include "core/ensure.h"
#include "core/number.h"
#include "core/statistics.h"
#include "geometry/decompose.h"
#include "scan/register/as_published/state_vector.h"

namespace partscribe::scan {
namespace {

std::string_view without_blanks(std::string_view word) {
  const auto first = word.find_first_not_of(" \t\r\"");
  return first == std::string_view::npos ? std::string_view{}
                                         : word.substr(first, word.find_last_not_of(" \t\r\"") - first + 1);
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto end = line.find(',');
    cells.push_back(without_blanks(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

/// Whether `file` is what `said` names: the same, or the end of its path.
bool names_file(std::string_view said, std::string_view file) {
  if (said == file) return true;
  if (said.size() > file.size()) std::swap(said, file);
  return !said.empty() && file.ends_with(said) && file[file.size() - said.size() - 1] == '/';
}

/// Where the points of one view lie on those of the others.
struct SharedPoints {
  std::vector<Vec3> own, world;
};

/// Three of them are on no line: the second largest spread is no rounding error of the largest.
bool fix_a_pose(const std::vector<Vec3>& points) {
  constexpr double line = 1e-3;  // of the length, across it
  if (points.size() < 3) return false;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose();
  const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvalues();
  return values[1] > line * line * values[2];
}

/// Of rotation vector about `center` and shift, from the rest that the shared points leave.
Mat6 covariance_by_rest(const SharedPoints& shared, const StateVector& q, const Vec3& center) {
  const double numbers = 3 * static_cast<double>(shared.own.size());
  const double variance = numbers > 6 ? mean_square_error(shared.own, shared.world, q) *
                                            static_cast<double>(shared.own.size()) / (numbers - 6)
                                      : 0;
  Mat6 information = Mat6::Zero();
  for (const Vec3& p : shared.world) {
    Eigen::Matrix<double, 3, 6> J;
    const Vec3 r = p - center;
    J << 0, r.z(), -r.y(), 1, 0, 0, -r.z(), 0, r.x(), 0, 1, 0, r.y(), -r.x(), 0, 0, 0, 1;
    information += J.transpose() * J;
  }
  Mat6 covariance;
  for (int k = 0; k < 6; ++k)
    covariance.col(k) = variance * solve_ldlt<6, 1>(information, Eigen::Matrix<double, 6, 1>(Mat6::Identity().col(k)));
  return covariance;
}

}  // namespace

Result<std::vector<Fiducial>> parse_fiducials(std::string_view text, const std::vector<View>& views, double unit) {
  std::vector<Fiducial> result;
  std::size_t number = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = without_blanks(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    const std::string at = "line " + std::to_string(number) + ": ";
    if (line.empty() || line.front() == '#') continue;
    const auto cells = cells_of(line);
    if (cells.size() != 5)
      return bad_input(at + "expected view file, name, x, y, z, found " + std::to_string(cells.size()) + " cells");
    Fiducial fiducial;
    fiducial.name = cells[1];
    bool numbers = true, words = true;
    for (int k = 0; k < 3; ++k) {
      const auto value = parse_number(cells[2 + static_cast<std::size_t>(k)]);
      numbers = numbers && value, words = words && !value;
      if (value) fiducial.place[k] = unit * *value;
    }
    if (words && result.empty()) continue;  // a heading
    if (!numbers) return bad_input(at + "expected three numbers after the name, found '" + std::string(line) + "'");
    std::size_t files = 0;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (names_file(cells[0], views[v].file)) fiducial.view = v, ++files;
    if (files != 1)
      return bad_input(at + "expected the file of one view, found '" + std::string(cells[0]) + "', which " +
                       (files ? std::to_string(files) + " views have" : "no view has"));
    for (const Fiducial& other : result)
      if (other.view == fiducial.view && other.name == fiducial.name)
        return bad_input(at + "expected each point once in a view, found '" + fiducial.name + "' again");
    result.push_back(std::move(fiducial));
  }
  return result;
}

Result<Registration> register_by_fiducials(const std::vector<RegisterView>& views,
                                           const std::vector<Fiducial>& fiducials) {
  std::vector<std::map<std::string, Vec3>> shown(views.size());
  for (const Fiducial& f : fiducials) {
    ensure(f.view < views.size(), "a reference point belongs to a view");
    shown[f.view][f.name] = f.place;
  }
  const auto first = std::find_if(shown.begin(), shown.end(), [](const auto& points) { return points.size() >= 3; });
  if (first == shown.end()) return bad_input("expected a view that shows three reference points, found none");
  Registration result;
  result.views.resize(views.size());
  std::map<std::string, std::vector<Vec3>> known;  // in the world, by each view placed that shows it
  const auto place = [&](std::size_t v, const Pose& pose, ViewStatus status) {
    result.views[v].world_from_view = pose, result.views[v].status = status;
    for (const auto& [name, p] : shown[v]) known[name].push_back(pose * p);
  };
  const auto shared_by = [&](std::size_t v) {
    SharedPoints shared;
    for (const auto& [name, p] : shown[v])
      if (const auto at = known.find(name); at != known.end()) {
        Vec3 mean = Vec3::Zero();
        for (const Vec3& q : at->second) mean += q / static_cast<double>(at->second.size());
        shared.own.push_back(p), shared.world.push_back(mean);
      }
    return shared;
  };
  const auto reference = static_cast<std::size_t>(first - shown.begin());
  place(reference, views[reference].guess.value_or(Pose{}), ViewStatus::reference);
  for (const auto& [name, p] : known) result.center += p.front() / static_cast<double>(known.size());
  result.covariance =
      Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(views.size()), 6 * static_cast<Eigen::Index>(views.size()));
  for (;;) {
    std::optional<std::size_t> next;
    SharedPoints most;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (result.views[v].status != ViewStatus::refused) continue;
      SharedPoints shared = shared_by(v);
      if (fix_a_pose(shared.own) && shared.own.size() > most.own.size()) next = v, most = std::move(shared);
    }
    if (!next) break;
    const StateVector q = best_state(most.own, most.world);
    place(*next, pose_of(q), ViewStatus::registered);
    RegisteredView& view = result.views[*next];
    view.covariance = covariance_by_rest(most, q, result.center);
    std::vector<double> rest;
    for (std::size_t i = 0; i < most.own.size(); ++i)
      rest.push_back((most.world[i] - view.world_from_view * most.own[i]).norm());
    view.residual_median = median(std::move(rest));
    const auto at = 6 * static_cast<Eigen::Index>(*next);
    result.covariance.block<6, 6>(at, at) = view.covariance;
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    RegisteredView& view = result.views[v];
    if (view.status != ViewStatus::refused) continue;
    view.world_from_view = views[v].guess.value_or(Pose{});
    view.reason =
        "expected at least 3 reference points, not on a line, that views placed before it show as well, found " +
        std::to_string(shared_by(v).own.size());
    result.warnings.push_back("view " + (views[v].name.empty() ? std::to_string(v) : views[v].name) +
                              " is not registered: " + view.reason);
  }
  return result;
}

}  // namespace partscribe::scan
