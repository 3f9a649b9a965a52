#include "fit/surface/generalized_delaunay.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "core/random.h"
#include "fit/surface/lattice_facets.h"
#include "geometry/mesh/bounded_mesh.h"
#include "testing/relief_fields.h"

using namespace partscribe::fit;

namespace {

constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();

Vec3 random_vector(Random& random) { return Vec3(random.normal(), random.normal(), random.normal()); }

using Height = std::function<double(double, double)>;

/// Seen from above, `pitch` mm per pixel about the origin; normals from the height itself, away from steps.
SampleLattice lattice_of(const Height& height, int columns, int rows, double pitch) {
  SampleLattice lattice{columns, rows, {}, {}};
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const double x = (c - 0.5 * (columns - 1)) * pitch, y = (r - 0.5 * (rows - 1)) * pitch, h = 1e-5;
      lattice.places.emplace_back(x, y, height(x, y));
      const double dx = height(x + h, y) - height(x - h, y), dy = height(x, y + h) - height(x, y - h);
      const Vec3 normal(-dx / (2 * h), -dy / (2 * h), 1);
      lattice.normals.push_back(normal.allFinite() ? Vec3(normal.normalized()) : Vec3(Vec3::UnitZ()));
    }
  return lattice;
}

double bumps(double x, double y) { return 2 * std::sin(0.35 * x + 0.3) * std::cos(0.28 * y) + 0.002 * x * y; }

GeneralizedDelaunay triangulated(const SampleLattice& lattice, double tolerance) {
  Context context;
  GeneralizedDelaunayOptions options;
  options.tolerance = tolerance;
  return generalized_delaunay(lattice, options, context);
}

/// Ends of the edges that only one triangle has.
std::vector<std::pair<Vec3, Vec3>> border_of(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<std::pair<Vec3, Vec3>> border;
  for (const auto& [edge, count] : edges)
    if (count == 1) border.emplace_back(mesh.vertices[edge.first], mesh.vertices[edge.second]);
  return border;
}

/// The guarantee, checked against every triangle by solving for where the normal meets it: samples that are not within
/// the tolerance. Where the normal passes the border by, the distance from it counts.
std::size_t violations(const SampleLattice& lattice, const TriangleMesh& mesh, double tolerance) {
  const auto border = border_of(mesh);
  std::size_t count = 0;
  for (std::size_t i = 0; i < lattice.places.size(); ++i) {
    const Vec3 &p = lattice.places[i], &n = lattice.normals[i];
    if (!p.allFinite()) continue;
    double along = 1e300;
    for (std::size_t t = 0; t < mesh.triangles.size() && along > tolerance; ++t) {
      const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
      const double reach = 1.01 * tolerance;  // farther away it cannot be met within the tolerance
      if (((a.cwiseMin(b).cwiseMin(c) - p).array() > reach || (p - a.cwiseMax(b).cwiseMax(c)).array() > reach).any())
        continue;
      Mat3 m;
      m << b - a, c - a, -n;
      const Vec3 x = m.inverse() * (p - a);
      if (x[0] > -1e-7 && x[1] > -1e-7 && x[0] + x[1] < 1 + 1e-7) along = std::min(along, std::abs(x[2]));
    }
    if (along < tolerance + 1e-9) continue;
    double beside = 1e300;
    for (const auto& [a, b] : border) beside = std::min(beside, distance_to_triangle(p, a, a, b));
    count += !(beside < tolerance + 1e-9);
  }
  return count;
}

/// The triangles in an order of their own, each from its first pixel on.
std::set<std::array<std::uint32_t, 3>> triangles_by_pixel(const GeneralizedDelaunay& result, int mirrored_columns = 0) {
  std::set<std::array<std::uint32_t, 3>> all;
  for (const auto& t : result.mesh.triangles) {
    std::array<std::uint32_t, 3> v{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = result.pixels[t[k]], n = static_cast<std::uint32_t>(mirrored_columns);
      v[k] = n > 0 ? p / n * n + n - 1 - p % n : p;
    }
    std::sort(v.begin(), v.end());
    all.insert(v);
  }
  return all;
}

SampleLattice mirrored(const SampleLattice& lattice) {
  SampleLattice result = lattice;
  for (int r = 0; r < lattice.rows; ++r) {
    const auto begin = r * static_cast<std::ptrdiff_t>(lattice.columns), end = begin + lattice.columns;
    std::reverse(result.places.begin() + begin, result.places.begin() + end);
    std::reverse(result.normals.begin() + begin, result.normals.begin() + end);
  }
  return result;
}

SampleLattice noisy(SampleLattice lattice, double sigma, std::uint64_t seed) {
  Random random(seed);
  for (Vec3& p : lattice.places) p.z() += sigma * random.normal();
  return lattice;
}

double smallest_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto at = [](const Vec3& p, const Vec3& q, const Vec3& r) {
    return std::acos(std::clamp((q - p).normalized().dot((r - p).normalized()), -1.0, 1.0));
  };
  return std::min({at(a, b, c), at(b, c, a), at(c, a, b)});
}

std::size_t live_facets(const LatticeFacets& facets) {
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < facets.size(); ++t) count += facets[t].alive();
  return count;
}

/// Twice the area in the picture; every facet of positive turn, every edge known from both sides.
std::int64_t checked_area(const LatticeFacets& facets, const LatticePicture& picture) {
  std::int64_t area = 0;
  for (std::uint32_t t = 0; t < facets.size(); ++t) {
    const LatticeFacet& f = facets[t];
    if (!f.alive()) continue;
    const std::int64_t turn = picture.turn(f.v[0], f.v[1], f.v[2]);
    REQUIRE(turn > 0);
    area += turn;
    for (const std::uint32_t u : f.n)
      if (u != LatticeFacet::nobody) REQUIRE(facets[u].index_across(t) < 3);
  }
  return area;
}

std::uint32_t facet_at(const LatticeFacets& facets, const LatticePicture& picture, std::uint32_t p) {
  for (std::uint32_t t = 0; t < facets.size(); ++t) {
    const auto& v = facets[t].v;
    if (facets[t].alive() && picture.turn(v[0], v[1], p) >= 0 && picture.turn(v[1], v[2], p) >= 0 &&
        picture.turn(v[2], v[0], p) >= 0)
      return t;
  }
  return LatticeFacet::nobody;
}

void put_in(LatticeFacets& facets, const LatticePicture& picture, std::uint32_t p) {
  facets.begin();
  facets.insert(p, facet_at(facets, picture, p));
  facets.flip_edges();
  facets.keep();
}

}  // namespace

TEST_CASE("generalized delaunay: the minsphere passes through the corners and is the smallest that does") {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 a = random_vector(random), b = random_vector(random), c = random_vector(random);
    const Vec3 n = (b - a).cross(c - a).normalized();
    const Minsphere sphere = minsphere(a, b, c);
    const double r = std::sqrt(sphere.sq_radius);
    for (const Vec3& p : {a, b, c}) CHECK((p - sphere.centre).norm() == Approx(r).epsilon(1e-9));
    CHECK(n.dot(sphere.centre - a) == Approx(0).margin(1e-9 * r));
    // All spheres through three points have their centres on one line; along it radii only grow.
    for (const double off : {-0.3 * r, 0.01 * r}) {
      const Vec3 centre = sphere.centre + off * n;
      CHECK((a - centre).norm() == Approx((c - centre).norm()).epsilon(1e-9));
      CHECK((a - centre).norm() > r);
    }
    CHECK(sphere.holds(sphere.centre + 0.99 * r * random_vector(random).normalized()));
    CHECK_FALSE(sphere.holds(sphere.centre + 1.01 * r * random_vector(random).normalized()));
  }
  const Minsphere unit_square = minsphere({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  CHECK_FALSE(unit_square.holds({1, 1, 0}));
  CHECK(std::isinf(minsphere({0, 0, 0}, {1, 1, 1}, {3, 3, 3}).sq_radius));
}

TEST_CASE("generalized delaunay: the distance to a triangle is the least over its weights") {
  Random random(2);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 a = random_vector(random), b = random_vector(random), c = random_vector(random);
    const Vec3 p = 2 * random_vector(random);
    const double d = distance_to_triangle(p, a, b, c);
    CHECK(d == Approx((partscribe::geometry::closest_on_triangle(p, a, b, c) - p).norm()).margin(1e-9));
    for (int k = 0; k < 20; ++k) {
      double a1 = random.uniform(), a2 = random.uniform();
      if (a1 + a2 > 1) a1 = 1 - a1, a2 = 1 - a2;
      REQUIRE((a1 * a + a2 * b + (1 - a1 - a2) * c - p).norm() > d - 1e-9);
    }
  }
  CHECK(distance_to_triangle({0, 2, 0}, {-1, 0, 0}, {0, 0, 0}, {1, 0, 0}) == Approx(2));  // no area
}

TEST_CASE("generalized delaunay: edge functions tell what projects into a triangle, away from its edges") {
  Random random(3);
  int inside = 0, spoilt_differs = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec3 a = random_vector(random), b = random_vector(random), c = random_vector(random);
    const EdgeFunctions edges = edge_functions(a, b, c);
    const double a1 = random.uniform(-0.5, 1.5), a2 = random.uniform(-0.5, 1.5), a3 = 1 - a1 - a2;
    if (std::min({std::abs(a1), std::abs(a2), std::abs(a3)}) < 1e-6) continue;
    const Vec3 p = a1 * a + a2 * b + a3 * c + random.normal() * (b - a).cross(c - a);
    const bool exact = a1 > 0 && a2 > 0 && a3 > 0;
    REQUIRE(projects_inside(edges, p) == exact);
    // The distances themselves, and those stored of the corners: their ratios are the weights.
    CHECK(edges(0, p) / edges.corner[0] == Approx(a1).margin(1e-6));
    CHECK(edges(1, p) / edges.corner[1] == Approx(a2).margin(1e-6));
    CHECK(edges.corner[1] < 0);
    EdgeFunctions reversed = edges, spoilt = edges;
    for (std::size_t i = 0; i < 3; ++i) reversed.across[i] *= -1, reversed.offsets[i] *= -1, reversed.corner[i] *= -1;
    CHECK(projects_inside(reversed, p) == exact);
    spoilt.corner[0] *= -1;
    inside += exact;
    spoilt_differs += projects_inside(spoilt, p) != exact;
  }
  CHECK(inside > 200);
  CHECK(spoilt_differs >= inside);
  // The printed inequalities leave out the edge and the corner; d(p, T) has them.
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  CHECK(projects_inside(edge_functions(a, b, c), {1, 1, 5}));
  CHECK_FALSE(projects_inside(edge_functions(a, b, c), {1, 0, 5}));
  CHECK_FALSE(projects_inside(edge_functions(a, b, c), {0, 0, 5}));
  CHECK(distance_to_triangle({1, 0, 5}, a, b, c) == Approx(5));
}

TEST_CASE("generalized delaunay: a normal meets the triangle it runs through, or the edge, or none") {
  const EdgeFunctions left = edge_functions({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const EdgeFunctions right = edge_functions({4, 0, 0}, {4, 4, 0}, {0, 4, 0});
  const Vec3 leaning = Vec3(1, 0, 1).normalized();
  CHECK(distance_along_normal(left, {1, 1, 1}, Vec3::UnitZ()).value() == Approx(1));
  CHECK(distance_along_normal(left, {2, 1, 1}, leaning).value() == Approx(std::sqrt(2.0)));
  CHECK(distance_along_normal(left, {0.5, 1, -1}, leaning).value() == Approx(std::sqrt(2.0)));
  CHECK_FALSE(distance_along_normal(left, {0.5, 1, 1}, leaning));  // passes x = 0
  CHECK_FALSE(distance_along_normal(left, {1, 1, 1}, Vec3::UnitX()));
  Random random(4);
  for (int trial = 0; trial < 1000; ++trial) {  // through their common edge, from anywhere
    const double x = random.uniform(0.01, 3.99);
    const Vec3 p(random.normal(), random.normal(), 2), n = (Vec3(x, 4 - x, 0) - p).normalized();
    REQUIRE((distance_along_normal(left, p, n) || distance_along_normal(right, p, n)));
  }
}

TEST_CASE("generalized delaunay: where a point lies decides how it is inserted, and all of it can be taken back") {
  const SampleLattice flat = lattice_of([](double, double) { return 0; }, 40, 40, 1);
  const LatticePicture picture(flat, 5);
  LatticeFacets facets(picture);
  facets.begin();
  facets.add_first({picture.pixel(10, 10), picture.pixel(30, 10), picture.pixel(10, 30)});
  facets.keep();
  const auto insert = [&](int column, int row) {
    const std::uint32_t p = picture.pixel(column, row);
    facets.begin();
    facets.insert(p, facet_at(facets, picture, p));
  };
  std::size_t before = live_facets(facets);
  insert(15, 14);
  CHECK(live_facets(facets) == before + 2);  // 1 becomes 3
  CHECK(checked_area(facets, picture) == 400);
  facets.roll_back();
  CHECK(live_facets(facets) == before);
  CHECK(checked_area(facets, picture) == 400);

  insert(20, 10);  // 1 becomes 2
  facets.keep();
  CHECK(live_facets(facets) == before + 1);
  CHECK(checked_area(facets, picture) == 400);
  before = live_facets(facets);
  insert(15, 20);  // on the edge from (20, 10) to (10, 30): 2 become 4
  facets.keep();
  CHECK(live_facets(facets) == before + 2);
  CHECK(checked_area(facets, picture) == 400);
  before = live_facets(facets);
  insert(30, 30);  // sees the long side only
  facets.keep();
  CHECK(live_facets(facets) == before + 1);
  CHECK(checked_area(facets, picture) == 800);
  before = live_facets(facets);
  insert(20, 5);  // sees both halves of the upper side
  facets.keep();
  CHECK(live_facets(facets) == before + 2);

  // Taken away again: two fewer, over the same area.
  const std::int64_t area = checked_area(facets, picture);
  before = live_facets(facets);
  facets.begin();
  REQUIRE(facets.remove(picture.pixel(15, 20), facet_at(facets, picture, picture.pixel(15, 20))));
  facets.keep();
  CHECK(live_facets(facets) == before - 2);
  CHECK(checked_area(facets, picture) == area);
  facets.begin();
  CHECK_FALSE(facets.remove(picture.pixel(30, 30), facet_at(facets, picture, picture.pixel(30, 30))));
  facets.roll_back();
  CHECK(checked_area(facets, picture) == area);
}

TEST_CASE("generalized delaunay: in a plane empty minspheres make the smallest angles as large as they can be") {
  // Any plane in space, seen aslant: spheres know nothing of the picture.
  for (const double slope : {0.0, 1.1}) {
    const SampleLattice plane = lattice_of([&](double x, double y) { return slope * x - 0.3 * slope * y; }, 50, 50, 1);
    const LatticePicture picture(plane, 5);
    LatticeFacets facets(picture);
    facets.begin();
    facets.add_first({picture.pixel(0, 0), picture.pixel(49, 0), picture.pixel(0, 49)});
    facets.keep();
    put_in(facets, picture, picture.pixel(49, 49));
    Random random(7);
    std::set<std::uint32_t> corners = {0, 49, 49 * 50, 49 * 50 + 49};
    while (corners.size() < 150) {
      const auto p = static_cast<std::uint32_t>(random.below(2500));
      if (corners.insert(p).second) put_in(facets, picture, p);
    }
    CHECK(checked_area(facets, picture) == 2 * 49 * 49);
    double kept = 0, flipped = 0;
    for (std::uint32_t t = 0; t < facets.size(); ++t) {
      const LatticeFacet& f = facets[t];
      if (!f.alive()) continue;
      for (const std::uint32_t p : corners) REQUIRE_FALSE(f.sphere.holds(picture.place(p)));
      for (std::size_t k = 0; k < 3; ++k) {
        if (f.n[k] == LatticeFacet::nobody || f.n[k] < t) continue;
        const LatticeFacet& g = facets[f.n[k]];
        const std::uint32_t ip = f.v[k], ia = f.v[(k + 1) % 3], ib = f.v[(k + 2) % 3], iq = g.v[g.index_across(t)];
        if (picture.turn(ip, ia, iq) <= 0 || picture.turn(ip, iq, ib) <= 0) continue;
        const Vec3 p = picture.place(ip), a = picture.place(ia), b = picture.place(ib), q = picture.place(iq);
        const double angle = std::min(smallest_angle(p, a, b), smallest_angle(q, b, a));
        const double other = std::min(smallest_angle(p, a, q), smallest_angle(p, q, b));
        REQUIRE(angle > other - 1e-9);
        kept += angle, flipped += other;
      }
    }
    CHECK(kept > 1.3 * flipped);
  }
}

TEST_CASE("generalized delaunay: it starts at the sample nearest to the centre of gravity") {
  // Twice as dense a half has no say: samples count, of which the right half lost two thirds.
  SampleLattice lattice = lattice_of(bumps, 61, 61, 0.5);
  for (int r = 0; r < 61; ++r)
    for (int c = 31; c < 61; ++c)
      if (r >= 20 && r < 60) lattice.places[static_cast<std::size_t>(r * 61 + c)].setConstant(nowhere);
  Vec3 centre = Vec3::Zero();
  double count = 0;
  for (const Vec3& p : lattice.places)
    if (p.allFinite()) centre += p, ++count;
  centre /= count;
  std::uint32_t nearest = 0;
  for (std::uint32_t i = 0; i < lattice.places.size(); ++i)
    if ((lattice.places[i] - centre).norm() < (lattice.places[nearest] - centre).norm() ||
        !lattice.places[nearest].allFinite())
      nearest = i;
  const GeneralizedDelaunay start = triangulated(lattice, 1000);  // nothing to add
  REQUIRE(start.mesh.triangles.size() == 1);
  CHECK(std::count(start.pixels.begin(), start.pixels.end(), nearest) == 1);
}

TEST_CASE("generalized delaunay: a flat lattice becomes a handful of triangles") {
  const GeneralizedDelaunay flat = triangulated(lattice_of([](double x, double) { return 0.2 * x; }, 90, 70, 0.5), 0.1);
  CHECK(flat.mesh.triangles.size() <= 8);
  CHECK(flat.samples == 90 * 70);
  CHECK(flat.uncovered.empty());
  CHECK(flat.max_distance < 0.1);
  CHECK(flat.broken_edges == 0);
  CHECK(area(flat.mesh) > 0.98 * 44.5 * 34.5 * std::sqrt(1.04));
}

TEST_CASE("generalized delaunay: every sample is within the tolerance along its normal, of few triangles") {
  const SampleLattice lattice = lattice_of(bumps, 64, 56, 0.5);
  std::size_t triangles = 0;
  for (const double tolerance : {0.3, 0.08}) {
    const GeneralizedDelaunay result = triangulated(lattice, tolerance);
    const MeshTopology top = topology(result.mesh);
    INFO("tolerance " << tolerance << ", triangles " << result.mesh.triangles.size());
    CHECK(violations(lattice, result.mesh, tolerance) == 0);
    CHECK(result.uncovered.empty());
    CHECK(result.max_distance < tolerance);
    CHECK(result.max_distance > 0.5 * tolerance);
    CHECK(top.components == 1);
    CHECK(top.nonmanifold_edges == 0);
    CHECK(top.inconsistent_edges == 0);
    CHECK(result.mesh.triangles.size() > 2 * triangles);
    CHECK(result.mesh.triangles.size() < 64 * 56 / 4);
    CHECK(result.broken_edges < result.mesh.triangles.size() / 30);
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) REQUIRE(triangle_normal(result.mesh, t).z() > 0);
    triangles = result.mesh.triangles.size();

    // The check sees a vertex that is off.
    TriangleMesh spoilt = result.mesh;
    for (Vec3& v : spoilt.vertices)
      if (v.head<2>().norm() < 3) v.z() += 2 * tolerance;
    CHECK(violations(lattice, spoilt, tolerance) > 0);
  }
}

TEST_CASE("generalized delaunay: resolutions go from coarse to fine, and later points make earlier ones needless") {
  const GeneralizedDelaunay result = triangulated(noisy(lattice_of(bumps, 100, 100, 0.4), 0.01, 5), 0.1);
  REQUIRE(result.levels.size() == 6);
  std::size_t added = 3, removed = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(result.levels[i].stride == 32 >> i);
    added += result.levels[i].added, removed += result.levels[i].removed;
  }
  CHECK(result.levels[1].added > 0);
  CHECK(removed > added / 20);
  CHECK(result.mesh.vertices.size() == added - removed);
  CHECK(result.forced < added / 20);
}

TEST_CASE("generalized delaunay: holes stay holes, single lost pixels are bridged") {
  Random random(11);
  std::set<std::size_t> lost;
  SampleLattice lattice =
      lattice_of([](double x, double y) { return Vec2(x - 3, y + 2).norm() < 6 ? nowhere : bumps(x, y); }, 80, 80, 0.5);
  for (int k = 0; k < 12; ++k) {
    const auto i = static_cast<std::size_t>((5 + 6 * k) * 80 + 6 + k % 3);
    lattice.places[i].setConstant(nowhere);
  }
  const GeneralizedDelaunay result = triangulated(lattice, 0.15);
  CHECK(result.uncovered.empty());
  CHECK(violations(lattice, result.mesh, 0.15) == 0);
  const MeshTopology top = topology(result.mesh);
  CHECK(top.components == 1);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : result.mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
  // Vertices - edges + faces = 1 - holes.
  CHECK(result.mesh.vertices.size() + result.mesh.triangles.size() == edges.size());
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    for (int k = 0; k < 60; ++k) {
      double a1 = random.uniform(), a2 = random.uniform();
      if (a1 + a2 > 1) a1 = 1 - a1, a2 = 1 - a2;
      const Vec3 p =
          a1 * result.mesh.corner(t, 0) + a2 * result.mesh.corner(t, 1) + (1 - a1 - a2) * result.mesh.corner(t, 2);
      REQUIRE(Vec2(p.x() - 3, p.y() + 2).norm() > 6 - 2 * 0.5);
    }
}

TEST_CASE("generalized delaunay: no triangle spans a step of depth or a bay of the silhouette") {
  const auto terrace = [](double x, double y) {
    if (std::abs(x) > 14 || std::abs(y) > 14 || (x > 6 && std::abs(y + 0.3 * x) < 4)) return nowhere;
    return 0.3 * x + y > 2 ? 12 + 0.1 * x : 0.01 * x * x;
  };
  const SampleLattice lattice = lattice_of(terrace, 72, 72, 0.5);
  const GeneralizedDelaunay result = triangulated(lattice, 0.1);
  CHECK(result.uncovered.empty());
  CHECK(topology(result.mesh).components == 2);
  CHECK(violations(lattice, result.mesh, 0.1) == 0);
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) {
    double low = 1e9, high = -1e9;
    for (int k = 0; k < 3; ++k)
      low = std::min(low, result.mesh.corner(t, k).z()), high = std::max(high, result.mesh.corner(t, k).z());
    REQUIRE(high - low < 4);
    const Vec3 middle = (result.mesh.corner(t, 0) + result.mesh.corner(t, 1) + result.mesh.corner(t, 2)) / 3;
    REQUIRE_FALSE((middle.x() > 6.8 && std::abs(middle.y() + 0.3 * middle.x()) < 3.2));
  }
}

TEST_CASE("generalized delaunay: samples that no triangle fits on are named") {
  SampleLattice lattice = lattice_of(
      [](double x, double y) { return std::abs(x) < 6 && std::abs(y) < 6 ? bumps(x, y) : nowhere; }, 60, 60, 0.5);
  const std::vector<std::uint32_t> specks = {3 * 60 + 50, 20 * 60 + 2, 20 * 60 + 3, 20 * 60 + 4};  // and a thread
  for (const std::uint32_t i : specks) lattice.places[i] = Vec3(0.5 * (i % 60) - 14.75, 0.5 * (i / 60) - 14.75, 1);
  const GeneralizedDelaunay result = triangulated(lattice, 0.1);
  CHECK(result.uncovered == specks);
  CHECK(topology(result.mesh).components == 1);

  for (Vec3& p : lattice.places) p.setConstant(nowhere);
  for (const std::uint32_t i : specks) lattice.places[i] = Vec3(0.5 * (i % 60), 0.5 * (i / 60), 1);
  const GeneralizedDelaunay none = triangulated(lattice, 0.1);
  CHECK(none.mesh.empty());
  CHECK(none.uncovered == specks);
}

TEST_CASE("generalized delaunay: the same input gives the same bytes, mirrored or moved it gives the same triangles") {
  const auto bay = [](double x, double y) { return Vec2(x - 9, y - 4).norm() < 5 ? nowhere : bumps(x, y); };
  const SampleLattice lattice = noisy(lattice_of(bay, 70, 60, 0.5), 0.02, 9);
  const GeneralizedDelaunay one = triangulated(lattice, 0.15), two = triangulated(lattice, 0.15);
  CHECK(one.mesh.vertices == two.mesh.vertices);
  CHECK(one.mesh.triangles == two.mesh.triangles);
  const auto truth = triangles_by_pixel(one);
  REQUIRE(truth.size() == one.mesh.triangles.size());

  const GeneralizedDelaunay mirror = triangulated(mirrored(lattice), 0.15);
  CHECK(mirror.mesh.triangles.size() == one.mesh.triangles.size());
  CHECK(triangles_by_pixel(mirror, 70) == truth);
  for (std::size_t t = 0; t < mirror.mesh.triangles.size(); ++t) REQUIRE(triangle_normal(mirror.mesh, t).z() > 0);

  SampleLattice moved = lattice;
  const Pose pose{rotation_of({0.5, -0.8, 2.1}), Vec3(100, -30, 55)};
  for (Vec3& p : moved.places) p = pose * p;
  for (Vec3& n : moved.normals) n = pose.rotation * n;
  CHECK(triangles_by_pixel(triangulated(moved, 0.15)) == truth);
}

TEST_CASE("generalized delaunay: a range image of a pinhole is triangulated in the world, facing its sensor") {
  partscribe::geometry::RangeImage image;
  image.width = 90, image.height = 80;
  image.projection = partscribe::geometry::Projection::pinhole;
  image.fx = image.fy = 300, image.cx = 45, image.cy = 40;
  image.z0 = 100, image.q = 0.002;
  image.world_from_view = {rotation_of({2.1, 0.4, -0.3}), Vec3(10, 20, -5)};
  const auto depth = [](double c, double r) { return 140 + 3 * std::sin(0.11 * c) * std::cos(0.09 * r); };
  for (int r = 0; r < 80; ++r)
    for (int c = 0; c < 90; ++c)
      image.codes.push_back(
          static_cast<std::uint16_t>(r < 12 && c < 20 ? 0 : std::lround((depth(c, r) - 100) / 0.002)));
  const SampleLattice lattice = sample_lattice(image, 2);
  CHECK(lattice.columns == 90);
  CHECK(lattice.rows == 80);
  CHECK_FALSE(lattice.places[5].allFinite());
  const GeneralizedDelaunay result = triangulated(lattice, 0.2);
  CHECK(result.samples == 90 * 80 - 12 * 20);
  CHECK(result.uncovered.empty());
  const Vec3 sensor = image.world_from_view.translation;
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    REQUIRE(triangle_normal(result.mesh, t).dot(sensor - result.mesh.corner(t, 0)) > 0);
  for (std::size_t i = 0; i < result.pixels.size(); ++i)
    REQUIRE(result.mesh.vertices[i] == lattice.places[result.pixels[i]]);
}

TEST_CASE("generalized delaunay: a face at 0.5 mm and a hand at 0.4 mm need some thousand triangles") {
  const auto in_middle = [](const Height& height, double x, double y) {
    return Height([=](double u, double v) { return height(u + x, v + y); });
  };
  struct Relief {
    const char* name;
    Height height;
    double pitch, tolerance, sigma;
  };
  for (const Relief& relief :
       {Relief{"face", partscribe::testing::face_mask_height, 200.0 / 255, 0.5, 0.02},
        Relief{"hand", in_middle(partscribe::testing::hand_height, 0, 91), 186.0 / 255, 0.4, 0.02}}) {
    const SampleLattice lattice = noisy(lattice_of(relief.height, 256, 256, relief.pitch), relief.sigma, 3);
    const GeneralizedDelaunay result = triangulated(lattice, relief.tolerance);
    const MeshTopology top = topology(result.mesh);
    INFO(relief.name << ": " << result.mesh.triangles.size() << " triangles, " << result.samples << " samples, "
                     << result.uncovered.size() << " uncovered, " << result.broken_edges << " broken edges");
    CHECK(result.uncovered.empty());
    CHECK(result.max_distance < relief.tolerance);
    CHECK(violations(lattice, result.mesh, relief.tolerance) == 0);
    CHECK(result.mesh.triangles.size() < result.samples / 10);
    CHECK(result.broken_edges < result.mesh.triangles.size() / 50);
    CHECK(top.components == 1);
    CHECK(top.nonmanifold_edges == 0);
    CHECK(top.inconsistent_edges == 0);
  }
}
