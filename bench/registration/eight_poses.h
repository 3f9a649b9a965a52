/// The registration experiment of 1993: parts in eight poses, one view after the other.
#pragma once

#include <string>
#include <vector>

namespace partscribe::testing {

/// A table of what becomes of a polyhedron and of a sculpture, by planar patches and by triangles, from several
/// guesses; each of `seeds` is a scan of eight views.
void eight_poses_of_1993(const std::vector<std::string>& seeds);

}  // namespace partscribe::testing
