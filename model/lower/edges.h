/// Rounded and chamfered edges as bodies that are cut away or added.
#pragma once

#include <string>
#include <variant>

#include "model/lower/reflect.h"
#include "model/model.h"

namespace partscribe::model {

/// What fills the corner at an edge, or has to be cut from it.
struct EdgeTool {
  Placed body;           ///< in the frame of the object whose edge it is
  bool removes = false;  ///< true: the edge is convex, the tool is cut away
};

/// Finds the edge in which two faces of an object meet, by their names as ModelDistance has them ("plate top", "hole
/// wall"), and the tool for it. Edges that can be told: between two planes along the axes of the object, and the full
/// circle between such a plane and a cylinder about its normal. Positions are expressions, so that the tool follows
/// when sizes are edited; which of several ends comes first, and whether the edge is convex, is taken from the present
/// values. Otherwise one line that says what is wrong. `model.objects` ends with the object; its shapes may be of any
/// kind.
std::variant<EdgeTool, std::string> edge_tool(const Model& model, const Values& values, const EdgeFillet& edge);
std::variant<EdgeTool, std::string> edge_tool(const Model& model, const Values& values, const EdgeChamfer& edge);

}  // namespace partscribe::model
