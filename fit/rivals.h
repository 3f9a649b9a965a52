/// Says when the data cannot tell the procedure that won from a richer one.
#pragma once

#include <string>

#include "fit/candidate.h"

namespace partscribe {

/// A sentence such as "the data cannot tell it from a cone: half angle 0.4 +- 0.6 degrees", if the number by which the
/// rival differs from the winner is zero within two sigmas; empty otherwise. Knows cylinder and cone, sphere and
/// ellipsoid. The rival is refined on the way.
std::string told_apart_by(const Candidate& winner, Candidate rival, const FitInput& input, Context& context);

/// A sentence such as "the data cannot tell it from 29 degrees of a cylinder of radius 43.1 +- 0.9 mm", where a body of flat
/// faces won although nearly all points lie on one sheet that bends by more than three sigmas; empty otherwise.
std::string bent_sheet(const Candidate& winner, const FitInput& input);

/// What a convex polyhedron would say whose plane faces hold the points, if their end was not scanned; else empty. For a
/// superellipsoid or supertoroid, which serve where no procedure of the trade does; among strays also for a winner with plane
/// faces, of `cost` nats, where there are but two or three and they cost less alone.
std::string open_polyhedron(const Candidate& winner, double cost, const FitInput& input, Context& context);

}  // namespace partscribe
