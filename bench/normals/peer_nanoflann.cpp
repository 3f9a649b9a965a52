// nanoflann and a covariance matrix: what one writes in an hour.
#include <nanoflann.hpp>

#include "peers.h"
#include "plane_normal.h"

namespace peers {
namespace {

struct Points {
  const std::vector<Vec3>& all;
  std::size_t kdtree_get_point_count() const { return all.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return all[i][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3, std::uint32_t>;
  const Points adaptor{points};
  Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  std::vector<Vec3> result(points.size());
  std::vector<std::uint32_t> near(static_cast<std::size_t>(count));
  std::vector<double> sq_distance(near.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t found = tree.knnSearch(points[i].data(), near.size(), near.data(), sq_distance.data());
    result[i] = plane_normal(found, [&](std::size_t k) -> Vec3 { return points[near[k]] - points[i]; });
  }
  return result;
}

}  // namespace

std::vector<CloudMethod> nanoflann_methods() { return {{"nanoflann + PCA", &planes}}; }

}  // namespace peers
