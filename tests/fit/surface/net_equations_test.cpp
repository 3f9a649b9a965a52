#include "fit/surface/net_equations.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "fit/surface/knot_choice.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

const KnotVector fine_u = clamped(3, {0, 4, 7, 10, 15, 20, 24, 30}), fine_v = clamped(3, {0, 5, 10, 12, 16, 20});
const KnotVector coarse_u = clamped(3, {0, 7, 20, 30}), coarse_v = clamped(3, {0, 12, 20});

struct Scattered {
  std::vector<Vec3> points;
  std::vector<Vec2> places;
};

template <class Height>
Scattered scattered(std::size_t count, const Height& height) {
  Random random(7);
  Scattered result;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = 30 * random.uniform(), y = 20 * random.uniform();
    result.points.emplace_back(x, y, height(x, y)), result.places.emplace_back(x, y);
  }
  return result;
}

const auto wave = [](double x, double y) { return 3 * std::sin(x / 5) * std::cos(y / 7); };

}  // namespace

TEST_CASE("net equations: a restriction is what knot insertion makes of a net") {
  Random random(3);
  NurbsSurface surface{coarse_u, coarse_v, {}, {}};
  for (int i = 0; i < coarse_u.count() * coarse_v.count(); ++i)
    surface.points.emplace_back(random.normal(), random.normal(), random.normal());
  NurbsSurface inserted = surface;
  for (const double t : {4.0, 10.0, 15.0, 24.0}) inserted = with_knot(inserted, true, t);
  REQUIRE(inserted.u == fine_u);
  const auto r = restriction(fine_u, coarse_u);
  const int columns = coarse_v.count();
  for (int p = 0; p < fine_u.count(); ++p)
    for (int j = 0; j < columns; ++j) {
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        sum +=
            r.share[std::size_t(4 * p + k)] * surface.points[std::size_t((r.first[std::size_t(p)] + k) * columns + j)];
      CHECK((sum - inserted.points[std::size_t(p * columns + j)]).norm() < 1e-12);
    }
}

TEST_CASE("net equations: a restriction at multiple knots, whose columns go up one by one") {
  const KnotVector fine = clamped(3, {0, 3, 7, 7, 7, 9, 12, 12, 20, 30});
  for (const KnotVector& coarse : {clamped(3, {0, 7, 7, 7, 30}), clamped(3, {0, 7, 12, 12, 30}), clamped(3, {0, 30}),
                                   clamped(3, {0, 3, 7, 7, 20, 30}), fine}) {
    Random random(4);
    NurbsCurve<3> curve{coarse, {}, {}};
    for (int i = 0; i < coarse.count(); ++i)
      curve.points.emplace_back(random.normal(), random.normal(), random.normal());
    NurbsCurve<3> inserted = curve;
    for (const double t : {3.0, 7.0, 9.0, 12.0, 20.0}) {
      const auto times = [t](const KnotVector& knots) { return std::count(knots.knots.begin(), knots.knots.end(), t); };
      inserted = with_knot(inserted, t, int(times(fine) - times(coarse)));
    }
    REQUIRE(inserted.t == fine);
    const auto r = restriction(fine, coarse);
    for (int p = 0; p < fine.count(); ++p) {
      const int first = r.first[std::size_t(p)];
      REQUIRE((first >= 0 && first + 4 <= coarse.count()));
      if (p > 0) CHECK((first - r.first[std::size_t(p - 1)] == 0 || first - r.first[std::size_t(p - 1)] == 1));
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k) sum += r.share[std::size_t(4 * p + k)] * curve.points[std::size_t(first + k)];
      CHECK((sum - inserted.points[std::size_t(p)]).norm() < 1e-12);
    }
  }
}

TEST_CASE("net equations: coarse nets are those of dense least squares over the points") {
  const auto data = scattered(900, wave);
  std::vector<double> weights;
  for (std::size_t i = 0; i < data.points.size(); ++i) weights.push_back(1 + double(i % 3));
  NetEquations equations(fine_u, fine_v);
  equations.add(data.points, data.places, weights);
  // In turn, so that halves are taken over in both directions.
  for (const auto& [u, v] : {std::pair(coarse_u, coarse_v), std::pair(coarse_u, fine_v), std::pair(fine_u, fine_v),
                             std::pair(coarse_u, fine_v)}) {
    const auto fit = equations.solve(u, v, 1e-12);
    REQUIRE(fit);
    const int unknowns = u.count() * v.count();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(Eigen::Index(data.points.size()), unknowns);
    Eigen::MatrixX3d right(rows.rows(), 3);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      BasisValues nu, nv;
      basis(u, data.places[std::size_t(i)].x(), 0, nu), basis(v, data.places[std::size_t(i)].y(), 0, nv);
      const double root = std::sqrt(weights[std::size_t(i)]);
      for (int k = 0; k < 4; ++k)
        for (int l = 0; l < 4; ++l)
          rows(i, (nu.first + k) * v.count() + nv.first + l) = root * nu.value[0][k] * nv.value[0][l];
      right.row(i) = root * data.points[std::size_t(i)].transpose();
    }
    const Eigen::MatrixX3d net = rows.colPivHouseholderQr().solve(right);
    for (int i = 0; i < unknowns; ++i) CHECK((net.row(i).transpose() - fit->points[std::size_t(i)]).norm() < 1e-6);
  }
}

TEST_CASE("net equations: what is left are weighted means of signed distances") {
  // A plane 0.3 mm below the points.
  const auto data = scattered(4000, [](double, double) { return 0.3; });
  NetEquations equations(fine_u, fine_v);
  equations.add(data.points, data.places, {});
  NurbsSurface plane{clamped(3, {0, 30}), clamped(3, {0, 20}), {}, {}};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) plane.points.emplace_back(10.0 * i, 20.0 / 3 * j, 0);
  const auto left = equations.left(plane);
  for (std::size_t i = 0; i < left.mean.size(); ++i) CHECK(left.mean[i] == Approx(0.3));
  // A function in the middle weighs points over cells of about 4 x 4 mm, of which 6.7 lie in a square millimetre.
  CHECK(*std::max_element(left.points.begin(), left.points.end()) > 300);
  CHECK(left_over(equations, plane, 10) == Approx(0.3));
  CHECK(left_over(equations, plane, 1e6) == 0);
}

TEST_CASE("knot choice: knots go where they are needed, and few of them") {
  const auto step = [](double x, double) { return 2 * std::tanh((x - 21) / 1.5); };
  const auto data = scattered(20000, step);
  std::vector<double> lines;
  for (int i = 0; i <= 60; ++i) lines.push_back(0.5 * i);
  std::vector<double> across;
  for (int i = 0; i <= 10; ++i) across.push_back(2.0 * i);
  NetEquations equations(clamped(3, lines), clamped(3, across));
  equations.add(data.points, data.places, {});
  // A start with knots everywhere.
  std::vector<double> many;
  for (int i = 0; i <= 30; ++i) many.push_back(i);
  const auto start = equations.solve(clamped(3, many), clamped(3, across), 1e-6);
  REQUIRE(start);
  KnotChoiceOptions options;
  options.allowed = 0.02, options.averaged = 3;
  REQUIRE(left_over(equations, *start, options.averaged) < options.allowed);
  const auto [u, v] = fewest_knots(equations, *start, options);
  CHECK(v.count() == 4);
  CHECK(u.count() < 17);
  const auto fit = equations.solve(u, v, options.fairness);
  REQUIRE(fit);
  CHECK(left_over(equations, *fit, options.averaged) <= options.allowed);
  std::size_t near = 0;
  const auto used = u.breaks();
  for (const double t : used) near += std::abs(t - 21) < 5;
  CHECK(near + 4 >= used.size());
  // The other way round as well.
  const auto jumps = knots_by_jump(*start);
  CHECK(std::abs(jumps.back().at - 21) < 3);
  CHECK(jumps.back().along_u);
}

TEST_CASE("knot choice: a start that needs all of its knots keeps them") {
  const auto data = scattered(20000, wave);
  NetEquations equations(clamped(3, {0, 5, 10, 15, 20, 25, 30}), clamped(3, {0, 5, 10, 15, 20}));
  equations.add(data.points, data.places, {});
  const auto start = equations.solve(equations.u(), equations.v(), 1e-6);
  REQUIRE(start);
  KnotChoiceOptions options;
  options.allowed = 1e-6;
  const auto [u, v] = fewest_knots(equations, *start, options);
  CHECK(u == equations.u());
  CHECK(v == equations.v());
}
