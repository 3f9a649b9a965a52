/// Memory of C++ as numpy arrays: read-only, never copied, alive as long as an array needs it.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <vector>

#include "geometry/mesh/triangle_mesh.h"

namespace partscribe::python {

namespace py = pybind11;

/// One number for each item; `owner` holds the vector and does not change it. None if the vector is empty.
template <class T>
py::object array_of(const std::vector<T>& values, py::handle owner);

/// N x 3; None if there are no points.
py::object array_of(const std::vector<geometry::Vec3>& points, py::handle owner);

/// M x 3 indices; None if there are no triangles.
py::object array_of(const std::vector<std::array<std::uint32_t, 3>>& triangles, py::handle owner);

/// Of zeros and ones.
py::object truths_of(const std::vector<std::uint8_t>& values, py::handle owner);

}  // namespace partscribe::python
