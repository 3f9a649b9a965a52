/// Outlines that many parts have, fitted whole: where walls were hidden, what was seen of the rest fixes their few
/// numbers.
#pragma once

#include <vector>

#include "fit/sketch/outline_cells.h"

namespace partscribe::fit {

/// Rectangle; rectangle with four equal rounds; slot, whose two ends are half circles; slot with equal holes about the
/// centres of its ends; L.
enum class OutlineForm { rectangle, rounded, slot, link, ell };

/// An outline in a frame turned by `angle`; mm.
struct CommonOutline {
  OutlineForm form = OutlineForm::rectangle;
  double angle = 0;                              ///< rad, of the frame's x
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();  ///< sides, in the frame
  Vec2 inner = Vec2::Zero();                     ///< ell: its inner corner; the corner at `high` is missing
  double round = 0;                              ///< rounded: radius of the corners
  double eye = 0;                                ///< link: radius of the holes
  double cost = 0;                               ///< of what was seen: the least is the likeliest

  double radius() const;                  ///< of corners or ends
  double area() const;                    ///< without the holes
  double distance(const Vec2& p) const;   ///< from the outline, positive outside; beside an inner corner a lower bound
  std::vector<Vec2> end_centres() const;  ///< of a slot or link
  LoopPieces loop() const;                ///< counter-clockwise, named "outline"
};

/// The best of each form, the likeliest first. Robust: wall points that are farther off than noise explains, or face
/// another way (for an L also inwards, if the sign of the normals is known), cost no more than outliers, and so do a
/// few points of the end faces outside the outline. Area that end faces do not fill costs a little, which pulls a side
/// whose wall was not seen to the end of the data.
std::vector<CommonOutline> common_outlines(const OutlineData& data);

}  // namespace partscribe::fit
