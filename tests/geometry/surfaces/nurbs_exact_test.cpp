#include "geometry/surfaces/nurbs_exact.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/number.h"
#include "geometry/surfaces/nurbs_edit.h"

namespace partscribe::geometry {
namespace {

/// Calls `check(point, u, v)` all over a surface, its edges and knots included.
template <class Check>
void all_over(const NurbsSurface& s, const Check& check) {
  for (int i = 0; i <= 48; ++i)
    for (int j = 0; j <= 24; ++j) {
      const double u = s.u.low() + (s.u.high() - s.u.low()) * i / 48, v = s.v.low() + (s.v.high() - s.v.low()) * j / 24;
      check(s.at(u, v), u, v);
    }
}

double axis_distance(const Vec3& p) { return std::hypot(p.x(), p.y()); }

/// Area by the midpoints of small rectangles of parameters, and by how far these are from `from` along the normals the
/// volume; both are near enough to tell wrong sides and missing parts.
double flux_of(const NurbsSurface& s) {
  double sum = 0;
  const auto bu = s.u.breaks(), bv = s.v.breaks();
  for (std::size_t a = 0; a + 1 < bu.size(); ++a)
    for (std::size_t b = 0; b + 1 < bv.size(); ++b)
      for (int i = 0; i < 32; ++i)
        for (int j = 0; j < 32; ++j) {
          const double hu = (bu[a + 1] - bu[a]) / 32, hv = (bv[b + 1] - bv[b]) / 32;
          const auto at = s.derivatives(bu[a] + (i + 0.5) * hu, bv[b] + (j + 0.5) * hv);
          sum += hu * hv * at.p.dot(at.du.cross(at.dv)) / 3;
        }
  return sum;
}

}  // namespace

TEST_CASE("nurbs_exact: arcs of any angle and either sense lie on their circle and meet its ends") {
  for (const double turn : {0.3, 1.0, pi / 2, 2.0, pi, 4.5, 2 * pi})
    for (const double side : {1.0, -1.0}) {
      const Arc2 arc{Vec2(3, -2), 7, 0.4, 0.4 + side * turn};
      const auto c = exact_arc(arc);
      CHECK((c.at(c.t.low()) - arc.at(arc.from)).norm() < 1e-13);
      CHECK((c.at(c.t.high()) - arc.at(arc.to)).norm() < 1e-13);
      CHECK(c.t.high() == Approx(turn));
      double last = -1e-12;
      for (int i = 0; i <= 200; ++i) {
        const Vec2 p = c.at(turn * i / 200) - arc.center;
        CHECK(p.norm() == Approx(7).epsilon(1e-14));
        // The parameter is nearly the angle, and is it where the pieces meet.
        double angle = side * (std::atan2(p.y(), p.x()) - arc.from);
        while (angle < last - 1) angle += 2 * pi;
        CHECK(angle == Approx(turn * i / 200).margin(0.03));
        CHECK(angle > last);
        last = angle;
      }
      for (const auto& [knot, times] : c.t.multiplicities()) {
        const Vec2 on = arc.at(arc.from + side * knot);
        CHECK((c.at(knot) - on).norm() < 1e-13);
      }
    }
  const auto full = exact_arc({Vec2(1, 1), 2, 0, 2 * pi});
  CHECK(full.points.size() == 9);
  CHECK(full.points.front() == full.points.back());
}

TEST_CASE("nurbs_exact: ellipses, hyperbolas and parabolas fulfil their equations") {
  const auto ellipse = exact_ellipse(Vec2(1, 2), Vec2(5, 0), Vec2(0, 3), 0.2, 5.7);
  const auto hyperbola = exact_hyperbola(Vec2(1, 2), Vec2(5, 0), Vec2(0, 3), -1.5, 2.0);
  const auto parabola = exact_parabola(Vec2(1, 2), Vec2(1, 0), Vec2(0, 0.25), -3, 4);
  CHECK(parabola.weights.empty());
  for (int i = 0; i <= 100; ++i) {
    const Vec2 e = ellipse.at(0.2 + 5.5 * i / 100) - Vec2(1, 2), h = hyperbola.at(-1.5 + 3.5 * i / 100) - Vec2(1, 2);
    CHECK(std::pow(e.x() / 5, 2) + std::pow(e.y() / 3, 2) == Approx(1).epsilon(1e-13));
    CHECK(std::pow(h.x() / 5, 2) - std::pow(h.y() / 3, 2) == Approx(1).epsilon(1e-12));
    CHECK(h.x() > 0);
    const double t = -3 + 0.07 * i;
    CHECK((parabola.at(t) - Vec2(1 + t, 2 + 0.25 * t * t)).norm() < 1e-13);
  }
  CHECK((hyperbola.at(2.0) - Vec2(1 + 5 * std::cosh(2.0), 2 + 3 * std::sinh(2.0))).norm() < 1e-12);
  // Half axes that are conjugate but not perpendicular: a sheared circle.
  const auto sheared = exact_ellipse(Vec2::Zero(), Vec2(4, 0), Vec2(2, 3), 0, 2 * pi);
  for (int i = 0; i <= 100; ++i) {
    const Vec2 p = sheared.at(2 * pi * i / 100);
    CHECK(std::hypot((p.x() - 2 * p.y() / 3) / 4, p.y() / 3) == Approx(1).epsilon(1e-13));
  }
}

TEST_CASE("nurbs_exact: quadrics and the torus are at their radii everywhere, with outward normals") {
  const auto cylinder = exact_cylinder(4, 10), cone = exact_cone(6, 2, 8), sphere = exact_sphere(5);
  const auto torus = exact_torus(10, 3);
  all_over(cylinder, [](const Vec3& p, double, double v) {
    CHECK(axis_distance(p) == Approx(4).epsilon(1e-12));
    CHECK(p.z() == Approx(v).margin(1e-12));
  });
  all_over(cone,
           [](const Vec3& p, double, double) { CHECK(axis_distance(p) == Approx(6 - p.z() / 2).epsilon(1e-12)); });
  all_over(sphere, [](const Vec3& p, double, double) { CHECK(p.norm() == Approx(5).epsilon(1e-12)); });
  all_over(torus, [](const Vec3& p, double, double) {
    CHECK(std::hypot(axis_distance(p) - 10, p.z()) == Approx(3).epsilon(1e-12));
  });
  for (const auto* s : {&cylinder, &cone, &sphere, &torus})
    all_over(*s, [&](const Vec3& p, double u, double v) {
      const Vec3 n = normal_at(*s, u, v), out = Vec3(p.x(), p.y(), 0).normalized();
      CHECK(n.norm() == Approx(1));
      if (s == &cylinder) CHECK((n - out).norm() < 1e-9);
      if (s == &cone) CHECK((n - Vec3(2 * out + Vec3::UnitZ()).normalized()).norm() < 1e-9);
      if (s == &sphere) CHECK((n - p / 5).norm() < 1e-7);
      if (s == &torus) CHECK((n - (p - 10 * out) / 3).norm() < 1e-9);
    });
  // By the divergence theorem; of the cylinder and the cone the lids' shares are left out.
  CHECK(flux_of(sphere) == Approx(4.0 / 3 * pi * 125).epsilon(1e-3));
  CHECK(flux_of(torus) == Approx(2 * pi * pi * 10 * 9).epsilon(1e-3));
  CHECK(flux_of(cylinder) == Approx(2.0 / 3 * pi * 16 * 10).epsilon(1e-3));
}

TEST_CASE("nurbs_exact: turned parabolas and hyperbolas are quadrics, and a part of a turn ends where it should") {
  const auto paraboloid = exact_revolution(exact_parabola(Vec2::Zero(), Vec2(1, 0), Vec2(0, 0.5), 0, 4), 0.3, 2.1);
  all_over(paraboloid, [](const Vec3& p, double, double) {
    CHECK(p.z() == Approx(0.5 * axis_distance(p) * axis_distance(p)).margin(1e-12));
    if (axis_distance(p) > 1e-9) {
      CHECK(std::atan2(p.y(), p.x()) > 0.3 - 1e-12);
      CHECK(std::atan2(p.y(), p.x()) < 2.1 + 1e-12);
    }
  });
  CHECK(paraboloid.at(2.1, 4.0).x() == Approx(4 * std::cos(2.1)));
  const auto waist = exact_revolution(exact_hyperbola(Vec2::Zero(), Vec2(2, 0), Vec2(0, 3), -1, 1), 0, 2 * pi);
  all_over(waist, [](const Vec3& p, double, double) {
    CHECK(std::pow(axis_distance(p) / 2, 2) - std::pow(p.z() / 3, 2) == Approx(1).epsilon(1e-12));
  });
}

TEST_CASE("nurbs_exact: lines between two turned circles are a hyperboloid, though the curves differ in their knots") {
  NurbsCurve<3> low = in_space(exact_arc({Vec2::Zero(), 5, 0, 2 * pi}));
  NurbsCurve<3> high = in_space(exact_arc({Vec2::Zero(), 5, 1.0, 1.0 + 2 * pi}));
  for (Vec3& p : high.points) p.z() = 6;
  const auto ruled = exact_ruled(with_knot(low, 1.0), with_higher_degree(with_knot(high, 4.0)));
  CHECK(ruled.u.degree == 3);
  // Between places at the turn of 1 radian: r^2 = 25 cos^2(1/2) + 25 sin^2(1/2) (z / 3 - 1)^2.
  all_over(ruled, [](const Vec3& p, double, double) {
    const double c = std::cos(0.5), s = std::sin(0.5), z = p.z() / 3 - 1;
    CHECK(axis_distance(p) == Approx(5 * std::sqrt(c * c + s * s * z * z)).epsilon(1e-12));
  });
  const NurbsCurve<3> line{clamped(1, {0, 2}), {Vec3(0, 0, 0), Vec3(4, 0, 0)}, {}};
  const NurbsCurve<3> bent{clamped(2, {0, 1, 3}), {Vec3(0, 3, 0), Vec3(1, 4, 1), Vec3(3, 2, 0), Vec3(4, 3, 2)}, {}};
  const auto strip = exact_ruled(line, bent);
  CHECK(strip.weights.empty());
  for (int i = 0; i <= 30; ++i)
    for (const double v : {0.0, 0.3, 1.0})
      CHECK((strip.at(i / 30.0, v) - ((1 - v) * line.at(2 * i / 30.0) + v * bent.at(3 * i / 30.0))).norm() < 1e-12);
}

TEST_CASE("nurbs_exact: a swept circle is a cylinder, a moved one is at its new place") {
  const auto swept = exact_extrusion(in_space(exact_arc({Vec2(1, 2), 3, 0, 2 * pi})), Vec3(0, 0, 5));
  all_over(swept, [](const Vec3& p, double, double v) {
    CHECK(std::hypot(p.x() - 1, p.y() - 2) == Approx(3).epsilon(1e-12));
    CHECK(p.z() == Approx(5 * v).margin(1e-13));
  });
  CHECK(swept.derivatives(0.2, 0.5).normal().dot(swept.at(0.2, 0.5) - Vec3(1, 2, 2.5)) > 0);
  const Pose pose{rotation_of(Vec3(0.3, -0.8, 0.5)), Vec3(7, 8, 9)};
  const auto moved_sphere = posed(exact_sphere(2), pose);
  all_over(moved_sphere, [&](const Vec3& p, double u, double v) {
    CHECK((p - pose.translation).norm() == Approx(2).epsilon(1e-12));
    CHECK((p - pose * exact_sphere(2).at(u, v)).norm() < 1e-13);
  });
}

}  // namespace partscribe::geometry
