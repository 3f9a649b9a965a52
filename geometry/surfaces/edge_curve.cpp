#include "geometry/surfaces/edge_curve.h"

#include <algorithm>
#include <cmath>

namespace partscribe::geometry {
namespace {

constexpr double beside = 1e-9;       // share by which one-sided derivatives keep away from knots
constexpr double least_piece = 1e-5;  // share: knots of both sides that are nearer are one
constexpr int most_halvings = 10;

struct End {
  Vec3 place, derivative;
};

struct Piece {
  double from, to;
  End first, last;
  Vec3 at(double share) const {
    const double h = to - from, t = (share - from) / h, s = 1 - t;
    return s * s * (1 + 2 * t) * first.place + t * t * (3 - 2 * t) * last.place +
           h * (s * s * t * first.derivative - t * t * s * last.derivative);
  }
};

void halved(std::span<const EdgeSide> sides, double from, double to, double deviation, int depth,
            std::vector<Piece>& pieces) {
  Piece piece{from, to, {}, {}};
  edge_place(sides, from, false, piece.first.place, piece.first.derivative);
  edge_place(sides, to, true, piece.last.place, piece.last.derivative);
  bool near = depth == most_halvings;
  if (!near) {
    near = true;
    for (const double t : {0.2, 0.5, 0.8}) {
      Vec3 place, derivative;
      const double share = from + t * (to - from);
      edge_place(sides, share, false, place, derivative);
      near = near && (piece.at(share) - place).norm() < deviation;
    }
  }
  if (near) return pieces.push_back(piece);
  halved(sides, from, 0.5 * (from + to), deviation, depth + 1, pieces);
  halved(sides, 0.5 * (from + to), to, deviation, depth + 1, pieces);
}

}  // namespace

std::map<int, std::vector<EdgeSide>> edge_sides(std::span<const TrimmedSurface> surfaces) {
  std::map<int, std::vector<EdgeSide>> sides;
  for (const auto& surface : surfaces)
    for (const auto& loop : surface.loops)
      for (const auto& trim : loop) sides[trim.edge].push_back({&surface.surface, &trim.curve});
  return sides;
}

double edge_gap(std::span<const EdgeSide> sides, int pieces) {
  double gap = 0;
  for (int i = 0; sides.size() == 2 && i <= pieces; ++i) {
    Vec3 place[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const KnotVector& t = sides[k].trim->t;
      const double share = double(k == 0 ? i : pieces - i) / pieces;
      const Vec2 uv = sides[k].trim->at(t.low() + share * (t.high() - t.low()));
      place[k] = sides[k].surface->at(uv.x(), uv.y());
    }
    gap = std::max(gap, (place[0] - place[1]).norm());
  }
  return gap;
}

void edge_place(std::span<const EdgeSide> sides, double share, bool below, Vec3& place, Vec3& derivative) {
  place = derivative = Vec3::Zero();
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const KnotVector& t = sides[i].trim->t;
    const double length = t.high() - t.low(), towards = i == 0 ? length : -length;
    const double own = i == 0 ? share : 1 - share, off = (i == 0) == below ? -beside : beside;
    const double exact = t.low() + own * length, near = std::clamp(exact + off * length, t.low(), t.high());
    Vec2 uv, first, second;
    sides[i].trim->derivatives(near, uv, first, second);
    const SurfacePoint p = sides[i].surface->derivatives(uv.x(), uv.y());
    uv = sides[i].trim->at(exact);
    place += sides[i].surface->at(uv.x(), uv.y()) / double(sides.size());
    derivative += towards * (first.x() * p.du + first.y() * p.dv) / double(sides.size());
  }
}

NurbsCurve<3> edge_curve(std::span<const EdgeSide> sides, double deviation) {
  std::vector<double> breaks;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const KnotVector& t = sides[i].trim->t;
    for (const double knot : t.breaks()) {
      const double share = (knot - t.low()) / (t.high() - t.low());
      breaks.push_back(i == 0 ? share : 1 - share);
    }
  }
  std::sort(breaks.begin(), breaks.end());
  std::vector<Piece> pieces;
  double from = 0;
  for (const double to : breaks)
    if (to > from + least_piece) halved(sides, from, to > 1 - least_piece ? 1.0 : to, deviation, 0, pieces), from = to;
  NurbsCurve<3> curve;
  curve.t = {3, {0, 0, 0, 0}};
  curve.points = {pieces.front().first.place};
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& p = pieces[i];
    const double third = (p.to - p.from) / 3;
    curve.points.push_back(p.first.place + third * p.first.derivative);
    curve.points.push_back(p.last.place - third * p.last.derivative);
    if (i + 1 == pieces.size()) break;
    const Vec3 &before = p.last.derivative, &after = pieces[i + 1].first.derivative;
    const bool kink = (before - after).norm() > 1e-6 * (before.norm() + after.norm());
    curve.t.knots.insert(curve.t.knots.end(), kink ? 3 : 2, p.to);
    if (kink) curve.points.push_back(p.last.place);
  }
  curve.points.push_back(pieces.back().last.place);
  curve.t.knots.insert(curve.t.knots.end(), 4, 1.0);
  return curve;
}

}  // namespace partscribe::geometry
