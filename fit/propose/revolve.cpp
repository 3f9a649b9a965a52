#include "fit/propose/revolve.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/evidence/evidence.h"
#include "fit/propose/sparse_step.h"
#include "fit/propose/turned_primitives.h"
#include "fit/search/equal_choices.h"
#include "fit/sketch/sketch_builder.h"
#include "geometry/least_squares.h"
#include "geometry/points/nearby_in_plane.h"

namespace partscribe::fit {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double on_axis = 0.02;  // of the half diagonal; nearer to the axis a normal gives no information

/// Of the normals, those that meet the axis as well as their noise lets them.
double share_of_normals(const FitInput& input, const Axis& axis) {
  const double least = on_axis * 0.5 * input.bounds.diagonal();
  std::vector<double> misses;
  double near = 0;
  for (std::size_t i = 0; i < input.cloud.size(); ++i) {
    if (input.surface_share.size() == input.cloud.size() && input.surface_share[i] < 0.8f)
      continue;  // perhaps an outlier
    const Vec3 across = axis.direction.cross(input.cloud.points[i] - axis.point);
    const double rho = across.norm();
    if (rho < least)
      near += 1;
    else
      misses.push_back(std::abs(input.cloud.normals[i].dot(across)) / rho);
  }
  if (misses.empty()) return 0;
  const double noise = 1.4826 * median(misses), window = std::clamp(3 * noise, 0.14, 0.35);
  const double good = near + double(std::count_if(misses.begin(), misses.end(), [&](double m) { return m < window; }));
  return good / (near + double(misses.size()));
}

Axis solved_axis(const FitInput& input, Axis axis, bool have_start) {
  const auto& cloud = input.cloud;
  const Vec3 c = input.bounds.center();
  const double size = 0.5 * input.bounds.diagonal();
  const double least = on_axis * size;
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
  axis.direction = nearest_sense(axis.direction);
  axis.share = share_of_normals(input, axis);
  return axis;
}

/// Radius (x) and height (y) about an axis, with the direction away from it.
struct Turned {
  Vec2 place = Vec2::Zero();
  Vec3 away = Vec3::Zero();
};

Turned turned(const Vec3& p, const Axis& axis) {
  const Vec3 d = p - axis.point;
  const double h = d.dot(axis.direction);
  const Vec3 radial = d - h * axis.direction;
  const double rho = radial.norm();
  return {{rho, h}, rho > 0 ? Vec3(radial / rho) : Vec3::Zero()};
}

using Vector4 = Eigen::Matrix<double, 4, 1>;

/// A point's residual from the profile near it, with its derivatives by two shifts and two tilts of the axis.
struct AxisRow {
  double along = 0, residual = 0, weight = 0;
  Vector4 by_axis = Vector4::Zero();
};

/// The same motions less what a shift, a tilt and a bend of the profile do as well.
void take_out_profile(std::vector<AxisRow>& rows) {
  Mat3 m = Mat3::Zero();
  Eigen::Matrix<double, 3, 5> r = Eigen::Matrix<double, 3, 5>::Zero();
  const auto basis = [](const AxisRow& row) { return Vec3(1, row.along, row.along * row.along); };
  Eigen::Matrix<double, 1, 5> both;
  for (const auto& row : rows) {
    const Vec3 b = basis(row);
    both << row.residual, row.by_axis.transpose();
    m += row.weight * b * b.transpose(), r += row.weight * b * both;
  }
  m.diagonal().array() += 1e-9 * m.trace();
  const Eigen::Matrix<double, 3, 5> fit = m.ldlt().solve(r);
  for (auto& row : rows) {
    both = basis(row).transpose() * fit;
    row.residual -= both[0], row.by_axis -= both.tail<4>().transpose();
  }
}

/// The axis about which the points near each place of the profile scatter least. The axis from noisy normals is off by
/// some hundredths of the size, which would split straight walls of the profile.
Axis settled_axis(const FitInput& input, Axis axis) {
  constexpr int rounds = 8, classes = 4;
  constexpr std::size_t least_points = 12;
  const auto& cloud = input.cloud;
  const double size = input.bounds.diagonal(), edge = std::max(size / 40, 6 * input.sampling.sigma);
  axis.point += axis.direction * axis.direction.dot(input.bounds.center() - axis.point);
  double scale = edge / 3;
  for (int round = 0; round < rounds; ++round) {
    const Vec3 e1 = axis.direction.unitOrthogonal(), e2 = axis.direction.cross(e1);
    struct Entry {
      std::array<std::int64_t, 3> cell;
      std::size_t index;
    };
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Turned t = turned(cloud.points[i], axis);
      const Vec2 n(cloud.normals[i].dot(t.away), cloud.normals[i].dot(axis.direction));
      if (n.norm() < 0.9) continue;
      const double angle = std::atan2(n.y(), n.x()) / pi * classes + 2 * classes + 0.5;
      entries.push_back({{std::llround(std::floor(t.place.x() / edge)), std::llround(std::floor(t.place.y() / edge)),
                          std::llround(std::floor(angle)) % classes},
                         i});
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.cell != b.cell ? a.cell < b.cell : a.index < b.index; });
    NormalSums<4> sums;
    std::vector<double> sizes;
    for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
      while (end < entries.size() && entries[end].cell == entries[begin].cell) ++end;
      if (end - begin < least_points) continue;
      std::vector<Turned> members;
      std::vector<double> xs, ys;
      Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
      for (std::size_t k = begin; k < end; ++k) {
        members.push_back(turned(cloud.points[entries[k].index], axis));
        const Vec3& n3 = cloud.normals[entries[k].index];
        const Vec2 n(n3.dot(members.back().away), n3.dot(axis.direction));
        normals += n * n.transpose();
        xs.push_back(members.back().place.x()), ys.push_back(members.back().place.y());
      }
      const double angle = 0.5 * std::atan2(2 * normals(0, 1), normals(0, 0) - normals(1, 1));
      const Vec2 n(std::cos(angle), std::sin(angle)), middle(median(xs), median(ys));
      std::vector<AxisRow> rows;
      for (const auto& t : members) {
        AxisRow row;
        row.along = (t.place - middle).dot(Vec2(-n.y(), n.x())) / edge;
        row.residual = n.dot(t.place - middle);
        row.weight = welsch_weight(row.residual, scale);
        const double tilt = n.y() * t.place.x() - n.x() * t.place.y();
        row.by_axis = Vector4(-n.x() * t.away.dot(e1), -n.x() * t.away.dot(e2), tilt * t.away.dot(e1) / size,
                              tilt * t.away.dot(e2) / size);
        rows.push_back(row);
      }
      take_out_profile(rows);
      for (const auto& row : rows) {
        sizes.push_back(std::abs(row.residual));
        sums.add(row.by_axis, -row.residual, welsch_weight(row.residual, scale));
      }
    }
    if (sizes.size() < 50) return axis;
    // What the data leave open stays as it was.
    const Vector4 step = sums.solution(1e-6 * sums.h.trace());
    if (!step.allFinite() || step.norm() > 0.1 * size) return axis;
    axis.point += step[0] * e1 + step[1] * e2;
    axis.direction = (axis.direction + (step[2] * e1 + step[3] * e2) / size).normalized();
    scale = std::max(3 * 1.4826 * median(sizes), input.sampling.sigma);
  }
  axis.share = share_of_normals(input, axis);
  return axis;
}

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

/// The chain's pieces in order with the solid on the left, closed at ends that were not scanned. Nearer to the axis
/// than `at_axis` mm a chain ends on it, and what runs along it is no wall.
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

/// The same without faces at its two ends, if these lie much nearer to each other than to the axis: there is a rim that
/// was hardly seen. Nothing if the profile has no two such ends.
std::optional<LoopPieces> closed_at_rim(const LoopPieces& loop) {
  constexpr double near = 0.5;
  if (!loop.axis_to_axis || loop.segments.size() < 5 || loop.segments.front().supported ||
      loop.segments.back().supported)
    return {};
  const Vec2 first = loop.segments.front().end, last = loop.segments.back().start;
  if ((first - last).norm() > near * std::min(first.x(), last.x())) return {};
  LoopPieces result = loop;
  result.segments.erase(result.segments.begin()), result.segments.pop_back();
  result.axis_to_axis = false;
  return result;
}

/// The same with another step on top of its last face (`sign` 1) or below its first one (-1): one whose wall was taken
/// for outliers, `places` of which are given as radii and heights. Nothing if there is none, or if the profile ends
/// there in no flat face.
std::optional<LoopPieces> with_step_aside(const LoopPieces& loop, const std::vector<Vec2>& places, double sign,
                                          double noise, std::size_t least) {
  if (!loop.axis_to_axis || loop.segments.size() < 3) return {};
  const bool up = sign > 0;
  const ProfileSegment& end = up ? loop.segments.back() : loop.segments.front();
  if (end.arc || end.spline || std::abs(end.direction.y()) > 0.1) return {};
  const Vec2 edge = up ? end.start : end.end;
  const auto found = step_beyond(places, edge.y(), sign, noise, least);
  if (!found) return {};
  const Vec2 foot(found->radius, edge.y()), top(found->radius, found->end);
  ProfileSegment shoulder = end, wall;
  shoulder.start = up ? edge : foot, shoulder.end = up ? foot : edge;
  shoulder.direction = Vec2::UnitX() * (shoulder.end.x() < shoulder.start.x() ? -1 : 1);
  wall.start = up ? foot : top, wall.end = up ? top : foot;
  wall.point = 0.5 * (foot + top), wall.direction = Vec2::UnitY();
  wall.points = double(found->points);
  LoopPieces result = loop;
  auto& pieces = result.segments;
  if (up)
    pieces.back() = shoulder, pieces.push_back(wall), pieces.push_back(flat_end(top, {0, top.y()}));
  else
    pieces.front() = shoulder, pieces.insert(pieces.begin(), {flat_end({0, top.y()}, top), wall});
  return result;
}

/// The same with a neck wherever a shoulder goes on, by more than `least` mm, towards the axis than the wall next to
/// it, which begins as far away: the neck between them was hardly seen. Nothing if there is none.
std::optional<LoopPieces> with_unseen_necks(const LoopPieces& loop, double least) {
  const auto runs_along = [](const ProfileSegment& s, int axis) {
    return s.supported && !s.arc && !s.spline && std::abs(s.direction[axis]) > 0.98;
  };
  LoopPieces result = loop;
  result.segments.clear();
  for (std::size_t i = 0; i < loop.segments.size(); ++i) {
    const ProfileSegment& s = loop.segments[i];
    if (i > 0) {
      const ProfileSegment& before = loop.segments[i - 1];
      const bool wall_next = runs_along(before, 0) && runs_along(s, 1),
                 wall_before = runs_along(before, 1) && runs_along(s, 0);
      const Vec2 shoulder = wall_next ? before.end : s.start, wall = wall_next ? s.start : before.end;
      if ((wall_next || wall_before) && wall.x() - shoulder.x() > least && std::abs(wall.y() - shoulder.y()) > least) {
        const Vec2 corner(shoulder.x(), wall.y());
        result.segments.push_back(flat_end(before.end, corner)), result.segments.push_back(flat_end(corner, s.start));
      }
    }
    result.segments.push_back(s);
  }
  if (result.segments.size() == loop.segments.size()) return {};
  return result;
}

/// Steps and corners that noise has rounded are made square again: a piece shorter than `blur` mm between two walls
/// becomes a shoulder; one between a wall and a flat face is left out, unless `corners_stay`. Nothing if there is none.
std::optional<LoopPieces> with_square_steps(const LoopPieces& loop, double blur, bool corners_stay) {
  const auto runs_along = [](const ProfileSegment& s, int axis) {
    return !s.arc && !s.spline && std::abs(s.direction[axis]) > 0.98;
  };
  LoopPieces result = loop;
  result.segments.clear();
  bool changed = false;
  for (std::size_t i = 0; i < loop.segments.size(); ++i) {
    ProfileSegment s = loop.segments[i];
    const bool slant = i > 0 && i + 1 < loop.segments.size() && !s.spline && s.length() < blur && !runs_along(s, 0) &&
                       !runs_along(s, 1);
    if (slant) {
      const auto &before = loop.segments[i - 1], &after = loop.segments[i + 1];
      const auto walls = [&](int axis) { return runs_along(before, axis) && runs_along(after, axis); };
      const auto corner = [&](int axis) {
        return !corners_stay && runs_along(before, axis) && runs_along(after, 1 - axis);
      };
      changed |= walls(0) || walls(1) || corner(0) || corner(1);
      if (corner(0) || corner(1)) continue;
      if (walls(0) || walls(1)) {
        const int axis = walls(1) ? 0 : 1;
        s.arc = false;
        s.point = 0.5 * (s.start + s.end);
        s.direction = Vec2::Unit(axis) * (s.end[axis] < s.start[axis] ? -1 : 1);
        s.start[1 - axis] = s.end[1 - axis] = s.point[1 - axis];
      }
    }
    result.segments.push_back(s);
  }
  if (!changed) return {};
  return result;
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

/// Radii and heights of the points that were set aside.
std::vector<Vec2> places_aside(const FitInput& input, const Axis& axis) {
  std::vector<Vec2> places;
  for (const Vec3& p : input.set_aside.points) places.push_back(turned(p, axis).place);
  return places;
}

/// Nodes of a profile, and what they blur.
struct ProfileNodes {
  double cell = 0;   ///< mm between them
  double noise = 0;  ///< mm, of one point
  double blur = 0;   ///< mm; pieces shorter than this may be made of noise
};

Candidate turned_candidate(const FitInput& input, const Axis& axis, const LoopPieces& loop) {
  SketchOptions options;
  options.tolerance = input.tolerance;
  options.revolve = true;
  BuiltSketch built = build_sketch({loop}, options);
  Candidate c;
  c.procedure = "surface of revolution";
  c.object_name = "turned_body";
  c.parameters = std::move(built.parameters);
  c.shape = Revolve{std::move(built.sketch)};
  c.scan_from_part.rotation = rotation_onto_axis(axis.direction);
  c.scan_from_part.translation = axis.point + axis.direction * built.origin.y();
  simplify(c);
  return c;
}

/// The share of the points that lie next to no node of the chain; `cell`: mm between its nodes.
double left_aside(const std::vector<PlanePoint>& points, const Chain& chain, double cell) {
  if (points.empty() || chain.nodes.empty()) return 0;
  const NearbyInPlane nodes(chain.nodes, &ChainNode::position);
  const auto aside = std::count_if(points.begin(), points.end(),
                                   [&](const PlanePoint& p) { return !nodes.within(p.position, 3 * cell); });
  return double(aside) / double(points.size());
}

/// Adds a candidate for every level of detail at which the profile splits differently. Returns the chain that was
/// split; empty if there is none.
Chain add_profiles(const FitInput& input, const Axis& axis, const std::vector<PlanePoint>& points, double outline,
                   const ProfileNodes& nodes, std::vector<Candidate>& candidates) {
  ChainOptions chain_options;
  chain_options.noise = nodes.noise;
  chain_options.cell = nodes.cell;
  // Near the axis a ring holds few points: the last nodes may be missing.
  chain_options.axis = std::max(4 * nodes.cell + input.tolerance, 3 * input.thin_spacing);
  // What goes on beyond a corner in the band of noise is no end of the profile.
  if (nodes.blur > 0) chain_options.least = 6;
  constexpr double at_noise = 2;  // cells
  const std::vector<Vec2> aside = places_aside(input, axis);
  // Where there are many outliers, any step explains some.
  const double count = double(input.cloud.size());
  const auto least_of_step = static_cast<std::size_t>(std::max(20.0, count / 200) + 0.05 * input.outlier_share * count);
  const auto chains = chains_of(points, chain_options);
  if (chains.empty() || fills_area(chains[0], nodes.cell)) return {};
  std::vector<std::array<std::size_t, 4>> seen;  // what was proposed already: pieces, arcs, walls, control points
  std::set<std::string> primitives;
  const auto propose = [&](const LoopPieces& loop) {
    if (loop.segments.size() > 60) return;
    std::array<std::size_t, 4> key = {loop.segments.size(), 0, 0, 0};
    for (const auto& s : loop.segments) {
      key[1] += nodes.blur > 0 && s.arc;
      key[2] += nodes.blur > 0 && !s.arc && !s.spline && s.direction.cwiseAbs().maxCoeff() > 0.98;
      key[3] += s.curve.points.size();
    }
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) return;
    seen.push_back(key);
    Candidate c = turned_candidate(input, axis, loop);
    const std::string kind(kind_of(c.shape));
    // A primitive has one best fit, wherever it starts.
    if (!std::holds_alternative<Revolve>(c.shape) && !primitives.insert(kind).second) return;
    candidates.push_back(std::move(c));
  };
  const auto propose_and_square = [&](const LoopPieces& loop) {
    propose(loop);
    for (const double sign : {1.0, -1.0})
      if (const auto step = with_step_aside(loop, aside, sign, nodes.noise, least_of_step)) propose(*step);
    if (const auto rim = closed_at_rim(loop)) propose(*rim);
    if (const auto necks = with_unseen_necks(loop, std::max(at_noise * nodes.cell, 2 * input.tolerance)))
      propose(*necks);
    if (nodes.blur == 0) return;
    for (const bool corners_stay : {false, true})
      if (const auto square = with_square_steps(loop, nodes.blur, corners_stay)) propose(*square);
  };
  for (const double share : {0.35, 0.15, 0.07, 0.03})
    for (const double spline : {0.0, 0.15 * input.tolerance}) {
      std::size_t pieces = 0;
      for (const bool arcs : {true, false}) {
        // Blurred corners look like arcs.
        if (!arcs && (spline > 0 || nodes.blur == 0)) continue;
        ProfileOptions options;
        options.floor = share * input.tolerance;
        options.spline = spline;
        options.size = outline / 2;
        if (!arcs) options.arc_cost = 1e9;
        const auto loop = loop_of(chains[0], options, nodes.cell, chain_options.axis, input.tolerance);
        if (!loop) continue;
        // Many lines in place of few arcs are round after all.
        if (arcs)
          pieces = loop->segments.size();
        else if (loop->segments.size() > pieces + 2)
          continue;
        propose_and_square(*loop);
        // Beyond what noise moves from the axis a piece along it may be the wall of a thin step, whose end was not
        // seen.
        const auto stepped = loop_of(chains[0], options, nodes.cell, at_noise * nodes.cell, input.tolerance);
        if (stepped && stepped->segments.size() != loop->segments.size()) propose_and_square(*stepped);
      }
    }
  return chains[0];
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
  constexpr double band_widths = 4, most_aside = 0.01, of_outliers = 0.04, sparse = 3;
  std::vector<Candidate> candidates;
  std::vector<Axis> axes = revolution_axes(input, start_directions);
  if (axes.size() > 2) axes.resize(2);
  for (Axis axis : axes) {
    if (axis.share > 0.5) axis = settled_axis(input, axis);
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
    const double bare = std::max(outline / 700, 6 * outline / double(std::max<std::size_t>(data.points.size(), 1)));
    const double fine = std::max(bare, 1.5 * noise);
    // Nodes narrower than the band that noise makes of a wall would lie side by side.
    const bool wide = band_widths * noise > bare;
    const double band = band_widths * noise, blur = wide ? 5 * band : 0;
    const auto points = wide ? sharpened(data.points, band) : data.points;
    const Chain chain = add_profiles(input, axis, points, outline, {fine, noise, blur}, candidates);
    // Of walls that were seen at a slant too few points may be left for every node to hold some.
    if (left_aside(data.points, chain, fine) > most_aside + of_outliers * input.outlier_share)
      add_profiles(input, axis, wide ? sharpened(data.points, sparse * band, 0) : data.points, outline,
                   {sparse * fine, noise, blur}, candidates);
    // A real part's wall is no line but a band as wide as its dents: look at it with nodes that span the band too.
    if (1.5 * input.tolerance > 1.6 * fine)
      add_profiles(input, axis, points, outline, {1.5 * input.tolerance, noise, blur}, candidates);
  }
  return candidates;
}

}  // namespace partscribe::fit
