#include "verify/align/misplaced_part.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "verify/compare/samples.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t judged_points = 2000;
constexpr std::size_t fitted_points = 500;
constexpr std::size_t glanced_points = 120;
constexpr double clear_gain = 0.025;  // of all points: less could be one feature among many

using Mat7 = Eigen::Matrix<double, 7, 7>;
using Vec7 = Eigen::Matrix<double, 7, 1>;

/// A point of the scan goes to scale * turn * p + shift in the artifact's frame; `turn` may be a mirror.
struct Similarity {
  double scale = 1;
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
  Vec3 operator*(const Vec3& p) const { return scale * (turn * p) + shift; }
  bool mirrors() const { return turn.determinant() < 0; }
};

enum Freedom { moves = 3, turns = 6, scales = 7 };

class Seeker {
 public:
  Seeker(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface, const VerifyOptions& options)
      : mesh_(mesh),
        surface_(surface),
        near_(0.5 * options.tolerance + 2 * source.noise),
        tolerance_(options.tolerance) {
    const std::size_t stride = std::max<std::size_t>(1, source.points.size() / judged_points);
    for (std::size_t i = 0; i < source.points.size(); i += stride) points_.push_back(source.points[i]);
    for (const auto& s : even_samples(mesh, judged_points)) samples_.push_back(s.point);
  }

  /// The share of the points that lie on the artifact.
  double share(const Similarity& to) const {
    std::size_t on = 0;
    for (const auto& p : points_) on += surface_.closest_within(to * p, near_ * to.scale).has_value();
    return double(on) / double(points_.size());
  }

  /// True if points that lie on the artifact now would fit worse afterwards: what is right must stay right. One end of
  /// a bar that is too long could pass for a bar that is too large, if its other sizes were not looked at.
  bool spoils(const Similarity& to) const {
    double now = 0, then = 0;
    std::size_t both = 0;
    for (const auto& p : points_) {
      const auto before = surface_.closest_within(p, near_);
      const auto after = before ? surface_.closest_within(to * p, near_ * to.scale) : std::nullopt;
      if (!after) continue;
      ++both;
      now += before->distance * before->distance;
      then += after->distance * after->distance / (to.scale * to.scale);
    }
    return both >= 50 && then > 1.01 * now + double(both) * std::pow(0.02 * tolerance_, 2);
  }

  /// The typical distance of a sample of the points, in mm of the scan; robust against outliers.
  double glance(const Similarity& to) const {
    double sum = 0;
    const std::size_t stride = std::max<std::size_t>(1, points_.size() / glanced_points);
    const double most = 0.1 * size(points_);
    for (std::size_t i = 0; i < points_.size(); i += stride) {
      const auto hit = surface_.closest_within(to * points_[i], most * to.scale);
      sum += hit ? hit->distance / to.scale : most;
    }
    return sum;
  }

  /// Point to plane, the farther ones counting less and less.
  Similarity refined(Similarity to, Freedom freedom, int rounds) const {
    const std::size_t stride = std::max<std::size_t>(1, points_.size() / fitted_points);
    for (int round = 0; round < rounds; ++round) {
      struct Pair {
        Vec3 q, normal;
        double off;
      };
      std::vector<Pair> pairs;
      std::vector<double> sizes;
      Vec3 middle = Vec3::Zero();
      for (std::size_t i = 0; i < points_.size(); i += stride) {
        const Vec3 q = to * points_[i];
        const MeshHit hit = surface_.closest(q);
        const Vec3 n = triangle_normal(mesh_, hit.triangle);
        pairs.push_back({q, n, n.dot(hit.point - q)});
        sizes.push_back(hit.distance);
        middle += q;
      }
      middle /= double(pairs.size());
      const double reach = std::max(4.5 * median_in_place(sizes), 3 * near_ * to.scale);
      const double arm = std::max(size(points_) * to.scale, 1e-9);  // so that all unknowns are lengths
      Mat7 h = Mat7::Zero();
      Vec7 g = Vec7::Zero();
      for (const auto& pair : pairs) {
        const double r = pair.off / reach;
        if (std::abs(r) >= 1) continue;
        const double w = (1 - r * r) * (1 - r * r);
        const Vec3 lever = (pair.q - middle) / arm;
        Vec7 row;
        row << pair.normal, lever.cross(pair.normal), lever.dot(pair.normal);
        h += w * row * row.transpose();
        g += w * pair.off * row;
      }
      const int n = freedom;
      const double damping = 1e-4 * h.topLeftCorner(n, n).trace() / n + 1e-12;  // what the data do not fix stays
      Vec7 x = Vec7::Zero();
      x.head(n) = (h.topLeftCorner(n, n) + damping * Eigen::MatrixXd::Identity(n, n)).ldlt().solve(g.head(n));
      const Mat3 by = rotation_of(x.segment<3>(3) / arm);
      const double grow = 1 + std::clamp(x[6] / arm, -0.2, 0.2);
      to.shift = grow * (by * (to.shift - middle)) + middle + x.head<3>();
      to.turn = by * to.turn;
      to.scale *= grow;
      if (x.norm() < 1e-3 * tolerance_ * to.scale) break;
    }
    return to;
  }

  /// Guesses for a part that stands anywhere, in either hand.
  std::vector<Similarity> anywhere(double scale) const {
    std::vector<Mat3> turned;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (const double s : {1.0, -1.0})
          for (const double t : {1.0, -1.0}) {
            if (a == b) continue;
            Mat3 m;
            m.col(0) = s * Vec3::Unit(a), m.col(1) = t * Vec3::Unit(b), m.col(2) = m.col(0).cross(m.col(1));
            turned.push_back(m);
          }
    const Mat3 to = axes_of(samples_), from = axes_of(points_);
    const Vec3 there = middle_of(samples_), here = middle_of(points_);
    std::vector<Similarity> guesses;
    for (const auto& m : turned)
      for (const double hand : {1.0, -1.0}) {
        const Mat3 turn = m * Vec3(1, 1, hand).asDiagonal();
        for (const Mat3& r : {Mat3(turn), Mat3(to * turn * from.transpose())})
          guesses.push_back({scale, r, there - scale * (r * here)});
        guesses.push_back({scale, turn, Vec3::Zero()});
      }
    return guesses;
  }

  double size_ratio() const { return size(samples_) / size(points_); }
  double tolerance() const { return tolerance_; }
  /// The largest distance by which a corner of the artifact's box is moved.
  double effect(const Similarity& to) const {
    Box3 box;
    for (const auto& p : points_) box.add(p);
    double most = 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 p(i & 1 ? box.high.x() : box.low.x(), i & 2 ? box.high.y() : box.low.y(),
                   i & 4 ? box.high.z() : box.low.z());
      most = std::max(most, (to * p - p).norm());
    }
    return most;
  }
  Vec3 center() const { return middle_of(points_); }

 private:
  const TriangleMesh& mesh_;
  const MeshDistance& surface_;
  double near_, tolerance_;
  std::vector<Vec3> points_, samples_;

  static Vec3 middle_of(const std::vector<Vec3>& points) {
    Vec3 sum = Vec3::Zero();
    for (const auto& p : points) sum += p;
    return sum / double(points.size());
  }

  /// Mean distance from the middle.
  static double size(const std::vector<Vec3>& points) {
    const Vec3 middle = middle_of(points);
    double sum = 0;
    for (const auto& p : points) sum += (p - middle).norm();
    return std::max(sum / double(points.size()), 1e-12);
  }

  static Mat3 axes_of(const std::vector<Vec3>& points) {
    const Vec3 middle = middle_of(points);
    Mat3 sum = Mat3::Zero();
    for (const auto& p : points) sum += (p - middle) * (p - middle).transpose();
    Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(sum).eigenvectors();
    if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
    return axes;
  }
};

/// What is wrong with the artifact if `to` puts it right.
std::string described(const Similarity& to, const Vec3& center) {
  std::vector<std::string> faults;
  if (to.mirrors()) faults.push_back("mirrored");
  struct Known {
    double factor;
    const char* why;
  };
  const Known known[] = {{25.4, "inches and millimetres are confused"},
                         {10, "centimetres and millimetres are confused"},
                         {1000, "millimetres and another thousandth are confused"},
                         {304.8, "feet and millimetres are confused"}};
  const double larger = std::max(to.scale, 1 / to.scale);
  std::string unit;
  for (const auto& k : known)
    if (std::abs(larger / k.factor - 1) < 0.02)
      unit = print_number(k.factor) + " times too " + (to.scale > 1 ? "large: " : "small: ") + k.why;
  if (!unit.empty())
    faults.push_back(unit);
  else if (larger > 1.5)
    faults.push_back(shown(larger, 0.001) + " times too " + (to.scale > 1 ? "large" : "small"));
  else if (larger > 1 + 1e-9)
    faults.push_back("scaled by " + shown(to.scale, 1e-4) + ", " + shown(100 * (larger - 1), 0.01) + " % too " +
                     (to.scale > 1 ? "large" : "small"));
  if (!to.mirrors()) {
    const Eigen::AngleAxisd turn(to.turn);
    if (turn.angle() > 1e-9)
      faults.push_back("turned by " + shown(degrees(turn.angle()), 0.01) + " degrees about " +
                       shown(Vec3(turn.axis()), 0.001));
    // A part grows about its own origin or about another place: only the latter is a motion.
    const Vec3 moved = larger > 1 + 1e-9 && to.shift.norm() < 1e-9 ? Vec3(Vec3::Zero()) : Vec3(to * center - center);
    if (larger < 1.5 && moved.norm() > 1e-9) faults.push_back("moved by " + shown(moved, 0.001) + " mm");
  }
  return listed(faults);
}

}  // namespace

std::optional<std::string> misplacement(const ScanSource& source, const TriangleMesh& mesh, const MeshDistance& surface,
                                        const VerifyOptions& options, Context& context) {
  if (mesh.empty() || source.points.size() < 100) return std::nullopt;
  const Seeker seeker(source, mesh, surface, options);
  const double now = seeker.share({});
  // A small turn or shift that changes nothing is not worth a word.
  auto simplified = [&](const Similarity& to) {
    const double then = seeker.share(to);
    const Vec3 center = seeker.center(), moved = to * center - center;
    std::vector<Similarity> simpler = {{1, Mat3::Identity(), moved},
                                       {to.scale, Mat3::Identity(), Vec3::Zero()},
                                       {1, to.turn, center - to.turn * center},
                                       {1, to.turn, moved + center - to.turn * center}};
    if (!to.mirrors())
      for (const auto& s : simpler)
        if (seeker.share(s) >= then - 0.005 && !seeker.spoils(s)) return s;
    return to;
  };
  // What is said must be worth saying: all points but outliers come to lie on it, and clearly more than before.
  auto said = [&](const Similarity& to) -> std::optional<std::string> {
    const double then = seeker.share(to);
    if (then < 1 - options.outlier_rate || then < now + clear_gain || seeker.effect(to) < seeker.tolerance() ||
        seeker.spoils(to))
      return std::nullopt;
    return "the whole part is " + described(simplified(to), seeker.center()) + ": put right, " + percent(then) +
           " of the points lie on it, now " + percent(now);
  };
  if (now > 0.999) return std::nullopt;
  // The simplest explanation first; a later one is used only if it explains more.
  for (const Freedom freedom : {moves, turns, scales})
    if (auto text = said(seeker.refined({}, freedom, 12))) return text;
  if (now > 0.97 || context.cancelled) return std::nullopt;
  for (const double factor : {25.4, 1000.0, 10.0, 304.8})
    for (const double scale : {factor, 1 / factor}) {
      const Similarity guess{scale, Mat3::Identity(), Vec3::Zero()};
      if (auto text = said(guess)) return text;
    }
  std::vector<double> sizes = {1};
  if (const double ratio = seeker.size_ratio(); std::abs(std::log(ratio)) > 0.3) sizes.push_back(ratio);
  for (const double scale : sizes) {
    const auto guesses = seeker.anywhere(scale);
    std::vector<std::pair<double, std::size_t>> order(guesses.size());
    parallel_for(
        guesses.size(), context.threads,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) order[i] = {seeker.glance(guesses[i]), i};
        },
        4);
    std::sort(order.begin(), order.end());
    // Both hands are tried; a motion is reported in preference to a mirror.
    for (const bool mirror : {false, true}) {
      int tried = 0;
      for (const auto& [far, i] : order) {
        if (guesses[i].mirrors() != mirror) continue;
        if (++tried > 6) break;
        const auto found = seeker.refined(guesses[i], scale == 1 ? turns : scales, 40);
        if (auto text = said(found)) return text;
      }
    }
  }
  return std::nullopt;
}

}  // namespace partscribe::verify
