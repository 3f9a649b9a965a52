#include "fit/surface/line_basis.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::core;
using namespace partscribe::geometry;
using namespace partscribe::fit;

namespace {

std::vector<double> uneven_lines(std::size_t count) {
  Random random(5);
  std::vector<double> lines;
  for (std::size_t i = 0; i < count; ++i) lines.push_back(10 * (double(i) + 0.8 * random.uniform()) / double(count));
  return lines;
}

/// A row of basis functions for each line, by the recursion for any degree.
Eigen::MatrixXd rows_of(const std::vector<double>& lines, const KnotVector& knots) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(Eigen::Index(lines.size()), knots.count());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    BasisValues n;
    basis(knots, lines[i], 0, n);
    for (int k = 0; k < 4; ++k) rows(Eigen::Index(i), n.first + k) = n.value[0][k];
  }
  return rows;
}

const KnotVector with_triple = clamped(3, {0, 1.5, 4, 4, 4, 6, 6, 8, 10});

}  // namespace

TEST_CASE("line basis: splines nearest to values are those of dense least squares, at multiple knots as well") {
  const auto lines = uneven_lines(60);
  Random random(9);
  const Eigen::MatrixXd values = Eigen::MatrixXd::NullaryExpr(60, 3, [&] { return random.normal(); });
  std::vector<double> flat;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 3; ++k) flat.push_back(values(i, k));
  const auto found = LineBasis(lines, with_triple).nearest(flat, 3);
  const Eigen::MatrixXd net = rows_of(lines, with_triple).colPivHouseholderQr().solve(values);
  REQUIRE(found.size() == std::size_t(net.size()));
  for (int i = 0; i < net.rows(); ++i)
    for (int k = 0; k < 3; ++k) CHECK(found[std::size_t(3 * i + k)] == Approx(net(i, k)).margin(1e-6));
}

TEST_CASE("line basis: the share of a knot is a unit and orthogonal to all splines without it") {
  const auto lines = uneven_lines(80);
  const LineBasis basis(lines, with_triple);
  for (const double t : {1.5, 4.0, 6.0, 8.0}) {
    const auto share = basis.share_of(t);
    Eigen::VectorXd at = Eigen::VectorXd::Zero(80);
    for (std::size_t i = share.begin; i < share.end; ++i) at[Eigen::Index(i)] = share.values[i - share.begin];
    CHECK(at.norm() == Approx(1).margin(1e-3));
    KnotVector fewer = with_triple;
    fewer.knots.erase(std::find(fewer.knots.begin(), fewer.knots.end(), t));
    const Eigen::MatrixXd rows = rows_of(lines, fewer);
    CHECK((rows.transpose() * at).norm() < 0.02 * rows.norm());
    // It is a spline with the knot.
    const Eigen::MatrixXd all = rows_of(lines, with_triple);
    CHECK((all * all.colPivHouseholderQr().solve(at) - at).norm() < 0.02);
    // One of another knot is not orthogonal to them.
    if (t == 1.5) CHECK((rows_of(lines, with_triple).transpose() * at).norm() > 0.1);
  }
}

TEST_CASE("line basis: what a neighbour knows already changes nothing") {
  const auto lines = uneven_lines(80);
  const KnotVector moved = clamped(3, {0, 1.5, 4, 4, 4, 6, 6, 8.7, 10});
  std::vector<double> values;
  for (const double t : lines) values.push_back(t * t * (7 - t));
  const LineBasis before(lines, with_triple);
  CHECK(LineBasis(lines, moved, before).nearest(values, 1) == LineBasis(lines, moved).nearest(values, 1));
  CHECK(LineBasis(lines, clamped(3, {0, 5, 10}), before).nearest(values, 1) ==
        LineBasis(lines, clamped(3, {0, 5, 10})).nearest(values, 1));
}
