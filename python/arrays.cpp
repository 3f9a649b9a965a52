#include "python/arrays.h"

namespace partscribe::python {
namespace {

template <class T>
py::object view(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  if (shape.front() == 0) return py::none();
  py::array_t<T> array(std::move(shape), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

py::ssize_t length(std::size_t size) { return static_cast<py::ssize_t>(size); }

}  // namespace

template <class T>
py::object array_of(const std::vector<T>& values, py::handle owner) {
  return view(values.data(), {length(values.size())}, owner);
}
template py::object array_of(const std::vector<float>&, py::handle);
template py::object array_of(const std::vector<std::int32_t>&, py::handle);
template py::object array_of(const std::vector<std::uint32_t>&, py::handle);

py::object array_of(const std::vector<geometry::Vec3>& points, py::handle owner) {
  static_assert(sizeof(geometry::Vec3) == 3 * sizeof(double));
  return view(reinterpret_cast<const double*>(points.data()), {length(points.size()), 3}, owner);
}

py::object array_of(const std::vector<std::array<std::uint32_t, 3>>& triangles, py::handle owner) {
  return view(reinterpret_cast<const std::uint32_t*>(triangles.data()), {length(triangles.size()), 3}, owner);
}

py::object truths_of(const std::vector<std::uint8_t>& values, py::handle owner) {
  static_assert(sizeof(bool) == 1);
  return view(reinterpret_cast<const bool*>(values.data()), {length(values.size())}, owner);
}

}  // namespace partscribe::python
