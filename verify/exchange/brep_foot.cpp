#include <Eigen/Geometry>
#include <ElSLib.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <algorithm>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Lin.hxx>
#include <gp_Pln.hxx>
#include <gp_Sphere.hxx>
#include <gp_Torus.hxx>

#include "core/number.h"
#include "verify/exchange/brep_parts.h"

namespace partscribe::verify {
namespace {

Vec3 vec(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
gp_Pnt pnt(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

double wrapped(const ParameterRange& range, double x) {
  if (range.period > 0) {
    if (x < range.low || x > range.low + range.period) x -= range.period * std::floor((x - range.low) / range.period);
    return x;
  }
  return x;
}

SurfacePoint general_point(const Geom_Surface& surface, double u, double v) {
  gp_Pnt p;
  gp_Vec du, dv, duu, dvv, duv;
  surface.D2(u, v, p, du, dv, duu, dvv, duv);
  return {vec(p.XYZ()), vec(du.XYZ()), vec(dv.XYZ()), vec(duu.XYZ()), vec(duv.XYZ()), vec(dvv.XYZ())};
}

/// In the trim, with whole turns added where the parameter plane repeats.
bool in_trim(const BrepFace& face, const Vec2& uv) {
  const TrimRegion& trim = face.trim;
  auto first = [](const ParameterRange& range, double x, double low) {
    return range.period > 0 ? x - range.period * std::floor((x - low) / range.period) : x;
  };
  // A place on the seam itself may belong to either side of it.
  const double slip_u = 1e-9 * face.u.period, slip_v = 1e-9 * face.v.period;
  for (double u = first(face.u, uv.x(), trim.low().x() - slip_u); u <= trim.high().x() + slip_u; u += face.u.period) {
    for (double v = first(face.v, uv.y(), trim.low().y() - slip_v); v <= trim.high().y() + slip_v; v += face.v.period) {
      if (trim.contains({u, v})) return true;
      if (face.v.period == 0) break;
    }
    if (face.u.period == 0) break;
  }
  return false;
}

/// Descends to a foot on the surface, held inside the parameters' ranges.
void descend(const BrepFace& face, const Vec3& query, double& u, double& v, SurfacePoint& s) {
  u = wrapped(face.u, u), v = wrapped(face.v, v);
  if (face.u.period == 0) u = std::clamp(u, face.u.low, face.u.high);
  if (face.v.period == 0) v = std::clamp(v, face.v.low, face.v.high);
  s = surface_point(face, u, v);
  double value = (s.p - query).squaredNorm();
  for (int round = 0; round < 50; ++round) {
    const Vec3 r = s.p - query;
    const double gu = r.dot(s.du), gv = r.dot(s.dv);
    const double e = s.du.squaredNorm(), f = s.du.dot(s.dv), g = s.dv.squaredNorm();
    double a = e + r.dot(s.duu), b = f + r.dot(s.duv), c = g + r.dot(s.dvv);
    // Away from a minimum the full second derivative may point uphill; the first-order one never does.
    if (!(a > 1e-6 * e && c > 1e-6 * g && a * c - b * b > 1e-6 * e * g)) a = e, b = f, c = g;
    const double tiny = 1e-14 * (e + g);
    auto at_end = [](const ParameterRange& range, double x, double step) {
      return range.period == 0 && ((x <= range.low && step < 0) || (x >= range.high && step > 0));
    };
    double du = 0, dv = 0;
    const double determinant = a * c - b * b;
    if (determinant > 1e-12 * e * g && e > tiny && g > tiny) {
      du = -(c * gu - b * gv) / determinant, dv = -(a * gv - b * gu) / determinant;
    } else {
      if (e > tiny)
        du = -gu / std::max(a, e * 1e-3);
      else if (g > tiny)
        dv = -gv / std::max(c, g * 1e-3);
    }
    // At the end of a range only the other parameter moves.
    if (at_end(face.u, u, du)) du = 0, dv = g > tiny ? -gv / std::max(c, 1e-6 * g) : 0;
    if (at_end(face.v, v, dv)) {
      dv = 0, du = e > tiny ? -gu / std::max(a, 1e-6 * e) : 0;
      if (at_end(face.u, u, du)) du = 0;
    }
    const double moved = e * du * du + 2 * f * du * dv + g * dv * dv;
    if (!(moved > 1e-24)) return;
    bool improved = false;
    for (int halving = 0; halving < 12; ++halving, du *= 0.5, dv *= 0.5) {
      double nu = u + du, nv = v + dv;
      if (face.u.period == 0) nu = std::clamp(nu, face.u.low, face.u.high);
      if (face.v.period == 0) nv = std::clamp(nv, face.v.low, face.v.high);
      nu = wrapped(face.u, nu), nv = wrapped(face.v, nv);
      const SurfacePoint next = surface_point(face, nu, nv);
      const double next_value = (next.p - query).squaredNorm();
      if (next_value <= value) {
        improved = next_value < value;
        u = nu, v = nv, s = next, value = next_value;
        break;
      }
    }
    if (!improved || moved < 1e-17) return;  // the next step would be below any digit: convergence is quadratic
  }
}

template <class Surface>
Vec2 parameters(const Surface& surface, const gp_Pnt& p) {
  double u = 0, v = 0;
  ElSLib::Parameters(surface, p, u, v);
  return {u, v};
}

}  // namespace

SurfacePoint surface_point(const BrepFace& face, double u, double v) {
  return std::visit(
      [&](const auto& surface) -> SurfacePoint {
        using Kind = std::decay_t<decltype(surface)>;
        if constexpr (std::is_same_v<Kind, NurbsSurface>) {
          return surface.derivatives(std::clamp(wrapped(face.u, u), surface.u.low(), surface.u.high()),
                                     std::clamp(wrapped(face.v, v), surface.v.low(), surface.v.high()));
        } else if constexpr (std::is_same_v<Kind, Handle(Geom_Surface)>) {
          return general_point(*surface, u, v);
        } else {
          gp_Pnt p;
          gp_Vec du, dv;
          ElSLib::D1(u, v, surface, p, du, dv);
          return {vec(p.XYZ()), vec(du.XYZ()), vec(dv.XYZ()), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
        }
      },
      face.surface);
}

CurvePoint curve_point(const BrepEdge& edge, double t) {
  return std::visit(
      [&](const auto& curve) -> CurvePoint {
        using Kind = std::decay_t<decltype(curve)>;
        if constexpr (std::is_same_v<Kind, NurbsCurve<3>>) {
          CurvePoint at;
          curve.derivatives(std::clamp(t, curve.t.low(), curve.t.high()), at.p, at.d1, at.d2);
          return at;
        } else if constexpr (std::is_same_v<Kind, Handle(Geom_Curve)>) {
          gp_Pnt p;
          gp_Vec d1, d2;
          curve->D2(t, p, d1, d2);
          return {vec(p.XYZ()), vec(d1.XYZ()), vec(d2.XYZ())};
        } else if constexpr (std::is_same_v<Kind, gp_Lin>) {
          const Vec3 d = vec(curve.Direction().XYZ());
          return {vec(curve.Location().XYZ()) + t * d, d, Vec3::Zero()};
        } else {
          const Vec3 x = curve.Radius() * vec(curve.XAxis().Direction().XYZ()),
                     y = curve.Radius() * vec(curve.YAxis().Direction().XYZ());
          const Vec3 out = std::cos(t) * x + std::sin(t) * y;
          return {vec(curve.Location().XYZ()) + out, std::cos(t) * y - std::sin(t) * x, -out};
        }
      },
      edge.curve);
}

std::optional<SurfaceFoot> foot_on_face(const BrepFace& face, const Vec3& query, const Vec2& start) {
  Vec2 uv = start;
  SurfacePoint s;
  if (face.closed_form()) {
    const gp_Pnt p = pnt(query);
    uv = std::visit(
        [&](const auto& surface) -> Vec2 {
          using Kind = std::decay_t<decltype(surface)>;
          if constexpr (std::is_same_v<Kind, NurbsSurface> || std::is_same_v<Kind, Handle(Geom_Surface)>)
            return start;
          else
            return parameters(surface, p);
        },
        face.surface);
    if (!in_trim(face, uv)) return std::nullopt;
    s = surface_point(face, uv.x(), uv.y());
  } else {
    descend(face, query, uv.x(), uv.y(), s);
    if (!in_trim(face, uv)) return std::nullopt;
  }
  const Vec3 normal = s.du.cross(s.dv);
  return SurfaceFoot{s.p, face.reversed ? Vec3(-normal) : normal};
}

CurveFoot foot_on_edge(const BrepEdge& edge, const Vec3& query, double start) {
  double t = start;
  if (const auto* line = std::get_if<gp_Lin>(&edge.curve)) {
    t = vec(line->Direction().XYZ()).dot(query - vec(line->Location().XYZ()));
  } else if (const auto* circle = std::get_if<gp_Circ>(&edge.curve)) {
    const Vec3 r = query - vec(circle->Location().XYZ());
    const double x = vec(circle->XAxis().Direction().XYZ()).dot(r), y = vec(circle->YAxis().Direction().XYZ()).dot(r);
    t = std::atan2(y, x);
    t -= 2 * pi * std::floor((t - edge.first) / (2 * pi));
    // Off the arc the nearer end is the nearest place.
    if (t > edge.last && edge.first + 2 * pi - t < t - edge.last) t = edge.first;
  } else {
    t = std::clamp(t, edge.first, edge.last);
    CurvePoint c = curve_point(edge, t);
    double value = (c.p - query).squaredNorm();
    for (int round = 0; round < 50; ++round) {
      const Vec3 r = c.p - query;
      const double g = r.dot(c.d1), e = c.d1.squaredNorm();
      double h = e + r.dot(c.d2);
      if (!(h > 1e-6 * e)) h = e;
      if (!(e > 0)) break;
      double step = std::clamp(t - g / h, edge.first, edge.last) - t;
      const double moved = e * step * step;
      if (!(moved > 1e-24)) break;
      bool improved = false;
      for (int halving = 0; halving < 12; ++halving, step *= 0.5) {
        const CurvePoint next = curve_point(edge, t + step);
        const double next_value = (next.p - query).squaredNorm();
        if (next_value <= value) {
          improved = next_value < value;
          t += step, c = next, value = next_value;
          break;
        }
      }
      if (!improved || moved < 1e-17) break;
    }
  }
  const double clamped = std::clamp(t, edge.first, edge.last);
  return {curve_point(edge, clamped).p, clamped, t <= edge.first ? -1 : t >= edge.last ? 1 : 0};
}

}  // namespace partscribe::verify
