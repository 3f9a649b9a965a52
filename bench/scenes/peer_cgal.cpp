// CGAL's Efficient RANSAC and its region growing (planes).
#include "core/number.h"
#include "peers.h"

#if __has_include(<CGAL/Shape_detection/Efficient_RANSAC.h>)
#include <CGAL/Random.h>
#include <CGAL/Shape_detection/Efficient_RANSAC.h>
#include <CGAL/Shape_detection/Region_growing/Region_growing.h>
#include <CGAL/Shape_detection/Region_growing/Region_growing_on_point_set.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>

namespace bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using PointWithNormal = std::tuple<Kernel::Point_3, Kernel::Vector_3, std::uint32_t>;  // the last: which point it is
using Points = std::vector<PointWithNormal>;
using PointMap = CGAL::Nth_of_tuple_property_map<0, PointWithNormal>;
using NormalMap = CGAL::Nth_of_tuple_property_map<1, PointWithNormal>;

Vec3 vec(const auto& v) { return {v.x(), v.y(), v.z()}; }

Points with_normals(const Question& question, Answer& answer) {
  Points points;
  for (const Vec3& p : question.cloud.points)
    points.emplace_back(Kernel::Point_3(p.x(), p.y(), p.z()), Kernel::Vector_3(),
                        static_cast<std::uint32_t>(points.size()));
  const double before = processor_seconds();
  CGAL::pca_estimate_normals<CGAL::Sequential_tag>(points, 18,
                                                   CGAL::parameters::point_map(PointMap()).normal_map(NormalMap()));
  answer.normals = processor_seconds() - before;
  return points;
}

namespace sd = CGAL::Shape_detection;
using Traits = sd::Efficient_RANSAC_traits<Kernel, Points, PointMap, NormalMap>;

/// Detection puts the points in another order.
FoundShape taken(const sd::Shape_base<Traits>& shape, const Points& points) {
  FoundShape found;
  Primitive p;
  if (const auto* plane = dynamic_cast<const sd::Plane<Traits>*>(&shape)) {
    p.kind = PrimitiveKind::plane, p.axis = vec(plane->plane_normal()).normalized();
    p.point = -plane->d() / vec(plane->plane_normal()).norm() * p.axis;
  } else if (const auto* cylinder = dynamic_cast<const sd::Cylinder<Traits>*>(&shape)) {
    p.kind = PrimitiveKind::cylinder, p.radius = cylinder->radius();
    p.point = vec(cylinder->axis().point()), p.axis = vec(cylinder->axis().to_vector()).normalized();
  } else if (const auto* sphere = dynamic_cast<const sd::Sphere<Traits>*>(&shape)) {
    p.kind = PrimitiveKind::sphere, p.point = vec(sphere->center()), p.radius = sphere->radius();
  } else if (const auto* cone = dynamic_cast<const sd::Cone<Traits>*>(&shape)) {
    p.kind = PrimitiveKind::cone, p.half_angle = cone->angle(), p.axis = vec(cone->axis()).normalized();
    p.point = vec(cone->apex());
  } else if (const auto* torus = dynamic_cast<const sd::Torus<Traits>*>(&shape)) {
    p.kind = PrimitiveKind::torus, p.point = vec(torus->center()), p.axis = vec(torus->axis()).normalized();
    p.radius = torus->major_radius(), p.tube = torus->minor_radius();
  }
  found.kind = face_kind(p.kind), found.surface = p;
  for (const auto i : shape.indices_of_assigned_points()) found.points.push_back(std::get<2>(points[i]));
  return found;
}

struct Setting {
  double epsilon;  // sigmas
  double normal;   // degrees
  std::size_t least;
};

Contestant ransac(const Setting& setting) {
  const auto answer = [setting](const Question& question, Context&) -> std::optional<Answer> {
    Answer answer;
    Points points = with_normals(question, answer);
    CGAL::get_default_random() = CGAL::Random(static_cast<unsigned>(question.seed));
    const double before = processor_seconds();
    sd::Efficient_RANSAC<Traits> detector;
    detector.set_input(points);
    detector.add_shape_factory<sd::Plane<Traits>>();
    detector.add_shape_factory<sd::Sphere<Traits>>();
    detector.add_shape_factory<sd::Cylinder<Traits>>();
    detector.add_shape_factory<sd::Cone<Traits>>();
    detector.add_shape_factory<sd::Torus<Traits>>();
    sd::Efficient_RANSAC<Traits>::Parameters parameters;
    parameters.probability = 0.01;
    parameters.min_points = setting.least;
    parameters.epsilon = setting.epsilon * question.sigma;
    parameters.cluster_epsilon = 5 * question.spacing;
    parameters.normal_threshold = std::cos(radians(setting.normal));
    detector.detect(parameters);
    for (const auto& shape : detector.shapes()) answer.shapes.push_back(taken(*shape, points));
    answer.seconds = processor_seconds() - before;
    return answer;
  };
  return {"CGAL Efficient RANSAC",
          "within " + std::to_string(int(setting.epsilon)) + " sigmas and " + std::to_string(int(setting.normal)) +
              " degrees, " + std::to_string(setting.least) + " points",
          5, answer};
}

Contestant growing(const Setting& setting) {
  const auto answer = [setting](const Question& question, Context&) -> std::optional<Answer> {
    using Neighbours = sd::Point_set::K_neighbor_query<Kernel, Points, PointMap>;
    using Region = sd::Point_set::Least_squares_plane_fit_region<Kernel, Points, PointMap, NormalMap>;
    using Sorting = sd::Point_set::Least_squares_plane_fit_sorting<Kernel, Points, Neighbours, PointMap>;
    Answer answer;
    const Points points = with_normals(question, answer);
    const double before = processor_seconds();
    Neighbours neighbours(points, 12);
    Region region(points, setting.epsilon * question.sigma, setting.normal, setting.least);
    Sorting sorting(points, neighbours);
    sorting.sort();
    sd::Region_growing<Points, Neighbours, Region, typename Sorting::Seed_map> grower(points, neighbours, region,
                                                                                      sorting.seed_map());
    std::vector<std::vector<std::size_t>> regions;
    grower.detect(std::back_inserter(regions));
    answer.seconds = processor_seconds() - before;
    for (const auto& members : regions) {
      FoundShape found;
      std::vector<Vec3> places;
      for (const auto i : members)
        found.points.push_back(static_cast<std::uint32_t>(i)), places.push_back(question.cloud.points[i]);
      if (const auto fit = fit_primitive(PrimitiveKind::plane, places, {}, {})) found.surface = fit->primitive;
      answer.shapes.push_back(std::move(found));
    }
    return answer;
  };
  return {"CGAL region growing",
          "within " + std::to_string(int(setting.epsilon)) + " sigmas and " + std::to_string(int(setting.normal)) +
              " degrees, " + std::to_string(setting.least) + " points",
          1, answer};
}

}  // namespace

std::vector<Contestant> cgal() {
  return {ransac({3, 20, 150}), ransac({4, 25, 100}), ransac({5, 25, 200}), growing({3, 20, 150}),
          growing({5, 25, 150})};
}

}  // namespace bench
#else
namespace bench {
std::vector<Contestant> cgal() { return {}; }
}  // namespace bench
#endif
