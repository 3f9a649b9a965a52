#include "scan/register/as_published/primitives.h"

#include <algorithm>
#include <cmath>

namespace partscribe::scan {
namespace {

class PatchPrimitives : public PublishedModel {
 public:
  explicit PatchPrimitives(const PaperOptions& options) : options_(options) {}

  void add(const ViewSurface& surface, const Pose& pose) override {
    for (const Patch& patch : planar_patches(surface, options_)) {
      const Vec3 center = pose * patch.center, normal = pose.rotation * patch.normal;
      for (const auto i : patch.members) {
        const Vec3 member = pose * surface.points[i];
        members_.push_back(member - normal.dot(member - center) * normal);
        owner_.push_back(static_cast<std::uint32_t>(center_.size()));
      }
      center_.push_back(center), normal_.push_back(normal), reach_.push_back(2 * surface.spacing);
    }
    tree_.emplace(members_);
  }

  ClosestPoint closest(const Vec3& p) const override {
    // Of which patch: members lie on its plane, a spacing apart.
    const std::uint32_t nearest = tree_->nearest_one(p).index, k = owner_[nearest];
    const Vec3 foot = p - normal_[k].dot(p - center_[k]) * normal_[k];
    const bool inside = (foot - members_[nearest]).norm() <= reach_[k];
    return {inside ? foot : members_[nearest], normal_[k]};
  }

  std::size_t primitives() const override { return center_.size(); }

 private:
  PaperOptions options_;
  std::vector<Vec3> center_, normal_;  // of each patch
  std::vector<double> reach_;          // mm beyond its outermost points
  std::vector<Vec3> members_;
  std::vector<std::uint32_t> owner_;  // patch of each member
  std::optional<KdTree> tree_;
};

class TrianglePrimitives : public PublishedModel {
 public:
  explicit TrianglePrimitives(const PaperOptions& options) : options_(options) {}

  void add(const ViewSurface& surface, const Pose& pose) override {
    constexpr double vertices = 3000;  // of a view: triangles are small against those that the points come from
    const auto smooth = static_cast<double>(std::count(surface.smooth.begin(), surface.smooth.end(), 1));
    const TriangleMesh view =
        transformed(triangulated_view(surface, std::max(1.5, std::sqrt(smooth / vertices))), pose);
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    std::vector<std::array<std::uint32_t, 3>> missing;
    for (std::size_t t = 0; t < view.triangles.size(); ++t)
      if (mesh_.empty() || !is_there(view, t))
        missing.push_back({first + view.triangles[t][0], first + view.triangles[t][1], first + view.triangles[t][2]});
    mesh_.vertices.insert(mesh_.vertices.end(), view.vertices.begin(), view.vertices.end());
    mesh_.triangles.insert(mesh_.triangles.end(), missing.begin(), missing.end());
    distance_.emplace(mesh_);
  }

  ClosestPoint closest(const Vec3& p) const override {
    const MeshHit hit = distance_->closest(p);
    return {hit.point, triangle_normal(mesh_, hit.triangle)};
  }

  std::size_t primitives() const override { return mesh_.triangles.size(); }

 private:
  /// The triangle's middle lies on the model: well within its own size, and facing the same way.
  bool is_there(const TriangleMesh& view, std::size_t t) const {
    const Vec3 center = (view.corner(t, 0) + view.corner(t, 1) + view.corner(t, 2)) / 3;
    const double near = 0.3 * (view.corner(t, 0) - center).norm();
    const auto hit = distance_->closest_within(center, near);
    return hit && triangle_normal(mesh_, hit->triangle).dot(triangle_normal(view, t)) > std::cos(options_.normal_angle);
  }

  PaperOptions options_;
  TriangleMesh mesh_;
  std::optional<MeshDistance> distance_;
};

}  // namespace

std::unique_ptr<PublishedModel> model_of_patches(const PaperOptions& options) {
  return std::make_unique<PatchPrimitives>(options);
}

std::unique_ptr<PublishedModel> model_of_triangles(const PaperOptions& options) {
  return std::make_unique<TrianglePrimitives>(options);
}

}  // namespace partscribe::scan
