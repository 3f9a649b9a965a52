#include "geometry/normals/weighted_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "geometry/vec.h"

using namespace partscribe::geometry;

namespace {

/// Eight points and their neighbours in no order, on a bent sheet with noise.
struct Sheet {
  std::vector<PlaneNode> nodes;
  std::vector<std::uint32_t> links;
  std::vector<double> sq_reach;
  std::size_t rows;

  Sheet(std::size_t count, std::size_t neighbours, double noise, std::uint64_t seed) : rows(neighbours) {
    Random random(seed);
    nodes.resize(count + 1);
    for (std::size_t i = 0; i < count; ++i) {
      PlaneNode& n = nodes[i];
      n.x = random.uniform(-1, 1), n.y = random.uniform(-1, 1),
      n.z = 0.3 * n.x * n.x + 0.1 * n.y + noise * random.normal();
      n.weight = 1 + static_cast<double>(i % 3), n.spread = 0.02 * static_cast<double>(i % 5);
      const Vec3 normal = Vec3(random.normal(), random.normal(), 5).normalized() * (i % 7 == 3 ? -1 : 1);
      n.nx = normal.x(), n.ny = normal.y(), n.nz = normal.z();
    }
    for (std::size_t k = 0; k < plane_block * neighbours; ++k)
      links.push_back(static_cast<std::uint32_t>(k < plane_block ? k : k % 5 == 4 ? count : random.below(count)));
    for (std::size_t i = 0; i < plane_block; ++i) sq_reach.push_back(0.5 + 0.1 * static_cast<double>(i));
  }
  PlaneBlock block() const { return {nodes.data(), 0, links.data(), rows}; }
  const PlaneNode& neighbour(std::size_t i, std::size_t k) const { return nodes[links[plane_block * k + i]]; }
};

Vec3 place(const PlaneNode& n) { return {n.x, n.y, n.z}; }
Vec3 normal(const PlaneNode& n) { return {n.nx, n.ny, n.nz}; }

Mat3 covariance(const Sheet& sheet, const PlaneWeights& rule, std::size_t i) {
  const PlaneNode& own = sheet.nodes[i];
  std::vector<double> weights;
  Vec3 mean = Vec3::Zero();
  double sum = 0;
  for (std::size_t k = 0; k < sheet.rows; ++k) {
    const PlaneNode& other = sheet.neighbour(i, k);
    const Vec3 d = place(other) - place(own);
    double w = other.weight * std::exp(-d.squaredNorm() / (0.6 * rule.sq_reach[i]));
    if (!rule.first) {
      const double along = normal(own).dot(normal(other));
      const double off = normal(own).dot(d) / std::max(rule.least_width, own.spread);
      w *= std::pow(rule.two_sided ? std::abs(along) : std::max(along, 0.0), 4) * std::exp(-0.5 * off * off);
    }
    weights.push_back(w), sum += w, mean += w * d;
  }
  mean /= sum;
  Mat3 result = Mat3::Zero();
  for (std::size_t k = 0; k < sheet.rows; ++k) {
    const Vec3 d = place(sheet.neighbour(i, k)) - place(own) - mean;
    result += weights[k] / sum * d * d.transpose();
  }
  return result;
}

}  // namespace

TEST_CASE("weighted planes: every direction is the eigenvector of the weighted covariances") {
  int with = 0, without = 0;
  for (const double noise : {0.0, 0.01, 0.5})
    for (const bool first : {true, false})
      for (const bool two_sided : {true, false})
        for (const std::uint64_t seed : {1u, 2u, 3u}) {
          const Sheet sheet(60, 40, noise, seed);
          const PlaneWeights rule{sheet.sq_reach.data(), 0.05, first, two_sided};
          FoundPlanes found;
          weighted_planes(sheet.block(), rule, found);
          for (std::size_t i = 0; i < plane_block; ++i) {
            const Eigen::SelfAdjointEigenSolver<Mat3> eigen(covariance(sheet, rule, i));
            const Vec3 v(found.x[i], found.y[i], found.z[i]);
            INFO("noise " << noise << ", first " << first << ", two sides " << two_sided << ", seed " << seed
                          << ", point " << i);
            // Turned against all its neighbours, a point has nobody but itself.
            if (!(eigen.eigenvalues()[1] > 1e-12 * eigen.eigenvalues()[2])) {
              CHECK(std::isnan(v.x()));
              ++without;
              continue;
            }
            ++with;
            CHECK(v.norm() == Approx(1).epsilon(1e-12));
            CHECK(v.cwiseAbs().maxCoeff() == v.maxCoeff());
            // How well the direction is fixed at all falls with the distance of the two least eigenvalues.
            const double apart = 1 - eigen.eigenvalues()[0] / eigen.eigenvalues()[1];
            if (apart > 0.05) CHECK(v.cross(eigen.eigenvectors().col(0)).norm() < 2e-6 / apart);
            CHECK(found.spread[i] ==
                  Approx(std::sqrt(std::max(eigen.eigenvalues()[0], 0.0))).epsilon(1e-3).margin(1e-7));
          }
        }
  CHECK(with > 20 * without);
}

TEST_CASE("weighted planes: points of a plane without noise give its normal, and points on a line none") {
  Sheet sheet(60, 30, 0, 4);
  const Vec3 truth = Vec3(1, -2, 4).normalized();
  for (const bool line : {false, true}) {
    for (PlaneNode& n : sheet.nodes) {
      if (line)
        n.x = 1000 + n.x, n.y = 2 * n.x, n.z = 3 * n.x;
      else
        n.z = (2 * n.y - n.x) / 4;
      n.weight = n.weight > 0, n.spread = 0, n.nx = truth.x(), n.ny = truth.y(), n.nz = truth.z();
    }
    for (const bool first : {true, false}) {
      FoundPlanes found;
      weighted_planes(sheet.block(), {sheet.sq_reach.data(), 0, first, true}, found);
      for (std::size_t i = 0; i < plane_block; ++i) {
        if (line)
          CHECK(std::isnan(found.x[i]));
        else
          CHECK((Vec3(found.x[i], found.y[i], found.z[i]) - truth).norm() < 1e-8);
      }
    }
  }
}

TEST_CASE("weighted planes: every set of instructions answers the same to the bit") {
  for (const auto instructions : {Instructions::avx2, Instructions::avx512}) {
    if (instructions > widest_instructions()) continue;
    for (const double noise : {0.0, 0.01, 0.5})
      for (const bool first : {true, false}) {
        const Sheet sheet(60, 40, noise, 7);
        FoundPlanes plain, found;
        weighted_planes(sheet.block(), {sheet.sq_reach.data(), 0.05, first, true}, plain, Instructions::baseline);
        weighted_planes(sheet.block(), {sheet.sq_reach.data(), 0.05, first, true}, found, instructions);
        double plain_support[plane_block], support[plane_block];
        count_support(sheet.block(), {0.1, 0.05, first, 100}, plain_support, Instructions::baseline);
        count_support(sheet.block(), {0.1, 0.05, first, 100}, support, instructions);
        for (std::size_t i = 0; i < plane_block; ++i) {
          const auto same = [](double a, double b) {
            return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
          };
          CHECK((same(plain.x[i], found.x[i]) && same(plain.y[i], found.y[i]) && same(plain.z[i], found.z[i])));
          CHECK(same(plain.spread[i], found.spread[i]));
          CHECK(same(plain_support[i], support[i]));
        }
      }
  }
}

TEST_CASE("weighted planes: support is counted as the rule says, point by point") {
  for (const bool either : {true, false}) {
    const Sheet sheet(60, 13, 0.1, 5);
    const SupportRule rule{0.1, 0.05, either, 100};
    double support[plane_block];
    count_support(sheet.block(), rule, support);
    double all = 0;
    for (std::size_t i = 0; i < plane_block; ++i) {
      int expected = 0;
      for (std::size_t k = 1; k < sheet.rows; ++k) {
        const PlaneNode &own = sheet.nodes[i], &other = sheet.neighbour(i, k);
        const Vec3 d = place(other) - place(own);
        const double along = normal(own).dot(normal(other));
        const Vec3 mean = (normal(other) + (along < 0 ? -1 : 1) * normal(own)).normalized();
        double off = std::abs(d.dot(std::abs(along) > 0.7 ? mean : normal(other)));
        if (either) off = std::min({off, std::abs(d.dot(normal(own))), std::abs(d.dot(normal(other)))});
        expected += off <= rule.tolerance + rule.slope * d.norm();
      }
      CHECK(support[i] == expected);
      all += support[i];
    }
    double enough[plane_block];
    count_support(sheet.block(), {0.1, 0.05, either, 3}, enough);
    for (std::size_t i = 0; i < plane_block; ++i) CHECK((enough[i] >= 3) == (support[i] >= 3));
    CHECK(all > 10);
    CHECK(all < 12 * 8 - 10);
  }
}
