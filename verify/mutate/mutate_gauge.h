/// Measures by how much a damaged model differs from the true one; for the .cpp files behind mutate.h only.
#pragma once

#include "model/distance/distance.h"
#include "verify/mutate/mutate.h"

namespace partscribe::verify {

/// The box around a model's surface, in the frame of ModelDistance.
Box3 bounds_of(const Model& model, const ModelDistance& distance);

bool passes_check(const Model& model);

/// Measures damages of one model, which must outlive it.
class Gauge {
 public:
  explicit Gauge(const Model& model);

  const Box3& box() const { return box_; }
  const ModelDistance& distance() const { return distance_; }
  /// Even places on the true surface.
  const std::vector<PlaceOnPart>& points() const { return points_; }

  /// At least 1/200 of the true surface is so far from the surface of `damaged`.
  double moved(const Model& damaged) const;
  /// The same, or 1/400 of the damaged surface is so far from the true one.
  double moved_either(const Model& damaged) const;
  /// True if both describe the same surface.
  bool same(const Model& damaged) const;

 private:
  ModelDistance distance_;
  std::vector<PlaceOnPart> points_;
  Box3 box_;
};

}  // namespace partscribe::verify
