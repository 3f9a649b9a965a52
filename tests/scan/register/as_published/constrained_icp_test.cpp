/// One view against a model of known truth: each constraint of 1993 alone saves the result where it is needed.
#include "scan/register/as_published/constrained_icp.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/number.h"
#include "core/random.h"
#include "scan/register/register_pair.h"

using namespace partscribe::scan;

namespace {

/// A rectangle about `center`, which is a primitive of its own kind: the matching knows nothing of it.
struct Tile {
  Vec3 center, u, v;  // half its edges, at right angles
  Vec3 normal() const {
    return Vec3(u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x())
        .normalized();
  }
};

class TileModel : public PublishedModel {
 public:
  explicit TileModel(std::vector<Tile> tiles) : tiles_(std::move(tiles)) {}
  void add(const ViewSurface&, const Pose&) override {}
  ClosestPoint closest(const Vec3& p) const override {
    ClosestPoint best;
    double least = std::numeric_limits<double>::infinity();
    for (const Tile& t : tiles_) {
      const Vec3 d = p - t.center;
      const double a = std::clamp(d.dot(t.u) / t.u.squaredNorm(), -1.0, 1.0),
                   b = std::clamp(d.dot(t.v) / t.v.squaredNorm(), -1.0, 1.0);
      const Vec3 x = t.center + a * t.u + b * t.v;
      if ((p - x).norm() < least) least = (p - x).norm(), best = {x, t.normal()};
    }
    return best;
  }
  std::size_t primitives() const override { return tiles_.size(); }

 private:
  std::vector<Tile> tiles_;
};

/// Three faces of a block of 24 mm that meet in a corner, 20 x 20 each.
std::vector<Tile> corner() {
  return {
      {{12, 0, 0}, {0, 10, 0}, {0, 0, 10}}, {{0, 12, 0}, {0, 0, 10}, {10, 0, 0}}, {{0, 0, 12}, {10, 0, 0}, {0, 10, 0}}};
}

/// Nine points on each of the faces.
std::vector<ReferencePoint> points_on(const std::vector<Tile>& tiles) {
  std::vector<ReferencePoint> points;
  for (const Tile& t : tiles)
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j) points.push_back({t.center + 0.6 * i * t.u + 0.6 * j * t.v, t.normal()});
  return points;
}

/// The same faces so much deeper: they face the same way, and are not in the model.
void add_steps(std::vector<ReferencePoint>& points, const std::vector<Tile>& tiles, double depth, std::size_t count) {
  const auto all = points_on(tiles);
  for (std::size_t k = 0; k < count; ++k) {
    const ReferencePoint& p = all[(5 * k) % all.size()];
    points.push_back({p.place - depth * p.normal + 0.3 * double(k / all.size()) * Vec3(1, 1, 1), p.normal});
  }
}

/// Of points as a view has them that stands at `truth`.
std::vector<ReferencePoint> seen_from(const Pose& truth, std::vector<ReferencePoint> points) {
  const Pose back = truth.inverse();
  for (ReferencePoint& p : points) p = {back * p.place, back.rotation * p.normal};
  return points;
}

const Pose truth{rotation_of(Vec3(0.3, -0.2, 0.5)), Vec3(4, 5, -6)};

/// The first estimate: so far off, about the middle of the part.
StateVector estimate(double angle_deg, double shift) {
  return state_of(Pose{rotation_of(radians(angle_deg) * Vec3(1, -2, 1).normalized()), shift * Vec3(2, -1, 2) / 3} *
                  truth);
}

std::vector<std::uint8_t> all_of(const std::vector<ReferencePoint>& points) {
  return std::vector<std::uint8_t>(points.size(), 1);
}

/// Degrees, and mm at the middle of the part.
struct OffTruth {
  double angle, shift;
};
OffTruth off(const IcpResult& found) {
  const Pose d = pose_of(found.state) * truth.inverse();
  return {degrees(rotation_vector(d.rotation).norm()), (d * Vec3(0, 0, 0)).norm()};
}

bool right(const IcpResult& found) {
  return found.failure.empty() && off(found).angle < 0.05 && off(found).shift < 0.02;
}

constexpr double pixel = 0.5;

}  // namespace

TEST_CASE("constrained icp: a view is found from an estimate 6 degrees and 2 mm off, and e(q) falls") {
  const TileModel model(corner());
  const auto points = seen_from(truth, points_on(corner()));
  const IcpResult found = constrained_icp(points, all_of(points), model, estimate(6, 2), pixel, {});
  CHECK(right(found));
  CHECK(found.asked == 27);
  CHECK(found.overlapping == 27);
  for (std::size_t k = 1; k < found.errors.size(); ++k) CHECK(found.errors[k] <= found.errors[k - 1] * (1 + 1e-9));
}

TEST_CASE("constrained icp: it ends when e(q) falls below the threshold, or when it no longer falls") {
  const TileModel model(corner());
  auto points = seen_from(truth, points_on(corner()));
  PaperOptions options;
  for (const double threshold : {1e-2, 1e-4, 1e-6}) {
    options.error_threshold = threshold;
    const IcpResult found = constrained_icp(points, all_of(points), model, estimate(6, 2), pixel, options);
    INFO(threshold << " after " << found.errors.size());
    REQUIRE(found.errors.size() > 1);
    CHECK(found.errors.back() < threshold * pixel * pixel);
    CHECK(found.errors[found.errors.size() - 2] >= threshold * pixel * pixel);
  }
  // With noise it never gets there.
  Random random(2);
  for (ReferencePoint& p : points) p.place += 0.05 * random.normal() * p.normal;
  const IcpResult noisy = constrained_icp(points, all_of(points), model, estimate(6, 2), pixel, options);
  CHECK(noisy.failure.empty());
  CHECK(noisy.errors.size() < 1000);
  CHECK(noisy.errors.back() > options.error_threshold * pixel * pixel);
  CHECK(noisy.errors[noisy.errors.size() - 3] == Approx(noisy.errors.back()).epsilon(1e-5));
  CHECK(off(noisy).shift < 0.05);
}

TEST_CASE("constrained icp: points that are not visible in the model lead it astray unless they are left out") {
  // Two thirds lie on faces 3 mm deeper: near to the model, facing the same way, and too many to be told by residuals.
  const TileModel model(corner());
  auto points = points_on(corner());
  const std::size_t there = points.size();
  add_steps(points, corner(), 3, 54);
  points = seen_from(truth, points);
  std::vector<std::uint8_t> visible(points.size(), 0);
  std::fill_n(visible.begin(), there, 1);
  CHECK(right(constrained_icp(points, visible, model, estimate(4, 1), pixel, {})));
  const IcpResult without = constrained_icp(points, all_of(points), model, estimate(4, 1), pixel, {});
  CHECK(!right(without));
  CHECK((off(without).shift > 1 || !without.failure.empty()));
}

TEST_CASE("constrained icp: mismatches among visible points are told by the distribution of residuals") {
  // A third lies on steps that the model does not have, in front of its faces: visible, near, facing the same way.
  const TileModel model(corner());
  auto points = points_on(corner());
  add_steps(points, corner(), -4, 13);
  points = seen_from(truth, points);
  const IcpResult found = constrained_icp(points, all_of(points), model, estimate(4, 1), pixel, {});
  CHECK(right(found));
  CHECK(std::count(found.valid.begin(), found.valid.begin() + 27, 1) == 27);
  CHECK(std::count(found.valid.begin() + 27, found.valid.end(), 1) == 0);
  PaperOptions without;
  without.mismatch_deviations = std::numeric_limits<double>::infinity();
  CHECK(off(constrained_icp(points, all_of(points), model, estimate(4, 1), pixel, without)).shift > 0.5);
}

TEST_CASE("constrained icp: the other side of a thin wall is told by its normals alone") {
  // As many points of the backs of walls 0.8 mm thick: no residual tells them, and half way between both is least.
  const TileModel model(corner());
  auto points = points_on(corner());
  const std::size_t front = points.size();
  for (std::size_t i = 0; i < front; ++i)
    points.push_back(
        {points[i].place - 0.8 * points[i].normal, (Vec3(0.05, 0.03, -0.04) - points[i].normal).normalized()});
  points = seen_from(truth, points);
  const IcpResult found = constrained_icp(points, all_of(points), model, estimate(2, 0.3), pixel, {});
  CHECK(right(found));
  CHECK(std::count(found.valid.begin() + std::ptrdiff_t(front), found.valid.end(), 1) == 0);
  PaperOptions without;
  without.normal_angle = pi;  // every normal is consistent
  without.mismatch_deviations = std::numeric_limits<double>::infinity();
  CHECK(off(constrained_icp(points, all_of(points), model, estimate(2, 0.3), pixel, without)).shift > 0.3);
}

TEST_CASE("constrained icp: a large alpha converges from estimates that a small one refuses, and uses rough normals") {
  const TileModel model(corner());
  auto points = seen_from(truth, points_on(corner()));
  PaperOptions large, small;
  small.normal_angle = radians(4);
  for (const double angle : {1.0, 2.0, 6.0, 12.0, 18.0}) {
    INFO("estimate off by " << angle << " degrees");
    CHECK(right(constrained_icp(points, all_of(points), model, estimate(angle, 1), pixel, large)));
    const IcpResult found = constrained_icp(points, all_of(points), model, estimate(angle, 1), pixel, small);
    UNSCOPED_INFO("small: off " << off(found).angle << " " << off(found).shift << " " << found.failure);
    CHECK(right(found) == (angle < 4));
  }
  // From a good estimate as well: a small alpha throws away sound points whose normals are rough, a large one keeps
  // all.
  Random random(3);
  for (ReferencePoint& p : points)
    p.normal = (p.normal + 0.08 * Vec3(random.normal(), random.normal(), random.normal())).normalized();
  const IcpResult all = constrained_icp(points, all_of(points), model, estimate(2, 0.5), pixel, large);
  CHECK(right(all));
  CHECK(std::count(all.valid.begin(), all.valid.end(), 1) == 27);
  const IcpResult some = constrained_icp(points, all_of(points), model, estimate(2, 0.5), pixel, small);
  CHECK(std::count(some.valid.begin(), some.valid.end(), 1) < 18);
}

TEST_CASE("constrained icp: where what does not overlap predominates a good estimate does, and a wrong one is told") {
  // 54 of 100 points are of no face of the model.
  const TileModel model(corner());
  auto points = points_on(corner());
  for (const ReferencePoint& p : points_on(corner())) points.push_back({p.place + Vec3(0.4, 0.5, 0.3), p.normal});
  points.resize(46);
  for (std::size_t i = 27; i < 46; ++i) {
    const ReferencePoint& p = points[i - 27];
    points[i] = {p.place + 0.5 * Vec3(1 - p.normal.x(), 1 - p.normal.y(), 1 - p.normal.z()), p.normal};
  }
  add_steps(points, corner(), -5, 27);
  add_steps(points, corner(), -8, 27);
  points = seen_from(truth, points);
  const IcpResult good = constrained_icp(points, all_of(points), model, estimate(0, 0), pixel, {});
  CHECK(right(good));
  CHECK(good.overlapping == 46);
  const IcpResult wrong = constrained_icp(points, all_of(points), model, estimate(20, 6), pixel, {});
  REQUIRE(!wrong.failure.empty());
  CHECK(wrong.failure.find("of 100 matched points lie within 0.5 mm") != std::string::npos);
  CHECK(wrong.failure.find("most do not overlap, and the first estimate is too far off") != std::string::npos);
  CHECK(wrong.failure.find('\n') == std::string::npos);
}

TEST_CASE("constrained icp: bad_points say what was expected") {
  const TileModel model(corner());
  auto points = seen_from(truth, points_on(corner()));
  std::vector<std::uint8_t> few(points.size(), 0);
  few[0] = few[9] = few[18] = 1;
  CHECK(constrained_icp(points, few, model, estimate(1, 0), pixel, {}).failure ==
        "expected at least 6 points that views before it can see by the first estimate, found 3");
  for (ReferencePoint& p : points) p.normal = -p.normal;
  const std::string turned = constrained_icp(points, all_of(points), model, estimate(1, 0), pixel, {}).failure;
  CHECK(turned.find("have normals like those of the views before it") != std::string::npos);
}
