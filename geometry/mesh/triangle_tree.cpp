#include "geometry/mesh/triangle_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/ensure.h"
#include "core/parallel.h"

namespace partscribe::geometry {
namespace {

constexpr std::size_t few = 48;           // triangles that are sorted into fewer bins
constexpr std::size_t many = 1024;        // triangles of which not all are sorted into bins
constexpr int sah_depth = 48;             // below it splits are by count, so that the stack of a search is bounded
constexpr std::size_t least_task = 8192;  // triangles; smaller subtrees are not worth a task of their own

// Four floats of which the last one is not used; compilers turn these loops into single instructions.
struct alignas(16) Float4 {
  float v[4];
};
inline Float4 least(const Float4& a, const Float4& b) {
  Float4 r;
  for (int k = 0; k < 4; ++k) r.v[k] = a.v[k] < b.v[k] ? a.v[k] : b.v[k];
  return r;
}
inline Float4 most(const Float4& a, const Float4& b) {
  Float4 r;
  for (int k = 0; k < 4; ++k) r.v[k] = a.v[k] > b.v[k] ? a.v[k] : b.v[k];
  return r;
}

struct Box {
  Float4 low{{INFINITY, INFINITY, INFINITY, INFINITY}}, high{{-INFINITY, -INFINITY, -INFINITY, -INFINITY}};
  void add(const Float4& l, const Float4& h) { low = least(low, l), high = most(high, h); }
  float half_area() const {
    const float x = high.v[0] - low.v[0], y = high.v[1] - low.v[1], z = high.v[2] - low.v[2];
    return x >= 0 ? x * y + y * z + z * x : 0;
  }
};

/// A triangle's box; its index rides in the unused lane.
struct Item {
  Float4 low, high;
  std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(low.v[3]); }
  float twice_center(int axis) const { return low.v[axis] + high.v[axis]; }
};

// A step of more than one unit in the last place outward from the rounded value.
float rounded_down(double v) {
  const float f = static_cast<float>(v);
  return f - std::abs(f) * 1.2e-7f - 1e-37f;
}
float rounded_up(double v) {
  const float f = static_cast<float>(v);
  return f + std::abs(f) * 1.2e-7f + 1e-37f;
}

bool lexicographically_less(const Vec3& a, const Vec3& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  if (a.y() != b.y()) return a.y() < b.y();
  return a.z() < b.z();
}

struct Range {
  std::size_t begin = 0, end = 0;
  Box box, centers;  // centers: twice their coordinates
  int depth = 0;     // of binary splits
  std::size_t size() const { return end - begin; }
};

class Builder {
 public:
  Builder(const TriangleMesh& mesh, int threads, Instructions instructions)
      : mesh_(mesh), threads_(threads), leaf_size_(leaf_size(mesh.triangles.size(), instructions)) {}

  TriangleTree build() {
    const std::size_t count = mesh_.triangles.size();
    if (count == 0) return std::move(tree_);
    ensure(count <= TriangleTree::most_triangles, "a mesh of more than 268 million triangles");
    make_items();
    Range all = measured(0, count);
    // The upper levels first; what hangs below them is built by tasks, whose nodes are then put in a row.
    const std::size_t task_size = std::max(least_task, count / 64);
    Part top;
    grow(all, top, task_size);
    // More than most meshes need; what is not written to costs nothing.
    tree_.nodes.reserve(top.nodes.size() + count / 16);
    tree_.leaves.reserve((leaf_size_ < TriangleTree::width ? 3 * count / 2 : count) + spare);
    append(top);
    auto hang = [&](const Task& task, const Part& part) {
      tree_.nodes[task.node].child[task.lane] = static_cast<std::uint32_t>(tree_.nodes.size());
      append(part);
    };
    if (threads_ == 1) {
      Part part;  // stays in the cache
      for (const Task& task : tasks_) {
        part.nodes.clear(), part.leaves.clear();
        grow(task.range, part, 0);
        hang(task, part);
      }
    } else {
      std::vector<Part> parts(tasks_.size());
      parallel_for(
          tasks_.size(), threads_,
          [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) grow(tasks_[i].range, parts[i], 0);
          },
          1);
      for (std::size_t i = 0; i < parts.size(); ++i) {
        hang(tasks_[i], parts[i]);
        parts[i] = {};
      }
    }
    tree_.leaves.resize(tree_.leaves.size() + spare);
    ensure(tree_.leaves.size() < TriangleTree::leaf_bit, "the leaves of a mesh take more than 137 GB");
    return std::move(tree_);
  }

 private:
  static constexpr std::size_t spare = 8;  // behind the last leaf: whole vectors are loaded

  /// Most triangles of a leaf. Where a vector holds fewer than eight numbers a leaf of eight takes two passes: a second
  /// one that is not near is spared by a box of its own, which pays as long as the tree lies in the cache.
  static std::size_t leaf_size(std::size_t triangles, Instructions instructions) {
    constexpr std::size_t in_cache = 200000;
    return instructions == Instructions::avx512 || triangles > in_cache ? TriangleTree::width : TriangleTree::width / 2;
  }

  struct Part {
    std::vector<TriangleTree::Node> nodes;
    std::vector<TriangleTree::Leaf> leaves;
  };
  struct Task {
    Range range;
    std::uint32_t node;
    int lane;
  };

  const TriangleMesh& mesh_;
  int threads_;
  std::size_t leaf_size_;
  TriangleTree tree_;
  std::vector<Item> items_;
  std::vector<Task> tasks_;

  /// References within a part count from its own beginning.
  void append(const Part& part) {
    const auto first_node = static_cast<std::uint32_t>(tree_.nodes.size()),
               first_unit = static_cast<std::uint32_t>(tree_.leaves.size());
    for (auto node : part.nodes) {
      for (std::uint32_t lane = 0; lane < node.children; ++lane)
        node.child[lane] += TriangleTree::is_leaf(node.child[lane]) ? first_unit : first_node;
      tree_.nodes.push_back(node);
    }
    tree_.leaves.insert(tree_.leaves.end(), part.leaves.begin(), part.leaves.end());
  }

  void make_items() {
    const Box3 bounds = mesh_.bounds();
    tree_.origin = bounds.center();
    // Slack for the rounding of differences: a box must never seem farther than a triangle in it.
    const double margin = 1e-12 * (bounds.low.cwiseAbs().maxCoeff() + bounds.high.cwiseAbs().maxCoeff());
    items_.resize(mesh_.triangles.size());
    parallel_for(
        items_.size(), threads_,
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t t = begin; t < end; ++t) {
            const auto& corner = mesh_.triangles[t];
            const Vec3 &a = mesh_.vertices[corner[0]], &b = mesh_.vertices[corner[1]], &c = mesh_.vertices[corner[2]];
            Item& item = items_[t];
            for (int k = 0; k < 3; ++k) {
              item.low.v[k] = rounded_down(std::min(std::min(a[k], b[k]), c[k]) - tree_.origin[k] - margin);
              item.high.v[k] = rounded_up(std::max(std::max(a[k], b[k]), c[k]) - tree_.origin[k] + margin);
            }
            item.low.v[3] = std::bit_cast<float>(static_cast<std::uint32_t>(t)), item.high.v[3] = 0;
          }
        },
        1 << 16);
  }

  Range measured(std::size_t begin, std::size_t end) const {
    Range range;
    range.begin = begin, range.end = end;
    for (std::size_t i = begin; i < end; ++i) {
      const Item& item = items_[i];
      Float4 center;
      for (int k = 0; k < 4; ++k) center.v[k] = item.low.v[k] + item.high.v[k];
      range.box.add(item.low, item.high), range.centers.add(center, center);
    }
    return range;
  }

  /// Fills `into` with the subtree of `range`; children of at least `task_size` are grown too, smaller ones become
  /// tasks (0: everything is grown). Returns its node.
  std::uint32_t grow(const Range& range, Part& into, std::size_t task_size) {
    std::array<Range, TriangleTree::width> child;
    int children = 1;
    child[0] = range;
    // Split the child with the largest surface until there are eight; rather a small one, which else becomes a node of
    // few leaves.
    while (children < TriangleTree::width) {
      int widest = -1;
      float most = -1;
      for (int i = 0; i < children; ++i) {
        const std::size_t leaves = (child[i].size() + leaf_size_ - 1) / leaf_size_;
        const float worth = child[i].box.half_area() * (leaves <= 2 ? 4.0f : leaves == 3 ? 2.0f : 1.0f);
        if (leaves > 1 && worth > most) widest = i, most = worth;
      }
      if (widest < 0) break;
      const Range parent = child[widest];
      if (parent.size() < few)
        split<6>(parent, child[widest], child[children++]);
      else
        split<16>(parent, child[widest], child[children++]);
    }
    const auto index = static_cast<std::uint32_t>(into.nodes.size());
    into.nodes.emplace_back();
    TriangleTree::Node node{};
    node.children = static_cast<std::uint32_t>(children);
    for (int lane = 0; lane < TriangleTree::width; ++lane)
      for (int k = 0; k < 3; ++k) {
        node.low[k][lane] = lane < children ? child[lane].box.low.v[k] : INFINITY;
        node.high[k][lane] = lane < children ? child[lane].box.high.v[k] : -INFINITY;
      }
    for (int lane = 0; lane < children; ++lane) {
      const Range& part = child[lane];
      if (part.size() <= leaf_size_) {
        node.child[lane] = make_leaf(part, into.leaves);
      } else if (part.size() < task_size) {
        tasks_.push_back({part, index, lane});
      } else {
        node.child[lane] = grow(part, into, task_size);
      }
    }
    into.nodes[index] = node;
    return index;
  }

  /// Cuts a range in two by the surface area heuristic on binned centres.
  template <int bins>
  void split(const Range& range, Range& left, Range& right) {
    std::size_t middle = range.begin;
    Range part[2];
    if (range.depth < sah_depth) {
      int best_axis = -1, best_bin = 0;
      float scale[3], extent[3];
      for (int k = 0; k < 3; ++k) extent[k] = range.centers.high.v[k] - range.centers.low.v[k];
      const float widest = std::max({extent[0], extent[1], extent[2]});
      // Across a patch's thin side a cut gains nothing.
      int axes[3], axis_count = 0;
      for (int k = 0; k < 3; ++k) {
        scale[k] = extent[k] > 0 && extent[k] >= 0.3f * widest ? bins * (1 - 1e-6f) / extent[k] : 0;
        if (!std::isfinite(scale[k])) scale[k] = 0;
        if (scale[k] > 0) axes[axis_count++] = k;
      }
      Box boxes[3][bins];
      std::uint32_t counts[3][bins] = {};
      // Of very many, some tell where to cut.
      const std::size_t step = range.size() < many ? 1 : range.size() < 8 * many ? 4 : 16;
      const auto total = static_cast<std::uint32_t>((range.size() + step - 1) / step);
      for (std::size_t i = range.begin; i < range.end; i += step) {
        const Item& item = items_[i];
        for (int n = 0; n < axis_count; ++n) {
          const int axis = axes[n];
          const int b = bin_of<bins>(item, axis, range.centers.low.v[axis], scale[axis]);
          ++counts[axis][b];
          boxes[axis][b].add(item.low, item.high);
        }
      }
      float best_cost = INFINITY;
      for (int n = 0; n < axis_count; ++n) {
        const int axis = axes[n];
        float right_cost[bins];
        Box box;
        std::uint32_t count = 0;
        for (int b = bins - 1; b > 0; --b) {
          box.add(boxes[axis][b].low, boxes[axis][b].high);
          count += counts[axis][b];
          right_cost[b] = box.half_area() * static_cast<float>(count);
        }
        box = {}, count = 0;
        for (int b = 0; b + 1 < bins; ++b) {
          box.add(boxes[axis][b].low, boxes[axis][b].high);
          count += counts[axis][b];
          if (count == 0 || count == total) continue;
          const float cost = box.half_area() * static_cast<float>(count) + right_cost[b + 1];
          if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = b;
        }
      }
      if (best_axis >= 0) {
        // Partition and measure both sides in one pass.
        std::size_t i = range.begin, j = range.end;
        auto measure = [](Range& side, const Item& item) {
          Float4 center;
          for (int k = 0; k < 4; ++k) center.v[k] = item.low.v[k] + item.high.v[k];
          side.box.add(item.low, item.high), side.centers.add(center, center);
        };
        while (i < j) {
          if (bin_of<bins>(items_[i], best_axis, range.centers.low.v[best_axis], scale[best_axis]) <= best_bin) {
            measure(part[0], items_[i++]);
          } else {
            std::swap(items_[i], items_[--j]);
            measure(part[1], items_[j]);
          }
        }
        middle = i;
      }
    }
    if (middle == range.begin || middle == range.end) {
      middle = range.begin + range.size() / 2;
      part[0] = measured(range.begin, middle), part[1] = measured(middle, range.end);
    }
    part[0].begin = range.begin, part[0].end = part[1].begin = middle, part[1].end = range.end;
    part[0].depth = part[1].depth = range.depth + 1;
    left = part[0], right = part[1];
  }

  template <int bins>
  static int bin_of(const Item& item, int axis, float low, float scale) {
    return std::clamp(static_cast<int>((item.twice_center(axis) - low) * scale), 0, bins - 1);
  }

  std::uint32_t make_leaf(const Range& range, std::vector<TriangleTree::Leaf>& leaves) const {
    constexpr int width = TriangleTree::width;
    TriangleTree::Leaf head{};
    // Vertices by index first; what stands at the same place is one vertex even where a mesh is not welded.
    std::uint32_t known[3 * width];
    Vec3 place[3 * width];
    int indices = 0, vertices = 0;
    std::uint8_t vertex_of[3 * width];
    const int count = static_cast<int>(range.size());
    for (int i = 0; i < count; ++i) {
      const std::uint32_t t = items_[range.begin + std::size_t(i)].triangle();
      int at = i;
      for (; at > 0 && head.triangle[at - 1] > t; --at) head.triangle[at] = head.triangle[at - 1];
      head.triangle[at] = t;
    }
    for (int i = 0; i < count; ++i) {
      const std::uint32_t t = head.triangle[i];
      std::uint8_t c[3];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t index = mesh_.triangles[t][std::size_t(k)];
        int at = 0;
        while (at < indices && known[at] != index) ++at;
        if (at == indices) {
          known[indices] = index;
          place[vertices] = mesh_.vertices[index];
          int same = 0;
          while (std::memcmp(&place[same], &place[vertices], sizeof(Vec3)) != 0) ++same;
          vertex_of[indices++] = static_cast<std::uint8_t>(same);
          vertices += same == vertices;
        }
        c[k] = vertex_of[at];
      }
      auto sort = [&](std::uint8_t& a, std::uint8_t& b) {
        if (lexicographically_less(place[b], place[a])) std::swap(a, b);
      };
      sort(c[0], c[1]), sort(c[1], c[2]), sort(c[0], c[1]);
      for (int k = 0; k < 3; ++k) head.corner[k][i] = c[k];
    }
    for (int i = count; i < width; ++i) {
      head.triangle[i] = head.triangle[count - 1];
      for (auto& corner : head.corner) corner[i] = corner[count - 1];
    }
    head.count = static_cast<std::uint8_t>(count), head.vertices = static_cast<std::uint8_t>(vertices);
    const std::size_t first = leaves.size(),
                      units = (3 * sizeof(double) * std::size_t(vertices) + sizeof head - 1) / sizeof head;
    leaves.resize(first + 1 + units);
    leaves[first] = head;
    double coordinates[9 * width];
    for (int v = 0; v < vertices; ++v)
      for (int k = 0; k < 3; ++k) coordinates[k * vertices + v] = place[v][k];
    std::memcpy(static_cast<void*>(&leaves[first + 1]), coordinates, 3 * sizeof(double) * std::size_t(vertices));
    return TriangleTree::leaf_bit | static_cast<std::uint32_t>(first);
  }
};

}  // namespace

std::size_t TriangleTree::bytes() const { return nodes.size() * sizeof(Node) + leaves.size() * sizeof(Leaf); }

TriangleTree build_triangle_tree(const TriangleMesh& mesh, int threads, Instructions instructions) {
  return Builder(mesh, threads, instructions).build();
}

}  // namespace partscribe::geometry
