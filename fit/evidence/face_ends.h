/// What the ends of scanned plane faces say for one body against another.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

/// Nats by which `a` explains where scanned plane faces end better than `b` does. Where a body goes on and the points
/// of its face do not, there is a shadow, whose outline could run anywhere: it has to be told place by place, once for
/// every two or three points along it. A body that ends there needs no shadow. Where points go on beyond its end that
/// body is wrong; where they stop before, its end may be anywhere. Asked of the flat faces of boxes and wedges and of
/// the ends of extrusions; 0 where most of the ends in question were not seen.
double face_ends_told(const Candidate& a, const Candidate& b, const FitInput& input);

}  // namespace partscribe::fit
