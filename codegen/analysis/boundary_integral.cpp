#include "codegen/analysis/boundary_integral.h"

#include <BRepAdaptor_Curve2d.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Eigen/Geometry>
#include <TColStd_Array1OfReal.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <gp_Pnt.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>
#include <gp_Vec2d.hxx>
#include <vector>

#include "core/number.h"

namespace partscribe::codegen {
namespace {

/// Area, volume, x y z, xx yy zz, xy xz yz; each divided by the power of the body's size that its unit has.
using Sums = Eigen::Matrix<double, 11, 1>;

// Eight points are exact for moments of bicubic faces.
constexpr std::array<double, 4> gauss_at = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                            0.9602898564975363};
constexpr std::array<double, 4> gauss_weight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                0.1012285362903763};

constexpr double converged = 1e-11;
constexpr int finest_level = 32;

/// Calls `visit(x, weight)` at the points of a rule on `panels` equal parts of [a, b].
template <class Visit>
void over_points(double a, double b, int panels, const Visit& visit) {
  const double half = (b - a) / (2 * panels);
  for (int p = 0; p < panels; ++p) {
    const double middle = a + (2 * p + 1) * half;
    for (std::size_t k = 0; k < gauss_at.size(); ++k) {
      visit(middle - half * gauss_at[k], half * gauss_weight[k]);
      visit(middle + half * gauss_at[k], half * gauss_weight[k]);
    }
  }
}

std::vector<double> values_in(const TColStd_Array1OfReal& array) { return {array.begin(), array.end()}; }

/// Parts of full turns that eight points do justice to.
void split_turns(std::vector<double>& breaks) {
  std::vector<double> finer = {breaks.front()};
  for (std::size_t i = 1; i < breaks.size(); ++i) {
    const int parts = std::max(1, static_cast<int>(std::ceil((breaks[i] - breaks[i - 1]) / (pi / 3) - 1e-9)));
    for (int k = 1; k <= parts; ++k)
      finer.push_back(k == parts ? breaks[i] : breaks[i - 1] + (breaks[i] - breaks[i - 1]) * k / parts);
  }
  breaks = std::move(finer);
}

/// The integrals of one face: outside the face's own plane of parameters nothing is known of it.
class FaceIntegral {
 public:
  FaceIntegral(const TopoDS_Face& face, const Vec3& origin, double size)
      : surface_(face, true), origin_(origin), size_(size) {
    TColStd_Array1OfReal u(1, surface_.NbUIntervals(GeomAbs_CN) + 1), v(1, surface_.NbVIntervals(GeomAbs_CN) + 1);
    surface_.UIntervals(u, GeomAbs_CN), surface_.VIntervals(v, GeomAbs_CN);
    u_breaks_ = values_in(u), v_breaks_ = values_in(v);
    if (surface_.IsUPeriodic()) split_turns(u_breaks_);
  }

  /// Green's theorem in the plane of parameters: along an edge, of what lies between it and the face's lower u.
  Sums along(const TopoDS_Edge& edge, const TopoDS_Face& face) const {
    const BRepAdaptor_Curve2d curve(edge, face);
    const std::vector<double> breaks = breaks_of(curve);
    Sums coarse = along(curve, breaks, 1);
    for (int level = 2; level <= finest_level; level *= 2) {
      const Sums fine = along(curve, breaks, level);
      const double change = (fine - coarse).cwiseAbs().maxCoeff();
      coarse = fine;
      if (change <= converged) break;
    }
    return coarse;
  }

 private:
  /// Where the curve or the surface under it is not smooth.
  std::vector<double> breaks_of(const BRepAdaptor_Curve2d& curve) const {
    TColStd_Array1OfReal own(1, curve.NbIntervals(GeomAbs_CN) + 1);
    curve.Intervals(own, GeomAbs_CN);
    std::vector<double> breaks = values_in(own);
    if (curve.IsPeriodic() || curve.GetType() == GeomAbs_Circle || curve.GetType() == GeomAbs_Ellipse)
      split_turns(breaks);
    if (v_breaks_.size() <= 2) return breaks;
    constexpr int samples = 16;  // a curve crosses no line of equal v twice between two of them
    std::vector<double> crossings;
    const auto v_at = [&](double t) { return curve.Value(t).Y(); };
    for (std::size_t i = 1; i < breaks.size(); ++i)
      for (int k = 0; k < samples; ++k) {
        const double step = (breaks[i] - breaks[i - 1]) / samples;
        const double a = breaks[i - 1] + k * step, b = a + step;
        for (std::size_t j = 1; j + 1 < v_breaks_.size(); ++j) {
          const double level = v_breaks_[j], va = v_at(a) - level, vb = v_at(b) - level;
          if (va * vb > 0 || va == vb) continue;
          double low = a, high = b;
          for (int bisection = 0; bisection < 60; ++bisection) {
            const double middle = (low + high) / 2;
            ((v_at(middle) - level > 0) == (va > 0) ? low : high) = middle;
          }
          crossings.push_back((low + high) / 2);
        }
      }
    breaks.insert(breaks.end(), crossings.begin(), crossings.end());
    std::sort(breaks.begin(), breaks.end());
    return breaks;
  }

  Sums along(const BRepAdaptor_Curve2d& curve, const std::vector<double>& breaks, int level) const {
    Sums sums = Sums::Zero();
    for (std::size_t i = 1; i < breaks.size(); ++i)
      over_points(breaks[i - 1], breaks[i], level, [&](double t, double weight) {
        gp_Pnt2d at;
        gp_Vec2d tangent;
        curve.D1(t, at, tangent);
        if (tangent.Y() != 0) sums += weight * tangent.Y() * row(at.X(), at.Y(), level);
      });
    return sums;
  }

  /// From the lower end of the face to `to`, at one v.
  Sums row(double to, double v, int level) const {
    Sums sums = Sums::Zero();
    double from = u_breaks_.front();
    for (std::size_t i = 1; i < u_breaks_.size() && from != to; ++i) {
      // The last part goes on: curves may leave the bounds by rounding.
      const bool last = i + 1 == u_breaks_.size() || to <= u_breaks_[i];
      const double end = last ? to : u_breaks_[i];
      over_points(from, end, level, [&](double u, double weight) { sums += weight * at(u, v); });
      from = end;
    }
    return sums;
  }

  Sums at(double u, double v) const {
    gp_Pnt place;
    gp_Vec along_u, along_v;
    surface_.D1(u, v, place, along_u, along_v);
    const Vec3 p = (Vec3(place.X(), place.Y(), place.Z()) - origin_) / size_;
    const Vec3 n = Vec3(along_u.X(), along_u.Y(), along_u.Z()).cross(Vec3(along_v.X(), along_v.Y(), along_v.Z())) /
                   (size_ * size_);
    Sums sums;
    sums << n.norm(), p.dot(n) / 3, p.cwiseAbs2().cwiseProduct(n) / 2, p.array().cube().matrix().cwiseProduct(n) / 3,
        p.x() * p.x() * p.y() * n.x() / 2, p.x() * p.x() * p.z() * n.x() / 2, p.y() * p.y() * p.z() * n.y() / 2;
    return sums;
  }

  BRepAdaptor_Surface surface_;
  Vec3 origin_;
  double size_;
  std::vector<double> u_breaks_, v_breaks_;
};

}  // namespace

BodyIntegrals body_integrals(const TopoDS_Shape& shape, const Vec3& origin) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(shape, box, false, false);
  const double size = std::sqrt(box.SquareExtent());
  Sums sums = Sums::Zero();
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const bool reversed = faces.Current().Orientation() == TopAbs_REVERSED;
    const TopoDS_Face face = TopoDS::Face(faces.Current().Oriented(TopAbs_FORWARD));
    const FaceIntegral integral(face, origin, size);
    Sums of_face = Sums::Zero();
    for (TopExp_Explorer edges(face, TopAbs_EDGE); edges.More(); edges.Next()) {
      const TopoDS_Edge& edge = TopoDS::Edge(edges.Current());
      if (edge.Orientation() == TopAbs_INTERNAL || edge.Orientation() == TopAbs_EXTERNAL) continue;
      const Sums part = integral.along(edge, face);
      of_face += edge.Orientation() == TopAbs_REVERSED ? Sums(-part) : part;
    }
    // The area has no direction; everything else changes its sign with the normal.
    const double area = of_face[0];
    if (reversed) of_face = -of_face;
    of_face[0] = area;
    sums += of_face;
  }
  BodyIntegrals integrals;
  integrals.area = sums[0] * std::pow(size, 2);
  integrals.volume = sums[1] * std::pow(size, 3);
  integrals.first = sums.segment<3>(2) * std::pow(size, 4);
  integrals.second = Vec3(sums.segment<3>(5)).asDiagonal();
  integrals.second(0, 1) = integrals.second(1, 0) = sums[8];
  integrals.second(0, 2) = integrals.second(2, 0) = sums[9];
  integrals.second(1, 2) = integrals.second(2, 1) = sums[10];
  integrals.second *= std::pow(size, 5);
  return integrals;
}

}  // namespace partscribe::codegen
