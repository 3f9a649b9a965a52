/// Claims about exact distances, signs and rays against triangle meshes.
#include "geometry/mesh/mesh_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>

#include "core/number.h"
#include "core/random.h"

using namespace partscribe::geometry;

namespace {

/// A sphere as `rings` x 2 `rings` quads, closed and outward; each vertex moved outward by a bump.
TriangleMesh bumpy_sphere(double radius, int rings, double bump = 0) {
  TriangleMesh mesh;
  const int columns = 2 * rings;
  auto at = [&](int i, int j) {
    const double theta = pi * i / rings, phi = 2 * pi * (j % columns) / columns;
    const double r = radius + bump * std::sin(5 * theta) * std::cos(3 * phi);
    return Vec3(r * std::sin(theta) * std::cos(phi), r * std::sin(theta) * std::sin(phi), r * std::cos(theta));
  };
  mesh.vertices.push_back(at(0, 0));
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < columns; ++j) mesh.vertices.push_back(at(i, j));
  mesh.vertices.push_back(at(rings, 0));
  auto id = [&](int i, int j) {
    if (i == 0) return 0u;
    if (i == rings) return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    return static_cast<std::uint32_t>(1 + (i - 1) * columns + j % columns);
  };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < columns; ++j) {
      if (i + 1 < rings) mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      if (i > 0) mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  return mesh;
}

TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z()});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Independent of the tree: the least of |p - (a + u ab + v ac)|^2 by the sequence of Ericson's regions, in long
/// double.
long double oracle_sq(const TriangleMesh& mesh, std::size_t t, const Vec3& query) {
  using V = Eigen::Matrix<long double, 3, 1>;
  const V p = query.cast<long double>(), a = mesh.corner(t, 0).cast<long double>(),
          b = mesh.corner(t, 1).cast<long double>(), c = mesh.corner(t, 2).cast<long double>();
  auto segment = [&](const V& s, const V& e) {
    const V d = e - s;
    const long double l = d.squaredNorm();
    const long double u = l > 0 ? std::clamp<long double>(d.dot(p - s) / l, 0, 1) : 0;
    return (p - s - u * d).squaredNorm();
  };
  long double best = std::min({segment(a, b), segment(b, c), segment(c, a)});
  const V n = (b - a).cross(c - a);
  if (n.squaredNorm() > 0 && n.dot((b - a).cross(p - a)) > 0 && n.dot((c - b).cross(p - b)) > 0 &&
      n.dot((a - c).cross(p - c)) > 0)
    best = std::min(best, n.dot(p - a) * n.dot(p - a) / n.squaredNorm());
  return best;
}

double oracle(const TriangleMesh& mesh, const Vec3& query) {
  long double best = std::numeric_limits<long double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) best = std::min(best, oracle_sq(mesh, t, query));
  return static_cast<double>(std::sqrt(best));
}

}  // namespace

TEST_CASE("mesh distance: agrees with every triangle tried in turn, near, inside and far away") {
  const auto mesh = bumpy_sphere(20, 12, 2);
  const MeshDistance distance(mesh);
  Random random(1);
  for (const double reach : {22.0, 60.0, 1e4})
    for (int i = 0; i < 400; ++i) {
      const Vec3 q(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
      const auto hit = distance.closest(q);
      CHECK(std::abs(hit.distance - oracle(mesh, q)) <= 1e-12 * (1 + reach));
      CHECK(std::abs((hit.point - q).norm() - hit.distance) <= 1e-12 * (1 + reach));
      CHECK(std::sqrt(double(oracle_sq(mesh, hit.triangle, q))) <= hit.distance + 1e-12 * (1 + reach));
    }
}

TEST_CASE(
    "mesh distance: no weights of the corners, each from 0 to 1 and 1 together, come nearer than the place found") {
  // A place of a convex set is the nearest exactly if no corner lies beyond the plane through it towards the query.
  Random random(12);
  const auto anywhere = [&](double reach) {
    return Vec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  int inside = 0, on_edges = 0, at_corners = 0;
  for (int round = 0; round < 3000; ++round) {
    const TriangleMesh one{{anywhere(5), anywhere(5), anywhere(5)}, {{0, 1, 2}}};
    const Vec3 &a = one.vertices[0], &b = one.vertices[1], &c = one.vertices[2], q = anywhere(9);
    const auto hit = MeshDistance(one).closest(q);
    Eigen::Matrix<double, 3, 2> sides;
    sides << b - a, c - a;
    const Vec2 shares = (sides.transpose() * sides).inverse() * (sides.transpose() * (hit.point - a));
    const Vec3 weights(1 - shares.sum(), shares[0], shares[1]);
    CHECK((weights[0] * a + weights[1] * b + weights[2] * c - hit.point).norm() < 1e-9);
    CHECK(weights.minCoeff() > -1e-9);
    for (const Vec3& corner : one.vertices) CHECK((q - hit.point).dot(corner - hit.point) < 1e-9);
    CHECK(hit.distance == Approx((q - hit.point).norm()).margin(1e-12));
    const auto zeros = (weights.array() < 1e-9).count();
    (zeros == 0 ? inside : zeros == 1 ? on_edges : at_corners) += 1;
  }
  CHECK(std::min({inside, on_edges, at_corners}) > 100);
}

TEST_CASE("mesh distance: the foot on the plane counts where it lies between each edge and the corner opposite") {
  // The paper's test of interiority: 0 < d_i(foot) < d_i(p_i), or both signs turned, d_i the distance from edge i.
  Random random(13);
  const auto anywhere = [&](double reach) {
    return Vec3(random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach));
  };
  int inside = 0, outside = 0, turned = 0;
  for (int round = 0; round < 3000; ++round) {
    const TriangleMesh one{{anywhere(5), anywhere(5), anywhere(5)}, {{0, 1, 2}}};
    const Vec3 q = anywhere(7), n = triangle_normal(one, 0), foot = q - n.dot(q - one.vertices[0]) * n;
    // The edges' sense says on which side d_i is positive; either will do.
    const double sense = random.uniform() < 0.5 ? -1 : 1;
    bool holds = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 &from = one.vertices[(i + 1) % 3], &to = one.vertices[(i + 2) % 3];
      const Vec3 across = sense * n.cross(to - from).normalized();
      const double of_foot = across.dot(foot - from), of_corner = across.dot(one.vertices[i] - from);
      holds = holds && (of_corner > 0 ? 0 < of_foot && of_foot < of_corner : 0 > of_foot && of_foot > of_corner);
      turned += of_corner < 0;
    }
    const auto hit = MeshDistance(one).closest(q);
    const double height = std::abs(n.dot(q - one.vertices[0]));
    INFO("round " << round);
    CHECK((hit.distance <= height + 1e-9) == holds);
    if (holds) CHECK((hit.point - foot).norm() < 1e-9);
    (holds ? inside : outside) += 1;
  }
  CHECK(std::min({inside, outside, turned}) > 100);
}

TEST_CASE("mesh distance: stays exact far from the origin") {
  auto mesh = bumpy_sphere(20, 10, 2);
  const Vec3 away(1e6, -2e6, 5e5);
  for (auto& v : mesh.vertices) v += away;
  const MeshDistance distance(mesh);
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    const Vec3 q = away + Vec3(random.uniform(-25, 25), random.uniform(-25, 25), random.uniform(-25, 25));
    CHECK(std::abs(distance.closest(q).distance - oracle(mesh, q)) < 1e-8);
  }
}

TEST_CASE("mesh distance: triangles without area and slivers count as the segments they are") {
  TriangleMesh mesh;
  Random random(3);
  auto anywhere = [&] { return Vec3(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5)); };
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3 a = anywhere(), b = anywhere();
    const Vec3 c = i % 4 == 0   ? Vec3(0.5 * (a + b))                      // collinear
                   : i % 4 == 1 ? a                                        // a segment
                   : i % 4 == 2 ? Vec3(0.5 * (a + b) + 1e-7 * anywhere())  // a sliver
                                : anywhere();
    mesh.vertices.insert(mesh.vertices.end(), {a, i % 8 == 1 ? a : b, c});  // i % 8 == 1: one point
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const MeshDistance distance(mesh);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 q = anywhere();
    CHECK(std::abs(distance.closest(q).distance - oracle(mesh, q)) < 1e-9);
  }
}

TEST_CASE("mesh distance: among equally near triangles the lowest index answers") {
  auto mesh = box({0, 0, 0}, {2, 2, 2});
  const auto count = mesh.triangles.size();
  for (std::size_t copy = 0; copy < 3; ++copy)
    for (std::size_t t = 0; t < count; ++t) mesh.triangles.push_back(mesh.triangles[t]);
  const MeshDistance distance(mesh);
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const Vec3 q(random.uniform(-1, 3), random.uniform(-1, 3), random.uniform(-1, 3));
    CHECK(distance.closest(q).triangle < count);
  }
  CHECK(distance.closest({3, 3, 3}).triangle == 3);  // corner 7 belongs to triangles 3, 7, 11 ...: 3 has corner 3
}

TEST_CASE("mesh distance: a bound cuts off what is farther and nothing else") {
  const auto mesh = box({0, 0, 0}, {2, 2, 2});
  const MeshDistance distance(mesh);
  CHECK_FALSE(distance.closest_within({5, 1, 1}, 2.999));
  REQUIRE(distance.closest_within({5, 1, 1}, 3.0));
  CHECK(distance.closest_within({5, 1, 1}, 3.0)->distance == 3.0);
  CHECK(distance.closest_within({5, 1, 1}, 1e300)->distance == 3.0);
  CHECK_FALSE(distance.closest_within({5, 1, 1}, -1));
  REQUIRE(distance.closest_within({1, 1, 2}, 0));
  const TriangleMesh empty;
  CHECK_FALSE(MeshDistance(empty).closest_within({0, 0, 0}, 1e9));
  CHECK_FALSE(MeshDistance(empty).first_hit({0, 0, 0}, {1, 0, 0}, 1e9));
}

TEST_CASE("mesh distance: inside is negative, also where the nearest place is an edge or a corner") {
  const auto mesh = box({0, 0, 0}, {2, 3, 4});
  const MeshDistance distance(mesh);
  CHECK(distance.signed_distance({1, 1.4, 2}) == Approx(-1));
  CHECK(distance.signed_distance({3, 4, 5}) == Approx(std::sqrt(3.0)));
  CHECK(distance.signed_distance({3, 4, 1}) == Approx(std::sqrt(2.0)));
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q(random.uniform(-1, 3), random.uniform(-1, 4), random.uniform(-1, 5));
    const bool inside = q.x() > 0 && q.x() < 2 && q.y() > 0 && q.y() < 3 && q.z() > 0 && q.z() < 4;
    CHECK((distance.signed_distance(q) < 0) == inside);
  }
  // A sharp dihedral: face normals alone give the wrong sign beside a thin wedge's edge.
  TriangleMesh wedge;
  wedge.vertices = {{0, 0, 0}, {10, 0, 1}, {10, 0, -1}, {0, 10, 0}, {10, 10, 1}, {10, 10, -1}};
  wedge.triangles = {{0, 1, 4}, {0, 4, 3}, {0, 3, 5}, {0, 5, 2}, {1, 2, 5}, {1, 5, 4}, {0, 2, 1}, {3, 4, 5}};
  if (volume(wedge) < 0)
    for (auto& t : wedge.triangles) std::swap(t[1], t[2]);
  REQUIRE(topology(wedge).closed());
  const MeshDistance thin(wedge);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q(random.uniform(-3, 12), random.uniform(-2, 12), random.uniform(-2, 2));
    const bool inside = q.x() < 10 && q.y() > 0 && q.y() < 10 && std::abs(q.z()) < 0.1 * q.x();
    CHECK((thin.signed_distance(q) < 0) == inside);
  }
}

TEST_CASE("mesh distance: signs hold for unwelded corners and across triangles without area") {
  // The box as loose triangles, one edge of the top reaching its neighbours only through a zero-area triangle.
  const auto solid = box({0, 0, 0}, {2, 2, 2});
  TriangleMesh soup;
  auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {a, b, c});
    soup.triangles.push_back({n, n + 1, n + 2});
  };
  const Vec3 p5(2, 0, 2), p7(2, 2, 2), middle(2, 1, 2);
  // Split the side x = 2 at `middle`, which the top does not know; the gap is filled by a triangle without area.
  add(p7, middle, p5);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const auto tri = solid.triangles[t];
    if (tri == std::array<std::uint32_t, 3>{3, 7, 5}) {
      add(solid.vertices[3], p7, middle);
      add(solid.vertices[3], middle, p5);
    } else {
      add(solid.corner(t, 0), solid.corner(t, 1), solid.corner(t, 2));
    }
  }
  const MeshDistance distance(soup);
  Random random(6);
  for (int i = 0; i < 4000; ++i) {
    const Vec3 q(random.uniform(-1, 3), random.uniform(-1, 3), random.uniform(-1, 3));
    const bool inside = q.minCoeff() > 0 && q.maxCoeff() < 2;
    CHECK((distance.signed_distance(q) < 0) == inside);
  }
}

TEST_CASE("mesh distance: the sign agrees with the solid angle of a bumpy surface") {
  const auto mesh = bumpy_sphere(10, 14, 2.5);
  const MeshDistance distance(mesh);
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const Vec3 q(random.uniform(-13, 13), random.uniform(-13, 13), random.uniform(-13, 13));
    double winding = 0;  // van Oosterom & Strackee
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 a = mesh.corner(t, 0) - q, b = mesh.corner(t, 1) - q, c = mesh.corner(t, 2) - q;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      winding += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    CHECK((distance.signed_distance(q) < 0) == (winding > 2 * pi));
  }
}

TEST_CASE("mesh distance: a ray meets the first surface, whichever triangle or edge it goes through") {
  const auto mesh = box({0, 0, 0}, {2, 2, 2});
  const MeshDistance distance(mesh);
  auto hit = distance.first_hit({-3, 1, 1}, {1, 0, 0}, 100);  // straight through the diagonal edge
  REQUIRE(hit);
  CHECK(hit->distance == Approx(3));
  hit = distance.first_hit({-3, 0.5, 1}, {2, 0, 0}, 100);  // t counts in lengths of the direction
  REQUIRE(hit);
  CHECK(hit->distance == Approx(1.5));
  CHECK(hit->point.isApprox(Vec3(0, 0.5, 1)));
  CHECK(distance.first_hit({1, 0.5, 1}, {1, 0, 0}, 100)->distance == Approx(1));
  CHECK_FALSE(distance.first_hit({-3, 0.5, 1}, {1, 0, 0}, 2.9));
  CHECK_FALSE(distance.first_hit({-3, 0.5, 1}, {-1, 0, 0}, 100));
  CHECK_FALSE(distance.first_hit({-3, 2.5, 1}, {1, 0, 0}, 100));

  // From the centre every direction must leave, also exactly through vertices and edge midpoints.
  const auto sphere = bumpy_sphere(10, 24, 1);
  const MeshDistance ball(sphere);
  std::size_t missed = 0;
  for (const auto& v : sphere.vertices) missed += !ball.first_hit({0, 0, 0}, v, 1e3);
  for (const auto& t : sphere.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 middle = 0.5 * (sphere.vertices[t[k]] + sphere.vertices[t[(k + 1) % 3]]);
      missed += !ball.first_hit({0, 0, 0}, middle, 1e3);
    }
  CHECK(missed == 0);
}

TEST_CASE("mesh distance: a ray agrees with every triangle tried in turn") {
  const auto mesh = bumpy_sphere(10, 10, 2.5);
  const MeshDistance distance(mesh);
  Random random(8);
  for (int i = 0; i < 500; ++i) {
    const Vec3 o(random.uniform(-15, 15), random.uniform(-15, 15), random.uniform(-15, 15));
    const Vec3 d(random.normal(), random.normal(), random.normal());
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 n = triangle_normal(mesh, t);
      const double s = n.dot(mesh.corner(t, 0) - o) / n.dot(d);
      const Vec3 x = o + s * d;
      bool in = s > 0;
      for (int k = 0; k < 3; ++k)
        in = in && n.dot((mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).cross(x - mesh.corner(t, k))) >= 0;
      if (in) best = std::min(best, s);
    }
    const auto hit = distance.first_hit(o, d, 1e6);
    REQUIRE(bool(hit) == std::isfinite(best));
    if (hit) CHECK(hit->distance == Approx(best).epsilon(1e-9));
  }
}

TEST_CASE("mesh distance: many queries at once get the answers of one by one, to the bit and for any threads") {
  const auto mesh = bumpy_sphere(20, 40, 2);
  const MeshDistance distance(mesh), built_by_three(mesh, 3);
  Random random(10);
  for (const double reach : {23.0, 200.0}) {
    std::vector<Vec3> queries;
    for (int i = 0; i < 5000; ++i)
      queries.push_back({random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)});
    for (const auto& v : mesh.vertices) queries.push_back(v);   // ties at every corner
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 7)  // and on edges
      queries.push_back(1.1 * 0.5 * (mesh.corner(t, 0) + mesh.corner(t, 1)));
    queries.push_back(queries.front());
    for (const int threads : {1, 2, 5}) {
      const auto plain = distance.closest(queries, threads);
      const auto signs = built_by_three.closest(queries, threads, Sign::inside_negative);
      std::size_t different = 0;
      for (std::size_t i = 0; i < queries.size(); ++i) {
        const MeshHit one = distance.closest(queries[i]);
        different +=
            plain[i].distance != one.distance || plain[i].triangle != one.triangle || plain[i].point != one.point;
        different += signs[i].distance != distance.signed_distance(queries[i]) || signs[i].triangle != one.triangle;
      }
      CHECK(different == 0);
    }
  }
  CHECK(distance.closest(std::vector<Vec3>{}, 2).empty());
  // All queries at one place, and a mesh that fits into one leaf.
  const auto one = box({0, 0, 0}, {1, 1, 1});
  TriangleMesh few{one.vertices, {one.triangles[0], one.triangles[1]}};
  for (const auto& hit : MeshDistance(few).closest(std::vector<Vec3>(100, Vec3(0.2, 0.2, -3)), 1))
    CHECK(hit.distance == 3);
}

TEST_CASE("mesh distance: speed near the surface of 100,000 triangles", "[.speed]") {
  const auto mesh = bumpy_sphere(50, 159, 2);
  const auto start = std::chrono::steady_clock::now();
  const MeshDistance distance(mesh);
  const auto built = std::chrono::steady_clock::now();
  Random random(9);
  std::vector<Vec3> queries;
  for (int i = 0; i < 1000000; ++i) {
    const auto t = random.below(mesh.triangles.size());
    queries.push_back((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3 +
                      0.05 * Vec3(random.normal(), random.normal(), random.normal()));
  }
  const auto ready = std::chrono::steady_clock::now();
  double sum = 0;
  for (const auto& q : queries) sum += distance.closest(q).distance;
  const auto done = std::chrono::steady_clock::now();
  using S = std::chrono::duration<double>;
  WARN(mesh.triangles.size() << " triangles built in " << S(built - start).count() << " s, 1e6 random queries in "
                             << S(done - ready).count() << " s, sum " << sum);
}
