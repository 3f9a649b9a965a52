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
  std::string name;    ///< unique in the model
  std::string object;  ///< the object it belongs to
};

/// Built once from a model's values; queries may run on many threads. Points are in the scan's frame when
/// `model.as_scanned`, in the part's otherwise. The distance is exact for every single shape; for unions,
/// differences and intersections its zero set is exact and its size a lower bound.
class ModelDistance {
 public:
  ModelDistance(const Model& model, const Values& values);
  explicit ModelDistance(const Model& model);
  ~ModelDistance();
  ModelDistance(ModelDistance&&) noexcept;

  ModelHit operator()(const Vec3& point) const;
  const std::vector<ModelFace>& faces() const;

  struct Node;  ///< one evaluated object; defined in the .cpp

 private:
  std::unique_ptr<Node> root_;
  Pose part_from_scan_;
  std::vector<ModelFace> faces_;
};

}  // namespace partscribe::model
