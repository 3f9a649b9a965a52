#include "cli/measure/measured_part.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/disjoint_sets.h"
#include "geometry/mesh/mesh_facets.h"

namespace partscribe::cli {
namespace {

/// Places of the members of a face: corners of its triangles, or its points.
std::vector<Vec3> places_of(const Scan& scan, const Faces& faces, const Face& face) {
  std::vector<Vec3> places;
  for (const auto m : face.members)
    if (faces.of_mesh)
      for (int k = 0; k < 3; ++k) places.push_back(scan.mesh.corner(m, k));
    else
      places.push_back(scan.cloud.points[m]);
  return places;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Counter-clockwise [Andrew 1979].
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  const auto before = [](const Vec2& a, const Vec2& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const auto& p : points) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// The smallest rectangle around points has a side along an edge of their hull.
Vec2 smallest_rectangle(const std::vector<Vec2>& points) {
  const auto hull = convex_hull(points);
  Vec2 best = Vec2::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 edge = hull[(i + 1) % hull.size()] - hull[i];
    if (!(edge.norm() > 0)) continue;
    const Vec2 along = edge.normalized(), across(-along.y(), along.x());
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const auto& p : hull) {
      const Vec2 q(along.dot(p), across.dot(p));
      low = low.cwiseMin(q), high = high.cwiseMax(q);
    }
    const Vec2 size = high - low;
    if (size.prod() >= least) continue;
    least = size.prod();
    best = {size.maxCoeff(), size.minCoeff()};
  }
  return best;
}

/// A part of the surface: a triangle, or what one point stands for.
struct Piece {
  Vec3 middle = Vec3::Zero();
  double area = 0;
};

/// Triangles joined by their edges.
std::vector<std::vector<Piece>> left_triangles(const TriangleMesh& mesh, const Faces& faces) {
  DisjointSets groups(mesh.triangles.size());
  const auto is_left = [&](std::uint32_t t) { return faces.face_of[t] == no_face; };
  for_each_edge(edge_uses(mesh.triangles), [&](const auto& around) {
    for (std::size_t i = 1; i < around.size(); ++i)
      if (is_left(around[i - 1].triangle) && is_left(around[i].triangle))
        groups.unite(around[i - 1].triangle, around[i].triangle);
  });
  std::map<std::uint32_t, std::vector<Piece>> by_group;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!is_left(t)) continue;
    const Vec3 a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    by_group[groups.root(t)].push_back({(a + b + c) / 3, 0.5 * (b - a).cross(c - a).norm()});
  }
  std::vector<std::vector<Piece>> result;
  for (auto& [first, pieces] : by_group) result.push_back(std::move(pieces));
  return result;
}

/// Points joined through cells of a grid that touch each other.
std::vector<std::vector<Piece>> left_points(const Scan& scan, const Faces& faces) {
  const PointCloud& cloud = scan.cloud;
  const double area = area_per_point(scan, faces), cell = 3 * std::sqrt(area);
  std::map<std::array<std::int64_t, 3>, std::vector<std::uint32_t>> cells;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (faces.face_of[i] != no_face || (!cloud.rejected.empty() && cloud.rejected[i])) continue;
    std::array<std::int64_t, 3> key{};
    for (int k = 0; k < 3; ++k)
      key[k] = cell > 0 ? static_cast<std::int64_t>(std::floor(cloud.points[i][k] / cell)) : 0;
    cells[key].push_back(i);
  }
  DisjointSets groups(cells.size());
  std::map<std::array<std::int64_t, 3>, std::uint32_t> number;
  for (const auto& [key, points] : cells) number.emplace(key, static_cast<std::uint32_t>(number.size()));
  for (const auto& [key, n] : number)
    for (int step = 0; step < 27; ++step)
      if (const auto other = number.find({key[0] + step % 3 - 1, key[1] + step / 3 % 3 - 1, key[2] + step / 9 - 1});
          other != number.end())
        groups.unite(n, other->second);
  std::map<std::uint32_t, std::vector<Piece>> by_group;
  for (const auto& [key, points] : cells)
    for (const auto i : points) by_group[groups.root(number.at(key))].push_back({cloud.points[i], area});
  std::vector<std::vector<Piece>> result;
  for (auto& [first, pieces] : by_group) result.push_back(std::move(pieces));
  return result;
}

/// One of the pieces, so that the place is on the surface: the one nearest to the middle of all.
UnclassifiedPlace place_among(const std::vector<Piece>& pieces, double tolerance) {
  UnclassifiedPlace place;
  Vec3 sum = Vec3::Zero();
  Box3 box;
  for (const auto& piece : pieces) place.area += piece.area, sum += piece.area * piece.middle, box.add(piece.middle);
  const Vec3 middle = place.area > 0 ? Vec3(sum / place.area) : box.center();
  const auto nearest = std::min_element(pieces.begin(), pieces.end(), [&](const Piece& a, const Piece& b) {
    return (a.middle - middle).squaredNorm() < (b.middle - middle).squaredNorm();
  });
  place.place = nearest->middle;
  constexpr double smallest = 5;  // tolerances across
  const double length = std::max(box.diagonal(), std::sqrt(place.area));
  place.small = place.area < smallest * tolerance * length;
  place.reason = place.small ? "too small or narrow to tell its shape at this tolerance"
                             : "no plane, cylinder, cone, sphere or torus describes it";
  return place;
}

const char* word_of(FaceKind kind) { return kind == FaceKind::free_form ? "free form" : name_of(kind); }

std::string plural_of(FaceKind kind) {
  return kind == FaceKind::torus       ? "tori"
         : kind == FaceKind::free_form ? "free forms"
                                       : word_of(kind) + std::string("s");
}

}  // namespace

Result<MeasuredPart> measured_part(const Scan& scan, double tolerance, Context& context) {
  MeasuredPart part;
  part.tolerance = tolerance;
  FaceOptions options;
  options.tolerance = tolerance;
  part.faces = faces_of(scan, options, context);
  if (context.cancelled) return Error{"cancelled in: faces", ErrorKind::stopped};
  part.plane_sizes = sizes_of_planes(scan, part.faces);
  part.features = simple_features(part.faces);
  part.relations = relations_between(part.faces, tolerance);
  part.unclassified = unclassified_places(scan, part.faces, tolerance);
  return part;
}

double total_area(const MeasuredPart& part) {
  double area = area_of(part.faces);
  for (const auto& place : part.unclassified) area += place.area;
  return area;
}

std::size_t face_number(std::size_t face) { return face + 1; }

std::string face_name(const Faces& faces, std::size_t face) {
  return word_of(faces.faces[face].kind) + (" " + std::to_string(face_number(face)));
}

std::string face_list(const Faces& faces, const std::vector<std::uint32_t>& members, std::size_t most) {
  std::map<FaceKind, std::vector<std::uint32_t>> by_kind;
  for (const auto f : members) by_kind[faces.faces[f].kind].push_back(f);
  std::string text;
  for (auto& [kind, list] : by_kind) {
    std::sort(list.begin(), list.end());
    text += (text.empty() ? "" : "; ") + (list.size() > 1 ? plural_of(kind) : std::string(word_of(kind)));
    for (std::size_t i = 0; i < std::min(most, list.size()); ++i)
      text += (i ? ", " : " ") + std::to_string(face_number(list[i]));
    if (list.size() > most) text += " and " + std::to_string(list.size() - most) + " more";
  }
  return text;
}

Vec3 place_of(const Face& face) {
  return face.kind == FaceKind::plane || face.kind == FaceKind::free_form ? face.middle : face.surface().point;
}

Vec3 place_of(const Faces& faces, const SimpleFeature& feature) {
  Vec3 sum = Vec3::Zero();
  for (const auto f : feature.faces) sum += place_of(faces.faces[f]);
  return feature.faces.empty() ? sum : Vec3(sum / static_cast<double>(feature.faces.size()));
}

std::vector<Vec2> sizes_of_planes(const Scan& scan, const Faces& faces) {
  std::vector<Vec2> sizes(faces.faces.size(), Vec2::Zero());
  for (std::size_t f = 0; f < faces.faces.size(); ++f) {
    const Face& face = faces.faces[f];
    if (face.kind != FaceKind::plane) continue;
    const Mat3 frame = rotation_onto_axis(face.surface().axis);
    std::vector<Vec2> flat;
    for (const auto& p : places_of(scan, faces, face)) flat.emplace_back((frame.transpose() * p).head<2>());
    sizes[f] = smallest_rectangle(flat);
  }
  return sizes;
}

double area_per_point(const Scan& scan, const Faces& faces) {
  const double area = area_of(faces);
  std::size_t points = 0;
  for (const auto& face : faces.faces) points += face.members.size();
  if (points > 0 && area > 0) return area / static_cast<double>(points);
  if (!scan.mesh.empty())
    return geometry::area(scan.mesh) / static_cast<double>(std::max<std::size_t>(1, scan.cloud.size()));
  // Nothing is known of the surface: as much as that of the box around the points.
  const Vec3 s = scan.cloud.bounds().size();
  return 2 * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x()) /
         static_cast<double>(std::max<std::size_t>(1, scan.cloud.size()));
}

std::vector<UnclassifiedPlace> unclassified_places(const Scan& scan, const Faces& faces, double tolerance) {
  std::vector<UnclassifiedPlace> places;
  for (const auto& pieces : faces.of_mesh ? left_triangles(scan.mesh, faces) : left_points(scan, faces))
    places.push_back(place_among(pieces, tolerance));
  std::stable_sort(places.begin(), places.end(),
                   [](const UnclassifiedPlace& a, const UnclassifiedPlace& b) { return a.area > b.area; });
  return places;
}

}  // namespace partscribe::cli
