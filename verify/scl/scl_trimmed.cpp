/// Surfaces within borders, alone or joined to shells.
#include <BRep_Tool.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <optional>

#include "verify/exchange/nurbs_of.h"
#include "verify/scl/scl_shape.h"

namespace partscribe::verify {
namespace {

std::optional<NurbsSurface> surface_of(const SclGeometry& geometry) {
  if (!geometry.shape || !geometry.natural) return std::nullopt;
  TopExp_Explorer faces(*geometry.shape, TopAbs_FACE);
  if (!faces.More()) return std::nullopt;
  const auto s = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(TopoDS::Face(faces.Current())));
  if (s.IsNull() || s->IsUPeriodic() || s->IsVPeriodic()) return std::nullopt;
  return nurbs_of(*s);
}

std::optional<NurbsCurve<2>> trim_of(const SclGeometry& geometry) {
  if (geometry.kind != SclGeometryKind::curve || !geometry.shape) return std::nullopt;
  double first = 0, last = 0;
  const auto c = Handle(Geom_BSplineCurve)::DownCast(BRep_Tool::Curve(TopoDS::Edge(*geometry.shape), first, last));
  if (c.IsNull()) return std::nullopt;
  const NurbsCurve<3> in_space = nurbs_of(*c);
  NurbsCurve<2> result{in_space.t, {}, in_space.weights};
  for (const Vec3& p : in_space.points) result.points.push_back(p.head<2>());
  return result;
}

/// A side of a border in space.
struct Side {
  SurfaceTrim* trim;
  Vec3 first, middle, last;
};

}  // namespace

SclMade scl_trimmed(const SclGeometryPtr& surface, const std::vector<std::vector<SclGeometryPtr>>& loops) {
  const auto whole = surface_of(*surface);
  if (!whole) return bad_input("expected a B-spline surface that is not periodic, to trim it");
  if (loops.empty()) return bad_input("expected a border, found no loops");
  auto result = std::make_shared<SclGeometry>();
  result->kind = SclGeometryKind::surface;
  TrimmedSurface trimmed{*whole, {}};
  const double size = std::max(whole->u.high() - whole->u.low(), whole->v.high() - whole->v.low());
  int edge = 0;
  for (const auto& loop : loops) {
    auto& curves = trimmed.loops.emplace_back();
    for (const auto& piece : loop) {
      const auto curve = trim_of(*piece);
      if (!curve) return bad_input(std::string("expected B-spline curves in a border, found ") + name_of(piece->kind));
      curves.push_back({*curve, edge++});
    }
    for (std::size_t i = 0; i < curves.size(); ++i)
      if ((curves[i].curve.points.back() - curves[(i + 1) % curves.size()].curve.points.front()).norm() > 1e-6 * size)
        return bad_input("expected a closed border, its curve " + std::to_string(i + 1) +
                         " does not end where the next begins");
  }
  result->trimmed.push_back(std::move(trimmed));
  return SclGeometryPtr(result);
}

SclMade trimmed_shell(const std::vector<SclGeometryPtr>& surfaces) {
  auto shell = std::make_shared<SclGeometry>();
  shell->kind = SclGeometryKind::shell;
  for (const auto& s : surfaces) {
    if (s->trimmed.empty()) return bad_input("expected surfaces within borders only, found a whole one among them");
    shell->trimmed.insert(shell->trimmed.end(), s->trimmed.begin(), s->trimmed.end());
  }
  std::vector<Side> sides;
  int number = 0;
  for (auto& surface : shell->trimmed)
    for (auto& loop : surface.loops)
      for (SurfaceTrim& trim : loop) {
        const auto at = [&](double share) {
          const auto& t = trim.curve.t;
          const Vec2 uv = trim.curve.at(t.low() + share * (t.high() - t.low()));
          return surface.surface.at(uv.x(), uv.y());
        };
        trim.edge = number++;
        sides.push_back({&trim, at(0), at(0.5), at(1)});
      }
  // Borders that are nearer to each other than they are long are one edge; the nearest pairs come first.
  struct Pair {
    double gap;
    std::size_t a, b;
  };
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < sides.size(); ++a)
    for (std::size_t b = a + 1; b < sides.size(); ++b) {
      const double length = (sides[a].middle - sides[a].first).norm() + (sides[a].last - sides[a].middle).norm();
      const double gap = std::max({(sides[a].first - sides[b].last).norm(), (sides[a].last - sides[b].first).norm(),
                                   (sides[a].middle - sides[b].middle).norm()});
      if (gap < 0.3 * length) pairs.push_back({gap, a, b});
    }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.gap < b.gap; });
  std::vector<char> taken(sides.size(), 0);
  std::size_t free = sides.size();
  for (const Pair& pair : pairs) {
    if (taken[pair.a] || taken[pair.b]) continue;
    taken[pair.a] = taken[pair.b] = 1, free -= 2;
    sides[pair.b].trim->edge = sides[pair.a].trim->edge;
  }
  shell->solid = free == 0;
  return SclGeometryPtr(shell);
}

}  // namespace partscribe::verify
