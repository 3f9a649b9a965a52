/// Unions in any order give the same roots and sizes.
#include "core/disjoint_sets.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/random.h"

using namespace partscribe::core;

TEST_CASE("disjoint sets: the root is the least member and the size counts the members") {
  DisjointSets sets(6);
  CHECK(sets.unite(5, 3));
  CHECK(sets.unite(3, 4));
  CHECK_FALSE(sets.unite(4, 5));
  CHECK(sets.root(5) == 3);
  CHECK(sets.size(4) == 3);
  CHECK(sets.root(0) == 0);
  CHECK(sets.size(0) == 1);
  const auto added = sets.add();
  CHECK(added == 6);
  CHECK(sets.unite(added, 1));
  CHECK(sets.root(6) == 1);
}

TEST_CASE("disjoint sets: random unions agree with labels that are painted over") {
  Random random(11);
  constexpr std::uint32_t count = 200;
  DisjointSets sets(count);
  std::vector<std::uint32_t> label(count);
  for (std::uint32_t i = 0; i < count; ++i) label[i] = i;
  for (int step = 0; step < 180; ++step) {
    const auto a = static_cast<std::uint32_t>(random.uniform(0, count)),
               b = static_cast<std::uint32_t>(random.uniform(0, count));
    CHECK(sets.unite(a, b) == (label[a] != label[b]));
    const std::uint32_t low = std::min(label[a], label[b]), high = std::max(label[a], label[b]);
    for (auto& l : label)
      if (l == high) l = low;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    CHECK(sets.root(i) == label[i]);
    CHECK(sets.size(i) == std::count(label.begin(), label.end(), label[i]));
  }
}

TEST_CASE("disjoint sets: numbers count the sets in the order of their least members") {
  DisjointSets sets(6);
  sets.unite(5, 1), sets.unite(4, 3);
  CHECK(sets.numbers() == std::vector<std::uint32_t>{0, 1, 2, 3, 3, 1});
  CHECK(DisjointSets().numbers().empty());
}
