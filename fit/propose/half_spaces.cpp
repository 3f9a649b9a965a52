/// Convex bodies with plane faces: found by their normals, closed where the data end, named as simply as possible.
#include "fit/propose/half_spaces.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "core/number.h"
#include "core/statistics.h"
#include "fit/propose/convex_body.h"
#include "fit/propose/wedges.h"
#include "fit/search/equal_choices.h"
#include "fit/sketch/length_parameter.h"

namespace partscribe::fit {

namespace {

constexpr double square_angle = 3 * pi / 180;  // faces this near to a right angle may be meant as one

/// The rotation whose columns are nearest to the measured directions, each with its weight.
Mat3 frame_from(const std::vector<std::pair<int, Vec3>>& directions, const std::vector<double>& weights) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < directions.size(); ++i)
    sum += weights[i] * directions[i].second * Vec3::Unit(directions[i].first).transpose();
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 fix = Mat3::Identity();
  fix(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * fix * svd.matrixV().transpose();
}

double face_weight(const ConvexFace& f) { return static_cast<double>(f.points) + 1; }

/// Median position along `axis` of the points on a face; for a face that was not scanned, where its plane was put.
double level_along(const Vec3& axis, const ConvexFace& face, const std::vector<ConvexFace>& faces,
                   const FitInput& input, double reach) {
  std::vector<double> v;
  if (face.points > 0)
    for (const Vec3& p : input.cloud.points) {
      std::size_t f = 0;
      if (std::abs(convex_distance(faces, p, &f)) < 2 * reach && &faces[f] == &face) v.push_back(axis.dot(p));
    }
  if (!v.empty()) return median(std::move(v));
  return face.offset * (face.normal.dot(axis) < 0 ? -1 : 1);
}

std::string closing_note(const ConvexFace& a, const ConvexFace& b) {
  return a.points > 0 && b.points > 0 ? "" : "; one of its two faces was not scanned, the data end there";
}

/// Three pairs of parallel faces at right angles.
std::optional<Candidate> box_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  if (faces.size() != 6) return std::nullopt;
  const double parallel = std::cos(square_angle), square = std::sin(square_angle);
  std::array<std::pair<std::size_t, std::size_t>, 3> pairs;
  std::vector<bool> used(6, false);
  for (int k = 0; k < 3; ++k) {
    std::size_t a = 0;
    while (used[a]) ++a;
    used[a] = true;
    std::size_t b = 6;
    for (std::size_t j = 0; j < 6; ++j)
      if (!used[j] && faces[j].normal.dot(faces[a].normal) < -parallel) b = j;
    if (b == 6) return std::nullopt;
    used[b] = true;
    pairs[static_cast<std::size_t>(k)] = {a, b};
  }
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < k; ++l)
      for (std::size_t i : {pairs[static_cast<std::size_t>(k)].first, pairs[static_cast<std::size_t>(k)].second})
        for (std::size_t j : {pairs[static_cast<std::size_t>(l)].first, pairs[static_cast<std::size_t>(l)].second})
          if (std::abs(faces[i].normal.dot(faces[j].normal)) > square) return std::nullopt;

  // Longest side along x, next along y; of equal sides the one nearest to the scan's axis. x and z keep to the scan's.
  std::array<double, 3> size;
  for (std::size_t k = 0; k < 3; ++k) size[k] = faces[pairs[k].first].offset + faces[pairs[k].second].offset;
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  const auto way = [&](std::size_t k) { return Vec3(faces[pairs[k].first].normal.cwiseAbs()); };
  const auto equal = [&](std::size_t k, std::size_t l) { return size[order[k]] - size[order[l]] < input.tolerance; };
  // The shortest first: the vertical direction matters most.
  const std::size_t last = equal(0, 2)   ? nearest_to_scan({way(order[2]), way(order[1]), way(order[0])})
                           : equal(1, 2) ? nearest_to_scan({way(order[2]), way(order[1])})
                                         : 0;
  std::rotate(order.end() - 1 - std::ptrdiff_t(last), order.end() - std::ptrdiff_t(last), order.end());
  if (equal(0, 1) && nearest_to_scan({way(order[0]), way(order[1])}, {0, 1, 2}) == 1) std::swap(order[0], order[1]);
  std::array<std::pair<std::size_t, std::size_t>, 3> axis;  // (far face, near face)
  for (std::size_t k = 0; k < 3; ++k) {
    axis[k] = pairs[order[k]];
    const Vec3& normal = faces[axis[k].first].normal;
    const std::array<int, 3> preferred = k == 0 ? std::array<int, 3>{0, 1, 2} : std::array<int, 3>{2, 0, 1};
    if (nearest_sense(normal, preferred) != normal) std::swap(axis[k].first, axis[k].second);
  }
  if (faces[axis[0].first].normal.cross(faces[axis[1].first].normal).dot(faces[axis[2].first].normal) < 0)
    std::swap(axis[1].first, axis[1].second);  // z keeps its way up
  std::vector<std::pair<int, Vec3>> directions;
  std::vector<double> weights;
  for (int k = 0; k < 3; ++k) {
    const auto& [far, near] = axis[static_cast<std::size_t>(k)];
    directions.emplace_back(k, faces[far].normal), weights.push_back(face_weight(faces[far]));
    directions.emplace_back(k, -faces[near].normal), weights.push_back(face_weight(faces[near]));
  }
  const Mat3 frame = frame_from(directions, weights);
  const double reach = reach_of(input);
  Vec3 corner, far_corner;
  std::array<std::string, 3> notes;
  for (int k = 0; k < 3; ++k) {
    const auto& [far, near] = axis[static_cast<std::size_t>(k)];
    corner[k] = level_along(frame.col(k), faces[near], faces, input, reach);
    far_corner[k] = level_along(frame.col(k), faces[far], faces, input, reach);
    notes[static_cast<std::size_t>(k)] = closing_note(faces[far], faces[near]);
  }
  const Vec3 extent = far_corner - corner;
  if (!(extent.minCoeff() > 0)) return std::nullopt;
  Candidate c;
  c.procedure = "box", c.object_name = "block";
  c.shape = Box{Expr::of("length"), Expr::of("width"), Expr::of("height")};
  c.parameters = {length_parameter("length", extent.x(), "longest side of the block" + notes[0]),
                  length_parameter("width", extent.y(), "second side of the block" + notes[1]),
                  length_parameter("height", extent.z(), "shortest side of the block" + notes[2])};
  c.scan_from_part = {frame, frame * corner};
  return c;
}

/// A block from the two largest faces that are perpendicular to each other, without regard to the others: a face of few
/// points may be a curtain or be tilted. Sides that were not scanned are put where the data end.
std::optional<Candidate> block_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  constexpr double nearly = 0.12;  // of a right angle, 7 degrees
  if (faces.size() < 2) return std::nullopt;
  std::size_t second = 1;
  while (second < faces.size() && std::abs(faces[second].normal.dot(faces[0].normal)) > nearly) ++second;
  if (second == faces.size()) return std::nullopt;
  const Mat3 frame =
      frame_from({{0, faces[0].normal}, {1, faces[second].normal}, {2, faces[0].normal.cross(faces[second].normal)}},
                 {face_weight(faces[0]), face_weight(faces[second]), 1});
  std::vector<ConvexFace> sides;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0})
      for (const ConvexFace& f : faces)
        if (sign * frame.col(k).dot(f.normal) > 1 - nearly * nearly / 2) {
          sides.push_back(f);
          break;
        }
  // If there is a further face with more points than outliers explain, the body is not a block.
  const auto points = [](const std::vector<ConvexFace>& list) {
    double sum = 0;
    for (const ConvexFace& f : list) sum += double(f.points);
    return sum;
  };
  if (points(sides) < (1 - input.outlier_share) * points(faces)) return std::nullopt;
  const double reach = reach_of(input);
  const std::vector<Vec3> on = points_on(sides, input, reach);
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) {
      const Vec3 n = sign * frame.col(k);
      const auto same = [&](const ConvexFace& f) { return f.normal.dot(n) > 1 - nearly * nearly / 2; };
      if (std::none_of(sides.begin(), sides.end(), same)) sides.push_back(closing_face(on, n));
    }
  for (ConvexFace& f : sides) {
    // Square, about the middle of its points.
    Vec3 n = f.normal;
    int axis = 0;
    (frame.transpose() * f.normal).cwiseAbs().maxCoeff(&axis);
    n = (frame.col(axis).dot(f.normal) < 0 ? -1 : 1) * frame.col(axis);
    std::vector<double> levels;
    if (f.points > 0)
      for (const Vec3& p : on)
        if (std::abs(f.normal.dot(p) - f.offset) < reach) levels.push_back(n.dot(p));
    f = {n, levels.empty() ? f.offset : median(std::move(levels)), f.points};
  }
  return box_of(sides, input);
}

/// A prism between two parallel faces whose section is a triangle or trapezoid with a right angle.
std::optional<Candidate> wedge_of(const std::vector<ConvexFace>& faces, const FitInput& input) {
  if (faces.size() != 5 && faces.size() != 6) return std::nullopt;
  const double parallel = std::cos(square_angle), square = std::sin(square_angle), reach = reach_of(input);
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  for (std::size_t a = 0; a < faces.size(); ++a)
    for (std::size_t b = a + 1; b < faces.size(); ++b) {
      if (faces[a].normal.dot(faces[b].normal) > -parallel) continue;
      const Vec3 z = (faces[a].normal - faces[b].normal).normalized();
      std::vector<std::size_t> sides;
      bool prism = true;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        if (i == a || i == b) continue;
        sides.push_back(i);
        prism = prism && std::abs(faces[i].normal.dot(z)) < square;
      }
      if (!prism) continue;
      // y = 0 and x = 0 at right angles; with four sides the third is parallel to y = 0, shorter, and the last slopes.
      for (std::size_t y0 : sides)
        for (std::size_t x0 : sides) {
          if (x0 == y0 || std::abs(faces[x0].normal.dot(faces[y0].normal)) > square) continue;
          std::vector<std::size_t> rest;
          for (std::size_t i : sides)
            if (i != x0 && i != y0) rest.push_back(i);
          std::size_t slope = rest[0], top = faces.size();
          if (rest.size() == 2) {
            top = faces[rest[0]].normal.dot(faces[y0].normal) < -parallel ? rest[0] : rest[1];
            if (faces[top].normal.dot(faces[y0].normal) > -parallel) continue;
            slope = top == rest[0] ? rest[1] : rest[0];
          }
          const Vec3& ns = faces[slope].normal;
          if (ns.dot(faces[x0].normal) > -std::sin(square_angle) || -ns.dot(faces[y0].normal) < square) continue;
          // Of the two ways to read a triangle take the one with the longer foot.
          if (top == faces.size() && face_area(*body, y0) < face_area(*body, x0) - 1e-9) continue;

          std::vector<std::pair<int, Vec3>> directions = {{0, -faces[x0].normal}, {1, -faces[y0].normal}};
          std::vector<double> weights = {face_weight(faces[x0]), face_weight(faces[y0])};
          if (top < faces.size())
            directions.emplace_back(1, faces[top].normal), weights.push_back(face_weight(faces[top]));
          const Vec3 up = directions[0].second.cross(directions[1].second).dot(z) > 0 ? z : Vec3(-z);
          directions.emplace_back(2, up), weights.push_back(face_weight(faces[a]) + face_weight(faces[b]));
          const Mat3 frame = frame_from(directions, weights);
          const std::size_t low = faces[a].normal.dot(up) < 0 ? a : b, high = low == a ? b : a;
          const Vec3 corner(level_along(frame.col(0), faces[x0], faces, input, reach),
                            level_along(frame.col(1), faces[y0], faces, input, reach),
                            level_along(frame.col(2), faces[low], faces, input, reach));
          const double size_z = level_along(frame.col(2), faces[high], faces, input, reach) - corner.z();
          // The slope's line in the section: nx x + ny y = c from the corner.
          const double nx = frame.col(0).dot(ns), ny = frame.col(1).dot(ns);
          const double c0 = faces[slope].offset - ns.dot(frame * corner);
          const double size_x = c0 / nx;
          double size_y = c0 / ny, top_x = 0;
          if (top < faces.size()) {
            size_y = level_along(frame.col(1), faces[top], faces, input, reach) - corner.y();
            top_x = (c0 - ny * size_y) / nx;
          }
          if (!(size_x > 0 && size_y > 0 && size_z > 0 && top_x >= 0)) continue;
          Candidate c;
          c.procedure = "wedge", c.object_name = "wedge_block";
          Wedge wedge{Expr::of("foot_length"), Expr::of("height"), Expr::of("width"), 0};
          c.parameters = {length_parameter("foot_length", size_x, "length of the foot, along x at y = 0"),
                          length_parameter("height", size_y, "height above the foot, along y"),
                          length_parameter("width", size_z, "width between the two parallel cheeks, along z")};
          if (top < faces.size()) {
            wedge.top_x = Expr::of("top_length");
            c.parameters.push_back(length_parameter("top_length", top_x, "length left at the full height"));
          }
          c.shape = wedge;
          c.scan_from_part = {frame, frame * corner};
          return c;
        }
    }
  return std::nullopt;
}

/// Any convex body: its largest face on top, standing on its lowest place, x along the longest edge of the top.
std::optional<Candidate> half_spaces_of(const std::vector<ConvexFace>& faces) {
  const auto body = convex_polyhedron(planes_only(faces));
  if (!body) return std::nullopt;
  constexpr double as_large = 0.03;  // share; of faces and edges
  std::vector<std::size_t> order, left;
  std::vector<double> area;
  for (std::size_t i = 0; i < faces.size(); ++i) left.push_back(i), area.push_back(face_area(*body, i));
  while (!left.empty()) {
    double largest = 0;
    for (const std::size_t i : left) largest = std::max(largest, area[i]);
    std::vector<std::size_t> equals;
    std::vector<Vec3> normals;
    for (const std::size_t i : left)
      if (area[i] >= (1 - as_large) * largest) equals.push_back(i), normals.push_back(faces[i].normal);
    order.push_back(equals[nearest_to_scan(normals)]);
    std::erase(left, order.back());
  }
  const auto& top = body->faces[order[0]];
  const Vec3 z = faces[order[0]].normal;
  std::vector<Vec3> edges;
  double longest = 0;
  for (std::size_t k = 0; k < top.size(); ++k) {
    edges.push_back(body->vertices[top[(k + 1) % top.size()]] - body->vertices[top[k]]);
    longest = std::max(longest, edges.back().norm());
  }
  std::erase_if(edges, [&](const Vec3& e) { return e.norm() < (1 - as_large) * longest; });
  std::vector<Vec3> ways;
  for (const Vec3& e : edges)
    for (const double sign : {1.0, -1.0}) ways.push_back(sign * (e - z * z.dot(e)).normalized());
  const Vec3 x = ways[nearest_to_scan(ways, {0, 1, 2})];
  Mat3 frame;
  frame << x, z.cross(x), z;
  Vec3 middle = Vec3::Zero();
  double lowest = 1e300;
  for (const Vec3& v : body->vertices)
    middle += v / static_cast<double>(body->vertices.size()), lowest = std::min(lowest, z.dot(v));
  const Vec3 origin = middle + z * (lowest - z.dot(middle));

  Candidate c;
  c.procedure = "convex polyhedron", c.object_name = "polyhedron";
  HalfSpaces shape;
  int number = 0;
  for (std::size_t i : order) {
    const std::string name = "face_" + std::to_string(++number);
    const Vec3 n = frame.transpose() * faces[i].normal;
    HalfSpace half{n.x(), n.y(), n.z(), Expr::of(name + "_offset"), "face " + std::to_string(number)};
    shape.planes.push_back(half);
    Parameter p = length_parameter(name + "_offset", faces[i].offset - faces[i].normal.dot(origin),
                                   "distance of face " + std::to_string(number) + " from the origin along its normal");
    if (faces[i].points == 0) p.note += "; not scanned, the data end there";
    c.parameters.push_back(p);
  }
  c.shape = shape;
  c.scan_from_part = {frame, origin};
  c.extra_numbers = 2 * number;  // a direction is two numbers
  return c;
}

}  // namespace

std::vector<Candidate> propose_polyhedra(const FitInput& input, Context& context) {
  std::vector<ConvexFace> scanned = scanned_faces(input, context);
  std::vector<ConvexFace> faces = closed_body(scanned, input, context);
  auto box = box_of(faces, input);
  // A face that few points show was none to begin with; sides that nobody saw then cut across it. Outliers make such
  // faces too.
  if (!box && !faces.empty() && !among_outliers(input))
    if (auto more = with_a_face_more(scanned, faces, input, context); !more.empty())
      if (auto closed = closed_body(more, input, context); !closed.empty())
        scanned = std::move(more), faces = std::move(closed);
  std::vector<Candidate> result;
  if (!box) box = box_of(faces, input);
  if (box) {
    result.push_back(*box);
  } else {
    const bool outliers = input.outlier_share > 0;
    if (auto block = outliers ? block_of(scanned, input) : std::nullopt) result.push_back(*block);
    if (auto wedge = wedge_of(faces, input)) result.push_back(*wedge);
  }
  if (faces.size() >= 4)
    if (auto any = half_spaces_of(faces)) result.push_back(*any);
  // A side that was not scanned may lean as well, and of several the data's ends may name others than a wedge has.
  std::vector<ConvexFace> ends;
  std::ranges::copy_if(faces, std::back_inserter(ends), [](const ConvexFace& f) { return f.points == 0; });
  if (among_outliers(input) || !ends.empty())
    for (Candidate& wedge : propose_wedges(scanned, ends, input, context)) result.push_back(std::move(wedge));
  return result;
}

}  // namespace partscribe::fit
