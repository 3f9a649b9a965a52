/// Sets of the numbers 0, 1, 2, ..., alone at first, that are united step by step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/layers.h"

namespace partscribe::core {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count = 0) : parent_(count), size_(count, 1) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  /// The next number, in a set of its own.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    size_.push_back(1);
    return parent_.back();
  }

  /// The least member of the set of `i`, whatever the order of the unions.
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// False if the two are in one set already.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    if (a == b) return false;
    if (b < a) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
    return true;
  }

  /// Of each member the number of its set, which are counted in the order of their least members.
  std::vector<std::uint32_t> numbers() {
    std::vector<std::uint32_t> result(parent_.size());
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < result.size(); ++i) result[i] = root(i) == i ? count++ : result[root(i)];
    return result;
  }

  /// How many are in the set of `i`.
  std::uint32_t size(std::uint32_t i) { return size_[root(i)]; }

 private:
  std::vector<std::uint32_t> parent_, size_;  // the size counts at roots
};

}  // namespace partscribe::core
