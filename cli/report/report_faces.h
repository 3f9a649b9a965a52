/// The faces of the scan as a section of a report: picture, features, faces, relations.
#pragma once

#include <string>

#include "cli/measure/measured_part.h"
#include "cli/pictures/pictures.h"

namespace partscribe::cli {

ReportPicture picture_of_faces(const Scan& scan, const Faces& faces, Context& context);

/// HTML. `picture`: of the same faces. Long tables are cut, as in the terminal.
std::string faces_section(const MeasuredPart& part, const ReportPicture& picture);

}  // namespace partscribe::cli
