/// Several small files in one text, for doors that read a file and what it names.
#pragma once

#include <string_view>

#include "core/files.h"

namespace partscribe::testing {

using namespace core;

/// A folder that holds the files of a bundle while the object lives. Each begins with a line "--- name"; what stands
/// before the first such line, or under a name that is no plain file name, is left out.
class Bundle {
 public:
  explicit Bundle(std::string_view text);
  const Path& first() const { return first_; }  ///< path of the first file; empty if there is none

 private:
  TemporaryDirectory folder_;
  Path first_;
};

}  // namespace partscribe::testing
