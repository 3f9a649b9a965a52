#include "verify/compare.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/number.h"
#include "core/parallel.h"
#include "verify/data_to_model.h"
#include "verify/findings.h"
#include "verify/model_to_data.h"

namespace partscribe {
namespace {

constexpr double smooth_edge = 0.93969262078590838;  // cosine of 20 degrees
constexpr std::size_t most_faces = 40;

std::string shown(double v) { return print_number(snapped(v, 0.01)); }
std::string shown(const Vec3& p) { return "(" + shown(p.x()) + ", " + shown(p.y()) + ", " + shown(p.z()) + ")"; }

std::vector<Vec3> facet_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.triangles.size());
  for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = triangle_normal(mesh, t);
  return normals;
}

/// Area of separate bodies that no point supports: nobody can have scanned a part and missed one of its pieces
/// altogether. Cavities (pieces of negative volume) are hidden by nature and do not count.
double unsupported_bodies(const TriangleMesh& mesh, const SurfaceField& field) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : mesh.triangles)
    for (const auto v : {t[1], t[2]}) parent[std::max(root(t[0]), root(v))] = std::min(root(t[0]), root(v));
  std::vector<double> areas(parent.size(), 0), volumes(parent.size(), 0);
  std::vector<char> supported(parent.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto r = root(mesh.triangles[t][0]);
    const Vec3 o = mesh.vertices[r], a = mesh.corner(t, 0) - o, b = mesh.corner(t, 1) - o, c = mesh.corner(t, 2) - o;
    areas[r] += 0.5 * (b - a).cross(c - a).norm();
    volumes[r] += a.dot(b.cross(c)) / 6;
  }
  for (std::size_t i = 0; i < field.samples.size(); ++i)
    if (field.support[i] == Support::supported) supported[root(mesh.triangles[field.samples[i].triangle][0])] = 1;
  double sum = 0;
  for (std::uint32_t v = 0; v < parent.size(); ++v)
    if (root(v) == v && !supported[v] && volumes[v] > 0) sum += areas[v];
  return sum;
}

/// Of each place and each surface sample, its row: index into the verdict's objects, or -1.
struct RowOf {
  std::vector<std::int32_t> place, sample;
};

/// A row per face that has data or area; which row each point and each triangle of the mesh belongs to.
RowOf fill_rows(const ScanSource& source, const FaceNames& faces, const PointField& points, const SurfaceField& surface,
                const VerifyOptions& options, ArtifactVerdict& verdict, int threads) {
  std::vector<FeatureVerdict> result(faces.names.size());
  std::vector<double> squares(result.size(), 0);
  std::vector<std::size_t> samples(result.size(), 0), covered(result.size(), 0);
  for (std::size_t f = 0; f < result.size(); ++f) result[f].name = faces.names[f];
  std::vector<int> place_face(points.places.size()), sample_face(surface.samples.size());
  parallel_for(place_face.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto p = points.places[i].point;
      place_face[i] = faces.face_of(source.points[p], points.triangle[p]);
    }
  });
  parallel_for(sample_face.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      sample_face[i] = faces.face_of(surface.samples[i].point, surface.samples[i].triangle);
  });
  for (std::size_t i = 0; i < points.places.size(); ++i)
    if (place_face[i] >= 0 && points.places[i].surface) {
      auto& row = result[static_cast<std::size_t>(place_face[i])];
      row.max = std::max(row.max, std::abs(points.places[i].mean));
    }
  for (std::size_t i = 0; i < points.distance.size(); ++i) {
    const int f = place_face[points.place[i]];
    if (f < 0 || points.stray[i]) continue;
    ++result[static_cast<std::size_t>(f)].points;
    squares[static_cast<std::size_t>(f)] += points.distance[i] * points.distance[i];
  }
  for (std::size_t i = 0; i < sample_face.size(); ++i)
    if (sample_face[i] >= 0) {
      ++samples[static_cast<std::size_t>(sample_face[i])];
      covered[static_cast<std::size_t>(sample_face[i])] += surface.support[i] == Support::supported;
    }
  std::vector<std::int32_t> row_of_face(result.size(), -1);
  for (std::size_t f = 0; f < result.size(); ++f) {
    auto& row = result[f];
    if (row.points == 0 && samples[f] == 0) continue;
    if (row.points) row.rms = std::sqrt(squares[f] / static_cast<double>(row.points));
    if (samples[f]) row.covered = static_cast<double>(covered[f]) / static_cast<double>(samples[f]);
    const bool bad = row.max > options.tolerance || (options.strict && samples[f] && row.covered == 0);
    row.verdict = bad ? Outcome::out_of_tolerance : Outcome::verified;
    row_of_face[f] = static_cast<std::int32_t>(verdict.objects.size());
    verdict.objects.push_back(row);
  }
  auto row_of = [&](int face) { return face < 0 ? -1 : row_of_face[static_cast<std::size_t>(face)]; };
  verdict.point_object.assign(source.kept, -1);
  for (std::size_t i = 0; i < source.points.size(); ++i)
    if (source.kept_place[i] != ScanSource::nowhere)
      verdict.point_object[source.kept_place[i]] = row_of(place_face[points.place[i]]);
  const TriangleMesh& mesh = verdict.mesh;
  verdict.triangle_object.resize(mesh.triangles.size());
  parallel_for(mesh.triangles.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      verdict.triangle_object[t] = row_of(faces.face_of(middle, static_cast<std::uint32_t>(t)));
    }
  });
  RowOf row;
  for (const int face : place_face) row.place.push_back(row_of(face));
  for (const int face : sample_face) row.sample.push_back(row_of(face));
  return row;
}

}  // namespace

FaceNames smooth_faces(const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  const auto normals = facet_normals(mesh);
  std::vector<std::uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), 0u);
  auto root = [&](std::uint32_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  struct Use {
    std::uint64_t edge;
    std::uint32_t triangle;
  };
  std::vector<Use> uses;
  for (std::uint32_t t = 0; t < count; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), t});
    }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
  });
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (uses[i].edge != uses[i + 1].edge) continue;
    const auto a = uses[i].triangle, b = uses[i + 1].triangle;
    if (normals[a].dot(normals[b]) >= smooth_edge) parent[std::max(root(a), root(b))] = std::min(root(a), root(b));
  }
  struct Face {
    double area = 0;
    std::uint32_t root = 0;
  };
  std::vector<double> areas(count, 0);
  for (std::uint32_t t = 0; t < count; ++t)
    areas[root(t)] += 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  std::vector<Face> faces;
  for (std::uint32_t t = 0; t < count; ++t)
    if (root(t) == t) faces.push_back({areas[t], t});
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.area != b.area ? a.area > b.area : a.root < b.root;
  });
  const bool rest = faces.size() > most_faces;
  const std::size_t named = rest ? most_faces - 1 : faces.size();
  FaceNames names;
  std::vector<int> face_of_root(count, static_cast<int>(named));
  for (std::size_t f = 0; f < named; ++f) {
    names.names.push_back("face " + std::to_string(f + 1));
    face_of_root[faces[f].root] = static_cast<int>(f);
  }
  if (rest) names.names.push_back(std::to_string(faces.size() - named) + " small faces");
  std::vector<int> face(count);
  for (std::uint32_t t = 0; t < count; ++t) face[t] = face_of_root[root(t)];
  names.face_of = [face = std::move(face)](const Vec3&, std::uint32_t triangle) { return face[triangle]; };
  return names;
}

void compare(const ScanSource& source, const FaceNames& faces, const VerifyOptions& options, ArtifactVerdict& verdict,
             Context& context) {
  const auto normals = facet_normals(verdict.mesh);
  const MeshDistance surface(verdict.mesh);
  const PointField points = data_to_model(source, surface, normals, options, context);
  context.report("compare", 0.6);
  const SurfaceField field = model_to_data(source, points, verdict.mesh, surface, normals, options, context);
  context.report("compare", 0.9);
  verdict.data_to_model = points.summary;
  verdict.model_to_data = field.summary;
  for (const auto support : field.support) verdict.sample_support.push_back(static_cast<std::uint8_t>(support));
  const RowOf row = fill_rows(source, faces, points, field, options, verdict, context.threads);
  const Compared compared{source, verdict.mesh, normals, surface, points, field, verdict.objects, row.place, row.sample, {}};
  verdict.findings = find_places(compared, options, context.threads);
  verdict.point_deviation.assign(source.kept, 0);
  for (std::size_t i = 0; i < source.points.size(); ++i)
    if (source.kept_place[i] != ScanSource::nowhere)
      verdict.point_deviation[source.kept_place[i]] =
          static_cast<float>(points.stray[i] ? points.distance[i] : points.places[points.place[i]].mean);

  std::vector<std::string> faults = points.faults;
  if (field.summary.contradicted > field.allowed_contradiction)
    faults.push_back(shown(field.summary.contradicted) + " mm^2 of the model's surface contradict the scan, near " +
                     shown(field.worst));
  if (const double inside = surface_inside_bodies(verdict.mesh, surface, normals, field, context.threads);
      inside > field.allowed_contradiction)
    faults.push_back("bodies of the artifact overlap: " + shown(inside) + " mm^2 of surface lie inside another body");
  if (const double alone = unsupported_bodies(verdict.mesh, field); alone > field.allowed_contradiction)
    faults.push_back("a separate body of " + shown(alone) + " mm^2 has no scanned point at all");
  if (options.strict && field.summary.not_scanned > field.allowed_contradiction)
    faults.push_back(shown(field.summary.not_scanned) + " mm^2 of the model's surface were not scanned");
  if (!faults.empty()) verdict.verdict = Outcome::out_of_tolerance;
  verdict.reasons.insert(verdict.reasons.end(), faults.begin(), faults.end());
}

double distance_between(const TriangleMesh& a, const TriangleMesh& b, int threads) {
  auto one_way = [&](const TriangleMesh& from, const TriangleMesh& to) {
    const MeshDistance surface(to);
    const std::size_t corners = from.vertices.size();
    std::vector<double> found(corners + from.triangles.size());
    parallel_for(found.size(), threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t t = i - corners;
        const Vec3 p = i < corners ? from.vertices[i] : Vec3((from.corner(t, 0) + from.corner(t, 1) + from.corner(t, 2)) / 3);
        found[i] = surface.closest(p).distance;
      }
    });
    return found.empty() ? 0.0 : *std::max_element(found.begin(), found.end());
  };
  // A sheet and the solid that a program made of it by giving it a thickness share the sheet only.
  const bool a_open = topology(a).boundary_edges > 0, b_open = topology(b).boundary_edges > 0;
  if (a_open && !b_open) return one_way(a, b);
  if (b_open && !a_open) return one_way(b, a);
  return std::max(one_way(a, b), one_way(b, a));
}

}  // namespace partscribe
