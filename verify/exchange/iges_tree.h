/// Evaluates the constructive solid geometry of an IGES file: primitives, boolean trees, assemblies, instances.
#pragma once

#include <optional>
#include <string>

class IGESControl_Reader;
class TopoDS_Shape;

namespace partscribe::verify {

/// What became of the tree.
struct IgesTree {
  bool present = false;              ///< the file holds such entities at all
  std::optional<std::string> fault;  ///< why it could not be evaluated
};

/// Builds all trees of the file that nothing else refers to, in mm, into `shape`. OpenCASCADE reads these entities
/// but converts none of them.
IgesTree evaluate_iges_tree(IGESControl_Reader& reader, TopoDS_Shape& shape);

}  // namespace partscribe::verify
