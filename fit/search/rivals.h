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

/// For a rival that was refused because it is off by more than the tolerance at some place, in a scan with many
/// outliers: the place may be a cluster of outliers, and a shape that fits the cluster costs more everywhere else. Says
/// so if the rival costs less in all; else empty.
std::string off_where_outliers_are(const CandidateEvidence& winner, const CandidateEvidence& rival,
                                   const FitInput& input);

/// Says so if a shorter rival may be the truth because the points that it does not explain and the winner does may be
/// outliers: they are few compared with those that were set aside, and without them the rival is hardly less likely.
/// Else empty.
std::string leaves_out_outliers(const CandidateEvidence& winner, const CandidateEvidence& rival, const FitInput& input);

/// For a rival of another procedure within the tolerance. The cheaper of the two is not certain if the difference is
/// smaller than a choice between kinds requires with many outliers, which a body of another kind can fit everywhere on
/// its surface (far_more_likely), or smaller than 20 nats where even the winner's residuals are twice the noise or
/// more; such nats are scaled down by how much larger than noise the residuals are. Says so; empty where it is decided.
std::string hardly_told_apart(const CandidateEvidence& winner, const CandidateEvidence& rival, const FitInput& input);

/// All radii of a ball, ellipsoid, cylinder or cone, some of which may be plain numbers; none of any other shape.
std::vector<Expr> radii_of(const Shape& shape);

/// Why a refined ball, ellipsoid or cylinder is none, whatever it follows: the data do not fix one of its radii to
/// within itself ("its radius 230 +- 4800 mm is not known"). A cone may end in a tip. Else empty.
std::string unknown_radius(const Candidate& refined);

/// Why a refined extrusion is none, whatever it follows: a wall between two parallel sides of its outline may as well
/// be of no thickness
/// ("a wall of 0.9 +- 1.1 mm may be none"), although points depend on it. Such a wall is the noise of one face, or
/// outliers beside it; for a side that was not seen, its large sigma says so. Else empty.
std::string unknown_wall(const Candidate& refined);

/// Twelve of the rivals, in their order: those that may be the truth ("cannot tell", "fits as well") before all others,
/// and of these one of each procedure before a second.
std::vector<Rival> worth_naming(std::vector<Rival> all);

/// A sentence such as "the data cannot tell it from 29 degrees of a cylinder of radius 43.1 +- 0.9 mm", where a body of
/// flat faces won although nearly all points lie on one sheet that bends by more than three sigmas; empty otherwise.
std::string bent_sheet(const Candidate& winner, const FitInput& input);

/// Says so if a few plane faces contain nearly all points and the ends of these faces were not scanned, so that any
/// convex polyhedron with such faces may be the truth; else empty. For a superellipsoid or supertoroid, which are used
/// only where no other procedure fits. With many outliers also for a winner with plane faces, of `cost` nats, if there
/// are only one to three faces, and three cost less alone or are all perpendicular to one plane, so that nothing closes
/// the body along it; and for a cylinder, cone or wedge that is not clearly cheaper than the faces (far_more_likely).
std::string open_polyhedron(const Candidate& winner, double cost, const FitInput& input, Context& context);

}  // namespace partscribe::fit
