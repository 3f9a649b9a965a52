/// What the process that reads STEP and IGES hands back to the one that asked: numbers as they lie in memory, for both
/// ends are one program.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "verify/exchange/read_brep.h"

namespace partscribe::verify {

std::string to_bytes(const Result<BrepReading>& result);

/// Nothing if they are not whole, or say what no reading holds: a hostile file may have taken over the process that
/// wrote them.
std::optional<Result<BrepReading>> from_bytes(std::string_view bytes);

}  // namespace partscribe::verify
