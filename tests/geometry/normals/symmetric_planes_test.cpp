#include "geometry/normals/symmetric_planes.h"

#include <Eigen/Geometry>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/random.h"

using namespace partscribe::geometry;

namespace {

/// Pairs of oriented points that lie near each other under the rule's pose, most of them.
struct Pairs {
  std::vector<OrientedPoint> source, target;
  std::vector<std::uint32_t> from, to;
  SymmetricRule rule;

  Pairs(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    const auto direction = [&] { return Vec3(random.normal(), random.normal(), random.normal()).normalized(); };
    rule.target_from_source = {rotation_of(0.4 * direction()), Vec3(1, 2, -3)};
    rule.origin = Vec3(1, 1, 1), rule.size = 7, rule.reach = 0.8, rule.wide = 0.3;
    const Pose back = rule.target_from_source.inverse();
    for (std::uint32_t k = 0; k < count; ++k) {
      const Vec3 p(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)), n = direction();
      const Vec3 turned = (n + (k % 6 == 5 ? 3.0 : 0.3) * direction()).normalized();
      target.push_back(oriented_point(p, n));
      source.push_back(
          oriented_point(back * Vec3(p + random.uniform(0, k % 4 == 3 ? 4 : 1) * direction()), back.rotation * turned));
      from.push_back(k), to.push_back(static_cast<std::uint32_t>(k));
    }
    std::swap(from.front(), from.back()), std::swap(to.front(), to.back());
  }

  SymmetricSums sums(Instructions instructions = widest_instructions()) const {
    SymmetricSums result;
    add_symmetric(source.data(), target.data(), from.data(), to.data(), from.size(), rule, result, instructions);
    return result;
  }
};

/// As the header writes it.
SymmetricSums by_hand(const Pairs& pairs) {
  SymmetricSums result;
  const SymmetricRule& rule = pairs.rule;
  for (std::size_t k = 0; k < pairs.from.size(); ++k) {
    const OrientedPoint &a = pairs.source[pairs.from[k]], &b = pairs.target[pairs.to[k]];
    const Vec3 x = rule.target_from_source * Vec3(a.x, a.y, a.z),
               nx = rule.target_from_source.rotation * Vec3(a.nx, a.ny, a.nz), ny(b.nx, b.ny, b.nz);
    const Vec3 d = x - Vec3(b.x, b.y, b.z), n = (nx + ny).normalized();
    const double e = d.dot(n);
    if (d.norm() > 3 * rule.reach || nx.dot(ny) < rule.least_cosine) continue;
    const double w = std::exp(-d.squaredNorm() / (2 * rule.reach * rule.reach) - e * e / (2 * rule.wide * rule.wide));
    Eigen::Matrix<double, 6, 1> row;
    row << (x - 0.5 * d - rule.origin).cross(n) / rule.size, n;
    std::size_t at = 0;
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j) result.values[at++] += w * row[i] * row[j];
    for (int i = 0; i < 6; ++i) result.values[at++] -= w * e * row[i];
    result.values[at] += w;
  }
  return result;
}

}  // namespace

TEST_CASE("symmetric planes: sums are those of the definition, whatever the number of pairs") {
  for (const std::size_t count : {1, 7, 8, 9, 300}) {
    const Pairs pairs(count, count);
    const SymmetricSums found = pairs.sums(), expected = by_hand(pairs);
    for (std::size_t v = 0; v < found.values.size(); ++v)
      CHECK(std::abs(found.values[v] - expected.values[v]) < 1e-6 * (1 + std::abs(expected.values[v])));
  }
  CHECK(by_hand(Pairs(300, 300)).values.back() > 30);  // pairs that count
}

TEST_CASE("symmetric planes: every set of instructions gives the same bits") {
  const Pairs pairs(301, 4);
  const SymmetricSums plain = pairs.sums(Instructions::baseline);
  for (const auto instructions : {Instructions::avx2, Instructions::avx512}) {
    if (instructions > widest_instructions()) continue;
    const SymmetricSums wide = pairs.sums(instructions);
    for (std::size_t v = 0; v < plain.values.size(); ++v)
      CHECK(std::bit_cast<std::uint64_t>(plain.values[v]) == std::bit_cast<std::uint64_t>(wide.values[v]));
  }
}
