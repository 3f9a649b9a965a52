#include "model/distance/distance.h"

#include <map>
#include <set>

#include "core/ensure.h"
#include "core/number.h"
#include "model/distance/tree.h"
#include "model/lower/lower.h"
#include "model/overloaded.h"

namespace partscribe::model {
namespace {

using Tree = ModelDistance::Tree;
using Operation = Tree::Node::Operation;

Box3 moved(const Box3& box, const Pose& pose) {
  Box3 result;
  if (box.empty()) return result;
  for (int c = 0; c < 8; ++c)
    result.add(pose * Vec3(c & 1 ? box.high.x() : box.low.x(), c & 2 ? box.high.y() : box.low.y(),
                           c & 4 ? box.high.z() : box.low.z()));
  return result;
}

/// Unfolds the objects of a lowered model into a tree whose leaves stand in the part's frame.
class Unfolding {
 public:
  /// Solids of `like` that have the same shape here are used again.
  Unfolding(const Model& lowered, Tree& tree, std::vector<ModelFace>& faces, const Tree* like)
      : model_(lowered), tree_(tree), faces_(faces), like_(like) {
    for (const Object& o : model_.objects) by_name_[o.name] = &o;
  }

  void run(bool single) {
    single_ = single;
    tree_.root = node(model_.objects.back(), Pose{}, "");
    tree_.small = std::max(1e-7, 1e-6 * tree_.root.bounds.diagonal());
  }

 private:
  /// `copy_of`: the outermost pattern that this object is part of a copy of.
  Tree::Node node(const Object& o, const Pose& outer, const std::string& copy_of) {
    const Pose part_from_object = outer * evaluate(o.frame, {});
    const std::string& repeats = copy_of.empty() ? o.repeats : copy_of;
    const EvaluatedShape shape = evaluate(o.shape, {});
    Tree::Node n;
    const auto [operation, names] = combined(shape);
    n.operation = operation;
    if (operation == Operation::leaf) leaf(n, o, shape, part_from_object, repeats);
    for (const auto& name : names) n.operands.push_back(node(*by_name_.at(name), part_from_object, repeats));
    // A union of one is that one; the fewer nodes, the faster.
    if (n.operands.size() == 1) return Tree::Node(std::move(n.operands[0]));
    bound(n);
    return n;
  }

  struct Combined {
    Operation operation = Operation::leaf;
    std::vector<std::string> names;
  };
  static Combined combined(const EvaluatedShape& shape) {
    return std::visit(Overloaded{[](const UnionOf<double>& s) {
                                   return Combined{Operation::join, s.objects};
                                 },
                                 [](const DifferenceOf<double>& s) {
                                   return Combined{Operation::cut, s.objects};
                                 },
                                 [](const IntersectionOf<double>& s) {
                                   return Combined{Operation::common, s.objects};
                                 },
                                 [](const auto&) { return Combined{}; }},
                      shape);
  }

  void leaf(Tree::Node& n, const Object& o, const EvaluatedShape& shape, const Pose& pose, const std::string& repeats) {
    Tree::Leaf leaf;
    const std::shared_ptr<const Solid> solid = solid_of(o.name, shape);
    leaf.solid = solid;
    leaf.part_from_leaf = pose, leaf.leaf_from_part = pose.inverse();
    leaf.bounds = moved(solid->bounds, pose);
    leaf.first_face = static_cast<int>(faces_.size());
    std::string feature = o.feature;
    if (!repeats.empty()) {
      feature = repeats + " " + print_number(++copies_[{repeats, o.feature}]);
      // A pattern of more than one body: whose face it is has to be said as well.
      const auto [first, made] = first_of_.emplace(repeats, o.feature);
      if (!made && first->second != o.feature) feature += " " + o.feature;
    }
    for (const auto& name : solid->faces) {
      const std::string base = single_ ? name : feature + " " + name;
      std::string full = base;
      for (int k = 2; !taken_.insert(full).second; ++k) full = base + " " + print_number(k);
      faces_.push_back({full, o.feature, feature});
    }
    n.leaf = static_cast<int>(tree_.leaves.size());
    tree_.leaves.push_back(std::move(leaf));
  }

  std::shared_ptr<const Solid> solid_of(const std::string& name, const EvaluatedShape& shape) {
    auto& made = tree_.solids[name];
    if (made.solid) return made.solid;
    if (like_) {
      const auto earlier = like_->solids.find(name);
      if (earlier != like_->solids.end() && earlier->second.shape && *earlier->second.shape == shape)
        return (made = earlier->second).solid;
    }
    made.solid = make_solid(shape);
    // Of a single object all is built anew, or nothing: its shape, maybe a million triangles, need not be known.
    if (!single_) made.shape = std::make_shared<EvaluatedShape>(shape);
    return made.solid;
  }

  void bound(Tree::Node& n) {
    if (n.operation == Operation::leaf) {
      n.bounds = tree_.leaves[static_cast<std::size_t>(n.leaf)].bounds;
      return;
    }
    n.bounds = n.operands[0].bounds;
    for (std::size_t i = 1; i < n.operands.size(); ++i) {
      const Box3& other = n.operands[i].bounds;
      if (n.operation == Operation::join)
        n.bounds.low = n.bounds.low.cwiseMin(other.low), n.bounds.high = n.bounds.high.cwiseMax(other.high);
      if (n.operation == Operation::common)
        n.bounds.low = n.bounds.low.cwiseMax(other.low), n.bounds.high = n.bounds.high.cwiseMin(other.high);
    }
  }

  const Model& model_;
  Tree& tree_;
  std::vector<ModelFace>& faces_;
  const Tree* like_;
  bool single_ = false;
  std::map<std::string, const Object*> by_name_;
  std::map<std::pair<std::string, std::string>, int> copies_;
  std::map<std::string, std::string> first_of_;
  std::set<std::string> taken_;
};

}  // namespace

ModelDistance::ModelDistance(const Model& model, const Values& values, const ModelDistance* like)
    : tree_(std::make_unique<Tree>()) {
  ensure(!model.objects.empty(), "a model has an object");
  const Model simple = lowered(model, with_formulas(model, values), {islands});
  Unfolding(simple, *tree_, faces_, like ? like->tree_.get() : nullptr).run(model.objects.size() == 1);
  if (model.as_scanned) tree_->part_from_scan = evaluate(simple.scan_from_part, {}).inverse();
}

ModelDistance::ModelDistance(const Model& model) : ModelDistance(model, values_of(model)) {}
ModelDistance::~ModelDistance() = default;
ModelDistance::ModelDistance(ModelDistance&&) noexcept = default;

ModelHit ModelDistance::operator()(const Vec3& point) const { return tree_->nearest(tree_->part_from_scan * point); }
double ModelDistance::bound(const Vec3& point) const {
  return tree_->bound(tree_->root, tree_->part_from_scan * point).distance;
}
const std::vector<ModelFace>& ModelDistance::faces() const { return faces_; }
Box3 ModelDistance::bounds() const { return moved(tree_->root.bounds, tree_->part_from_scan.inverse()); }

}  // namespace partscribe::model
