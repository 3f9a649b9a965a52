/// The faces of a part in colours of their own, each with its number, from four sides in one picture.
#pragma once

#include "cli/pictures/raster.h"
#include "core/context.h"
#include "geometry/points/point_cloud.h"
#include "geometry/segment/faces.h"

namespace partscribe::cli {

/// `faces` are those of the scan. Free form is grey, what belongs to no face dark; rejected points are left out. The
/// part stands along its largest faces, upright as the scan's z axis has it.
Raster draw_faces(const Scan& scan, const Faces& faces, Context& context);

/// The colour of a face, before any light.
Color face_color(const Faces& faces, std::size_t face);

}  // namespace partscribe::cli
