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

/// All radii of a ball, ellipsoid, cylinder or cone, some of which may be plain numbers; none of any other shape.
std::vector<Expr> radii_of(const Shape& shape);

/// Why a refined ball, ellipsoid or cylinder cannot be the answer, however well it fits: the data do not determine one
/// of its radii ("its radius 230 +- 4800 mm is not known"). Cones are exempt, because they may end in a tip. Empty
/// otherwise.
std::string unknown_radius(const Candidate& refined);

/// Why a refined extrusion cannot be the answer, however well it fits: a wall between two parallel sides of its outline
/// may have no thickness at all ("a wall of 0.9 +- 1.1 mm may be none"), although points depend on it. Such a wall is
/// the noise of one face, or outliers beside it. A side that was not seen is exempt: its large sigma already says so.
/// Empty otherwise.
std::string unknown_wall(const Candidate& refined);

/// Twelve of the rivals, in their order: those that may be the truth ("cannot tell", "fits as well") before all others,
/// and of these one of each procedure before a second.
std::vector<Rival> worth_naming(std::vector<Rival> all);

/// A sentence such as "the data cannot tell it from 29 degrees of a cylinder of radius 43.1 +- 0.9 mm", where a body of
/// flat faces won although nearly all points lie on one sheet that bends by more than three sigmas; empty otherwise.
std::string bent_sheet(const Candidate& winner, const FitInput& input);

/// A sentence if the data leave open how the body is closed: a few plane faces contain nearly all points and what lies
/// beyond them was not scanned, so that any convex polyhedron with such faces may be the truth. Empty otherwise. It is
/// said of
/// - a superellipsoid or supertoroid, which win only where no other procedure fits, if the scanned faces determine no
///   closed body;
/// - a box, wedge or extrusion in a scan with many outliers, if there are at most three faces. Three faces around a
///   corner end where the body ends, and count only if they alone cost less than the winner, whose `cost` is in nats
///   (for a wedge: not clearly more, told_apart). Three that are all perpendicular to one plane leave both ends of
///   the body open;
/// - a cylinder or cone in a scan with many outliers, if there are at most three faces and they alone cost less than
///   the winner or not clearly more.
std::string open_polyhedron(const Candidate& winner, double cost, const FitInput& input, Context& context);

}  // namespace partscribe::fit
