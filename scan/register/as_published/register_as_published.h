/// Registration as published in 1993: one view after the other against all that is registered, which it then joins.
///
/// Koivunen, Vezien, Bajcsy, MS-CIS-93-66. Each step of the paper is a function of this folder:
/// - 2.1.1, q, e(q), its least, displacements cumulated: state_vector.h
/// - 2.1.1, closest point on the closest primitive: primitives.h
/// - 2.1.2, visibility by the first estimate, the distribution of residuals, consistency of normals and the loop in
/// which
///   the displacement is recomputed: constraints.h
/// - 2.1.1 and 2.1.2, the iteration, its ends and its failure: constrained_icp.h
/// - 2.1.2 and 4, which points and primitives are taken: reference_points.h, primitives.h
/// - 2.1.2 and 5, the model grown view by view: here
#pragma once

#include <vector>

#include "scan/register/as_published/paper_options.h"
#include "scan/register/register_start.h"

namespace partscribe::scan {

/// The first usable view is the model to begin with, at its guess. The view that by its guess the model's part of it
/// fixes best comes next ("a contiguous viewpoint"), is registered from there and joins the model. A view whose
/// registration fails, or whose matched points leave a motion free, is tried again once the model has grown. If a
/// motion stays free to the end the view is placed all the same; if registration fails to the end it is not, with the
/// reason.
StartResult register_as_published(const std::vector<ViewSurface>& surfaces, const std::vector<Pose>& guesses,
                                  const PaperOptions& options, Context& context);

}  // namespace partscribe::scan
