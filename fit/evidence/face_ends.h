/// What the ends of scanned plane faces say for one body against another.
#pragma once

#include "fit/candidate.h"

namespace partscribe::fit {

/// Nats by which `a` explains the borders of scanned plane faces better than `b`. Where a body continues beyond the
/// points of its face, the rest of the face must have been in shadow. The outline of a shadow could run anywhere:
/// describing it costs nats for every two or three points along it. A body that ends where the points end needs no
/// shadow. A body is wrong if points continue beyond its end. Computed for the flat faces of boxes and wedges and the
/// ends of extrusions; 0 where most of these borders were not seen.
double face_ends_told(const Candidate& a, const Candidate& b, const FitInput& input);

}  // namespace partscribe::fit
