#include "verify/compare/compare.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/number.h"
#include "core/parallel.h"
#include "geometry/mesh/mesh_facets.h"
#include "verify/compare/clusters.h"
#include "verify/compare/data_to_model.h"
#include "verify/compare/model_to_data.h"
#include "verify/features/inspect.h"
#include "verify/features/roundness.h"
#include "verify/report/findings.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t most_second_looks = 40;  // at features: each goes through all points once
constexpr std::size_t fewest_points = 20;      // that show another radius
constexpr double hardly_covered = 0.35;        // share of a feature; it may be elsewhere

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

/// True if the point is on the surface that was measured of a displaced feature, or `or_inside` it.
bool on_measured(const MeshFeature& feature, const Inspection& inspection, const Vec3& point, bool or_inside = false) {
  const double off = distance(inspection.measured, point);
  if ((or_inside ? off : std::abs(off)) > inspection.close) return false;
  const Vec3 d = point - feature.primitive->point;
  const auto kind = feature.primitive->kind;
  if (kind != PrimitiveKind::cylinder && kind != PrimitiveKind::cone)
    return (point - feature.middle).norm() < inspection.reach + 10 * inspection.close;
  const double along = d.dot(feature.primitive->axis);
  return along > feature.low - 10 * inspection.close && along < feature.high + 10 * inspection.close;
}

/// Of each feature those that share an edge with it.
std::vector<std::vector<std::uint32_t>> neighbours_of(const TriangleMesh& mesh, const MeshFeatures& features) {
  struct Side {
    std::uint32_t from, to, feature;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), features.feature_of[t]});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.from, a.to, a.feature) < std::tie(b.from, b.to, b.feature);
  });
  std::vector<std::vector<std::uint32_t>> neighbours(features.features.size());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.from != b.from || a.to != b.to || a.feature == b.feature) continue;
    neighbours[a.feature].push_back(b.feature), neighbours[b.feature].push_back(a.feature);
  }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

/// Clears rows of what a displaced feature causes: where a feature stands in the wrong place, points near its rim are
/// nearest to its neighbours, and points of its neighbours are nearest to it. A place is not held against its row if it
/// lies where another feature was measured, or on the row's own surface and only beyond its rim, or, if the row's own
/// feature is displaced, on the surface of a neighbour that continues there.
void exonerate(Compared& compared, const RowOf& row, const std::vector<std::vector<std::uint32_t>>& neighbours,
               const std::vector<Inspection>& found, const VerifyOptions& options, std::vector<FeatureVerdict>& rows) {
  const auto& features = compared.features.features;
  auto lies_on = [&](std::uint32_t feature, const Vec3& point) {
    const auto& primitive = features[feature].primitive;
    return primitive && std::abs(distance(*primitive, point)) <= options.tolerance;
  };
  std::vector<std::size_t> guilty;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (found[r].finding) guilty.push_back(r);
  auto explained = [&](std::uint32_t point, std::size_t own) {
    const Vec3& p = compared.source.points[point];
    for (const auto g : guilty)
      if (on_measured(features[static_cast<std::size_t>(row.feature[g])], found[g], p)) return true;
    if (row.feature[own] < 0) return false;
    const auto feature = static_cast<std::uint32_t>(row.feature[own]);
    if (!found[own].finding) return lies_on(feature, p);
    const auto& around = neighbours[feature];
    return std::any_of(around.begin(), around.end(), [&](std::uint32_t n) { return lies_on(n, p); });
  };
  std::vector<double> left(rows.size(), 0);
  for (std::size_t p = 0; p < compared.points.places.size(); ++p) {
    const Place& place = compared.points.places[p];
    const auto r = row.place[p];
    if (r < 0 || !place.surface) continue;
    const auto own = static_cast<std::size_t>(r);
    const double off = std::abs(place.mean);
    if (off > options.tolerance && explained(place.point, own))
      compared.explained_point[place.point] = 1;
    else
      left[own] = std::max(left[own], off);
  }
  for (std::uint32_t i = 0; i < compared.points.crowded.size(); ++i) {
    if (!compared.points.crowded[i] || row.point[i] < 0) continue;
    const auto own = static_cast<std::size_t>(row.point[i]);
    if (explained(i, own))
      compared.explained_point[i] = 1;
    else
      left[own] = std::max(left[own], std::abs(compared.points.distance[i]));
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].verdict == Outcome::verified || found[r].finding || left[r] > options.tolerance) continue;
    if (options.strict && rows[r].covered == 0) continue;
    rows[r].max = left[r];
    rows[r].verdict = Outcome::verified;
  }
}

/// Connected points about a feature that lie neither on the artifact, nor where its neighbours go on, nor on what was
/// measured of these.
std::vector<std::uint32_t> unexplained_about(const Compared& compared, std::uint32_t number,
                                             const std::vector<std::uint32_t>& neighbours,
                                             const std::vector<const Inspection*>& measured, double tolerance) {
  const MeshFeature& feature = compared.features.features[number];
  const Primitive& own = *feature.primitive;
  const double close = std::max(3 * compared.source.noise, 0.3 * tolerance);
  std::vector<Vec3> places;
  std::vector<std::uint32_t> index;
  for (std::uint32_t i = 0; i < compared.source.points.size(); ++i) {
    const auto at = compared.features.feature_of[compared.points.triangle[i]];
    if (compared.points.outlier[i] || (at != number && !std::binary_search(neighbours.begin(), neighbours.end(), at)))
      continue;
    const Vec3& p = compared.source.points[i];
    const double along = (p - own.point).dot(own.axis);
    if (along < feature.low - close || along > feature.high + close) continue;
    bool explained = std::abs(compared.points.distance[i]) <= close;
    for (const auto n : neighbours) {
      const auto& surface = compared.features.features[n].primitive;
      explained = explained || (surface && std::abs(distance(*surface, p)) <= close) ||
                  (measured[n] && std::abs(distance(measured[n]->measured, p)) <= close);
    }
    if (!explained) places.push_back(p), index.push_back(i);
  }
  const std::vector<double> reach(places.size(), 4 * compared.source.spacing);
  // The group that the feature has most of; if it has none of any, the one about its axis.
  std::vector<std::uint32_t> best;
  std::size_t most = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& group : clusters_of(places, reach, [](std::uint32_t, std::uint32_t) { return true; })) {
    std::size_t own_points = 0;
    Vec3 middle = Vec3::Zero();
    for (const auto i : group) {
      own_points += compared.features.feature_of[compared.points.triangle[index[i]]] == number;
      middle += places[i];
    }
    middle /= static_cast<double>(group.size());
    const double apart = (middle - own.point).cross(own.axis).norm();
    if (group.size() < fewest_points || own_points < most || (own_points == most && apart >= nearest)) continue;
    most = own_points, nearest = apart;
    best.clear();
    for (const auto i : group) best.push_back(index[i]);
  }
  return best;
}

/// Features that are off, but not as a whole by what is nearest to them: their radius may be quite another one.
void look_again(const Compared& compared, const RowOf& row, const std::vector<std::vector<std::uint32_t>>& neighbours,
                const VerifyOptions& options, const std::vector<FeatureVerdict>& rows, std::vector<Inspection>& found) {
  std::vector<const Inspection*> measured(compared.features.features.size(), nullptr);
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (row.feature[r] >= 0 && !found[r].dimensions.empty())
      measured[static_cast<std::size_t>(row.feature[r])] = &found[r];
  std::size_t tried = 0;
  for (std::size_t r = 0; r < rows.size() && tried < most_second_looks; ++r) {
    if (row.feature[r] < 0 || found[r].finding) continue;
    const auto number = static_cast<std::uint32_t>(row.feature[r]);
    const auto& primitive = compared.features.features[number].primitive;
    if (!primitive || primitive->kind != PrimitiveKind::cylinder) continue;
    if (rows[r].verdict == Outcome::verified && rows[r].covered > hardly_covered) continue;
    ++tried;
    const auto points = unexplained_about(compared, number, neighbours[number], measured, options.tolerance);
    auto again = inspect_anew(compared, compared.features.features[number], rows[r], points, options);
    if (again.finding) found[r] = std::move(again);
  }
}

/// No two features of the artifact are one scanned feature: it belongs to the nearer of them.
void tell_apart(const Compared& compared, const RowOf& row, std::vector<Inspection>& found) {
  auto is_full = [&](std::size_t r) {
    if (!found[r].finding || row.feature[r] < 0) return false;
    const auto& kind = compared.features.features[static_cast<std::size_t>(row.feature[r])].kind;
    return kind == "hole" || kind == "boss";
  };
  auto range = [&](std::size_t r, const Primitive& along) {
    const MeshFeature& f = compared.features.features[static_cast<std::size_t>(row.feature[r])];
    const double a = (f.primitive->point + f.low * f.primitive->axis - along.point).dot(along.axis);
    const double b = (f.primitive->point + f.high * f.primitive->axis - along.point).dot(along.axis);
    return std::pair(std::min(a, b), std::max(a, b));
  };
  for (std::size_t r = 0; r < found.size(); ++r)
    for (std::size_t s = r + 1; s < found.size() && is_full(r); ++s) {
      if (!is_full(s)) continue;
      const Primitive &a = found[r].measured, &b = found[s].measured;
      const double close = std::max(found[r].close, found[s].close);
      if (std::abs(a.radius - b.radius) > close || std::abs(a.axis.dot(b.axis)) < 0.985) continue;
      const Vec3 d = b.point - a.point;
      if ((d - d.dot(a.axis) * a.axis).norm() > close + 0.2 * a.radius) continue;
      const auto p = range(r, a), q = range(s, a);
      if (std::min(p.second, q.second) <= std::max(p.first, q.first)) continue;  // one behind the other
      found[found[r].shift <= found[s].shift ? s : r] = {};
    }
}

/// Surface of the artifact between where a feature is and where it should be, or in its mouth, is explained by its
/// finding.
void explain_samples(Compared& compared, const RowOf& row, const std::vector<Inspection>& found) {
  compared.explained_sample.assign(compared.field.samples.size(), 0);
  for (std::size_t r = 0; r < found.size(); ++r) {
    if (!found[r].finding) continue;
    const MeshFeature& feature = compared.features.features[static_cast<std::size_t>(row.feature[r])];
    const bool full = feature.kind == "hole" || feature.kind == "boss";
    Inspection wider = found[r];
    wider.close += found[r].shift;
    for (std::size_t i = 0; i < compared.field.samples.size(); ++i)
      if (compared.field.support[i] == Support::contradicted &&
          on_measured(feature, wider, compared.field.samples[i].point, full))
        compared.explained_sample[i] = 1;
  }
}

/// Every feature measured by its own points: fills the rows' dimensions and verdicts. Returns the findings about whole
/// features; marks the places, samples and rows that these explain.
std::vector<Finding> inspect_rows(Compared& compared, const RowOf& row, const VerifyOptions& options,
                                  std::vector<FeatureVerdict>& rows, int threads) {
  std::vector<std::vector<std::uint32_t>> points(rows.size());
  for (std::uint32_t i = 0; i < row.point.size(); ++i) {
    const auto r = row.point[i];
    if (r < 0 || compared.points.outlier[i]) continue;
    const auto feature = row.feature[static_cast<std::size_t>(r)];
    if (feature >= 0 &&
        compared.features.feature_of[compared.points.triangle[i]] == static_cast<std::uint32_t>(feature))
      points[static_cast<std::size_t>(r)].push_back(i);
  }
  std::vector<Inspection> found(rows.size());
  parallel_for(
      rows.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r)
          if (row.feature[r] >= 0)
            found[r] = inspect(compared, compared.features.features[static_cast<std::size_t>(row.feature[r])], rows[r],
                               points[r], options);
      },
      1);
  const auto neighbours = neighbours_of(compared.mesh, compared.features);
  look_again(compared, row, neighbours, options, rows, found);
  tell_apart(compared, row, found);
  std::vector<Finding> findings;
  compared.explained_point.assign(compared.source.points.size(), 0);
  compared.explained_row.assign(rows.size(), 0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    rows[r].dimensions = std::move(found[r].dimensions);
    if (!found[r].finding) continue;
    rows[r].verdict = Outcome::out_of_tolerance;
    findings.push_back(std::move(*found[r].finding));
    compared.explained_row[r] = 1;
  }
  explain_samples(compared, row, found);
  if (!findings.empty()) exonerate(compared, row, neighbours, found, options, rows);
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
  const MeshFeatures features = recognise_features(
      verdict.mesh, options.tolerance,
      [&](const Primitive& wall, double low, double high) { return scanned_round(source, surface, wall, low, high); });
  const FaceNames faces = names ? *names : names_of(features);
  const RowOf row = fill_rows(source, faces, features, points, field, options, verdict, context.threads);
  Compared compared{source,      verdict.mesh, normals,    surface,      points, field, features, verdict.objects,
                    row.feature, row.place,    row.sample, verdict.file, {},     {},    {}};
  const auto whole = inspect_rows(compared, row, options, verdict.objects, context.threads);
  verdict.findings = all_findings(compared, whole, options, context.threads);
  verdict.point_deviation.assign(source.kept, 0);
  for (std::size_t i = 0; i < source.points.size(); ++i)
    if (source.kept_place[i] != ScanSource::nowhere)
      verdict.point_deviation[source.kept_place[i]] =
          static_cast<float>(points.outlier[i] ? points.distance[i] : points.places[points.place[i]].mean);

  std::vector<std::string> faults = points.faults;
  if (field.summary.contradicted > field.allowed_contradiction || !field.in_plain_view.empty())
    faults.push_back(shown(field.summary.contradicted, 0.01) +
                     " mm^2 of the artifact's surface contradict the scan, near " + shown(field.worst, 0.01));
  for (const auto& cluster : field.passages.clusters)
    faults.push_back(counted(cluster.members.size(), "point") + " were seen through the artifact's surface at " +
                     shown(field.passages.places[cluster.members.front()], 0.01) + ": " + std::to_string(cluster.most) +
                     " where outliers make " + shown(cluster.expected, 0.01));
  if (const double inside = surface_inside_bodies(verdict.mesh, surface, normals, field, context.threads);
      inside > field.allowed_contradiction)
    faults.push_back("bodies of the artifact overlap: " + shown(inside, 0.01) +
                     " mm^2 of surface lie inside another body");
  if (const double alone = unsupported_bodies(verdict.mesh, field); alone > field.allowed_contradiction)
    faults.push_back("a separate body of " + shown(alone, 0.01) + " mm^2 has no scanned point at all");
  if (options.strict && field.summary.not_scanned > field.allowed_contradiction)
    faults.push_back(shown(field.summary.not_scanned, 0.01) +
                     " mm^2 of the artifact's surface were not scanned, and --strict allows none");
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
        const Vec3 p =
            i < corners ? from.vertices[i] : Vec3((from.corner(t, 0) + from.corner(t, 1) + from.corner(t, 2)) / 3);
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

}  // namespace partscribe::verify
