/// Blocks, wedges and convex polyhedra from noisy points whose normals have no sense, some faces never scanned.
#include "fit/propose/half_spaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/number.h"
#include "core/random.h"
#include "fit/evidence/evidence.h"
#include "fit/propose/convex_body.h"
#include "fit/search/rivals.h"
#include "geometry/mesh/convex.h"

using namespace partscribe::fit;

namespace {

/// Even random points on the faces of a convex body, in a turned frame, with noise along the normal and normals of
/// random sense; `seen` says which faces were scanned.
FitInput scanned(const std::vector<Plane3>& planes, double noise, double outliers,
                 const std::function<bool(const Vec3& normal)>& seen, std::uint64_t seed, double density = 1.0) {
  Random random(seed);
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  const TriangleMesh mesh = triangulated(convex_polyhedron(planes).value());
  FitInput input;
  std::vector<std::pair<Vec3, Vec3>> drawn;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 n = triangle_normal(mesh, t), a = mesh.corner(t, 0), u = mesh.corner(t, 1) - a,
               v = mesh.corner(t, 2) - a;
    if (!seen(n)) continue;
    const auto count = static_cast<int>(0.5 * u.cross(v).norm() * density);
    for (int i = 0; i < count; ++i) {
      double r = random.uniform(), s = random.uniform();
      if (r + s > 1) r = 1 - r, s = 1 - s;
      drawn.emplace_back(a + r * u + s * v + noise * random.normal() * n,
                         (n + 0.05 * Vec3(random.normal(), random.normal(), random.normal())).normalized());
    }
  }
  for (const auto& [p, n] : drawn) {
    const bool wild = random.uniform() < outliers;
    const Vec3 q = wild ? Vec3(p + 8 * Vec3(random.normal(), random.normal(), random.normal())) : p;
    const Vec3 m = wild ? Vec3(random.normal(), random.normal(), random.normal()).normalized() : n;
    input.cloud.points.push_back(pose * q);
    input.cloud.normals.push_back((random.uniform() < 0.5 ? -1 : 1) * (pose.rotation * m));
  }
  input.cloud.sigma.assign(input.cloud.size(), static_cast<float>(noise));
  input.sampling.sigma = noise;
  input.sampling.spacing = input.thin_spacing = std::sqrt(1 / density);
  input.tolerance = 0.2;
  input.bounds = input.cloud.bounds();
  return input;
}

std::vector<Plane3> block(double x, double y, double z) {
  return {{{1, 0, 0}, x}, {{-1, 0, 0}, 0}, {{0, 1, 0}, y}, {{0, -1, 0}, 0}, {{0, 0, 1}, z}, {{0, 0, -1}, 0}};
}

bool all(const Vec3&) { return true; }

double value(const Candidate& c, const std::string& name) {
  for (const Parameter& p : c.parameters)
    if (p.name == name) return p.value;
  FAIL("no parameter " << name);
  return 0;
}

const Candidate* find(const std::vector<Candidate>& candidates, const std::string& procedure) {
  for (const Candidate& c : candidates)
    if (c.procedure == procedure) return &c;
  return nullptr;
}

/// Every corner of the body, moved into the scan, lies on at least three of the candidate's faces.
double worst_corner(const Candidate& c, const std::vector<Plane3>& truth) {
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  const auto& shape = std::get<HalfSpaces>(c.shape);
  Values values;
  for (const Parameter& p : c.parameters) values[p.name] = p.value;
  double worst = 0;
  const ConvexPolyhedron body = convex_polyhedron(truth).value();
  for (const Vec3& v : body.vertices) {
    const Vec3 q = c.scan_from_part.inverse() * (pose * v);
    std::vector<double> d;
    for (const HalfSpace& h : shape.planes)
      d.push_back(std::abs(evaluate(h.normal_x, values) * q.x() + evaluate(h.normal_y, values) * q.y() +
                           evaluate(h.normal_z, values) * q.z() - evaluate(h.offset, values)));
    std::sort(d.begin(), d.end());
    worst = std::max(worst, d[2]);
  }
  return worst;
}

}  // namespace

TEST_CASE("half spaces: a noisy block is proposed as a box with its three sizes, a corner at the origin") {
  Context context;
  const auto candidates = propose_polyhedra(scanned(block(60, 35, 22), 0.03, 0.0, all, 1), context);
  REQUIRE(candidates.size() == 2);
  const Candidate& box = candidates[0];
  CHECK(box.procedure == "box");
  CHECK(value(box, "length") == Approx(60).margin(0.02));
  CHECK(value(box, "width") == Approx(35).margin(0.02));
  CHECK(value(box, "height") == Approx(22).margin(0.02));
  CHECK(box.scan_from_part.rotation.determinant() == Approx(1));
  // The box covers the block: its far corner is one of the block's.
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  const Vec3 far = pose.inverse() * (box.scan_from_part * Vec3(60, 35, 22));
  for (int k = 0; k < 3; ++k) CHECK(std::min(std::abs(far[k]), std::abs(far[k] - Vec3(60, 35, 22)[k])) < 0.06);
  CHECK(candidates[1].procedure == "convex polyhedron");
  CHECK(worst_corner(candidates[1], block(60, 35, 22)) < 0.05);
}

TEST_CASE("half spaces: a block keeps its sizes with 4 % outliers and when the scan never saw its bottom") {
  Context context;
  const auto seen = [](const Vec3& n) { return n.z() > -0.5; };
  for (double outliers : {0.0, 0.04}) {
    const auto candidates = propose_polyhedra(scanned(block(60, 35, 22), 0.03, outliers, seen, 2), context);
    INFO("outliers " << outliers);
    const Candidate* box = find(candidates, "box");
    REQUIRE(box);
    CHECK(value(*box, "length") == Approx(60).margin(0.03));
    CHECK(value(*box, "width") == Approx(35).margin(0.03));
    // The bottom is where the data end.
    CHECK(value(*box, "height") == Approx(22).margin(0.25));
    CHECK(box->parameters[2].note.find("not scanned") != std::string::npos);
  }
}

TEST_CASE("half spaces: a block seen from one corner closes where the data end") {
  Context context;
  const auto seen = [](const Vec3& n) { return n.sum() > 0; };
  const auto candidates = propose_polyhedra(scanned(block(60, 35, 22), 0.02, 0, seen, 3), context);
  const Candidate* box = find(candidates, "box");
  REQUIRE(box);
  CHECK(value(*box, "length") == Approx(60).margin(0.25));
  CHECK(value(*box, "width") == Approx(35).margin(0.2));
  CHECK(value(*box, "height") == Approx(22).margin(0.2));
}

TEST_CASE("half spaces: two faces alone do not make a body") {
  Context context;
  const auto seen = [](const Vec3& n) { return n.x() + n.y() > 0.5; };
  CHECK(propose_polyhedra(scanned(block(60, 35, 22), 0.02, 0, seen, 3), context).empty());
}

TEST_CASE("half spaces: a right-angled wedge is proposed as a wedge, whole or with its tip cut off") {
  Context context;
  const Vec3 slope = Vec3(30, 50, 0).normalized();
  std::vector<Plane3> wedge = {
      {{-1, 0, 0}, 0}, {{0, -1, 0}, 0}, {{0, 0, 1}, 25}, {{0, 0, -1}, 0}, {slope, slope.x() * 50}};
  const auto whole = propose_polyhedra(scanned(wedge, 0.03, 0, all, 4), context);
  const Candidate* c = find(whole, "wedge");
  REQUIRE(c);
  CHECK(find(whole, "box") == nullptr);
  CHECK(value(*c, "foot_length") == Approx(50).margin(0.1));
  CHECK(value(*c, "height") == Approx(30).margin(0.1));
  CHECK(value(*c, "width") == Approx(25).margin(0.05));
  CHECK(std::get<Wedge>(c->shape).top_x == Expr(0));

  wedge.push_back({{0, 1, 0}, 18});
  const auto cut = propose_polyhedra(scanned(wedge, 0.03, 0, all, 5), context);
  c = find(cut, "wedge");
  REQUIRE(c);
  CHECK(value(*c, "foot_length") == Approx(50).margin(0.1));
  CHECK(value(*c, "height") == Approx(18).margin(0.05));
  CHECK(value(*c, "top_length") == Approx(20).margin(0.1));
  // The wedge's sloped corner lies where the scan has it.
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  const Vec3 q = pose.inverse() * (c->scan_from_part * Vec3(20, 18, 0));
  CHECK(q.x() == Approx(20).margin(0.1));
  CHECK(q.y() == Approx(18).margin(0.1));
  CHECK(std::min(std::abs(q.z()), std::abs(q.z() - 25)) < 0.1);
}

TEST_CASE("half spaces: an oblique hexahedron and a pyramid come as polyhedra, not as boxes") {
  Context context;
  std::vector<Plane3> hexahedron = block(50, 40, 30);
  hexahedron[0].normal = Vec3(1, 0.2, 0.1).normalized();
  hexahedron[2].normal = Vec3(0.1, 1, -0.25).normalized();
  auto candidates = propose_polyhedra(scanned(hexahedron, 0.03, 0, all, 6), context);
  REQUIRE(candidates.size() == 1);
  CHECK(candidates[0].procedure == "convex polyhedron");
  CHECK(worst_corner(candidates[0], hexahedron) < 0.05);
  CHECK(candidates[0].extra_numbers == 12);

  std::vector<Plane3> pyramid = {{{0, 0, -1}, 0}};
  for (int k = 0; k < 4; ++k)
    pyramid.push_back({Vec3(std::cos(k * pi / 2), std::sin(k * pi / 2), 0.8).normalized(), 20});
  candidates = propose_polyhedra(scanned(pyramid, 0.03, 0, all, 7), context);
  REQUIRE(candidates.size() == 1);
  CHECK(worst_corner(candidates[0], pyramid) < 0.08);
  // Its base unscanned: what the sides' areas leave over is the direction of the missing face.
  candidates = propose_polyhedra(scanned(
                                     pyramid, 0.03, 0, [](const Vec3& n) { return n.z() > 0; }, 8),
                                 context);
  // Beside it stand only wedges, for a face that was not seen may lean.
  CHECK(std::count_if(candidates.begin(), candidates.end(),
                      [](const Candidate& c) { return !std::holds_alternative<Wedge>(c.shape); }) == 1);
  const Candidate* open = find(candidates, "convex polyhedron");
  REQUIRE(open);
  CHECK(worst_corner(*open, pyramid) < 1.5);
}

TEST_CASE("half spaces: an L-shaped body and a ball are no convex bodies with plane faces") {
  Context context;
  // An L: the block 60 x 40 x 25 without its quarter x > 20, y > 15.
  Random random(9);
  FitInput input = scanned(block(60, 40, 25), 0.02, 0, all, 9);
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  PointCloud cloud;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 q = pose.inverse() * input.cloud.points[i];
    if (q.x() > 20 && q.y() > 15) continue;
    cloud.points.push_back(input.cloud.points[i]), cloud.normals.push_back(input.cloud.normals[i]);
  }
  for (int i = 0; i < 1600; ++i) {
    const bool first = i % 2 == 0;
    const Vec3 q(first ? 20 : random.uniform(20, 60), first ? random.uniform(15, 40) : 15, random.uniform(0, 25));
    cloud.points.push_back(pose * q);
    cloud.normals.push_back(pose.rotation * (first ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  }
  input.cloud = cloud;
  CHECK(propose_polyhedra(input, context).empty());

  FitInput ball = input;
  ball.cloud = {};
  for (int i = 0; i < 6000; ++i) {
    const Vec3 n = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    ball.cloud.points.push_back(30 * n), ball.cloud.normals.push_back(n);
  }
  ball.bounds = ball.cloud.bounds();
  CHECK(propose_polyhedra(ball, context).empty());
}

TEST_CASE("half spaces: no points, or points without normals, give no proposal") {
  Context context;
  FitInput input;
  CHECK(propose_polyhedra(input, context).empty());
  input = scanned(block(10, 10, 10), 0.01, 0, all, 1, 3);
  input.cloud.normals.clear();
  CHECK(propose_polyhedra(input, context).empty());
}

TEST_CASE(
    "wedges: among outliers a block whose side was not seen may be a wedge, one whose slope was seen has its numbers") {
  Context context;
  const auto wedges_of = [&](const FitInput& input) {
    std::vector<Candidate> wedges = propose_polyhedra(input, context);
    std::erase_if(wedges, [](const Candidate& c) { return c.procedure != "wedge"; });
    return wedges;
  };
  FitInput hidden = scanned(
      block(40, 25, 30), 0.3, 0, [](const Vec3& n) { return n.y() < -0.5 || n.z() > 0.5; }, 3);
  CHECK(wedges_of(hidden).empty());
  hidden.outlier_share = 0.2;
  CHECK_FALSE(wedges_of(hidden).empty());

  auto planes = block(40, 25, 30);
  planes[0] = {Vec3(25, 18, 0).normalized(), 25 * 40 / std::hypot(25.0, 18.0)};  // foot 40, top 22
  FitInput seen = scanned(
      planes, 0.3, 0, [](const Vec3& n) { return n.y() > 0.5 || n.x() > 0.5 || n.z() > 0.5; }, 4);
  seen.outlier_share = 0.2;
  const auto wedges = wedges_of(seen);
  CHECK(std::any_of(wedges.begin(), wedges.end(), [&](const Candidate& c) {
    return c.parameters.size() == 4 && std::abs(value(c, "foot_length") - 40) < 1 &&
           std::abs(value(c, "height") - 25) < 1 && std::abs(value(c, "width") - 30) < 1 &&
           std::abs(value(c, "top_length") - 22) < 1;
  }));
}

TEST_CASE("wedges: a block of which a side was not scanned may be a wedge, one that was scanned all around is none") {
  Context context;
  const auto proposed = [&](const std::function<bool(const Vec3&)>& seen) {
    return propose_polyhedra(scanned(block(60, 35, 22), 0.03, 0, seen, 2), context);
  };
  const auto hidden = proposed([](const Vec3& n) { return n.x() < 0.5; });
  CHECK(find(hidden, "box"));
  CHECK(find(hidden, "wedge"));
  CHECK_FALSE(find(proposed(all), "wedge"));
}

TEST_CASE("wedges: of a slope that was not scanned the border of a cheek says where it lies") {
  Context context;
  auto planes = block(40, 25, 30);
  planes[0] = {Vec3(25, 18, 0).normalized(), 25 * 40 / std::hypot(25.0, 18.0)};  // foot 40, top 22
  for (const std::uint64_t seed : {4, 5, 6}) {
    FitInput input = scanned(
        planes, 0.05, 0, [](const Vec3& n) { return n.z() > 0.5 || n.x() < -0.5 || std::abs(n.y()) > 0.9; }, seed);
    // A shadow across the back: the data end at a plane there that no wedge has.
    const Pose part_from_scan = Pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}}.inverse();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < input.cloud.size(); ++i) {
      const Vec3 q = part_from_scan * input.cloud.points[i];
      if (q.z() > 4 + 0.3 * q.y())
        input.cloud.points[kept] = input.cloud.points[i], input.cloud.normals[kept++] = input.cloud.normals[i];
    }
    input.cloud.points.resize(kept), input.cloud.normals.resize(kept);
    const auto proposed = propose_polyhedra(input, context);
    CHECK(std::any_of(proposed.begin(), proposed.end(), [&](const Candidate& c) {
      return c.procedure == "wedge" && c.parameters.size() == 4 && std::abs(value(c, "foot_length") - 40) < 1.5 &&
             std::abs(value(c, "height") - 25) < 0.5 && std::abs(value(c, "top_length") - 22) < 1.5;
    }));
  }
}

TEST_CASE("half-spaces: among outliers no bevel is made of points beside an edge") {
  Context context;
  FitInput input = scanned(
      block(40, 25, 30), 0.3, 0, [](const Vec3& n) { return n.maxCoeff() > 0.5; }, 5);
  input.tolerance = 1;
  // Points on a narrow plane that cuts the edge of the faces +x and +z by two sigmas.
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  const Vec3 outward = Vec3(1, 0, 1).normalized(), across = Vec3(1, 0, -1).normalized();
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p =
        Vec3(40, random.uniform(0, 25), 30) + random.uniform(-1, 1) * across + (0.05 * random.normal() - 0.7) * outward;
    input.cloud.points.push_back(pose * p), input.cloud.normals.push_back(pose.rotation * outward),
        input.cloud.sigma.push_back(0.3f);
  }
  CHECK(scanned_faces(input, context).size() == 4);
  input.outlier_share = 0.2;
  CHECK(scanned_faces(input, context).size() == 3);
}

TEST_CASE(
    "half-spaces: few points on a plane that cuts a block's corner are a face, as many strewn through the block are "
    "none") {
  Context context;
  auto planes = block(60, 35, 22);
  const Vec3 n = Vec3(1, 1, 1).normalized();
  const double offset = n.dot(Vec3(60, 35, 22)) - 6;
  planes.push_back({n, offset});
  FitInput input = scanned(
      planes, 0.1, 0, [](const Vec3& v) { return v.maxCoeff() > 0.9; }, 5, 2.0);
  input.tolerance = 0.3;
  const auto seen = scanned_faces(input, context);
  const auto closed = closed_body(seen, input, context);
  REQUIRE(seen.size() == 3);
  REQUIRE(closed.size() >= 6);
  const Pose pose{rotation_of({0.4, -0.7, 0.3}), {40, 10, -30}};
  Random random(8);
  FitInput bevel = input, strewn = input;
  for (int i = 0; i < 60; ++i) {
    const Vec3 place(random.uniform(1, 59), random.uniform(1, 34), random.uniform(1, 21));
    strewn.cloud.points.push_back(pose * place), strewn.cloud.normals.push_back(Vec3::UnitX()),
        strewn.cloud.sigma.push_back(0.1f);
    Vec3 on = Vec3(60, 35, 22) - 6 * n + random.uniform(-4, 4) * n.unitOrthogonal() +
              random.uniform(-4, 4) * n.cross(n.unitOrthogonal());
    on += 0.1 * random.normal() * n;
    bevel.cloud.points.push_back(pose * on), bevel.cloud.normals.push_back(Vec3::UnitX()),
        bevel.cloud.sigma.push_back(0.1f);
  }
  const auto more = with_a_face_more(seen, closed, bevel, context);
  REQUIRE(more.size() == 4);
  CHECK(std::any_of(more.begin(), more.end(),
                    [&](const ConvexFace& f) { return f.normal.dot(pose.rotation * n) > 0.998; }));
  CHECK(with_a_face_more(seen, closed, strewn, context).empty());
  CHECK(with_a_face_more(seen, closed, input, context).empty());
}

TEST_CASE("half-spaces: where two faces hold the points, a block says that their end was not scanned") {
  Context context;
  FitInput input = scanned(
      block(40, 25, 30), 0.3, 0, [](const Vec3& n) { return n.y() < -0.5 || n.z() > 0.5; }, 6);
  input.outlier_share = 0.2;
  Candidate box;
  box.shape = Box{40, 25, 30};
  CHECK(open_polyhedron(box, 1e9, input, context).find("2 plane faces") != std::string::npos);
  // A cylinder that bends to them says so only where they alone cost less.
  Candidate rod;
  rod.shape = Cylinder{20, 40};
  CHECK(open_polyhedron(rod, 1e9, input, context).find("2 plane faces") != std::string::npos);
  CHECK(open_polyhedron(rod, 0, input, context).empty());
  input.outlier_share = 0.05;
  CHECK(open_polyhedron(box, 1e9, input, context).empty());
  // Three faces that cost no less than the block speak for it.
  FitInput corner = scanned(
      block(40, 25, 30), 0.3, 0, [](const Vec3& n) { return n.maxCoeff() > 0.5; }, 6);
  corner.outlier_share = 0.2;
  CHECK(open_polyhedron(box, 0, corner, context).empty());
  // Three of which two are opposite do not: an angle has such faces, too.
  FitInput channel = scanned(
      block(40, 25, 30), 0.3, 0, [](const Vec3& n) { return n.x() < -0.5 || std::abs(n.z()) > 0.5; }, 6);
  channel.outlier_share = 0.2;
  CHECK(open_polyhedron(box, 0, channel, context).find("3 plane faces") != std::string::npos);
}
