/// Says when the data cannot tell the procedure that won from a richer one.
#pragma once

#include <string>
#include <vector>

#include "fit/candidate.h"
#include "fit/evidence/evidence.h"

namespace partscribe::fit {

/// A sentence such as "the data cannot tell it from a cone: half angle 0.4 +- 0.6 degrees", if the number by which the
/// rival differs from the winner is zero within two sigmas; empty otherwise. Knows cylinder and cone, sphere and
/// ellipsoid. The rival is refined on the way.
std::string told_apart_by(const Candidate& winner, Candidate rival, const FitInput& input, Context& context);

/// The kind that a refined cone or ellipsoid is as far as its sigmas tell, "cylinder" or "sphere": what sets it apart
/// is zero within two of them. Empty for anything else.
std::string simpler_kind(const Candidate& refined);

/// For a rival that was refused because it is off by more than the tolerance somewhere, among strays: a crowd of them
/// is off at one place, and what bends to it costs more everywhere else. Says so where the rival costs less in all;
/// else empty.
std::string off_where_strays_are(const CandidateEvidence& winner, const CandidateEvidence& rival,
                                 const FitInput& input);

/// What a shorter rival says for itself where the points that it leaves to chance and the winner does not may be strays
/// like those set aside: they are few beside these, and without them it is hardly less likely. Else empty.
std::string leaves_out_strays(const CandidateEvidence& winner, const CandidateEvidence& rival, const FitInput& input);

/// For a rival of another procedure within the tolerance: whichever of two costs less is not shown to be the part by
/// fewer nats than a choice between kinds takes among strays, where a body of another kind bends to them in all its
/// places (far_more_likely), nor by fewer than odds of 20 nats where even the winner is twice as far off as noise, or
/// more: residuals that noise does not explain count for as much less as they are larger. Says so; empty where it is
/// decided.
std::string hardly_told_apart(const CandidateEvidence& winner, const CandidateEvidence& rival, const FitInput& input);

/// All radii of a ball, ellipsoid, cylinder or cone, some of which may be plain numbers; none of any other shape.
std::vector<Expr> radii_of(const Shape& shape);

/// Why a refined ball, ellipsoid or cylinder is none, whatever it follows: the data do not fix one of its radii to
/// within itself ("its radius 230 +- 4800 mm is not known"). A cone may end in a tip. Else empty.
std::string unknown_radius(const Candidate& refined);

/// Why a refined extrusion is none, whatever it follows: a wall between two parallel sides of its outline may as well
/// be of no thickness
/// ("a wall of 0.9 +- 1.1 mm may be none"), although points speak about it. Such a wall is the band that noise makes of
/// a face, or strays beside one; of a side that was not seen the far sigma says so. Else empty.
std::string unknown_wall(const Candidate& refined);

/// Twelve of the rivals, in their order: those that may be the truth ("cannot tell", "fits as well") before all others,
/// and of these one of each procedure before a second.
std::vector<Rival> worth_naming(std::vector<Rival> all);

/// A sentence such as "the data cannot tell it from 29 degrees of a cylinder of radius 43.1 +- 0.9 mm", where a body of
/// flat faces won although nearly all points lie on one sheet that bends by more than three sigmas; empty otherwise.
std::string bent_sheet(const Candidate& winner, const FitInput& input);

/// What a convex polyhedron would say whose plane faces hold the points, if their end was not scanned; else empty. For
/// a superellipsoid or supertoroid, which serve where no procedure of the trade does; among strays also for a winner
/// with plane faces, of `cost` nats, where there are but one to three, and three cost less alone or are all across one
/// plane, so that nothing closes the body along it, and for a cylinder, cone or wedge that costs no less than they do
/// but for what strays may have done (far_more_likely): any body with such faces may be the truth.
std::string open_polyhedron(const Candidate& winner, double cost, const FitInput& input, Context& context);

}  // namespace partscribe::fit
