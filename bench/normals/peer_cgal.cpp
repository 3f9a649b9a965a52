// CGAL: planes through neighbours. It takes the neighbours besides the point itself.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/pca_estimate_normals.h>

#include "peers.h"

namespace peers {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Item = std::pair<Kernel::Point_3, Kernel::Vector_3>;

std::vector<Vec3> planes(const std::vector<Vec3>& points, int count) {
  std::vector<Item> items;
  items.reserve(points.size());
  for (const Vec3& p : points) items.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), CGAL::NULL_VECTOR);
  CGAL::pca_estimate_normals<CGAL::Sequential_tag>(items, unsigned(count - 1),
                                                   CGAL::parameters::point_map(CGAL::First_of_pair_property_map<Item>())
                                                       .normal_map(CGAL::Second_of_pair_property_map<Item>()));
  std::vector<Vec3> result;
  result.reserve(items.size());
  for (const Item& i : items) result.emplace_back(i.second.x(), i.second.y(), i.second.z());
  return result;
}

}  // namespace

std::vector<CloudMethod> cgal_methods() { return {{"CGAL", &planes}}; }

}  // namespace peers
