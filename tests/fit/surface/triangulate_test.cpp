#include "fit/surface/triangulate.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "core/number.h"
#include "core/random.h"
#include "core/statistics.h"
#include "fit/build.h"
#include "fit/input/prepare.h"
#include "fit/surface/reconstruct.h"
#include "geometry/io/read_geometry.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/points/kd_tree.h"
#include "testing/drilled_block.h"

using namespace partscribe::fit;
using namespace partscribe::testing;

namespace {

TriangleMesh mesh_of(const Candidate& candidate) {
  const auto& surface = std::get<TriSurface>(candidate.shape);
  TriangleMesh mesh;
  for (const auto& v : surface.vertices) mesh.vertices.push_back({v[0], v[1], v[2]});
  mesh.triangles = surface.triangles;
  return mesh;
}

double signed_distance(const MeshDistance& distance, const TriangleMesh& mesh, const Vec3& p) {
  const MeshHit hit = distance.closest(p);
  return triangle_normal(mesh, hit.triangle).dot(p - hit.point) < 0 ? -hit.distance : hit.distance;
}

/// The largest local robust mean of the kept points' signed distances.
double local_max(const PointCloud& all, const TriangleMesh& mesh, Vec3* where = nullptr) {
  PointCloud cloud;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all.rejected.empty() || !all.rejected[i])
      cloud.points.push_back(all.points[i]), cloud.normals.push_back(all.normals[i]);
  const MeshDistance distance(mesh);
  const KdTree tree(cloud.points);
  std::vector<double> off;
  for (const Vec3& p : cloud.points) off.push_back(signed_distance(distance, mesh, p));
  double worst = 0;
  std::vector<Neighbour> near;
  const std::size_t step = 1 + cloud.size() / 40000;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    tree.nearest(cloud.points[i], 60, near);
    std::vector<double> values;
    for (const Neighbour& n : near)
      if (std::abs(cloud.normals[n.index].dot(cloud.normals[i])) > 0.7 && values.size() < 25)
        values.push_back(off[n.index]);
    if (values.size() < 12) continue;
    const double mean = robust_mean(values).mean;
    if (std::abs(mean) > std::abs(worst)) {
      worst = mean;
      if (where) *where = cloud.points[i];
    }
  }
  return std::abs(worst);
}

Vec3 direction(Random& random) { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); }

/// A block with a cylindrical step on top, noisy, with some bit errors; `with_rays` tells the outside.
Scan block(std::size_t count, double sigma, bool with_rays, std::uint64_t seed) {
  Random random(seed);
  Scan scan;
  while (scan.cloud.size() < count) {
    Vec3 p, n = Vec3::Zero();
    const double choice = random.uniform() * (2 * 30 * 20 + 2 * 30 * 10 + 2 * 20 * 10 + 2 * pi * 7 * 6);
    if (choice < 2200) {
      const Vec3 half(15, 10, 5);
      p = Vec3(random.uniform(-15, 15), random.uniform(-10, 10), random.uniform(-5, 5));
      const int axis = choice < 1200 ? 2 : choice < 1800 ? 1 : 0;
      n[axis] = random.uniform() < 0.5 ? -1 : 1;
      p[axis] = n[axis] * half[axis];
      if (n.z() > 0 && p.head<2>().norm() < 7) p.z() += 6;
    } else {
      const double angle = random.uniform(0, 2 * pi);
      n = Vec3(std::cos(angle), std::sin(angle), 0);
      p = 7 * n;
      p.z() = random.uniform(5, 11);
    }
    p += sigma * random.normal() * n;
    if (random.uniform() < 0.002) p += n * random.uniform(1, 5);
    scan.cloud.points.push_back(p);
    if (with_rays) scan.cloud.rays.push_back((-n + 0.4 * direction(random)).normalized());
  }
  return scan;
}

Candidate triangulated(Scan& scan, double tolerance, Context& context) {
  auto input = prepare(scan, tolerance, context);
  REQUIRE(input.ok());
  auto result = Triangulator(*input, context).within(input->tolerance);
  if (!result.ok()) FAIL(result.error().message);
  return std::move(*result);
}

}  // namespace

TEST_CASE("triangulate: a noisy block with a step becomes a small closed solid within tolerance, edges included") {
  Context context;
  context.threads = 2;
  for (const bool with_rays : {true, false}) {
    Scan scan = block(60000, 0.03, with_rays, 5);
    const Candidate candidate = triangulated(scan, 0.15, context);
    const TriangleMesh mesh = mesh_of(candidate);
    INFO("rays " << with_rays << ", triangles " << mesh.triangles.size());
    CHECK(std::get<TriSurface>(candidate.shape).closed);
    CHECK(topology(mesh).closed());
    CHECK(topology(mesh).components == 1);
    CHECK(candidate.parameters.empty());
    CHECK(volume(mesh) == Approx(6000 + 3.14159 * 49 * 6).epsilon(0.004));
    CHECK(local_max(scan.cloud, mesh) < 0.15);
    CHECK(mesh.triangles.size() < 2000);
    CHECK(self_intersections(mesh).empty());
  }
}

TEST_CASE(
    "triangulate: a block with holes beside thin walls is one solid, though nobody knows from where it was seen") {
  Context context;
  context.threads = 2;
  Random random(41);
  Scan scan;
  const DrilledBlock block{{20, 12, 6}, {{-13, -8.2}, {0, 8.2}, {13, -8.2}}, 3};  // 0.8 mm from the side
  while (scan.cloud.size() < 80000) {
    const auto place = block.draw(random);
    scan.cloud.points.push_back(place.point + 0.02 * random.normal() * place.normal);
  }
  const TriangleMesh mesh = mesh_of(triangulated(scan, 0.15, context));
  CHECK(topology(mesh).closed());
  CHECK(topology(mesh).components == 1);
  CHECK(volume(mesh) == Approx(8 * 20 * 12 * 6 - 3 * pi * 9 * 12).epsilon(0.004));
  CHECK(local_max(scan.cloud, mesh) < 0.15);
  const auto vertices = static_cast<long>(mesh.vertices.size()), triangles = static_cast<long>(mesh.triangles.size());
  CHECK(vertices - triangles / 2 == 2 - 2 * 3);  // three holes [Euler]
}

TEST_CASE("triangulate: along its normal every place of a round surface meets the triangles within the tolerance") {
  // r(d) = 10 + 0.8 sin(4 x) sin(3 y) sin(4 z) in the direction d; its normal is the gradient of |p| - r.
  const auto bump = [](const Vec3& d) {
    return 10 + 0.8 * std::sin(4 * d.x()) * std::sin(3 * d.y()) * std::sin(4 * d.z());
  };
  const auto normal_at = [&](const Vec3& p) {
    Vec3 n;
    for (int k = 0; k < 3; ++k) {
      const auto level = [&](const Vec3& q) { return q.norm() - bump(q.normalized()); };
      n[k] = level(p + 1e-5 * Vec3::Unit(k)) - level(p - 1e-5 * Vec3::Unit(k));
    }
    return Vec3(n.normalized());
  };
  Context context;
  context.threads = 2;
  Random random(23);
  Scan scan;
  while (scan.cloud.size() < 40000) {
    const Vec3 d = direction(random), p = bump(d) * d, n = normal_at(p);
    scan.cloud.points.push_back(p + 0.01 * random.normal() * n), scan.cloud.rays.push_back(-n);
  }
  auto input = prepare(scan, 0.1, context);
  REQUIRE(input.ok());
  Triangulator triangulator(*input, context);
  std::size_t before = 0;
  for (const double tolerance : {0.4, 0.1}) {
    const auto candidate = triangulator.within(tolerance);
    REQUIRE(candidate.ok());
    const TriangleMesh mesh = mesh_of(*candidate);
    CHECK(topology(mesh).closed());
    CHECK(mesh.triangles.size() > before);
    before = mesh.triangles.size();
    const MeshDistance distance(mesh);
    std::size_t beyond = 0, beyond_a_tenth = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 d = direction(random), p = bump(d) * d, n = normal_at(p);
      beyond += !distance.first_hit(p - tolerance * n, n, 2 * tolerance);
      beyond_a_tenth += !distance.first_hit(p - 0.1 * tolerance * n, n, 0.2 * tolerance);
    }
    INFO("tolerance " << tolerance << ", triangles " << mesh.triangles.size());
    CHECK(beyond == 0);
    CHECK(beyond_a_tenth > 1000);  // the rays can miss
  }
}

TEST_CASE("triangulate: a ball with an unseen cap is closed, its free half stays round") {
  Context context;
  Random random(8);
  Scan scan;
  while (scan.cloud.size() < 30000) {
    const Vec3 d = direction(random);
    if (d.z() < -0.8) continue;
    scan.cloud.points.push_back((10 + 0.02 * random.normal()) * d);
    scan.cloud.rays.push_back(-d);
  }
  const Candidate candidate = triangulated(scan, 0.1, context);
  const TriangleMesh mesh = mesh_of(candidate);
  CHECK(std::get<TriSurface>(candidate.shape).closed);
  CHECK(topology(mesh).closed());
  CHECK(local_max(scan.cloud, mesh) < 0.1);
}

namespace {

/// A cup with walls of 0.35 mm, inside and outside seen, and 2 % outliers among the points.
struct Cup {
  static constexpr double outer = 8, inner = 7.65, height = 12, floor = 1;
  Scan scan;
  std::vector<std::uint8_t> outlier;

  Cup(std::size_t count, double sigma, std::uint64_t seed) {
    Random random(seed);
    while (scan.cloud.size() < count) {
      const double angle = random.uniform(0, 2 * pi), choice = random.uniform();
      const Vec3 radial(std::cos(angle), std::sin(angle), 0);
      // Seen through the opening.
      const auto within = [&](double radius) {
        Vec3 p = direction(random);
        p.z() = 0;
        return Vec3(p.normalized() * (radius * std::sqrt(random.uniform())));
      };
      const Vec3 from = within(0.9 * inner) + Vec3(0, 0, height);
      Vec3 p, n, ray;
      if (choice < 0.38) {
        n = radial, p = outer * n + Vec3(0, 0, random.uniform(0, height)),
        ray = (-n + 0.3 * direction(random)).normalized();
      } else if (choice < 0.71) {
        n = -radial, p = -inner * n + Vec3(0, 0, random.uniform(floor, height)), ray = (p - from).normalized();
      } else if (choice < 0.84) {
        n = Vec3::UnitZ(), p = within(inner) + floor * n, ray = (p - from).normalized();
      } else if (choice < 0.99) {
        n = -Vec3::UnitZ(), p = within(outer), ray = -n;
      } else {
        n = Vec3::UnitZ(), p = random.uniform(inner, outer) * radial + height * n, ray = -n;
      }
      p += sigma * random.normal() * n;
      outlier.push_back(random.uniform() < 0.02);
      if (outlier.back()) p -= ray * random.uniform(0.5, 5);
      scan.cloud.points.push_back(p), scan.cloud.rays.push_back(ray);
    }
  }
};

}  // namespace

TEST_CASE("triangulate: a cup of thin walls keeps its inside, and nothing stands where its sensors looked through") {
  Context context;
  context.threads = 2;
  Cup cup(60000, 0.02, 3);
  const PointCloud seen = cup.scan.cloud;
  const Candidate candidate = triangulated(cup.scan, 0.2, context);
  const TriangleMesh mesh = mesh_of(candidate);
  CHECK(std::get<TriSurface>(candidate.shape).closed);
  CHECK(topology(mesh).closed());
  CHECK(topology(mesh).components == 1);
  const double whole = pi * (64 * 12 - Cup::inner * Cup::inner * 11);
  CHECK(volume(mesh) == Approx(whole).epsilon(0.03));
  const MeshDistance distance(mesh);
  CHECK(signed_distance(distance, mesh, Vec3(0, 0, 6)) > 4.5);
  CHECK(signed_distance(distance, mesh, Vec3(7.825, 0, 6)) < 0);
  std::size_t hidden = 0, off = 0, asked = 0;
  for (std::size_t i = 0; i < seen.size(); i += 3) {
    if (cup.outlier[i]) continue;
    const Vec3 from = seen.points[i] - 40 * seen.rays[i];
    hidden += distance.first_hit(from, seen.rays[i], 40 - 0.5).has_value();
    off += distance.closest(seen.points[i]).distance > 0.2;
    ++asked;
  }
  INFO("triangles " << mesh.triangles.size() << ", hidden " << hidden << ", off " << off << " of " << asked);
  CHECK(hidden * 100 < asked);
  CHECK(off * 500 < asked);
}

TEST_CASE("triangulate: a strip of two rows, whose normals lie within it, faces its sensor") {
  Context context;
  Random random(9);
  Scan scan;
  const auto add = [&](const Vec3& d, const Vec3& normal, double radius = 10) {
    scan.cloud.points.push_back((radius + 0.01 * random.normal()) * d);
    scan.cloud.rays.push_back(-d), scan.cloud.normals.push_back(normal);
  };
  while (scan.cloud.size() < 20000) {
    const Vec3 d = direction(random);
    if (std::abs(d.z()) > 0.25) add(d, d);
  }
  std::vector<Vec3> strip;  // on the ground of a groove
  for (int k = 0; k < 160; ++k) {
    const double angle = 0.006 * (k / 2), z = 0.01 * (k % 2), around = std::sqrt(1 - z * z);
    add({around * std::cos(angle), around * std::sin(angle), z}, k % 4 < 2 ? Vec3::UnitZ() : Vec3(-Vec3::UnitZ()), 9.3);
    strip.push_back(scan.cloud.points.back());
  }
  SamplingSummary sampling;
  sampling.spacing = 0.12, sampling.sigma = 0.01;
  const Reconstruction found = reconstruct(scan.cloud, sampling, {}, context);
  CHECK(found.closed);
  const MeshDistance distance(found.mesh);
  int hidden = 0;
  for (const Vec3& p : strip) hidden += distance.first_hit(2 * p, -p.normalized(), p.norm() - 0.25).has_value();
  CHECK(hidden == 0);
}

namespace {

/// A dense ball with a groove, in whose ground one view saw a strip of three rows, five times as far apart as other
/// points.
struct GroovedBall {
  Scan scan;
  std::vector<Vec3> strip;

  explicit GroovedBall(std::uint64_t seed) {
    Random random(seed);
    const auto add = [&](const Vec3& d, double radius) {
      scan.cloud.points.push_back((radius + 0.01 * random.normal()) * d);
      scan.cloud.rays.push_back(-d), scan.cloud.normals.push_back(d);
    };
    while (scan.cloud.size() < 40000) {
      const Vec3 d = direction(random);
      if (std::abs(d.z()) > 0.25) add(d, 10);
    }
    for (int k = 0; k < 120; ++k) {
      const double angle = 0.065 * (k / 3), z = 0.065 * (k % 3 - 1), around = std::sqrt(1 - z * z);
      add({around * std::cos(angle), around * std::sin(angle), z}, 9.3);
      strip.push_back(scan.cloud.points.back());
    }
  }
};

}  // namespace

TEST_CASE("triangulate: a place that one view saw is followed, though its points are farther apart than the others") {
  Context context;
  const GroovedBall ball(4);
  SamplingSummary sampling;
  sampling.spacing = 0.11, sampling.sigma = 0.01;
  const Reconstruction found = reconstruct(ball.scan.cloud, sampling, {}, context);
  CHECK(found.closed);
  const MeshDistance distance(found.mesh);
  int off = 0;
  for (const Vec3& p : ball.strip) off += distance.closest(p).distance > 0.08;
  INFO(off << " of " << ball.strip.size() << " points are off, cells of " << found.cell << " mm");
  CHECK(off * 10 < int(ball.strip.size()));
}

TEST_CASE("triangulate: of a scan with hardly an outlier no surface is set aside") {
  Context context;
  context.threads = 2;
  GroovedBall ball(5);
  Scan scan = std::move(ball.scan);
  BuildOptions options;
  options.tolerance = 0.1, options.force = "triangulation";
  const auto model = build_model(scan, options, context);
  REQUIRE(model.ok());
  const std::size_t first = scan.cloud.size() - ball.strip.size();
  CHECK(std::count(scan.cloud.rejected.begin() + std::ptrdiff_t(first), scan.cloud.rejected.end(), 1) * 10 <
        int(ball.strip.size()));
}

TEST_CASE("triangulate: simplified again and again, from the same surface") {
  Context context;
  Scan scan = block(20000, 0.03, true, 6);
  auto input = prepare(scan, 0.2, context);
  REQUIRE(input.ok());
  Triangulator triangulator(*input, context);
  CHECK_FALSE(triangulator.unsimplified());
  const auto coarse = triangulator.within(0.4), fine = triangulator.within(0.1);
  REQUIRE(coarse.ok());
  REQUIRE(fine.ok());
  const auto surface = triangulator.unsimplified();
  REQUIRE(surface);
  const auto triangles = [](const Candidate& c) { return std::get<TriSurface>(c.shape).triangles.size(); };
  CHECK(triangles(*coarse) < triangles(*fine));
  CHECK(triangles(*fine) < triangles(*surface));
  const auto alone = Triangulator(*input, context).within(0.1);
  REQUIRE(alone.ok());
  CHECK(mesh_of(*alone).vertices == mesh_of(*fine).vertices);
}

TEST_CASE("triangulate: a face does not reach beyond its rim into a hole that was looked through") {
  constexpr double hole = 4, outside = 12, half = 4;  // a disc
  Context context;
  context.threads = 2;
  Random random(4);
  Scan scan;
  const auto add = [&](const Vec3& p, const Vec3& ray) {
    scan.cloud.points.push_back(p + 0.02 * random.normal() * ray), scan.cloud.rays.push_back(ray);
  };
  // Sensors above and below stand on one side, so that they see one half of the hole's wall.
  const double tilt = 0.5, pitch = 0.25;
  for (const double up : {1.0, -1.0})
    for (double x = -outside; x < outside; x += pitch)
      for (double y = -outside; y < outside; y += pitch) {
        const Vec3 ray(std::sin(tilt), 0, -up * std::cos(tilt)), top(x, y, up * half);
        const double r = std::hypot(x, y);
        if (r > outside) continue;
        if (r > hole) {
          add(top, ray);
          continue;
        }
        const double along = (-x + std::sqrt(hole * hole - y * y)) / ray.x();  // to the wall
        const Vec3 wall = top + along * ray;
        if (std::abs(wall.z()) < half && wall.x() / hole * ray.x() > 0.17) add(wall, ray);
      }
  for (int i = 0; i < 12000; ++i) {
    const double angle = random.uniform(0, 2 * pi);
    const Vec3 out(std::cos(angle), std::sin(angle), 0);
    add(outside * out + Vec3(0, 0, random.uniform(-half, half)), -out);
  }
  const PointCloud seen = scan.cloud;
  const TriangleMesh mesh = mesh_of(triangulated(scan, 0.25, context));
  CHECK(topology(mesh).closed());
  const MeshDistance distance(mesh);
  int hidden = 0;
  double innermost = hole;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (const auto hit = distance.first_hit(seen.points[i] - 40 * seen.rays[i], seen.rays[i], 40 - 0.5)) {
      const double r = hit->point.head<2>().norm();
      innermost = std::min(innermost, r);
      hidden += r < hole - 0.25;  // an edge may lie within the tolerance of its place
    }
  INFO("hidden " << hidden << " of " << seen.size() << ", by what reaches in to " << innermost << " from the axis");
  CHECK(hidden < 15);
  CHECK(innermost > hole - 0.6);
}

TEST_CASE("triangulate: points without rays beside others with rays, and points without normals, do no harm") {
  Context context;
  Scan scan = block(30000, 0.03, true, 6);
  for (std::size_t i = 0; i < scan.cloud.size(); i += 2) scan.cloud.rays[i].setZero();  // as of a file without rays
  auto input = prepare(scan, 0.15, context);
  REQUIRE(input.ok());
  const Reconstruction found = reconstruct(scan.cloud, input->sampling, {}, context);
  CHECK_FALSE(found.mesh.empty());
  PointCloud flat = scan.cloud;
  flat.normals.assign(flat.size(), Vec3::Zero());
  CHECK(reconstruct(flat, input->sampling, {}, context).mesh.empty());
}

TEST_CASE("triangulate: a sheet seen from one side stays open and gets a named thickness") {
  Context context;
  Random random(4);
  Scan scan;
  for (int i = 0; i < 30000; ++i) {
    const double x = random.uniform(-20, 20), y = random.uniform(-15, 15);
    scan.cloud.points.push_back({x, y, 2 * std::sin(0.2 * x) * std::cos(0.15 * y) + 0.02 * random.normal()});
    scan.cloud.rays.push_back({0, 0, -1});
  }
  const Candidate candidate = triangulated(scan, 0.1, context);
  const TriangleMesh mesh = mesh_of(candidate);
  const auto& surface = std::get<TriSurface>(candidate.shape);
  CHECK_FALSE(surface.closed);
  REQUIRE(candidate.parameters.size() == 1);
  CHECK(candidate.parameters[0].name == "sheet_thickness");
  CHECK(candidate.parameters[0].value == 2);
  CHECK(topology(mesh).nonmanifold_edges == 0);
  CHECK(topology(mesh).inconsistent_edges == 0);
  CHECK(local_max(scan.cloud, mesh) < 0.1);
  // Seen from the sensor above: the triangles face it.
  double up = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) up += triangle_normal(mesh, t).z() > 0 ? 1 : -1;
  CHECK(up > 0.97 * static_cast<double>(mesh.triangles.size()));
}

TEST_CASE("triangulate: the order of points and the number of threads do not change a single digit") {
  Context context;
  Scan scan = block(20000, 0.03, true, 9), shuffled;
  std::vector<std::size_t> order(scan.cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  Random random(2);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  for (const std::size_t i : order) {
    shuffled.cloud.points.push_back(scan.cloud.points[i]);
    shuffled.cloud.rays.push_back(scan.cloud.rays[i]);
  }
  const Candidate one = triangulated(scan, 0.15, context);
  context.threads = 3;
  const Candidate two = triangulated(shuffled, 0.15, context);
  CHECK(one.shape == two.shape);
}

TEST_CASE("triangulate: a source mesh keeps within tolerance, holes are closed, vertices lie on a decimal grid") {
  Context context;
  Scan scan;
  const int rings = 60, sides = 120;
  // A vase: its foot is open by a ring of missing triangles.
  auto add = [&](double r, double z) {
    for (int k = 0; k < sides; ++k) {
      const double a = 2 * pi * k / sides;
      scan.mesh.vertices.push_back({r * std::cos(a), r * std::sin(a), z});
    }
  };
  for (int i = 0; i <= rings; ++i) {
    const double s = static_cast<double>(i) / rings;
    add(4 + 8 * std::sin(3 * s), 40 * s);
  }
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < sides; ++k) {
      const auto a = static_cast<std::uint32_t>(i * sides + k),
                 b = static_cast<std::uint32_t>(i * sides + (k + 1) % sides);
      const auto n = static_cast<std::uint32_t>(sides);
      scan.mesh.triangles.push_back({a, b, b + n});
      scan.mesh.triangles.push_back({a, b + n, a + n});
    }
  scan.cloud.points = scan.mesh.vertices;
  scan.cloud.normals = vertex_normals(scan.mesh);
  const TriangleMesh source = scan.mesh;
  const Candidate candidate = triangulated(scan, 0.2, context);
  const TriangleMesh mesh = mesh_of(candidate);
  CHECK(std::get<TriSurface>(candidate.shape).closed);
  CHECK(topology(mesh).closed());
  CHECK(mesh.triangles.size() < source.triangles.size() / 4);
  const MeshDistance distance(mesh);
  for (const Vec3& v : source.vertices) REQUIRE(distance.closest(v).distance < 0.2);
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) REQUIRE(std::abs(v[k] * 100 - std::round(v[k] * 100)) < 1e-6);
}

TEST_CASE("triangulate: bad input, points on a line, is refused in one line") {
  Context context;
  Scan scan;
  for (int i = 0; i < 200; ++i) scan.cloud.points.push_back({0.1 * i, 0, 0});
  auto input = prepare(scan, 0.1, context);
  if (input.ok()) {
    const auto result = Triangulator(*input, context).within(input->tolerance);
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().message.find("expected points that lie on a surface") != std::string::npos);
  }
}

TEST_CASE("triangulate: files named in TRY_SCANS as path:scale:tolerance,...", "[.try]") {
  const char* names = std::getenv("TRY_SCANS");
  if (!names) return;
  Context context;
  context.threads = 2;
  context.log = [](const std::string& line) { WARN(line); };
  std::istringstream list(names);
  for (std::string item; std::getline(list, item, ',');) {
    const auto second = item.rfind(':'), first = item.rfind(':', second - 1);
    const double scale = std::atof(item.substr(first + 1).c_str()),
                 tolerance = std::atof(item.substr(second + 1).c_str());
    auto raw = read_geometry(item.substr(0, first), context);
    REQUIRE(raw.ok());
    Scan scan;
    scan.mesh = raw->mesh;
    scan.cloud = raw->cloud;
    for (Vec3& v : scan.mesh.vertices) v *= scale;
    for (Vec3& v : scan.cloud.points) v *= scale;
    if (!scan.mesh.empty()) scan.cloud.normals = vertex_normals(scan.mesh);
    const auto start = std::chrono::steady_clock::now();
    auto input = prepare(scan, tolerance, context);
    REQUIRE(input.ok());
    const auto middle = std::chrono::steady_clock::now();
    const auto candidate = Triangulator(*input, context).within(input->tolerance);
    const auto end = std::chrono::steady_clock::now();
    REQUIRE(candidate.ok());
    const TriangleMesh mesh = mesh_of(*candidate);
    const MeshTopology top = topology(mesh);
    Vec3 where = Vec3::Zero();
    const double worst = local_max(scan.cloud, mesh, &where);
    const MeshDistance distance(mesh);
    double raw_max = 0;
    for (std::size_t i = 0; i < scan.cloud.size(); ++i)
      if (!scan.cloud.rejected[i]) {
        const double d = distance.closest(scan.cloud.points[i]).distance;
        raw_max = std::max(raw_max, d);
      }
    WARN(item << "\n points " << scan.cloud.size() << " rejected " << input->sampling.rejected << " sigma "
              << input->sampling.sigma << " spacing " << input->sampling.spacing << "\n triangles "
              << scan.mesh.triangles.size() << " -> " << mesh.triangles.size() << " closed "
              << std::get<TriSurface>(candidate->shape).closed << " boundary " << top.boundary_edges << " components "
              << top.components << " volume " << volume(mesh) << " crossings " << self_intersections(mesh).size()
              << "\n local max " << worst << " at " << where.transpose() << ", raw max " << raw_max << "\n prepare "
              << std::chrono::duration<double>(middle - start).count() << " s, triangulate "
              << std::chrono::duration<double>(end - middle).count() << " s");
    if (const char* out = std::getenv("TRY_OUT")) CHECK(write_file(out, write_stl(mesh)).ok());
  }
}
