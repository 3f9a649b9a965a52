/// Mirror images of shapes.
#pragma once

#include <functional>
#include <string>

#include "model/model.h"

namespace partscribe::model {

/// A shape, and where it has to stand.
struct Placed {
  Shape shape;
  Frame frame;
};

/// The image of a shape behind the plane through its origin whose normal is axis 0, 1 or 2, said without a reflection:
/// a shape of the same kind, or the simpler solid that says it, turned and moved. Objects that it refers to have to be
/// reflected by the same plane, and `renamed` gives the names of those images. Worked edges are lowered before.
Placed reflected(const Shape& shape, int axis, const std::function<std::string(const std::string&)>& renamed);

/// The frame of an image: with the plane at `offset` along the axis, reflection * frame = result * (reflection in the
/// plane through the origin of the same normal).
Frame reflected(const Frame& frame, int axis, const Expr& offset);

}  // namespace partscribe::model
