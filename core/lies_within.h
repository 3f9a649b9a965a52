/// Whether a file that another file names is one of its company.
#pragma once

#include "core/files.h"

namespace partscribe::core {

/// Whether `file` lies in `folder` or below it, wherever symbolic links lead, and no part of its path from there on
/// begins with a dot. Names in the files of strangers must not reach what else their reader owns.
bool lies_within(const Path& file, const Path& folder);

}  // namespace partscribe::core
