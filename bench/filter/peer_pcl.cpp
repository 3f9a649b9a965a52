// PCL's filters. Its points are floats; fast bilateral: 5 pixels and 10 sigma.
#include "bench/filter/peers.h"

#ifdef PARTSCRIBE_HAS_PCL
#include <pcl/filters/fast_bilateral.h>
#include <pcl/filters/median_filter.h>
#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/surface/mls.h>

#include <cmath>

namespace partscribe::filter_bench {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// Organised, not a number where nothing returned.
Cloud::Ptr grid_of(const RangeImage& image, const Filtered& in) {
  Cloud::Ptr cloud(new Cloud(unsigned(image.width), unsigned(image.height)));
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    const float none = std::nanf("");
    const Vec3& p = in.points[i];
    (*cloud)[i] =
        in.kept[i] ? pcl::PointXYZ(float(p.x()), float(p.y()), float(p.z())) : pcl::PointXYZ(none, none, none);
  }
  cloud->is_dense = false;
  return cloud;
}

/// Of the kept points alone.
Cloud::Ptr list_of(const Filtered& in, std::vector<std::size_t>& source) {
  Cloud::Ptr cloud(new Cloud);
  for (std::size_t i = 0; i < in.points.size(); ++i)
    if (in.kept[i]) {
      cloud->push_back(pcl::PointXYZ(float(in.points[i].x()), float(in.points[i].y()), float(in.points[i].z())));
      source.push_back(i);
    }
  return cloud;
}

/// Depths as filtered; the pixel's ray stays.
Filtered with_depths(const RangeImage& image, Filtered in, const Cloud& depths) {
  for (std::size_t i = 0; i < in.points.size(); ++i) {
    if (!in.kept[i] || !std::isfinite(depths[i].z)) continue;
    if (image.projection == Projection::pinhole)
      in.points[i] *= depths[i].z / in.points[i].z();
    else
      in.points[i].z() = depths[i].z;
  }
  return in;
}

template <class Removal>
Filtered remove(const RangeImage& image, Removal removal) {
  Filtered out = raw(image);
  std::vector<std::size_t> source;
  removal.setInputCloud(list_of(out, source));
  pcl::Indices kept;
  removal.filter(kept);
  out.kept.assign(out.kept.size(), 0);
  for (const auto k : kept) out.kept[source[std::size_t(k)]] = 1;
  return out;
}

Filtered median(const RangeImage& image, double) {
  Filtered in = raw(image);
  pcl::MedianFilter<pcl::PointXYZ> filter;
  filter.setInputCloud(grid_of(image, in));
  filter.setWindowSize(5);
  Cloud result;
  filter.filter(result);
  return with_depths(image, std::move(in), result);
}

Filtered bilateral(const RangeImage& image, double sigma) {
  Filtered in = raw(image);
  pcl::FastBilateralFilter<pcl::PointXYZ> filter;
  filter.setInputCloud(grid_of(image, in));
  filter.setSigmaS(5);
  filter.setSigmaR(float(10 * sigma));
  Cloud result;
  filter.filter(result);
  return with_depths(image, std::move(in), result);
}

Filtered statistical(const RangeImage& image, double) {
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> removal;
  removal.setMeanK(20);
  removal.setStddevMulThresh(0.2);
  return remove(image, removal);
}

Filtered radius(const RangeImage& image, double) {
  pcl::RadiusOutlierRemoval<pcl::PointXYZ> removal;
  removal.setRadiusSearch(1.6);
  removal.setMinNeighborsInRadius(10);
  return remove(image, removal);
}

Filtered statistical_and_mls(const RangeImage& image, double sigma) {
  Filtered out = statistical(image, sigma);
  std::vector<std::size_t> source;
  pcl::MovingLeastSquares<pcl::PointXYZ, pcl::PointXYZ> mls;
  mls.setInputCloud(list_of(out, source));
  mls.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  mls.setSearchRadius(1.6);
  mls.setPolynomialOrder(2);
  Cloud result;
  mls.process(result);
  const auto indices = mls.getCorrespondingIndices();
  out.kept.assign(out.kept.size(), 0);
  for (std::size_t k = 0; k < result.size(); ++k) {
    const std::size_t i = source[std::size_t(indices->indices[k])];
    out.kept[i] = 1, out.points[i] = result[k].getVector3fMap().cast<double>();
  }
  return out;
}

}  // namespace

std::vector<Peer> pcl_filters() {
  return {{"PCL median 5x5", &median},
          {"PCL fast bilateral", &bilateral},
          {"PCL statistical removal 20, 0.2", &statistical},
          {"PCL radius removal 1.6", &radius},
          {"PCL statistical removal + MLS 1.6", &statistical_and_mls}};
}

}  // namespace partscribe::filter_bench
#else
namespace partscribe::filter_bench {
std::vector<Peer> pcl_filters() { return {}; }
}  // namespace partscribe::filter_bench
#endif
