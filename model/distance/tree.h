/// Booleans of solids as one body: what is inside, and the nearest point of the surface that is left.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "model/distance/distance.h"
#include "model/distance/solids.h"

namespace partscribe::model {

struct ModelDistance::Tree {
  /// A solid where it stands.
  struct Leaf {
    std::shared_ptr<const Solid> solid;
    Pose leaf_from_part, part_from_leaf;
    Box3 bounds;         ///< in the part's frame
    int first_face = 0;  ///< of the solid's faces in the model's list
  };
  struct Node {
    enum class Operation { leaf, join, cut, common } operation = Operation::leaf;
    int leaf = -1;
    std::vector<Node> operands;
    Box3 bounds;  ///< holds what the node leaves, in the part's frame
  };

  /// What was built of which shape, by the object's name.
  struct Made {
    std::shared_ptr<const EvaluatedShape> shape;  ///< in trees
    std::shared_ptr<const Solid> solid;
  };

  Pose part_from_scan;
  std::map<std::string, Made> solids;
  std::vector<Leaf> leaves;
  Node root;
  double small = 1e-7;  ///< mm; surfaces nearer to each other touch

  struct Face {
    int leaf = 0, face = 0;
  };
  struct Bound {
    double distance = 0;
    Face face;
  };

  ModelHit nearest(const Vec3& p) const;
  Bound bound(const Node& node, const Vec3& p) const;

 private:
  struct Probe;
  bool holds(const Node& node, Probe& probe) const;
  bool inside(const Vec3& p) const;
  Foot foot(const Face& face, const Vec3& p) const;
  bool on_surface(const Vec3& q, const Vec3& normal, const Face* faces, int count) const;
  std::optional<Vec3> meeting_point(const Face* faces, int count, const Vec3& p, const Vec3& start) const;
  int face_id(const Face& face) const { return leaves[static_cast<std::size_t>(face.leaf)].first_face + face.face; }
};

}  // namespace partscribe::model
