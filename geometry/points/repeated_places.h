/// Points that are no surface because a file repeats one place exactly: missing returns written as zeros, and the like.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vec.h"

namespace partscribe::geometry {

/// What of a cloud says nothing. A scanned surface hits no place twice but by the coarseness of its numbers, and then
/// it repeats most places about as often.
struct RepeatedPlaces {
  std::vector<std::uint8_t> kept;  ///< of each point; empty if all are
  std::size_t zeros = 0;           ///< points exactly at 0 0 0 that are left out: no sensor measures where it stands
  std::size_t places = 0;          ///< other places, repeated far more often than is usual in the cloud ...
  std::size_t copies = 0;          ///< ... and the points left out there, all but one of each
};

/// All points are finite. Zeros are left out if they are repeated more often than any usual place (one, then, stays),
/// and from the `image` of a sensor in any case.
RepeatedPlaces repeated_places(const std::vector<Vec3>& points, bool image);

}  // namespace partscribe::geometry
