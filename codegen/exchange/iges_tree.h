/// A model's procedure as IGES solids: primitives, sweeps and boolean trees (entities 150-180).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/model.h"

class IGESData_IGESEntity;

namespace partscribe::codegen {

/// One object of the tree, to be named after the model's object.
struct IgesTreeNode {
  std::shared_ptr<IGESData_IGESEntity> entity;  ///< holds one of the writer's own counted references
  std::string name;
};

/// The nodes in the model's order, the last one the root; empty if some object that the part needs has no IGES
/// primitive (superellipsoids, half-spaces, triangulations). Placed as the artifacts are.
std::vector<IgesTreeNode> iges_tree(const Model& model);

}  // namespace partscribe::codegen
