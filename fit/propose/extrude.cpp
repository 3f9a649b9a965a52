#include "fit/propose/extrude.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/evidence/evidence.h"
#include "fit/refine/refine.h"
#include "fit/search/equal_choices.h"
#include "fit/sketch/common_outlines.h"
#include "fit/sketch/end_rims.h"
#include "fit/sketch/outline_cells.h"
#include "fit/sketch/plane_circle.h"
#include "fit/sketch/round_holes.h"
#include "fit/sketch/sketch_builder.h"
#include "geometry/points/nearby_in_plane.h"
#include "model/check.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

constexpr double end_cosine = 0.98, side_sine = 0.2;  // of 11.5 degrees

/// Of the points, at least this many have normals along or across the sweep. Noise and outliers spoil normals.
double least_share(const FitInput& input) {
  const bool spoilt = input.outlier_share > 0 || input.sampling.sigma > 0.003 * input.bounds.diagonal();
  return spoilt ? 0.65 : 0.85;
}

/// A direction along which the part is swept, and between which heights.
struct Sweep {
  Vec3 direction;
  double low = 0, high = 0, share = 0;
  /// mm, standard deviation of the end whose face was not seen; 0: both were seen, or no outliers lie beyond
  double open_end = 0;
  bool opens_below = false;
  double last = 0;  ///< height of the last points at the open end

  /// Extended to these points: the data cannot tell a curtain of outliers behind the edges from a wall.
  Sweep to_last() const {
    Sweep s = *this;
    (opens_below ? s.low : s.high) = last, s.open_end = std::max(open_end, (s.high - s.low) - (high - low));
    return s;
  }
};

/// Where the walls end that start at `from` and run towards `sign`, and how well that is known.
struct FarEnd {
  double at = 0, sigma = 0;  // mm
};

/// If no face was seen at the other end and outliers lie beyond: the place where the density drops (the likeliest
/// change point between two constant densities); else the last point.
FarEnd far_end(const std::vector<double>& heights, double from, double sign, double last) {
  constexpr double fewer = 4, least = 0.1;  // times, share of the way to the last
  std::vector<double> way;
  for (const double h : heights)
    if (const double t = sign * (h - from); t > 0) way.push_back(t);
  std::sort(way.begin(), way.end());
  const double whole = sign * (last - from), n = double(way.size());
  if (!(whole > 0) || way.size() < 20) return {last, std::abs(whole)};
  double best = n * std::log(n / whole), end = whole, gap = whole / n;
  for (std::size_t i = 0; i + 1 < way.size() && way[i] < 0.95 * whole; ++i) {
    const double near = double(i + 1), t = way[i];
    if (t < least * whole || near / t < fewer * (n - near) / (whole - t)) continue;
    const double likelihood = near * std::log(near / t) + (n - near) * std::log((n - near) / (whole - t));
    if (likelihood > best) best = likelihood, end = t, gap = t / near;
  }
  return {from + sign * end, 3 * gap};
}

/// The height of the outermost face across the sweep, towards `sign`, beyond which there are hardly any wall points
/// except outliers. Both lists are sorted.
std::optional<double> outermost_face(const std::vector<double>& ends, const std::vector<double>& sides, double sign,
                                     double width) {
  constexpr double some = 0.05, hardly_any = 0.02;  // shares
  constexpr std::size_t least = 20;
  const auto count = [](const std::vector<double>& sorted, double from, double to) {
    return std::size_t(std::upper_bound(sorted.begin(), sorted.end(), to) -
                       std::lower_bound(sorted.begin(), sorted.end(), from));
  };
  const std::size_t enough = std::max(least, std::size_t(some * double(ends.size())));
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const double outer = ends[sign < 0 ? k : ends.size() - 1 - k], inner = outer - sign * width;
    const double low = std::min(outer, inner), high = std::max(outer, inner);
    if (count(ends, low, high) < enough) continue;
    const std::size_t beyond = sign < 0 ? count(sides, -1e300, low) : count(sides, high, 1e300);
    if (double(beyond) > hardly_any * double(sides.size())) return {};
    const auto first = std::lower_bound(ends.begin(), ends.end(), low),
               last = std::upper_bound(ends.begin(), ends.end(), high);
    return *(first + (last - first) / 2);
  }
  return {};
}

std::optional<Sweep> measured_sweep(const FitInput& input, Vec3 a) {
  const auto& cloud = input.cloud;
  for (int round = 0; round < 4; ++round) {
    Mat3 m = Mat3::Zero();
    for (const auto& n : cloud.normals) {
      const double c = std::abs(n.dot(a));
      // Side normals are perpendicular to the direction, end normals parallel: both pull it straight.
      if (c < side_sine)
        m += n * n.transpose();
      else if (c > end_cosine)
        m -= n * n.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(m);
    const Vec3 next = eigen.eigenvectors().col(0);
    a = next.dot(a) < 0 ? Vec3(-next) : next;
  }
  // Which end is the bottom is arbitrary. With many outliers the sense that was found is kept: where they make an end
  // uncertain, random draws in another frame could give another plate.
  if (input.outlier_share == 0) a = nearest_sense(a);
  Sweep sweep;
  sweep.direction = a;
  std::vector<double> ends, sides;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double c = std::abs(cloud.normals[i].dot(a)), h = cloud.points[i].dot(a);
    if (c > end_cosine)
      ends.push_back(h);
    else if (c < side_sine)
      sides.push_back(h);
  }
  const double n = double(cloud.size());
  sweep.share = double(ends.size() + sides.size()) / n;
  if (sweep.share < least_share(input) || double(sides.size()) < 0.03 * n) return {};
  double low = quantile(sides, 0.002), high = quantile(sides, 0.998);
  if (input.outlier_share > 0) {
    std::sort(ends.begin(), ends.end()), std::sort(sides.begin(), sides.end());
    const double width = std::max(input.tolerance, 4 * input.sampling.sigma);
    if (const auto face = outermost_face(ends, sides, -1, width)) low = *face;
    if (const auto face = outermost_face(ends, sides, 1, width)) high = *face;
  }
  const double middle = 0.5 * (low + high), reach = std::max(3 * input.tolerance, 0.03 * (high - low));
  std::vector<double> bottom, top;
  std::size_t outlier = 0;
  for (const double h : ends) {
    if (h < middle && std::abs(h - low) < reach)
      bottom.push_back(h);
    else if (h > middle && std::abs(h - high) < reach)
      top.push_back(h);
    else
      ++outlier;
  }
  if (double(outlier) > (input.outlier_share > 0 ? 0.1 : 0.05) * n) return {};
  if (bottom.size() > 20) low = quantile(bottom, 0.5);
  if (top.size() > 20) high = quantile(top, 0.5);
  if (bottom.size() <= 20 && top.size() <= 20) return {};
  if (input.outlier_share > 0 && std::min(bottom.size(), top.size()) <= 20) {
    const bool below = bottom.size() <= 20;
    const FarEnd end = below ? far_end(sides, high, -1, low) : far_end(sides, low, 1, high);
    sweep.opens_below = below, sweep.last = below ? low : high;
    (below ? low : high) = end.at;
    sweep.open_end = std::max(end.sigma, input.sampling.sigma);
  }
  sweep.low = low, sweep.high = high;
  if (!(high - low > 2 * input.tolerance)) return {};
  return sweep;
}

std::vector<Sweep> sweeps_of(const FitInput& input, const std::vector<Vec3>& starts) {
  std::vector<Vec3> directions;
  auto add = [&](const Vec3& d) {
    if (!(d.norm() > 1e-6)) return;
    const Vec3 u = d.normalized();
    for (const auto& known : directions)
      if (std::abs(known.dot(u)) > 0.995) return;
    directions.push_back(u);
  };
  // The most frequent normals, then their cross products, then what the hypothesis says.
  const auto& normals = input.cloud.normals;
  const std::size_t step = std::max<std::size_t>(1, normals.size() / 300);
  std::vector<std::pair<std::size_t, Vec3>> votes;
  for (std::size_t i = 0; i < normals.size(); i += step) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < normals.size(); k += 7) count += std::abs(normals[k].dot(normals[i])) > 0.995;
    votes.emplace_back(count, normals[i]);
  }
  std::stable_sort(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [count, n] : votes) {
    if (directions.size() >= 5) break;
    add(n);
  }
  const std::size_t planes = std::min<std::size_t>(directions.size(), 3);
  for (std::size_t i = 0; i < planes; ++i)
    for (std::size_t k = i + 1; k < planes; ++k) add(directions[i].cross(directions[k]));
  for (const auto& d : starts) add(d);
  std::vector<Sweep> sweeps;
  for (const auto& d : directions)
    if (const auto sweep = measured_sweep(input, d)) {
      bool known = false;
      for (const auto& other : sweeps) known |= std::abs(other.direction.dot(sweep->direction)) > 0.999;
      if (!known) sweeps.push_back(*sweep);
    }
  std::stable_sort(sweeps.begin(), sweeps.end(), [](const Sweep& a, const Sweep& b) { return a.share > b.share; });
  if (sweeps.size() > 3) sweeps.resize(3);
  return sweeps;
}

double chain_area(const Chain& chain) {
  double sum = 0;
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    const Vec2 &a = chain.nodes[i].position, &b = chain.nodes[(i + 1) % chain.nodes.size()].position;
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum / 2;
}

void turn(ProfileSegment& s, double angle) {
  const Eigen::Matrix2d r =
      (Eigen::Matrix2d() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)).finished();
  for (Vec2* v : {&s.start, &s.end, &s.point, &s.direction, &s.center}) *v = r * *v;
  for (auto& c : s.curve.points) c = r * c;
}

/// What the length of the extrusion is called in a box or wedge.
void call_height(Candidate& candidate, const char* note) {
  for (auto& p : candidate.parameters)
    if (p.name == "height") p.note = note;
}

/// Box or wedge, if that is what the outline is.
void simplify(Candidate& candidate) {
  const auto* extrude = std::get_if<Extrude>(&candidate.shape);
  if (!extrude || extrude->sketch.loops.size() != 1) return;
  const auto& elements = extrude->sketch.loops[0].elements;
  if (elements.size() == 1) {
    const auto* arc = std::get_if<SketchArc>(&elements[0]);
    if (!arc || !arc->radius.is_parameter()) return;
    std::vector<Parameter> kept;
    for (const auto& p : candidate.parameters)
      if (p.name == arc->radius.parameter || p.name == "height") kept.push_back(p);
    kept[0].name = "radius", kept[0].note = "radius of the cylinder";
    candidate.parameters = kept;
    candidate.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
    candidate.procedure = "cylinder", candidate.object_name = "rod";
    call_height(candidate, "length of the cylinder");
    return;
  }
  if (elements.size() != 4) return;
  std::vector<SketchPoint> p;
  for (const auto& e : elements) {
    const auto* point = std::get_if<SketchPoint>(&e);
    if (!point) return;
    p.push_back(*point);
  }
  // Start at the corner on the origin; the outline runs counter-clockwise.
  for (int k = 0; k < 4 && !(p[0].x == Expr(0) && p[0].y == Expr(0)); ++k)
    std::rotate(p.begin(), p.begin() + 1, p.end());
  if (!(p[0].x == Expr(0) && p[0].y == Expr(0))) return;
  if (p[1].y == Expr(0) && p[1].x.is_parameter() && p[2].x == p[1].x && p[2].y == p[3].y && p[2].y.is_parameter() &&
      p[3].x == Expr(0)) {
    candidate.shape = Box{p[1].x, p[2].y, Expr::of("height")};
    candidate.procedure = "box", candidate.object_name = "block";
    call_height(candidate, "size along z");
  }
}

double weight_of(const Chain& chain) {
  double weight = 0;
  for (const auto& node : chain.nodes) weight += node.weight;
  return weight;
}

/// Closed chains, the outer one first and counter-clockwise, holes clockwise; none if a large piece stays open.
std::vector<Chain> rings_of(const std::vector<PlanePoint>& points, double noise, double cell) {
  ChainOptions options;
  options.noise = noise;
  options.cell = cell;
  auto chains = chains_of(points, options);
  if (!chains.empty() && fills_area(chains[0], cell)) return {};
  double total = 0;
  for (const auto& chain : chains) total += weight_of(chain);
  std::vector<Chain> rings;
  for (auto& chain : chains) {
    const double weight = weight_of(chain);
    const double gap = (chain.nodes.front().position - chain.nodes.back().position).norm();
    if (!chain.closed && gap > 0.4 * length_of(chain)) {
      if (weight > 0.05 * total) return {};
      continue;
    }
    if (weight < 0.002 * total || chain.nodes.size() < 6) continue;
    chain.closed = true;
    rings.push_back(chain);
  }
  std::stable_sort(rings.begin(), rings.end(),
                   [](const Chain& a, const Chain& b) { return std::abs(chain_area(a)) > std::abs(chain_area(b)); });
  for (std::size_t i = 0; i < rings.size(); ++i)
    if ((chain_area(rings[i]) > 0) != (i == 0)) std::reverse(rings[i].nodes.begin(), rings[i].nodes.end());
  return rings;
}

Chain ring_of(const PlaneCircle& circle, double noise) {
  constexpr int count = 36;
  Chain ring;
  ring.closed = true;
  for (int k = 0; k < count; ++k) {
    const double angle = -2 * pi * k / count;  // clockwise
    const Vec2 out(std::cos(angle), std::sin(angle));
    ChainNode node;
    node.position = circle.center + circle.radius * out;
    node.tangent = {out.y(), -out.x()};
    node.sigma = noise, node.weight = 1;
    ring.nodes.push_back(node);
  }
  return ring;
}

/// The points of the rims of both end faces that may replace an unseen wall: nothing lies farther out, and no wall is
/// near.
std::vector<PlanePoint> outer_rims(const std::vector<Vec2> (&ends)[2], const std::vector<PlanePoint>& walls,
                                   double cell) {
  const NearbyInPlane wall(walls, &PlanePoint::position);
  std::vector<PlanePoint> result;
  for (const auto& end : ends)
    for (const auto& p : rim_of(end)) {
      if (wall.within(p.position, 2 * cell)) continue;
      const Vec2 along(-p.normal.y(), p.normal.x());
      const auto beyond = [&](const Vec2& q) {
        const Vec2 d = q - p.position;
        return d.dot(p.normal) > 2 * cell && std::abs(d.dot(along)) < cell;
      };
      const bool inside =
          std::any_of(end.begin(), end.end(), beyond) ||
          std::any_of(walls.begin(), walls.end(), [&](const PlanePoint& w) { return beyond(w.position); });
      if (!inside) result.push_back(p);
    }
  return result;
}

/// Rings where walls were hidden: round holes from a part of their wall, the outline from walls and, if asked for, from
/// rims of the end faces.
std::vector<Chain> rings_of_parts(const std::vector<PlanePoint>& walls, const std::vector<Vec2> (&ends)[2],
                                  bool with_rims, double noise, double cell, double band, double size) {
  std::vector<Vec2> both = ends[0];
  both.insert(both.end(), ends[1].begin(), ends[1].end());
  const std::vector<PlaneCircle> holes = partly_seen_holes(walls, both, band, size);
  std::vector<PlanePoint> outline;
  const auto keep = [&](const PlanePoint& p) {
    if (std::none_of(holes.begin(), holes.end(),
                     [&](const PlaneCircle& h) { return (p.position - h.center).norm() < h.radius + 3 * band; }))
      outline.push_back(p);
  };
  for (const auto& p : walls) keep(p);
  if (with_rims)
    for (const auto& p : outer_rims(ends, walls, cell)) keep(p);
  std::vector<Chain> rings = rings_of(outline, noise, cell);
  if (rings.empty()) return rings;
  rings.resize(1);
  for (const auto& hole : holes) rings.push_back(ring_of(hole, noise));
  return rings;
}

/// rad, in the plane of `frame`: how x must turn to run along the longest straight edge; of several such the one
/// nearest to the scan's x.
double along_longest_edge(const LoopPieces& outline, const Mat3& frame, double tolerance) {
  constexpr double as_long = 0.03, opposite = 0.1;  // shares; noise says where in a round the edge across ends
  std::vector<const ProfileSegment*> edges;
  for (const auto& s : outline.segments)
    if (!s.arc && !s.spline) edges.push_back(&s);
  if (edges.empty()) return 0;
  const ProfileSegment& longest =
      **std::ranges::max_element(edges, {}, [](const ProfileSegment* s) { return s->length(); });
  std::vector<Vec3> directions;
  std::erase_if(edges, [&](const ProfileSegment* s) {
    const double share = s->direction.dot(longest.direction) < -0.99 ? opposite : as_long;
    return s->length() < longest.length() - std::max(share * longest.length(), tolerance);
  });
  for (const auto* s : edges) directions.push_back(frame.leftCols<2>() * s->direction);
  const Vec2& d = edges[nearest_to_scan(directions, {0, 1, 2})]->direction;
  return std::atan2(d.y(), d.x());
}

/// Holes ordered by size and those of one size by place, so that their numbers do not depend on noise.
void order_holes(std::vector<LoopPieces>& loops, double tolerance) {
  if (loops.size() < 3) return;
  std::vector<Vec2> places;
  std::vector<double> sizes;
  for (std::size_t k = 1; k < loops.size(); ++k) {
    const auto& segments = loops[k].segments;
    const bool round = segments.size() == 1 && segments[0].arc;
    const Vec2 reach = Vec2::Constant(round ? segments[0].radius : 0);
    Vec2 low = Vec2::Constant(1e300), high = -low;
    for (const auto& s : segments)
      for (const Vec2& p : {round ? s.center : s.start, round ? s.center : s.end})
        low = low.cwiseMin(p - reach), high = high.cwiseMax(p + reach);
    places.push_back((low + high) / 2), sizes.push_back((high - low).sum());
  }
  std::vector<LoopPieces> ordered = {loops[0]};
  for (const std::size_t k : by_size(sizes, in_order(places, tolerance), tolerance)) {
    ordered.push_back(loops[k + 1]);
    ordered.back().name = loops[ordered.size() - 1].name;
  }
  loops = std::move(ordered);
}

/// The extrusion of an outline and its holes; x runs along the longest straight edge.
Candidate extrusion_of(std::vector<LoopPieces> loops, const FitInput& input, const Sweep& sweep, const Mat3& frame) {
  double angle = along_longest_edge(loops[0], frame, input.tolerance);
  SketchOptions sketch_options;
  sketch_options.tolerance = input.tolerance;
  const auto turned_by = [&](double by) {
    for (auto& loop : loops)
      for (auto& s : loop.segments) turn(s, by);
    order_holes(loops, input.tolerance);
    return build_sketch(loops, sketch_options);
  };
  BuiltSketch built = turned_by(-angle);
  // The part extends from its origin along +x rather than along -x.
  double left = 0, right = 0;
  for (const auto& s : loops[0].segments)
    for (const double x : {s.start.x(), s.end.x()})
      left = std::max(left, built.origin.x() - x), right = std::max(right, x - built.origin.x());
  if (left > right + input.tolerance) {
    angle += pi;
    built = turned_by(pi);
  }
  Candidate c;
  c.procedure = "extrusion";
  c.object_name = "plate";
  c.parameters = std::move(built.parameters);
  Parameter height;
  height.name = "height";
  height.value = height.fitted = sweep.high - sweep.low;
  height.note = "length of the extrusion";
  c.parameters.push_back(height);
  if (sweep.open_end > 0) c.held = {{"height", sweep.open_end}};
  c.shape = Extrude{std::move(built.sketch), Expr::of("height")};
  c.scan_from_part.rotation = frame * rotation_of(Vec3(0, 0, angle));
  c.scan_from_part.translation = c.scan_from_part.rotation * Vec3(built.origin.x(), built.origin.y(), sweep.low);
  if (const Sweep longer = sweep.to_last();
      sweep.open_end > 0 && longer.high - longer.low > sweep.high - sweep.low + input.tolerance) {
    Candidate other = c;
    for (auto& p : other.parameters)
      if (p.name == height.name) p.value = p.fitted = longer.high - longer.low;
    other.held = {{height.name, longer.open_end}};
    other.scan_from_part.translation = c.scan_from_part.rotation * Vec3(built.origin.x(), built.origin.y(), longer.low);
    simplify(other);
    c.otherwise = std::make_shared<const Candidate>(std::move(other));
  }
  simplify(c);
  return c;
}

/// Adds a candidate for every level of detail at which the rings split differently.
void add_outlines(const FitInput& input, const Sweep& sweep, const Mat3& frame, const std::vector<Chain>& rings,
                  double outline, std::vector<Candidate>& candidates) {
  std::vector<std::size_t> seen;  // what was proposed already: pieces and control points
  for (const double share : {0.35, 0.15, 0.07, 0.03})
    for (const double spline : {0.0, 0.15 * input.tolerance}) {
      ProfileOptions profile_options;
      profile_options.floor = share * input.tolerance;
      profile_options.spline = spline;
      profile_options.size = outline / 2;
      std::vector<LoopPieces> loops;
      std::size_t pieces = 0, controls = 0;
      for (std::size_t i = 0; i < rings.size(); ++i) {
        LoopPieces loop;
        loop.name = i == 0 ? "outline" : rings.size() == 2 ? "hole" : "hole " + print_number(double(i));
        loop.segments = segments_of(rings[i], profile_options);
        pieces += loop.segments.size();
        for (const auto& s : loop.segments) controls += s.curve.points.size();
        if (loop.segments.size() > 1 || (loop.segments.size() == 1 && loop.segments[0].arc))
          loops.push_back(std::move(loop));
      }
      const std::size_t key = pieces + 1000 * controls;
      if (loops.empty() || pieces > 120 || std::find(seen.begin(), seen.end(), key) != seen.end()) continue;
      seen.push_back(key);
      candidates.push_back(extrusion_of(std::move(loops), input, sweep, frame));
    }
}

/// What is seen along a sweep.
struct Section {
  Sweep sweep;
  Mat3 frame;  ///< columns x, y, and z along the sweep
  std::vector<PlanePoint> walls;
  std::vector<Vec2> ends[2];     ///< points of the faces at the low and the high end
  std::vector<Vec2> between;     ///< points of neither, whatever their normals
  double size = 0, outline = 0;  ///< mm, longer side and circumference of the box around the walls
  double noise = 0, fine = 0;    ///< mm, of a wall point; least distance of nodes
};

Section section_of(const FitInput& input, const Sweep& sweep) {
  Section s{sweep, rotation_onto_axis(sweep.direction), {}, {}, {}};
  const double margin = 0.5 * input.tolerance, thick = std::max(2.5 * input.sampling.sigma, input.tolerance);
  Vec2 low = Vec2::Constant(1e300), high = -low;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 q = s.frame.transpose() * input.cloud.points[i], n = s.frame.transpose() * input.cloud.normals[i];
    if (std::abs(n.z()) > 0.9)
      for (const bool top : {false, true})
        if (std::abs(q.z() - (top ? sweep.high : sweep.low)) < thick) s.ends[top].push_back(q.head<2>());
    if (q.z() > sweep.low + thick && q.z() < sweep.high - thick) s.between.push_back(q.head<2>());
    if (std::abs(n.z()) > side_sine || q.z() < sweep.low - margin || q.z() > sweep.high + margin) continue;
    s.walls.push_back({q.head<2>(), n.head<2>().normalized()});
    low = low.cwiseMin(q.head<2>()), high = high.cwiseMax(q.head<2>());
  }
  if (s.walls.empty()) return s;
  s.size = (high - low).maxCoeff(), s.outline = 2 * (high - low).sum();
  s.noise = std::max(input.sampling.sigma, 1e-6 * s.outline);
  s.fine = std::max({s.outline / 700, 1.5 * s.noise, 6 * s.outline / double(s.walls.size())});
  return s;
}

OutlineData outline_data(const FitInput& input, const Section& s, double band) {
  OutlineData data;
  data.walls = s.walls, data.band = band, data.spacing = input.thin_spacing, data.outward = input.oriented;
  for (const auto& end : s.ends) data.ends.insert(data.ends.end(), end.begin(), end.end());
  return data;
}

/// With walls alone, and with the rims of the end faces.
void add_outlines_by_cells(const FitInput& input, const Section& s, double band, std::vector<Candidate>& candidates) {
  OutlineData data = outline_data(input, s, band);
  for (const bool with_rims : {false, true}) {
    if (with_rims) data.rims = outer_rims(s.ends, s.walls, std::max(s.fine, 3 * input.thin_spacing));
    auto loops = outline_by_cells(data);
    if (!loops.empty()) candidates.push_back(extrusion_of(std::move(loops), input, s.sweep, s.frame));
  }
}

LoopPieces loop_of(const PlaneCircle& hole, std::string name) {
  ProfileSegment s;
  s.arc = true, s.center = hole.center, s.radius = hole.radius, s.sweep = -2 * pi;
  s.start = s.end = hole.center + Vec2(hole.radius, 0);
  return {{s}, false, std::move(name)};
}

std::vector<LoopPieces> with_holes(const LoopPieces& outline, const std::vector<PlaneCircle>& holes) {
  std::vector<LoopPieces> loops = {outline};
  for (std::size_t i = 0; i < holes.size(); ++i)
    loops.push_back(loop_of(holes[i], holes.size() == 1 ? "hole" : "hole " + print_number(double(i + 1))));
  return loops;
}

/// Sides that depend on hardly any wall point stay where the end faces put them: a fit would move them towards
/// outliers.
void hold_unseen(Candidate& candidate, const FitInput& input) {
  constexpr double speaks = 0.1;  // of the distance, per unit of the parameter
  if (among_outliers(input) || input.closed) return;
  const double near = std::max(4 * input.sampling.sigma, input.tolerance), h = 1e-4 * input.bounds.diagonal();
  const Pose part_from_scan = candidate.scan_from_part.inverse();
  const ModelDistance distance(bare_model(candidate));
  std::vector<std::pair<Vec3, double>> on_surface;
  for (const Vec3& p : input.cloud.points) {
    const Vec3 q = part_from_scan * p;
    if (const double d = distance(q).distance; std::abs(d) < near) on_surface.emplace_back(q, d);
  }
  for (std::size_t k = 0; k < candidate.parameters.size(); ++k) {
    Candidate moved = candidate;
    moved.parameters[k].value += h;
    const ModelDistance other(bare_model(moved));
    const auto count = std::count_if(on_surface.begin(), on_surface.end(), [&](const auto& p) {
      return std::abs(other(p.first).distance - p.second) > speaks * h;
    });
    const std::string& name = candidate.parameters[k].name;
    const bool known = std::any_of(candidate.held.begin(), candidate.held.end(),
                                   [&](const HeldParameter& held) { return held.name == name; });
    if (std::size_t(count) < hardly_any_points && !known)
      candidate.held.push_back({name, std::max(2 * input.thin_spacing, input.sampling.sigma)});
  }
}

/// Outlines of few numbers, with the holes of which something was seen.
void add_common_outlines(const FitInput& input, const Section& s, double band, std::vector<Candidate>& candidates) {
  constexpr double dearer = 1.5;
  const OutlineData data = outline_data(input, s, band);
  const auto outlines = common_outlines(data);
  // Because the walls of its holes are explained already, a link costs less than any outline whose holes are still to
  // be found.
  const auto first = std::find_if(outlines.begin(), outlines.end(),
                                  [](const CommonOutline& o) { return o.form != OutlineForm::link; });
  for (const auto& o : outlines) {
    if (first != outlines.end() && o.cost > dearer * first->cost) break;
    std::vector<Vec2> inside;
    for (const Vec2& p : s.between)
      if (o.distance(p) < -2 * band) inside.push_back(p);
    const auto add = [&](const std::vector<PlaneCircle>& holes) {
      candidates.push_back(extrusion_of(with_holes(o.loop(), holes), input, s.sweep, s.frame));
      // a round determines the sides beside it
      const bool straight = o.form == OutlineForm::rectangle || o.form == OutlineForm::ell;
      if (straight && drawable(candidates.back())) hold_unseen(candidates.back(), input);
    };
    if (o.form == OutlineForm::link) {
      std::vector<PlaneCircle> eyes;
      for (const Vec2& c : o.end_centres()) eyes.push_back({c, o.eye});
      add(eyes);
      continue;
    }
    for (const bool by_walls : {false, true}) add(hardly_seen_holes(inside, data.ends, band, s.size, by_walls));
    const auto in_ends = holes_about(o.end_centres(), o.radius(), inside, data.ends, band);
    if (!in_ends.empty()) add(in_ends);
  }
}

bool starts_alike(const Candidate& a, const Candidate& b) {
  const auto same = [](const Parameter& p, const Parameter& q) { return p.name == q.name && p.value == q.value; };
  return a.procedure == b.procedure &&
         std::equal(a.parameters.begin(), a.parameters.end(), b.parameters.begin(), b.parameters.end(), same) &&
         a.scan_from_part.translation == b.scan_from_part.translation &&
         a.scan_from_part.rotation == b.scan_from_part.rotation;
}

/// Rims that change nothing give the same outline again.
std::vector<Candidate> each_once(std::vector<Candidate> all) {
  std::vector<Candidate> result;
  for (Candidate& c : all)
    if (std::none_of(result.begin(), result.end(), [&](const Candidate& r) { return starts_alike(r, c); }))
      result.push_back(std::move(c));
  return result;
}

}  // namespace

std::vector<Candidate> propose_extrudes(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        bool clear_only, Context& context) {
  std::vector<Candidate> candidates;
  if (input.cloud.normals.size() != input.cloud.size() || input.cloud.size() < 50) return candidates;
  std::vector<Section> sections;
  for (const Sweep& sweep : sweeps_of(input, start_directions)) {
    context.say("extrude: " + print_number(snapped(100 * sweep.share, 0.1)) +
                " % of the normals along or across one direction");
    Section section = section_of(input, sweep);
    if (section.walls.size() >= 30) sections.push_back(std::move(section));
  }
  // A real part's wall is no line but a band as wide as its dents: look at it with nodes that span the band too.
  const double wide = 1.5 * input.tolerance;
  for (const Section& s : sections) {
    add_outlines(input, s.sweep, s.frame, rings_of(s.walls, s.noise, s.fine), s.outline, candidates);
    if (wide > 1.6 * s.fine)
      add_outlines(input, s.sweep, s.frame, rings_of(s.walls, s.noise, wide), s.outline, candidates);
  }
  // A rod of no radius has no distances either.
  const auto makes_sense = [](const Candidate& c) {
    return std::holds_alternative<Extrude>(c.shape) ? drawable(c)
                                                    : !std::holds_alternative<Complaints>(check(bare_model(c)));
  };
  const auto near = [&](const Candidate& c) {
    return makes_sense(c) && evidence_of(c, input, context).local_max < 3 * input.tolerance;
  };
  const bool any_near = std::any_of(candidates.begin(), candidates.end(), near);
  if (clear_only || (any_near && input.outlier_share == 0)) return candidates;
  // Some walls were not seen, or outliers lie beside them.
  for (const Section& s : sections) {
    const double band = std::max(2.5 * s.noise, 0.3 * input.tolerance);
    add_outlines_by_cells(input, s, band, candidates);
    add_common_outlines(input, s, band, candidates);
    if (any_near) continue;
    for (const bool with_rims : {false, true})
      for (const double cell :
           {std::max(s.fine, 3 * input.thin_spacing), std::max({s.fine, wide, 5 * input.thin_spacing})})
        add_outlines(input, s.sweep, s.frame, rings_of_parts(s.walls, s.ends, with_rims, s.noise, cell, band, s.size),
                     s.outline, candidates);
  }
  return each_once(std::move(candidates));
}

}  // namespace partscribe::fit
