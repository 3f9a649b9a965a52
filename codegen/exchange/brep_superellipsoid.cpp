// Superellipsoids and supertoroids as one spline surface each.
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <cmath>
#include <functional>

#include "codegen/exchange/brep_shapes.h"
#include "core/number.h"
#include "geometry/surfaces/quadric_distance.h"

// A superellipsoid is the product of two plane curves: x = a1 U(u) C(v) (1 + taper_x S(v)) and so on, with (U, V) on
// the unit superellipse of exponent e2, (C, S) on that of e1. Each curve is replaced by C1 cubics in the angle of the
// ray (regular for all exponents below 2), refined where they deviate; the product of two splines is a spline surface.
// Bending leaves it a sum of such products: x and z become sums of a curve in v and of U(u) times another one, so that
// the second curve has five coordinates.

namespace partscribe::codegen {
namespace {

/// Coordinates of a curve: three, and two more of a bent one.
using Row = Eigen::Matrix<double, 5, 1>;

Row row(double x, double y, double z, double u = 0, double w = 0) {
  Row r;
  r << x, y, z, u, w;
  return r;
}

/// A curve point and its derivative.
struct Jet {
  Row point, derivative;
};

/// The unit superellipse |x|^(2/e) + |y|^(2/e) = 1 at a ray angle in [0, pi/2].
void superellipse(double t, double e, double& x, double& y, double& dx, double& dy) {
  const double p = 2 / e;
  const double c = t >= pi / 2 ? 0 : std::cos(t), s = std::sin(t);
  const double sum = std::pow(c, p) + std::pow(s, p);
  const double r = std::pow(sum, -1 / p);
  const double sum_t = p * (std::pow(s, p - 1) * c - std::pow(c, p - 1) * s);
  const double r_t = -r / (p * sum) * sum_t;
  x = r * c, y = r * s;
  dx = r_t * c - r * s, dy = r_t * s + r * c;
}

/// Along the closed unit superellipse, turned into quarter `quarter`.
Jet closed_superellipse(double e, double t, int quarter) {
  double x, y, dx, dy;
  // Odd quarters run from the second axis to the first, so the quarter curve is taken backwards.
  const bool odd = quarter % 2 == 1;
  superellipse(odd ? pi / 2 - t : t, e, x, y, dx, dy);
  if (odd) dx = -dx, dy = -dy;
  const double sx = quarter == 0 || quarter == 3 ? 1 : -1, sy = quarter < 2 ? 1 : -1;
  return {row(sx * x, sy * y, 0), row(sx * dx, sy * dy, 0)};
}

/// Along the meridian: half 0 from the lower pole to the equator, half 1 from there up. Bent, the coordinates are those
/// across the bend (of x and z), the width, and those of the axis (of z and x).
Jet meridian(const SuperellipsoidOf<double>& s, double t, int half) {
  double c, z, dc, dz;
  superellipse(half == 0 ? pi / 2 - t : t, s.e1, c, z, dc, dz);
  if (half == 0) z = -z, dc = -dc;  // t runs backwards and z is mirrored: dz changes sign twice
  const double gx = 1 + s.taper_x * z, gy = 1 + s.taper_y * z;
  const double x = c * gx, y = c * gy, dx = dc * gx + c * s.taper_x * dz, dy = dc * gy + c * s.taper_y * dz;
  const double b = s.bend;
  if (b == 0) return {row(x, y, z), row(dx, dy, dz)};
  const double cos = std::cos(b * z), sin = std::sin(b * z), turn = b * dz;
  const Vec3 axis = bent({0, 0, z}, b);
  return {row(x * cos, y, axis.z(), x * sin, axis.x()),
          row(dx * cos - x * sin * turn, dy, cos * dz, dx * sin + x * cos * turn, sin * dz)};
}

using Curve = std::function<Jet(double t, int part)>;

Row hermite(const Jet& a, const Jet& b, double h, double w) {
  const double w2 = w * w, w3 = w2 * w;
  return (2 * w3 - 3 * w2 + 1) * a.point + (w3 - 2 * w2 + w) * h * a.derivative + (3 * w2 - 2 * w3) * b.point +
         (w3 - w2) * h * b.derivative;
}

/// The largest distance, along each axis scaled by `size`, between one cubic and its curve.
double deviation(const Curve& curve, int part, double from, double to, const Row& size, int samples) {
  const Jet a = curve(from, part), b = curve(to, part);
  double worst = 0;
  for (int i = 1; i < samples; ++i) {
    const double w = double(i) / samples;
    const Row d = hermite(a, b, to - from, w) - curve(from + w * (to - from), part).point;
    worst = std::max(worst, d.cwiseProduct(size).norm());
  }
  return worst;
}

/// Cuts [0, pi/2] until every cubic is within tolerance in all parts; the same cuts for all, mirrored where they run
/// back.
std::vector<double> nodes_of(const Curve& curve, int parts, const Row& size, double tolerance) {
  std::vector<double> nodes{0, pi / 4, pi / 2};
  for (std::size_t i = 0; i + 1 < nodes.size() && nodes.size() < 400;) {
    double worst = 0;
    for (int part = 0; part < parts; ++part) {
      const bool back = parts == 2 ? part == 0 : part % 2 == 1;
      const double from = back ? pi / 2 - nodes[i + 1] : nodes[i], to = back ? pi / 2 - nodes[i] : nodes[i + 1];
      worst = std::max(worst, deviation(curve, part, from, to, size, 8));
    }
    if (worst > tolerance && nodes[i + 1] - nodes[i] > 1e-7) {
      nodes.insert(nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1, (nodes[i] + nodes[i + 1]) / 2);
    } else {
      ++i;
    }
  }
  return nodes;
}

/// A C1 cubic spline in Bezier pieces; at corners the knot is threefold.
struct Spline {
  std::vector<Row> poles;
  std::vector<double> knots;
  std::vector<int> multiplicities;
  double error = 0;
};

Spline spline_of(const Curve& curve, int parts, bool corners, const Row& size, double tolerance) {
  const std::vector<double> nodes = nodes_of(curve, parts, size, tolerance);
  Spline spline;
  spline.poles.push_back(curve(0, 0).point);
  spline.knots.push_back(0);
  spline.multiplicities.push_back(4);
  for (int part = 0; part < parts; ++part) {
    const bool back = parts == 2 ? part == 0 : part % 2 == 1;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const std::size_t k = nodes.size() - 2 - i;
      const double from = back ? pi / 2 - nodes[k + 1] : nodes[i], to = back ? pi / 2 - nodes[k] : nodes[i + 1];
      const Jet a = curve(from, part), b = curve(to, part);
      spline.poles.push_back(a.point + (to - from) / 3 * a.derivative);
      spline.poles.push_back(b.point - (to - from) / 3 * b.derivative);
      spline.error = std::max(spline.error, deviation(curve, part, from, to, size, 23));
      const bool last_of_part = i + 2 == nodes.size();
      const bool last = last_of_part && part + 1 == parts;
      const bool corner = corners && last_of_part;
      if (corner || last) spline.poles.push_back(b.point);
      spline.knots.push_back(part * pi / 2 + to);
      spline.multiplicities.push_back(last ? 4 : corner ? 3 : 2);
    }
  }
  return spline;
}

/// A closed surface with these poles as a solid.
TopoDS_Shape solid_of(const TColgp_Array2OfPnt& poles, const Spline& u, const Spline& v) {
  auto reals = [](const std::vector<double>& list) {
    TColStd_Array1OfReal array(1, static_cast<int>(list.size()));
    for (std::size_t i = 0; i < list.size(); ++i) array(static_cast<int>(i) + 1) = list[i];
    return array;
  };
  auto integers = [](const std::vector<int>& list) {
    TColStd_Array1OfInteger array(1, static_cast<int>(list.size()));
    for (std::size_t i = 0; i < list.size(); ++i) array(static_cast<int>(i) + 1) = list[i];
    return array;
  };
  const Handle(Geom_BSplineSurface) surface = new Geom_BSplineSurface(
      poles, reals(u.knots), reals(v.knots), integers(u.multiplicities), integers(v.multiplicities), 3, 3);
  BRepBuilderAPI_MakeFace face(surface, 1e-6);
  if (!face.IsDone()) return {};
  BRep_Builder builder;
  TopoDS_Shell shell;
  builder.MakeShell(shell);
  builder.Add(shell, face.Face());
  shell.Closed(true);
  TopoDS_Solid solid;
  builder.MakeSolid(solid);
  builder.Add(solid, shell);
  BRepLib::OrientClosedSolid(solid);
  return solid;
}

}  // namespace

TopoDS_Shape brep_of(const SuperellipsoidOf<double>& s, double tolerance, double& error) {
  const double grow_x = 1 + std::abs(s.taper_x), grow_y = 1 + std::abs(s.taper_y);
  const Spline u = spline_of([&](double t, int part) { return closed_superellipse(s.e2, t, part); }, 4, s.e2 > 2 - 1e-9,
                             row(s.a1 * grow_x, s.a2 * grow_y, 0), tolerance / 2);
  const Spline v = spline_of([&](double t, int part) { return meridian(s, t, part); }, 2, s.e1 > 2 - 1e-9,
                             row(s.a1, s.a2, s.a3, s.a1, s.a3), tolerance / 2);
  error = u.error + v.error;
  TColgp_Array2OfPnt poles(1, static_cast<int>(u.poles.size()), 1, static_cast<int>(v.poles.size()));
  for (std::size_t i = 0; i < u.poles.size(); ++i) {
    const Row& ring_pole = i + 1 == u.poles.size() ? u.poles.front() : u.poles[i];
    for (std::size_t j = 0; j < v.poles.size(); ++j) {
      const bool tip = j == 0 || j + 1 == v.poles.size();
      const Row& m = v.poles[j];
      gp_Pnt& pole = poles(static_cast<int>(i) + 1, static_cast<int>(j) + 1);
      if (s.bend != 0) {
        const double out = tip ? 0 : s.a1 * ring_pole.x(), wide = tip ? 0 : s.a2 * ring_pole.y();
        pole = gp_Pnt(s.a3 * m[4] + out * m[0], wide * m[1], s.a3 * m[2] - out * m[3]);
      } else {
        pole = tip ? gp_Pnt(0, 0, j == 0 ? -s.a3 : s.a3)
                   : gp_Pnt(s.a1 * m.x() * ring_pole.x(), s.a2 * m.y() * ring_pole.y(), s.a3 * m.z());
      }
    }
  }
  return solid_of(poles, u, v);
}

TopoDS_Shape brep_of(const SupertoroidOf<double>& s, double tolerance, double& error) {
  const double reach = s.major_radius + s.minor_radius;
  const Spline u = spline_of([&](double t, int part) { return closed_superellipse(s.e2, t, part); }, 4, s.e2 > 2 - 1e-9,
                             row(reach, reach, 0), tolerance / 2);
  const Spline v = spline_of([&](double t, int part) { return closed_superellipse(s.e1, t, part); }, 4, s.e1 > 2 - 1e-9,
                             row(s.minor_radius, s.half_height, 0), tolerance / 2);
  error = u.error + v.error;
  TColgp_Array2OfPnt poles(1, static_cast<int>(u.poles.size()), 1, static_cast<int>(v.poles.size()));
  for (std::size_t i = 0; i < u.poles.size(); ++i) {
    const Row& ring = i + 1 == u.poles.size() ? u.poles.front() : u.poles[i];
    for (std::size_t j = 0; j < v.poles.size(); ++j) {
      const Row& tube = j + 1 == v.poles.size() ? v.poles.front() : v.poles[j];
      const double r = s.major_radius + s.minor_radius * tube.x();
      poles(static_cast<int>(i) + 1, static_cast<int>(j) + 1) =
          gp_Pnt(r * ring.x(), r * ring.y(), s.half_height * tube.y());
    }
  }
  return solid_of(poles, u, v);
}

}  // namespace partscribe::codegen
