#include "fit/surface/chart_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>
#include <set>
#include <string>

#include "fit/surface/flatten.h"
#include "fit/surface/piece_fit.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_neighbours.h"
#include "geometry/mesh/mesh_part.h"
#include "geometry/points/kd_tree.h"

namespace partscribe::fit {
namespace {

constexpr double strip_steep = 0.2;        // cosine between a triangle of the strip and the direction of its chart
constexpr double roughness = 0.3;          // of the tolerance
constexpr std::size_t chart_points = 200;  // a chart has at least so many

/// Calls `visit` with n (n + 1) / 2 places inside of a triangle.
template <class Visit>
void visit_lattice(const TriangleMesh& mesh, std::size_t triangle, int n, Visit&& visit) {
  const Vec3 a = mesh.corner(triangle, 0), ab = mesh.corner(triangle, 1) - a, ac = mesh.corner(triangle, 2) - a;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) visit(Vec3(a + (i + 1.0 / 3) / n * ab + (j + 1.0 / 3) / n * ac));
}

/// A small piece has fewer points than a surface takes; the mesh has as many as one likes.
void add_lattice(ChartPiece& piece) {
  const int n = static_cast<int>(std::ceil(std::sqrt(double(chart_points) / double(piece.mesh.triangles.size()))));
  for (std::size_t t = 0; t < piece.mesh.triangles.size(); ++t)
    visit_lattice(piece.mesh, t, n, [&](const Vec3& p) {
      piece.data.points.push_back(p), piece.data.places.push_back(place_on(piece.mesh, piece.places, t, p));
    });
}

}  // namespace

ChartPieces::ChartPieces(const TriangleMesh& mesh, const FitInput& input, Context& context)
    : mesh_(mesh), input_(input), context_(context), neighbours_(mesh_neighbours(mesh)) {
  const bool drawn = input.scan && !input.scan->mesh.empty();
  if (!drawn) even_out();
  const MeshDistance distance(mesh_, context.threads);
  const auto hits = distance.closest(input.cloud.points, context.threads);
  on_.resize(mesh.triangles.size());
  for (std::uint32_t i = 0; i < hits.size(); ++i)
    if (hits[i].distance < 3 * input.tolerance)
      on_[hits[i].triangle].emplace_back(input.cloud.points[i], hits[i].point);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) normals_.push_back(triangle_normal(mesh, t));
  if (!drawn) add_unseen();
  add_facets();
}

/// Large facets are data as well, not their corners alone.
void ChartPieces::add_facets() {
  const double step = std::max(0.35 * input_.thin_spacing, 2 * input_.tolerance);
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const Vec3 ab = mesh_.corner(t, 1) - mesh_.corner(t, 0), ac = mesh_.corner(t, 2) - mesh_.corner(t, 0);
    const int n = static_cast<int>(std::max({ab.norm(), ac.norm(), (ac - ab).norm()}) / step);
    if (n >= 2) visit_lattice(mesh_, t, n + 1, [&](const Vec3& p) { on_[t].emplace_back(p, p); });
  }
}

Vec3 ChartPieces::middle(std::size_t t) const {
  return (mesh_.corner(t, 0) + mesh_.corner(t, 1) + mesh_.corner(t, 2)) / 3;
}

/// Where there are no points the mesh alone says how the surface goes on: as smoothly as it can.
void ChartPieces::add_unseen() {
  std::vector<char> seen(mesh_.vertices.size(), 0);
  const KdTree points(input_.cloud.points);
  for (std::size_t v = 0; v < seen.size(); ++v)
    seen[v] = points.nearest_one(mesh_.vertices[v]).sq_distance < std::pow(2 * input_.thin_spacing, 2);
  smooth(seen);
  // As dense as the points are elsewhere.
  std::set<std::array<int, 3>> taken;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const auto& c = mesh_.triangles[t];
    if (seen[c[0]] || seen[c[1]] || seen[c[2]]) continue;
    const Vec3 p = middle(t);
    std::array<int, 3> cell;
    for (std::size_t k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[int(k)] / input_.thin_spacing));
    if (taken.insert(cell).second) on_[t].emplace_back(p, p);
  }
}

/// A reconstruction is rough by the noise of its points, and roughness makes creases and steep places where there are
/// none. It is taken out without shrinking the surface [Taubin 1995]; no vertex moves by more than a share of the
/// tolerance.
void ChartPieces::even_out() {
  const double most = roughness * input_.tolerance;
  const auto before = mesh_.vertices;
  for (int round = 0; round < 40; ++round) {
    const double share = round % 2 == 0 ? 0.6 : -0.63;
    const auto mean = means_around();
    for (std::size_t v = 0; v < mean.size(); ++v) {
      const Vec3 off = mesh_.vertices[v] + share * (mean[v] - mesh_.vertices[v]) - before[v];
      mesh_.vertices[v] = before[v] + off * std::min(1.0, most / std::max(off.norm(), 1e-300));
    }
  }
}

/// Of each vertex the mean of its neighbours.
std::vector<Vec3> ChartPieces::means_around() const {
  std::vector<Vec3> sum(mesh_.vertices.size(), Vec3::Zero());
  std::vector<int> count(sum.size(), 0);
  for (const auto& t : mesh_.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum[t[k]] += mesh_.vertices[t[(k + 1) % 3]] + mesh_.vertices[t[(k + 2) % 3]], count[t[k]] += 2;
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] = count[v] > 0 ? Vec3(sum[v] / count[v]) : mesh_.vertices[v];
  return sum;
}

/// Vertices that are not `fixed` go to the mean of their neighbours, many times over.
void ChartPieces::smooth(const std::vector<char>& fixed) {
  for (int round = 0; round < 200; ++round) {
    const auto mean = means_around();
    for (std::size_t v = 0; v < mean.size(); ++v)
      if (!fixed[v]) mesh_.vertices[v] = 0.5 * (mesh_.vertices[v] + mean[v]);
  }
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) normals_[t] = triangle_normal(mesh_, t);
}

/// The triangles of a chart and of the strip around it that one can still see from where the chart is seen.
std::vector<std::uint32_t> ChartPieces::with_strip(const std::vector<std::uint32_t>& chart, double share) const {
  Vec3 direction = Vec3::Zero();
  double size = 0;
  for (const auto t : chart) {
    const double a =
        0.5 * (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0)).norm();
    direction += a * normals_[t], size += a;
  }
  direction.normalize();
  const double width = share * std::max(6 * input_.tolerance, 0.1 * std::sqrt(size));
  std::map<std::uint32_t, double> away;
  std::priority_queue<std::pair<double, std::uint32_t>, std::vector<std::pair<double, std::uint32_t>>, std::greater<>>
      queue;
  for (const auto t : chart) away[t] = 0, queue.push({0, t});
  if (width == 0) queue = {};
  while (!queue.empty()) {
    const auto [d, t] = queue.top();
    queue.pop();
    if (d > away[t]) continue;
    for (const auto other : neighbours_[t]) {
      if (other == no_neighbour) continue;
      const double next = d + (middle(other) - middle(t)).norm();
      const auto known = away.find(other);
      if (known != away.end() ? next >= known->second : d > width) continue;
      if (normals_[other].dot(normals_[t]) < sharp_cosine || normals_[other].dot(direction) < strip_steep) continue;
      away[other] = next, queue.push({next, other});
    }
  }
  std::vector<std::uint32_t> result;
  for (const auto& [t, d] : away) result.push_back(t);
  return result;
}

/// Without places where these triangles cannot be laid out.
ChartPiece ChartPieces::laid_out(std::vector<std::uint32_t> triangles) const {
  ChartPiece piece;
  piece.triangles = std::move(triangles);
  MeshPart part = part_of(mesh_, piece.triangles);
  piece.mesh = std::move(part.mesh), piece.local = std::move(part.local);
  if (auto places = flattened(piece.mesh)) piece.places = std::move(*places);
  return piece;
}

std::shared_ptr<const ChartPiece> ChartPieces::fitted(const Charts& charts, int chart) {
  std::vector<std::uint32_t> own;
  for (std::uint32_t t = 0; t < charts.of.size(); ++t)
    if (charts.of[t] == chart) own.push_back(t);
  auto& known = fitted_[own];
  if (known) return known;
  // A strip that goes round a bend may not lie open: a narrower one, or none.
  ChartPiece piece;
  for (const double width : {1.0, 0.4, 0.0})
    if (piece = laid_out(with_strip(own, width)); !piece.places.empty()) break;
  if (piece.places.empty()) {
    context_.say("free form: a chart cannot be laid out in a plane");
    return nullptr;
  }
  for (std::size_t t = 0; t < piece.triangles.size(); ++t)
    for (const auto& [point, foot] : on_[piece.triangles[t]]) {
      piece.data.points.push_back(point);
      piece.data.places.push_back(place_on(piece.mesh, piece.places, t, foot));
    }
  if (piece.data.points.size() < chart_points) add_lattice(piece);
  // Where the chart ends is said by vertices.
  for (const auto& loop : border_loops(piece.mesh))
    for (const auto v : loop)
      piece.data.points.push_back(piece.mesh.vertices[v]), piece.data.places.push_back(piece.places[v]);
  auto fit = fit_piece(piece.data, input_, context_);
  if (!fit) return nullptr;
  piece.data.places = std::move(fit->places);
  piece.surface = std::move(fit->surface);
  context_.say("free form: chart " + std::to_string(chart + 1) + ": " + std::to_string(piece.surface.u.count()) +
               " x " + std::to_string(piece.surface.v.count()) + " control points");
  return known = std::make_shared<ChartPiece>(std::move(piece));
}

}  // namespace partscribe::fit
