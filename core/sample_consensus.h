/// Random sample consensus (Fischler and Bolles 1981): of many hypotheses made from a few samples each, the one that
/// the most samples support.
#pragma once

#include <optional>
#include <utility>

#include "core/random.h"

namespace partscribe::core {

template <class Hypothesis>
struct Consensus {
  Hypothesis hypothesis;
  double support = 0;
};

/// Draws so many times; nothing if no hypothesis has more support than `least`, and of equal ones the first.
///
/// `draw(offer)` draws samples and calls `offer(hypothesis)` for what they make: once, several times or not at all.
/// `support(hypothesis, most)` says how many samples support it; what cannot exceed `most` may be cut short.
template <class Hypothesis, class Draw, class Support>
std::optional<Consensus<Hypothesis>> consensus(int draws, double least, Draw draw, Support support) {
  std::optional<Consensus<Hypothesis>> best;
  double most = least;
  for (int k = 0; k < draws; ++k)
    draw([&](Hypothesis hypothesis) {
      const double found = support(std::as_const(hypothesis), most);
      if (found > most) most = found, best = {std::move(hypothesis), found};
    });
  return best;
}

/// One of them.
template <class Samples>
const auto& drawn_from(const Samples& samples, Random& random) {
  return samples[random.below(samples.size())];
}

}  // namespace partscribe::core
