/// The simulated scanner delivers what its options say, and the same for any number of threads.
#include "scan/simulate/simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/number.h"
#include "scan/read/range_file.h"
#include "scan/read/read.h"

using namespace partscribe::scan;

namespace {

constexpr double radius = 20;
const Vec3 center(100, -50, 30);

/// A ball, hit exactly.
Surface ball() {
  Surface surface;
  surface.bounds.add(center - Vec3::Constant(radius)), surface.bounds.add(center + Vec3::Constant(radius));
  surface.first_hit = [](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    const double middle = (center - origin).dot(direction);
    const double off = (origin + middle * direction - center).squaredNorm();
    if (off >= radius * radius) return {};
    const double t = middle - std::sqrt(radius * radius - off);
    return SurfaceHit{t, (origin + t * direction - center) / radius};
  };
  return surface;
}

SimulatedScan run(const Surface& surface, const SimulateOptions& options, int threads = 2) {
  Context context;
  context.threads = threads;
  return simulate(surface, options, context);
}

SimulateOptions small() {
  SimulateOptions options;
  options.views = "tetrahedron";
  options.resolution = 64;
  return options;
}

double off_ball(const Vec3& p) { return (p - center).norm() - radius; }

Model cylinder_with_bore() {
  Model model;
  Parameter r;
  r.name = "r", r.value = 10;
  model.parameters = {r};
  const auto object = [](const std::string& name, const Shape& shape) {
    Object result;
    result.name = name, result.shape = shape;
    return result;
  };
  auto body = object("body", Cylinder{Expr::of("r"), 30}), bore = object("bore", Cylinder{4, 40});
  auto part = object("part", Difference{{"body", "bore"}});
  bore.frame.z = -5;
  part.frame.x = 7;
  model.objects = {body, bore, part};
  model.scan_from_part.rx = pi / 2;  // the axis now runs along -y
  return model;
}

}  // namespace

TEST_CASE("viewpoints: the sets have their size, unit length and balance") {
  for (const auto& [name, count] : std::vector<std::pair<std::string, std::size_t>>{{"tetrahedron", 4},
                                                                                    {"octahedron", 6},
                                                                                    {"cube", 8},
                                                                                    {"icosahedron", 12},
                                                                                    {"dodecahedron", 20},
                                                                                    {"1", 1},
                                                                                    {"37", 37}}) {
    const auto points = viewpoints(name);
    REQUIRE(points);
    CHECK(points->size() == count);
    Vec3 sum(0, 0, 0);
    for (const auto& p : *points) {
      CHECK(p.norm() == Approx(1));
      sum += p;
    }
    for (std::size_t i = 0; i < points->size(); ++i)
      for (std::size_t j = 0; j < i; ++j) CHECK(((*points)[i] - (*points)[j]).norm() > 0.2);
    if (count > 1) CHECK(sum.norm() < 0.5);
  }
  CHECK(!viewpoints("pyramid"));
  CHECK(!viewpoints("0"));
  CHECK(!viewpoints("12x"));
}

TEST_CASE(
    "viewpoints: every turn of a regular polyhedron takes its set onto itself, and none of its sides is preferred") {
  struct Known {
    const char* name;
    double nearest_deg;  // between neighbours
    std::size_t turns;   // of its group
  };
  for (const Known& known :
       {Known{"tetrahedron", 109.4712206, 12}, Known{"octahedron", 90, 24}, Known{"cube", 70.5287794, 24},
        Known{"icosahedron", 63.4349488, 60}, Known{"dodecahedron", 41.8103149, 60}}) {
    const auto points = *viewpoints(known.name);
    INFO(known.name);
    Vec3 sum = Vec3::Zero();
    Mat3 spread = Mat3::Zero();
    for (const auto& p : points) sum += p, spread += p * p.transpose();
    CHECK(sum.norm() < 1e-12);
    CHECK((spread - static_cast<double>(points.size()) / 3 * Mat3::Identity()).norm() < 1e-12);
    // The turns are those that take one pair of neighbours to each other pair.
    const double cosine = std::cos(radians(known.nearest_deg));
    std::vector<Mat3> frames;
    for (const auto& p : points)
      for (const auto& q : points) {
        CHECK((p == q || p.dot(q) < cosine + 1e-8));
        if (std::abs(p.dot(q) - cosine) > 1e-8) continue;
        Mat3 frame;
        frame << p, (q - p.dot(q) * p).normalized(), p.cross(q).normalized();
        frames.push_back(frame);
      }
    CHECK(frames.size() == known.turns);
    for (const auto& frame : frames) {
      const Mat3 turn = frame * frames.front().transpose();
      for (const auto& p : points) {
        double nearest = 2;
        for (const auto& q : points) nearest = std::min(nearest, (turn * p - q).norm());
        CHECK(nearest < 1e-9);
      }
    }
  }
}

TEST_CASE("simulate: without noise every point lies on the surface to half a code") {
  for (const auto projection : {Projection::orthographic, Projection::pinhole}) {
    auto options = small();
    options.projection = projection;
    const auto scan = run(ball(), options);
    REQUIRE(scan.views.size() == 4);
    REQUIRE(scan.merged.cloud.size() > 3000);
    const double q = scan.views[0].image.q;
    for (const auto& v : scan.views) CHECK((v.image.q == q && v.image.z0 == scan.views[0].image.z0));
    for (const auto& p : scan.merged.cloud.points) REQUIRE(std::abs(off_ball(p)) < 0.51 * q);
    for (std::size_t i = 0; i < scan.merged.cloud.size(); ++i)  // seen from outside, within the drop-out angle
      REQUIRE((scan.merged.cloud.points[i] - center).normalized().dot(scan.merged.cloud.rays[i]) <
              -std::cos(radians(78.1)));
  }
}

TEST_CASE("simulate: the noise along the axis has the sigma that was asked for and grows with incidence") {
  auto options = small();
  options.resolution = 128;
  options.sigma = 0.05;
  const auto scan = run(ball(), options);
  double facing = 0, slanted = 0;
  std::size_t n_facing = 0, n_slanted = 0;
  for (std::size_t i = 0; i < scan.merged.cloud.size(); ++i) {
    const Vec3 &p = scan.merged.cloud.points[i], &ray = scan.merged.cloud.rays[i];
    // Along the ray, exactly: where it meets the ball.
    const double middle = (center - p).dot(ray), off = (p + middle * ray - center).squaredNorm();
    const double error = middle - std::sqrt(radius * radius - off), cosine = std::sqrt(1 - off / (radius * radius));
    if (cosine > 0.95) facing += error * error, ++n_facing;
    if (cosine > 0.45 && cosine < 0.55) slanted += error * error, ++n_slanted;
  }
  REQUIRE(n_facing > 1000);
  REQUIRE(n_slanted > 500);
  CHECK(std::sqrt(facing / double(n_facing)) == Approx(0.05 / 0.975).epsilon(0.05));
  CHECK(std::sqrt(slanted / double(n_slanted)) == Approx(0.1).epsilon(0.1));
}

TEST_CASE("simulate: bit errors come as often as asked for, flip one bit each, and shift nothing else") {
  auto options = small();
  options.sigma = 0.02;
  const auto clean = run(ball(), options);
  options.bit_error = 0.02;
  const auto scan = run(ball(), options);
  std::size_t errors = 0, returns = 0, differing = 0;
  for (std::size_t v = 0; v < scan.views.size(); ++v) {
    errors += scan.views[v].bit_errors;
    returns += clean.views[v].returns;
    for (std::size_t i = 0; i < scan.views[v].image.codes.size(); ++i) {
      const unsigned change = scan.views[v].image.codes[i] ^ clean.views[v].image.codes[i];
      if (change == 0) continue;
      ++differing;
      REQUIRE((change & (change - 1)) == 0);
    }
  }
  CHECK(differing == errors);
  const double expected = 0.02 * double(returns);
  CHECK(std::abs(double(errors) - expected) < 4 * std::sqrt(expected));
}

TEST_CASE("simulate: outliers come as often as asked for and fill the volume") {
  auto options = small();
  options.outliers = 0.05;
  const auto scan = run(ball(), options);
  std::size_t off = 0;
  double farthest = 0;
  for (const auto& p : scan.merged.cloud.points)
    off += std::abs(off_ball(p)) > 0.1, farthest = std::max(farthest, off_ball(p));
  CHECK(double(off) / double(scan.merged.cloud.size()) == Approx(0.05).epsilon(0.15));
  CHECK(farthest > 5);
}

TEST_CASE("simulate: twelve bits give codes below 4096 and coarser steps") {
  auto options = small();
  options.bits = 12;
  options.bit_error = 0.1;
  const auto scan = run(ball(), options);
  for (const auto& view : scan.views) CHECK(*std::max_element(view.image.codes.begin(), view.image.codes.end()) < 4096);
  options.bits = 16;
  CHECK(run(ball(), options).views[0].image.q < scan.views[0].image.q / 15);
}

TEST_CASE("simulate: nothing returns beyond the drop-out angle, all of it below the thinning angle") {
  auto options = small();
  options.drop_angle = radians(50);
  const auto scan = run(ball(), options);
  std::size_t expected = 0;
  const auto& image = scan.views[0].image;
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c) {
      const double x = image.x0 + c * image.pitch_x, y = image.y0 + r * image.pitch_y;
      const bool seen = std::hypot(x, y) < radius * std::sin(radians(50));
      expected += seen;
      CHECK((image.codes[std::size_t(r * image.width + c)] != 0) == seen);
    }
  CHECK(scan.views[0].returns == expected);
}

TEST_CASE("simulate: mixed pixels lie between two depths of a step, and only when asked for") {
  // Two plates, one 10 above the other.
  Surface surface;
  surface.bounds.add(Vec3(-20, -20, 0)), surface.bounds.add(Vec3(20, 20, 10));
  surface.first_hit = [](const Vec3& origin, const Vec3& direction) -> std::optional<SurfaceHit> {
    if (direction.z() >= 0) return {};
    for (const double z : {10.0, 0.0}) {
      const double t = (z - origin.z()) / direction.z();
      const Vec3 p = origin + t * direction;
      if (t > 0 && std::abs(p.y()) < 20 && p.x() > (z > 5 ? 0 : -20) && p.x() < 20) return SurfaceHit{t, Vec3(0, 0, 1)};
    }
    return {};
  };
  auto options = small();
  options.views = "1";  // from above, tilted a little
  options.tilt = 0.05;
  const auto between = [&] {
    std::size_t count = 0;
    for (const auto& p : run(surface, options).merged.cloud.points) count += p.z() > 0.5 && p.z() < 9.5;
    return count;
  };
  CHECK(between() == 0);
  options.mixed = 0.5;
  CHECK(between() > 10);
}

TEST_CASE("simulate: threads change nothing, seeds change the noise") {
  auto options = small();
  options.sigma = 0.1, options.bit_error = 0.01, options.outliers = 0.01, options.mixed = 0.3;
  options.pose_noise_angle = 0.05, options.pose_noise_shift = 1;
  const auto files = files_of(run(ball(), options, 1), options), again = files_of(run(ball(), options, 4), options);
  REQUIRE(files.size() == again.size());
  for (std::size_t i = 0; i < files.size(); ++i) CHECK(files[i].bytes == again[i].bytes);
  options.seed = 2;
  CHECK(files_of(run(ball(), options), options)[0].bytes != files[0].bytes);
}

TEST_CASE("simulate: the files read back as the same scan, in both projections") {
  for (const auto projection : {Projection::orthographic, Projection::pinhole}) {
    auto options = small();
    options.projection = projection;
    options.sigma = 0.03, options.bit_error = 0.001;
    options.pose_noise_angle = 0.05, options.pose_noise_shift = 2;
    const auto scan = run(ball(), options);
    TemporaryDirectory folder;
    for (const auto& file : files_of(scan, options)) REQUIRE(write_file(folder.path() / file.name, file.bytes).ok());
    Context context;
    const auto back = read_scan({folder.path()}, {}, context);
    REQUIRE(back.ok());
    CHECK(back->cloud.pixel == scan.merged.cloud.pixel);
    CHECK(back->cloud.view == scan.merged.cloud.view);
    REQUIRE(back->cloud.size() == scan.merged.cloud.size());
    for (std::size_t i = 0; i < back->cloud.size(); ++i) {
      REQUIRE((back->cloud.points[i] - scan.merged.cloud.points[i]).norm() < 1e-10);
      REQUIRE((back->cloud.rays[i] - scan.merged.cloud.rays[i]).norm() < 1e-12);
    }
    CHECK(back->views[1].has_sensor == (projection == Projection::pinhole));
    CHECK(back->views[3].file == "view_03.png");
    const auto merged = read_scan({folder.path() / "merged.ply"}, {}, context);
    REQUIRE(merged.ok());
    CHECK(merged->cloud.points == scan.merged.cloud.points);
    CHECK(merged->cloud.rays == scan.merged.cloud.rays);
    CHECK(merged->cloud.view == scan.merged.cloud.view);
    // The guess turns the part about itself by the stated angle and moves its centre by the stated length.
    ReadOptions guess;
    guess.initial_guess = true;
    const auto off = read_scan({folder.path()}, guess, context);
    REQUIRE(off.ok());
    for (std::size_t v = 0; v < 4; ++v) {
      const Pose change = off->views[v].world_from_view * scan.views[v].image.world_from_view.inverse();
      CHECK(Eigen::AngleAxisd(change.rotation).angle() == Approx(0.05).epsilon(1e-6));
      CHECK((change * center - center).norm() == Approx(2).epsilon(1e-6));
    }
  }
}

TEST_CASE("surface_of model: rays hit where geometry says, from outside and into the bore") {
  const auto surface = surface_of(cylinder_with_bore());
  // The cylinder lies along -y now: x 7 +- 10, z +- 10, y from -30 to 0.
  CHECK((surface.bounds.low.array() <= Vec3(-3, -30, -10).array() + 1e-9).all());
  CHECK((surface.bounds.high.array() >= Vec3(17, 0, 10).array() - 1e-9).all());
  CHECK(surface.bounds.diagonal() < 1.1 * Vec3(20, 30, 20).norm());
  const auto side = surface.first_hit(Vec3(7, -15, 50), Vec3(0, 0, -1));
  REQUIRE(side);
  CHECK(side->distance == Approx(40).margin(1e-9));
  CHECK((side->normal - Vec3(0, 0, 1)).norm() < 1e-6);
  const auto slanted = surface.first_hit(Vec3(7 + 6, -15, 50), Vec3(0, 0, -1));
  REQUIRE(slanted);
  CHECK(slanted->distance == Approx(42).margin(1e-9));
  CHECK((slanted->normal - Vec3(0.6, 0, 0.8)).norm() < 1e-6);
  const auto face = surface.first_hit(Vec3(7 + 6, 20, 0), Vec3(0, -1, 0));
  REQUIRE(face);
  CHECK(face->distance == Approx(20).margin(1e-9));
  CHECK(!surface.first_hit(Vec3(7 + 3, 20, 0), Vec3(0, -1, 0)));  // through the bore
  const auto wall = surface.first_hit(Vec3(7, 10, 0), Vec3(0, -10, 4).normalized());
  REQUIRE(wall);
  CHECK(wall->distance == Approx(std::hypot(10.0, 4.0)).margin(1e-9));  // where y = 0: the wall's edge
  const auto inner = surface.first_hit(Vec3(7, 10, 0), Vec3(0, -20, 4).normalized());
  REQUIRE(inner);
  CHECK(inner->distance == Approx(std::hypot(20.0, 4.0)).margin(1e-8));
  CHECK((inner->normal - Vec3(0, 0, -1)).norm() < 1e-6);
  CHECK(!surface.first_hit(Vec3(7, -15, 50), Vec3(0, 0, 1)));
  CHECK(!surface.first_hit(Vec3(50, -15, 50), Vec3(0, 0, -1)));
}

TEST_CASE("surface_of mesh: the first triangle is met, its normal facing the ray") {
  TriangleMesh mesh;
  for (const double z : {0.0, 5.0}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {10, 0, z}, {0, 10, z}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const auto surface = surface_of(mesh);
  for (const double side : {1.0, -1.0}) {
    const auto hit = surface.first_hit(Vec3(2, 2, side > 0 ? 20 : -20), Vec3(0, 0, -side));
    REQUIRE(hit);
    CHECK(hit->distance == Approx(side > 0 ? 15 : 20));
    CHECK((hit->normal - Vec3(0, 0, side)).norm() < 1e-12);
  }
  CHECK(!surface.first_hit(Vec3(9, 9, 20), Vec3(0, 0, -1)));
}
