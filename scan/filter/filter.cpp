#include "scan/filter/filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/statistics.h"
#include "geometry/images/rlts_filter.h"

namespace partscribe::scan {
namespace {

/// A filtered pixel in the sensor's frame.
struct Sample {
  Vec3 point, normal;  // normal: unit, towards the sensor; zero where the slope is unknown
};

Sample sample_of(const RangeImage& image, const FilteredImage& filtered, std::size_t pixel) {
  const int row = static_cast<int>(pixel) / image.width, column = static_cast<int>(pixel) % image.width;
  const double z = filtered.depth[pixel], zu = filtered.slope_column[pixel], zv = filtered.slope_row[pixel];
  Vec3 point, along_column, along_row;
  if (image.projection == Projection::pinhole) {
    const Vec3 ray((column - image.cx) / image.fx, (row - image.cy) / image.fy, 1);
    point = z * ray;
    along_column = zu * ray + z / image.fx * Vec3::UnitX(), along_row = zv * ray + z / image.fy * Vec3::UnitY();
  } else {
    point = {image.x0 + column * image.pitch_x, image.y0 + row * image.pitch_y, z};
    along_column = {image.pitch_x, 0, zu}, along_row = {0, image.pitch_y, zv};
  }
  const RltsModel model = filtered.model[pixel];
  const bool sloped = model != RltsModel::none && model != RltsModel::rejected && model != RltsModel::raw;
  Vec3 normal = along_column.cross(along_row);
  const double length = normal.norm();
  if (!sloped || !(length > 0) || !std::isfinite(length)) return {point, Vec3::Zero()};
  normal /= length;
  const Vec3 away = image.projection == Projection::pinhole ? point : Vec3::UnitZ();
  return {point, normal.dot(away) > 0 ? Vec3(-normal) : normal};
}

/// The filter's answer for each view that is a range image, and the points of the view that have a pixel in it.
template <class Visit>
FilterSummary filter_each(Scan& scan, const std::vector<RangeImage>& images, const RltsOptions& options,
                          Context& context, const Visit& visit) {
  FilterSummary summary;
  PointCloud& cloud = scan.cloud;
  if (images.size() != scan.views.size() || cloud.pixel.size() != cloud.size() || cloud.view.size() != cloud.size())
    return summary;
  cloud.rejected.resize(cloud.size(), 0);
  std::vector<std::vector<std::uint32_t>> points_of(images.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.view[i] >= 0 && static_cast<std::size_t>(cloud.view[i]) < points_of.size() && cloud.pixel[i] >= 0)
      points_of[static_cast<std::size_t>(cloud.view[i])].push_back(static_cast<std::uint32_t>(i));
  std::vector<double> sigmas;
  for (std::size_t v = 0; v < images.size() && !context.cancelled; ++v) {
    const RangeImage& image = images[v];
    if (image.width == 0) continue;
    context.report("filter", double(v) / double(images.size()));
    const FilteredImage filtered = rlts_filter(image, options, context);
    ++summary.views, summary.returns += filtered.returns, summary.rejected += filtered.rejected;
    sigmas.push_back(filtered.noise.sigma(1));
    for (const std::uint32_t i : points_of[v]) {
      const auto pixel = static_cast<std::size_t>(cloud.pixel[i]);
      if (pixel >= filtered.kept.size()) continue;
      if (!filtered.kept[pixel])
        cloud.rejected[i] = 1;
      else
        visit(image, filtered, pixel, i);
    }
  }
  if (!sigmas.empty()) summary.sigma = median(std::move(sigmas));
  return summary;
}

}  // namespace

bool are_range_images(const std::vector<RangeImage>& images) {
  return !images.empty() && std::all_of(images.begin(), images.end(), [](const RangeImage& i) { return i.width > 0; });
}

FilterSummary filter_views(Scan& scan, const std::vector<RangeImage>& images, Context& context, FilterSigma of) {
  PointCloud& cloud = scan.cloud;
  const bool columns = are_range_images(images) && images.size() == scan.views.size();
  std::vector<Vec3> normals(columns ? cloud.size() : 0, Vec3::Zero());
  std::vector<float> sigmas(normals.size(), 0.0f);
  const auto summary = filter_each(
      scan, images, {}, context,
      [&](const RangeImage& image, const FilteredImage& filtered, std::size_t pixel, std::uint32_t i) {
        const Sample sample = sample_of(image, filtered, pixel);
        const Pose& pose = image.world_from_view;
        cloud.points[i] = pose * sample.point;
        if (!columns) return;
        normals[i] = pose.rotation * sample.normal;
        const double cosine = sample.normal.isZero() ? 1 : std::abs(normals[i].dot(cloud.rays[i]));
        const double sigma = of == FilterSigma::of_noise ? filtered.sigma[pixel]
                                                         : std::hypot(filtered.sigma[pixel], filtered.doubt[pixel]);
        sigmas[i] = static_cast<float>(sigma * cosine);
      });
  if (columns && summary.views > 0) cloud.normals = std::move(normals), cloud.sigma = std::move(sigmas);
  return summary;
}

FilterSummary flag_outliers(Scan& scan, const std::vector<RangeImage>& images, RltsForm form, Context& context) {
  RltsOptions options;
  options.form = form;
  return filter_each(scan, images, options, context,
                     [](const RangeImage&, const FilteredImage&, std::size_t, std::uint32_t) {});
}

std::vector<RegisterView> views_to_register(const Scan& scan, const std::vector<RangeImage>& images, Context& context) {
  const bool filtered_before = scan.cloud.sigma.size() == scan.cloud.size();
  if (!are_range_images(images) || filtered_before) return views_of(scan);
  Scan filtered = scan;
  filter_views(filtered, images, context, FilterSigma::of_noise);
  return views_of(filtered, scan.cloud.points);
}

}  // namespace partscribe::scan
