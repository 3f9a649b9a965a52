/// Other programs' fits behind one interface; a program that was not installed at build time returns nothing.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "geometry/surfaces/primitive_fit.h"

namespace peers {

using Fit = std::function<std::optional<partscribe::geometry::Primitive>()>;

/// One question to all contestants.
struct Question {
  partscribe::geometry::PrimitiveKind kind;
  const std::vector<partscribe::geometry::Vec3>& points;
  partscribe::geometry::Primitive start;
};

/// Prepares a question in a program's own structures; calling the answer fits. Empty: the program has no such fit.
using Prepare = std::function<Fit(const Question&)>;

struct Peer {
  const char* name;
  Prepare prepare;  ///< empty: not installed
};

Prepare ceres_fits();
Prepare pcl_fits();
Prepare cgal_fits();
Prepare gte_fits();
Prepare gte_minimizer_fits();  ///< GeometricTools with its Gauss-Newton or Levenberg-Marquardt minimizers

}  // namespace peers
