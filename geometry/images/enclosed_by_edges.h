/// Step edges of a range image linked to closed lines, and which pixels they part from its margin.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/images/deriche.h"

namespace partscribe::geometry {

struct EdgeLinkOptions {
  /// Pixels; a gap up to this long is bridged. Larger closes where the operator saw nothing, in narrow slots for
  /// example, and joins what does not belong together.
  int reach = 16;
  double most_turn = 0.5;  ///< rad; a bridge goes on as the edge ends, so that it follows a slot and does not cross it
  int run = 6;             ///< pixels of an edge that tell where it leads; shorter ones are not continued
};

/// 1: a step, or a bridge from the end of a run of steps along its direction to the nearest step ahead. Bridges hold a
/// flood that goes from a pixel to its four neighbours.
std::vector<std::uint8_t> linked_steps(const std::vector<RangeEdge>& edges, int width, int height,
                                       const EdgeLinkOptions& options);

/// 1: outside, what a flood from the margin of the image reaches between linked steps. A pixel of a step or bridge that
/// the flood touches is outside if its depth is closer to those outside than to those inside within three pixels of it.
/// `depth`: one value per pixel, NaN where there is none.
std::vector<std::uint8_t> outside_of_edges(const std::vector<RangeEdge>& edges, const std::vector<double>& depth,
                                           int width, int height, const EdgeLinkOptions& options);

}  // namespace partscribe::geometry
