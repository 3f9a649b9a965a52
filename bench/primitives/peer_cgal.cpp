// CGAL's closed forms for planes and lines.
#include "peers.h"

#if __has_include(<CGAL/linear_least_squares_fitting_3.h>)
#include <CGAL/Simple_cartesian.h>
#include <CGAL/linear_least_squares_fitting_3.h>

namespace peers {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using partscribe::geometry::Primitive;
using partscribe::geometry::PrimitiveKind;
using partscribe::geometry::Vec3;

Fit prepare(const Question& question) {
  const PrimitiveKind kind = question.kind;
  if (kind != PrimitiveKind::plane && kind != PrimitiveKind::line) return {};
  auto points = std::make_shared<std::vector<Kernel::Point_3>>();
  for (const Vec3& q : question.points) points->emplace_back(q.x(), q.y(), q.z());
  return [points, kind]() -> std::optional<Primitive> {
    Primitive p;
    p.kind = kind;
    Kernel::Point_3 center;
    const auto vec = [](const auto& v) { return Vec3(v.x(), v.y(), v.z()).normalized(); };
    if (kind == PrimitiveKind::plane) {
      Kernel::Plane_3 plane;
      CGAL::linear_least_squares_fitting_3(points->begin(), points->end(), plane, center, CGAL::Dimension_tag<0>());
      p.axis = vec(plane.orthogonal_vector());
    } else {
      Kernel::Line_3 line;
      CGAL::linear_least_squares_fitting_3(points->begin(), points->end(), line, center, CGAL::Dimension_tag<0>());
      p.axis = vec(line.to_vector());
    }
    p.point = Vec3(center.x(), center.y(), center.z());
    return p;
  };
}

}  // namespace

Prepare cgal_fits() { return prepare; }

}  // namespace peers
#else
namespace peers {
Prepare cgal_fits() { return {}; }
}  // namespace peers
#endif
