// CGAL's AABB tree over triangles with the inexact-constructions kernel.
#include "peers.h"

#if __has_include(<CGAL/AABB_tree.h>)
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>

namespace peers {
namespace {

class Cgal : public Peer {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

 public:
  explicit Cgal(const partscribe::geometry::TriangleMesh& mesh) {
    auto point = [](const partscribe::geometry::Vec3& v) { return Kernel::Point_3(v.x(), v.y(), v.z()); };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      triangles_.emplace_back(point(mesh.corner(t, 0)), point(mesh.corner(t, 1)), point(mesh.corner(t, 2)));
    tree_ = std::make_unique<Tree>(triangles_.cbegin(), triangles_.cend());
    tree_->build();
    tree_->accelerate_distance_queries();
  }
  void distances(const std::vector<partscribe::geometry::Vec3>& queries, std::size_t begin, std::size_t end, bool warm,
                 double* out) const override {
    Kernel::Point_3 hint;
    for (std::size_t i = begin; i < end; ++i) {
      const Kernel::Point_3 q(queries[i].x(), queries[i].y(), queries[i].z());
      hint = warm && i > begin ? tree_->closest_point(q, hint) : tree_->closest_point(q);
      out[i] = std::sqrt(CGAL::squared_distance(q, hint));
    }
  }
  std::size_t bytes() const override { return 0; }

 private:
  Triangles triangles_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace

std::unique_ptr<Peer> cgal(const partscribe::geometry::TriangleMesh& mesh) { return std::make_unique<Cgal>(mesh); }

}  // namespace peers
#else
namespace peers {
std::unique_ptr<Peer> cgal(const partscribe::geometry::TriangleMesh&) { return nullptr; }
}  // namespace peers
#endif
