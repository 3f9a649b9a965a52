// Ceres: one automatically differentiated residual per point, the axis on the unit sphere.
#include "peers.h"

#if __has_include(<ceres/ceres.h>)
#include <ceres/ceres.h>
#include <glog/logging.h>

#include <array>

namespace peers {
namespace {

using partscribe::geometry::Primitive;
using partscribe::geometry::PrimitiveKind;
using partscribe::geometry::Vec3;

struct Distance {
  PrimitiveKind kind;
  Vec3 q;
  template <class T>
  bool operator()(const T* point, const T* axis, const T* size, T* residual) const {
    const T d[3] = {q.x() - point[0], q.y() - point[1], q.z() - point[2]};
    const T h = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
    const T w[3] = {d[0] - h * axis[0], d[1] - h * axis[1], d[2] - h * axis[2]};
    const T rho = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + 1e-300);
    switch (kind) {
      case PrimitiveKind::plane:
        residual[0] = h;
        break;
      case PrimitiveKind::sphere:
        residual[0] = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - size[0];
        break;
      case PrimitiveKind::cylinder:
        residual[0] = rho - size[0];
        break;
      case PrimitiveKind::cone:
        residual[0] = (rho - size[0]) * cos(size[1]) - h * sin(size[1]);
        break;
      case PrimitiveKind::torus:
        residual[0] = sqrt((rho - size[0]) * (rho - size[0]) + h * h) - size[1];
        break;
      default:
        return false;
    }
    return true;
  }
};

struct CircleDistance {
  Vec3 q;
  template <class T>
  bool operator()(const T* point, const T* axis, const T* size, T* residual) const {
    const T d[3] = {q.x() - point[0], q.y() - point[1], q.z() - point[2]};
    const T h = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
    const T w[3] = {d[0] - h * axis[0], d[1] - h * axis[1], d[2] - h * axis[2]};
    residual[0] = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + 1e-300) - size[0];
    residual[1] = h;
    return true;
  }
};

Fit prepare(const Question& question) {
  const PrimitiveKind kind = question.kind;
  if (kind == PrimitiveKind::line) return {};
  struct State {
    std::array<double, 3> point, axis;
    std::array<double, 2> size;
    std::unique_ptr<ceres::Problem> problem = std::make_unique<ceres::Problem>();
  };
  auto state = std::make_shared<State>();
  for (const Vec3& q : question.points) {
    ceres::CostFunction* cost =
        kind == PrimitiveKind::circle
            ? static_cast<ceres::CostFunction*>(
                  new ceres::AutoDiffCostFunction<CircleDistance, 2, 3, 3, 2>(new CircleDistance{q}))
            : new ceres::AutoDiffCostFunction<Distance, 1, 3, 3, 2>(new Distance{kind, q});
    state->problem->AddResidualBlock(cost, nullptr, state->point.data(), state->axis.data(), state->size.data());
  }
  state->problem->SetManifold(state->axis.data(), new ceres::SphereManifold<3>);
  if (kind == PrimitiveKind::sphere) state->problem->SetParameterBlockConstant(state->axis.data());
  if (kind == PrimitiveKind::plane)
    state->problem->SetParameterBlockConstant(state->size.data());
  else if (kind != PrimitiveKind::cone && kind != PrimitiveKind::torus)
    state->problem->SetManifold(state->size.data(), new ceres::SubsetManifold(2, {1}));
  const Primitive start = question.start;
  return [state, start, kind]() -> std::optional<Primitive> {
    for (int i = 0; i < 3; ++i) state->point[i] = start.point[i], state->axis[i] = start.axis[i];
    state->size = {start.radius, kind == PrimitiveKind::torus ? start.tube : start.half_angle};
    FLAGS_minloglevel = 3;  // failed steps are its own affair
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-10;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, state->problem.get(), &summary);
    Primitive p;
    p.kind = kind;
    p.point = Vec3(state->point[0], state->point[1], state->point[2]);
    p.axis = Vec3(state->axis[0], state->axis[1], state->axis[2]);
    p.radius = state->size[0];
    if (kind == PrimitiveKind::torus) p.tube = state->size[1];
    if (kind == PrimitiveKind::cone) p.half_angle = state->size[1];
    return p;
  };
}

}  // namespace

Prepare ceres_fits() { return prepare; }

}  // namespace peers
#else
namespace peers {
Prepare ceres_fits() { return {}; }
}  // namespace peers
#endif
