#include "model/shapes.h"

#include "core/ensure.h"

namespace partscribe::model {
namespace {

// ---- evaluation: the same walk over the source and over the result --------------------------------------------

/// The type that a field has in a shape of expressions when it is T in a shape of doubles.
template <class T>
struct InExpr {
  using type = T;
};
template <>
struct InExpr<double> {
  using type = Expr;
};
template <>
struct InExpr<std::vector<std::array<double, 2>>> {
  using type = std::vector<std::array<Expr, 2>>;
};
template <>
struct InExpr<std::vector<HalfSpaceOf<double>>> {
  using type = std::vector<HalfSpaceOf<Expr>>;
};
template <>
struct InExpr<std::vector<LoopOf<double>>> {
  using type = std::vector<LoopOf<Expr>>;
};
template <>
struct InExpr<std::vector<SketchElementOf<double>>> {
  using type = std::vector<SketchElementOf<Expr>>;
};
template <>
struct InExpr<SketchOf<double>> {
  using type = SketchOf<Expr>;
};

template <class To, class From>
void convert(const From& from, To& to, const Values& values);

template <class T>
void convert_field(const T& from, T& to, const Values&) {
  to = from;
}
void convert_field(const Expr& from, double& to, const Values& values) { to = evaluate(from, values); }
void convert_field(const SketchOf<Expr>& from, SketchOf<double>& to, const Values& values) {
  convert(from, to, values);
}
void convert_field(const std::vector<std::array<Expr, 2>>& from, std::vector<std::array<double, 2>>& to,
                   const Values& values) {
  for (const auto& p : from) to.push_back({evaluate(p[0], values), evaluate(p[1], values)});
}
void convert_field(const std::vector<HalfSpaceOf<Expr>>& from, std::vector<HalfSpaceOf<double>>& to,
                   const Values& values) {
  for (const auto& p : from) convert(p, to.emplace_back(), values);
}
void convert_field(const std::vector<LoopOf<Expr>>& from, std::vector<LoopOf<double>>& to, const Values& values) {
  for (const auto& p : from) convert(p, to.emplace_back(), values);
}
void convert_field(const std::vector<SketchElementOf<Expr>>& from, std::vector<SketchElementOf<double>>& to,
                   const Values& values) {
  for (const auto& element : from)
    std::visit(
        [&]<template <class> class E>(const E<Expr>& e) {
          E<double> result;
          convert(e, result, values);
          to.push_back(std::move(result));
        },
        element);
}

template <class To, class From>
void convert(const From& from, To& to, const Values& values) {
  std::vector<const void*> sources;
  From::fields(from, [&](const char*, const auto& field, auto&&...) { sources.push_back(&field); });
  std::size_t next = 0;
  To::fields(to, [&]<class T>(const char*, T& field, auto&&...) {
    convert_field(*static_cast<const typename InExpr<T>::type*>(sources[next++]), field, values);
  });
}

// ---- walking all expressions ------------------------------------------------------------------------------------

template <class S, class Visit>
void walk(S& shape, const Visit& visit);

template <class E, class Visit>
void walk_field(E& field, Domain domain, const Visit& visit) {
  visit(field, domain);
}

template <class Field, class Visit>
void walk_structured(Field& field, const Visit& visit) {
  using Plain = std::remove_const_t<Field>;
  if constexpr (std::is_same_v<Plain, Sketch>) {
    walk(field, visit);
  } else if constexpr (std::is_same_v<Plain, std::vector<Loop>> || std::is_same_v<Plain, std::vector<HalfSpace>>) {
    for (auto& item : field) walk(item, visit);
  } else if constexpr (std::is_same_v<Plain, std::vector<SketchElement>>) {
    for (auto& item : field) std::visit([&](auto& element) { walk(element, visit); }, item);
  } else if constexpr (std::is_same_v<Plain, std::vector<std::array<Expr, 2>>>) {
    for (auto& item : field)
      for (auto& e : item) visit(e, Domain::coordinate);
  }
}

template <class S, class Visit>
void walk(S& shape, const Visit& visit) {
  std::remove_const_t<S>::fields(shape, [&](const char*, auto& field, auto&&... rest) {
    if constexpr (sizeof...(rest) > 1) {
      const auto domain = std::get<0>(std::forward_as_tuple(rest...));
      walk_field(field, domain, visit);
    } else {
      walk_structured(field, visit);
    }
  });
}

}  // namespace

bool is_sheet(const Shape& shape) {
  if (const auto* triangles = std::get_if<TriSurface>(&shape)) return !triangles->closed;
  if (const auto* surfaces = std::get_if<SurfaceSet>(&shape)) return !surfaces->closed;
  return false;
}

EvaluatedShape evaluate(const Shape& shape, const Values& values) {
  return std::visit(
      [&]<template <class> class S>(const S<Expr>& s) -> EvaluatedShape {
        S<double> result;
        convert(s, result, values);
        return result;
      },
      shape);
}

EvaluatedSketch evaluate(const Sketch& sketch, const Values& values) {
  EvaluatedSketch result;
  convert(sketch, result, values);
  return result;
}

void visit_expressions(Shape& shape, const std::function<void(Expr&, Domain)>& visit) {
  std::visit([&](auto& s) { walk(s, visit); }, shape);
}

void visit_expressions(const Shape& shape, const std::function<void(const Expr&, Domain)>& visit) {
  std::visit([&](const auto& s) { walk(s, visit); }, shape);
}

}  // namespace partscribe::model
