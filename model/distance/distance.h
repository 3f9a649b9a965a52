/// Exact signed distance from a point to a model, and which of its faces is nearest.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/model.h"

namespace partscribe::model {

/// The nearest place on the model's surface.
struct ModelHit {
  double distance = 0;  ///< mm; negative inside
  int face = -1;        ///< index into ModelDistance::faces()
};

/// A face that a person can name: "hole 2", "shank", "top".
struct ModelFace {
  std::string name;     ///< unique in the model: "holes 3 wall"
  std::string object;   ///< the object of the model whose shape it belongs to: "hole"
  std::string feature;  ///< that object, or which copy of it by the pattern or mirror that made it: "holes 3"
};

/// Built from a model's values; queries may run on many threads. Points are in the scan's frame when
/// `model.as_scanned`, in the part's otherwise.
///
/// The distance is that to the surface which the whole tree leaves: faces inside other bodies, or where bodies touch,
/// do not count. It is exact for single shapes, and for trees where the nearest point lies on a face or on the curve
/// or corner in which faces of two or three bodies meet.
class ModelDistance {
 public:
  /// `like`: of the same model at other values; solids that these values do not change are not built again.
  ModelDistance(const Model& model, const Values& values, const ModelDistance* like = nullptr);
  explicit ModelDistance(const Model& model);
  ~ModelDistance();
  ModelDistance(ModelDistance&&) noexcept;

  ModelHit operator()(const Vec3& point) const;
  /// Signed, no larger than the distance, and several times faster for trees; 0 also on faces inside other bodies.
  double bound(const Vec3& point) const;
  const std::vector<ModelFace>& faces() const;
  /// Holds the surface, in the frame of the points; often too large.
  Box3 bounds() const;

  struct Tree;  ///< defined in tree.h

 private:
  std::unique_ptr<Tree> tree_;
  std::vector<ModelFace> faces_;
};

}  // namespace partscribe::model
