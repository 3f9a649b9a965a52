#include "verify/compare.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh_facets.h"
#include "verify/data_to_model.h"
#include "verify/findings.h"
#include "verify/inspect.h"
#include "verify/model_to_data.h"
#include "verify/words.h"

namespace partscribe {
namespace {

std::string shown(double v) { return print_number(snapped(v, 0.01)); }
std::string shown(const Vec3& p) { return "(" + shown(p.x()) + ", " + shown(p.y()) + ", " + shown(p.z()) + ")"; }

/// Area of separate bodies that no point supports: nobody can have scanned a part and missed one of its pieces
/// altogether. Cavities (pieces of negative volume) are hidden by nature and do not count.
double unsupported_bodies(const TriangleMesh& mesh, const SurfaceField& field) {
  const MeshPieces pieces = pieces_of(mesh);
  std::vector<char> supported(pieces.area.size(), 0);
  for (std::size_t i = 0; i < field.samples.size(); ++i)
    if (field.support[i] == Support::supported) supported[pieces.of[field.samples[i].triangle]] = 1;
  double sum = 0;
  for (std::size_t p = 0; p < pieces.area.size(); ++p)
    if (!supported[p] && pieces.volume[p] > 0) sum += pieces.area[p];
  return sum;
}

/// True if the point is on the surface that was measured of a displaced feature.
bool on_measured(const MeshFeature& feature, const Inspection& inspection, const Vec3& point) {
  if (std::abs(distance(inspection.measured, point)) > inspection.close) return false;
  const Vec3 d = point - feature.primitive->point;
  const auto kind = feature.primitive->kind;
  if (kind != PrimitiveKind::cylinder && kind != PrimitiveKind::cone) return (point - feature.middle).norm() < inspection.reach + 10 * inspection.close;
  const double along = d.dot(feature.primitive->axis);
  return along > feature.low - 10 * inspection.close && along < feature.high + 10 * inspection.close;
}

/// Where a feature stands in the wrong place, points near its rim are nearest to its neighbours. A place is not held
/// against its row if the finding about another feature explains it, or if it lies on the row's own surface and only
/// beyond its rim.
void exonerate(Compared& compared, const RowOf& row, const std::vector<Inspection>& found, const VerifyOptions& options,
               std::vector<FeatureVerdict>& rows) {
  auto feature_of = [&](std::size_t r) -> const MeshFeature& {
    return compared.features.features[static_cast<std::size_t>(row.feature[r])];
  };
  std::vector<std::size_t> guilty;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (found[r].finding) guilty.push_back(r);
  std::vector<double> left(rows.size(), 0);
  for (std::size_t p = 0; p < compared.points.places.size(); ++p) {
    const Place& place = compared.points.places[p];
    const auto r = row.place[p];
    if (r < 0 || !place.surface) continue;
    const auto own = static_cast<std::size_t>(r);
    const double off = std::abs(place.mean);
    if (off > options.tolerance) {
      const Vec3& point = compared.source.points[place.point];
      bool explained = row.feature[own] >= 0 && feature_of(own).primitive && !found[own].finding &&
                       std::abs(distance(*feature_of(own).primitive, point)) <= options.tolerance;
      for (const auto g : guilty) explained = explained || on_measured(feature_of(g), found[g], point);
      if (explained) {
        compared.explained_place[p] = 1;
        continue;
      }
    }
    left[own] = std::max(left[own], off);
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].verdict == Outcome::verified || found[r].finding || left[r] > options.tolerance) continue;
    if (options.strict && rows[r].covered == 0) continue;
    rows[r].max = left[r];
    rows[r].verdict = Outcome::verified;
  }
}

/// Every feature measured by its own points: fills the rows' dimensions and verdicts. Returns the findings about whole
/// features; marks the places and rows that these explain.
std::vector<Finding> inspect_rows(Compared& compared, const RowOf& row, const VerifyOptions& options,
                                  std::vector<FeatureVerdict>& rows, int threads) {
  std::vector<std::vector<std::uint32_t>> points(rows.size());
  for (std::uint32_t i = 0; i < row.point.size(); ++i) {
    const auto r = row.point[i];
    if (r < 0 || compared.points.stray[i]) continue;
    const auto feature = row.feature[static_cast<std::size_t>(r)];
    if (feature >= 0 && compared.features.feature_of[compared.points.triangle[i]] == static_cast<std::uint32_t>(feature))
      points[static_cast<std::size_t>(r)].push_back(i);
  }
  std::vector<Inspection> found(rows.size());
  parallel_for(rows.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      if (row.feature[r] >= 0)
        found[r] = inspect(compared, compared.features.features[static_cast<std::size_t>(row.feature[r])], rows[r].name,
                           points[r], options);
  }, 1);
  std::vector<Finding> findings;
  compared.explained_place.assign(compared.points.places.size(), 0);
  compared.explained_row.assign(rows.size(), 0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    rows[r].dimensions = std::move(found[r].dimensions);
    if (!found[r].finding) continue;
    rows[r].verdict = Outcome::out_of_tolerance;
    findings.push_back(std::move(*found[r].finding));
    compared.explained_row[r] = 1;
  }
  if (!findings.empty()) exonerate(compared, row, found, options, rows);
  return findings;
}

}  // namespace

void compare(const ScanSource& source, const FaceNames* names, const VerifyOptions& options, ArtifactVerdict& verdict,
             Context& context) {
  const auto normals = triangle_normals(verdict.mesh);
  const MeshDistance surface(verdict.mesh);
  const PointField points = data_to_model(source, surface, normals, options, context, verdict.exact.get());
  context.report("compare", 0.6);
  const SurfaceField field = model_to_data(source, points, verdict.mesh, surface, normals, options, context);
  context.report("compare", 0.9);
  verdict.data_to_model = points.summary;
  verdict.model_to_data = field.summary;
  for (const auto support : field.support) verdict.sample_support.push_back(static_cast<std::uint8_t>(support));
  const MeshFeatures features = recognise_features(verdict.mesh, options.tolerance);
  const FaceNames faces = names ? *names : names_of(features);
  const RowOf row = fill_rows(source, faces, features, points, field, options, verdict, context.threads);
  Compared compared{source,  verdict.mesh, normals,   surface,    points,      field, features,
                    verdict.objects, row.feature, row.place, row.sample, {}, {}};
  const auto whole = inspect_rows(compared, row, options, verdict.objects, context.threads);
  verdict.findings = all_findings(compared, whole, options, context.threads);
  verdict.point_deviation.assign(source.kept, 0);
  for (std::size_t i = 0; i < source.points.size(); ++i)
    if (source.kept_place[i] != ScanSource::nowhere)
      verdict.point_deviation[source.kept_place[i]] =
          static_cast<float>(points.stray[i] ? points.distance[i] : points.places[points.place[i]].mean);

  std::vector<std::string> faults = points.faults;
  if (field.summary.contradicted > field.allowed_contradiction)
    faults.push_back(shown(field.summary.contradicted) + " mm^2 of the model's surface contradict the scan, near " +
                     shown(field.worst));
  for (const auto& cluster : field.passages.clusters)
    faults.push_back(counted(cluster.members.size(), "point") + " were seen through the model's surface at " +
                     shown(field.passages.places[cluster.members.front()]) + ": " + std::to_string(cluster.most) +
                     " where this scan's strays explain " + shown(cluster.expected));
  if (const double inside = surface_inside_bodies(verdict.mesh, surface, normals, field, context.threads);
      inside > field.allowed_contradiction)
    faults.push_back("bodies of the artifact overlap: " + shown(inside) + " mm^2 of surface lie inside another body");
  if (const double alone = unsupported_bodies(verdict.mesh, field); alone > field.allowed_contradiction)
    faults.push_back("a separate body of " + shown(alone) + " mm^2 has no scanned point at all");
  if (options.strict && field.summary.not_scanned > field.allowed_contradiction)
    faults.push_back(shown(field.summary.not_scanned) + " mm^2 of the model's surface were not scanned");
  // What is wrong says more than how far the worst place is off.
  const bool told = !verdict.findings.empty() && verdict.findings.front().kind != Finding::Kind::not_scanned;
  if (told && (!faults.empty() || !whole.empty())) faults.insert(faults.begin(), verdict.findings.front().text);
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
