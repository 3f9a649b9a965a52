#include "fit/revolve.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/sketch_builder.h"
#include "fit/turned_primitives.h"

namespace partscribe {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Axis solved_axis(const FitInput& input, Axis axis, bool have_start) {
  const auto& cloud = input.cloud;
  const Vec3 c = input.bounds.center();
  const double size = 0.5 * input.bounds.diagonal();
  const double least = 0.02 * size;
  double width = have_start ? 0.35 : 1e9;  // sine of the angle by which a normal may miss the axis
  for (int round = 0; round < 12; ++round) {
    Matrix6 m = Matrix6::Zero();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vec3 p = (cloud.points[i] - c) / size;
      const Vec3& n = cloud.normals[i];
      double w = 1;
      if (have_start || round > 0) {
        const Vec3 d = cloud.points[i] - axis.point;
        const Vec3 across = axis.direction.cross(d);
        const double rho = across.norm();
        if (rho < least) continue;
        const double miss = n.dot(across) / rho / width;
        w = std::exp(-miss * miss / 2) * (size * size) / (rho * rho);
      }
      Eigen::Matrix<double, 6, 1> l;
      l << p.cross(n), n;
      m.selfadjointView<Eigen::Lower>().rankUpdate(l, w);
    }
    m = Matrix6(m.selfadjointView<Eigen::Lower>());
    const Mat3 a = m.topLeftCorner<3, 3>(), b = m.topRightCorner<3, 3>();
    Mat3 d = m.bottomRightCorner<3, 3>();
    d.diagonal().array() += 1e-9 * double(cloud.size());
    const Mat3 d_inverse = d.inverse();
    if (have_start && round == 0) {
      // The direction is given; find the place that suits it.
      const Vec3 moment = -d_inverse * (b.transpose() * axis.direction);
      axis.point = c + size * axis.direction.cross(moment - axis.direction * axis.direction.dot(moment));
    } else {
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(Mat3(a - b * d_inverse * b.transpose()));
      const Vec3 direction = eigen.eigenvectors().col(0);
      Vec3 moment = -d_inverse * (b.transpose() * direction);
      moment -= direction * direction.dot(moment);
      axis.direction = direction;
      axis.point = c + size * direction.cross(moment);
    }
    width = std::max(0.6 * std::min(width, 1.0), 0.04);
  }
  Eigen::Index largest;
  axis.direction.cwiseAbs().maxCoeff(&largest);
  if (axis.direction[largest] < 0) axis.direction = -axis.direction;
  double good = 0, asked = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (input.surface_share.size() == cloud.size() && input.surface_share[i] < 0.8f) continue;  // perhaps a stray
    asked += 1;
    const Vec3 across = axis.direction.cross(cloud.points[i] - axis.point);
    const double rho = across.norm();
    good += rho < least || std::abs(cloud.normals[i].dot(across)) < 0.14 * rho;
  }
  axis.share = good / std::max(asked, 1.0);
  return axis;
}

/// The axis of the same direction that circles about it fit best: averages out what the normals' noise left.
struct PlaneData {
  std::vector<PlanePoint> points;
  double height_low = 1e300, height_high = -1e300, radius_high = 0;
};

PlaneData plane_data(const FitInput& input, const Axis& axis) {
  PlaneData data;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    const Vec3 d = input.cloud.points[i] - axis.point;
    const double h = d.dot(axis.direction);
    const Vec3 radial = d - h * axis.direction;
    const double rho = radial.norm();
    data.height_low = std::min(data.height_low, h), data.height_high = std::max(data.height_high, h);
    data.radius_high = std::max(data.radius_high, rho);
    const Vec3& n = input.cloud.normals[i];
    Vec2 normal(rho > 0 ? n.dot(radial) / rho : 0, n.dot(axis.direction));
    const double in_plane = normal.norm();
    if (in_plane < 0.9 && rho > 0.02 * input.bounds.diagonal()) continue;
    normal = in_plane > 1e-6 ? Vec2(normal / in_plane) : Vec2(0, 1);
    data.points.push_back({{rho, h}, normal});
  }
  return data;
}

void reverse(Chain& chain) { std::reverse(chain.nodes.begin(), chain.nodes.end()); }

double polygon_area(const std::vector<Vec2>& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 &a = p[i], &b = p[(i + 1) % p.size()];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum / 2;
}

ProfileSegment flat_end(const Vec2& from, const Vec2& to) {
  ProfileSegment s;
  s.start = from, s.end = to, s.point = from;
  s.direction = (to - from).normalized();
  s.supported = false;
  return s;
}

/// The chain's pieces in order with the solid on the left, closed at ends that were not scanned.
std::optional<LoopPieces> loop_of(Chain chain, const ProfileOptions& o, double cell, double at_axis, double tolerance) {
  std::vector<Vec2> polygon;
  const Vec2 first = chain.nodes.front().position, last = chain.nodes.back().position;
  for (const auto& node : chain.nodes) polygon.push_back(node.position);
  if (!chain.closed) {
    polygon.emplace_back(0, last.y());
    polygon.emplace_back(0, first.y());
  }
  if (polygon_area(polygon) < 0) reverse(chain);
  LoopPieces loop;
  loop.name = "profile";
  loop.segments = segments_of(chain, o);
  if (loop.segments.empty()) return {};
  loop.axis_to_axis = !chain.closed;
  if (chain.closed) return loop;
  const bool starts = chain.nodes.front().position.x() < at_axis, ends = chain.nodes.back().position.x() < at_axis;
  // Two ends on the same bore wall: the bore goes through, its middle was not seen.
  const auto& a = loop.segments.back();
  const auto& b = loop.segments.front();
  if (!starts && !ends && loop.segments.size() > 2 && !a.arc && !b.arc && !a.spline && !b.spline &&
      std::abs(a.direction.x()) < 0.1 && std::abs(b.direction.x()) < 0.1 && a.direction.y() < 0 &&
      b.direction.y() < 0 && std::abs(a.point.x() - b.point.x()) < 2 * tolerance + cell) {
    ProfileSegment joined = a;
    joined.end = b.end;
    joined.point = 0.5 * (a.point + b.point);
    joined.direction = (b.end - a.start).normalized();
    joined.points += b.points;
    loop.segments.back() = joined;
    loop.segments.erase(loop.segments.begin());
    loop.axis_to_axis = false;
    return loop;
  }
  // A first or last piece along the axis is no surface.
  auto along_axis = [&](const ProfileSegment& s) {
    return !s.arc && !s.spline && std::max(s.start.x(), s.end.x()) < at_axis && std::abs(s.direction.x()) < 0.5;
  };
  while (loop.segments.size() > 2 && along_axis(loop.segments.front())) loop.segments.erase(loop.segments.begin());
  while (loop.segments.size() > 2 && along_axis(loop.segments.back())) loop.segments.pop_back();
  const Vec2 s = loop.segments.front().start, e = loop.segments.back().end;
  // A flat face that stops short of the axis goes on to it; any other end gets a face of its own.
  auto flat = [](const ProfileSegment& face) {
    return !face.arc && !face.spline && std::abs(face.direction.y()) < 0.1;
  };
  if (!starts && !flat(loop.segments.front())) loop.segments.insert(loop.segments.begin(), flat_end({0, s.y()}, s));
  if (!ends && !flat(loop.segments.back())) loop.segments.push_back(flat_end(e, {0, e.y()}));
  return loop;
}

/// Cylinder, cone, sphere or torus, if that is what the sketch is.
void simplify(Candidate& candidate) {
  const auto* revolve = std::get_if<Revolve>(&candidate.shape);
  if (!revolve || revolve->sketch.loops.size() != 1) return;
  const auto elements = revolve->sketch.loops[0].elements;
  auto keep_only = [&](const std::vector<std::pair<std::string, std::string>>& renames) {
    std::vector<Parameter> kept;
    for (const auto& [from, to] : renames)
      for (auto p : candidate.parameters)
        if (p.name == from) {
          p.name = to;
          kept.push_back(p);
        }
    candidate.parameters = std::move(kept);
  };
  if (elements.size() == 1) {
    const auto* arc = std::get_if<SketchArc>(&elements[0]);
    if (!arc) return;
    const bool full = arc->from.is_number() && arc->to.is_number() && std::abs(arc->to.number - arc->from.number) > 6;
    if (full && arc->center_x.is_parameter() && arc->radius.is_parameter()) {
      const std::string ring = arc->center_x.parameter, tube = arc->radius.parameter;
      keep_only({{ring, "major_radius"}, {tube, "minor_radius"}});
      for (auto& p : candidate.parameters)
        p.note = p.name == "major_radius" ? "radius of the ring's centre circle" : "radius of the tube";
      candidate.shape = Torus{Expr::of("major_radius"), Expr::of("minor_radius")};
      candidate.procedure = candidate.object_name = "torus";
    } else if (!full && arc->center_x == Expr(0) && arc->center_y == Expr(0) && arc->radius.is_parameter()) {
      keep_only({{arc->radius.parameter, "radius"}});
      for (auto& p : candidate.parameters) p.note = "radius of the sphere";
      candidate.shape = Sphere{Expr::of("radius")};
      candidate.procedure = "sphere", candidate.object_name = "ball";
    }
    return;
  }
  std::vector<SketchPoint> p;
  for (const auto& e : elements) {
    const auto* point = std::get_if<SketchPoint>(&e);
    if (!point) return;
    p.push_back(*point);
  }
  auto parameter = [](const Expr& e) { return e.is_parameter(); };
  if (p.size() == 4 && p[0].x == Expr(0) && p[3].x == Expr(0) && p[0].y == Expr(0) && p[1].y == Expr(0) &&
      p[2].y == p[3].y && parameter(p[1].x) && parameter(p[2].x) && parameter(p[2].y)) {
    if (p[1].x == p[2].x) {
      keep_only({{p[1].x.parameter, "radius"}, {p[2].y.parameter, "height"}});
      candidate.shape = Cylinder{Expr::of("radius"), Expr::of("height")};
      candidate.procedure = "cylinder", candidate.object_name = "rod";
      candidate.parameters[0].note = "radius of the cylinder", candidate.parameters[1].note = "height of the cylinder";
    } else {
      keep_only({{p[1].x.parameter, "bottom_radius"}, {p[2].x.parameter, "top_radius"}, {p[2].y.parameter, "height"}});
      candidate.shape = Cone{Expr::of("bottom_radius"), Expr::of("top_radius"), Expr::of("height")};
      candidate.procedure = "frustum of a cone", candidate.object_name = "frustum";
      candidate.parameters[0].note = "radius at the bottom", candidate.parameters[1].note = "radius at the top",
      candidate.parameters[2].note = "height";
    }
  } else if (p.size() == 3 && p[0].x == Expr(0) && p[2].x == Expr(0) && p[0].y == Expr(0) && p[1].y == Expr(0) &&
             parameter(p[1].x) && parameter(p[2].y)) {
    keep_only({{p[1].x.parameter, "bottom_radius"}, {p[2].y.parameter, "height"}});
    candidate.shape = Cone{Expr::of("bottom_radius"), Expr(0), Expr::of("height")};
    candidate.procedure = "cone", candidate.object_name = "cone";
    candidate.parameters[0].note = "radius of the base",
    candidate.parameters[1].note = "height of the tip above the base";
  }
}

/// Adds a candidate for every level of detail at which the profile, in nodes of `cell` mm, splits differently.
void add_profiles(const FitInput& input, const Axis& axis, const PlaneData& data, double outline, double noise,
                  double cell, std::vector<Candidate>& candidates) {
  ChainOptions chain_options;
  chain_options.noise = noise;
  chain_options.cell = cell;
  // Near the axis a ring holds few points: the last nodes may be missing.
  chain_options.axis = std::max(4 * cell + input.tolerance, 3 * input.thin_spacing);
  const auto chains = chains_of(data.points, chain_options);
  if (chains.empty()) return;
  std::vector<std::size_t> seen;  // what was proposed already: pieces and control points
  for (const double share : {0.35, 0.15, 0.07, 0.03})
    for (const double spline : {0.0, 0.15 * input.tolerance}) {
      ProfileOptions profile_options;
      profile_options.floor = share * input.tolerance;
      profile_options.spline = spline;
      profile_options.size = outline / 2;
      auto loop = loop_of(chains[0], profile_options, cell, chain_options.axis, input.tolerance);
      if (!loop || loop->segments.size() > 60) continue;
      std::size_t key = loop->segments.size();
      for (const auto& piece : loop->segments) key += 1000 * piece.curve.control.size();
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) continue;
      seen.push_back(key);
      SketchOptions sketch_options;
      sketch_options.tolerance = input.tolerance;
      sketch_options.revolve = true;
      BuiltSketch built = build_sketch({*loop}, sketch_options);
      Candidate c;
      c.procedure = "surface of revolution";
      c.object_name = "turned_body";
      c.parameters = std::move(built.parameters);
      c.shape = Revolve{std::move(built.sketch)};
      c.scan_from_part.rotation = rotation_onto_axis(axis.direction);
      c.scan_from_part.translation = axis.point + axis.direction * built.origin.y();
      simplify(c);
      candidates.push_back(std::move(c));
    }
}

}  // namespace

std::vector<Axis> revolution_axes(const FitInput& input, const std::vector<Vec3>& start_directions) {
  std::vector<Axis> axes;
  if (input.cloud.size() < 20 || input.cloud.normals.size() != input.cloud.size()) return axes;
  auto consider = [&](const Axis& axis) {
    if (!axis.direction.allFinite() || !axis.point.allFinite()) return;
    for (auto& known : axes) {
      const Vec3 d = axis.point - known.point;
      const double apart = (d - known.direction * d.dot(known.direction)).norm();
      if (std::abs(axis.direction.dot(known.direction)) > 0.9995 && apart < 0.02 * input.bounds.diagonal()) {
        if (axis.share > known.share) known = axis;
        return;
      }
    }
    axes.push_back(axis);
  };
  consider(solved_axis(input, {}, false));
  for (const auto& direction : start_directions) {
    Axis start;
    start.direction = direction.normalized();
    consider(solved_axis(input, start, true));
  }
  std::stable_sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.share > b.share; });
  return axes;
}

std::vector<Candidate> propose_revolves(const FitInput& input, const std::vector<Vec3>& start_directions,
                                        Context& context) {
  std::vector<Candidate> candidates;
  std::vector<Axis> axes = revolution_axes(input, start_directions);
  if (axes.size() > 2) axes.resize(2);
  for (Axis axis : axes) {
    context.say("revolve: axis shared by " + print_number(snapped(100 * axis.share, 0.1)) + " % of the normals");
    if (axis.share < 0.8) continue;
    for (auto& primitive : propose_turned_primitives(input, axis)) candidates.push_back(std::move(primitive));
    // The larger flat end is the bottom.
    {
      double up = 0, down = 0;
      const PlaneData data = plane_data(input, axis);
      const double middle = 0.5 * (data.height_low + data.height_high);
      for (const auto& p : data.points)
        if (std::abs(p.normal.y()) > 0.97) (p.position.y() > middle ? up : down) += 1;
      if (up > 1.05 * down) axis.direction = -axis.direction;
    }
    const PlaneData data = plane_data(input, axis);
    const double outline = 2 * (data.radius_high + data.height_high - data.height_low);
    const double noise = std::max(input.sampling.sigma, 1e-6 * outline);
    const double fine =
        std::max({outline / 700, 1.5 * noise, 6 * outline / double(std::max<std::size_t>(data.points.size(), 1))});
    add_profiles(input, axis, data, outline, noise, fine, candidates);
    // A real part's wall is no line but a band as wide as its dents: look at it with nodes that span the band too.
    if (1.5 * input.tolerance > 1.6 * fine)
      add_profiles(input, axis, data, outline, noise, 1.5 * input.tolerance, candidates);
  }
  return candidates;
}

}  // namespace partscribe
