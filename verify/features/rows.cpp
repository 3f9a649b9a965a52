#include "verify/features/rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.h"

namespace partscribe::verify {
namespace {

constexpr double dominates = 0.6;  // of a row's area, so that the feature stands for the row

}  // namespace

FaceNames names_of(const MeshFeatures& features) {
  FaceNames names;
  for (const auto& f : features.features) names.names.push_back(f.name);
  names.face_of = [&features](const Vec3&, std::uint32_t triangle) {
    return static_cast<int>(features.feature_of[triangle]);
  };
  return names;
}

RowOf fill_rows(const ScanSource& source, const FaceNames& faces, const MeshFeatures& features,
                const PointField& points, const SurfaceField& field, const VerifyOptions& options,
                ArtifactVerdict& verdict, int threads) {
  const std::size_t count = faces.names.size();
  std::vector<FeatureVerdict> result(count);
  std::vector<double> squares(count, 0);
  std::vector<std::size_t> samples(count, 0), covered(count, 0);
  for (std::size_t f = 0; f < count; ++f) result[f].name = faces.names[f];
  std::vector<int> place_face(points.places.size()), sample_face(field.samples.size());
  parallel_for(place_face.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto p = points.places[i].point;
      place_face[i] = faces.face_of(source.points[p], points.triangle[p]);
    }
  });
  parallel_for(sample_face.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      sample_face[i] = faces.face_of(field.samples[i].point, field.samples[i].triangle);
  });
  for (std::size_t i = 0; i < points.places.size(); ++i)
    if (place_face[i] >= 0 && points.places[i].surface) {
      auto& row = result[static_cast<std::size_t>(place_face[i])];
      row.max = std::max(row.max, std::abs(points.places[i].mean));
    }
  std::vector<double> crowd(count, 0);  // points that stand together off it, and how far
  std::vector<std::size_t> crowded(count, 0);
  for (std::size_t i = 0; i < points.distance.size(); ++i) {
    const int f = place_face[points.place[i]];
    if (f < 0 || points.outlier[i]) continue;
    if (points.crowded[i])
      crowd[static_cast<std::size_t>(f)] += std::abs(points.distance[i]), ++crowded[static_cast<std::size_t>(f)];
    ++result[static_cast<std::size_t>(f)].points;
    squares[static_cast<std::size_t>(f)] += points.distance[i] * points.distance[i];
  }
  for (std::size_t i = 0; i < sample_face.size(); ++i)
    if (sample_face[i] >= 0) {
      ++samples[static_cast<std::size_t>(sample_face[i])];
      covered[static_cast<std::size_t>(sample_face[i])] += field.support[i] == Support::supported;
    }
  std::vector<std::int32_t> row_of_face(count, -1);
  for (std::size_t f = 0; f < count; ++f) {
    auto& row = result[f];
    if (row.points == 0 && samples[f] == 0) continue;
    if (crowded[f]) row.max = std::max(row.max, crowd[f] / static_cast<double>(crowded[f]));
    if (row.points) row.rms = std::sqrt(squares[f] / static_cast<double>(row.points));
    if (samples[f]) row.covered = static_cast<double>(covered[f]) / static_cast<double>(samples[f]);
    const bool bad = row.max > options.tolerance || (options.strict && samples[f] && row.covered == 0);
    row.verdict = bad ? Outcome::out_of_tolerance : Outcome::verified;
    row_of_face[f] = static_cast<std::int32_t>(verdict.objects.size());
    verdict.objects.push_back(row);
  }

  RowOf row;
  auto row_of = [&](int face) { return face < 0 ? -1 : row_of_face[static_cast<std::size_t>(face)]; };
  for (const int face : place_face) row.place.push_back(row_of(face));
  for (const int face : sample_face) row.sample.push_back(row_of(face));
  for (const auto place : points.place) row.point.push_back(row.place[place]);
  verdict.point_object.assign(source.kept, -1);
  for (std::size_t i = 0; i < source.points.size(); ++i)
    if (source.kept_place[i] != ScanSource::nowhere) verdict.point_object[source.kept_place[i]] = row.point[i];
  const TriangleMesh& mesh = verdict.mesh;
  verdict.triangle_object.resize(mesh.triangles.size());
  parallel_for(mesh.triangles.size(), threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Vec3 middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
      verdict.triangle_object[t] = row_of(faces.face_of(middle, static_cast<std::uint32_t>(t)));
    }
  });

  std::vector<std::map<std::uint32_t, std::size_t>> votes(verdict.objects.size());
  std::vector<std::size_t> total(verdict.objects.size(), 0);
  for (std::size_t i = 0; i < field.samples.size(); ++i)
    if (row.sample[i] >= 0) {
      const auto r = static_cast<std::size_t>(row.sample[i]);
      ++votes[r][features.feature_of[field.samples[i].triangle]];
      ++total[r];
    }
  row.feature.assign(verdict.objects.size(), -1);
  for (std::size_t r = 0; r < votes.size(); ++r) {
    for (const auto& [feature, number] : votes[r])
      if (static_cast<double>(number) >= dominates * static_cast<double>(total[r]))
        row.feature[r] = static_cast<std::int32_t>(feature);
    if (row.feature[r] >= 0) verdict.objects[r].kind = features.features[static_cast<std::size_t>(row.feature[r])].kind;
  }
  return row;
}

}  // namespace partscribe::verify
