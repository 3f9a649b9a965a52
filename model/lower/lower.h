/// Says a model in terms of fewer kinds of shapes, exactly: features as solids, patterns as copies, mirror images as
/// solids, nested sketches as several. Whoever writes or measures models calls this first and then has to know
/// only the kinds it names.
#pragma once

#include <set>
#include <string_view>

#include "model/lower/solids.h"
#include "model/model.h"

namespace partscribe::model {

/// Kinds of shapes that are left as they are, beside the basic ones (box to tri_surface without fillet, and booleans).
/// Worked edges never are.
using Kinds = std::set<std::string_view>;

/// In place of a kind: sketches with islands are left as they are.
inline constexpr std::string_view islands = "islands";

/// The same part with the same parameters. Each object keeps its name; objects that it needs come before it, with names
/// that nobody else has. `feature` and `repeats` of every object say what it comes from. Counts are those of the
/// parameters' present values. Needs a model whose references are right (check()).
Model lowered(const Model& model, const Kinds& known);

/// The same with every expression replaced by its value.
Model lowered(const Model& model, const Values& values, const Kinds& known = {});

template <class S>
struct AsWritten;  // HoleOf<double>: Hole
template <template <class> class S, class N>
struct AsWritten<S<N>> {
  using type = S<Expr>;
};

/// True for the kinds that lowered() never replaces: no simpler solid says them, and they repeat or work no other
/// object.
template <class S>
constexpr bool is_basic = !SaidSimpler<typename AsWritten<S>::type> && !requires(S s) {
  s.object;
};

/// A shape that lowered() replaces: a visitor that runs after it needs one function for all of them.
template <class S>
concept LoweredAway = !is_basic<S>;

}  // namespace partscribe::model
