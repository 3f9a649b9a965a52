/// Changes of a whole model and of its parts; for the .cpp files behind mutate.h only.
#pragma once

#include <string>
#include <vector>

#include "verify/mutate/mutate.h"

namespace partscribe::verify {

/// A changed model and what was done to it.
struct Edit {
  Mutation::Kind kind;
  std::string name;
  Model model;
};

std::string quoted(const std::string& text);

/// The frame with the values of a rigid motion, and a motion that only shifts.
Frame frame_of(const Pose& pose);
Pose shift(const Vec3& by);

/// True for unions, differences and intersections.
bool combines(const Shape& shape);
/// The sketch of an extrusion or a revolve; nothing for other shapes.
Sketch* sketch_of(Shape& shape);
const Sketch* sketch_of(const Shape& shape);
/// The names that a combination refers to; nothing for other shapes.
std::vector<std::string>* operands_of(Shape& shape);
const std::vector<std::string>* operands_of(const Shape& shape);

/// The surfaces of a set, or the swept one; none for other shapes.
std::vector<TrimmedPatch*> patches_of(Shape& shape);
std::vector<const TrimmedPatch*> patches_of(const Shape& shape);

/// Mirrored in the part's frame, at `middle` along `axis`.
Model mirrored(const Model& model, int axis, const Vec3& middle);

/// Scaled in the part's frame about `middle`.
Model scaled(const Model& model, double factor, const Vec3& middle);

/// Everything that can be left out: loops, elements of sketches, faces, operands. Not checked.
std::vector<Edit> omissions(const Model& model);

}  // namespace partscribe::verify
