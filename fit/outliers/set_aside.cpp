#include "fit/outliers/set_aside.h"

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "fit/evidence/evidence.h"
#include "fit/outliers/outliers.h"
#include "geometry/points/keep_points.h"
#include "geometry/segment/faces.h"

namespace partscribe::fit {
namespace {

constexpr double beside_from = 4, beside_to = 16;  // sigmas off a face: as near as outliers lie that are not on it
constexpr double least_spared = 12;                // points on a face that were taken for outliers

/// What lies on a face of the part is no outlier, however small the face is: the wall of a hole has few neighbours on
/// any local plane.
void spare_faces(const PointCloud& cloud, double tolerance, SurfacePoints& found, Context& context) {
  FaceOptions options;
  options.tolerance = tolerance;
  const Faces faces = faces_of_cloud(cloud, options, context);
  std::vector<std::uint32_t> outliers;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (found.outlier[i]) outliers.push_back(i);
  for (std::uint32_t f = 0; f < faces.faces.size(); ++f) {
    const Face& face = faces.faces[f];
    if (face.kind == FaceKind::free_form) continue;
    // Outliers lie beside the face as densely as on it: what they put there by chance does not make a face.
    Box3 box;
    for (const auto i : face.members) box.add(cloud.points[i]);
    const Vec3 margin = Vec3::Constant(beside_to * faces.noise);
    double on = 0, beside = 0;
    for (const auto i : outliers) {
      const Vec3& p = cloud.points[i];
      if ((p.array() < (box.low - margin).array()).any() || (p.array() > (box.high + margin).array()).any()) continue;
      const double off = std::abs(distance(face.surface(), p)) / faces.noise;
      if (faces.face_of[i] == f)
        on += 1;
      else if (off > beside_from && off < beside_to)
        beside += 1;
    }
    const double chance = beside * beside_from / (beside_to - beside_from);
    if (on < 3 * chance + 3 * std::sqrt(chance) + least_spared) continue;
    for (const auto i : outliers)
      if (faces.face_of[i] == f) found.outlier[i] = 0, --found.outliers;
  }
}

}  // namespace

std::optional<Fitted> without_outliers(const Scan& scan, FitInput input, Context& context) {
  constexpr std::size_t least_outliers = 9;  // fewer never judge a candidate
  if (!scan.mesh.empty() || input.cloud.normals.size() != input.cloud.size()) return std::nullopt;
  SurfacePoints found = surface_points_of(input.cloud.points, input.cloud.rays, input.sampling.sigma, context);
  PointCloud& cloud = input.cloud;
  if (found.outliers >= least_outliers) spare_faces(cloud, input.tolerance, found, context);
  const std::size_t n = cloud.size();
  if (found.outliers < least_outliers || n - found.outliers < 50) return std::nullopt;
  context.say("outliers: " + print_number(double(found.outliers)) + " of " + print_number(double(n)) +
              " points set aside");
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& towards = cloud.rays.size() == n ? Vec3(-cloud.rays[i]) : cloud.normals[i];
    cloud.normals[i] = found.normals[i].dot(towards) < 0 ? Vec3(-found.normals[i]) : found.normals[i];
  }
  std::vector<std::uint8_t> surface(n);
  for (std::size_t i = 0; i < n; ++i) surface[i] = !found.outlier[i];
  input.set_aside = cloud;
  keep_points(input.set_aside, found.outlier);
  std::vector<std::uint8_t> rejected = points_at(scan.cloud, input.set_aside.points);
  for (std::size_t i = 0; i < scan.cloud.rejected.size(); ++i) rejected[i] |= scan.cloud.rejected[i];
  keep_points(cloud, surface);
  for (std::size_t i = 0; i < n; ++i)
    if (surface[i]) input.surface_share.push_back(found.share[i]);
  input.outlier_share = double(found.outliers) / double(n);
  input.sampling.sigma = std::min(input.sampling.sigma, found.sigma);
  input.sampling.rejected += found.outliers;
  input.bounds = cloud.bounds();
  input.surroundings = surroundings_of(input, context);
  return Fitted{std::move(input), std::move(rejected)};
}

}  // namespace partscribe::fit
