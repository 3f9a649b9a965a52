#include "verify/align/align.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/least_squares.h"
#include "geometry/mesh/mesh_facets.h"
#include "geometry/points/thin.h"
#include "geometry/segment/facets.h"
#include "verify/compare/model_to_data.h"
#include "verify/compare/samples.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t coarse_points = 600, fine_points = 6000, mesh_samples = 4000;
constexpr int coarse_steps = 25, fine_steps = 60;
constexpr std::size_t finalists = 6;
constexpr double trimmed = 0.8;  // share of the points that a start is judged by: a scan has outliers, and gaps none
constexpr double off_by_frame = 0.2;   // share of the points beyond the tolerance; less is damage in some place
constexpr double equally_good = 1.05;  // ratio of the errors of two fits that the scan cannot tell apart
constexpr double hardly = 0.02;        // of the tolerance: smaller differences do not matter

using Vec6 = Eigen::Matrix<double, 6, 1>;

struct PrincipalFrame {
  Vec3 center = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  // columns, by growing extent
};

PrincipalFrame principal_frame(const std::vector<Vec3>& points) {
  PrincipalFrame frame;
  for (const auto& p : points) frame.center += p;
  frame.center /= static_cast<double>(points.size());
  Mat3 covariance = Mat3::Zero();
  for (const auto& p : points) covariance += (p - frame.center) * (p - frame.center).transpose();
  Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
  frame.axes = solver.eigenvectors();
  if (frame.axes.determinant() < 0) frame.axes.col(0) *= -1;
  return frame;
}

/// All turns that take coordinate axes to coordinate axes, the identity first.
std::vector<Mat3> axis_turns() {
  std::vector<Mat3> turns;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 turn = Mat3::Zero();
      for (int k = 0; k < 3; ++k) turn(order[static_cast<std::size_t>(k)], k) = signs >> k & 1 ? -1 : 1;
      if (turn.determinant() > 0) turns.push_back(turn);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return turns;
}

/// At most `count` points, spread evenly.
std::vector<Vec3> spread(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<Vec3> chosen;
  for (const auto i : thinned(points, {}, spacing_for_count(points, count))) chosen.push_back(points[i]);
  return chosen;
}

struct Trial {
  Pose pose;         // artifact from scan
  double error = 0;  // mm, root mean square of the nearer `trimmed` of the distances
};

class Fitting {
 public:
  Fitting(const MeshDistance& surface, double size, double noise, int threads)
      : surface_(surface), size_(size), noise_(noise), threads_(threads) {}

  /// Newton steps on the weighted squared distances; distant points lose their weight.
  Trial run(const std::vector<Vec3>& points, Pose pose, int steps) const {
    const std::size_t count = points.size();
    std::vector<double> distance(count), sizes(count);
    std::vector<Vec3> direction(count);
    Trial trial{pose, 0};
    for (int step = 0; step <= steps; ++step) {
      parallel_for(
          count, threads_,
          [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
              const Vec3 q = pose * points[i];
              MeshHit hit;
              distance[i] = surface_.signed_distance(q, hit);
              const Vec3 away = q - hit.point;
              direction[i] = away.norm() > 1e-12 * size_ ? Vec3(away / distance[i]) : Vec3(0, 0, 0);
            }
          },
          256);
      for (std::size_t i = 0; i < count; ++i) sizes[i] = std::abs(distance[i]);
      const double limit = quantile(sizes, trimmed);
      double sum = 0;
      std::size_t used = 0;
      for (const double s : sizes)
        if (s <= limit) sum += s * s, ++used;
      trial = {pose, std::sqrt(sum / static_cast<double>(std::max<std::size_t>(used, 1)))};
      if (step == steps) break;

      // Welsch weights at the scale of the middle of the distances; early, while all are far, nearly even ones.
      const double scale = std::max({3 * 1.4826 * quantile(sizes, 0.5), 3 * noise_, 1e-9 * size_});
      NormalSums<6> sums;
      Vec3 center = Vec3::Zero();
      for (const auto& p : points) center += p;
      center = pose * Vec3(center / static_cast<double>(count));
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 arm = (pose * points[i] - center) / size_;
        Vec6 row;
        row << arm.cross(direction[i]), direction[i];
        sums.add(row, -distance[i], welsch_weight(distance[i], scale / std::sqrt(2)));
      }
      // Directions that the part leaves open (a cylinder turns in itself) stay where they are.
      const Vec6 move = sums.solution(1e-6 * sums.h.trace() + 1e-300);
      const Mat3 turn = rotation_of(move.head<3>() / size_);
      pose = Pose{turn, center - turn * center + move.tail<3>()} * pose;
      if (move.norm() < 1e-9 * size_) break;
    }
    return trial;
  }

 private:
  const MeshDistance& surface_;
  double size_, noise_;
  int threads_;
};

double turn_of(const Mat3& rotation) { return std::acos(std::clamp(0.5 * (rotation.trace() - 1), -1.0, 1.0)); }

void describe(Alignment& alignment, const std::vector<Vec3>& points) {
  alignment.rotation = turn_of(alignment.scan_to_artifact.rotation);
  Vec3 center = Vec3::Zero();
  for (const auto& p : points) center += p;
  center /= static_cast<double>(points.size());
  alignment.translation = alignment.scan_to_artifact * center - center;
}

void measure(Alignment& alignment, const std::vector<Vec3>& points, const MeshDistance& surface, double noise) {
  std::vector<double> sizes;
  for (const auto& p : points) sizes.push_back(surface.closest(alignment.scan_to_artifact * p).distance);
  const double limit = std::max(5 * 1.4826 * quantile(sizes, 0.5), 5 * noise);
  double sum = 0;
  for (const double s : sizes)
    if (s <= limit) sum += s * s, ++alignment.points;
  alignment.rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(alignment.points, 1)));
}

Alignment best_fit(const std::vector<Vec3>& points, const TriangleMesh& mesh, const MeshDistance& surface, double noise,
                   double tolerance, int threads) {
  std::vector<Vec3> samples;
  for (const auto& s : even_samples(mesh, mesh_samples)) samples.push_back(s.point);
  const PrincipalFrame scan = principal_frame(points), part = principal_frame(samples);
  const Fitting fitting(surface, mesh.bounds().diagonal(), noise, threads);
  const auto few = spread(points, coarse_points);
  std::vector<Trial> trials = {fitting.run(few, {}, coarse_steps)};
  for (const auto& turn : axis_turns()) {
    const Mat3 rotation = part.axes * turn * scan.axes.transpose();
    trials.push_back(fitting.run(few, {rotation, part.center - rotation * scan.center}, coarse_steps));
  }
  std::stable_sort(trials.begin() + 1, trials.end(), [](const Trial& a, const Trial& b) { return a.error < b.error; });
  trials.resize(std::min(trials.size(), finalists + 1));
  for (auto& trial : trials) trial = fitting.run(points, trial.pose, fine_steps);
  double least = trials.front().error;
  for (const auto& trial : trials) least = std::min(least, trial.error);
  // What starts as it lies ends in the nearest position: it is kept if no other one is better. Between exact meshes all
  // errors are next to nothing, and their ratio says nothing.
  const double limit = equally_good * least + hardly * tolerance;
  Alignment best;
  double best_turn = 0;
  std::vector<Mat3> different;
  for (const auto& trial : trials) {
    if (trial.error > limit) continue;
    const double turn = turn_of(trial.pose.rotation);
    if (different.empty() || (trials.front().error > limit && turn < best_turn))
      best.scan_to_artifact = trial.pose, best_turn = turn;
    if (std::all_of(different.begin(), different.end(),
                    [&](const Mat3& other) { return turn_of(other.transpose() * trial.pose.rotation) > 0.02; }))
      different.push_back(trial.pose.rotation);
  }
  best.method = AlignBy::best_fit;
  if (different.size() > 1)
    best.remark = "the part fits as well in at least " + counted(different.size() - 1, "other position") +
                  "; this one is the nearest to how it lay";
  return best;
}

/// One flat face and the plane through the scanned points on it, in the artifact's frame.
struct Datum {
  Vec3 normal, middle;            // of the face
  Vec3 seen_normal, seen_middle;  // of the points
  std::size_t points = 0;
};

/// Three times over, letting go of what is beyond three deviations.
bool fit_plane(std::vector<Vec3> points, Datum& datum) {
  for (int round = 0; round < 3; ++round) {
    if (points.size() < 10) return false;
    const PrincipalFrame frame = principal_frame(points);
    datum.seen_middle = frame.center;
    datum.seen_normal = frame.axes.col(0).dot(datum.normal) < 0 ? Vec3(-frame.axes.col(0)) : Vec3(frame.axes.col(0));
    datum.points = points.size();
    std::vector<double> off;
    for (const auto& p : points) off.push_back(std::abs(datum.seen_normal.dot(p - datum.seen_middle)));
    const double limit = 3 * 1.4826 * quantile(off, 0.5) + 1e-12;
    std::erase_if(points,
                  [&](const Vec3& p) { return std::abs(datum.seen_normal.dot(p - datum.seen_middle)) > limit; });
  }
  return true;
}

/// The largest flat faces that fix a frame: the second at least 30 degrees across to the first, the third to both.
std::vector<Datum> three_faces(const Facets& facets, std::array<std::uint32_t, 3>& index) {
  std::vector<Datum> chosen;
  std::vector<std::uint32_t> order(facets.facets.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return facets.facets[a].area > facets.facets[b].area; });
  while (chosen.size() < 3) {
    bool found = false;
    for (const auto f : order) {
      const Vec3& n = facets.facets[f].normal;
      const bool across =
          chosen.empty() || (chosen.size() == 1 && chosen[0].normal.cross(n).norm() > 0.5) ||
          (chosen.size() == 2 && std::abs(chosen[0].normal.cross(chosen[1].normal).normalized().dot(n)) > 0.5);
      if (!across) continue;
      index[chosen.size()] = f;
      chosen.push_back({n, facets.facets[f].middle, n, facets.facets[f].middle});
      found = true;
      break;
    }
    if (!found) break;
  }
  return chosen;
}

/// The rotation that takes the first seen normal onto the first face's, and the second as nearly as that leaves.
Mat3 frame_of(const Vec3& first, const Vec3& second) {
  Mat3 frame;
  frame.col(0) = first;
  frame.col(2) = first.cross(second).normalized();
  frame.col(1) = frame.col(2).cross(first);
  return frame;
}

Result<Alignment> by_datums(const std::vector<Vec3>& points, const TriangleMesh& mesh, const MeshDistance& surface,
                            const Alignment& start, double noise) {
  const Facets facets = flat_pieces(mesh, 1e-6 * mesh.bounds().diagonal());
  std::array<std::uint32_t, 3> index{};
  auto datums = three_faces(facets, index);
  // A facet of a round face is no datum.
  const double least_area = 0.01 * area(mesh);
  for (const auto f : index)
    if (datums.size() < 3 || facets.facets[f].area < least_area)
      return bad_input("--align datums: expected three flat faces across to one another to stand the part on, found " +
                       std::string(datums.size() < 3 ? std::to_string(datums.size()) : "only small ones") +
                       "; --align best-fit needs none");
  std::array<std::vector<Vec3>, 3> on;
  const double reach = std::max(5 * noise, 3 * start.rms) + 1e-9 * mesh.bounds().diagonal();
  for (const auto& p : points) {
    const Vec3 q = start.scan_to_artifact * p;
    const MeshHit hit = surface.closest(q);
    if (hit.distance > reach) continue;
    for (std::size_t k = 0; k < 3; ++k)
      if (facets.facet_of[hit.triangle] == index[k]) on[k].push_back(q);
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (!fit_plane(on[k], datums[k]))
      return bad_input("--align datums: expected scanned points on three flat faces, found " +
                       std::to_string(on[k].size()) + " on the " +
                       (k == 0   ? "first"
                        : k == 1 ? "second"
                                 : "third") +
                       " one; --align best-fit needs none");
  const Mat3 turn =
      frame_of(datums[0].normal, datums[1].normal) * frame_of(datums[0].seen_normal, datums[1].seen_normal).transpose();
  Mat3 normals;
  Vec3 offsets;
  for (int k = 0; k < 3; ++k) {
    const auto& d = datums[static_cast<std::size_t>(k)];
    normals.row(k) = d.normal.transpose();
    offsets[k] = d.normal.dot(d.middle - turn * d.seen_middle);
  }
  const Vec3 shift = normals.partialPivLu().solve(offsets);
  Alignment alignment = start;
  alignment.method = AlignBy::datums;
  alignment.scan_to_artifact = Pose{turn, shift} * start.scan_to_artifact;
  alignment.rms = 0, alignment.points = 0;
  return alignment;
}

}  // namespace

Result<Alignment> align(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface, AlignBy by,
                        double tolerance, Context& context) {
  context.report("align", 0);
  const auto points = spread(source.points, fine_points);
  Alignment best = best_fit(points, mesh, surface, source.noise, tolerance, context.threads);
  measure(best, points, surface, source.noise);
  if (by == AlignBy::datums) {
    auto found = by_datums(points, mesh, surface, best, source.noise);
    if (!found) return found.error();
    best = *found;
    measure(best, points, surface, source.noise);
  }
  // A part that lies right already stays where it is.
  double farthest = 0;
  for (const auto& p : points) farthest = std::max(farthest, (best.scan_to_artifact * p - p).norm());
  if (farthest < hardly * tolerance) best.scan_to_artifact = {};
  describe(best, points);
  return best;
}

Result<bool> lay_onto_scan(const ScanSource& source, const VerifyOptions& options, ArtifactVerdict& verdict,
                           Context& context) {
  auto found = align(source, verdict.mesh, MeshDistance(verdict.mesh), options.align, options.tolerance, context);
  if (!found) return found.error();
  verdict.mesh = transformed(verdict.mesh, found->scan_to_artifact.inverse());
  verdict.alignment = std::move(*found);
  return true;
}

std::optional<std::string> hint_at_frame(const ScanSource& source, const VerifyOptions& options,
                                         const ArtifactVerdict& verdict, Context& context) {
  // What is wrong in one place is no matter of frames.
  const auto points = spread(source.points, coarse_points);
  const MeshDistance as_it_is(verdict.mesh);
  const auto off = std::count_if(points.begin(), points.end(),
                                 [&](const Vec3& p) { return as_it_is.closest(p).distance > options.tolerance; });
  if (static_cast<double>(off) < off_by_frame * static_cast<double>(points.size())) return {};
  const auto found = align(source, verdict.mesh, as_it_is, AlignBy::best_fit, options.tolerance, context);
  if (!found) return {};
  const auto moved = transformed(verdict.mesh, found->scan_to_artifact.inverse());
  const MeshDistance surface(moved);
  const auto normals = triangle_normals(moved);
  const auto field = data_to_model(source, surface, normals, options, context);
  if (!field.faults.empty()) return {};
  const auto area = model_to_data(source, field, moved, surface, normals, options, context);
  if (area.summary.contradicted > area.allowed_contradiction) return {};
  return "the scan fits after it is " + words_for(*found) + ": give --align best-fit if the frames differ";
}

std::string words_for(const Alignment& alignment) {
  const auto& t = alignment.translation;
  if (!alignment.moves()) return "left where it lies";
  return "turned by " + shown(degrees(alignment.rotation), 0.001) + " degrees and moved by " + shown(t.norm(), 0.001) +
         " mm " + shown(t, 0.001);
}

}  // namespace partscribe::verify
