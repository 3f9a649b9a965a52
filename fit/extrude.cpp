#include "fit/extrude.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/sketch_builder.h"

namespace partscribe {
namespace {

constexpr double end_cosine = 0.98, side_sine = 0.2;

/// A direction along which the part is swept, and between which heights.
struct Sweep {
  Vec3 direction;
  double low = 0, high = 0, share = 0;
};

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
  Sweep sweep{a, 0, 0, 0};
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
  if (sweep.share < 0.85 || double(sides.size()) < 0.03 * n) return {};
  double low = quantile(sides, 0.002), high = quantile(sides, 0.998);
  const double middle = 0.5 * (low + high), reach = std::max(3 * input.tolerance, 0.03 * (high - low));
  std::vector<double> bottom, top;
  std::size_t stray = 0;
  for (const double h : ends) {
    if (h < middle && std::abs(h - low) < reach)
      bottom.push_back(h);
    else if (h > middle && std::abs(h - high) < reach)
      top.push_back(h);
    else
      ++stray;
  }
  if (double(stray) > 0.05 * n) return {};
  if (bottom.size() > 20) low = quantile(bottom, 0.5);
  if (top.size() > 20) high = quantile(top, 0.5);
  if (bottom.size() <= 20 && top.size() <= 20) return {};
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
  for (auto& c : s.curve.control) c = r * c;
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
  }
}

/// Closed chains, the outer one first and counter-clockwise, holes clockwise; none if a large piece stays open.
std::vector<Chain> rings_of(const std::vector<PlanePoint>& points, double noise, double cell) {
  ChainOptions options;
  options.noise = noise;
  options.cell = cell;
  auto chains = chains_of(points, options);
  auto weight_of = [](const Chain& chain) {
    double weight = 0;
    for (const auto& node : chain.nodes) weight += node.weight;
    return weight;
  };
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
        for (const auto& s : loop.segments) controls += s.curve.control.size();
        if (loop.segments.size() > 1 || (loop.segments.size() == 1 && loop.segments[0].arc))
          loops.push_back(std::move(loop));
      }
      const std::size_t key = pieces + 1000 * controls;
      if (loops.empty() || pieces > 120 || std::find(seen.begin(), seen.end(), key) != seen.end()) continue;
      seen.push_back(key);
      // x along the longest straight edge.
      double longest = 0, angle = 0;
      for (const auto& s : loops[0].segments)
        if (!s.arc && !s.spline && s.length() > longest)
          longest = s.length(), angle = std::atan2(s.direction.y(), s.direction.x());
      for (auto& loop : loops)
        for (auto& s : loop.segments) turn(s, -angle);
      SketchOptions sketch_options;
      sketch_options.tolerance = input.tolerance;
      BuiltSketch built = build_sketch(loops, sketch_options);
      // The part extends from its origin along +x rather than along -x.
      double left = 0, right = 0;
      for (const auto& s : loops[0].segments)
        for (const double x : {s.start.x(), s.end.x()})
          left = std::max(left, built.origin.x() - x), right = std::max(right, x - built.origin.x());
      if (left > right + input.tolerance) {
        for (auto& loop : loops)
          for (auto& s : loop.segments) turn(s, pi);
        angle += pi;
        built = build_sketch(loops, sketch_options);
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
      c.shape = Extrude{std::move(built.sketch), Expr::of("height")};
      c.scan_from_part.rotation = frame * rotation_of(Vec3(0, 0, angle));
      c.scan_from_part.translation = c.scan_from_part.rotation * Vec3(built.origin.x(), built.origin.y(), sweep.low);
      simplify(c);
      candidates.push_back(std::move(c));
    }
}

}  // namespace

std::vector<Candidate> propose_extrudes(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        Context& context) {
  std::vector<Candidate> candidates;
  if (input.cloud.normals.size() != input.cloud.size() || input.cloud.size() < 50) return candidates;
  for (const Sweep& sweep : sweeps_of(input, start_directions)) {
    context.say("extrude: " + print_number(snapped(100 * sweep.share, 0.1)) +
                " % of the normals along or across one direction");
    const Mat3 frame = rotation_onto_axis(sweep.direction);
    std::vector<PlanePoint> points;
    const double margin = 0.5 * input.tolerance;
    Vec2 low = Vec2::Constant(1e300), high = -low;
    for (std::size_t i = 0; i < input.cloud.size(); ++i) {
      const Vec3 q = frame.transpose() * input.cloud.points[i], n = frame.transpose() * input.cloud.normals[i];
      if (std::abs(n.z()) > side_sine || q.z() < sweep.low - margin || q.z() > sweep.high + margin) continue;
      points.push_back({q.head<2>(), n.head<2>().normalized()});
      low = low.cwiseMin(q.head<2>()), high = high.cwiseMax(q.head<2>());
    }
    if (points.size() < 30) continue;
    const double outline = 2 * (high - low).sum();
    const double noise = std::max(input.sampling.sigma, 1e-6 * outline);
    const double fine = std::max({outline / 700, 1.5 * noise, 6 * outline / double(points.size())});
    add_outlines(input, sweep, frame, rings_of(points, noise, fine), outline, candidates);
    // A real part's wall is no line but a band as wide as its dents: look at it with nodes that span the band too.
    if (1.5 * input.tolerance > 1.6 * fine)
      add_outlines(input, sweep, frame, rings_of(points, noise, 1.5 * input.tolerance), outline, candidates);
  }
  return candidates;
}

}  // namespace partscribe
